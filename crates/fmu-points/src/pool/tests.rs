use std::sync::Arc;

use super::*;
use crate::failure::Failure;

/// Doubles its first value; fails where that is negative.
struct Doubling;

impl Worker for Doubling {
    fn run(&mut self, jobs: &[Job], post: &mut Post<'_>) -> Result<(), RunError> {
        for job in jobs {
            let value = job.values[0];
            let answer = if value < 0.0 { Err(Failure::Timeout) } else { Ok(vec![2.0 * value].into()) };
            post.send(Event::Answer(job.index, answer, Separation::Used));
            if post.is_over() {
                break;
            }
        }
        Ok(())
    }
}

fn workers(count: usize) -> Vec<Box<dyn Worker>> {
    (0..count).map(|_| Box::new(Doubling) as Box<dyn Worker>).collect()
}

fn job(index: u64) -> Job {
    Job { index, values: vec![index as f64 - 3.0] }
}

fn none(_: Separation) -> Vec<u64> {
    Vec::new()
}

#[test]
fn every_point_is_answered_once() {
    let mut seen = vec![0; 10_000];
    let stop = AtomicBool::new(false);
    run::<RunError>(&mut workers(3), 0..10_000, &job, &none, &mut Company::default(), &stop, |event| {
        let Event::Answer(index, answer, _) = event else {
            return Ok(ControlFlow::Continue(()));
        };
        seen[index as usize] += 1;
        match answer {
            Ok(outcome) => assert_eq!(outcome.values[0], 2.0 * (index as f64 - 3.0)),
            Err(_) => assert!(index < 3),
        }
        Ok(ControlFlow::Continue(()))
    })
    .unwrap();
    assert!(seen[3..].iter().all(|&count| count == 1));
    // Of those that took too long while others ran, one comes again alone, and changes nothing.
    assert_eq!(seen[..3].iter().sum::<i32>(), 4);
}

#[test]
fn a_run_ends_early_when_asked_to() {
    let stop = AtomicBool::new(false);
    let mut count = 0;
    run::<RunError>(&mut workers(2), 0..1_000_000, &job, &none, &mut Company::default(), &stop, |event| {
        count += u64::from(matches!(event, Event::Answer(..)));
        Ok(if count == 10 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) })
    })
    .unwrap();
    assert!((10..900_000).contains(&count), "{count}");
}

/// Finds after a thousand points that used processes err: 1e9 too much from the hundredth point on. What one worker finds,
/// all heed from the next point on.
struct Erring(u64, Arc<AtomicBool>);

impl Worker for Erring {
    fn run(&mut self, jobs: &[Job], post: &mut Post<'_>) -> Result<(), RunError> {
        for job in jobs {
            self.0 += 1;
            let (value, separation) = match self.0 {
                _ if self.1.load(Ordering::Relaxed) => (0.0, Separation::Forked),
                ..100 => (0.0, Separation::Used),
                100..1000 => (1e9, Separation::Used),
                _ => (0.0, Separation::Forked),
            };
            if self.0 == 1000 {
                self.1.store(true, Ordering::Relaxed);
                post.send(Event::Void(Separation::Used));
            }
            let answer = Ok(vec![value + job.values[0]].into());
            post.send(Event::Answer(job.index, answer, separation));
        }
        Ok(())
    }
}

#[test]
fn what_does_not_count_is_computed_again() {
    let known = Arc::new(AtomicBool::new(false));
    let erring = || Box::new(Erring(0, known.clone())) as Box<dyn Worker>;
    let mut workers = vec![erring(), erring()];
    let mut values = vec![f64::NAN; 5000];
    let earlier = |_| vec![7];
    let open = (0..5000).filter(|index| *index != 7);
    let stop = AtomicBool::new(false);
    run::<RunError>(&mut workers, open, &job, &earlier, &mut Company::default(), &stop, |event| {
        if let Event::Answer(index, answer, _) = event {
            values[index as usize] = answer.unwrap().values[0];
        }
        Ok(ControlFlow::Continue(()))
    })
    .unwrap();
    // A point of an earlier run comes again, too.
    assert!((0..5000).all(|index| values[index] == index as f64 - 3.0));
}

/// Gives back what it has taken after so many batches, and is ready no more.
struct Leaving(u32);

impl Worker for Leaving {
    fn ready(&mut self, _stopped: &dyn Fn() -> bool) -> Result<bool, RunError> {
        Ok(self.0 > 0)
    }

    fn run(&mut self, jobs: &[Job], post: &mut Post<'_>) -> Result<(), RunError> {
        self.0 -= 1;
        if self.0 > 0 {
            return Doubling.run(jobs, post);
        }
        let (first, rest) = jobs.split_at(jobs.len() / 2);
        post.give_back(rest.to_vec());
        Doubling.run(first, post)
    }
}

#[test]
fn points_of_workers_that_leave_are_answered_by_others() {
    for last in [1, 2, 5] {
        let mut workers = workers(1);
        workers.extend((0..3).map(|_| Box::new(Leaving(last)) as Box<dyn Worker>));
        let mut seen = vec![0; 3000];
        run::<RunError>(
            &mut workers,
            3..3000,
            &job,
            &none,
            &mut Company::default(),
            &AtomicBool::new(false),
            |event| {
                if let Event::Answer(index, ..) = event {
                    seen[usize::try_from(index).unwrap()] += 1;
                }
                Ok(ControlFlow::Continue(()))
            },
        )
        .unwrap();
        assert!(seen[3..].iter().all(|&count| count == 1));
    }
}

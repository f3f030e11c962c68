use super::*;
use crate::failure::Failure;

/// Doubles its first value; fails where that is negative.
struct Doubling;

impl Worker for Doubling {
    fn run(&mut self, jobs: &[Job], post: &mut Post) -> Result<(), RunError> {
        for job in jobs {
            let value = job.values[0];
            let answer = if value < 0.0 { Err(Failure::Timeout) } else { Ok(vec![2.0 * value].into()) };
            post.send(Event::Answer(job.index, answer));
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

#[test]
fn every_point_is_answered_once() {
    let mut seen = vec![0; 10_000];
    let stop = AtomicBool::new(false);
    run::<RunError>(&mut workers(3), 0..10_000, &job, &stop, |event| {
        let Event::Answer(index, answer) = event else {
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
    assert!(seen.iter().all(|&count| count == 1));
}

#[test]
fn a_run_ends_early_when_asked_to() {
    let stop = AtomicBool::new(false);
    let mut count = 0;
    run::<RunError>(&mut workers(2), 0..1_000_000, &job, &stop, |event| {
        count += u64::from(matches!(event, Event::Answer(..)));
        Ok(if count == 10 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) })
    })
    .unwrap();
    assert!((10..900_000).contains(&count), "{count}");
}

/// Gives back what it has taken after so many batches, and is ready no more.
struct Leaving(u32);

impl Worker for Leaving {
    fn ready(&mut self, _stopped: &dyn Fn() -> bool) -> Result<bool, RunError> {
        Ok(self.0 > 0)
    }

    fn run(&mut self, jobs: &[Job], post: &mut Post) -> Result<(), RunError> {
        self.0 -= 1;
        if self.0 > 0 {
            return Doubling.run(jobs, post);
        }
        let (first, rest) = jobs.split_at(jobs.len() / 2);
        post.returned.extend(rest.to_vec());
        Doubling.run(first, post)
    }
}

#[test]
fn points_of_workers_that_leave_are_answered_by_others() {
    for last in [1, 2, 5] {
        let mut workers = workers(1);
        workers.extend((0..3).map(|_| Box::new(Leaving(last)) as Box<dyn Worker>));
        let mut seen = vec![0; 3000];
        run::<RunError>(&mut workers, 3..3000, &job, &AtomicBool::new(false), |event| {
            if let Event::Answer(index, ..) = event {
                seen[usize::try_from(index).unwrap()] += 1;
            }
            Ok(ControlFlow::Continue(()))
        })
        .unwrap();
        assert!(seen[3..].iter().all(|&count| count == 1));
    }
}

//! Workers on other machines: one there does what one here does, with processes of its own.

use std::{
    sync::{
        Arc,
        atomic::{AtomicU64, Ordering},
    },
    time::{Duration, Instant},
};

use crate::{
    dispatch::{Order, Series},
    points::{Job, Post, RunError, Worker},
    task::Case,
    team::{Lane, OrderEnd, Team},
    working_directory,
};

/// A worker that has its processes on another machine.
#[derive(Debug)]
pub struct Remote {
    team: Arc<Team>,
    /// Its lane; none for one that takes any.
    lane: Option<usize>,
    /// The host that it does not take while there is another one.
    but: Option<String>,
    series: Series,
    number: u64,
    /// How long the last points took beyond their computation.
    overhead: Duration,
}

impl Remote {
    pub fn new(team: &Arc<Team>, lane: Option<usize>, cases: &[Case]) -> Self {
        static SERIES: AtomicU64 = AtomicU64::new(0);
        let here = cases.iter().any(|case| working_directory::is_named_in(&case.task));
        Self {
            team: Arc::clone(team),
            lane,
            but: None,
            series: Series { cases: cases.to_vec(), again: false, here },
            number: SERIES.fetch_add(1, Ordering::Relaxed),
            overhead: Duration::ZERO,
        }
    }

    /// A worker that runs points again, on another host than `but` where there is one.
    pub fn again(team: &Arc<Team>, cases: &[Case], but: Option<&str>) -> Self {
        let mut worker = Self::new(team, None, cases);
        worker.series.again = true;
        worker.but = but.map(str::to_owned);
        worker
    }

    /// How many results a point has.
    fn results(&self) -> usize {
        self.series.cases.iter().map(|case| case.task.observed.len()).sum()
    }

    /// Tells a worker what points are about to come, unless it knows.
    fn begin(&self, lane: &mut Lane) {
        if lane.series.replace(self.number) == Some(self.number) {
            return;
        }
        if let Some(link) = &mut lane.link {
            link.order(&Order::Begin(Box::new(self.series.clone())));
        }
    }

    /// One try of points on a lane; those that are open still.
    fn attempt(&mut self, number: usize, jobs: &[Job], post: &mut Post) -> Result<Vec<Job>, RunError> {
        let begun = Instant::now();
        let team = Arc::clone(&self.team);
        let mut lane = team.lane(number);
        self.begin(&mut lane);
        let order = Order::Run(jobs.to_vec(), team.changed());
        let (end, open) = team.order(&mut lane, &order, jobs, self.results(), post);
        match end {
            OrderEnd::Done(took) => {
                self.overhead = begun.elapsed().saturating_sub(Duration::try_from_secs_f64(took).unwrap_or_default());
                Ok(open.into_values().collect())
            }
            OrderEnd::Stopped => {
                // It may be at the points still.
                team.leave(&mut lane);
                Ok(open.into_values().collect())
            }
            OrderEnd::Lost(fault) => {
                team.fail(&mut lane, &fault)?;
                let cost = jobs.len() == 1 && !fault.lasting;
                let how = format!("{}: {}", lane.host, fault.how);
                Ok(team.reclaim(open, cost, &how, post))
            }
        }
    }

    /// Runs points on whichever lane has a worker, until all are done.
    fn run_anywhere(&mut self, jobs: &[Job], post: &mut Post) -> Result<(), RunError> {
        let team = Arc::clone(&self.team);
        let mut open = jobs.to_vec();
        while !open.is_empty() && !post.is_over() {
            let all = 0..team.lanes.len();
            let linked = all.clone().filter(|&number| team.lane(number).link.is_some());
            let Some(number) = linked
                .clone()
                .find(|&number| Some(&team.lane(number).host) != self.but.as_ref())
                .or_else(|| linked.clone().next())
                .or_else(|| all.clone().find(|&number| !team.lane(number).out))
            else {
                return Err(RunError::NoWorker("all hosts are left out".to_owned()));
            };
            if team.connect(&mut team.lane(number), post.stopped)? {
                open = self.attempt(number, &open, post)?;
            }
        }
        Ok(())
    }
}

impl Worker for Remote {
    fn ready(&mut self, stopped: &dyn Fn() -> bool) -> Result<bool, RunError> {
        match self.lane {
            Some(number) => self.team.connect(&mut self.team.lane(number), stopped),
            None => Ok(true),
        }
    }

    fn run(&mut self, jobs: &[Job], post: &mut Post) -> Result<(), RunError> {
        let Some(number) = self.lane else { return self.run_anywhere(jobs, post) };
        let open = self.attempt(number, jobs, post)?;
        post.returned.extend(open);
        Ok(())
    }

    fn overhead(&self) -> Duration {
        self.overhead
    }
}

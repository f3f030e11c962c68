//! Points of several cases: each case is ordered from a worker as a simulation of its own, and their replies become
//! one.
//!
//! So whoever separates processes separates cases as strictly as points, and whoever asks for points sees one answer with
//! the results of all cases, the first case first. The index of a simulation is that of its point times the number of
//! cases, plus the number of its case.

use std::collections::BTreeMap;

use crate::{
    failure::{Failure, OfCase},
    notices::Notices,
    points::{Job, Simulated},
    task::Case,
    wire::{Origin, Reply, SimulationOutcome, Trouble},
};

/// A point's simulations.
pub fn split(job: &Job, cases: usize) -> impl Iterator<Item = Job> {
    let first = job.index * cases as u64;
    (first..first + cases as u64).map(|index| Job { index, values: job.values.clone() })
}

/// The number of the case of a simulation.
pub fn case_of(index: u64, cases: usize) -> usize {
    // Less than the number of cases, which is none of 64 bits where there is another width.
    usize::try_from(index % (cases as u64).max(1)).unwrap_or(0)
}

/// The part of a case in the results of a point.
#[derive(Debug)]
pub struct CasePart {
    /// The case's name.
    name: String,
    /// How many results it has.
    results: usize,
}

/// The parts of all cases.
pub fn parts(cases: &[Case]) -> Vec<CasePart> {
    cases
        .iter()
        .map(|case| CasePart { name: case.name.clone().unwrap_or_default(), results: case.task.observed.len() })
        .collect()
}

/// The simulations of points that are not complete yet.
#[derive(Debug)]
pub struct Join {
    cases: Vec<CasePart>,
    open: BTreeMap<u64, Vec<Option<Reply>>>,
}

impl Join {
    pub fn new(cases: &[Case]) -> Self {
        Self { cases: parts(cases), open: BTreeMap::new() }
    }

    /// Takes the reply of a simulation; gives that of its point once it is the last one.
    pub fn add(&mut self, reply: Reply) -> Option<Reply> {
        let count = self.cases.len();
        if count == 1 {
            return Some(reply);
        }
        let (point, case) = (reply.index / (count as u64).max(1), case_of(reply.index, count));
        let replies = self.open.entry(point).or_insert_with(|| vec![None; count]);
        *replies.get_mut(case)? = Some(reply);
        if replies.iter().any(Option::is_none) {
            return None;
        }
        let replies: Vec<Reply> = self.open.remove(&point)?.into_iter().flatten().collect();
        let forkable = replies.iter().map(|reply| reply.forkable).reduce(|one, other| Some(one? && other?));
        let answers = replies.into_iter().map(|reply| reply.answer).collect();
        Some(Reply { index: point, answer: joined(&self.cases, answers), forkable: forkable.flatten() })
    }
}

/// The outcome of a point: that of its only case; or else the results of all cases, or the failure of the first one of the
/// gravest kind.
pub fn joined(cases: &[CasePart], mut outcomes: Vec<SimulationOutcome>) -> SimulationOutcome {
    if outcomes.len() == 1 {
        return outcomes.remove(0);
    }
    let mut notices = Notices::default();
    for (case, outcome) in cases.iter().zip(&outcomes) {
        let said = match outcome {
            Ok(simulated) => simulated.notices.as_deref(),
            Err(trouble) => Some(&*trouble.notices),
        };
        said.into_iter().for_each(|said| notices.add(said, &case.name));
    }
    let Some(worst) = (0..outcomes.len())
        .filter(|&case| outcomes[case].is_err())
        .min_by_key(|&case| outcomes[case].as_ref().err().map(|trouble| trouble.from))
    else {
        let values = outcomes.into_iter().flatten().flat_map(|simulated| simulated.values);
        return Ok(Simulated::new(values.collect(), &notices));
    };
    let values: Vec<Option<f64>> =
        cases.iter().zip(&outcomes).flat_map(|(case, outcome)| known(outcome, case.results)).collect();
    let trouble = outcomes.into_iter().nth(worst).and_then(Result::err).expect("the worst one failed");
    let case = cases[worst].name.clone();
    let failure = match (trouble.from, trouble.failure) {
        (Origin::Loading, failure) => failure,
        (_, mut failure) => {
            if let Failure::NotFinite(partial) = &mut failure {
                // `values` below holds them already, with those of the other cases.
                partial.values.clear();
            }
            Failure::InCase(Box::new(OfCase { case, failure, values }))
        }
    };
    Err(Trouble { from: trouble.from, failure, notices: Box::new(notices), passing: trouble.passing })
}

/// The results of a case, as far as there are any.
fn known(outcome: &SimulationOutcome, count: usize) -> Vec<Option<f64>> {
    match outcome {
        Ok(simulated) => simulated.values.iter().copied().map(Some).collect(),
        Err(trouble) => (0..count).map(|k| trouble.failure.value(k)).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::failure::Partial;
    use crate::task::{Measure, Probe, Schedule, Task};
    use fmu_import::{Content, Handle};
    use sampling::statistics::Statistic;

    /// Two cases with two results each.
    fn cases() -> Vec<Case> {
        let probe = Probe {
            name: "y".to_owned(),
            handle: Handle { reference: 0, content: Content::Real },
            measure: Measure::Statistic(Statistic::Final),
            window: None,
            unit: None,
            product: None,
        };
        let task = Task {
            observed: vec![probe.clone(), probe],
            ..Task::new(Schedule { start: 0.0, stop: 1.0, step: 1.0, window_start: 0.0, leap: false, tolerance: None })
        };
        let case = |name: &str| Case { name: Some(name.to_owned()), task: task.clone() };
        vec![case("slow"), case("fast")]
    }

    fn reply(index: u64, answer: SimulationOutcome) -> Reply {
        Reply { forkable: Some(true), ..Reply::new(index, answer) }
    }

    fn failed(failure: Failure) -> SimulationOutcome {
        Err(Trouble::new(Origin::Fmu, failure))
    }

    #[test]
    fn a_point_is_answered_with_its_last_case_whatever_the_order() {
        let cases = cases();
        let mut join = Join::new(&cases);
        let job = |index| Job { index, values: vec![7.0] };
        let runs: Vec<(u64, usize)> = [job(3), job(4)]
            .iter()
            .flat_map(|job| split(job, 2))
            .map(|job| (job.index, case_of(job.index, 2)))
            .collect();
        assert_eq!(runs, [(6, 0), (7, 1), (8, 0), (9, 1)]);
        assert!(join.add(reply(9, Ok(vec![3.0, 4.0].into()))).is_none());
        assert!(join.add(reply(6, Ok(vec![5.0, 6.0].into()))).is_none());
        let point = join.add(reply(8, Ok(vec![1.0, 2.0].into()))).unwrap();
        assert_eq!((point.index, point.forkable), (4, Some(true)));
        assert_eq!(point.answer.unwrap().values, [1.0, 2.0, 3.0, 4.0]);
    }

    #[test]
    fn a_broken_case_costs_the_point_and_is_named() {
        let good = || Ok(vec![1.0, 2.0].into());
        let broken = joined(&parts(&cases()), vec![good(), failed(Failure::Timeout)]).unwrap_err();
        let failure = broken.failure;
        assert_eq!(failure.to_string(), "case fast: timeout");
        let values = |failure: &Failure| [0, 1, 2, 3].map(|k| failure.value(k));
        assert_eq!(values(&failure), [Some(1.0), Some(2.0), None, None]);
        // A result that is no number keeps the others of its case.
        let partial = Failure::NotFinite(Partial::new("y", &[3.0, f64::NAN]));
        let failure = joined(&parts(&cases()), vec![failed(partial), good()]).unwrap_err().failure;
        assert_eq!(failure.to_string(), "case slow: not finite: y");
        assert_eq!(values(&failure), [Some(3.0), None, Some(1.0), Some(2.0)]);
    }

    #[test]
    fn what_befalls_the_process_comes_before_what_the_fmu_says() {
        let lost = || Err(Trouble::lost(Failure::Timeout));
        let said = || failed(Failure::Error("no".to_owned()));
        let worst = joined(&parts(&cases()), vec![said(), lost()]).unwrap_err();
        assert_eq!(worst.from, Origin::Process);
        let unloadable = Err(Trouble::unloadable("no file".to_owned()));
        let worst = joined(&parts(&cases()), vec![lost(), unloadable]).unwrap_err();
        assert_eq!(worst.failure, Failure::Unloadable("no file".to_owned()));
    }

    #[test]
    fn warnings_of_all_cases_are_counted() {
        let warned = |count, text: &str| {
            Ok(Simulated {
                values: vec![0.0, 0.0],
                notices: Some(Box::new(Notices {
                    warnings: count,
                    first_warning: Some(text.to_owned()),
                    ..Notices::default()
                })),
            })
        };
        let warned = vec![warned(2, "hot"), warned(3, "cold")];
        let notices = joined(&parts(&cases()), warned).unwrap().notices.unwrap();
        assert_eq!(notices.warnings, 5);
        assert_eq!(notices.first_warning.as_deref(), Some("case slow: hot"));
    }
}

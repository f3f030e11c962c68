//! Runs of a study's model at points that an analysis chooses.

use std::cell::Cell;
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::atomic::AtomicBool;

use super::CommandError;
use super::limits::place;
use super::progress::Progress;
use crate::cli::Means;
use crate::design::Design;
use crate::distribution::Distribution;
use crate::engine::crew::Crew;
use crate::engine::{self, EngineError, Job};
use crate::judge::Judge;
use crate::results::origin::Origin;
use crate::results::{Outcome, ResultsError};
use crate::study::plan::Plan;
use crate::study::{self, Method, Study};
use fmu_import::Package;
use tempfile::TempDir;

/// A study that is ready to run.
pub(super) struct Batch {
    pub(super) plan: Plan,
    pub(super) judge: Judge,
    /// To what belongs what its runs tell.
    pub(super) origin: Origin,
    crew: Crew,
    /// Whether results have been handed out.
    used: Cell<bool>,
    // What the workers need on disk lives as long as these.
    _scratch: TempDir,
    _package: Package,
}

impl Batch {
    pub(super) fn new(path: &Path, means: &Means) -> Result<Self, CommandError> {
        let study = Study::read(path)?;
        let mut package = Package::open(&means.fmu(&study))?;
        let judge = Judge::new(&study, Some(package.description()))?;
        let plan = Plan::new(&study, package.description())?;
        if !plan.is_independent() {
            let message = "this analysis takes every parameter on its own; remove [[correlations]]";
            return Err(study.error(message).into());
        }
        let scratch = tempfile::tempdir().map_err(ResultsError::io(&std::env::temp_dir()))?;
        let jobs = means.jobs();
        let crew = Crew::new(&mut package, place(means, jobs)?, scratch.path(), jobs)?;
        let origin = Origin {
            study_sha256: study.digest(),
            fmu_sha256: Some(package.digest()?),
            points: None,
        };
        Ok(Self {
            plan,
            judge,
            origin,
            crew,
            used: Cell::new(false),
            _scratch: scratch,
            _package: package,
        })
    }

    /// The parameters that vary, by their place among the plan's inputs.
    pub(super) fn varied(&self) -> Vec<usize> {
        let inputs = &self.plan.inputs;
        (0..inputs.len())
            .filter(|&k| inputs[k].distribution.varies())
            .collect()
    }

    /// The parameters at a point of the unit cube of those that vary.
    pub(super) fn parameters(&self, cube: &[f64]) -> Vec<f64> {
        let mut places = cube.iter();
        let value = |distribution: &Distribution| {
            let place = if distribution.varies() {
                places.next()
            } else {
                None
            };
            place.map_or_else(
                || distribution.median(),
                |&u| distribution.quantile(inside(u)),
            )
        };
        self.plan
            .inputs
            .iter()
            .map(|input| &input.distribution)
            .map(value)
            .collect()
    }

    /// Simulates points given by their parameters; the outcomes are in the study's units.
    pub(super) fn run(&self, points: &[Vec<f64>]) -> Result<Vec<Outcome>, CommandError> {
        let mut workers = self.crew.workers(&self.plan.task);
        let plan = &self.plan;
        let job = |index: u64| {
            let mut values = Vec::new();
            if let Some(parameters) = points.get(index as usize) {
                plan.to_fmu(parameters, &mut values);
            }
            Job { index, values }
        };
        let progress = Progress::new(points.len() as u64, 0);
        let mut outcomes: Vec<Option<Outcome>> = vec![None; points.len()];
        let (mut verified, mut failed, mut done) = (0, 0, 0);
        engine::run(
            &mut workers,
            0..points.len() as u64,
            &job,
            &|_| Vec::new(),
            &AtomicBool::new(false),
            |event| {
                let (index, answer) = match event {
                    engine::Event::Answer(index, answer, _) => (index, answer),
                    // Those of this run will come again.
                    engine::Event::Void(_) if self.used.get() => {
                        return Err(EngineError::Refuted.into());
                    }
                    engine::Event::Void(_) | engine::Event::Idle => {
                        return Ok(ControlFlow::Continue(()));
                    }
                };
                let outcome: Outcome = answer.map(|mut values| {
                    plan.to_study(&mut values);
                    values
                });
                done += 1;
                failed += u64::from(outcome.is_err());
                verified += u64::from(self.judge.verdict(outcome.as_deref().ok()).verified());
                progress.step(verified, failed, done);
                if let Some(place) = outcomes.get_mut(index as usize) {
                    *place = Some(outcome);
                }
                Ok::<_, CommandError>(ControlFlow::Continue(()))
            },
        )?;
        progress.finish();
        self.used.set(true);
        Ok(outcomes.into_iter().flatten().collect())
    }
}

/// Keeps away from the ends of the unit interval, where a distribution may reach to infinity.
fn inside(u: f64) -> f64 {
    u.clamp(1e-6, 1.0 - 1e-6)
}

/// Points in the unit cube, which belong to independently scrambled Sobol nets in turn.
pub(super) fn cube(
    dimensions: usize,
    points: u64,
    seed: u64,
    replicates: u64,
) -> Result<Vec<Vec<f64>>, String> {
    let design = study::Design {
        method: Method::Sobol,
        points,
        seed,
        replicates,
    };
    let unit = Distribution::Uniform { min: 0.0, max: 1.0 };
    let design = Design::new(&design, vec![unit; dimensions])?;
    Ok((0..points).map(|index| design.point(index)).collect())
}

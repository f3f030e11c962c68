//! `identify --posterior`: a sample of the posterior, and its file.

use std::path::Path;

use serde::Deserialize;

use super::files::remove;
use crate::{
    error::{Error, Result},
    identify::bind::Bound,
};
use calibration::{
    objective::Objective,
    optima::Optimum,
    outcome::IdentificationOutcome,
    problem::Problem,
    sample::{FEWEST, Sample, Settings, evidence::Evidence, outcome::PosteriorOutcome, sample, text},
    search::SearchError,
};
use number_tables::{csv_file, files};
use point_journal::files::write_atomically;
use study::{Identification, Study};

/// The most particles: more would be the table's work, not the posterior's.
const MOST: u64 = 1_000_000;

/// Particles that each unknown needs: with fewer, the moves cannot follow the sample's shape.
const EACH: u64 = 20;

/// The name of the table of particles.
const FILE: &str = "posterior.csv";

/// Refuses numbers of particles that would say nothing.
pub fn check(study: &Study, settings: &Identification, bound: &Bound, by_option: bool) -> Result {
    let Some(particles) = &settings.posterior else { return Ok(()) };
    let common = 2 * bound.problem.populations.len();
    let unknowns = (bound.problem.unknowns() + common) as u64;
    let fewest = FEWEST.max(EACH * unknowns);
    let number = *particles.as_ref();
    if (fewest..=MOST).contains(&number) {
        return Ok(());
    }
    let message = format!("{number} particles: with {unknowns} unknowns, give {fewest} or more, and at most {MOST}");
    Err(if by_option { Error::option("posterior", message) } else { study.error_at(particles, message).into() })
}

/// The evidence of another result, given its file or its folder.
pub fn other(path: &Path, problem: &Problem) -> Result<Evidence> {
    #[derive(Deserialize)]
    struct Other {
        evidence: Option<Evidence>,
    }
    let path = if path.is_dir() { path.join(super::RESULT) } else { path.to_owned() };
    let evidence = serde_json::from_str::<Other>(&files::text(&path)?)
        .map_err(|error| Error::content(&path, error))?
        .evidence
        .ok_or_else(|| Error::content(&path, "there is no evidence in it; run that identify with --posterior N"))?;
    evidence.is_of(problem).map_err(|message| Error::content(&path, message))?;
    Ok(evidence)
}

/// Samples the posterior where that is asked for.
pub fn sampled(
    objective: &Objective,
    optima: &[Optimum],
    settings: &Identification,
    outcome: &mut IdentificationOutcome,
    say: &dyn Fn(String),
) -> Result<Option<Sample>, SearchError> {
    let Some(particles) = &settings.posterior else { return Ok(None) };
    let settings = Settings { particles: *particles.as_ref(), seed: settings.seed };
    let observe = |exponent: f64, step: usize| {
        say(format!("posterior with exponent {exponent:.2e}, step {step}"));
    };
    match sample(objective, &[], &settings, &observe) {
        Ok(sample) => {
            let posterior = PosteriorOutcome::new(objective, optima, &sample);
            outcome.evidence = Some(Evidence::new(objective.problem, &sample, posterior.trusted));
            outcome.posterior = Some(posterior);
            Ok(Some(sample))
        }
        Err(error) => Err(error.into()),
    }
}

/// Writes the table of particles. Without a sample an earlier one's goes: it would be taken for this one's.
pub fn write(folder: &Path, settings: &Identification, bound: &Bound, sample: Option<&Sample>) -> Result {
    let path = folder.join(FILE);
    let Some(sample) = sample else { return remove(&path) };
    // Groups of one size may need some more.
    let wanted = settings.posterior.as_ref().map_or(MOST, |particles| *particles.as_ref()) as usize;
    write_atomically(&path, |out| {
        let problem = &bound.problem;
        writeln!(out, "# {}", text::units(problem))?;
        let mut table = csv::Writer::from_writer(out);
        let head = text::head(problem);
        table.write_record(head.iter().map(|name| csv_file::cell(name).into_owned()))?;
        for row in text::rows(problem, sample).take(wanted) {
            table.write_record(row)?;
        }
        table.flush()
    })?;
    Ok(())
}

//! `identify`: finds the parameters that make the FMU's outputs most probable.

mod files;
mod posterior;
mod surrogate;

use std::process::ExitCode;
use std::time::{Duration, Instant};

use super::limits::place;
use super::{CommandError, asking, output};
use crate::cli::Identify;
use crate::identify::bind::Bound;
use crate::identify::error::BindError;
use crate::identify::from_study;
use crate::identify::model::FmuModel;
use crate::pipeline::folder::RunFolder;
use crate::pipeline::{Part, Pipeline};
use crate::results::lock::Lock;
use crate::results::{Header, ResultsError};
use crate::session::{Asking, Request};
use crate::study::Identification;
use crate::study::Study;
use calibration::cross::outcome::{CrossValidation, Found};
use calibration::cross::{self, Whole, cross_validate};
use calibration::failures::Excluded;
use calibration::local::{End, Minimum};
use calibration::objective::Objective;
use calibration::outcome::IdentificationOutcome;
use calibration::problem::{Problem, Simulate};
use calibration::remembered::Remembered;
use calibration::rounds;
use calibration::sample::{self, Sample};
use calibration::search::{self, Progress, SearchError};
use calibration::text;
use fmu_import::{Description, Package};
use fmu_points::crew::Crew;
use sampling::design::cube;

/// The name of the command, and of the folder of its journal.
const NAME: &str = "identify";

pub(super) fn run(options: &Identify) -> Result<ExitCode, CommandError> {
    if asking::shard(&options.work.parts)?.is_some() {
        let message = "each step of a search depends on the one before, so it has no parts; --resume goes on with one";
        return Err(CommandError::Option {
            option: "shard",
            message: message.to_owned(),
        });
    }
    let study = Study::read(&options.work.study)?;
    let settings = settings(options, &study)?;
    let fmu = options.work.means.fmu.as_deref();
    let mut package = study.open_fmu::<CommandError>(fmu)?;
    let bound = bound(&study, &settings, package.description())?;
    if options.cross_validate && bound.problem.cases.len() < 2 {
        let message = match study.cases.is_empty() {
            true => {
                "there is one case only, and nothing to predict it from; give more under `cases` in [identify]"
            }
            false => {
                "the cases of a study are fitted together; to predict one from the others, set `held-out = true` in it"
            }
        };
        return Err(CommandError::Option {
            option: "cross-validate",
            message: message.to_owned(),
        });
    }
    posterior::check(&study, &settings, &bound, options.posterior.is_some())?;
    surrogate::check(&study, &settings, &bound, options)?;
    let folder = asking::folder(
        options.work.output.as_deref(),
        &options.work.study,
        &options.work.parts,
        None,
    )?;
    let state = folder.join(NAME);
    let header = header(&study, &package, &settings)?;
    let (request, earlier) = (request(options), options.work.parts.earlier());
    request.check(&folder, Some(NAME), Some(&study), earlier)?;
    let taken = RunFolder::open(Lock::take(&state)?, &state, &header, earlier, false)?;
    request.write(&state, &study)?;
    let jobs = options.work.means.jobs();
    let place = place(&options.work.means, jobs)?;
    let crew = Crew::new(&mut package, place, taken.scratch.path(), jobs)?;
    let RunFolder {
        journal, finished, ..
    } = taken;
    let mut pipeline = Pipeline::new(
        &bound,
        Some((&crew, &bound.simulations[..])),
        journal,
        finished,
        Part::of(None, &header),
    )
    .repeating(settings.seed, true);
    let found = find(options, &study, &settings, &bound, &mut pipeline);
    let (outcome, sample) = match found {
        Ok(found) => found,
        Err(error) => {
            pipeline.pause()?;
            return Err(error);
        }
    };
    pipeline.end()?;
    files::write(&folder, &study, &settings, &outcome)?;
    posterior::write(&folder, &bound, sample.as_ref())?;
    let validation = outcome.cross_validation.as_ref();
    output::print(&format!(
        "{}{}{}results in {}\n",
        text::summary(&outcome),
        outcome
            .posterior
            .as_ref()
            .map_or_else(String::new, sample::text::summary),
        validation.map_or_else(String::new, cross::text::summary),
        folder.display()
    ));
    Ok(match outcome.end {
        End::Time | End::Iterations => ExitCode::FAILURE,
        End::Converged | End::Rounds => ExitCode::SUCCESS,
    })
}

/// The unknowns and the data: the cases of the study, or those of the section `[identify]`.
fn bound(
    study: &Study,
    settings: &Identification,
    fmu: &Description,
) -> Result<Bound, CommandError> {
    if !study.cases.is_empty() {
        return Ok(from_study::bind(study, settings, fmu)?);
    }
    Bound::new(study, settings, fmu).map_err(|error| match error {
        BindError::Study(error) => CommandError::from(error),
        BindError::Table(error) => CommandError::from(error),
    })
}

/// The study's settings, overridden by the command line. A study with cases need not have any.
fn settings(options: &Identify, study: &Study) -> Result<Identification, CommandError> {
    let usual = || (!study.cases.is_empty()).then(Identification::default);
    let mut settings = study.identify.clone().or_else(usual).ok_or_else(|| {
        study.error("identify needs a section [identify]; `orchestrator identify --help` shows one")
    })?;
    settings.starts = options.starts.unwrap_or(settings.starts);
    settings.seed = options.seed.unwrap_or(settings.seed);
    if let Some(particles) = options.posterior {
        settings.posterior = Some(toml::Spanned::new(0..0, particles));
    }
    if let Some(runs) = options.surrogate {
        settings.surrogate = Some(toml::Spanned::new(0..0, runs));
    }
    Ok(settings)
}

/// The request to keep beside the journal, for `--resume`.
fn request(options: &Identify) -> Request {
    let Identify {
        starts,
        seed,
        cross_validate,
        posterior,
        surrogate,
        ..
    } = options;
    Request {
        study: options.work.study.clone(),
        fmu: options.work.means.fmu.clone(),
        seed: *seed,
        analysis: Some(Asking {
            name: NAME.to_owned(),
            options: serde_json::json!({
                "starts": starts, "cross-validate": cross_validate, "posterior": posterior, "surrogate": surrogate,
            }),
        }),
        ..Request::default()
    }
}

/// Identity of the run.
fn header(
    study: &Study,
    package: &Package,
    settings: &Identification,
) -> Result<Header, CommandError> {
    let table = settings.cases.as_ref().map(|path| {
        let path = files::beside(study, path.as_ref());
        crate::files::digest(&path).map_err(ResultsError::io(&path))
    });
    Ok(Header {
        orchestrator: env!("CARGO_PKG_VERSION").to_owned(),
        study: study.digest(),
        fmu: package.digest()?,
        table: table.transpose()?,
        seed: settings.seed,
        points: None,
        shard: None,
        analysis: Some(format!("{NAME}, {} starts", settings.starts)),
    })
}

/// Searches for the most probable parameters.
fn find(
    options: &Identify,
    study: &Study,
    settings: &Identification,
    bound: &Bound,
    pipeline: &mut Pipeline<'_>,
) -> Result<(IdentificationOutcome, Option<Sample>), CommandError> {
    let starts = starts(study, settings, bound.problem.free.len())?;
    let limits = search::Effort {
        descents: settings.descents.max(1),
        iterations: settings.iterations.max(1),
        deadline: options
            .time_limit
            .map(|seconds| Instant::now() + Duration::from_secs_f64(seconds.clamp(0.0, 1e9))),
    };
    let model = FmuModel::new(bound, pipeline);
    let remembered = Remembered::new(&model);
    let task = rounds::Task {
        problem: &bound.problem,
        unknown: &bound.discrepancies,
        difference: settings.difference,
        starts: &starts,
        effort: limits,
    };
    let search = || {
        let replaced = surrogate::replaced(study, settings, &task, &remembered, &|text| {
            model.say(text);
        })?;
        let mut task = task;
        let mut asked: &dyn Simulate = &remembered;
        // Without surrogates: the places of a sample hardly ever come twice, and there are many.
        let mut sampled: &dyn Simulate = &model;
        if let Some(own) = &replaced {
            task.problem = &own.problem;
            (asked, sampled) = (&own.model, &own.model);
        }
        let mut searched = rounds::searched(&task, asked, &|progress| {
            model.say(so_far(progress));
        })?;
        let again = replaced.as_ref().map(|own| {
            let objective = Objective::new(&searched.problem, &remembered, settings.difference);
            surrogate::run_again(&objective, own, &mut searched.optima)
        });
        let again = again.transpose()?;
        let optima = &searched.optima;
        let cross_validation = options.cross_validate.then(|| {
            validate(
                (bound, &searched.problem),
                &remembered,
                &model,
                settings,
                &optima[0].minimum,
                limits.deadline,
            )
        });
        let mut outcome = IdentificationOutcome {
            cross_validation: cross_validation.transpose()?,
            surrogate: again,
            ..searched.outcome()
        };
        if let Some(own) = &replaced {
            // Only the model's own runs tell where it fails.
            let ended = own.screened.iter().copied();
            outcome.excluded = Excluded::new(&bound.problem, &own.failures, ended);
        }
        let objective = Objective::new(task.problem, sampled, settings.difference);
        let sample = posterior::sampled(
            &objective,
            optima,
            settings,
            limits.deadline,
            &bound.discrepancies,
            &mut outcome,
            &|text| model.say(text),
        )?;
        Ok((outcome, sample))
    };
    let found = search();
    found.map_err(|error: SearchError| match model.halted() {
        Some(halt) => halt.into(),
        None => CommandError::Search(error.to_string()),
    })
}

/// Predicts each case from the others.
fn validate(
    (bound, problem): (&Bound, &Problem),
    remembered: &Remembered<'_>,
    model: &FmuModel<'_, '_>,
    settings: &Identification,
    minimum: &Minimum,
    deadline: Option<Instant>,
) -> Result<CrossValidation, SearchError> {
    let whole = Whole {
        problem,
        model: remembered,
        difference: settings.difference,
        minimum,
        iterations: settings.iterations.max(1),
        deadline,
    };
    let of = problem.cases.len();
    let folds = cross_validate(&whole, &|case| {
        model.say(format!("case {} of {of} left out", case + 1));
    })?;
    Ok(CrossValidation::new(&Found {
        problem,
        free: &problem.free_values(&minimum.places),
        fitted: &minimum.misfit.predicted,
        known: &bound.known,
        folds: &folds,
    }))
}

/// How far a search has got, for people.
fn so_far(progress: &Progress) -> String {
    let best = progress.best().map_or_else(String::new, |best| {
        format!(", sum of squares {:.4}", best.cost)
    });
    format!(
        "{} starts screened, {} followed down{best}",
        progress.screened.len(),
        progress.descents.len()
    )
}

/// Starts from a scrambled Sobol net between the bounds.
fn starts(
    study: &Study,
    settings: &Identification,
    unknowns: usize,
) -> Result<Vec<Vec<f64>>, CommandError> {
    let starts = cube(unknowns, settings.starts.max(1), settings.seed, 1);
    Ok(starts.map_err(|message| study.error(format!("[identify] {message}")))?)
}

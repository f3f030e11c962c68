//! `identify`: finds the parameters that make the FMU's outputs most probable.

mod causes;
mod culprits;
mod document;
mod files;
mod optimum;
mod posterior;
mod surrogate;

use std::{
    path::{Path, PathBuf},
    process::ExitCode,
};

use clap::Args;
use serde::{Deserialize, Serialize};

use super::{
    asking::{self, Analysis, AnalysisResult, Delivery, PointSet},
    setup::{Runnable, SourceParts},
};
use crate::{
    error::{Error, Result},
    identify::{
        bind::Bound,
        from_study,
        model::{Finer, FmuModel},
        offsets,
    },
    options::{Means, Work},
    results::origin::Origin,
    session::{Request, account::Account},
};
use calibration::{
    capped::Capped,
    failures::Excluded,
    fit,
    local::End,
    numerical::NumericalError,
    objective::Objective,
    outcome::IdentificationOutcome,
    problem::{NoPrediction, Simulate},
    remembered::Remembered,
    rounds::{self, Searched},
    sample::{Sample, evidence::Evidence},
    search::{self, Progress, SearchError},
    surrogate::{Replaced, outcome::SurrogateOutcome},
};
use fmu_import::Package;
use point_journal::{
    files::write_json,
    pipeline::{Pipeline, folder::Earlier},
};
use result_document::Document;
use sampling::design::cube;
use study::{
    Identification, Study,
    concern::{Code, Concern},
};
use surrogate::KnownPoints;

/// The result's file in a folder of results.
const RESULT: &str = "identification.json";

/// Particles of the posterior where a budget makes them without runs.
const PARTICLES: u64 = 1000;

/// Options of `identify`.
#[derive(Debug, Args)]
#[command(after_help = include_str!("help.txt"))]
pub struct Options {
    /// The study, how its points are run, and where the results go
    #[command(flatten)]
    pub work: Work,
    /// Target and means of the search.
    #[command(flatten)]
    pub asked: Asked,
}

/// What the page of a finished study shows of it, in the folder of its journal.
pub const FILE: &str = "identify/section.json";

/// A result as the page of a finished study shows it, and where it came from.
#[derive(Serialize, Deserialize)]
pub struct Section {
    origin: Origin,
    document: Document,
}

/// The document of a result.
pub fn document(section: &Section) -> Document {
    section.document.clone()
}

/// What explains that a study is not verified, in the study's folder: a search with the usual options.
///
/// # Errors
/// Says why nothing was sought or found.
pub(crate) fn causes(study: &Path, means: &Means, earlier: Earlier, folder: &Path) -> Result<Vec<String>> {
    let asked = Asked::default();
    let fit = asked.open(asking::request(study, means))?;
    let Delivery { result, folder, .. } = asking::run_by(fit, &asked, (means, earlier), folder.to_owned())?;
    result.write(&folder)?;
    Ok(result.causes)
}

/// Runs the command.
///
/// # Errors
/// When the options or the study cannot be used, and when the search fails.
pub fn run(options: &Options) -> Result<Delivery> {
    let Options { work, asked } = options;
    let mut fit = asking::open(work, asked)?;
    let folder = work.folder();
    if let Some(runs) = asked.budget {
        fit.known = KnownPoints::of(&fit, &folder)?;
        let command = (Asked::NAME, work.resuming.resume);
        fit.request.account = Some(Account::open(&folder, command, runs, surrogate::cost(&fit.bound))?);
    }
    asking::run(fit, asked, work, folder)
}

/// A search for the most probable parameters.
#[derive(Debug, Default, Args)]
pub struct Asked {
    /// How many starts are screened, instead of the study's number
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub starts: Option<u64>,
    /// Also draw N sets of parameters from the posterior, of any shape
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub posterior: Option<u64>,
    /// For an FMU whose runs are dear: at most N runs, those of other budgets in the folder included. A surrogate of chosen ones, and of
    /// the study's points in the folder, tells optimum, intervals and posterior; its error counts as an uncertainty
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub budget: Option<u64>,
    /// Weigh the model against that of another result on the same data: its identification.json, or its folder
    #[arg(long, value_name = "FILE")]
    pub against: Option<PathBuf>,
    /// The seed of the starts, instead of the study's
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub seed: Option<u64>,
}

/// A study with its unknowns, tied to its FMU.
#[derive(Debug)]
pub struct BoundStudy {
    request: Request,
    study: Study,
    settings: Identification,
    package: Package,
    bound: Bound,
    /// The study's points, where a budget uses them.
    known: KnownPoints,
}

impl Runnable for BoundStudy {
    fn package(&mut self) -> &mut Package {
        &mut self.package
    }

    fn parts(&self) -> SourceParts<'_> {
        SourceParts {
            request: &self.request,
            study: &self.study,
            package: &self.package,
            model: &self.bound,
            cases: &self.bound.simulations,
        }
    }
}

impl Analysis for Asked {
    const NAME: &'static str = "identify";

    type Source = BoundStudy;

    fn open(&self, request: Request) -> Result<BoundStudy> {
        let seed = self.seed.or(request.seed);
        let study = Study::read(&request.study)?;
        let settings = self.settings(&study, seed)?;
        let package = study.open_fmu(request.fmu.as_deref())?;
        let fmu = package.description();
        // The unknowns and the data are those of the section `[identify]`, or of the study's criteria.
        let is_stated = study.criteria.is_empty() || !settings.measured.is_empty();
        let bound = if study.cases.is_empty() && is_stated {
            Bound::new(&study, &settings, fmu)?
        } else {
            from_study::bind(&study, &settings, fmu)?
        };
        Ok(BoundStudy {
            request: Request { seed, ..request },
            study,
            settings,
            package,
            bound,
            known: KnownPoints::default(),
        })
    }

    fn points(&self, fit: &BoundStudy) -> Result<PointSet> {
        let BoundStudy { study, settings, .. } = fit;
        let table = settings.cases.as_ref().map(|path| {
            let path = study.path_of(path.as_ref());
            number_tables::files::digest(&path).map_err(Error::io(&path))
        });
        Ok(PointSet {
            seed: settings.seed,
            points: None,
            method: format!("{} starts", settings.starts),
            table: table.transpose()?.or_else(|| fit.known.digest.clone()),
        })
    }

    fn check(&self, fit: &BoundStudy) -> Result {
        let BoundStudy { study, settings, bound, .. } = fit;
        posterior::check(study, settings, bound, self.posterior.is_some())?;
        self.other(settings, bound)?;
        surrogate::check(fit)
    }

    fn find(&self, fit: &BoundStudy, pipeline: &mut Pipeline, folder: &Path) -> Result<AnalysisResult> {
        let (mut outcome, sample) = find(fit, pipeline)?;
        if let (Some(other), Some(evidence)) = (self.other(&fit.settings, &fit.bound)?, &mut outcome.evidence) {
            evidence.compare(&other).unwrap_or_else(|message| {
                outcome.posterior.iter_mut().for_each(|sample| {
                    sample.notes.push(format!("--against: {message}"));
                })
            });
        }
        let fmu = fit.request.fmu.clone().unwrap_or_else(|| fit.study.fmu_path());
        files::write(folder, (&fit.study, &fmu), &outcome, &fit.bound)?;
        posterior::write(folder, &fit.settings, &fit.bound, sample.as_ref())?;
        let code = match outcome.end {
            End::Iterations | End::Budget => ExitCode::FAILURE,
            End::Converged => ExitCode::SUCCESS,
        };
        let title = fit.study.title.as_deref();
        let page = document::Page {
            title: title.unwrap_or("Parameters from measured values"),
            bound: &fit.bound,
            outcome: &outcome,
        };
        let origin = asking::origin(fit)?;
        let document = page.section();
        let mut result = AnalysisResult::new(&outcome, origin.clone(), &document, RESULT);
        if !fit.study.criteria.is_empty() && outcome.optima.len() == 1 {
            let file = folder.join("optimum.toml");
            result.text += &format!("\n`orchestrator verify {}` judges the model there\n", file.display());
        }
        write_json(&folder.join(FILE), &Section { origin, document })?;
        // A finished study has a page, which shows the section.
        if !folder.join("summary.json").exists() {
            page.write(folder)?;
        }
        result.add("fit", &outcome.fit());
        result.causes = causes::causes(&outcome);
        result.add("causes", &result.causes.clone());
        result.add("concerns", &concerns(&outcome));
        result.code = code;
        Ok(result)
    }
}

impl Asked {
    /// The evidence that this one's is weighed against.
    fn other(&self, settings: &Identification, bound: &Bound) -> Result<Option<Evidence>> {
        let Some(path) = &self.against else { return Ok(None) };
        if settings.posterior.is_none() {
            return Err(Error::option("against", "the evidence comes with --posterior N"));
        }
        posterior::other(path, &bound.problem).map(Some)
    }

    /// The study's settings, overridden by the command line. A study with criteria need not have any.
    fn settings(&self, study: &Study, seed: Option<u64>) -> Result<Identification> {
        let mut settings = study.identify.clone().or_else(|| (!study.criteria.is_empty()).then(Identification::default)).ok_or_else(|| {
            study.error_near(
                "criteria",
                "identify needs to know what is measured: add [criteria], or a section [identify] (`orchestrator identify --help`)",
            )
        })?;
        settings.starts = self.starts.unwrap_or(settings.starts);
        settings.seed = seed.unwrap_or(settings.seed);
        let unplaced = |number| toml::Spanned::new(0..0, number);
        settings.posterior = self.posterior.map(unplaced).or(settings.posterior);
        // By surrogate a sample takes no run.
        settings.posterior = settings.posterior.or_else(|| self.budget.map(|_| unplaced(PARTICLES)));
        Ok(settings)
    }
}

/// Searches for the most probable parameters.
fn find(fit: &BoundStudy, pipeline: &mut Pipeline) -> Result<(IdentificationOutcome, Option<Sample>)> {
    let BoundStudy { study, settings, bound, .. } = fit;
    let starts = starts(study, settings, bound.problem.free.len())?;
    let effort = search::Effort { descents: settings.descents, iterations: settings.iterations };
    if fit.request.account.is_some() {
        pipeline.repeat_at_most(1);
    }
    let model = FmuModel::new(bound, pipeline);
    let capped = Capped::new(&model, fit.request.account.as_ref().map_or(u64::MAX, Account::points));
    let remembered = Remembered::new(&capped, fit.known.answers(bound));
    let task = rounds::Task { problem: &bound.problem, difference: settings.difference, starts: &starts, effort };
    search_by(fit, task, (&model, &capped, &remembered)).map_err(|error| match model.halted() {
        Some(halt) => halt,
        None => Error::Search(error.to_string()),
    })
}

/// What a search asks for predictions.
enum Asks {
    /// The model.
    Model,
    /// Surrogates of the model, which hold.
    Surrogates(Box<Replaced>),
    /// The model, with the rest of a budget whose surrogates do not hold: down from this best run.
    FromBest(SurrogateOutcome, [Vec<f64>; 1]),
}

impl Asks {
    fn new(replaced: Option<Replaced>, unknowns: usize) -> Self {
        match replaced {
            None => Self::Model,
            Some(replaced) if replaced.told.holds => Self::Surrogates(Box::new(replaced)),
            Some(Replaced { told, best, .. }) => Self::FromBest(told, [best[..unknowns].to_vec()]),
        }
    }
}

/// The search itself, with the model as it is, with runs up to a budget, and with its answers remembered.
fn search_by(
    fit: &BoundStudy,
    given: rounds::Task,
    (model, capped, remembered): (&FmuModel, &Capped, &Remembered),
) -> Result<(IdentificationOutcome, Option<Sample>), SearchError> {
    let BoundStudy { settings, package, bound, .. } = fit;
    let say = |text| model.say(text);
    let asks = Asks::new(surrogate::replaced(fit, &given, remembered, &say)?, bound.problem.free.len());
    let (task, asked): (_, &dyn Simulate) = match &asks {
        Asks::Model => (given, remembered),
        Asks::Surrogates(by) => (rounds::Task { problem: &by.problem, ..given }, &by.model),
        Asks::FromBest(_, starts) => {
            let effort = search::Effort { descents: 1, ..given.effort };
            (rounds::Task { starts, effort, ..given }, remembered)
        }
    };
    let mut searched = rounds::searched(&task, asked, &|progress| say(so_far(progress)))?;
    let surrogate = match &asks {
        Asks::Model => None,
        Asks::Surrogates(by) => {
            let objective = Objective::new(&searched.problem, remembered, settings.difference);
            Some(surrogate::run_again(&objective, by, (&mut searched.optima, capped.left()))?)
        }
        Asks::FromBest(told, _) => Some(told.clone()),
    };
    let optima = &searched.optima;
    let mut outcome = IdentificationOutcome { surrogate, notes: bound.notes.clone(), ..searched.outcome() };
    if matches!(asks, Asks::FromBest(..)) && capped.has_refused() {
        outcome.end = End::Budget;
    }
    match &fit.request.account {
        Some(account) if account.points() == 0 => {
            let note = "The budget has no run left: neither the optimum was run nor half the communication step";
            outcome.notes.push(format!("{note}{}.", account.told()));
        }
        _ => look_closer(&mut outcome, &searched, model)?,
    }
    (outcome.farthest, outcome.influence) =
        calibration::influence::of_values(&searched.problem, &optima[0], &document::groups(bound));
    outcome.look_along(&document::curves(bound), &bound.problem.estimates);
    if outcome.fit() == fit::FitVerdict::Misses {
        outcome.notes.extend(offsets::held(bound));
        // On surrogates one would look for what their error explains.
        if let Asks::Model = asks {
            let fmu = (bound, package.description());
            outcome.suspects = Some(culprits::ask(fmu, &given, &searched, (remembered, model))?);
        }
    }
    let sampled: &dyn Simulate = match &asks {
        // The places of a sample hardly ever come twice, and there are many.
        Asks::Model => model,
        Asks::Surrogates(by) => {
            // Only the model's own runs tell where it fails.
            outcome.excluded = Excluded::new(&bound.problem, &by.failures, by.screened.iter().copied());
            &by.model
        }
        // There are no runs for a sample.
        Asks::FromBest(..) => return Ok((outcome, None)),
    };
    let objective = Objective::new(&searched.problem, sampled, settings.difference);
    let sample = posterior::sampled(&objective, optima, settings, &mut outcome, &say)?;
    Ok((outcome, sample))
}

/// Tries half the communication steps at the first optimum.
fn look_closer(outcome: &mut IdentificationOutcome, searched: &Searched, model: &FmuModel) -> Result<(), SearchError> {
    let Searched { problem, optima, .. } = searched;
    model.say("half the communication step".to_owned());
    let finer = Finer(model);
    // It takes no derivatives.
    let finer = Objective::new(problem, &finer, f64::NAN).misfit(&optima[0].minimum.places);
    match finer {
        Ok(finer) => {
            outcome.numerical_error = Some(NumericalError::new(problem, &optima[0], &finer, model.steps()));
        }
        Err(NoPrediction::Here(why)) => {
            outcome.notes.push(format!("Half the communication step was not tried: {why}."))
        }
        Err(NoPrediction::Stopped) => return Err(SearchError::Stopped),
    }
    Ok(())
}

/// The doubts about a result, for programs.
fn concerns(outcome: &IdentificationOutcome) -> Vec<Concern> {
    outcome
        .numerical_error
        .as_ref()
        .and_then(NumericalError::doubt)
        .map(|text| Concern::new(Code::CoarseStep, text).remedied(NumericalError::REMEDY))
        .into_iter()
        .collect()
}

/// How far a search has got, for people.
fn so_far(progress: &Progress) -> String {
    let best = progress.best().map(|best| format!(", sum of squares {:.4}", best.misfit.cost())).unwrap_or_default();
    format!("{} starts screened, {} followed down{best}", progress.screened.len(), progress.descents.len())
}

/// Starts from a scrambled Sobol net between the bounds.
fn starts(study: &Study, settings: &Identification, unknowns: usize) -> Result<Vec<Vec<f64>>> {
    Ok(cube(unknowns, settings.starts, settings.seed, 1)
        .map_err(|message| study.error_in("identify", &["starts"], message))?)
}

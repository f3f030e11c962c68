//! `tolerances`: the widest tolerances of the parameters at which the wanted share of points is still accepted, or conforms.

mod document;
mod goal;

use std::path::{Path, PathBuf};

use clap::Args;

use super::{
    asking::{self, Analysis, AnalysisResult, Delivery, PointSet, Takes},
    known,
};
use crate::{
    error::{Error, Result},
    options::Work,
    results::{summary::ParameterSummary, table},
    session::{Request, Session, absolute},
};
use goal::Goal;
use number_tables::files::FileError;
use parameter_regions::{
    robustness::stand::Stand,
    table::PointTable,
    tolerances::{
        Problem, Sample,
        stated::{Parameter, Tolerances},
    },
};
use point_journal::{PointOutcome, pipeline::Pipeline};
use result_document::format::number;
use sampling::{design::Joint, statistics::moments::mean};
use study::{
    Study,
    plan::{Input, Plan},
};

pub use document::document;

/// The result's file in a folder of results.
pub const FILE: &str = "tolerances.json";

/// Options of `tolerances`.
#[derive(Debug, Args)]
#[command(after_help = "Example: orchestrator tolerances studies/paper-table3.toml --from results/paper-table3")]
pub struct Options {
    /// The study, how its points are run, and where the results go
    #[command(flatten)]
    pub work: Work,
    /// The folder of the finished study, whose points are used first [default: --output, if it is there, or results/ and the study's name]
    #[arg(long, value_name = "DIR")]
    pub from: Option<PathBuf>,
    /// Points of each round of the search [default: `points` under `[tolerances]`, or 1024]
    #[arg(long, value_name = "N")]
    pub points: Option<u64>,
    /// Fresh runs that confirm the result [default: `confirm` under `[tolerances]`, or 1000]
    #[arg(long, value_name = "N")]
    pub confirm: Option<u64>,
    /// For an FMU whose runs are dear: at most N runs, those of other budgets in the folder included, which confirm what a surrogate
    /// of the finished study's points finds
    #[arg(long, value_name = "N", conflicts_with = "confirm")]
    pub budget: Option<u64>,
    /// The seed [default: the study's, or 1]
    #[arg(long, value_name = "S")]
    pub seed: Option<u64>,
}

/// Runs the command.
///
/// # Errors
/// When the options, the study or its points cannot be used.
pub fn run(options: &Options) -> Result<Delivery> {
    let path = &options.work.study;
    let said = &Study::read(path)?.tolerances;
    let mut analysis = Asked {
        from: absolute(&known::from(options.from.as_deref(), options.work.output.as_deref(), path)),
        points: options.points.or(said.points).unwrap_or(1024).max(16),
        confirm: options.confirm.or(said.confirm).unwrap_or(1000).max(1),
        by_surrogate: options.budget.is_some(),
        seed: options.seed.or(said.seed).unwrap_or(1),
    };
    let mut session = asking::open(&options.work, &analysis)?;
    let folder = options.work.folder();
    if let Some(runs) = options.budget {
        let account = session.account(&folder, (Asked::NAME, options.work.resuming.resume), runs)?;
        analysis.confirm = account.points();
        if analysis.confirm == 0 {
            return Err(account.too_few(account.of(1), ""));
        }
    }
    asking::run(session, &analysis, &options.work, folder)
}

/// A search by importance weights on known points, and by runs of its own.
#[derive(Debug)]
pub struct Asked {
    /// The folder of the finished study, if there is one.
    from: PathBuf,
    /// Points of a round.
    points: u64,
    /// Fresh runs that confirm the result.
    confirm: u64,
    /// Whether a surrogate takes the place of all other runs.
    by_surrogate: bool,
    seed: u64,
}

impl Analysis for Asked {
    const NAME: &'static str = "tolerances";

    type Source = Session;

    fn open(&self, request: Request) -> Result<Session> {
        asking::session(request, Takes { correlations: false, samples: true })
    }

    fn points(&self, session: &Session) -> Result<PointSet> {
        let known = self.by_surrogate || self.known(session)?.is_some();
        Ok(PointSet {
            seed: self.seed,
            // Rounds follow until the weights are sure enough.
            points: None,
            method: format!("rounds of {} points, {} to confirm", self.points, self.confirm),
            table: known.then(|| known::digest_of(&self.from)).transpose()?,
        })
    }

    fn check(&self, session: &Session) -> Result {
        let goal = Goal::new(&session.study, &session.judge, &self.from)?;
        self.problem(session, &goal).map(drop)
    }

    fn find(&self, session: &Session, pipeline: &mut Pipeline, _: &Path) -> Result<AnalysisResult> {
        let goal = Goal::new(&session.study, &session.judge, &self.from)?;
        let problem = self.problem(session, &goal)?;
        let stand = self.by_surrogate.then(|| self.stand(session)).transpose()?;
        if stand.is_some() {
            pipeline.repeat_at_most(1);
        }
        let mut runs = Runs { session, varied: of_points(&session.plan), pipeline, stand };
        let centre = runs.outcomes(&problem.centres())?;
        let at_centre = mean(&goal.goods(&centre));
        let mut told = Tolerances {
            wanted: goal.wanted,
            share: problem.target,
            confidence: problem.confidence,
            ..Tolerances::default()
        };
        let result = |told: &Tolerances| Ok(AnalysisResult::new(told, asking::origin(session)?, &document(told), FILE));
        if at_centre < problem.target {
            told.reasons.push(at_nothing(at_centre, centre.len()));
            return result(&told);
        }
        let (points, outcomes) = match self.known(session)?.filter(|_| runs.stand.is_none()) {
            Some(table) => runs.known(&table),
            None => {
                let points = problem.draw(&vec![1.0; problem.distributions.len()], self.seed);
                let outcomes = runs.outcomes(&points)?;
                (points, outcomes)
            }
        };
        let mut sample = Sample::new(&problem.distributions, points, goal.goods(&outcomes));
        let answer = problem.search(&mut sample, &mut |points: Vec<Vec<f64>>| runs.goods(&goal, &points))?;
        let stand = runs.stand.take();
        (told.points, told.rounds) = (sample.len() as u64, sample.rounds());
        told.surrogate = stand.and_then(|stand| Some(stand.qualities.first()?.points));
        told.parameters = parameters(&session.plan, &problem, &answer.scales, &answer.safe);
        told.widest = Some(answer.at_scales);
        told.stated = Some(answer.at_safe);
        told.confirmed = Some(problem.confirm(&answer.safe, |points| runs.goods(&goal, &points))?);
        result(&told)
    }
}

impl Asked {
    /// The points of the finished study, if they were drawn from the parameters' distributions.
    fn known(&self, session: &Session) -> Result<Option<PointTable>> {
        if !self.from.join("summary.json").exists() {
            return Ok(None);
        }
        let (summary, table) = table::read(&self.from)?;
        let drawn = summary.surrogate.is_none() && summary.provenance.method != "table";
        let same_files = session.study.digest() == summary.provenance.study_sha256;
        let same_files = same_files && summary.provenance.fmu_sha256 == Some(session.package.digest()?);
        Ok((drawn && same_files && !table.is_empty()).then_some(table))
    }

    /// A surrogate of the finished study's points, however they were chosen.
    fn stand(&self, session: &Session) -> Result<Stand> {
        let (_, table) = known::points_of(&self.from, &session.study)?;
        Stand::fit(&table).ok_or_else(|| {
            let study = session.study.path().display();
            let message = format!(
                "the points are too few for a surrogate: `orchestrator verify {study} --points 100` makes more"
            );
            Error::option("budget", message)
        })
    }

    fn problem(&self, session: &Session, goal: &Goal) -> Result<Problem> {
        let Session { study, plan, .. } = session;
        let with_tolerances = plan.with_tolerances();
        if with_tolerances.is_empty() {
            return Err(study
                .error("no parameter has a tolerance: those that vary come from samples, which stay as they are")
                .into());
        }
        let inputs = || with_tolerances.iter().map(|&k| &plan.inputs[k]);
        let problem = Problem {
            distributions: inputs().map(|input| input.distribution.clone()).collect(),
            samples: plan.joints.clone(),
            costs: costs(study, plan)?,
            target: goal.target,
            confidence: goal.confidence,
            limit: limit(study)?,
            points: self.points,
            confirm: self.confirm,
            seed: self.seed,
        };
        problem.check().map_err(|message| study.error_in("tolerances", &["points"], message))?;
        Ok(problem)
    }
}

/// Why no tolerances would do: what is left with all of them at nothing, one point, or one for each of some rows of the samples.
fn at_nothing(share: f64, points: usize) -> String {
    format!(
        "with all tolerances at nothing, {} % of {points} point{} conform as wanted, and only a spread would bring some more: shift \
         a parameter's nominal value, or measure better",
        number(100.0 * share, 3),
        if points == 1 { "" } else { "s" }
    )
}

/// The places among the inputs of the numbers of a point: those with tolerances, then those from samples.
fn of_points(plan: &Plan) -> Vec<usize> {
    plan.with_tolerances().into_iter().chain(plan.joints.iter().flat_map(Joint::inputs).copied()).collect()
}

/// Relative cost of a narrower tolerance, for each parameter that has one.
fn costs(study: &Study, plan: &Plan) -> Result<Vec<f64>, FileError> {
    let varied: Vec<&str> = plan.with_tolerances().iter().map(|&k| plan.inputs[k].name.as_str()).collect();
    for (name, cost) in &study.tolerances.costs {
        if !varied.contains(&name.as_ref().as_str()) {
            return Err(study.error_at(name, format!(
                "no parameter `{}` has a tolerance; name one under [parameters] that varies and comes from no sample",
                name.as_ref()
            )));
        }
        if !(*cost.as_ref() > 0.0 && cost.as_ref().is_finite()) {
            return Err(study.error_at(cost, "a cost must be a positive, finite number"));
        }
    }
    Ok(varied.iter().map(|name| study.tolerances.costs.get(*name).map_or(1.0, |cost| *cost.as_ref())).collect())
}

fn limit(study: &Study) -> Result<f64, FileError> {
    const USUAL: f64 = 3.0;
    match &study.tolerances.limit {
        Some(limit) if !(*limit.as_ref() > 0.0 && limit.as_ref().is_finite()) => {
            Err(study.error_at(limit, "the limit must be a positive, finite number"))
        }
        limit => Ok(limit.as_ref().map_or(USUAL, |limit| *limit.as_ref())),
    }
}

/// The tolerances of the answer in the study's own terms.
fn parameters(plan: &Plan, problem: &Problem, scales: &[f64], safe: &[f64]) -> Vec<Parameter> {
    let with_tolerances = plan.with_tolerances();
    let scaled = |input: &Input, scale: f64| {
        ParameterSummary::new(&Input { distribution: input.distribution.scaled(scale), ..input.clone() })
    };
    with_tolerances
        .iter()
        .enumerate()
        .map(|(k, &number)| {
            let input = &plan.inputs[number];
            Parameter {
                name: input.name.clone(),
                unit: input.unit.clone(),
                cost: problem.costs[k],
                own: words(&scaled(input, 1.0)),
                widest_scale: scales[k],
                widest: words(&scaled(input, scales[k])),
                scale: safe[k],
                stated: words(&scaled(input, safe[k])),
                distribution: scaled(input, safe[k]).distribution.into_iter().collect(),
                limited: scales[k] >= 0.999 * problem.limit,
            }
        })
        .collect()
}

/// A distribution as words, with numbers of as many digits as people need.
fn words(parameter: &ParameterSummary) -> String {
    let mut rounded = parameter.clone();
    for value in rounded.distribution.values_mut() {
        if let Some(exact) = value.as_f64() {
            *value = number(exact, 4).into();
        }
    }
    let words = rounded
        .distribution
        .iter()
        .filter_map(|(key, value)| {
            let value = value.as_str()?;
            Some(if key == "distribution" { value.to_owned() } else { format!("{key} {value}") })
        })
        .collect::<Vec<_>>()
        .join(", ");
    match &parameter.unit {
        Some(unit) => format!("{words} {unit}"),
        None => words,
    }
}

/// Points of the parameters that vary, run through the pipeline, or by a surrogate.
struct Runs<'a, 'b> {
    session: &'a Session,
    /// The places among the inputs of the numbers of a point.
    varied: Vec<usize>,
    pipeline: &'a mut Pipeline<'b>,
    stand: Option<Stand>,
}

impl Runs<'_, '_> {
    /// The results of points; none for those that fail.
    fn outcomes(&mut self, points: &[Vec<f64>]) -> Result<Vec<Option<Vec<f64>>>> {
        let inputs = &self.session.plan.inputs;
        let full = |point: &Vec<f64>| -> Vec<f64> {
            let mut all: Vec<f64> = inputs.iter().map(|input| input.distribution.centre()).collect();
            self.varied.iter().zip(point).for_each(|(&k, &value)| all[k] = value);
            all
        };
        let full: Vec<Vec<f64>> = points.iter().map(full).collect();
        if let Some(stand) = &self.stand {
            return Ok(stand.values(&full).into_iter().map(Some).collect());
        }
        let outcomes: Vec<PointOutcome> = self.pipeline.ask(&full)?;
        Ok(outcomes.into_iter().map(Result::ok).collect())
    }

    /// How good the outcomes of points are.
    fn goods(&mut self, goal: &Goal, points: &[Vec<f64>]) -> Result<Vec<f64>> {
        Ok(goal.goods(&self.outcomes(points)?))
    }

    /// The points of a finished study, with what came of them; more would only cost time.
    fn known(&self, table: &PointTable) -> (Vec<Vec<f64>>, Vec<Option<Vec<f64>>>) {
        const MOST: usize = 20_000;
        let count = table.len().min(MOST);
        (
            (0..count).map(|i| self.varied.iter().map(|&k| table.parameters[k].values[i]).collect()).collect(),
            (0..count)
                .map(|i| {
                    let values = table.criteria.iter().map(|criterion| criterion.values[i]);
                    table.completed(i).then(|| values.collect())
                })
                .collect(),
        )
    }
}

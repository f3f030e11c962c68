//! `robustness`: how far the parameters may go.

mod confirm;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use serde::{Deserialize, Serialize};

use super::CommandError;
use super::asking::{self, Analysis, PointSet};
use super::finding::{self, AnalysisResult};
use crate::cli;
use crate::pipeline::Pipeline;
use crate::report::format::{number, percent};
use crate::report::robustness as page;
use crate::results::origin::Origin;
use crate::session::Session;
use crate::study::Study;
use crate::study::plan::Plan;
use confirm::Confirmation;
use parameter_regions::robustness::region::Domain;
use parameter_regions::robustness::{Robustness, region, robustness, rows};
use parameter_regions::table::PointTable;
use sampling::design::{Design, Method, Sampling, cube};

pub(super) const NAME: &str = "robustness";

pub(super) fn run(options: &cli::Robustness) -> Result<ExitCode, CommandError> {
    let cli::Work {
        study: path,
        parts,
        output,
        ..
    } = &options.work;
    let from = options.from.clone();
    let from = from.unwrap_or_else(|| finding::folder_of(path));
    let study = Study::read(path)?;
    let said = &study.robustness;
    let analysis = Stated {
        from: std::path::absolute(&from).unwrap_or_else(|_| from.clone()),
        level: level(options, &study)?,
        confirm: options.confirm.or(said.confirm).unwrap_or(0),
        seed: options.seed.or(said.seed).unwrap_or(1),
    };
    let session = asking::open(&options.work, &analysis);
    let shard = asking::shard(parts)?;
    let own = shard.map(|_| asking::folder(None, path, parts, Some(NAME)));
    let own = own.transpose()?;
    let folder = output.clone().or(own).unwrap_or(from);
    if analysis.confirm > 0 {
        return asking::run(session?, &analysis, &options.work, &folder);
    }
    if shard.is_some() || parts.resume {
        let message = "without new runs there is nothing to resume or to share; add --confirm N";
        return Err(option("confirm", message));
    }
    asking::check(&options.work, &folder)?;
    // Without the FMU there are no new runs, but all else can be told, unless it takes what binds the study's parameters.
    let session = match session {
        Err(error) if !study.correlations.is_empty() || study.binds_by_samples() => {
            return Err(error);
        }
        other => other.ok(),
    };
    let plan = session.as_ref().map(|session| &session.plan);
    let (origin, points, cloud) = analysis.known(&study, plan)?;
    let mut result = analysis.stated(&points, &cloud)?;
    if let Some(plan) = plan {
        result.keep_together(&plan.together());
    }
    let text = text(&result);
    AnalysisResult::new(&result, origin, text, page::FILE)?.tell(&folder)
}

/// The probability that box and ellipsoid must hold.
fn level(options: &cli::Robustness, study: &Study) -> Result<f64, CommandError> {
    const MESSAGE: &str = "must lie between 0 and 1";
    let inside = |level: f64| level > 0.0 && level < 1.0;
    match (options.level, &study.robustness.level) {
        (Some(level), _) if !inside(level) => Err(option("level", MESSAGE)),
        (Some(level), _) => Ok(level),
        (None, Some(level)) if !inside(*level.as_ref()) => {
            Err(study.error_at(level, format!("level {MESSAGE}")).into())
        }
        (None, Some(level)) => Ok(*level.as_ref()),
        (None, None) => Ok(0.9),
    }
}

fn option(option: &'static str, message: &str) -> CommandError {
    CommandError::Option {
        option,
        message: message.to_owned(),
    }
}

/// Statements from the points of a finished study, confirmed by new runs if wanted.
#[derive(Debug, Serialize, Deserialize)]
struct Stated {
    /// The folder of the finished study.
    from: PathBuf,
    /// The verification probability that box and ellipsoid must hold.
    level: f64,
    /// New runs in each.
    confirm: usize,
    seed: u64,
}

pub(super) fn kept(options: serde_json::Value) -> serde_json::Result<Box<dyn Analysis>> {
    Ok(Box::new(serde_json::from_value::<Stated>(options)?))
}

impl Stated {
    /// The points of the finished study, to which results they belong, and a large sample of its distributions.
    fn known(
        &self,
        study: &Study,
        plan: Option<&Plan>,
    ) -> Result<(Origin, PointTable, Vec<Vec<f64>>), CommandError> {
        let (summary, table) = finding::points_of(&self.from, study)?;
        let cloud = cloud(plan, &table, self.seed)?;
        Ok((Origin::of_points(&summary), table, cloud))
    }

    fn stated(&self, table: &PointTable, cloud: &[Vec<f64>]) -> Result<Robustness, CommandError> {
        robustness(table, cloud, self.level).ok_or_else(|| {
            option(
                "from",
                "the points are too few for a surrogate, or no parameter varies: verify more points",
            )
        })
    }
}

impl Analysis for Stated {
    fn name(&self) -> &'static str {
        NAME
    }

    fn options(&self) -> serde_json::Value {
        serde_json::json!(self)
    }

    fn points(&self, _: &Session) -> Result<PointSet, CommandError> {
        Ok(PointSet {
            seed: self.seed,
            // Further rounds follow where a statement does not hold.
            points: None,
            method: format!("{} runs to confirm the level {}", self.confirm, self.level),
            table: Some(finding::digest_of(&self.from)?),
        })
    }

    fn takes_correlations(&self) -> bool {
        true
    }

    fn takes_samples(&self) -> bool {
        true
    }

    fn find(
        &self,
        session: &Session,
        pipeline: &mut Pipeline<'_>,
        _: &Path,
    ) -> Result<AnalysisResult, CommandError> {
        let (origin, table, cloud) = self.known(&session.study, Some(&session.plan))?;
        let stated = self.stated(&table, &cloud)?;
        let mut confirmed = Confirmation {
            session,
            pipeline,
            table: &table,
            cloud: &cloud,
            points: self.confirm,
            seed: self.seed,
        }
        .of(stated)?;
        confirmed.keep_together(&session.plan.together());
        AnalysisResult::new(&confirmed, origin, text(&confirmed), page::FILE)
    }
}

/// A large sample from the study's distributions, in the order of the table's parameters; from the
/// points themselves where the FMU is not there to convert units.
fn cloud(
    plan: Option<&Plan>,
    table: &PointTable,
    seed: u64,
) -> Result<Vec<Vec<f64>>, CommandError> {
    const SIZE: u64 = 65_536;
    let own = || table.parameters.iter().map(|p| &p.name);
    match plan {
        Some(plan) if plan.inputs.iter().map(|i| &i.name).eq(own()) && !plan.is_independent() => {
            let points = joint(plan, SIZE, seed).map_err(|m| option("seed", &m))?;
            Ok((0..SIZE).map(|index| points.point(index)).collect())
        }
        Some(plan) if plan.inputs.iter().map(|i| &i.name).eq(own()) => {
            let cube = cube(plan.varied().len(), SIZE, seed, 1).map_err(|m| option("seed", &m))?;
            Ok(cube.iter().map(|u| plan.from_cube(u)).collect())
        }
        _ => Ok(region::cloud(&rows(table), seed)),
    }
}

/// Independent points of the study's joint distribution, correlations included.
fn joint(plan: &Plan, points: u64, seed: u64) -> Result<Design, String> {
    plan.design(&Sampling {
        method: Method::MonteCarlo,
        points,
        seed,
        ..Sampling::default()
    })
}

/// What is stated of a region, whether it comes to the level, and how the study's points and fresh runs compare with it.
fn evidence<S>(level: f64, of: &Domain<S>) -> String {
    let claim = if of.interval[0] >= level {
        "shown to be"
    } else {
        "NOT shown to be"
    };
    let own = of.confirmed;
    let mut out = format!(
        "  takes {} of the sampled space; verification probability {} (95 % interval {} to {}): {claim} {level} or more\n  by the \
         surrogates and the study's own points, of which {} lie inside, {} verified\n",
        number(of.share, 3),
        number(of.probability, 3),
        number(of.interval[0], 3),
        number(of.interval[1], 3),
        own.points,
        own.verified
    );
    if let Some(c) = of.fresh {
        out += &format!(
            "  {} fresh runs inside: {} verified, 95 % interval {} to {}: {}\n",
            c.points,
            c.verified,
            number(c.interval[0], 3),
            number(c.interval[1], 3),
            c.on(of.interval)
        );
    }
    out
}

fn text(result: &Robustness) -> String {
    let mut out = format!(
        "{}\n\nsurrogates, by leave-one-out",
        result.answer.words(result.shown())
    );
    if result.further_runs > 0 {
        let further = result.further_runs;
        out += &format!(" (refined with {further} further runs in box and ellipsoid)");
    }
    out.push('\n');
    for (name, q) in &result.criteria {
        out += &format!(
            "  {name}: degree {}, {} terms, error {}, predicts {} % of the variance\n",
            q.degree,
            q.terms,
            number(q.error, 2),
            number(100.0 * q.predicted, 4)
        );
    }
    if !result.margins.is_empty() {
        out += "\nfrom the best point, one parameter at a time\n";
    }
    let end = |(value, lost): &(f64, Option<String>)| match lost {
        Some(name) => format!("{} ({name})", number(*value, 5)),
        None => format!("{} (sampled no further)", number(*value, 5)),
    };
    for m in &result.margins {
        out += &format!(
            "  {} = {} {}: {} .. {}\n",
            m.parameter,
            number(m.value, 5),
            result.unit(&m.parameter),
            end(&m.low),
            end(&m.high)
        );
    }
    if let Some(region) = &result.region {
        out += "\nlargest box found\n";
        for ((name, unit), [low, high]) in result
            .parameters
            .iter()
            .zip(&result.units)
            .zip(&region.limits)
        {
            out += &format!(
                "  {name}: {} .. {} {unit}\n",
                number(*low, 5),
                number(*high, 5)
            );
        }
        out += &evidence(result.level, region);
    }
    if let Some(ellipsoid) = &result.ellipsoid {
        out += "\nlargest ellipsoid found\n";
        out += &evidence(result.level, ellipsoid);
    }
    if !result.unsafe_combinations.is_empty() {
        out += "\nunsafe: hardly any point is verified, whatever the other parameters are\n";
    }
    for c in &result.unsafe_combinations {
        out += &format!(
            "  {}: {} % of the sampled space, probability {}, {} is lost; of the study's own points {} of {} verified\n",
            page::bounds(result, c),
            percent(c.share),
            number(c.probability, 2),
            c.lost,
            c.confirmed.verified,
            c.confirmed.points
        );
    }
    for warning in &result.warnings {
        out += &format!("note: {warning}\n");
    }
    out
}

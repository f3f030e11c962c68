//! `robustness`: how far the parameters may go.

mod confirm;

use std::process::ExitCode;

use super::batch::{self, Batch};
use super::{CommandError, finding};
use crate::analysis::robustness::region::Confirmed;
use crate::analysis::robustness::{Robustness, region, robustness, rows};
use crate::analysis::table::PointTable;
use crate::cli;
use crate::report::format::{number, percent};
use crate::report::robustness as page;
use crate::results::origin::Origin;
use confirm::Confirmation;

pub(super) fn run(options: &cli::Robustness) -> Result<ExitCode, CommandError> {
    let folder = options
        .from
        .clone()
        .unwrap_or_else(|| finding::folder_of(&options.study));
    let (summary, table) = finding::points_of(&folder, &options.study)?;
    if !(options.level > 0.0 && options.level < 1.0) {
        return Err(option("level", "must lie between 0 and 1"));
    }
    let batch = Batch::new(&options.study, &options.means);
    let batch = match batch {
        Err(error) if options.confirm > 0 => return Err(error),
        // Without the FMU there are no new runs, but all else can be told.
        other => other.ok(),
    };
    let cloud = cloud(batch.as_ref(), &table, options.seed)?;
    let mut result = robustness(&table, &cloud, options.level).ok_or_else(|| {
        option(
            "from",
            "the points are too few for a surrogate, or no parameter varies: verify more points",
        )
    })?;
    if let (Some(batch), points @ 1..) = (&batch, options.confirm) {
        result = Confirmation {
            batch,
            table: &table,
            cloud: &cloud,
            points,
            seed: options.seed,
        }
        .of(result)?;
    }
    let target = options.output.clone().unwrap_or_else(|| folder.clone());
    let origin = Origin::of_points(&summary);
    finding::tell(&result, &origin, &text(&result), &target, page::FILE)
}

fn option(option: &'static str, message: &str) -> CommandError {
    CommandError::Option {
        option,
        message: message.to_owned(),
    }
}

/// A large sample from the study's distributions, in the order of the table's parameters; from the
/// points themselves where the FMU is not there to convert units.
fn cloud(
    batch: Option<&Batch>,
    table: &PointTable,
    seed: u64,
) -> Result<Vec<Vec<f64>>, CommandError> {
    const SIZE: u64 = 32_768;
    let names = |batch: &Batch| {
        batch
            .plan
            .inputs
            .iter()
            .map(|i| i.name.clone())
            .collect::<Vec<_>>()
    };
    let own: Vec<String> = table.parameters.iter().map(|p| p.name.clone()).collect();
    match batch {
        Some(batch) if names(batch) == own => {
            let cube =
                batch::cube(batch.varied().len(), SIZE, seed, 1).map_err(|m| option("seed", &m))?;
            Ok(cube.iter().map(|u| batch.parameters(u)).collect())
        }
        _ => Ok(region::cloud(&rows(table), seed)),
    }
}

/// What runs of the model say of a stated probability.
fn evidence(stated: f64, own: Confirmed, fresh: Option<Confirmed>) -> String {
    let mut out = format!(
        "  of the study's own points {} lie inside, {} verified\n",
        own.points, own.verified
    );
    if let Some(c) = fresh {
        out += &format!(
            "  {} fresh runs inside: {} verified, 95 % interval {} to {}: {}\n",
            c.points,
            c.verified,
            number(c.interval[0], 3),
            number(c.interval[1], 3),
            c.on(stated)
        );
    }
    out
}

fn text(result: &Robustness) -> String {
    let mut out = String::from("surrogates, by leave-one-out");
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
    out += "\nfrom the best point, one parameter at a time\n";
    let end = |(value, lost): &(f64, Option<String>)| match lost {
        Some(name) => format!("{} ({name})", number(*value, 5)),
        None => format!("{} (sampled no further)", number(*value, 5)),
    };
    for (m, unit) in result.margins.iter().zip(&result.units) {
        out += &format!(
            "  {} = {} {unit}: {} .. {}\n",
            m.parameter,
            number(m.value, 5),
            end(&m.low),
            end(&m.high)
        );
    }
    if let Some(region) = &result.region {
        out += &format!(
            "\nlargest box with a verification probability of {} or more: {} of the sampled space, probability {}\n",
            result.level,
            number(region.share, 3),
            number(region.probability, 3)
        );
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
        out += &evidence(region.probability, region.confirmed, region.fresh);
    }
    if let Some(e) = &result.ellipsoid {
        out += &format!(
            "\nlargest ellipsoid: {} of the sampled space, probability {}\n",
            number(e.share, 3),
            number(e.probability, 3)
        );
        out += &evidence(e.probability, e.confirmed, e.fresh);
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

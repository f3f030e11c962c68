//! `robustness`: how far the parameters may go.

use std::path::PathBuf;
use std::process::ExitCode;

use super::batch::{self, Batch};
use super::{CommandError, output};
use crate::analysis::from_results;
use crate::analysis::robustness::{Robustness, region, robustness, rows};
use crate::analysis::table::PointTable;
use crate::cli;
use crate::report::format::number;
use crate::report::{Report, robustness as page};
use crate::results::{ResultsError, write_atomically};

pub(super) fn run(options: &cli::Robustness) -> Result<ExitCode, CommandError> {
    let folder = options.from.clone().unwrap_or_else(|| {
        let stem = options.study.file_stem().unwrap_or("study".as_ref());
        PathBuf::from("results").join(stem)
    });
    let (_, table) = from_results::read(&folder)?;
    if !(options.level > 0.0 && options.level < 1.0) {
        return Err(option("level", "must lie between 0 and 1"));
    }
    let mut batch = Batch::new(&options.study, options.fmu.as_deref(), options.jobs).ok();
    let cloud = cloud(batch.as_ref(), &table, options.seed)?;
    let result = robustness(&table, &cloud, options.level).ok_or_else(|| {
        option(
            "from",
            "the points are too few for a surrogate, or no parameter varies: verify more points",
        )
    })?;
    let confirmed = match (&mut batch, options.confirm) {
        (_, 0) => String::new(),
        (Some(batch), points) => confirm(batch, &table, &result, &cloud, points)?,
        (None, _) => return Err(option("confirm", "needs the study's FMU for new runs")),
    };
    let target = options.output.clone().unwrap_or_else(|| folder.clone());
    std::fs::create_dir_all(&target).map_err(ResultsError::io(&target))?;
    write_atomically(&target.join(page::FILE), |out| {
        serde_json::to_writer(&mut *out, &result)?;
        writeln!(out)
    })?;
    if target.join("summary.json").exists() {
        Report::from_folder(&target)?.write(&target)?;
    }
    output::print(&format!(
        "{}{confirmed}\nresults in {}\n",
        text(&result),
        target.display()
    ));
    Ok(ExitCode::SUCCESS)
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
    const SIZE: u64 = 16_384;
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

/// Runs the model at fresh points inside the box.
fn confirm(
    batch: &mut Batch,
    table: &PointTable,
    result: &Robustness,
    cloud: &[Vec<f64>],
    points: usize,
) -> Result<String, CommandError> {
    let Some(region) = &result.region else {
        return Ok(String::new());
    };
    let places: Vec<usize> = (0..table.parameters.len())
        .filter(|&k| result.parameters.contains(&table.parameters[k].name))
        .collect();
    let inside = |x: &&Vec<f64>| region.contains(&places.iter().map(|&k| x[k]).collect::<Vec<_>>());
    let chosen: Vec<Vec<f64>> = cloud.iter().filter(inside).take(points).cloned().collect();
    let outcomes = batch.run(&chosen)?;
    let verified = outcomes
        .iter()
        .filter(|o| batch.judge.verdict(o.as_deref().ok()).verified())
        .count();
    let share = crate::analysis::verdict::Fraction::wilson(verified, chosen.len());
    Ok(format!(
        "box, {} fresh runs: {verified} verified, {} (95 % interval {} to {})\n",
        chosen.len(),
        number(share.value(), 3),
        number(share.low, 3),
        number(share.high, 3)
    ))
}

fn text(result: &Robustness) -> String {
    let mut out = String::from("surrogates, by leave-one-out\n");
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
        let c = region.confirmed;
        out += &format!(
            "  of the study's own points {} lie inside, {} verified\n",
            c.points, c.verified
        );
    }
    if let Some(e) = &result.ellipsoid {
        out += &format!(
            "largest ellipsoid: {} of the sampled space, probability {}\n",
            number(e.share, 3),
            number(e.probability, 3)
        );
    }
    for warning in &result.warnings {
        out += &format!("note: {warning}\n");
    }
    out
}

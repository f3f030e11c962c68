//! The band of the verified points beside a measured curve: some of them are run once more, for the picture alone.

use std::path::Path;
use std::time::{Duration, Instant};

use super::CommandError;
use crate::engine::process::Limits;
use crate::engine::single::Recorder;
use crate::engine::working_directory;
use crate::pipeline::stop;
use crate::results::Summary;
use crate::study::plan::Plan;
use crate::table::csv_file;
use crate::task::MeasuredCurve;
use curves::Sampler;
use fmu_import::{Handle, Package, Value};

/// So many points for each of the extra runs that are allowed.
const EACH: usize = 5;
/// They take no more than this part of the study's time, but may take [`PATIENCE`].
const PART: f64 = 0.1;
const PATIENCE: Duration = Duration::from_secs(5);

/// The least and the largest value of the verified points at the times of each criterion's measured curve.
#[derive(Debug, Default)]
pub(super) struct Bands {
    /// How many points were run.
    pub(super) points: usize,
    /// By criterion; none where it has no curve.
    pub(super) of: Vec<Option<[Vec<f64>; 2]>>,
}

/// Runs verified points, evenly chosen among all. `most` are the extra runs that are allowed. What fails is left out: the
/// picture lacks a band then, and the verdict nothing.
pub(super) fn found(
    folder: &Path,
    plan: &Plan,
    package: &mut Package,
    summary: &Summary,
    most: usize,
    limits: Limits,
) -> Bands {
    let has_curve = plan.probes().any(|probe| probe.curve.is_some());
    let most = (EACH * most) as u64;
    if !has_curve || summary.verified == 0 || most == 0 {
        return Bands::default();
    }
    let chosen = chosen(folder, plan.inputs.len(), summary.verified, most);
    run(plan, package, summary, &chosen.unwrap_or_default(), limits).unwrap_or_default()
}

/// The parameters of verified points, evenly chosen.
fn chosen(folder: &Path, inputs: usize, verified: u64, most: u64) -> csv::Result<Vec<Vec<f64>>> {
    let mut table = csv::Reader::from_path(folder.join("points.csv"))?;
    let header = table.headers()?.clone();
    let place = header
        .iter()
        .position(|name| csv_file::text(name) == "verified");
    let Some(place) = place else {
        return Ok(Vec::new());
    };
    let every = verified.div_ceil(most);
    let mut points = Vec::new();
    let mut seen = 0;
    for record in table.records() {
        let record = record?;
        if record.get(place) != Some("true") {
            continue;
        }
        if seen % every == 0 {
            let cells = record.iter().skip(1).take(inputs);
            points.extend(
                cells
                    .map(|cell| cell.parse().ok())
                    .collect::<Option<Vec<f64>>>(),
            );
        }
        seen += 1;
    }
    Ok(points)
}

fn run(
    plan: &Plan,
    package: &mut Package,
    summary: &Summary,
    points: &[Vec<f64>],
    limits: Limits,
) -> Result<Bands, CommandError> {
    let begun = Instant::now();
    let study = summary.run.as_ref().map_or(0.0, |run| run.wall_seconds);
    let patience = PATIENCE.max(Duration::from_secs_f64(PART * study.max(0.0)));
    let scratch = stop::scratch()?;
    let fmu = package.unpack(scratch.path())?;
    let tasks = plan.cases.iter().map(|case| &case.task);
    let recorder = Recorder {
        fmu: &fmu,
        name: package.path(),
        home: working_directory::home(scratch.path(), package.description(), tasks),
        limits,
        echo: false,
    };
    let mut bands = Bands {
        points: 0,
        of: vec![None; plan.probes().count()],
    };
    for point in points {
        if begun.elapsed() > patience {
            break;
        }
        if let Some(signals) = signals(plan, &recorder, point) {
            bands.points += 1;
            for (criterion, values) in signals {
                widen(&mut bands.of[criterion], values);
            }
        }
    }
    Ok(bands)
}

fn widen(band: &mut Option<[Vec<f64>; 2]>, values: Vec<f64>) {
    let Some([low, high]) = band else {
        *band = Some([values.clone(), values]);
        return;
    };
    for ((low, high), value) in low.iter_mut().zip(high).zip(values) {
        (*low, *high) = (low.min(value), high.max(value));
    }
}

/// A point's signals at the times of the measured curves, by the numbers of their criteria; none where a run fails.
fn signals(plan: &Plan, recorder: &Recorder<'_>, point: &[f64]) -> Option<Vec<(usize, Vec<f64>)>> {
    let mut start = Vec::new();
    plan.to_fmu(point, &mut start);
    let mut signals = Vec::new();
    for number in 0..plan.cases.len() {
        let (first, task) = (plan.criteria_of(number).start, &plan.cases[number].task);
        let probes = task.observed.iter().enumerate();
        let curves: Vec<(usize, Handle, &MeasuredCurve)> = probes
            .filter_map(|(k, probe)| Some((first + k, probe.handle, probe.curve.as_deref()?)))
            .collect();
        if curves.is_empty() {
            continue;
        }
        let sampler = |curve: &MeasuredCurve| Sampler::new(curve.shown_times().collect());
        let mut samplers: Vec<Sampler> = curves.iter().map(|(.., curve)| sampler(curve)).collect();
        let columns: Vec<Handle> = curves.iter().map(|(_, handle, _)| *handle).collect();
        let recorded = recorder.record(task, &start, &columns, |time, row| {
            for (value, sampler) in row.iter().zip(&mut samplers) {
                if let Value::Real(value) = value {
                    sampler.add(time, *value);
                }
            }
            Ok::<_, CommandError>(())
        });
        recorded.ok()?;
        for ((criterion, _, curve), sampler) in curves.iter().zip(&mut samplers) {
            let values = sampler.finish().ok()?.iter();
            let values: Vec<f64> = values.map(|v| curve.factor * v + curve.offset).collect();
            signals.push((*criterion, values));
        }
    }
    Some(signals)
}

//! Measured curves beside the results, each with the band of the verified points: some of them are run once more, for the
//! picture alone.

use std::fs;
use std::path::Path;

use super::{Halt, Reruns};
use crate::report::history;
use crate::results::Summary;
use curves::Sampler;
use fmu_points::task::MeasuredCurve;
use number_tables::csv_file;
use point_journal::files::write_table;

/// So many points for each of those that are run once more to see whether they had settled.
const EACH: usize = 5;

/// The least and the largest value of the verified points at the times of a measured curve.
type Band = [Vec<f64>; 2];

/// Writes the measured curves, where there are any, and returns a sentence on those left out. A curve whose runs fail is
/// left out: its picture then lacks the band, the verdict does not change.
pub(super) fn write(reruns: &Reruns<'_>, folder: &Path, summary: &Summary) -> Option<String> {
    let path = folder.join(history::MEASURED);
    let probes = || reruns.plan().probes().enumerate();
    if probes().all(|(_, probe)| probe.curve.is_none()) {
        // An earlier run may have left one.
        let _ = fs::remove_file(&path);
        return None;
    }
    let mut left_out = None;
    let mut bands: Vec<Option<Band>> = vec![None; summary.criteria.len()];
    let mut points = 0;
    let most = (EACH * reruns.wish.most) as u64;
    if summary.verified > 0 && most > 0 {
        let inputs = reruns.plan().inputs.len();
        let chosen = chosen(folder, inputs, summary.verified, most).unwrap_or_default();
        for point in &chosen {
            match signals(reruns, point) {
                Ok(signals) => {
                    points += 1;
                    for (criterion, values) in signals {
                        widen(&mut bands[criterion], values);
                    }
                }
                Err(Halt::Late) => {
                    left_out = Some(format!(
                        "the band beside the measured curves is that of {points} of {} {} points",
                        chosen.len(),
                        summary.met()
                    ));
                    break;
                }
                Err(Halt::Failed(_)) => {}
            }
        }
    }
    let written = write_table(&path, history::MEASURED_COLUMNS, |table| {
        for ((k, probe), name) in probes().zip(summary.criteria.keys()) {
            let Some(curve) = &probe.curve else { continue };
            let band = bands[k].as_ref();
            let times = curve.shown_times().zip(&curve.values);
            for (row, (time, value)) in times.enumerate() {
                let text = |number: Option<&f64>| number.map_or_else(String::new, f64::to_string);
                let [low, high] = [0, 1].map(|side| band.and_then(|band| band[side].get(row)));
                table.write_record([
                    &*csv_file::cell(name),
                    &time.to_string(),
                    &value.to_string(),
                    &text(curve.expanded(row).as_ref()),
                    &text(low),
                    &text(high),
                    &band.map_or_else(String::new, |_| points.to_string()),
                ])?;
            }
        }
        Ok(())
    });
    written.err().map_or(left_out, |error| Some(error.to_string()))
}

/// The parameters of verified points, evenly chosen.
fn chosen(folder: &Path, inputs: usize, verified: u64, most: u64) -> csv::Result<Vec<Vec<f64>>> {
    let mut table = csv::Reader::from_path(folder.join("points.csv"))?;
    let header = table.headers()?.clone();
    let place = header.iter().position(|name| csv_file::text(name) == "verified");
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
            points.extend(cells.map(|cell| cell.parse().ok()).collect::<Option<Vec<f64>>>());
        }
        seen += 1;
    }
    Ok(points)
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

/// A point's signals at the times of the measured curves, by the numbers of their criteria.
fn signals(reruns: &Reruns<'_>, point: &[f64]) -> Result<Vec<(usize, Vec<f64>)>, Halt> {
    let plan = reruns.plan();
    let mut start = Vec::new();
    plan.to_fmu(point, &mut start);
    let mut curves_of_point = Vec::new();
    for (number, case) in plan.cases.iter().enumerate() {
        let first = plan.criteria_of(number).start;
        let curve = |criterion: usize| case.task.observed[criterion - first].curve.as_deref();
        let signals = reruns.signals(number, |criterion| curve(criterion).is_some());
        let curves: Vec<&MeasuredCurve> = signals.criteria.iter().filter_map(|&k| curve(k)).collect();
        if curves.is_empty() {
            continue;
        }
        let sampler = |curve: &&MeasuredCurve| Sampler::new(curve.shown_times().collect());
        let mut samplers: Vec<Sampler> = curves.iter().map(sampler).collect();
        reruns.record(None, &case.task, &start, &signals, &reruns.budget, &mut |time, row| {
            for (&value, sampler) in row.iter().zip(&mut samplers) {
                sampler.add(time, value);
            }
            Ok(())
        })?;
        for ((&criterion, curve), sampler) in signals.criteria.iter().zip(curves).zip(&mut samplers) {
            let values = sampler.finish().map_err(|_| Halt::Failed("it is too short".to_owned()))?;
            let values = values.iter().map(|v| curve.factor * v + curve.offset);
            curves_of_point.push((criterion, values.collect()));
        }
    }
    Ok(curves_of_point)
}

//! The page's part on sensitivity: bars with intervals, an output each.

use super::format::{escape, number};
use crate::analysis::sensitivity::study::{Output, Sensitivity};
use parameter_regions::table::PointTable;
use sensitivity::Estimate;
use sensitivity::method::Measure;
use serde::Serialize;
use std::fmt::Write as _;

/// The result's file in a folder of results.
pub const FILE: &str = "sensitivity.json";

/// Values that the template shows.
#[derive(Serialize)]
pub struct View {
    method: String,
    warnings: Vec<String>,
    outputs: Vec<OutputView>,
    verdict: Vec<[String; 5]>,
}

#[derive(Serialize)]
struct OutputView {
    name: String,
    svg: String,
    note: String,
    heads: Vec<String>,
    rows: Vec<(String, Vec<String>)>,
}

/// Prepares a result for the template; `table` knows the parameters' units.
pub fn view(result: &Sensitivity, table: &PointTable) -> View {
    let split = |(name, s): (&String, &::sensitivity::regional::Split)| {
        let known = table.parameters.iter().find(|p| p.name == *name);
        let unit = known.map_or("", |p| p.unit.as_str());
        let with_unit = |value| format!("{} {unit}", number(value, 5)).trim_end().to_owned();
        [
            name.clone(),
            number(s.distance, 3),
            number(s.chance, 2),
            with_unit(s.passing),
            with_unit(s.failing),
        ]
    };
    View {
        method: format!("{}.", result.method),
        warnings: result.warnings.clone(),
        outputs: result
            .outputs
            .iter()
            .map(|o| output(&result.parameters, o))
            .collect(),
        verdict: result
            .parameters
            .iter()
            .zip(&result.verdict)
            .map(split)
            .collect(),
    }
}

/// The plots that are written as files: name and picture.
pub fn plots(result: &Sensitivity) -> Vec<(String, String)> {
    let plot = |o: &Output| {
        let view = output(&result.parameters, o);
        (format!("sensitivity-{}", view.name), view.svg)
    };
    result.outputs.iter().map(plot).collect()
}

fn output(parameters: &[String], output: &Output) -> OutputView {
    let shown = output.shown();
    let rows = parameters
        .iter()
        .enumerate()
        .map(|(k, name)| (name.clone(), shown.iter().map(|m| interval(m, k)).collect()));
    OutputView {
        name: output.name.clone(),
        svg: bars(&output.name, parameters, &shown),
        note: match &output.dominant {
            Some(name) => format!("{name} matters most."),
            None => {
                let reason = output.undecided();
                format!("{}{}.", reason[..1].to_uppercase(), &reason[1..])
            }
        },
        heads: shown.iter().map(|m| m.name.to_owned()).collect(),
        rows: rows.collect(),
    }
}

fn interval(measure: &Measure, parameter: usize) -> String {
    let Estimate { value, low, high } = measure.estimates[parameter];
    let value = number(value, 3);
    if low.is_nan() {
        return value;
    }
    let interval = format!("{value} ({} … {})", number(low, 2), number(high, 2));
    match &measure.bounds {
        Some(bounds) => {
            let [low, high] = bounds[parameter].map(|end| number(end, 2));
            format!("{interval} {{{low} … {high}}}")
        }
        None => interval,
    }
}

/// Horizontal bars with whiskers, the most important parameter on top.
fn bars(output: &str, parameters: &[String], shown: &[Measure]) -> String {
    /// The look of the first bar, the second, and all others.
    const CLASSES: [&str; 3] = ["in", "all", "all"];
    let measures: Vec<&Measure> = shown.iter().filter(|measure| measure.drawn).collect();
    let Some(first) = measures.first() else {
        return String::new();
    };
    let mut order: Vec<usize> = (0..parameters.len()).collect();
    let finite = |v: f64| if v.is_finite() { v } else { 0.0 };
    let value = |k: usize| finite(first.estimates[k].value);
    order.sort_by(|&a, &b| value(b).total_cmp(&value(a)));
    let most = measures
        .iter()
        .flat_map(|m| m.surest())
        .map(|e| finite(e.high))
        .fold(1e-12, f64::max);
    let least = measures
        .iter()
        .flat_map(|m| m.surest())
        .map(|e| finite(e.low).min(finite(e.value)))
        .fold(0.0, f64::min);
    let (left, width, band) = (170.0, 560.0, 16.0 * measures.len() as f64 + 12.0);
    // Estimates of an index near 0 scatter below it, too: their whiskers are drawn whole.
    let at = |v: f64| {
        let part = (finite(v) - least) / (most - least);
        left + part.clamp(0.0, 1.0) * (width - left - 16.0)
    };
    let height = band * parameters.len() as f64 + 34.0;
    let mut out = String::new();
    for t in super::svg::ticks(least, most, 5) {
        let _ = write!(
            out,
            "<path class=\"grid\" d=\"M{x:.1},4V{:.1}\"/><text class=\"tick\" x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>",
            height - 26.0,
            height - 10.0,
            number(t, 4),
            x = at(t)
        );
    }
    for (row, &k) in order.iter().enumerate() {
        let top = 8.0 + row as f64 * band;
        let _ = write!(
            out,
            "<text class=\"title\" x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>",
            left - 8.0,
            top + band / 2.0 - 1.0,
            escape(&parameters[k])
        );
        for (m, measure) in measures.iter().enumerate() {
            let (e, y) = (&measure.estimates[k], top + m as f64 * 16.0);
            let _ = write!(
                out,
                "<path class=\"bar solid {}\" d=\"M{zero:.1},{y:.1}H{:.1}v11H{zero:.1}z\"/><path class=\"whisker\" d=\"M{low:.1},{c:.1}H{high:.1}M{low:.1},{:.1}v6M{high:.1},{:.1}v6\"/>",
                CLASSES[m.min(2)],
                at(e.value),
                y + 2.5,
                y + 2.5,
                zero = at(0.0),
                low = at(e.low),
                high = at(e.high),
                c = y + 5.5
            );
            if let Some([low, high]) = measure.bounds.as_ref().map(|bounds| bounds[k]) {
                let _ = write!(
                    out,
                    "<path class=\"limit\" d=\"M{:.1},{c:.1}H{:.1}\"/>",
                    at(low),
                    at(high),
                    c = y + 5.5
                );
            }
        }
    }
    if let Some(limit) = first.chance {
        let _ = write!(
            out,
            "<path class=\"limit\" d=\"M{x:.1},4V{:.1}\"/>",
            height - 26.0,
            x = at(limit)
        );
    }
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"plot\" viewBox=\"0 0 {width} {height:.0}\" role=\"img\" aria-label=\"Sensitivity of {}; the table below tells the same in numbers\">{out}</svg>",
        escape(output)
    )
}

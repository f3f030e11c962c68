//! The document of sensitivity: an output each, its numbers and bars with intervals, and what decides the verdict.

use super::outputs::{Output, Sensitivity};
use crate::results::words::capitalised;
use parameter_regions::table::PointTable;
use result_document::format::number;
use result_document::svg::{area, path, picture, text, ticks};
use result_document::{Block, Document, Figure, Key, Table, numbers, words};
use sensitivity::Estimate;
use sensitivity::method::Measure;
use sensitivity::regional::Split;

/// The document of a result; `table` knows the parameters' units.
pub fn document(result: &Sensitivity, table: &PointTable) -> Document {
    let title = "Which parameter matters";
    let mut told = Document::new("sensitivity", "Sensitivity", title);
    told.say(format!("{}.", result.method));
    told.warn(&result.warnings);
    told.hint(
        "Whiskers are 95 % intervals; a dashed line down the picture is what a parameter without influence reaches by chance, \
         one along a bar the bounds where runs failed.",
    );
    let shown = result.outputs.first().map(Output::shown);
    if shown.is_some_and(|shown| shown.get(1).is_some_and(|m| m.name == "first order")) {
        let bar = "M1,3h12v8h-12z";
        told.blocks.push(Block::Legend(vec![
            Key::new("bar solid in", bar, "total: alone and in combination"),
            Key::new("bar solid all", bar, "first order: alone"),
        ]));
    }
    let figures = result.outputs.iter();
    let figures = figures.map(|output| figure(&result.parameters, output));
    told.blocks.push(Block::Figures("planes", figures.collect()));
    if !result.verdict.is_empty() {
        told.heading("What decides pass or fail");
        told.table(splits(result, table));
        told.hint(
            "Distance between the distributions of the parameter over verified and other points (Kolmogorov-Smirnov): 0 it \
             has nothing to do with the verdict, 1 it decides alone.",
        );
    }
    told
}

fn splits(result: &Sensitivity, table: &PointTable) -> Table {
    let row = |(name, s): (&String, &Split)| {
        let known = table.parameters.iter().find(|p| p.name == *name);
        let unit = known.map_or("", |p| p.unit.as_str());
        let with_unit = |value| format!("{} {unit}", number(value, 5)).trim_end().to_owned();
        vec![name.clone(), number(s.distance, 3), number(s.chance, 2), with_unit(s.passing), with_unit(s.failing)]
    };
    let pairs = result.parameters.iter().zip(&result.verdict);
    Table {
        name: "What decides pass or fail".into(),
        columns: vec![
            words("Parameter"),
            numbers("Distance"),
            numbers("By chance"),
            numbers("Median, verified"),
            numbers("Median, others"),
        ],
        rows: pairs.map(row).collect(),
        ..Table::default()
    }
}

fn figure(parameters: &[String], output: &Output) -> Figure {
    let shown = output.shown();
    let row = |(k, name): (usize, &String)| {
        let cells = shown.iter().map(|m| cell(m, k));
        std::iter::once(name.clone()).chain(cells).collect()
    };
    let heads = shown.iter().map(|m| words(m.name));
    Figure {
        file: format!("sensitivity-{}", output.name),
        caption: output.name.clone(),
        svg: bars(&output.name, parameters, &shown),
        note: match &output.dominant {
            Some(name) => format!("{name} matters most."),
            None => format!("{}.", capitalised(output.undecided())),
        },
        numbers: Some(Table {
            name: format!("Numbers of {}", output.name),
            columns: std::iter::once(words("Parameter")).chain(heads).collect(),
            rows: parameters.iter().enumerate().map(row).collect(),
            ..Table::default()
        }),
    }
}

fn cell(measure: &Measure, parameter: usize) -> String {
    let Estimate { value, low, high } = measure.estimates[parameter];
    let value = number(value, 3);
    if low.is_nan() {
        return value;
    }
    let interval = format!("{value} ({} .. {})", number(low, 2), number(high, 2));
    match &measure.bounds {
        Some(bounds) => {
            let [low, high] = bounds[parameter].map(|end| number(end, 2));
            format!("{interval} {{{low} .. {high}}}")
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
    let most = measures.iter().flat_map(|m| m.surest()).map(|e| finite(e.high)).fold(1e-12, f64::max);
    let least =
        measures.iter().flat_map(|m| m.surest()).map(|e| finite(e.low).min(finite(e.value))).fold(0.0, f64::min);
    let (left, width, band) = (170.0, 560.0, 16.0 * measures.len() as f64 + 12.0);
    // Estimates of an index near 0 scatter below it, too: their whiskers are drawn whole.
    let at = |v: f64| {
        let part = (finite(v) - least) / (most - least);
        left + part.clamp(0.0, 1.0) * (width - left - 16.0)
    };
    let height = band * parameters.len() as f64 + 34.0;
    let mut out = String::new();
    let down = |x: f64| format!("M{x:.1},4V{:.1}", height - 26.0);
    for t in ticks(least, most, 5) {
        out += &path("grid", down(at(t)));
        let place = [at(t), height - 10.0];
        out += &text("tick", place, "middle", &number(t, 4));
    }
    for (row, &k) in order.iter().enumerate() {
        let top = 8.0 + row as f64 * band;
        let place = [left - 8.0, top + band / 2.0 - 1.0];
        out += &text("title", place, "end", &parameters[k]);
        for (m, measure) in measures.iter().enumerate() {
            let (e, y) = (&measure.estimates[k], top + m as f64 * 16.0);
            let class = format!("bar solid {}", CLASSES[m.min(2)]);
            out += &area(&class, [at(0.0), at(e.value)], [y, y + 11.0]);
            let ([low, high], middle, upper) = ([e.low, e.high].map(at), y + 5.5, y + 2.5);
            let whisker = format_args!("M{low:.1},{middle:.1}H{high:.1}M{low:.1},{upper:.1}v6M{high:.1},{upper:.1}v6");
            out += &path("whisker", whisker);
            if let Some(bounds) = measure.bounds.as_ref().map(|bounds| bounds[k]) {
                let [low, high] = bounds.map(at);
                let bounds = format_args!("M{low:.1},{middle:.1}H{high:.1}");
                out += &path("limit", bounds);
            }
        }
    }
    if let Some(limit) = first.chance {
        out += &path("limit", down(at(limit)));
    }
    let title = format!("Sensitivity of {output}; the table below tells the same in numbers");
    picture("plot", [width, height], &title, &out)
}

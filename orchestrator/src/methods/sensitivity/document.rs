//! The document of sensitivity: an output each, its numbers and bars with intervals, and what decides the verdict.

use super::outputs::{Output, Sensitivity};
use crate::results::words::capitalised;
use result_document::{
    Block, Document, Figure, Key, Table,
    format::number,
    svg::{area, path, picture, text, ticks},
    words,
};
use sensitivity::{Estimate, method::Measure};

/// The document of a result.
pub fn document(result: &Sensitivity) -> Document {
    let mut told = Document::new("sensitivity", "Sensitivity", "Which parameter matters");
    told.say(format!("{}.", result.method));
    told.warn(&result.warnings);
    told.hint("Whiskers are 95 % intervals.");
    let shown = result.outputs.first().map(Output::shown);
    if shown.is_some_and(|shown| shown.get(1).is_some_and(|m| m.name == "first order")) {
        let bar = "M1,3h12v8h-12z";
        told.blocks.push(Block::Legend(vec![
            Key::new("bar solid in", bar, "total: alone and in combination"),
            Key::new("bar solid all", bar, "first order: alone"),
        ]));
    }
    let figures = result.outputs.iter().filter(|output| !output.shown().is_empty());
    let figures = figures.map(|output| figure(&result.parameters, output));
    told.blocks.push(Block::Figures("planes".into(), figures.collect()));
    told
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
    // Rounded away from the value: an interval that is shown holds what it held.
    let bound = |end: f64, round: fn(f64) -> f64| {
        let last = 10f64.powf(end.abs().log10().floor() - 1.0);
        // An end of two digits stays as it is, though 0.29 / 0.01 comes out as a little less than 29.
        let digits = (end / last * 1e6).round() / 1e6;
        number(if end.is_normal() { round(digits) * last } else { end }, 2)
    };
    format!("{value} ({} .. {})", bound(low, f64::floor), bound(high, f64::ceil))
}

/// Horizontal bars with whiskers, the most important parameter on top.
fn bars(output: &str, parameters: &[String], shown: &[Measure]) -> String {
    /// The look of the first bar, the second, and all others.
    const CLASSES: [&str; 3] = ["in", "all", "all"];
    let measures: Vec<&Measure> = shown.iter().filter(|measure| measure.drawn).collect();
    let Some(first) = measures.first() else { return String::new() };
    let mut order: Vec<usize> = (0..parameters.len()).collect();
    let finite = |v: f64| if v.is_finite() { v } else { 0.0 };
    let value = |k: usize| finite(first.estimates[k].value);
    order.sort_by(|&a, &b| value(b).total_cmp(&value(a)));
    let all = || measures.iter().flat_map(|m| &m.estimates);
    let most = all().map(|e| finite(e.high)).fold(1e-12, f64::max);
    let least = all().map(|e| finite(e.low).min(finite(e.value))).fold(0.0, f64::min);
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
        }
    }
    let title = format!("Sensitivity of {output}; the table below tells the same in numbers");
    picture("plot", [width, height], &title, &out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_interval_that_is_shown_holds_the_value() {
        let shown = |value, low, high| {
            let estimates = vec![Estimate { value, low, high }];
            cell(&Measure::drawn("total", estimates), 0)
        };
        assert_eq!(shown(0.997, 0.9965, 0.9977), "0.997 (0.99 .. 1)");
        assert_eq!(shown(0.0341, -0.00712, 0.0751), "0.0341 (−0.0072 .. 0.076)");
        assert_eq!(shown(0.3, 0.29, 0.57), "0.3 (0.29 .. 0.57)");
        assert_eq!(shown(0.0, 0.0, 0.0), "0 (0 .. 0)");
        assert_eq!(shown(0.1, f64::NEG_INFINITY, 1.0), "0.1 (−∞ .. 1)");
        assert_eq!(shown(0.5, f64::NAN, f64::NAN), "0.5");
    }
}

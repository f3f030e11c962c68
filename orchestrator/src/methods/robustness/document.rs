//! The document of robustness: the margins, the box, and maps over pairs.

use std::fmt::Write;

use crate::results::words::capitalised;
use parameter_regions::robustness::{
    Robustness,
    maps::{CELLS, Map},
    margins::Margin,
    region::Region,
    stand::Quality,
};
use result_document::{
    Block, Document, Figure, Key, Table,
    format::{DASH, number, percent_text, with_unit},
    numbers,
    svg::{Frame, path},
    words,
};

/// The document of a result.
pub fn document(result: &Robustness) -> Document {
    let mut told = Document::new("robustness", "Robustness", "How far the parameters may go");
    let answer = result.answer.words(result.shown());
    told.say(format!("{}.", capitalised(&answer)));
    told.warn(&result.warnings);
    told.heading("Margins and box");
    told.table(margins(result));
    told.hint("Alone: how far one parameter may move from the best point before the criterion in brackets is lost.");
    if let Some(region) = &result.region {
        told.say(evidence(result.level, region));
    }
    told.heading("Surrogates");
    told.table(surrogates(result));
    told.hint("Gaussian processes stand for the model. Their errors are by leave-one-out.");
    told.blocks.extend(maps(result));
    told.hint(
        "The criteria with all other parameters at their medians, the probability with all others as sampled. From the \
         surrogates.",
    );
    told
}

fn margins(result: &Robustness) -> Table {
    let end = |(value, lost): &(f64, Option<String>)| match lost {
        Some(name) => format!("{} ({name})", number(*value, 5)),
        None => format!("{} (end of samples)", number(*value, 5)),
    };
    let row = |(k, name): (usize, &String)| {
        let margin = result.margins.iter().find(|m| m.parameter == *name);
        let of_margin = |of: &dyn Fn(&Margin) -> String| margin.map_or(DASH.into(), of);
        let of_box = |side: usize| result.region.as_ref().map_or(DASH.into(), |r| number(r.limits[k][side], 5));
        vec![
            with_unit(name, &result.units[k]),
            of_margin(&|m| end(&m.low)),
            of_margin(&|m| number(m.value, 5)),
            of_margin(&|m| end(&m.high)),
            of_box(0),
            of_box(1),
        ]
    };
    let columns = [
        words("Parameter"),
        numbers("Alone, down to"),
        numbers("Best point"),
        numbers("Alone, up to"),
        numbers("Box, from"),
        numbers("Box, to"),
    ];
    Table::new("Margins and box", columns, result.parameters.iter().enumerate().map(row).collect())
}

/// The statement on the box, whether it comes to the level, and how the study's points and fresh runs compare with it.
fn evidence(level: f64, of: &Region) -> String {
    let [low, high] = of.interval.map(percent_text);
    let shown = if of.interval[0] >= level { "" } else { "not " };
    let told = format!(
        "Largest box found: {} % of the sampled space. Of it {} % are verified (95 % interval {low} .. {high} %), {shown}shown to be {} % \
         or more by the surrogates and the study's own points, of which {} lie inside, {} of them verified.",
        percent_text(of.share),
        percent_text(of.probability),
        percent_text(level),
        of.confirmed.points,
        of.confirmed.verified
    );
    let Some(fresh) = of.fresh else { return told };
    let [low, high] = fresh.interval.map(percent_text);
    format!(
        "{told} Of {} fresh runs inside {} are verified (95 % interval {low} .. {high} %): {}.",
        fresh.points,
        fresh.verified,
        fresh.on(of.interval)
    )
}

fn surrogates(result: &Robustness) -> Table {
    let row = |(name, q): &(String, Quality)| {
        vec![name.clone(), q.points.to_string(), number(q.error, 2), percent_text(q.predicted.max(0.0))]
    };
    let columns = [words("Criterion"), numbers("Points"), numbers("Error"), numbers("Variance predicted %")];
    Table::new("Surrogates", columns, result.criteria.iter().map(row).collect())
}

/// Maps of the probability of verification, and of each criterion.
fn maps(result: &Robustness) -> Vec<Block> {
    if result.maps.is_empty() {
        return Vec::new();
    }
    type Values = fn(&Map, usize) -> &[f64];
    let group = |name: &str, range: [f64; 2], values: Values, k: usize| {
        let figure = |map: &Map| drawn(result, map, name, values(map, k), range);
        let [low, high] = range.map(|end| number(end, 4));
        let scale = Block::Legend(vec![Key { svg: String::new(), words: low }, Key { svg: shades(), words: high }]);
        let figures = Block::Figures("maps".into(), result.maps.iter().map(figure).collect());
        Block::Folded(format!("{name} over all pairs of parameters"), false, vec![scale, figures])
    };
    let mut groups = Vec::new();
    // Where no place is verified, all of them look alike.
    if result.maps.iter().flat_map(|map| &map.probability).any(|p| *p >= 0.01) {
        groups.push(group("Probability of verification", [0.0, 1.0], |map, _| &map.probability, 0));
    }
    for (k, (name, _)) in result.criteria.iter().enumerate() {
        let values = result.maps.iter().flat_map(|m| &m.criteria[k]);
        groups.push(group(name, range(values), |map, k| &map.criteria[k], k));
    }
    if let Some(Block::Folded(_, open, _)) = groups.first_mut() {
        *open = true;
    }
    groups
}

fn range<'a>(values: impl Iterator<Item = &'a f64>) -> [f64; 2] {
    values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [low.min(*v), high.max(*v)])
}

const SHADES: usize = 9;

/// The shades of a map, from the lowest value to the highest.
fn shades() -> String {
    let shades: String = (0..SHADES)
        .map(|s| {
            let x = 10 * s;
            format!("<rect class=\"shade s{s}\" x=\"{x}\" width=\"10.2\" height=\"10\"/>")
        })
        .collect();
    format!("<svg class=\"plot scale\" viewBox=\"0 0 90 10\" aria-hidden=\"true\">{shades}</svg>")
}

/// One map in nine shades.
fn drawn(result: &Robustness, map: &Map, what: &str, values: &[f64], scale: [f64; 2]) -> Figure {
    let frame = Frame::new(280.0, 250.0, map.x_range, map.y_range);
    let [across, up] = [map.x, map.y].map(|k| with_unit(&result.parameters[k], &result.units[k]));
    let [width, height] = [frame.x.to - frame.x.from, frame.y.from - frame.y.to].map(|side| side / CELLS as f64);
    let span = (scale[1] - scale[0]).max(f64::MIN_POSITIVE);
    let mut paths = vec![String::new(); SHADES];
    for (k, v) in values.iter().enumerate() {
        let shade = (((v - scale[0]) / span * SHADES as f64) as usize).min(SHADES - 1);
        let x = frame.x.from + (k % CELLS) as f64 * width;
        let y = frame.y.from - (k / CELLS + 1) as f64 * height;
        // Neighbouring cells overlap slightly: some renderers would show seams between them.
        let [w, h] = [width + 0.3, height + 0.3];
        let _ = write!(paths[shade], "M{x:.1},{y:.1}h{w:.1}v{h:.1}h-{w:.1}z");
    }
    let shades = paths.iter().enumerate().filter(|(_, d)| !d.is_empty());
    let shades: String = shades.map(|(s, d)| path(&format!("shade s{s}"), d)).collect();
    let [low, high] = range(values.iter()).map(|end| number(if end.abs() < 1e-6 * span { 0.0 } else { end }, 4));
    let title = format!("{what} over {across} and {up}: {low} to {high}");
    Figure {
        file: format!("map-{what}-{}-{}", result.parameters[map.x], result.parameters[map.y]),
        svg: frame.wrap(&title, &(frame.axes(&across, Some(&up)) + &shades)),
        note: format!("{low} .. {high}"),
        ..Figure::default()
    }
}

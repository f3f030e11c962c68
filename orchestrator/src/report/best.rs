//! The page's table of the best points.

use super::payload::PlotColumn;
use parameter_regions::table::{PointTable, Ranked};
use result_document::format::{number, percent_text};
use serde::Serialize;

/// Number of best points in the table.
pub const BEST: usize = 12;

#[derive(Default, Serialize)]
pub struct Cell {
    text: String,
    note: String,
    bad: bool,
    /// Signed deviation, clipped to -1.5 to 1.5, for the little bar.
    bar: Option<f64>,
}

#[derive(Serialize)]
pub struct BestRow {
    id: u64,
    verified: bool,
    distance: String,
    deviation: String,
    binding: String,
    /// The conformance probability in per cent, where it is known.
    conforms: Option<String>,
    cells: Vec<Cell>,
}

/// A structured name in its two parts, and the unit.
pub fn heading<'a>(c: &PlotColumn<'a>) -> (&'a str, &'a str, &'a str) {
    let (path, name) = c.name.rsplit_once('.').unwrap_or(("", c.name));
    (path, name, c.unit)
}

pub fn best_rows(
    table: &PointTable,
    ranking: &[Ranked],
    conformance: Option<&[f64]>,
    pictured: Option<&[usize]>,
) -> Vec<BestRow> {
    ranking
        .iter()
        .take(BEST)
        .map(|ranked| {
            let Ranked { point: i, distance, binding } = *ranked;
            let parameters = table.parameters.iter().map(|p| Cell { text: number(p.values[i], 5), ..Cell::default() });
            let criteria =
                (0..table.criteria.len()).filter(|k| pictured.is_none_or(|shown| shown.contains(k))).map(|k| {
                    let c = &table.criteria[k];
                    let deviation = c.deviation(c.values[i]);
                    let bar = deviation.min(1.5) * (c.values[i] - c.nominal).signum();
                    Cell {
                        text: number(c.values[i], 5),
                        note: format!("{} of the tolerance", number(deviation, 2)),
                        bad: !c.ok[i],
                        bar: Some((100.0 * bar).round() / 100.0),
                    }
                });
            BestRow {
                id: table.ids[i],
                verified: table.verified[i],
                distance: number(distance, 3),
                deviation: number(binding.deviation, 2),
                binding: table.criteria[binding.criterion].name.clone(),
                conforms: conformance.map(|p| percent_text(p[i])),
                cells: parameters.chain(criteria).collect(),
            }
        })
        .collect()
}

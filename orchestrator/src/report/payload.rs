//! The data inside the page: columns of the points that are drawn, hovered and selected.

use super::{judgement::Judgement, whatif::WhatIf};
use crate::results::choice::Even;
use parameter_regions::table::PointTable;
use result_document::bins;
use serde::Serialize;
use std::cell::RefCell;

/// Largest number of points that are drawn.
pub const MOST_POINTS: usize = 20_000;
/// Largest size of the embedded columns, bytes.
const MOST_COLUMN_BYTES: usize = 2_000_000;

/// Bytes beside the data, which name their parts by begin and end.
#[derive(Default)]
pub struct Bytes(RefCell<Vec<u8>>);

type ByteRange = [usize; 2];

impl Bytes {
    fn add(&self, bytes: impl IntoIterator<Item = u8>) -> ByteRange {
        let mut all = self.0.borrow_mut();
        let begin = all.len();
        all.extend(bytes);
        [begin, all.len()]
    }

    pub fn all(self) -> Vec<u8> {
        self.0.into_inner()
    }
}

/// Data for the page's script.
#[derive(Serialize)]
pub struct Payload {
    total: usize,
    /// How many of all points are accepted.
    accepted: usize,
    /// Whether only some of the points are embedded.
    sampled: bool,
    columns: Vec<EmbeddedColumn>,
    /// Point numbers, 32-bit.
    ids: ByteRange,
    /// Whether a guard band acts, so that fewer points are accepted than lie within all tolerances.
    guarded: bool,
    /// A byte per point: accepted.
    verified: ByteRange,
    /// A byte per point: simulated to its end.
    completed: ByteRange,
    /// The conformance probabilities, 32-bit floats of five digits, where they are known.
    conformance: Option<ByteRange>,
    /// The study to be changed, where the points can be judged in the page.
    study: Option<WhatIf>,
    /// A byte per point: of an even choice of all points, which is what can be judged where not all are embedded.
    sample: Option<ByteRange>,
}

#[derive(Serialize)]
struct EmbeddedColumn {
    name: String,
    unit: String,
    range: [f64; 2],
    /// Points with a value that lies outside `range`.
    outside: usize,
    /// 32-bit floats; of a criterion 64-bit ones, since its values are judged. Their bytes stand apart (`apart`).
    data: ByteRange,
    criterion: Option<Acceptance>,
}

#[derive(Serialize)]
struct Acceptance {
    /// The measured value, with the deviation 0; of a limit that stands alone the value with that deviation.
    nominal: f64,
    lower: Option<f64>,
    upper: Option<f64>,
    /// The tolerance interval drawn in by the guard band, where one acts and anything is left.
    drawn_in: Option<[f64; 2]>,
    /// A byte per point.
    ok: ByteRange,
}

/// All columns of a table, parameters first, as the plots see them.
pub struct PlotColumn<'a> {
    /// Name of the parameter or criterion.
    pub name: &'a str,
    /// Its unit.
    pub unit: &'a str,
    /// One value per point.
    pub values: &'a [f64],
    /// The accepted interval; infinite for parameters.
    pub accepted: [f64; 2],
    /// That interval drawn in by the guard band, where one acts.
    pub drawn_in: Option<[f64; 2]>,
    /// Whether it is a criterion's.
    pub is_criterion: bool,
    /// The measured value of a criterion that has limits to both sides.
    pub nominal: Option<f64>,
    /// The axis.
    pub range: [f64; 2],
}

/// Lists the columns of a table; the axis of a column without any value is 0 to 1.
pub fn columns<'a>(table: &'a PointTable, judgement: &Judgement) -> Vec<PlotColumn<'a>> {
    let column = |name: &'a str, unit: &'a str, values: &'a [f64], accepted: [f64; 2], nominal| PlotColumn {
        name,
        unit,
        values,
        accepted,
        drawn_in: None,
        is_criterion: false,
        nominal,
        range: bins::axis_range(values.iter().copied(), accepted[0], accepted[1]).unwrap_or([0.0, 1.0]),
    };
    let free = [f64::NEG_INFINITY, f64::INFINITY];
    let parameters = table.parameters.iter().map(|p| column(&p.name, &p.unit, &p.values, free, None));
    let criteria = table.criteria.iter().enumerate().map(|(k, c)| {
        let tolerance = [c.lower, c.upper];
        let measured = Some(c.nominal).filter(|_| tolerance.iter().all(|end| end.is_finite()));
        PlotColumn {
            drawn_in: judgement.drawn_in(k, tolerance),
            is_criterion: true,
            ..column(&c.name, &c.unit, &c.values, tolerance, measured)
        }
    });
    parameters.chain(criteria).collect()
}

/// Which points are embedded and drawn: all of them, or the best, many verified ones and an even choice of all.
pub fn embedded(table: &PointTable, ranking: &[usize], columns: usize) -> Vec<usize> {
    embed(table, ranking, most_embedded(columns))
}

fn embed(table: &PointTable, ranking: &[usize], most: usize) -> Vec<usize> {
    let n = table.len();
    if n <= most {
        return (0..n).collect();
    }
    let even = even(n, most);
    let mut keep: Vec<bool> = (0..n).map(|i| even.has(i as u64)).collect();
    ranking.iter().take(most / 20).for_each(|&i| keep[i] = true);
    let verified: Vec<usize> = (0..n).filter(|&i| table.verified[i]).collect();
    let step = verified.len().div_ceil((most / 5).max(1)).max(1);
    verified.iter().step_by(step).for_each(|&i| keep[i] = true);
    (0..n).filter(|&i| keep[i]).collect()
}

/// The largest number of points that may be embedded.
fn most_embedded(columns: usize) -> usize {
    MOST_POINTS.min(MOST_COLUMN_BYTES * 3 / (16 * columns.max(1)))
}

/// The even choice of `n` points that is embedded where `most` are not enough for all: a sample like all of them, as the best
/// and the verified ones are not.
fn even(n: usize, most: usize) -> Even {
    Even::new(n as u64, (most / 4) as u64)
}

/// Collects the data for the page's script; there are `total` points, `accepted` of them accepted, of which the table may
/// hold only some. In the table the accepted points count as verified. `conformance` is the conformance probability of every
/// point, where it is known; `study` is what can be changed. What is many goes into `bytes`.
pub fn payload(
    table: &PointTable,
    columns: &[PlotColumn],
    points: &[usize],
    [total, accepted]: [usize; 2],
    conformance: Option<&[f64]>,
    study: Option<&WhatIf>,
    bytes: &Bytes,
) -> Payload {
    let first_criterion = table.parameters.len();
    let flags = |flag: &dyn Fn(usize) -> bool| bytes.add(points.iter().map(|&i| u8::from(flag(i))));
    let floats = |values: &[f64]| {
        let numbers = points.iter().map(|&i| (values[i] as f32).to_le_bytes());
        bytes.add(apart(numbers))
    };
    let doubles = |values: &[f64]| {
        let numbers = points.iter().map(|&i| values[i].to_le_bytes());
        bytes.add(apart(numbers))
    };
    let some = points.len() < table.len();
    let even = even(table.len(), most_embedded(columns.len()));
    let described = columns.iter().enumerate().map(|(k, c)| EmbeddedColumn {
        name: c.name.to_owned(),
        unit: c.unit.to_owned(),
        range: c.range,
        outside: c.values.iter().filter(|v| v.is_finite() && !(c.range[0]..=c.range[1]).contains(v)).count(),
        data: if k < first_criterion { floats(c.values) } else { doubles(c.values) },
        criterion: k.checked_sub(first_criterion).map(|j| {
            let criterion = &table.criteria[j];
            let finite = |limit: f64| limit.is_finite().then_some(limit);
            Acceptance {
                nominal: criterion.nominal,
                lower: finite(criterion.lower),
                upper: finite(criterion.upper),
                drawn_in: c.drawn_in.filter(|[low, high]| low <= high),
                ok: flags(&|i| criterion.ok[i]),
            }
        }),
    });
    Payload {
        total,
        accepted,
        sampled: points.len() < total,
        columns: described.collect(),
        ids: bytes.add(apart(points.iter().map(|&i| (table.ids[i] as u32).to_le_bytes()))),
        guarded: columns.iter().any(|c| c.drawn_in.is_some()),
        verified: flags(&|i| table.verified[i]),
        completed: flags(&|i| table.completed(i)),
        conformance: conformance.map(|chances| {
            let numbers = points.iter().map(|&i| short(chances[i]).to_le_bytes());
            bytes.add(apart(numbers))
        }),
        sample: some.then(|| flags(&|i| even.has(i as u64))),
        study: study.cloned().map(|study| if some { study.of_some() } else { study }),
    }
}

/// A number of five digits, which can be packed better.
fn short(number: f64) -> f32 {
    const DROPPED: u32 = 7;
    let bits = (number as f32).to_bits();
    f32::from_bits((bits + (1 << (DROPPED - 1))) >> DROPPED << DROPPED)
}

/// The bytes of numbers, all first ones, then all second ones, and so on: sign and exponent of neighbours are alike, so they can be
/// packed.
fn apart<const SIZE: usize>(numbers: impl Iterator<Item = [u8; SIZE]> + Clone) -> impl Iterator<Item = u8> {
    (0..SIZE).flat_map(move |place| numbers.clone().map(move |number| number[place]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(n: usize) -> PointTable {
        PointTable {
            ids: (0..n as u64).collect(),
            verified: (0..n).map(|i| i % 50 == 0).collect(),
            status: vec!["ok".into(); n],
            ..PointTable::default()
        }
    }

    #[test]
    fn few_points_are_all_embedded() {
        assert_eq!(embed(&table(100), &[], 100).len(), 100);
    }

    #[test]
    fn of_many_points_the_best_and_the_verified_are_kept() {
        let t = table(10_000);
        let chosen = embed(&t, &[7, 3], 2000);
        assert!(chosen.len() <= 1000, "{}", chosen.len());
        assert!(chosen.contains(&7) && chosen.contains(&3));
        assert_eq!(chosen.iter().filter(|&&i| t.verified[i]).count(), 200);
        let even = even(10_000, 2000);
        assert_eq!(chosen.iter().filter(|&&i| even.has(i as u64)).count(), 500);
    }
}

//! The planes that the page starts with.

use super::{figures, payload::PlotColumn};
use parameter_regions::table::PointTable;
use sampling::statistics::moments::pearson;
use serde::Serialize;

/// Largest number of planes of two criteria.
pub const PLANES: usize = 4;

/// A plane of two columns.
#[derive(Serialize)]
pub struct Plane {
    pub x: usize,
    pub y: usize,
    pub title: String,
    pub svg: String,
}

/// The planes to start with: neighbouring criteria of every group, then the criteria left over in
/// pairs, and at the end the parameter and criterion that go together most.
pub fn planes(table: &PointTable, columns: &[PlotColumn], points: &[usize], counts: [usize; 2]) -> Vec<Plane> {
    let first = table.parameters.len();
    let mut pairs: Vec<(usize, usize, String)> = Vec::new();
    let mut left_over = Vec::new();
    for group in table.groups().into_iter().map(Some).chain([None]) {
        let members = table.members(group);
        match (group, members.as_slice()) {
            (Some(name), [_, _, ..]) => {
                pairs.extend(members.windows(2).map(|w| (first + w[0], first + w[1], name.to_owned())))
            }
            _ => left_over.extend(members),
        }
    }
    pairs.extend(
        left_over.chunks(2).filter(|w| w.len() == 2).map(|w| (first + w[0], first + w[1], "criteria".to_owned())),
    );
    pairs.truncate(PLANES - 1);
    let room = if pairs.len().is_multiple_of(2) { 2 } else { 1 };
    let strongest = strongest_pairs(table).into_iter().take(room);
    pairs.extend(strongest.map(|(x, y)| (x, first + y, format!("strongest on {}", table.criteria[y].name))));
    pairs
        .into_iter()
        .map(|(x, y, title)| Plane {
            svg: figures::plane(table, &columns[x], &columns[y], points, counts),
            x,
            y,
            title,
        })
        .collect()
}

/// For every criterion the parameter with the largest linear correlation, the strongest first,
/// every parameter once.
fn strongest_pairs(table: &PointTable) -> Vec<(usize, usize)> {
    let mut all: Vec<(f64, usize, usize)> = Vec::new();
    for (p, parameter) in table.parameters.iter().enumerate() {
        for (c, criterion) in table.criteria.iter().enumerate() {
            let r = correlation(&parameter.values, &criterion.values).abs();
            if r > 0.0 {
                all.push((r, p, c));
            }
        }
    }
    all.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut chosen: Vec<(usize, usize)> = Vec::new();
    for (_, p, c) in all {
        if chosen.iter().all(|&(q, d)| p != q && c != d) {
            chosen.push((p, c));
        }
    }
    chosen
}

/// Of the points that have both values.
fn correlation(x: &[f64], y: &[f64]) -> f64 {
    let (x, y): (Vec<f64>, Vec<f64>) =
        x.iter().copied().zip(y.iter().copied()).filter(|(a, b)| a.is_finite() && b.is_finite()).unzip();
    pearson(&x, &y)
}

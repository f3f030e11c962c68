//! Maps over pairs of parameters (the paper's Table 4): the criteria with all other parameters at
//! their medians, and the probability of verification with all others as they were sampled.

use super::stand::Stand;
use crate::table::PointTable;
use sampling::statistics::moments::{quantile, sorted};
use serde::{Deserialize, Serialize};

/// Cells along each side.
pub const CELLS: usize = 20;
/// Samples of the remaining parameters for each cell of a map.
const OTHERS: usize = 25;

/// A map over two parameters.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Map {
    /// Index of the parameter along the horizontal axis.
    pub x: usize,
    /// Index of the parameter along the vertical axis.
    pub y: usize,
    /// Ends of the horizontal axis: the middle 98 % of the samples.
    pub x_range: [f64; 2],
    /// Ends of the vertical axis.
    pub y_range: [f64; 2],
    /// The criteria's values, row by row from low `y`, one list a criterion.
    pub criteria: Vec<Vec<f64>>,
    /// Probability of verification, in the same order.
    pub probability: Vec<f64>,
}

/// All pairs.
pub fn maps(table: &PointTable, stand: &Stand, inputs: &[Vec<f64>]) -> Vec<Map> {
    let d = table.parameters.len();
    let columns: Vec<Vec<f64>> = table.parameters.iter().map(|p| sorted(p.values.clone())).collect();
    let medians: Vec<f64> = columns.iter().map(|c| quantile(c, 0.5)).collect();
    let range = |k: usize| [0.01, 0.99].map(|part| quantile(&columns[k], part));
    let every = inputs.len().div_ceil(OTHERS).max(1);
    let others: Vec<&Vec<f64>> = inputs.iter().step_by(every).collect();
    let map = |(x, y): (usize, usize)| {
        let (x_range, y_range) = (range(x), range(y));
        let place = |k: usize, range: [f64; 2]| range[0] + (range[1] - range[0]) * (k as f64 + 0.5) / CELLS as f64;
        let at = |base: &[f64], cell: usize| {
            let mut point = base.to_vec();
            point[x] = place(cell % CELLS, x_range);
            point[y] = place(cell / CELLS, y_range);
            point
        };
        let cells = 0..CELLS * CELLS;
        let all = |base: &[f64]| -> Vec<Vec<f64>> { cells.clone().map(|cell| at(base, cell)).collect() };
        let values = stand.values(&all(&medians));
        let mut probability = vec![0.0; cells.len()];
        for other in &others {
            let of_other = stand.probabilities(&all(other));
            probability.iter_mut().zip(of_other).for_each(|(sum, p)| *sum += p / others.len() as f64);
        }
        Map {
            x,
            y,
            x_range,
            y_range,
            criteria: (0..table.criteria.len()).map(|c| values.iter().map(|v| v[c]).collect()).collect(),
            probability,
        }
    };
    let pairs = (0..d).flat_map(|x| (x + 1..d).map(move |y| (x, y)));
    pairs.map(map).collect()
}

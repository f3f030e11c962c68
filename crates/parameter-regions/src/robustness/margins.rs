//! How far each parameter alone may move from the best point before a criterion is lost.

use super::stand::Stand;
use crate::table::PointTable;
use sampling::statistics::moments::{quantile, sorted};
use serde::{Deserialize, Serialize};

/// A parameter's room.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Margin {
    /// The parameter.
    pub parameter: String,
    /// The parameter's value at the best point.
    pub value: f64,
    /// The limit below, and the criterion that is lost there; without one it is the end of the sampled range.
    pub low: (f64, Option<String>),
    /// The limit above, likewise.
    pub high: (f64, Option<String>),
}

/// Margins of all parameters, within the range that was sampled. A surrogate may see the best point
/// slightly outside; then the margin is zero and names that criterion.
pub fn margins(table: &PointTable, stand: &Stand, best: &[f64]) -> Vec<Margin> {
    let margin = |k: usize| {
        let column = sorted(table.parameters[k].values.clone());
        let lost = |value: f64| {
            let mut x = best.to_vec();
            x[k] = value;
            let values = stand.values(&[x]).remove(0);
            let outside = |c: &usize| values[*c] < table.criteria[*c].lower || values[*c] > table.criteria[*c].upper;
            (0..table.criteria.len()).find(outside)
        };
        let limit = |end: f64| {
            const STEPS: usize = 200;
            let at = |s: f64| best[k] + (end - best[k]) * s;
            let first = (0..=STEPS).find(|s| lost(at(*s as f64 / STEPS as f64)).is_some());
            let Some(step) = first else {
                return (end, None);
            };
            let (mut a, mut b) = (step.saturating_sub(1) as f64 / STEPS as f64, step as f64 / STEPS as f64);
            for _ in 0..40 {
                let middle = (a + b) / 2.0;
                if lost(at(middle)).is_some() { b = middle } else { a = middle }
            }
            (at(b), lost(at(b)).map(|c| table.criteria[c].name.clone()))
        };
        Margin {
            parameter: table.parameters[k].name.clone(),
            value: best[k],
            low: limit(quantile(&column, 0.0).min(best[k])),
            high: limit(quantile(&column, 1.0).max(best[k])),
        }
    };
    (0..table.parameters.len()).map(margin).collect()
}

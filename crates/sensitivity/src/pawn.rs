//! PAWN: how much the distribution of an output changes when a parameter is held in a slice of its
//! range. It sees every influence, not only that on the variance, and works on any points.
//!
//! Pianosi & Wagener (2018), "Distribution-based sensitivity analysis from a generic input-output
//! sample", Environmental Modelling & Software 108, 197-207.

use crate::method::{FromPoints, Measure, Told, read};
use sampling::random::{Purpose, Random};
use sampling::statistics::estimate::Estimate;
use sampling::statistics::moments::{ks_distance, mean, quantile, sorted};
use serde::{Deserialize, Serialize};
use serde_json::json;

/// Slices of a parameter's range.
const SLICES: usize = 10;
/// Resamples of the intervals.
const RESAMPLES: usize = 200;

/// PAWN indices of any points.
#[derive(Clone, Copy, Debug)]
pub struct Slices;

impl FromPoints for Slices {
    fn name(&self) -> &'static str {
        "PAWN"
    }

    fn tell(&self, columns: &[&[f64]], values: &[f64], seed: u64) -> Told {
        let pawn = pawn(columns, values, SLICES, RESAMPLES, seed);
        Told::from_iter([("pawn".to_owned(), json!(pawn))])
    }

    fn shown(&self, told: &Told) -> Vec<Measure> {
        let pawn: Option<Pawn> = read(told, "pawn");
        let measure = pawn.map(|pawn| Measure { chance: Some(pawn.threshold), ..Measure::drawn("PAWN", pawn.median) });
        measure.into_iter().collect()
    }
}

/// Influence of every parameter on one output.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pawn {
    /// Median over the slices of the Kolmogorov-Smirnov distance between the output's distribution
    /// in the slice and that of all points, with a bootstrap interval.
    pub median: Vec<Estimate>,
    /// The largest of these distances.
    pub max: Vec<f64>,
    /// The median distance that a parameter without influence reaches on so few points: the 95 %
    /// point over shuffled parameters. Smaller indices tell nothing.
    pub threshold: f64,
    /// Points with finite values.
    pub used: usize,
}

/// Computes the indices of columns of parameters on an output, in `slices` slices of equal content.
/// Points without a finite value are left out. `None` where a slice would hold fewer than two points.
pub fn pawn(parameters: &[&[f64]], output: &[f64], slices: usize, resamples: usize, seed: u64) -> Option<Pawn> {
    let kept: Vec<usize> =
        (0..output.len()).filter(|&j| output[j].is_finite() && parameters.iter().all(|p| p[j].is_finite())).collect();
    if slices == 0 || kept.len() < 2 * slices {
        return None;
    }
    let y: Vec<f64> = kept.iter().map(|&j| output[j]).collect();
    let mut random = Random::new(seed, Purpose::Resample, 0);
    let mut result = Pawn { median: vec![], max: vec![], threshold: 0.0, used: y.len() };
    for parameter in parameters {
        let x: Vec<f64> = kept.iter().map(|&j| parameter[j]).collect();
        let by_slice = distances(&x, &y, slices);
        let value = quantile(&by_slice, 0.5);
        let again = (0..resamples).map(|_| {
            let picks = (0..y.len()).map(|_| random.below(y.len()));
            let (x, y): (Vec<f64>, Vec<f64>) = picks.map(|j| (x[j], y[j])).unzip();
            quantile(&distances(&x, &y, slices), 0.5)
        });
        let again = sorted(again.collect());
        // Resampling adds distance of its own; shift it away, so that the interval is about the estimate.
        let bias = mean(&again) - value;
        result.median.push(Estimate {
            value,
            low: (quantile(&again, 0.025) - bias).clamp(0.0, value),
            high: (quantile(&again, 0.975) - bias).clamp(value, 1.0),
        });
        let largest = by_slice.last().expect("some slice holds a point");
        result.max.push(*largest);
    }
    let mut shuffled: Vec<f64> = (0..y.len()).map(|k| k as f64).collect();
    let dummy = (0..resamples.max(20)).map(|_| {
        random.shuffle(&mut shuffled);
        quantile(&distances(&shuffled, &y, slices), 0.5)
    });
    result.threshold = quantile(&sorted(dummy.collect()), 0.95);
    Some(result)
}

/// The slices' distances, sorted. Slices are between quantiles, closed below and open above, the
/// last closed on both sides.
fn distances(x: &[f64], y: &[f64], slices: usize) -> Vec<f64> {
    let all = sorted(y.to_vec());
    let order = sorted(x.to_vec());
    let edges: Vec<f64> = (0..=slices).map(|k| quantile(&order, k as f64 / slices as f64)).collect();
    let mut parts = vec![Vec::new(); slices];
    for (v, out) in x.iter().zip(y) {
        // The last slice whose lower edge is not above the value.
        let slice = edges[..slices].partition_point(|e| e <= v).max(1) - 1;
        parts[slice].push(*out);
    }
    let filled = parts.into_iter().filter(|part| !part.is_empty());
    let distances = filled.map(|part| ks_distance(&sorted(part), &all));
    sorted(distances.collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::functions::ishigami;
    use crate::testing::{lattice, near};

    fn sample(n: usize) -> (Vec<Vec<f64>>, Vec<f64>) {
        let mut random = Random::new(8, Purpose::Unstated, 0);
        let x: Vec<Vec<f64>> = (0..4).map(|_| (0..n).map(|_| random.unit()).collect()).collect();
        let y = (0..n).map(|j| ishigami(&[x[0][j], x[1][j], x[2][j]])).collect();
        (x, y)
    }

    /// A lattice of two parameters, of which the first moves the output much.
    fn waves(points: usize) -> ([Vec<f64>; 2], Vec<f64>) {
        let points = lattice(points, 2);
        let output = points.iter().map(|u| (6.0 * u[0]).sin() + 0.3 * u[1]);
        let column = |i: usize| points.iter().map(|u| u[i]).collect();
        ([column(0), column(1)], output.collect())
    }

    #[test]
    fn every_parameter_of_ishigami_matters_and_a_dummy_does_not() {
        let (x, y) = sample(3000);
        let views: Vec<&[f64]> = x.iter().map(Vec::as_slice).collect();
        let p = pawn(&views, &y, 10, 40, 1).unwrap();
        for i in 0..3 {
            assert!(p.median[i].value > p.threshold, "{i} {p:?}");
        }
        assert!(p.median[3].value < 1.3 * p.threshold, "{p:?}");
        // Pianosi & Wagener (2015), figure 4: the second parameter's influence is the largest.
        assert!(p.median[1].value > p.median[0].value && p.median[0].value > p.median[2].value, "{p:?}");
    }

    #[test]
    fn failed_points_are_left_out() {
        let (x, mut y) = sample(500);
        y[17] = f64::NAN;
        let views: Vec<&[f64]> = x.iter().map(Vec::as_slice).collect();
        assert_eq!(pawn(&views, &y, 10, 5, 1).unwrap().used, 499);
        assert!(pawn(&views, &y[..15], 10, 5, 1).is_none());
    }

    /// numpy and scipy: the distances of `ks_2samp` between slices and all, with the edges of numpy's `quantile`.
    #[test]
    fn distances_are_those_of_others() {
        let (x, y) = waves(60);
        let estimates = pawn(&[&x[0], &x[1]], &y, 6, 20, 1).unwrap();
        let values: Vec<f64> = estimates.median.iter().map(|e| e.value).collect();
        near(values.try_into().unwrap(), [0.558_333_333_3, 0.225]);
        near(estimates.max.try_into().unwrap(), [0.8, 1.0 / 3.0]);
        assert!(pawn(&[&x[0]], &y, 0, 20, 1).is_none());
        assert!(pawn(&[&x[0]], &y[..12], 6, 20, 1).is_some());
        assert!(pawn(&[&x[0]], &y[..11], 6, 20, 1).is_none());
    }

    /// Resampled points are farther apart in small slices, by more than the interval is wide. Yet the interval lies about the
    /// estimate.
    #[test]
    fn intervals_lie_evenly_about_the_estimate() {
        let (x, y) = waves(400);
        let pawn = pawn(&[&x[0], &x[1]], &y, 40, 200, 1).unwrap();
        for estimate in pawn.median {
            let below = estimate.value - estimate.low;
            let above = estimate.high - estimate.value;
            assert!(0.4 * below < above && above < 2.5 * below, "{estimate:?}");
            assert!(below + above < 0.3, "{estimate:?}");
        }
    }

    /// A result comes back when it is shown: the medians, with what a parameter without influence reaches by chance.
    #[test]
    fn what_is_shown_is_what_was_found() {
        let (x, y) = waves(100);
        let columns: [&[f64]; 2] = [&x[0], &x[1]];
        let pawn = pawn(&columns, &y, SLICES, RESAMPLES, 3).unwrap();
        let [shown] = &Slices.shown(&Slices.tell(&columns, &y, 3))[..] else { panic!("one measure") };
        assert_eq!((shown.name, shown.drawn), ("PAWN", true));
        assert_eq!(shown.estimates, pawn.median);
        assert_eq!(shown.chance, Some(pawn.threshold));
        assert_eq!(Slices.shown(&Slices.tell(&columns, &[0.0; 3], 3)), []);
    }
}

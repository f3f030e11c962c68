//! Rank correlations from any points: Spearman's, and partial (PRCC), which takes the linear
//! influence of all other parameters' ranks away first.
//!
//! Iman & Conover (1979), "The use of the rank transform in regression", Technometrics 21, 499-509;
//! Marino et al. (2008), "A methodology for performing global uncertainty and sensitivity analysis
//! in systems biology", J. Theoretical Biology 254, 178-196. Intervals: jackknife on Fisher's scale.

use crate::method::{FromPoints, Measure, Told, read};
use crate::ratio::jackknife;
use nalgebra::DMatrix;
use sampling::statistics::estimate::Estimate;
use sampling::statistics::moments::{ascending, pearson, ranks_in};
use serde::{Deserialize, Serialize};
use serde_json::json;
use statrs::distribution::{ContinuousCDF, StudentsT};

/// Parts of the points that are left out in turn for the intervals.
const GROUPS: usize = 10;

/// The largest correlation that Fisher's scale is used for.
const NEARLY: f64 = 1.0 - 1e-12;

/// Rank correlations of any points.
#[derive(Clone, Copy, Debug)]
pub struct Ranks;

impl FromPoints for Ranks {
    fn name(&self) -> &'static str {
        "rank correlations"
    }

    fn tell(&self, columns: &[&[f64]], values: &[f64], _: u64) -> Told {
        let correlations = correlations(columns, values);
        Told::from_iter([("ranks".to_owned(), json!(correlations))])
    }

    fn shown(&self, told: &Told) -> Vec<Measure> {
        let correlations: Option<Correlations> = read(told, "ranks");
        let partial = correlations.map(|correlations| correlations.partial);
        let measure = partial.filter(|partial| !partial.is_empty());
        let measure = measure.map(|partial| Measure::listed("PRCC", partial));
        measure.into_iter().collect()
    }
}

/// Rank correlations of every parameter with one output.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Correlations {
    /// Spearman's rank correlation.
    pub spearman: Vec<Estimate>,
    /// Partial rank correlation; empty where the parameters' ranks are linearly dependent or the points too few, be it
    /// without a tenth of them.
    pub partial: Vec<Estimate>,
    /// Points with finite values.
    pub used: usize,
}

/// Computes the correlations of columns of parameters with an output. An output of 0 and 1, such as
/// "is verified", is an output like any other. Points without a finite value are left out.
/// A constant column correlates with nothing: 0, without an interval. `None` for fewer than four points.
pub fn correlations(parameters: &[&[f64]], output: &[f64]) -> Option<Correlations> {
    let kept: Vec<usize> =
        (0..output.len()).filter(|&j| output[j].is_finite() && parameters.iter().all(|p| p[j].is_finite())).collect();
    let points = kept.len();
    if points < 4 {
        return None;
    }
    let values = |column: &[f64]| -> Vec<f64> { kept.iter().map(|&j| column[j]).collect() };
    let columns = parameters.iter().copied().chain([output]).map(values);
    let columns: Vec<(Vec<usize>, Vec<f64>)> = columns.map(|column| (ascending(&column), column)).collect();
    let coefficients = |left_out: Option<usize>| coefficients(&columns, points, left_out);
    let all = coefficients(None);
    let groups = GROUPS.min(points);
    let without: Vec<Coefficients> = (0..groups).map(|group| coefficients(Some(group))).collect();
    let freedom = points as f64 - 3.0 - (parameters.len() as f64 - 1.0);
    let partial_of_all = without.iter().all(|part| part.partial.len() == parameters.len());
    Some(Correlations {
        spearman: estimates(&all.spearman, without.iter().map(|part| &part.spearman)),
        partial: match freedom > 0.0 && partial_of_all {
            true => estimates(&all.partial, without.iter().map(|part| &part.partial)),
            false => vec![],
        },
        used: points,
    })
}

/// Correlations of some points.
struct Coefficients {
    spearman: Vec<f64>,
    partial: Vec<f64>,
}

/// From columns with their places in ascending order; every tenth point may be left out, from one of the first ten on.
fn coefficients(columns: &[(Vec<usize>, Vec<f64>)], points: usize, left_out: Option<usize>) -> Coefficients {
    let keep = |place: &usize| left_out.is_none_or(|group| place % GROUPS != group);
    let ranked = |(order, values): &(Vec<usize>, Vec<f64>)| -> Vec<f64> {
        let order: Vec<usize> = order.iter().copied().filter(keep).collect();
        let ranks = ranks_in(&order, values);
        (0..points).filter(keep).map(|j| ranks[j]).collect()
    };
    let ranks: Vec<Vec<f64>> = columns.iter().map(ranked).collect();
    let d = columns.len() - 1;
    let mut matrix = DMatrix::identity(d + 1, d + 1);
    for a in 0..=d {
        for b in 0..a {
            matrix[(a, b)] = pearson(&ranks[a], &ranks[b]);
            matrix[(b, a)] = matrix[(a, b)];
        }
    }
    Coefficients { spearman: (0..d).map(|i| matrix[(i, d)]).collect(), partial: partial(matrix) }
}

fn partial(matrix: DMatrix<f64>) -> Vec<f64> {
    let d = matrix.nrows() - 1;
    // A singular matrix (one column a combination of others, or exact dependence) has no inverse.
    let Some(inverse) = matrix.cholesky().map(|c| c.inverse()) else {
        return vec![];
    };
    let of = |i: usize| -inverse[(i, d)] / (inverse[(i, i)] * inverse[(d, d)]).sqrt();
    (0..d).map(of).collect()
}

/// The 95 % intervals of correlations by Student's distribution on Fisher's scale, from those without a tenth of the points.
///
/// Fisher's own standard error is that of normal values. Without scatter, as outputs of a model are, it is too small for
/// partial correlations: they then depend on what the ranks bend, not on the scatter.
fn estimates<'a>(of_all: &[f64], without: impl Iterator<Item = &'a Vec<f64>>) -> Vec<Estimate> {
    // A correlation of 1 has no place on the scale.
    let scaled = |r: f64| r.clamp(-NEARLY, NEARLY).atanh();
    let without: Vec<&Vec<f64>> = without.collect();
    let estimate = |(i, &r): (usize, &f64)| {
        let parts: Vec<f64> = without.iter().map(|part| scaled(part[i])).collect();
        let half = match parts.iter().all(|part| *part == 0.0) {
            // Nothing to correlate with: there is no interval.
            true => f64::NAN,
            false => half_width(&parts),
        };
        Estimate { value: r, low: (scaled(r) - half).tanh(), high: (scaled(r) + half).tanh() }
    };
    of_all.iter().enumerate().map(estimate).collect()
}

/// Half a 95 % interval by the delete-a-group jackknife (Kott 2001): Student's, from the values with each group left out.
fn half_width(without: &[f64]) -> f64 {
    let student = StudentsT::new(0.0, 1.0, without.len() as f64 - 1.0);
    student.map_or(f64::INFINITY, |t| t.inverse_cdf(0.975) * jackknife(without))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{holds, lattice};
    use rand::{RngExt, SeedableRng, rngs::StdRng};

    fn columns(n: usize, d: usize) -> Vec<Vec<f64>> {
        let mut random = StdRng::seed_from_u64(4);
        (0..d).map(|_| (0..n).map(|_| random.random::<f64>()).collect()).collect()
    }

    #[test]
    fn a_monotone_parameter_stands_out_of_the_others() {
        let x = columns(400, 3);
        let y: Vec<f64> = (0..400).map(|j| (3.0 * x[0][j]).exp() - 2.0 * x[1][j]).collect();
        let views: Vec<&[f64]> = x.iter().map(Vec::as_slice).collect();
        let c = correlations(&views, &y).unwrap();
        assert!(c.spearman[0].value > 0.9 && c.partial[0].value > 0.95, "{c:?}");
        assert!(c.partial[1].value < c.spearman[1].value && c.partial[1].high < 0.0);
        assert!(c.partial[2].contains(0.0));
    }

    #[test]
    fn points_without_values_are_left_out() {
        let x = columns(50, 2);
        let mut y = x[0].clone();
        y[3] = f64::NAN;
        let c = correlations(&[&x[0], &x[1]], &y).unwrap();
        assert_eq!(c.used, 49);
        assert!((c.spearman[0].value - 1.0).abs() < 1e-12);
        assert!(correlations(&[&x[0][..3], &x[1][..3]], &y[..3]).is_none());
    }

    #[test]
    fn a_constant_column_correlates_with_nothing() {
        let x = columns(50, 1);
        let c = correlations(&[&[1.0; 50]], &x[0]).unwrap();
        assert_eq!(c.spearman[0].value, 0.0);
        assert!(c.spearman[0].low.is_nan() && c.spearman[0].high.is_nan());
    }

    /// scipy: `spearmanr`; for the partial ones `pearsonr` of what is left of the ranks when the others' are fitted; both with
    /// each of ten groups left out (points 1 and 11, 2 and 12, 3, ...), and Student's quantile of nine degrees of freedom.
    /// People see the partial ones.
    #[test]
    fn correlations_and_their_intervals_are_those_of_others() {
        let points = lattice(12, 3);
        let [x, y, z] = [0, 1, 2].map(|i| points.iter().map(|u| u[i]).collect::<Vec<f64>>());
        let output: Vec<f64> = points.iter().map(|u| 2.0 * u[0] - u[1] + 3.0 * (u[2] - 0.5).powi(2)).collect();
        let told = Ranks.tell(&[&x, &y, &z], &output, 1);
        let correlations: Correlations = read(&told, "ranks").unwrap();
        holds(correlations.spearman[0], [0.958_041_958_0, 0.828_963_333_1, 0.990_227_516_7]);
        holds(correlations.spearman[1], [-0.188_811_188_8, -0.743_867_951_7, 0.520_390_868_7]);
        holds(correlations.partial[0], [0.981_365_007_6, 0.870_997_751_1, 0.997_437_413_0]);
        holds(correlations.partial[1], [-0.769_974_808_1, -0.994_273_198_7, 0.709_366_301_4]);
        holds(correlations.partial[2], [0.049_631_871_8, -0.932_510_280_2, 0.944_333_205_6]);
        assert_eq!(Ranks.shown(&told), [Measure::listed("PRCC", correlations.partial)]);
    }

    /// Four points have a rank correlation. A partial one needs more of them, the more parameters there are.
    #[test]
    fn few_points_have_no_partial_correlation() {
        let columns = [[1.0, 2.0, 3.0, 4.0, 5.0, 6.0], [2.0, 5.0, 1.0, 4.0, 3.0, 6.0]];
        let output = [1.0, 3.0, 2.0, 5.0, 6.0, 4.0];
        let told = |points: usize| {
            let columns: Vec<&[f64]> = columns.iter().map(|c| &c[..points]).collect();
            Ranks.tell(&columns, &output[..points], 1)
        };
        let four: Correlations = read(&told(4), "ranks").unwrap();
        assert_eq!((four.spearman.len(), four.partial.len()), (2, 0));
        assert_eq!(Ranks.shown(&told(4)), []);
        assert_eq!(Ranks.shown(&told(6))[0].estimates.len(), 2);
        assert_eq!(Ranks.shown(&told(3)), []);
    }
}

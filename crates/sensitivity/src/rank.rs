//! Rank correlations from any points: Spearman's, and partial (PRCC), which takes the linear
//! influence of all other parameters' ranks away first.
//!
//! Iman & Conover (1979), "The use of the rank transform in regression", Technometrics 21, 499-509;
//! Marino et al. (2008), "A methodology for performing global uncertainty and sensitivity analysis
//! in systems biology", J. Theoretical Biology 254, 178-196. Intervals: Fisher's z.

use crate::Estimate;
use crate::method::{FromPoints, Measure, Told, read};
use nalgebra::DMatrix;
use sampling::statistics::moments::{pearson, ranks};
use sampling::statistics::share::Z95;
use serde::{Deserialize, Serialize};
use serde_json::json;

/// Rank correlations of any points.
#[derive(Clone, Copy, Debug)]
pub struct Ranks;

impl FromPoints for Ranks {
    fn tell(&self, columns: &[&[f64]], values: &[f64], _: u64) -> Told {
        let found = correlations(columns, values);
        Told::from_iter([("ranks".to_owned(), json!(found))])
    }

    fn shown(&self, told: &Told) -> Vec<Measure> {
        let found: Option<Correlations> = read(told, "ranks");
        let partial = found.map(|found| found.partial);
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
    /// Partial rank correlation; empty where the parameters' ranks are linearly dependent or the
    /// points too few.
    pub partial: Vec<Estimate>,
    /// Points with finite values.
    pub used: usize,
}

/// Computes the correlations of columns of parameters with an output. An output of 0 and 1, such as
/// "is verified", is an output like any other. Points without a finite value are left out.
/// A constant column correlates with nothing. `None` for fewer than four points.
pub fn correlations(parameters: &[&[f64]], output: &[f64]) -> Option<Correlations> {
    let kept: Vec<usize> = (0..output.len())
        .filter(|&j| output[j].is_finite() && parameters.iter().all(|p| p[j].is_finite()))
        .collect();
    let n = kept.len();
    if n < 4 {
        return None;
    }
    let ranked = |column: &[f64]| ranks(&kept.iter().map(|&j| column[j]).collect::<Vec<_>>());
    let columns: Vec<Vec<f64>> = parameters
        .iter()
        .map(|p| ranked(p))
        .chain([ranked(output)])
        .collect();
    let d = parameters.len();
    let matrix = DMatrix::from_fn(d + 1, d + 1, |a, b| {
        if a == b {
            1.0
        } else {
            pearson(&columns[a], &columns[b])
        }
    });
    let spearman = (0..d)
        .map(|i| fisher(matrix[(i, d)], n as f64 - 3.0))
        .collect();
    let freedom = n as f64 - 3.0 - (d as f64 - 1.0);
    let partial = if freedom > 0.0 {
        partial(matrix, freedom)
    } else {
        vec![]
    };
    Some(Correlations {
        spearman,
        partial,
        used: n,
    })
}

fn partial(matrix: DMatrix<f64>, freedom: f64) -> Vec<Estimate> {
    let d = matrix.nrows() - 1;
    // A singular matrix (one column a combination of others, or exact dependence) has no inverse.
    let Some(inverse) = matrix.cholesky().map(|c| c.inverse()) else {
        return vec![];
    };
    (0..d)
        .map(|i| {
            fisher(
                -inverse[(i, d)] / (inverse[(i, i)] * inverse[(d, d)]).sqrt(),
                freedom,
            )
        })
        .collect()
}

/// The 95 % interval of a correlation by Fisher's transform.
fn fisher(r: f64, freedom: f64) -> Estimate {
    let (z, half) = (r.clamp(-1.0, 1.0).atanh(), Z95 / freedom.sqrt());
    Estimate {
        value: r,
        low: (z - half).tanh(),
        high: (z + half).tanh(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{holds, lattice};
    use rand::{RngExt, SeedableRng, rngs::StdRng};

    fn columns(n: usize, d: usize) -> Vec<Vec<f64>> {
        let mut random = StdRng::seed_from_u64(4);
        (0..d)
            .map(|_| (0..n).map(|_| random.random::<f64>()).collect())
            .collect()
    }

    #[test]
    fn a_monotone_parameter_stands_out_of_the_others() {
        let x = columns(400, 3);
        let y: Vec<f64> = (0..400)
            .map(|j| (3.0 * x[0][j]).exp() - 2.0 * x[1][j])
            .collect();
        let views: Vec<&[f64]> = x.iter().map(Vec::as_slice).collect();
        let c = correlations(&views, &y).unwrap();
        assert!(
            c.spearman[0].value > 0.9 && c.partial[0].value > 0.95,
            "{c:?}"
        );
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
    }

    /// scipy: `spearmanr`; for the partial ones `pearsonr` of what is left of the ranks when the others' are fitted; both with
    /// Fisher's interval, of 9 and of 7 degrees of freedom. People see the partial ones.
    #[test]
    fn correlations_and_their_intervals_are_those_of_others() {
        let points = lattice(12, 3);
        let [x, y, z] = [0, 1, 2].map(|i| points.iter().map(|u| u[i]).collect::<Vec<f64>>());
        let output: Vec<f64> = points
            .iter()
            .map(|u| 2.0 * u[0] - u[1] + 3.0 * (u[2] - 0.5).powi(2))
            .collect();
        let told = Ranks.tell(&[&x, &y, &z], &output, 1);
        let found: Correlations = read(&told, "ranks").unwrap();
        holds(
            found.spearman[0],
            [0.958_041_958_0, 0.853_307_347_4, 0.988_464_316_7],
        );
        holds(
            found.spearman[1],
            [-0.188_811_188_8, -0.688_145_965_1, 0.431_889_570_3],
        );
        holds(
            found.partial[0],
            [0.981_365_007_6, 0.920_524_640_8, 0.995_734_013_2],
        );
        holds(
            found.partial[1],
            [-0.769_974_808_1, -0.942_621_573_0, -0.272_413_672_8],
        );
        holds(
            found.partial[2],
            [0.049_631_871_8, -0.598_703_636_9, 0.658_674_890_3],
        );
        assert_eq!(Ranks.shown(&told), [Measure::listed("PRCC", found.partial)]);
    }

    /// Four points have a rank correlation. A partial one needs more of them, the more parameters there are.
    #[test]
    fn few_points_have_no_partial_correlation() {
        let columns = [[1.0, 2.0, 3.0, 4.0, 5.0], [2.0, 5.0, 1.0, 4.0, 3.0]];
        let output = [1.0, 3.0, 5.0, 2.0, 4.0];
        let found = |points: usize| {
            let columns: Vec<&[f64]> = columns.iter().map(|c| &c[..points]).collect();
            Ranks.tell(&columns, &output[..points], 1)
        };
        let four: Correlations = read(&found(4), "ranks").unwrap();
        assert_eq!((four.spearman.len(), four.partial.len()), (2, 0));
        assert_eq!(Ranks.shown(&found(4)), []);
        assert_eq!(Ranks.shown(&found(5))[0].estimates.len(), 2);
        assert_eq!(Ranks.shown(&found(3)), []);
    }
}

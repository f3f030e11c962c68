//! Latin hypercubes of correlated inputs. Mixing scores moves points out of their slices, so that some slices hold several
//! and others none. Therefore only the ranks of the mixed scores count: they say in which slice a point lies (Stein 1987,
//! "Large sample properties of simulations using Latin hypercube sampling", Technometrics 29, section 5).
//!
//! Before they are mixed, the scores are freed from the correlations that they have by chance (Iman, Conover 1982, "A
//! distribution-free approach to inducing rank correlation among input variables", Commun. Stat. B 11). What the ranks
//! change in the coefficients is taken out in the same way, several times.

use nalgebra::DMatrix;

use super::{
    correlation::Correlation,
    rule::{Inputs, Rule},
    slices::{Slices, ranks},
};
use crate::distribution::normal_quantile;

/// All points must be known at once; more of them than these need no slices.
const MOST: u64 = 1 << 24;
/// How often the coefficients are corrected; more corrections change few ranks.
const ROUNDS: usize = 8;

/// The rule whose points lie one in each slice, as those of `rule`, with the correlations that are wanted.
///
/// # Errors
/// When there are too many points for a table.
pub(super) fn correlated(
    rule: &dyn Rule,
    (seed, points): (u64, u64),
    correlation: &Correlation,
    inputs: &Inputs,
) -> Result<Slices, String> {
    let points = in_a_table(points)?;
    let varying: Vec<usize> =
        (0..inputs.distributions.len()).filter(|&input| inputs.distributions[input].varies()).collect();
    let wanted = correlation
        .among(&varying)
        .cholesky()
        .ok_or("the correlations of the parameters that vary contradict each other")?;
    // Indices are below lengths.
    let start = DMatrix::from_fn(points, varying.len(), |index, dimension| {
        normal_quantile(rule.uniform(index as u64, dimension as u32))
    });
    let scores = DMatrix::from_fn(points, varying.len(), |slice, dimension| {
        normal_quantile(Slices::place(seed, points, slice as u32, dimension as u32))
    });
    Ok(Slices::new(seed, points, paired(start, &scores, &wanted.l())))
}

/// So many points, where a table may have them.
fn in_a_table(points: u64) -> Result<usize, String> {
    usize::try_from(points).ok().filter(|_| points <= MOST).ok_or_else(|| {
        format!(
            "a Latin hypercube of correlated parameters has at most {MOST} points; for more use method = \"sobol\" or \
             \"monte-carlo\""
        )
    })
}

/// The slices of correlated inputs, input after input. `start` are the scores of points of independent inputs, `slices` those
/// of the places in each slice, and `factor` is the Cholesky factor of the wanted coefficients.
fn paired(start: DMatrix<f64>, slices: &DMatrix<f64>, factor: &DMatrix<f64>) -> Vec<Vec<u32>> {
    let wanted = factor * factor.transpose();
    let mut scores = start;
    // The scores of few points may depend on each other linearly: these are mixed as they are.
    let mut best = (f64::INFINITY, ranked(&(&scores * factor.transpose())));
    for _ in 0..ROUNDS {
        let Some(cholesky) = coefficients(&scores).cholesky() else { break };
        let Some(free) = cholesky.l().try_inverse() else { break };
        let ranks = ranked(&(&scores * (factor * free).transpose()));
        scores = DMatrix::from_fn(scores.nrows(), scores.ncols(), |point, input| {
            slices[(ranks[input][point] as usize, input)]
        });
        let off = (coefficients(&scores) - &wanted).amax();
        if off < best.0 {
            best = (off, ranks);
        }
    }
    best.1
}

fn ranked(scores: &DMatrix<f64>) -> Vec<Vec<u32>> {
    scores.column_iter().map(|c| ranks(c.as_slice())).collect()
}

/// Pearson's coefficients of the columns.
fn coefficients(columns: &DMatrix<f64>) -> DMatrix<f64> {
    let mut centred = columns.clone();
    for mut column in centred.column_iter_mut() {
        let mean = column.mean();
        column.add_scalar_mut(-mean);
        column.unscale_mut(column.norm());
    }
    centred.transpose() * centred
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::design::{Design, Method, Sampling};
    use crate::distribution::Distribution;

    const UNIT: Distribution = Distribution::Uniform { min: 0.0, max: 1.0 };
    const PAIRS: [(usize, usize, f64); 3] = [(0, 1, 0.8), (0, 4, -0.5), (1, 4, -0.2)];

    /// Five inputs, the third one fixed, the fourth one correlated with none.
    fn points(method: Method, points: u64, seed: u64) -> Vec<Vec<f64>> {
        let sampling = Sampling { method, points, seed, replicates: 1 };
        let fixed = Distribution::Fixed { value: 3.0 };
        let inputs = Inputs {
            joints: Vec::new(),
            distributions: vec![UNIT, UNIT, fixed, UNIT, UNIT],
            levels: Vec::new(),
            correlation: Some(Correlation::new(5, &PAIRS).unwrap()),
        };
        let design = Design::new(&sampling, inputs).unwrap();
        (0..points).map(|index| design.point(index)).collect()
    }

    fn column(points: &[Vec<f64>], input: usize, f: impl Fn(f64) -> f64) -> Vec<f64> {
        points.iter().map(|point| f(point[input])).collect()
    }

    fn coefficient(a: Vec<f64>, b: Vec<f64>) -> f64 {
        coefficients(&DMatrix::from_vec(a.len(), 2, [a, b].concat()))[(0, 1)]
    }

    fn wanted(a: usize, b: usize) -> f64 {
        let pair = PAIRS.iter().find(|pair| (pair.0, pair.1) == (a, b));
        pair.map_or(0.0, |pair| pair.2)
    }

    const METHODS: [Method; 2] = [Method::LatinHypercube, Method::OptimisedLatinHypercube];
    const INPUTS: [(usize, usize); 6] = [(0, 1), (0, 3), (0, 4), (1, 3), (1, 4), (3, 4)];

    #[test]
    fn every_slice_holds_one_point() {
        for (method, count) in METHODS.into_iter().flat_map(|m| [1, 2, 5, 64].map(|n| (m, n))) {
            let points = points(method, count, 3);
            for input in [0, 1, 3, 4] {
                let mut slices = column(&points, input, |u| (u * count as f64).floor());
                slices.sort_by(f64::total_cmp);
                let all: Vec<f64> = (0..count).map(|slice| slice as f64).collect();
                assert_eq!(slices, all, "{method:?} {input}");
            }
            assert!(points.iter().all(|point| point[2] == 3.0));
        }
    }

    /// The coefficients of the normal scores, and Spearman's, which follow from them for a Gaussian copula: 6 / pi
    /// asin(r / 2) (Pearson 1907).
    #[test]
    fn the_coefficients_are_those_wanted() {
        for (method, count, most, most_of_ranks) in [
            (Method::LatinHypercube, 20, 0.1, 0.25),
            (Method::OptimisedLatinHypercube, 20, 0.1, 0.25),
            (Method::LatinHypercube, 50, 0.04, 0.15),
            (Method::OptimisedLatinHypercube, 50, 0.04, 0.15),
            (Method::LatinHypercube, 1000, 2e-3, 3e-2),
        ] {
            let points = points(method, count, 7);
            for (a, b) in INPUTS {
                let r = wanted(a, b);
                let [x, y] = [a, b].map(|input| column(&points, input, normal_quantile));
                let of_scores = coefficient(x, y);
                assert!((of_scores - r).abs() < most, "{method:?} {count} {a} {b}: {of_scores}");
                let slice = |u: f64| (u * count as f64).floor();
                let [x, y] = [a, b].map(|input| column(&points, input, slice));
                let of_slices = coefficient(x, y);
                let off = of_slices - 6.0 / std::f64::consts::PI * (r / 2.0).asin();
                assert!(off.abs() < most_of_ranks, "{method:?} {count} {a} {b}: {off}");
            }
        }
    }

    /// Both inputs are above their medians with the probability of the Gaussian copula (Sheppard 1899).
    #[test]
    fn the_points_are_distributed_as_the_copula() {
        let points = points(Method::LatinHypercube, 4000, 5);
        for (a, b) in INPUTS {
            let above = points.iter().filter(|p| p[a] > 0.5 && p[b] > 0.5).count();
            let expected = 0.25 + wanted(a, b).asin() / std::f64::consts::TAU;
            let off = above as f64 / 4000.0 - expected;
            assert!(off.abs() < 8e-3, "{a} {b}: {off}");
        }
    }

    /// Three points of four inputs: their scores depend on each other linearly.
    #[test]
    fn few_points_are_mixed_as_they_are() {
        let points = points(Method::LatinHypercube, 3, 9);
        let free = {
            let sampling = Sampling { method: Method::LatinHypercube, points: 3, seed: 9, replicates: 1 };
            let design = Design::new(&sampling, vec![UNIT; 4]).unwrap();
            (0..3).map(|index| design.point(index)).collect::<Vec<_>>()
        };
        let mixed: Vec<f64> = free.iter().map(|p| 0.8 * normal_quantile(p[0]) + 0.6 * normal_quantile(p[1])).collect();
        let slices: Vec<u32> = points.iter().map(|p| (3.0 * p[1]) as u32).collect();
        assert_eq!(slices, ranks(&mixed));
    }

    #[test]
    fn a_table_has_so_many_points_and_no_more() {
        assert_eq!(in_a_table(MOST), Ok(1 << 24));
        assert!(in_a_table(MOST + 1).is_err());
    }

    #[test]
    fn too_many_points_are_refused_with_the_remedy() {
        let sampling = Sampling { method: Method::LatinHypercube, points: MOST + 1, seed: 1, replicates: 1 };
        let inputs = Inputs {
            joints: Vec::new(),
            distributions: vec![UNIT; 2],
            levels: Vec::new(),
            correlation: Some(Correlation::new(2, &[(0, 1, 0.5)]).unwrap()),
        };
        let error = Design::new(&sampling, inputs).unwrap_err();
        assert!(error.contains("16777216") && error.contains("sobol"), "{error}");
    }
}

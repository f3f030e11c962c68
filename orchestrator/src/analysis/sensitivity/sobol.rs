//! Sobol indices: the part of an output's variance that a parameter explains alone (first order),
//! and with all its interactions (total).
//!
//! Design: Saltelli et al. (2010), "Variance based sensitivity analysis of model output",
//! Computer Physics Communications 181, 259-270: two independent samples A and B, and for every
//! parameter i the sample A_B^(i), which is A with column i from B.

use super::Estimate;
use super::method::{FirstOrder, FromRuns, Measure, Settled, Told, read};
use sampling::statistics::moments::mean;
use serde::{Deserialize, Serialize};
use serde_json::json;
use statrs::distribution::{ContinuousCDF, StudentsT};

/// Sobol indices by runs of their own.
#[derive(Clone, Copy, Debug)]
pub struct Sobol;

impl FromRuns for Sobol {
    fn name(&self) -> &'static str {
        "sobol"
    }

    fn option(&self) -> &'static str {
        "base"
    }

    fn title(&self, size: u64) -> String {
        format!("Sobol indices from {size} base points")
    }

    fn usual_size(&self) -> u64 {
        256
    }

    fn runs(&self, parameters: u64, size: u64) -> u64 {
        size * (parameters + 2)
    }

    fn design(&self, parameters: usize, settled: &Settled) -> Result<Vec<Vec<f64>>, String> {
        let replicates = replicates(settled.size);
        let pairs = sampling::design::cube(2 * parameters, settled.size, settled.seed, replicates)?;
        Ok(design(&pairs))
    }

    /// The rows of A and B.
    fn plain_sample(&self, parameters: usize, rows: usize) -> Vec<usize> {
        let width = parameters + 2;
        (0..rows)
            .filter(|k| k % width == 0 || k % width == width - 1)
            .collect()
    }

    fn done(&self, parameters: usize, runs: usize, settled: &Settled) -> String {
        format!(
            "Sobol indices from {} base points in {} randomisations ({runs} runs); rank correlations and PAWN of their plain sample",
            runs / (parameters + 2),
            replicates(settled.size),
        )
    }

    fn tell(&self, design: &[Vec<f64>], values: &[f64], settled: &Settled) -> Told {
        let parameters = design.first().map_or(0, Vec::len);
        let replicates = replicates(settled.size);
        let found = indices(values, parameters, settled.estimator, replicates);
        let growing = convergence(values, parameters, settled.estimator, replicates);
        let totals = |s: Indices| s.total.iter().map(|e| e.value).collect::<Vec<f64>>();
        let growing: Vec<_> = growing.into_iter().map(|(n, s)| (n, totals(s))).collect();
        let [sobol, convergence] = [json!(found), json!(growing)];
        Told::from_iter([
            ("sobol".to_owned(), sobol),
            ("convergence".to_owned(), convergence),
        ])
    }

    fn shown(&self, told: &Told) -> Vec<Measure> {
        let found: Option<Indices> = read(told, "sobol");
        found.map_or_else(Vec::new, |found| {
            vec![
                Measure::drawn("total", found.total),
                Measure::drawn("first order", found.first),
            ]
        })
    }
}

/// The rows of the design in the unit cube, in the order A, A_B^(1) .. A_B^(d), B for every pair.
///
/// `pairs` are points of a sample of 2 d dimensions: the first d are A's, the last d are B's.
pub fn design(pairs: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let mut rows = Vec::new();
    for pair in pairs {
        let (a, b) = pair.split_at(pair.len() / 2);
        rows.push(a.to_vec());
        for i in 0..a.len() {
            let mut mixed = a.to_vec();
            mixed[i] = b[i];
            rows.push(mixed);
        }
        rows.push(b.to_vec());
    }
    rows
}

/// The number of independently scrambled nets from which the base points should come: as many as
/// Student's quantile asks for, as long as each keeps some points.
pub fn replicates(base: u64) -> u64 {
    (base / 8).clamp(2, 16)
}

/// Sobol indices of one output.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Indices {
    /// First-order index of every parameter.
    pub first: Vec<Estimate>,
    /// Total index of every parameter.
    pub total: Vec<Estimate>,
    /// Base points of which every value of the parameter's comparison was there.
    pub used: Vec<usize>,
    /// Runs without a finite value.
    pub failed: usize,
}

/// Model values that belong to one base point: at A, at each A_B^(i), at B.
struct Rows<'a> {
    values: &'a [f64],
    width: usize,
}

impl Rows<'_> {
    fn a(&self, j: usize) -> f64 {
        self.values[j * self.width]
    }
    fn ab(&self, j: usize, i: usize) -> f64 {
        self.values[j * self.width + 1 + i]
    }
    fn b(&self, j: usize) -> f64 {
        self.values[j * self.width + self.width - 1]
    }
}

/// Computes the indices from the outputs of the rows of [`design`], in its order.
///
/// The outputs are first shifted to mean 0, because the estimators are biased for others. A base
/// point of which A, B or A_B^(i) has no finite value is left out for parameter i; the variance is
/// that of the finite values of A and B. All indices of a constant output are 0.
///
/// The base points belong to `replicates` independent randomisations in turn: point j to
/// j mod `replicates`. The intervals are Student's, from the indices with each randomisation left out
/// (delete-a-group jackknife; Kott 2001, "The delete-a-group jackknife", J. Official Statistics 17).
/// A bootstrap of the points would not know how evenly a quasi-random sample fills the space.
///
/// Returns `None` where the number of outputs is no multiple of `parameters + 2`, or fewer than
/// two randomisations have complete base points.
pub fn indices(
    outputs: &[f64],
    parameters: usize,
    estimator: FirstOrder,
    replicates: u64,
) -> Option<Indices> {
    let width = parameters + 2;
    if parameters == 0 || outputs.is_empty() || !outputs.len().is_multiple_of(width) {
        return None;
    }
    let finite: Vec<f64> = outputs.iter().copied().filter(|v| v.is_finite()).collect();
    let centre = mean(&finite);
    let centred: Vec<f64> = outputs.iter().map(|v| v - centre).collect();
    let rows = Rows {
        values: &centred,
        width,
    };
    let n = outputs.len() / width;
    let ends: Vec<usize> = (0..n)
        .filter(|&j| rows.a(j).is_finite() && rows.b(j).is_finite())
        .collect();
    let mut result = Indices {
        first: vec![],
        total: vec![],
        used: vec![],
        failed: outputs.len() - finite.len(),
    };
    for i in 0..parameters {
        let complete: Vec<usize> = ends
            .iter()
            .copied()
            .filter(|&j| rows.ab(j, i).is_finite())
            .collect();
        let (first, total) = estimate(&rows, &complete, &ends, i, estimator);
        let without = |group: u64| {
            let others = |points: &[usize]| -> Vec<usize> {
                let keep = |j: &&usize| **j as u64 % replicates != group;
                points.iter().filter(keep).copied().collect()
            };
            let (points, ends) = (others(&complete), others(&ends));
            let part = points.len() < complete.len() && !points.is_empty();
            part.then(|| estimate(&rows, &points, &ends, i, estimator))
        };
        let parts: Vec<(f64, f64)> = (0..replicates).filter_map(without).collect();
        let student = StudentsT::new(0.0, 1.0, parts.len() as f64 - 1.0).ok()?;
        let around = |value: f64, parts: Vec<f64>| {
            Estimate::around(value, student.inverse_cdf(0.975) * jackknife(&parts))
        };
        result
            .first
            .push(around(first, parts.iter().map(|p| p.0).collect()));
        result
            .total
            .push(around(total, parts.iter().map(|p| p.1).collect()));
        result.used.push(complete.len());
    }
    Some(result)
}

/// The standard error of an estimate from its values with each group left out.
fn jackknife(without: &[f64]) -> f64 {
    let (n, centre) = (without.len() as f64, mean(without));
    let squares: f64 = without.iter().map(|v| (v - centre).powi(2)).sum();
    ((n - 1.0) / n * squares).sqrt()
}

/// First-order and total index of one parameter over some base points, with the variance of others.
fn estimate(
    rows: &Rows<'_>,
    points: &[usize],
    ends: &[usize],
    i: usize,
    estimator: FirstOrder,
) -> (f64, f64) {
    let n = points.len() as f64;
    let m = 2.0 * ends.len() as f64;
    let centre = ends.iter().map(|&j| rows.a(j) + rows.b(j)).sum::<f64>() / m;
    let v = ends
        .iter()
        .map(|&j| (rows.a(j) - centre).powi(2) + (rows.b(j) - centre).powi(2))
        .sum::<f64>()
        / m;
    if v <= f64::EPSILON * centre.powi(2).max(f64::MIN_POSITIVE) {
        return (0.0, 0.0);
    }
    let total = points
        .iter()
        .map(|&j| (rows.a(j) - rows.ab(j, i)).powi(2))
        .sum::<f64>()
        / (2.0 * n);
    let first = match estimator {
        FirstOrder::Saltelli => {
            points
                .iter()
                .map(|&j| rows.b(j) * (rows.ab(j, i) - rows.a(j)))
                .sum::<f64>()
                / n
        }
        FirstOrder::Jansen => {
            v - points
                .iter()
                .map(|&j| (rows.b(j) - rows.ab(j, i)).powi(2))
                .sum::<f64>()
                / (2.0 * n)
        }
    };
    (first / v, total / v)
}

/// Indices from growing parts of the design, to show convergence: base points, indices.
pub fn convergence(
    outputs: &[f64],
    parameters: usize,
    estimator: FirstOrder,
    replicates: u64,
) -> Vec<(usize, Indices)> {
    let width = parameters + 2;
    let n = outputs.len() / width;
    let mut sizes: Vec<usize> =
        std::iter::successors(Some(n), |m| (*m / 2 >= 32).then_some(m / 2)).collect();
    sizes.reverse();
    sizes
        .into_iter()
        .filter_map(|m| {
            let part = &outputs[..m * width];
            Some((m, indices(part, parameters, estimator, replicates)?))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::super::functions::{ishigami, ishigami_indices, sobol_g, sobol_g_indices};
    use super::*;
    use rand::{RngExt, SeedableRng, rngs::StdRng};
    use sampling::design::{Design, Method, Sampling};
    use sampling::distribution::Distribution;

    /// Pairs as the command takes them.
    fn scrambled_pairs(base: u64, d: usize, seed: u64) -> Vec<Vec<f64>> {
        let design = Sampling {
            method: Method::Sobol,
            points: base,
            seed,
            replicates: replicates(base),
        };
        let unit = Distribution::Uniform { min: 0.0, max: 1.0 };
        let design = Design::new(&design, vec![unit; 2 * d]).unwrap();
        (0..base).map(|index| design.point(index)).collect()
    }

    fn random_pairs(n: usize, d: usize, seed: u64) -> Vec<Vec<f64>> {
        let mut random = StdRng::seed_from_u64(seed);
        (0..n)
            .map(|_| (0..2 * d).map(|_| random.random::<f64>()).collect())
            .collect()
    }

    /// A lattice that any language can write down.
    fn lattice(n: usize, d: usize) -> Vec<Vec<f64>> {
        let primes = [2.0f64, 3.0, 5.0, 7.0, 11.0, 13.0, 17.0, 19.0];
        (1..=n)
            .map(|k| {
                primes[..2 * d]
                    .iter()
                    .map(|p| (k as f64 * p.sqrt()).fract())
                    .collect()
            })
            .collect()
    }

    fn evaluate(pairs: &[Vec<f64>], f: impl Fn(&[f64]) -> f64) -> Vec<f64> {
        design(pairs).iter().map(|u| f(u)).collect()
    }

    /// SALib 1.5 on the same rows: `sobol.analyze(problem, Y, calc_second_order=False)`.
    #[test]
    fn equal_to_salib_on_the_same_design() {
        let y = evaluate(&lattice(256, 3), ishigami);
        let s = indices(&y, 3, FirstOrder::Saltelli, 16).unwrap();
        for (i, (first, total)) in SALIB_ISHIGAMI.into_iter().enumerate() {
            assert!(
                (s.first[i].value - first).abs() < 1e-10,
                "{i} {:?}",
                s.first[i]
            );
            assert!(
                (s.total[i].value - total).abs() < 1e-10,
                "{i} {:?}",
                s.total[i]
            );
        }
    }
    const SALIB_ISHIGAMI: [(f64, f64); 3] = [
        (0.24393037317358926, 0.3972198967359823),
        (0.4862270491131861, 0.432243463350163),
        (-0.027736213144616974, 0.23831541149659913),
    ];

    #[test]
    fn both_estimators_converge_to_the_exact_indices() {
        let (first, total) = ishigami_indices();
        let y = evaluate(&random_pairs(40_000, 3, 5), ishigami);
        for estimator in [FirstOrder::Saltelli, FirstOrder::Jansen] {
            let s = indices(&y, 3, estimator, 16).unwrap();
            for (found, exact) in s.first.iter().zip(first).chain(s.total.iter().zip(total)) {
                assert!(
                    (found.value - exact).abs() < 0.03,
                    "{estimator:?} {found:?} {exact}"
                );
            }
        }
    }

    /// The short form of `cargo run --release --example coverage`.
    #[test]
    fn intervals_hold_the_exact_indices_in_95_per_cent_of_repetitions() {
        const REPETITIONS: u64 = 200;
        const BASE: u64 = 256;
        let a = [0.0, 1.0, 4.5, 9.0];
        let (gf, gt) = sobol_g_indices(&a);
        let (hf, ht) = ishigami_indices();
        let count = |s: &Indices, first: &[f64], total: &[f64]| {
            let pairs = s.first.iter().zip(first).chain(s.total.iter().zip(total));
            pairs
                .filter(|(found, exact)| found.contains(**exact))
                .count() as f64
        };
        let (mut ishigami_held, mut g_held) = (0.0, 0.0);
        for seed in 0..REPETITIONS {
            let y = evaluate(&scrambled_pairs(BASE, 3, 1000 + seed), ishigami);
            let s = indices(&y, 3, FirstOrder::Jansen, replicates(BASE)).unwrap();
            ishigami_held += count(&s, &hf, &ht) / (6 * REPETITIONS) as f64;
            let y = evaluate(&scrambled_pairs(BASE, 4, 2000 + seed), |u| sobol_g(u, &a));
            let s = indices(&y, 4, FirstOrder::Jansen, replicates(BASE)).unwrap();
            g_held += count(&s, &gf, &gt) / (8 * REPETITIONS) as f64;
        }
        for coverage in [ishigami_held, g_held] {
            assert!((coverage - 0.95).abs() <= 0.03, "{ishigami_held} {g_held}");
        }
    }

    #[test]
    fn failed_runs_are_left_out_and_counted() {
        let (first, _) = ishigami_indices();
        let mut y = evaluate(&random_pairs(20_000, 3, 9), ishigami);
        for k in (0..y.len()).step_by(97) {
            y[k] = f64::NAN;
        }
        let failed = y.iter().filter(|v| v.is_nan()).count();
        let s = indices(&y, 3, FirstOrder::Saltelli, 16).unwrap();
        assert_eq!(s.failed, failed);
        assert!(s.used.iter().all(|&u| u < 20_000 && u > 19_000));
        for (found, exact) in s.first.iter().zip(first) {
            assert!((found.value - exact).abs() < 0.04, "{found:?} {exact}");
        }
    }

    #[test]
    fn a_constant_output_depends_on_nothing() {
        let s = indices(&[7.0; 40], 3, FirstOrder::Saltelli, 16).unwrap();
        assert!(s.first.iter().chain(&s.total).all(|e| e.value == 0.0));
        assert_eq!(indices(&[1.0; 41], 3, FirstOrder::Saltelli, 16), None);
    }

    #[test]
    fn convergence_ends_with_the_whole_design() {
        let y = evaluate(&random_pairs(256, 3, 3), ishigami);
        let steps = convergence(&y, 3, FirstOrder::Saltelli, 16);
        assert_eq!(
            steps.iter().map(|s| s.0).collect::<Vec<_>>(),
            [32, 64, 128, 256]
        );
        assert_eq!(
            steps[3].1,
            indices(&y, 3, FirstOrder::Saltelli, 16).unwrap()
        );
    }
}

//! Sobol indices: the part of an output's variance that a parameter explains alone (first order),
//! and with all its interactions (total).
//!
//! Design: Saltelli et al. (2010), "Variance based sensitivity analysis of model output",
//! Computer Physics Communications 181, 259-270: two independent samples A and B, and for every
//! parameter i the sample A_B^(i), which is A with column i from B.

use crate::{
    method::{Facts, FirstOrder, FromRuns, KeyedResults, Measure, Settled, read},
    pairs::pairs,
    ratio::{self, Combined, Parts},
};
use sampling::statistics::{estimate::Estimate, moments::mean};
use serde::{Deserialize, Serialize};
use serde_json::json;

/// Sobol indices by runs of their own.
#[derive(Clone, Copy, Debug)]
pub struct Sobol;

impl FromRuns for Sobol {
    fn facts(&self) -> Facts {
        Facts {
            name: "sobol",
            option: "base",
            words: ["Sobol indices from", "base points"],
            usual_size: 256,
            tried_size: 64,
        }
    }

    fn runs(&self, parameters: usize, size: u64) -> u64 {
        size * (parameters as u64 + 2)
    }

    fn design(&self, parameters: usize, settled: &Settled) -> Result<Vec<Vec<f64>>, String> {
        let pairs = pairs(parameters, settled.size, settled.seed)?;
        Ok(design(&pairs))
    }

    fn tell(&self, design: &[Vec<f64>], values: &[f64], _: &Settled) -> KeyedResults {
        let parameters = design.first().map_or(0, Vec::len);
        let indices = indices(values, parameters, FirstOrder::default());
        let growing = convergence(values, parameters);
        let totals = |s: Indices| s.total.iter().map(|e| e.value).collect::<Vec<f64>>();
        let growing: Vec<_> = growing.into_iter().map(|(n, s)| (n, totals(s))).collect();
        KeyedResults::from_iter([("sobol".to_owned(), json!(indices)), ("convergence".to_owned(), json!(growing))])
    }

    fn shown(&self, told: &KeyedResults) -> Vec<Measure> {
        let Some(indices) = read::<Indices>(told, "sobol") else { return Vec::new() };
        vec![Measure::drawn("total", indices.total), Measure::drawn("first order", indices.first)]
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

/// Sobol indices of one output.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Indices {
    /// First-order index of every parameter.
    pub first: Vec<Estimate>,
    /// Total index of every parameter.
    pub total: Vec<Estimate>,
    /// Base points of which both runs of the parameter's total index have values.
    pub used: Vec<usize>,
    /// Runs without a finite value.
    pub failed: usize,
}

/// A base point's term of an estimator, from its part of V and the values of its runs of A, A_B and B.
type Term = fn(f64, [f64; 3]) -> f64;

/// Two estimators of the variance that a parameter explains alone: [Saltelli's](FirstOrder::Saltelli) product and
/// [Jansen's](FirstOrder::Jansen) difference.
const FIRST: [Term; 2] = [|_, [a, ab, b]| b * (ab - a), |v, [_, ab, b]| v - 0.5 * (b - ab).powi(2)];

/// Jansen's difference without V, which needs two runs only.
const DIFFERENCE: Term = |_, [_, ab, b]| -0.5 * (b - ab).powi(2);

/// Of what the others leave unexplained: V without the product of A and B exchanged, and Jansen's difference.
const TOTAL: [Term; 2] = [|v, [a, ab, b]| v - a * (ab - b), |_, [a, ab, _]| 0.5 * (a - ab).powi(2)];

/// The standard deviation of an estimator's terms over the root of their number, if the values of A, or of B, were independent of the
/// other two: with those of other base points. The smaller one of both.
///
/// A product of two values is large where both are. Where that is rare, the base points may have no such pair, so that their
/// scatter does not show it; with so many further pairs it does. One of the two partings leaves those runs together that share nearly
/// all that matters.
fn apart(runs: &[[f64; 3]], term: impl Fn([f64; 3]) -> f64) -> f64 {
    const SHIFTS: usize = 32;
    let n = runs.len();
    let of = |which: usize| {
        let [count, sum, squares] = (0..SHIFTS)
            .map(|k| 1 + k * (n - 1) / SHIFTS)
            .flat_map(|shift| (0..n).map(move |j| (runs[j], runs[(j + shift) % n][which])))
            .map(|(mut run, other)| {
                run[which] = other;
                term(run)
            })
            .filter(|term| term.is_finite())
            .fold([0.0; 3], |[n, sum, squares], x| [n + 1.0, sum + x, squares + x * x]);
        ((squares - sum * sum / count).max(0.0) / (count * n as f64)).sqrt()
    };
    of(0).min(of(2))
}

/// Computes the indices from the outputs of the rows of [`design`], in its order.
///
/// The outputs are first shifted to mean 0, because the estimators are biased for others. All indices of a constant output
/// are 0.
///
/// Where runs failed, the indices are conditional: the variance is that of the runs of A and B that have values; the total
/// index is the mean of (f_A - f_AB)^2 / 2 over the pairs that both have one, over that variance; the first-order index is
/// 1 minus the same of f_B and f_AB (Jansen's form, whatever the estimator: the others need three runs at a time).
///
/// Returns `None` where the number of outputs is no multiple of `parameters + 2`, or where all complete base points lie
/// in one of the sixteen blocks that the intervals are made from.
pub fn indices(outputs: &[f64], parameters: usize, estimator: FirstOrder) -> Option<Indices> {
    let width = parameters + 2;
    if parameters == 0 || outputs.is_empty() || !outputs.len().is_multiple_of(width) {
        return None;
    }
    let outputs = &ratio::moderate(outputs);
    let finite: Vec<f64> = outputs.iter().copied().filter(|v| v.is_finite()).collect();
    let shift = mean(&finite);
    let failed = outputs.len() - finite.len();
    let rows: Vec<Vec<f64>> = outputs.chunks(width).map(|row| row.iter().map(|v| v - shift).collect()).collect();
    let ends: Vec<[f64; 2]> = rows.iter().map(|row| [row[0], row[width - 1]]).collect();
    let variance = ratio::variance(&ends);
    let estimator = match failed {
        0 => estimator,
        _ => FirstOrder::Jansen,
    };
    let (carriers, centre) = (ratio::carriers(outputs, &ends), ratio::centre(&ends));
    let part_of_variance = |[a, _, b]: [f64; 3]| 0.5 * ((a - centre).powi(2) + (b - centre).powi(2));
    let mut result = Indices { first: vec![], total: vec![], used: vec![], failed };
    for i in 1..=parameters {
        let runs: Vec<[f64; 3]> = rows.iter().map(|row| [row[0], row[i], row[width - 1]]).collect();
        let of = |form: Term| -> Vec<f64> { runs.iter().map(|&run| form(part_of_variance(run), run)).collect() };
        let estimate = |forms: [Term; 2], estimator: FirstOrder, offset: f64| {
            let [product, difference] = forms.map(of);
            let Combined { terms, crosswise, weight } = match estimator {
                FirstOrder::Combined => ratio::combined(&product, &difference, &variance),
                FirstOrder::Saltelli => Combined::only(product, 0.0),
                FirstOrder::Jansen => Combined::only(difference, 1.0),
            };
            let [terms, crosswise] = [terms, crosswise].map(Parts::of);
            let ratio = ratio::ratio(&terms, &variance, |_| true);
            let least = apart(&runs, |run| {
                let v = part_of_variance(run);
                (1.0 - weight) * forms[0](v, run) + weight * forms[1](v, run) - ratio * v
            }) / variance.mean();
            ratio::scattering(&terms, &crosswise, &variance, offset, least, carriers)
        };
        result.first.push(match estimator {
            FirstOrder::Jansen => estimate([FIRST[0], DIFFERENCE], estimator, 1.0)?,
            _ => estimate(FIRST, estimator, 0.0)?,
        });
        let of_total = if estimator == FirstOrder::Combined { estimator } else { FirstOrder::Jansen };
        result.total.push(estimate(TOTAL, of_total, 0.0)?);
        result.used.push(Parts::of(of(TOTAL[1])).used());
    }
    Some(result)
}

/// Indices from growing parts of the design, to show convergence: base points, indices.
pub fn convergence(outputs: &[f64], parameters: usize) -> Vec<(usize, Indices)> {
    let width = parameters + 2;
    let n = outputs.len() / width;
    let mut parts: Vec<(usize, Indices)> = std::iter::successors(Some(n), |m| (*m / 2 >= 32).then_some(m / 2))
        .filter_map(|m| Some((m, indices(&outputs[..m * width], parameters, FirstOrder::default())?)))
        .collect();
    parts.reverse();
    parts
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::functions::{ishigami, ishigami_indices, sobol_g, sobol_g_indices};
    use crate::testing::{holds, holds_nearly, lattice, near, of_corners, settled};
    use rand::{RngExt, SeedableRng, rngs::StdRng};

    /// Pairs as the command takes them.
    fn scrambled_pairs(base: u64, d: usize, seed: u64) -> Vec<Vec<f64>> {
        pairs(d, base, seed).unwrap()
    }

    fn random_pairs(n: usize, d: usize, seed: u64) -> Vec<Vec<f64>> {
        let mut random = StdRng::seed_from_u64(seed);
        (0..n).map(|_| (0..2 * d).map(|_| random.random::<f64>()).collect()).collect()
    }

    fn evaluate(pairs: &[Vec<f64>], f: impl Fn(&[f64]) -> f64) -> Vec<f64> {
        design(pairs).iter().map(|u| f(u)).collect()
    }

    /// SALib 1.5 on the same rows: `sobol.analyze(problem, Y, calc_second_order=False)`.
    #[test]
    fn equal_to_salib_on_the_same_design() {
        let y = evaluate(&lattice(256, 6), ishigami);
        let s = indices(&y, 3, FirstOrder::Saltelli).unwrap();
        for (i, (first, total)) in SALIB_ISHIGAMI.into_iter().enumerate() {
            assert!((s.first[i].value - first).abs() < 1e-10, "{i} {:?}", s.first[i]);
            assert!((s.total[i].value - total).abs() < 1e-10, "{i} {:?}", s.total[i]);
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
        for estimator in [FirstOrder::Combined, FirstOrder::Saltelli, FirstOrder::Jansen] {
            let s = indices(&y, 3, estimator).unwrap();
            for (index, exact) in s.first.iter().zip(first).chain(s.total.iter().zip(total)) {
                assert!((index.value - exact).abs() < 0.03, "{estimator:?} {index:?} {exact}");
            }
        }
    }

    /// The short form of `cargo run --release --example coverage`.
    #[test]
    fn intervals_hold_the_exact_indices_in_95_per_cent_of_repetitions() {
        const REPETITIONS: u64 = 30;
        const BASE: u64 = 256;
        let a = [0.0, 1.0, 4.5, 9.0];
        let (gf, gt) = sobol_g_indices(&a);
        let (hf, ht) = ishigami_indices();
        let count = |s: &Indices, first: &[f64], total: &[f64]| {
            let pairs = s.first.iter().zip(first).chain(s.total.iter().zip(total));
            pairs.filter(|(index, exact)| index.contains(**exact)).count() as f64
        };
        for estimator in [FirstOrder::Combined, FirstOrder::Saltelli, FirstOrder::Jansen] {
            let (mut ishigami_held, mut g_held) = (0.0, 0.0);
            for seed in 0..REPETITIONS {
                let y = evaluate(&scrambled_pairs(BASE, 3, 1000 + seed), ishigami);
                let s = indices(&y, 3, estimator).unwrap();
                ishigami_held += count(&s, &hf, &ht) / (6 * REPETITIONS) as f64;
                let y = evaluate(&scrambled_pairs(BASE, 4, 2000 + seed), |u| sobol_g(u, &a));
                let s = indices(&y, 4, estimator).unwrap();
                g_held += count(&s, &gf, &gt) / (8 * REPETITIONS) as f64;
            }
            for coverage in [ishigami_held, g_held] {
                assert!(coverage >= 0.95, "{ishigami_held} {g_held}");
            }
        }
    }

    type Trial = (&'static str, Box<dyn Fn(&[f64]) -> f64>, [Vec<f64>; 2]);

    /// Functions of six parameters with their indices. Of three few runs carry the variance; of the last one a parameter has next to none.
    fn trials() -> [Trial; 7] {
        let a = [0.0, 0.5, 3.0, 9.0, 99.0, 99.0];
        let (first, total) = sobol_g_indices(&a);
        let product = |u: &[f64]| u[..3].iter().map(|u| 2.0 * u - 0.5).product::<f64>();
        let five = |u: &[f64]| u[..5].iter().map(|u| 2.0 * u - 1.0).product::<f64>();
        let steep = |u: &[f64]| u[0].powi(20) * u[1];
        // A switch that few runs close, and how much then flows.
        let switch = |u: &[f64]| (u[0] - 0.9).max(0.0) * u[1];
        // Sobol and Levitan's: the exponential of a sum.
        const RATES: [f64; 6] = [1.5, 0.9, 0.7, 0.5, 0.3, 0.1];
        let levitan = |u: &[f64]| u.iter().zip(RATES).map(|(u, rate)| rate * u).sum::<f64>().exp();
        // Of a product each factor has a variance over its squared mean: 4/3, that of an exponential, of a power, of a ramp that
        // begins at 0.9.
        let of_exponential = |rate: f64| 0.5 * rate * (2.0 * rate).exp_m1() / rate.exp_m1().powi(2) - 1.0;
        let (of_power, of_ramp) = (21.0 * 21.0 / 41.0 - 1.0, 4.0 / 0.3 - 1.0);
        let of_product = |relative: &[f64]| {
            let whole: f64 = relative.iter().map(|v| 1.0 + v).product();
            let part = |of: &dyn Fn(f64) -> f64| relative.iter().map(|v| of(*v) / (whole - 1.0)).collect::<Vec<f64>>();
            [part(&|v| v), part(&|v| v / (1.0 + v) * whole)]
        };
        let nearly_one = [1.0, 1e-6, 0.0, 0.0, 0.0, 0.0].map(|variance| variance / (1.0 + 1e-6));
        let of_two = |one: f64| of_product(&[one, 1.0 / 3.0, 0.0, 0.0, 0.0, 0.0]);
        [
            ("g", Box::new(move |u: &[f64]| sobol_g(u, &a)), [first, total]),
            ("product", Box::new(product), of_product(&[4.0 / 3.0, 4.0 / 3.0, 4.0 / 3.0, 0.0, 0.0, 0.0])),
            ("Sobol-Levitan", Box::new(levitan), of_product(&RATES.map(of_exponential))),
            ("product of five", Box::new(five), [vec![0.0; 6], vec![1.0, 1.0, 1.0, 1.0, 1.0, 0.0]]),
            ("power", Box::new(steep), of_two(of_power)),
            ("switch", Box::new(switch), of_two(of_ramp)),
            ("nearly one", Box::new(|u: &[f64]| u[0] + 1e-3 * u[1]), [nearly_one.to_vec(), nearly_one.to_vec()]),
        ]
    }

    /// Of these seeds: how many state intervals, how many of each index hold, and how many are off by more than 1.5 half widths, first
    /// order and total.
    struct Told {
        what: String,
        stated: u64,
        held: Vec<u64>,
        off: Vec<u64>,
    }

    fn told(base: u64, seeds: std::ops::Range<u64>) -> Vec<Told> {
        let of_trial = |(name, f, exact): Trial| {
            let mut told =
                Told { what: format!("base {base}, {name}"), stated: 0, held: vec![0; 12], off: vec![0; 12] };
            for seed in seeds.clone() {
                let s = indices(&evaluate(&scrambled_pairs(base, 6, seed), &f), 6, FirstOrder::default()).unwrap();
                if s.total[0].low.is_nan() {
                    continue;
                }
                told.stated += 1;
                for (k, (index, exact)) in s.first.iter().chain(&s.total).zip(exact.iter().flatten()).enumerate() {
                    told.held[k] += u64::from(holds_nearly(index, *exact));
                    told.off[k] += u64::from((index.value - exact).abs() > 0.75 * (index.high - index.low) + 1e-9);
                }
            }
            let Told { what, stated, held, off } = &told;
            println!("{what}: {stated} stated, held {held:?}, off {off:?}");
            told
        };
        trials().into_iter().map(of_trial).collect()
    }

    /// The fewest of so many seeds in which the interval of an index near 0 holds it: the last two are 3e-5 and 2e-6.
    fn near_zero_held(base: u64, seeds: u64) -> u64 {
        let a = [0.0, 0.5, 3.0, 9.0, 99.0, 400.0];
        let (first, total) = sobol_g_indices(&a);
        let mut held = [0; 4];
        for seed in 0..seeds {
            let y = evaluate(&scrambled_pairs(base, 6, 4000 + seed), |u| sobol_g(u, &a));
            let s = indices(&y, 6, FirstOrder::default()).unwrap();
            for (k, j) in [4, 5].into_iter().enumerate() {
                held[k] += u64::from(s.first[j].contains(first[j]));
                held[2 + k] += u64::from(s.total[j].contains(total[j]));
            }
        }
        println!("near 0, base {base}: {held:?} of {seeds}");
        held.into_iter().min().unwrap()
    }

    #[test]
    fn intervals_hold_indices_near_0() {
        for base in [64, 256] {
            assert!(near_zero_held(base, 60) >= 55, "{base}");
        }
    }

    #[test]
    #[ignore = "takes a while; run by scripts/test --long"]
    fn intervals_hold_indices_near_0_in_93_per_cent_of_many_seeds() {
        for base in [64, 256] {
            assert!(near_zero_held(base, 200) >= 186, "{base}");
        }
    }

    #[test]
    fn intervals_hold_and_hardly_any_index_is_far_off() {
        for Told { what, stated, held, off } in told(128, 1000..1016) {
            let count = |of: Vec<u64>| of.iter().sum::<u64>() as f64;
            let [held, off] = [held, off].map(count).map(|count| count / (12 * stated.max(1)) as f64);
            assert!(stated == 0 || held >= 0.95 && off <= 0.01, "{what}: {stated} stated, {held} hold, {off} far off");
        }
    }

    /// Where a tenth of the seeds states intervals, 93 % of each hold, and 1 % of each is far off at most.
    #[test]
    #[ignore = "takes minutes; run by scripts/test --long"]
    fn intervals_hold_and_no_index_of_any_base_is_far_off() {
        let all = [64, 128, 256, 512].into_iter().flat_map(|base| told(base, 1000..3000));
        let fails = |told: &Told| {
            let Told { stated, held, off, .. } = told;
            *stated >= 200
                && (held.iter().any(|held| 100 * held < 93 * stated) || off.iter().any(|off| 100 * off > *stated))
        };
        let failed: Vec<String> = all.filter(fails).map(|told| told.what).collect();
        assert!(failed.is_empty(), "{failed:?}");
    }

    /// Of outputs that are 1 where each of the first `of` parameters of three lies above a limit: how many of these seeds state an
    /// interval, and in how many of them each holds, first order and total.
    fn held_of_corner(base: u64, of: usize, share: f64, seeds: u64) -> (u64, Vec<u64>) {
        let alone = share.powf(1.0 / of as f64);
        let exact = [share * (1.0 / alone - 1.0) / (1.0 - share), 1.0 - (alone - share) / (1.0 - share)];
        let (mut stated, mut held) = (0, vec![0; 6]);
        for seed in 0..seeds {
            let flag = |u: &[f64]| f64::from(u[..of].iter().all(|u| *u > 1.0 - alone));
            let s = indices(&evaluate(&scrambled_pairs(base, 3, 7000 + seed), flag), 3, FirstOrder::default()).unwrap();
            // Nothing is told, or that all runs are the same.
            if s.first[0].low.is_nan() || s.total.iter().all(|index| index.value == 0.0) {
                continue;
            }
            stated += 1;
            for (k, index) in s.first.iter().chain(&s.total).enumerate() {
                held[k] += u64::from(holds_nearly(index, if k % 3 < of { exact[k / 3] } else { 0.0 }));
            }
        }
        println!("base {base}, corner of {of}, share {share}: {stated} of {seeds} stated, held {held:?}");
        (stated, held)
    }

    #[test]
    #[ignore = "takes minutes; run by scripts/test --long"]
    fn indices_of_two_values_hold() {
        of_corners(held_of_corner);
    }

    #[test]
    fn failed_runs_are_left_out_and_counted() {
        let (first, _) = ishigami_indices();
        let mut y = evaluate(&random_pairs(20_000, 3, 9), ishigami);
        for k in (0..y.len()).step_by(97) {
            y[k] = f64::NAN;
        }
        let failed = y.iter().filter(|v| v.is_nan()).count();
        let s = indices(&y, 3, FirstOrder::Saltelli).unwrap();
        assert_eq!(s.failed, failed);
        assert!(s.used.iter().all(|&u| u < 20_000 && u > 19_000));
        for (index, exact) in s.first.iter().zip(first) {
            assert!((index.value - exact).abs() < 0.04, "{index:?} {exact}");
        }
    }

    #[test]
    fn a_constant_output_depends_on_nothing() {
        let s = indices(&[7.0; 40], 3, FirstOrder::Saltelli).unwrap();
        assert!(s.first.iter().chain(&s.total).all(|e| e.value == 0.0));
        assert_eq!(indices(&[1.0; 41], 3, FirstOrder::Saltelli), None);
    }

    #[test]
    fn convergence_ends_with_the_whole_design() {
        let y = evaluate(&random_pairs(256, 3, 3), ishigami);
        let steps = convergence(&y, 3);
        assert_eq!(steps.iter().map(|s| s.0).collect::<Vec<_>>(), [32, 64, 128, 256]);
        assert_eq!(steps[3].1, indices(&y, 3, FirstOrder::default()).unwrap());
    }

    /// The design has the rows A, A_B of each parameter, B: those of A and B are a sample of the parameters.
    /// The way of a study: the design has A, A_B of each parameter, and B; what is told comes back when it is shown.
    #[test]
    fn a_study_shows_the_indices_of_its_design() {
        let rows = Sobol.design(2, &settled(64, 5)).unwrap();
        assert_eq!(rows.len() as u64, Sobol.runs(2, 64));
        for rows in rows.chunks(4) {
            let (a, b) = (&rows[0], &rows[3]);
            assert_eq!(rows[1..3], [vec![b[0], a[1]], vec![a[0], b[1]]]);
        }
        let outputs: Vec<f64> = rows.iter().map(|u| u[0] + 3.0 * u[1]).collect();
        let told = Sobol.tell(&rows, &outputs, &settled(64, 5));
        let indices = indices(&outputs, 2, FirstOrder::Combined).unwrap();
        let [total, first] = &Sobol.shown(&told)[..] else { panic!("two measures") };
        assert_eq!((total.name, total.drawn), ("total", true));
        assert_eq!((first.name, first.drawn), ("first order", true));
        assert_eq!((&total.estimates, &first.estimates), (&indices.total, &indices.first));
        let growing: Vec<(usize, Vec<f64>)> = read(&told, "convergence").unwrap();
        assert_eq!(growing.iter().map(|(n, _)| *n).collect::<Vec<_>>(), [32, 64]);
        near(growing[1].1.clone().try_into().unwrap(), [0, 1].map(|i| indices.total[i].value));
        assert_eq!(Sobol.shown(&Sobol.tell(&rows, &[f64::NAN; 256], &settled(64, 5))), []);
    }

    /// numpy and scipy, each step written once more: 18.8 of 128 independent runs carry the variance.
    /// The errors are those of points, of nets, and with the values of A or B of other base points.
    #[test]
    fn indices_and_their_intervals_are_those_of_numpy() {
        let steep = |u: &[f64]| if u[0] > 0.7 { u[1] * u[1] + 0.1 * u[0] } else { 0.1 * u[0] };
        let outputs = evaluate(&lattice(64, 4), steep);
        let about = |value: f64, half: f64| [value, value - half, value + half];
        let found = indices(&outputs, 2, FirstOrder::Combined).unwrap();
        holds(found.first[0], about(0.496_468_471_2, 0.468_514_719_3));
        holds(found.total[0], about(0.843_436_558_6, 0.475_386_705_8));
        holds(found.first[1], about(-0.040_443_917_3, 0.471_192_627_7));
        holds(found.total[1], about(0.502_266_595_2, 0.529_443_371_9));
        let found = indices(&outputs, 2, FirstOrder::Jansen).unwrap();
        holds(found.first[0], about(0.484_653_924_1, 0.652_906_555_1));
        holds(found.total[1], about(0.446_666_078_9, 0.651_415_237_5));
        let found = indices(&outputs, 2, FirstOrder::Saltelli).unwrap();
        holds(found.first[0], about(0.505_641_860_0, 0.715_858_303_1));
        holds(found.total[0], about(0.781_258_298_5, 0.786_016_244_6));
        // Without one run of A: Jansen's form of both, and none of the base points' other indices is lost.
        let lost = [&[f64::NAN][..], &outputs[1..]].concat();
        let found = indices(&lost, 2, FirstOrder::Combined).unwrap();
        assert_eq!((found.failed, found.used), (1, vec![63; 2]));
        assert!(found.first.iter().chain(&found.total).all(|index| index.low < index.value));
    }

    #[test]
    fn nothing_is_told_of_no_parameters_or_no_runs() {
        assert_eq!(indices(&[1.0, 2.0, 3.0, 4.0], 0, FirstOrder::Jansen), None);
        assert_eq!(indices(&[], 3, FirstOrder::Jansen), None);
    }
}

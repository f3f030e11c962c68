//! Shapley effects by a surrogate of few runs: how often their intervals hold the exact effects, and how large the error is.

use crate::functions::{ishigami, ishigami_indices, sobol_g};
use nalgebra::DMatrix;
use rayon::prelude::*;
use run_budget::{Design, Limit, Run, Surrogate, measures};
use sampling::design::cube;
use sensitivity::shapley::{Explained, design};
use statrs::distribution::{ContinuousCDF, Normal};

use crate::{G, percent};

type Function = fn(&[f64]) -> f64;

/// Pairs of points at which a surrogate is asked.
const PAIRS: usize = 4096;

/// A function of places in the unit cube, with the correlations of their scores and the exact effects.
struct Case {
    name: &'static str,
    function: Function,
    /// Whether its parameters are normal scores rather than places.
    normal: bool,
    correlation: Option<DMatrix<f64>>,
    exact: Vec<f64>,
}

pub fn print(repetitions: u64) -> Result<(), String> {
    println!(
        "\nShapley effects: % of {repetitions} intervals that hold the exact effect, one by one; their mean width; error"
    );
    for case in &cases()? {
        for runs in [60, 100] {
            held(case, runs, repetitions)?;
        }
    }
    Ok(())
}

fn cases() -> Result<Vec<Case>, String> {
    let (first, total) = ishigami_indices();
    let both = first.iter().zip(total).map(|(first, total)| (first + total) / 2.0);
    let parts = G.map(|a| 1.0 / (3.0 * (1.0_f64 + a).powi(2)));
    let linear: Function = |u| scores(u).zip(1..).map(|(z, k)| z * f64::from(k)).sum();
    let product: Function = |u| {
        let z: Vec<f64> = scores(u).collect();
        z[0] * z[1] + z[0]
    };
    let g: Function = |u| sobol_g(u, &G);
    let [three, four, six] = [chain(3, 0.5), chain(4, 0.4), chain(6, -0.45)];
    let r: f64 = 0.7;
    let asymmetric = [1.5, 0.5 + r * r].map(|part| part / (2.0 + r * r));
    let mut cases = vec![
        ("Ishigami", ishigami as Function, None, both.collect()),
        ("Sobol's g", g, None, of_subsets(4, |set| product_of(&parts, set))),
        ("linear", linear, None, (1..=6).map(|k| f64::from(k * k) / 91.0).collect()),
        ("x1 x2 + x1", product, Some(chain(2, r)), asymmetric.to_vec()),
    ];
    for matrix in [three.clone(), six] {
        let exact = of_subsets(matrix.nrows(), |set| explained(&matrix, set));
        cases.push(("linear", linear, Some(matrix), exact));
    }
    let mut cases: Vec<Case> = cases
        .into_iter()
        .map(|(name, function, correlation, exact)| {
            let normal = name == "linear" || name == "x1 x2 + x1";
            Case { name, function, normal, correlation, exact }
        })
        .collect();
    // No closed form: nested averages over a grid-like net, another way than that of the method.
    for (name, function, matrix) in [("Ishigami", ishigami as Function, three), ("Sobol's g", g, four)] {
        let exact = nested(function, &matrix)?;
        cases.push(Case { name, function, normal: false, correlation: Some(matrix), exact });
    }
    Ok(cases)
}

fn scores(u: &[f64]) -> impl Iterator<Item = f64> {
    u.iter().map(|&u| score(u))
}

fn score(u: f64) -> f64 {
    Normal::standard().inverse_cdf(u.clamp(1e-12, 1.0 - 1e-12))
}

/// Neighbours are correlated.
fn chain(parameters: usize, coefficient: f64) -> DMatrix<f64> {
    DMatrix::from_fn(parameters, parameters, |a, b| match a.abs_diff(b) {
        0 => 1.0,
        1 => coefficient,
        _ => 0.0,
    })
}

/// Shapley effects from what each set of parameters explains.
fn of_subsets(parameters: usize, explained: impl Fn(&[usize]) -> f64) -> Vec<f64> {
    let set = |mask: usize| -> Vec<usize> { (0..parameters).filter(|k| mask >> k & 1 == 1).collect() };
    let explained: Vec<f64> = (0..1 << parameters).map(|mask| explained(&set(mask))).collect();
    let choose = |k: usize| (0..k).fold(1.0, |c, j| c * (parameters - 1 - j) as f64 / (j + 1) as f64);
    let effect = |k: usize| {
        let without = (0..1 << parameters).filter(|mask: &usize| mask >> k & 1 == 0);
        let gain = |mask: usize| {
            let weight = choose(mask.count_ones() as usize) * parameters as f64;
            (explained[mask | 1 << k] - explained[mask]) / weight
        };
        without.map(gain).sum::<f64>() / explained[(1 << parameters) - 1]
    };
    (0..parameters).map(effect).collect()
}

/// The variance of Sobol's g that a set explains.
fn product_of(parts: &[f64], set: &[usize]) -> f64 {
    set.iter().map(|&k| 1.0 + parts[k]).product::<f64>() - 1.0
}

/// The variance of z1 + 2 z2 + ... that a set of correlated scores explains (Owen & Prieur 2017, section 4).
fn explained(matrix: &DMatrix<f64>, set: &[usize]) -> f64 {
    if set.is_empty() {
        return 0.0;
    }
    let weights = DMatrix::from_fn(matrix.nrows(), 1, |k, _| (k + 1) as f64);
    let covariances = matrix.select_rows(set) * weights;
    let among = matrix.select_rows(set).select_columns(set);
    let solved = among.lu().solve(&covariances).unwrap_or_default();
    (covariances.transpose() * solved)[(0, 0)]
}

/// Effects by nested averages: for each set, the variance of the mean of the function over the others.
fn nested(function: Function, matrix: &DMatrix<f64>) -> Result<Vec<f64>, String> {
    const OUTER: u64 = 2048;
    const INNER: u64 = 256;
    let d = matrix.nrows();
    let points = |count: u64, seed: u64| cube(d, count, seed, 1);
    let (outer, inner) = (points(OUTER, 5)?, points(INNER, 6)?);
    let normal = Normal::standard();
    let explained = |set: &[usize]| -> f64 {
        let rest: Vec<usize> = (0..d).filter(|k| !set.contains(k)).collect();
        let order = [set, &rest].concat();
        let sorted = DMatrix::from_fn(d, d, |a, b| matrix[(order[a], order[b])]);
        let Some(factor) = sorted.cholesky().map(|c| c.l()) else {
            return f64::NAN;
        };
        let value = |free: Vec<f64>| {
            let mut u = vec![0.0; d];
            for (row, &k) in order.iter().enumerate() {
                let z: f64 = (0..=row).map(|j| factor[(row, j)] * free[j]).sum();
                u[k] = normal.cdf(z);
            }
            function(&u)
        };
        let mean = |known: &Vec<f64>| {
            let all = inner.iter().map(|others| {
                let free = (0..d).map(|j| score(if j < set.len() { known[j] } else { others[j] }));
                value(free.collect())
            });
            all.sum::<f64>() / INNER as f64
        };
        let means: Vec<f64> = outer.par_iter().map(mean).collect();
        let centre = means.iter().sum::<f64>() / OUTER as f64;
        means.iter().map(|m| (m - centre).powi(2)).sum::<f64>() / OUTER as f64
    };
    Ok(of_subsets(d, explained))
}

fn held(case: &Case, runs: u64, repetitions: u64) -> Result<(), String> {
    let d = case.exact.len();
    let one = |seed: u64| -> Result<Option<[Vec<f64>; 3]>, String> {
        let pairs = cube(2 * d, PAIRS as u64, 7000 + seed, 1)?;
        let rows = design(&pairs, case.correlation.as_ref(), seed)?;
        let place = |u: &[f64]| if case.normal { scores(u).collect() } else { u.to_vec() };
        let points: Vec<Vec<f64>> = rows.iter().map(|u| place(u)).collect();
        let width = rows.len() / PAIRS;
        // The plain points of a design of its own.
        let plain = design(&cube(2 * d, runs, seed, 1)?, case.correlation.as_ref(), seed)?;
        let run = |u: &Vec<f64>| Run { point: place(u), values: Some(vec![(case.function)(u)]) };
        let runs: Vec<Run> = plain.iter().step_by(width).map(run).collect();
        let like: Vec<Vec<f64>> = points.iter().step_by(width).cloned().collect();
        let surrogate = Surrogate::fit(&runs, &like, None, seed).map_err(|unfit| unfit.to_string())?;
        let explained = Explained::new(d, PAIRS, case.correlation.is_some(), seed);
        let explained = |pair, values: &[f64]| explained.at(pair, values).into_iter().map(|x| [x, 0.0]).collect();
        let asked = Design { points: &points, width, drawn: PAIRS / 8, explained: &explained };
        let limits = [Limit { output: 0, range: [f64::NEG_INFINITY, f64::INFINITY] }];
        let Ok(found) = &measures(&surrogate, &limits, &runs, &asked, 0.95)[0] else { return Ok(None) };
        let all = || found.iter().zip(&case.exact);
        Ok(Some([
            all().map(|(e, &x)| f64::from(u8::from(e.interval[0] <= x && x <= e.interval[1]))).collect(),
            all().map(|(e, _)| e.interval[1] - e.interval[0]).collect(),
            all().map(|(e, x)| (e.estimate - x).powi(2)).collect(),
        ]))
    };
    let all: Vec<Option<[Vec<f64>; 3]>> = (0..repetitions).into_par_iter().map(one).collect::<Result<_, _>>()?;
    let all: Vec<[Vec<f64>; 3]> = all.into_iter().flatten().collect();
    let mean = |what: usize, k: usize| all.iter().map(|r| r[what][k]).sum::<f64>() / all.len() as f64;
    let held: Vec<f64> = (0..d).map(|k| percent(mean(0, k))).collect();
    let over = |what: usize| (0..d).map(|k| mean(what, k)).sum::<f64>() / d as f64;
    println!(
        "  {:<10} {} {runs:>5} runs, told {}: {held:.1?}; width {:.3}, rms error {:.4}",
        case.name,
        if case.correlation.is_some() { "correlated " } else { "independent" },
        all.len(),
        over(1),
        over(2).sqrt()
    );
    Ok(())
}

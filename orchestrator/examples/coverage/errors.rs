//! Root mean square errors of Sobol indices, against SALib's way: its estimators on a net in the order of its coordinates.
//! The tests show that both programs come to the same numbers on the same runs.

use crate::functions::{ishigami, ishigami_indices, sobol_g, sobol_g_indices};
use rayon::prelude::*;
use sampling::design::cube;
use sensitivity::method::FirstOrder;
use sensitivity::pairs::pairs;
use sensitivity::sobol::{design, indices};

use crate::{Case, G};

pub fn print(repetitions: u64) -> Result<(), String> {
    println!("\nErrors of Sobol indices over SALib's, {repetitions} repetitions: first order, total");
    let (first, total) = ishigami_indices();
    let (g_first, g_total) = sobol_g_indices(&G);
    let linear = |u: &[f64]| u.iter().zip(1_u8..).map(|(u, k)| f64::from(k) * u).sum();
    let of_linear = |d: u32| -> Vec<f64> {
        let squares: f64 = (1..=d).map(|k| f64::from(k * k)).sum();
        (1..=d).map(|k| f64::from(k * k) / squares).collect()
    };
    let cases = [
        Case::new("linear, 6", 6, linear, &of_linear(6), &of_linear(6)),
        Case::new("linear, 3", 3, linear, &of_linear(3), &of_linear(3)),
        Case::new("Ishigami", 3, ishigami, &first, &total),
        Case::new("Sobol's g", 4, |u| sobol_g(u, &G), &g_first, &g_total),
        Case::estimated("exponential", 5, |u| u.iter().sum::<f64>().exp())?,
    ];
    let mut logarithms = [0.0, 0.0];
    let sizes = [64, 256, 1024, 4096];
    for case in &cases {
        for base in sizes {
            let ours = errors(case, repetitions, FirstOrder::Combined, |seed| pairs(case.dimensions, base, seed))?;
            let theirs =
                errors(case, repetitions, FirstOrder::Saltelli, |seed| cube(2 * case.dimensions, base, seed, 1))?;
            let over = [0, 1].map(|k| ours[k] / theirs[k]);
            println!("  {:<11} {base:>4} base points: {ours:.5?} over {theirs:.5?}: {over:.2?}", case.name);
            for (sum, ratio) in logarithms.iter_mut().zip(over) {
                *sum += ratio.ln() / (cases.len() * sizes.len()) as f64;
            }
        }
    }
    println!("  geometric mean: {:.2?}", logarithms.map(f64::exp));
    Ok(())
}

/// Of the first-order indices and of the total ones.
fn errors(
    case: &Case,
    repetitions: u64,
    estimator: FirstOrder,
    sample: impl Fn(u64) -> Result<Vec<Vec<f64>>, String> + Sync,
) -> Result<[f64; 2], String> {
    let one = |seed: u64| -> Result<[f64; 2], String> {
        let rows = design(&sample(500 + seed)?);
        let outputs: Vec<f64> = rows.iter().map(|u| (case.function)(u)).collect();
        let found = indices(&outputs, case.dimensions, estimator).ok_or("too few points")?;
        let squares = |found: &[sensitivity::Estimate], exact: &[f64]| -> f64 {
            let pairs = found.iter().zip(exact);
            pairs.map(|(e, x)| (e.value - x).powi(2)).sum()
        };
        Ok([squares(&found.first, &case.first), squares(&found.total, &case.total)])
    };
    let all: Vec<[f64; 2]> = (0..repetitions).into_par_iter().map(one).collect::<Result<_, _>>()?;
    let count = (repetitions as usize * case.dimensions) as f64;
    Ok([0, 1].map(|k| (all.iter().map(|e| e[k]).sum::<f64>() / count).sqrt()))
}

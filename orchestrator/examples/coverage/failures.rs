//! Sobol indices where runs fail: how often the conditional intervals hold the conditional indices.

use crate::functions::{ishigami, ishigami_indices, sobol_g, sobol_g_indices};
use rayon::prelude::*;
use sensitivity::method::FirstOrder;
use sensitivity::pairs::pairs;
use sensitivity::sobol::{design, indices};

use crate::{Case, G, percent};

/// Where runs fail, given the share that does.
#[derive(Clone, Copy)]
struct Place {
    name: &'static str,
    fails: fn(&[f64], f64, f64) -> bool,
}

const PLACES: [Place; 5] = [
    Place { name: "corner", fails: |u, _, share| u[0].min(u[1]) > 1.0 - share.sqrt() },
    Place { name: "slab", fails: |u, _, share| u[2] < share },
    Place { name: "middle", fails: |u, _, share| u[..2].iter().all(|v| (v - 0.5).abs() < share.sqrt() / 2.0) },
    Place { name: "anywhere", fails: |u, _, share| (1e4 * u.iter().sum::<f64>()).fract() < share },
    Place { name: "largest", fails: |_, y, _| y > LARGE },
];

/// 5.1 % of Ishigami's function are larger.
const LARGE: f64 = 9.35;

pub fn print(repetitions: u64) -> Result<(), String> {
    println!("\nFailed runs, Sobol indices: % of {repetitions} that hold (mean width)");
    let (first, total) = ishigami_indices();
    let (g_first, g_total) = sobol_g_indices(&G);
    let ishigami = Case::new("Ishigami", 3, ishigami, &first, &total);
    let g = Case::new("Sobol's g", 4, |u| sobol_g(u, &G), &g_first, &g_total);
    let weights = [1.0, 2.0, 3.0].map(|w: f64| w * w / 14.0);
    let linear = |u: &[f64]| u[0] + 2.0 * u[1] + 3.0 * u[2];
    let linear = Case::new("linear", 3, linear, &weights, &weights);
    for (base, case) in [256, 1024].into_iter().flat_map(|n| [(n, &ishigami), (n, &g), (n, &linear)]) {
        for share in [0.01, 0.05] {
            for place in PLACES {
                if place.name != "largest" || (case.name == "Ishigami" && share > 0.02) {
                    held(case, base, place, share, repetitions)?;
                }
            }
        }
    }
    Ok(())
}

fn values(case: &Case, place: Place, share: f64, rows: &[Vec<f64>]) -> Vec<f64> {
    let value = |u: &Vec<f64>| {
        let y = (case.function)(u);
        if (place.fails)(u, y, share) { f64::NAN } else { y }
    };
    rows.iter().map(value).collect()
}

/// The conditional indices, from a very large design.
fn conditional(case: &Case, place: Place, share: f64) -> Result<Vec<f64>, String> {
    let pairs = pairs(case.dimensions, 1 << 17, 77)?;
    let values = values(case, place, share, &design(&pairs));
    let mut squares = vec![[0.0; 2]; 2 * case.dimensions];
    let (mut sums, width) = ([0.0; 3], case.dimensions + 2);
    for row in values.chunks(width) {
        let (a, b) = (row[0], row[width - 1]);
        for v in [a, b].into_iter().filter(|v| v.is_finite()) {
            sums = [sums[0] + 1.0, sums[1] + v, sums[2] + v * v];
        }
        for (k, sum) in squares.iter_mut().enumerate() {
            let mixed = row[1 + k % case.dimensions];
            let other = if k < case.dimensions { b } else { a };
            let square = (other - mixed).powi(2) / 2.0;
            if square.is_finite() {
                *sum = [sum[0] + square, sum[1] + 1.0];
            }
        }
    }
    let variance = sums[2] / sums[0] - (sums[1] / sums[0]).powi(2);
    let indices = squares.iter().enumerate();
    let indices = indices.map(|(k, [sum, count])| match sum / count / variance {
        ratio if k < case.dimensions => 1.0 - ratio,
        ratio => ratio,
    });
    Ok(indices.collect())
}

fn held(case: &Case, base: u64, place: Place, part: f64, repetitions: u64) -> Result<(), String> {
    let d = case.dimensions;
    let conditional = conditional(case, place, part)?;
    let exact: Vec<f64> = case.first.iter().chain(&case.total).copied().collect();
    let one = |seed: u64| -> Result<[f64; 3], String> {
        let pairs = pairs(d, base, 3000 + seed)?;
        let rows = design(&pairs);
        let outputs = values(case, place, part, &rows);
        let found = indices(&outputs, d, FirstOrder::default()).ok_or("too few points")?;
        let all: Vec<_> = found.first.iter().chain(&found.total).collect();
        let share = |hits: usize| hits as f64 / (2 * d) as f64;
        let of_conditional = all.iter().zip(&conditional);
        let of_exact = all.iter().zip(&exact);
        Ok([
            share(of_conditional.filter(|(e, x)| e.contains(**x)).count()),
            share(of_exact.filter(|(e, x)| e.contains(**x)).count()),
            all.iter().map(|e| e.high - e.low).sum::<f64>() / all.len() as f64,
        ])
    };
    let all: Vec<[f64; 3]> = (0..repetitions).into_par_iter().map(one).collect::<Result<_, _>>()?;
    let mean = |k: usize| all.iter().map(|r| r[k]).sum::<f64>() / repetitions as f64;
    println!(
        "  {:<10} {base:>4} base points, {:>2.0} % fail {:<9}: conditional {:>5.1} ({:.3}); it holds the index of all in {:>5.1}",
        case.name,
        percent(part),
        place.name,
        percent(mean(0)),
        mean(2),
        percent(mean(1)),
    );
    Ok(())
}

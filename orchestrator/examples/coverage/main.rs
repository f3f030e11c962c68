//! How often the stated 95 % intervals hold the exact value:
//! `cargo run --release --example coverage -- 200` (repetitions), with `-- 200 shapley` one part of it: `sobol`, `errors`,
//! `share`, `failures`, `morris`, `shapley`, `regions`.

mod errors;
mod failures;
#[path = "../../../crates/sensitivity/examples/functions/mod.rs"]
mod functions;
mod regions;
mod screening;
mod shapley;

use conformity::decision::randomised;
use conformity::interval::clopper_pearson;
use functions::{ishigami, ishigami_indices, sobol_g, sobol_g_indices};
use rayon::prelude::*;
use sampling::design::cube;
use sensitivity::Estimate;
use sensitivity::method::FirstOrder;
use sensitivity::pairs::pairs;
use sensitivity::sobol::{design, indices};

/// A function with its exact indices.
struct Case {
    name: &'static str,
    dimensions: usize,
    function: fn(&[f64]) -> f64,
    first: Vec<f64>,
    total: Vec<f64>,
}

impl Case {
    fn new(name: &'static str, dimensions: usize, function: fn(&[f64]) -> f64, first: &[f64], total: &[f64]) -> Self {
        Self { name, dimensions, function, first: first.to_vec(), total: total.to_vec() }
    }

    /// With the indices of two designs of 131,072 base points in place of exact ones.
    fn estimated(name: &'static str, dimensions: usize, function: fn(&[f64]) -> f64) -> Result<Self, String> {
        let of = |seed: u64| {
            let rows = design(&pairs(dimensions, 1 << 17, seed)?);
            let outputs: Vec<f64> = rows.iter().map(|u| function(u)).collect();
            indices(&outputs, dimensions, FirstOrder::Combined).ok_or_else(|| "too few points".to_owned())
        };
        let [one, other] = [of(77)?, of(78)?];
        let mean = |a: &[Estimate], b: &[Estimate]| -> Vec<f64> {
            let pairs = a.iter().zip(b);
            pairs.map(|(a, b)| f64::midpoint(a.value, b.value)).collect()
        };
        let first = mean(&one.first, &other.first);
        let total = mean(&one.total, &other.total);
        Ok(Self::new(name, dimensions, function, &first, &total))
    }
}

/// Flow through a borehole (Harper & Gupta 1983). One of eight parameters explains 0.83 of the variance, three nothing.
fn borehole(u: &[f64]) -> f64 {
    let ends = [
        [0.05, 0.15],
        [100.0, 50_000.0],
        [63_070.0, 115_600.0],
        [990.0, 1110.0],
        [63.1, 116.0],
        [700.0, 820.0],
        [1120.0, 1680.0],
        [9855.0, 12_045.0],
    ];
    let value = |k: usize| ends[k][0] + (ends[k][1] - ends[k][0]) * u[k];
    let (well, logarithm) = (value(0), (value(1) / value(0)).ln());
    let (upper, lower) = (value(2), value(4));
    let leak = 2.0 * value(6) * upper / (logarithm * well * well * value(7));
    2.0 * std::f64::consts::PI * upper * (value(3) - value(5)) / (logarithm * (1.0 + leak + upper / lower))
}

fn waves(u: &[f64]) -> f64 {
    (6.0 * u[0]).sin() * u[1] + u[2].powi(3) + 0.3 * u[3] * u[4]
}

fn bowl(u: &[f64]) -> f64 {
    let parts = u.iter().zip(1_u8..).map(|(u, k)| f64::from(k) * (u - 0.5));
    parts.sum::<f64>().powi(2) + u[0]
}

fn within(u: &[f64]) -> f64 {
    f64::from(u8::from(u.iter().all(|u| (u - 0.5).abs() < 0.4)))
}

fn percent(share: f64) -> f64 {
    100.0 * share
}

const G: [f64; 4] = [0.0, 1.0, 4.5, 9.0];

/// A part of the output, given the number of repetitions.
type Part = fn(u64) -> Result<(), String>;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let repetitions = std::env::args().nth(1).unwrap_or("200".into()).parse()?;
    let wanted = std::env::args().nth(2);
    let parts: [(&str, Part); 7] = [
        ("sobol", indices_hold),
        ("errors", errors::print),
        ("share", shares_hold),
        ("failures", failures::print),
        ("morris", screening::print),
        ("shapley", shapley::print),
        ("regions", regions::print),
    ];
    for (name, part) in parts {
        if wanted.as_ref().is_none_or(|wanted| wanted == name) {
            part(repetitions)?;
        }
    }
    Ok(())
}

fn indices_hold(repetitions: u64) -> Result<(), String> {
    let (first, total) = ishigami_indices();
    let (g_first, g_total) = sobol_g_indices(&G);
    let cases = [
        Case::new("Ishigami", 3, ishigami, &first, &total),
        Case::new("Sobol's g", 4, |u| sobol_g(u, &G), &g_first, &g_total),
        Case::estimated("borehole", 8, borehole)?,
        Case::estimated("waves", 5, waves)?,
        Case::estimated("bowl", 4, bowl)?,
        Case::estimated("within", 5, within)?,
    ];
    println!("Sobol indices: % of {repetitions} intervals that hold the exact index");
    for case in &cases {
        for base in [64, 128, 256, 512, 1024] {
            for estimator in [FirstOrder::Combined, FirstOrder::Jansen] {
                indices_held(case, base, estimator, repetitions)?;
            }
        }
    }
    Ok(())
}

fn shares_hold(repetitions: u64) -> Result<(), String> {
    println!("\nVerified share of a Sobol design with 16 replicates: % of {repetitions} intervals that hold it,");
    println!("and their mean width against Clopper and Pearson's");
    for (points, share) in [(512, 0.02), (512, 0.2), (4096, 0.02), (4096, 0.2), (4096, 0.5)] {
        share_held(points, share, repetitions)?;
    }
    Ok(())
}

fn indices_held(case: &Case, base: u64, estimator: FirstOrder, repetitions: u64) -> Result<(), String> {
    let d = case.dimensions;
    let one = |seed: u64| -> Result<Vec<f64>, String> {
        let pairs = pairs(d, base, 1000 + seed)?;
        let outputs: Vec<f64> = design(&pairs).iter().map(|u| (case.function)(u)).collect();
        let found = indices(&outputs, d, estimator).ok_or("too few points")?;
        let exact = case.first.iter().chain(&case.total);
        let all = found.first.iter().chain(&found.total).zip(exact);
        Ok(all.map(|(e, exact)| f64::from(u8::from(e.contains(*exact)))).collect())
    };
    let held: Vec<Vec<f64>> = (0..repetitions).into_par_iter().map(one).collect::<Result<_, _>>()?;
    let shares: Vec<f64> =
        (0..2 * d).map(|k| 100.0 * held.iter().map(|h| h[k]).sum::<f64>() / repetitions as f64).collect();
    let mean = shares.iter().sum::<f64>() / shares.len() as f64;
    let least = shares.iter().copied().fold(100.0, f64::min);
    println!(
        "  {:<10} {base:>5} base points, {estimator:?}: {mean:.1} in the mean, {least:.1} at least, one by one {shares:.1?}",
        case.name
    );
    Ok(())
}

/// Points of a seven-dimensional cube count as verified in a corner with the volume `share` that is cut
/// by three of the parameters, and by the sum of two others.
fn share_held(points: u64, share: f64, repetitions: u64) -> Result<(), String> {
    const REPLICATES: u64 = 16;
    // Half of what is left of three parameters lies below the diagonal of two others.
    let side = (2.0 * share).min(1.0).cbrt();
    let verified = |u: &[f64]| u[..3].iter().all(|v| *v < side) && u[3] + u[6] < 1.0;
    let one = |seed: u64| -> Result<[f64; 3], String> {
        let cube = cube(7, points, 5000 + seed, REPLICATES)?;
        let mut counts = [0_u64; REPLICATES as usize];
        for (index, u) in cube.iter().enumerate() {
            counts[index % counts.len()] += u64::from(verified(u));
        }
        let hits: u64 = counts.iter().sum();
        let [from, to] = clopper_pearson(hits as f64, points as f64, 0.95);
        let [low, high] = randomised(&counts, points, 0.95);
        Ok([f64::from(u8::from(low <= share && share <= high)), high - low, to - from])
    };
    let all: Vec<[f64; 3]> = (0..repetitions).into_par_iter().map(one).collect::<Result<_, _>>()?;
    let sum = |k: usize| all.iter().map(|r| r[k]).sum::<f64>();
    println!(
        "  share {share}, {points} points: {:.1}, width {:.2} of Clopper and Pearson's",
        100.0 * sum(0) / repetitions as f64,
        sum(1) / sum(2)
    );
    Ok(())
}

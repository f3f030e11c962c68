//! Rank correlations: how often their intervals hold those of many more points.

use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};
use rayon::prelude::*;
use sampling::design::cube;
use sensitivity::functions::{ishigami, sobol_g};
use sensitivity::rank::{Correlations, correlations};

use crate::{Case, G, borehole, percent};

pub fn print(repetitions: u64) -> Result<(), String> {
    println!("\nRank correlations: % of {repetitions} intervals that hold those of 400,000 points");
    let linear = |u: &[f64]| u.iter().zip(1_u8..).map(|(u, k)| f64::from(k) * u).sum();
    let corner = |u: &[f64]| f64::from(u8::from(u[0] < 0.3 && u[1] > 0.2));
    let steep = |u: &[f64]| (2.0 * u.iter().sum::<f64>()).exp();
    let cases = [
        Case::new("Ishigami", 3, ishigami, &[], &[]),
        Case::new("Sobol's g", 4, |u| sobol_g(u, &G), &[], &[]),
        Case::new("linear", 6, linear, &[], &[]),
        Case::new("exponential", 4, steep, &[], &[]),
        Case::new("borehole", 8, borehole, &[], &[]),
        Case::new("pass or fail", 4, corner, &[], &[]),
    ];
    for case in &cases {
        let many = found(case, &independent(case.dimensions, 400_000, 1)).ok_or("too few")?;
        for points in [50, 128, 512, 2048] {
            for (design, sample) in [
                ("independent", independent as fn(usize, u64, u64) -> Vec<Vec<f64>>),
                ("net", |d, points, seed| cube(d, points, seed, 1).unwrap_or_default()),
            ] {
                held(case, &many, design, |seed| sample(case.dimensions, points, seed), points, repetitions)?;
            }
        }
    }
    Ok(())
}

fn independent(dimensions: usize, points: u64, seed: u64) -> Vec<Vec<f64>> {
    let mut random = StdRng::seed_from_u64(seed);
    let mut point = || (0..dimensions).map(|_| random.random()).collect();
    (0..points).map(|_| point()).collect()
}

fn found(case: &Case, points: &[Vec<f64>]) -> Option<Correlations> {
    let column = |k: usize| points.iter().map(|u| u[k]).collect();
    let columns: Vec<Vec<f64>> = (0..case.dimensions).map(column).collect();
    let columns: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
    let outputs: Vec<f64> = points.iter().map(|u| (case.function)(u)).collect();
    correlations(&columns, &outputs)
}

fn held(
    case: &Case,
    many: &Correlations,
    design: &str,
    sample: impl Fn(u64) -> Vec<Vec<f64>> + Sync,
    points: u64,
    repetitions: u64,
) -> Result<(), String> {
    let one = |seed: u64| -> Option<Vec<f64>> {
        let found = found(case, &sample(6000 + seed))?;
        let pairs = |few: &[sensitivity::Estimate], many: &[sensitivity::Estimate]| {
            let pairs = few.iter().zip(many);
            let held = pairs.map(|(few, many)| f64::from(u8::from(few.contains(many.value))));
            held.collect::<Vec<f64>>()
        };
        let partial = pairs(&found.partial, &many.partial);
        Some([pairs(&found.spearman, &many.spearman), partial].concat())
    };
    let all: Option<Vec<Vec<f64>>> = (0..repetitions).into_par_iter().map(one).collect();
    let all = all.ok_or("too few")?;
    let mean = |k: usize| percent(all.iter().map(|r| r[k]).sum::<f64>() / repetitions as f64);
    let least = |places: std::ops::Range<usize>| places.map(mean).fold(100.0, f64::min);
    let d = case.dimensions;
    println!(
        "  {:<12} {points:>4} points, {design:<11}: Spearman {:.1} at least, partial {:.1}",
        case.name,
        least(0..d),
        least(d..2 * d)
    );
    Ok(())
}

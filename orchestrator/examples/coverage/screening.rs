//! Morris's mu*: how often its interval holds the mean over the whole grid.

use crate::functions::{ishigami, sobol_g};
use rayon::prelude::*;
use sensitivity::morris::{design, effects};

use crate::{Case, G, percent};

const LEVELS: usize = 4;

pub fn print(repetitions: u64) -> Result<(), String> {
    println!("\nMorris's mu*: % of {repetitions} intervals that hold the mean over the grid");
    let product = |u: &[f64]| u[0] * u[1] + 0.3 * u[2];
    let corner = |u: &[f64]| f64::from(u8::from(u[..3].iter().sum::<f64>() > 2.2));
    let jump = |u: &[f64]| f64::from(u8::from(u[..3].iter().sum::<f64>() > 2.2)) + u[3];
    let steep = |u: &[f64]| (2.0 * u.iter().sum::<f64>()).exp();
    let cases = [
        Case::new("Ishigami", 3, ishigami, &[], &[]),
        Case::new("Sobol's g", 4, |u| sobol_g(u, &G), &[], &[]),
        Case::new("product", 3, product, &[], &[]),
        Case::new("exponential", 4, |u| (u.iter().sum::<f64>()).exp(), &[], &[]),
        Case::new("steeper", 4, steep, &[], &[]),
        Case::new("jump and x4", 4, jump, &[], &[]),
        Case::new("pass or fail", 4, corner, &[], &[]),
    ];
    for case in &cases {
        for trajectories in [10, 20, 50, 200] {
            held(case, trajectories, repetitions)?;
        }
    }
    Ok(())
}

/// The mean magnitude of each parameter's effects over all points of the grid.
pub fn exact(case: &Case) -> Vec<f64> {
    let d = case.dimensions;
    let points = LEVELS.pow(d as u32);
    let grid = |number: usize| -> Vec<usize> {
        let place = |k: usize| number / LEVELS.pow(k as u32) % LEVELS;
        (0..d).map(place).collect()
    };
    let value = |place: &[usize]| {
        let u: Vec<f64> = place.iter().map(|&k| k as f64 / (LEVELS - 1) as f64).collect();
        (case.function)(&u)
    };
    let jump = LEVELS / 2;
    let step = jump as f64 / (LEVELS - 1) as f64;
    let of = |parameter: usize| {
        let low = (0..points).map(grid).filter(|place| place[parameter] < jump);
        let sizes = low.map(|mut place| {
            let before = value(&place);
            place[parameter] += jump;
            (value(&place) - before).abs() / step
        });
        sizes.sum::<f64>() / (points / 2) as f64
    };
    (0..d).map(of).collect()
}

fn held(case: &Case, trajectories: usize, repetitions: u64) -> Result<(), String> {
    let exact = exact(case);
    let one = |seed: u64| -> Result<Vec<f64>, String> {
        let rows = design(case.dimensions, trajectories, LEVELS, 9000 + seed);
        let outputs: Vec<f64> = rows.iter().map(|u| (case.function)(u)).collect();
        let found = effects(&rows, &outputs).ok_or("too few")?;
        // The grid's mean is rounded, too.
        let near = |x: f64, y: f64| (x - y).abs() <= 1e-9 * y.abs().max(1.0);
        let held = found.iter().zip(&exact).map(|(e, &x)| {
            let mu_star = e.mu_star;
            f64::from(u8::from(mu_star.contains(x) || near(mu_star.value, x)))
        });
        Ok(held.collect())
    };
    let all: Vec<Vec<f64>> = (0..repetitions).into_par_iter().map(one).collect::<Result<_, _>>()?;
    let mean = |k: usize| percent(all.iter().map(|r| r[k]).sum::<f64>() / repetitions as f64);
    let each: Vec<f64> = (0..case.dimensions).map(mean).collect();
    println!("  {:<12} {trajectories:>3} trajectories: {each:.1?}", case.name);
    Ok(())
}

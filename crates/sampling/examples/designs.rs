//! How far the mean of a smooth function over a design is from its integral, how evenly designs fill the cube, and how far
//! the coefficients of a Latin hypercube are from the wanted ones: `cargo run --release --example designs`.

use sampling::design::correlation::Correlation;
use sampling::design::{Design, Inputs, Method, Sampling};
use sampling::distribution::Distribution;

const UNIT: Distribution = Distribution::Uniform { min: 0.0, max: 1.0 };

fn main() -> Result<(), String> {
    integrals()?;
    discrepancies()?;
    correlations()
}

fn points(method: Method, points: u64, seed: u64, inputs: impl Into<Inputs>) -> Result<Vec<Vec<f64>>, String> {
    let sampling = Sampling { method, points, seed, replicates: 1 };
    let design = Design::new(&sampling, inputs)?;
    Ok((0..points).map(|index| design.point(index)).collect())
}

fn integrals() -> Result<(), String> {
    println!("the mean of x1 x2 x3 x4 (exact: 1/16) over 1024 points; largest error of 20 seeds");
    for method in
        [Method::MonteCarlo, Method::LatinHypercube, Method::OptimisedLatinHypercube, Method::Halton, Method::Sobol]
    {
        let mut worst: f64 = 0.0;
        for seed in 0..20 {
            let points = points(method, 1024, seed, vec![UNIT; 4])?;
            let products = points.iter().map(|point| point.iter().product::<f64>());
            worst = worst.max((products.sum::<f64>() / 1024.0 - 0.0625).abs());
        }
        println!("{:<26} {worst:.2e}", method.name());
    }
    Ok(())
}

fn discrepancies() -> Result<(), String> {
    println!("\nsquare of the centred L2 discrepancy in seven inputs, mean of 5 seeds: 50, 200, 1000 points");
    for method in [Method::LatinHypercube, Method::Sobol, Method::OptimisedLatinHypercube] {
        print!("{:<26}", method.name());
        for count in [50, 200, 1000] {
            let mut sum = 0.0;
            for seed in 0..5 {
                sum += discrepancy(&points(method, count, seed, vec![UNIT; 7])?);
            }
            print!(" {:.3e}", sum / 5.0);
        }
        println!();
    }
    Ok(())
}

/// Hickernell (1998), eq. 4.4.
fn discrepancy(points: &[Vec<f64>]) -> f64 {
    let n = points.len() as f64;
    let far = |x: &f64| (x - 0.5).abs();
    let one = |x: &f64| 1.0 + 0.5 * far(x) - 0.5 * far(x).powi(2);
    let two = |(x, y): (&f64, &f64)| 1.0 + 0.5 * (far(x) + far(y) - (x - y).abs());
    let ones: f64 = points.iter().map(|p| p.iter().map(one).product::<f64>()).sum();
    let row = |p: &Vec<f64>| -> f64 {
        let pairs = points.iter().map(|q| p.iter().zip(q).map(two).product::<f64>());
        pairs.sum()
    };
    let twos: f64 = points.iter().map(row).sum();
    let inputs = points.first().map_or(0, Vec::len);
    (13.0_f64 / 12.0).powf(inputs as f64) - 2.0 / n * ones + twos / (n * n)
}

fn correlations() -> Result<(), String> {
    println!(
        "\nfour normal inputs, coefficients 0.8, -0.5, -0.2 and 0: largest and rms deviation of all pairs, 50 seeds"
    );
    let wanted = [(0, 1, 0.8), (0, 3, -0.5), (1, 3, -0.2), (0, 2, 0.0), (1, 2, 0.0), (2, 3, 0.0)];
    let normal = Distribution::Normal { mean: 0.0, deviation: 1.0 };
    for method in [Method::MonteCarlo, Method::LatinHypercube, Method::OptimisedLatinHypercube] {
        for count in [20, 50, 200, 1000] {
            let [mut largest, mut squares] = [0.0_f64; 2];
            for seed in 0..if count > 500 { 10 } else { 50 } {
                let inputs = Inputs {
                    joints: Vec::new(),
                    distributions: vec![normal.clone(); 4],
                    levels: Vec::new(),
                    correlation: Some(Correlation::new(4, &wanted)?),
                };
                let points = points(method, count, seed, inputs)?;
                for (a, b, r) in wanted {
                    let off = pearson(&points, a, b) - r;
                    largest = largest.max(off.abs());
                    squares += off * off / 6.0 / if count > 500 { 10.0 } else { 50.0 };
                }
            }
            println!("{:<26} {count:>5} {largest:.1e} {:.1e}", method.name(), squares.sqrt());
        }
    }
    Ok(())
}

fn pearson(points: &[Vec<f64>], a: usize, b: usize) -> f64 {
    let n = points.len() as f64;
    let mean = |i: usize| points.iter().map(|p| p[i]).sum::<f64>() / n;
    let means = [mean(a), mean(b)];
    let product = |i: usize, k: usize| {
        let of = |p: &Vec<f64>| (p[[a, b][i]] - means[i]) * (p[[a, b][k]] - means[k]);
        points.iter().map(of).sum::<f64>()
    };
    product(0, 1) / (product(0, 0) * product(1, 1)).sqrt()
}

//! How far the mean of a smooth function over a design is from its integral: `cargo run --release --example designs`.

use sampling::design::{Design, Method, Sampling};
use sampling::distribution::Distribution;

const UNIT: Distribution = Distribution::Uniform { min: 0.0, max: 1.0 };

fn main() -> Result<(), String> {
    println!("the mean of x1 x2 x3 x4 (exact: 1/16) over 1024 points; largest error of 20 seeds");
    for &method in Method::ALL {
        let mut worst: f64 = 0.0;
        for seed in 0..20 {
            let sampling = Sampling { method, points: 1024, seed, replicates: 1 };
            let design = Design::new(&sampling, vec![UNIT; 4])?;
            let products = (0..1024).map(|index| design.point(index).iter().product::<f64>());
            worst = worst.max((products.sum::<f64>() / 1024.0 - 0.0625).abs());
        }
        println!("{:<16} {worst:.2e}", method.name());
    }
    Ok(())
}

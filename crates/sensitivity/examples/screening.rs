//! Morris screening: three of twenty parameters matter, and 210 runs find them.
//!
//! `cargo run -p sensitivity --example screening`

use std::error::Error;

use sensitivity::morris::{design, effects};

fn main() -> Result<(), Box<dyn Error>> {
    let (parameters, trajectories, levels, seed) = (20, 10, 4, 1);
    let points = design(parameters, trajectories, levels, seed);
    // Parameters 3 and 7 act together, parameter 11 alone, the others hardly.
    let model = |x: &[f64]| 4.0 * x[3] * x[7] + 2.0 * x[11] + 0.01 * x.iter().sum::<f64>();
    let values: Vec<f64> = points.iter().map(|point| model(point)).collect();

    let effects = effects(&points, &values).ok_or("too few trajectories")?;
    println!("{} runs", points.len());
    println!("parameter   mu*     sigma (0: linear, without interaction)");
    for (parameter, effect) in effects.iter().enumerate() {
        let mark = if effect.mu_star.low > 0.1 { "matters" } else { "" };
        println!("{parameter:>9}   {:.3}   {:.3}   {mark}", effect.mu_star.value, effect.sigma);
    }
    Ok(())
}

//! Prints all metrics of two curves, a line each: `compare [BAND [NORMALISER]] < pair.csv`.
//!
//! The table has the columns time and value of the reference, then time and value of the model; the shorter curve's
//! cells are empty at the end. For `iso18571` an uneven reference is put on even times first.

use std::error::Error;
use std::io::{Read, stdin};

use curves::{Curve, Metric, Pair, Sampler, iso18571};

fn main() -> Result<(), Box<dyn Error>> {
    let options: Vec<f64> = std::env::args().skip(1).map(|text| text.parse()).collect::<Result<_, _>>()?;
    let mut text = String::new();
    stdin().read_to_string(&mut text)?;
    let [reference, model] = read(&text)?;
    for &metric in Metric::ALL {
        let curve = if metric.needs_even_times() { reference.evenly() } else { reference.clone() };
        let values = sample(&curve, &model)?;
        let band = vec![options.first().copied().unwrap_or(0.0); values.len()];
        let pair = Pair {
            band: &band,
            normaliser: options.get(1).copied().unwrap_or(1.0),
            ..Pair::new(curve.values(), &values)
        };
        println!("{} {:?}", metric.name(), metric.compare(&pair));
        if metric == Metric::Iso18571 {
            let parts = iso18571::rate(curve.values(), &values);
            println!("corridor-rating {:?}", parts.corridor);
            println!("phase-rating {:?}", parts.phase);
            println!("magnitude-rating {:?}", parts.magnitude);
            println!("slope-rating {:?}", parts.slope);
        }
    }
    Ok(())
}

/// The model's values at the reference's times, as a simulation would give them.
fn sample(reference: &Curve, model: &Curve) -> Result<Vec<f64>, String> {
    let mut sampler = Sampler::new(reference.times().to_vec());
    sampler.add_all(model.times().iter().copied().zip(model.values().iter().copied()));
    let values = sampler.finish().map(<[f64]>::to_vec);
    values.map_err(|time| format!("the model ends before {time}"))
}

fn read(text: &str) -> Result<[Curve; 2], Box<dyn Error>> {
    let mut columns = [const { Vec::new() }; 4];
    for line in text.lines() {
        for (column, cell) in columns.iter_mut().zip(line.split(',')) {
            if !cell.trim().is_empty() {
                column.push(cell.trim().parse::<f64>()?);
            }
        }
    }
    let [a, b, c, d] = columns;
    Ok([Curve::new(a, b)?, Curve::new(c, d)?])
}

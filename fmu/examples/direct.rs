//! The stand called from Rust, without FMI: what the FMU is compared with in `scripts/evidence/bench`.
//!
//! `direct STEP STEPS RUNS` makes RUNS runs of STEPS steps, each from the initial state, reads one
//! output after every step and prints the mean of what it has read.

use std::error::Error;
use std::process::ExitCode;

use fmu_export::model::{Experiment, Model};
use plain_bearing_stand::stand::Stand;

fn main() -> ExitCode {
    match run() {
        Ok(mean) => {
            println!("{mean:e}");
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("direct: {error}");
            ExitCode::from(2)
        }
    }
}

fn run() -> Result<f64, Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [step, steps, runs] = arguments.as_slice() else {
        return Err("usage: direct STEP STEPS RUNS".into());
    };
    let (step, steps, runs): (f64, u32, u32) = (step.parse()?, steps.parse()?, runs.parse()?);
    let mut sum = 0.0;
    for _ in 0..runs {
        sum += one(step, steps)?;
    }
    Ok(sum / (f64::from(steps) * f64::from(runs)))
}

/// The sum of the bearing load, N, over the steps of one run.
fn one(step: f64, steps: u32) -> Result<f64, Box<dyn Error>> {
    let experiment = Experiment::default();
    let mut stand = Stand::default();
    stand.initialise(&experiment, &mut ())?;
    let mut sum = 0.0;
    for index in 0..steps {
        stand.advance(f64::from(index) * step, step, &mut ())?;
        sum += stand.readings().load_force;
    }
    Ok(sum)
}

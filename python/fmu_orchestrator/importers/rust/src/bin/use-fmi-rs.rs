//! The crate `fmi-rs` as a host. Its builder asks every FMU of FMI 3.0 for event mode, which not all have.

use fmi_rs::fmi2::{builder::FMU2Builder, types::fmi2Status};
use rust_importers::{Scenario, print};

fn good(status: fmi2Status) -> Result<(), String> {
    match status {
        fmi2Status::Ok | fmi2Status::Warning => Ok(()),
        status => Err(format!("status {status:?}")),
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let scenario = Scenario::from_arguments();
    let builder = FMU2Builder::new(&scenario.fmu)?;
    let variables = &builder.model_description.modelVariables;
    let reference = |name: &String| {
        variables.iter().find(|variable| variable.name == *name).expect("a known name").valueReference
    };
    let outputs: Vec<_> = scenario.outputs.iter().map(reference).collect();
    let instance = builder.instantiate_cs("stand")?;
    good(instance.setupExperiment(None, 0.0, None))?;
    for (name, value) in &scenario.start {
        good(instance.setReal(&[reference(name)], &[*value]))?;
    }
    good(instance.enterInitializationMode())?;
    good(instance.exitInitializationMode())?;
    let mut values = vec![0.0; outputs.len()];
    let mut ended = false;
    for i in 0..=scenario.steps {
        if i > 0 && !ended {
            match instance.doStep((i - 1) as f64 * scenario.step, scenario.step, 1) {
                fmi2Status::Discard => ended = true,
                status => good(status)?,
            }
        } else if ended {
            break;
        }
        good(instance.getReal(&outputs, &mut values))?;
        print(values.iter().copied());
    }
    good(instance.terminate())?;
    Ok(())
}

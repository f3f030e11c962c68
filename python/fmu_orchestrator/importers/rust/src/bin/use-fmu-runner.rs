//! The crate `fmu-runner` as a host.

use std::collections::HashMap;

use fmu_runner::{Fmu, FmuInstance, fmi2Type};
use rust_importers::{Scenario, print};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let scenario = Scenario::from_arguments();
    let fmu = Fmu::unpack(&scenario.fmu)?.load(fmi2Type::fmi2CoSimulation)?;
    let instance = FmuInstance::instantiate(&fmu, false)?;
    let variables = instance.lib.variables();
    instance.setup_experiment(0.0, None, None)?;
    let start = scenario.start.iter().map(|(name, value)| (&variables[name], *value));
    instance.set_reals(&start.collect::<HashMap<_, _>>())?;
    instance.enter_initialization_mode()?;
    instance.exit_initialization_mode()?;
    let outputs = scenario.outputs.iter().map(|name| &variables[name]).collect::<Vec<_>>();
    let mut ended = false;
    for i in 0..=scenario.steps {
        if i > 0 && !ended {
            match instance.do_step((i - 1) as f64 * scenario.step, scenario.step, true) {
                // The crate does not make the type of the status known.
                Err(error) if format!("{error:?}").contains("fmi2Discard") => ended = true,
                done => done?,
            }
        } else if ended {
            break;
        }
        let values = instance.get_reals(&outputs)?;
        print(outputs.iter().map(|output| values[output]));
    }
    Ok(())
}

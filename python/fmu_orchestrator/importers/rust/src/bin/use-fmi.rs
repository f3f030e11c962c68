//! The crate `fmi` as a host.

use fmi::fmi2::Fmi2Error;
use fmi::fmi2::import::Fmi2Import;
use fmi::fmi2::instance::{CoSimulation, Common};
use fmi::traits::FmiImport;
use rust_importers::{Scenario, print};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let scenario = Scenario::from_arguments();
    let import: Fmi2Import = fmi::import::from_path(&scenario.fmu)?;
    let variables = &import.model_description().model_variables.variables;
    let reference = |name: &String| {
        let variable = variables.iter().find(|variable| variable.name == *name);
        variable.expect("a known name").value_reference
    };
    let outputs = scenario.outputs.iter().map(reference).collect::<Vec<_>>();
    let mut instance = import.instantiate_cs("stand", false, false)?;
    instance.setup_experiment(None, 0.0, None)?;
    for (name, value) in &scenario.start {
        instance.set_real(&[reference(name)], &[*value])?;
    }
    instance.enter_initialization_mode()?;
    instance.exit_initialization_mode()?;
    let mut values = vec![0.0; outputs.len()];
    let mut ended = false;
    for i in 0..=scenario.steps {
        if i > 0 && !ended {
            match instance.do_step((i - 1) as f64 * scenario.step, scenario.step, true) {
                Err(Fmi2Error::Discard) => ended = true,
                done => drop(done?),
            }
        } else if ended {
            return Ok(());
        }
        instance.get_real(&outputs, &mut values)?;
        print(values.iter().copied());
    }
    let description = import.model_description().co_simulation.as_ref();
    if !description.is_some_and(|cs| cs.can_serialize_fmu_state == Some(true)) {
        return Ok(instance.terminate().map(drop)?);
    }
    // A state must come back as it was, also as bytes.
    let state = instance.get_fmu_state()?;
    let bytes = instance.serialize_fmu_state(&state)?;
    let copy = instance.deserialize_fmu_state(&bytes)?;
    instance.do_step(scenario.steps as f64 * scenario.step, scenario.step, true)?;
    instance.set_fmu_state(&copy);
    let mut again = vec![0.0; outputs.len()];
    instance.get_real(&outputs, &mut again)?;
    assert_eq!(values, again);
    instance.terminate()?;
    Ok(())
}

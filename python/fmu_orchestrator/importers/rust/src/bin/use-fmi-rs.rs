//! The crate `fmi-rs` as a host.

use fmi_rs::fmi2::{builder::FMU2Builder, types::fmi2Status};
use fmi_rs::fmi3::{builder::FMU3Builder, types::fmi3Status};
use rust_importers::{Scenario, print};

type Failure = Box<dyn std::error::Error>;

/// An error for every status but OK and warning.
macro_rules! good {
    ($statuses:ident, $status:expr) => {
        match $status {
            $statuses::Ok | $statuses::Warning => {}
            status => return Err(format!("{}: {status:?}", stringify!($status)).into()),
        }
    };
}

fn main() -> Result<(), Failure> {
    let scenario = Scenario::from_arguments();
    match FMU2Builder::new(&scenario.fmu) {
        Ok(builder) => old(&builder, &scenario),
        Err(error) => new(&FMU3Builder::new(&scenario.fmu).map_err(|other| format!("{error}; {other}"))?, &scenario),
    }
}

fn old(builder: &FMU2Builder, scenario: &Scenario) -> Result<(), Failure> {
    let variables = &builder.model_description.modelVariables;
    let reference = |name: &String| {
        variables.iter().find(|variable| variable.name == *name).expect("a known name").valueReference
    };
    let outputs: Vec<_> = scenario.outputs.iter().map(reference).collect();
    let instance = builder.instantiate_cs("stand")?;
    good!(fmi2Status, instance.setupExperiment(None, 0.0, None));
    for (name, value) in &scenario.start {
        good!(fmi2Status, instance.setReal(&[reference(name)], &[*value]));
    }
    good!(fmi2Status, instance.enterInitializationMode());
    good!(fmi2Status, instance.exitInitializationMode());
    let mut values = vec![0.0; outputs.len()];
    for i in 0..=scenario.steps {
        if i > 0 {
            good!(fmi2Status, instance.doStep((i - 1) as f64 * scenario.step, scenario.step, 1));
        }
        good!(fmi2Status, instance.getReal(&outputs, &mut values));
        print(values.iter().copied());
    }
    good!(fmi2Status, instance.terminate());
    Ok(())
}

fn new(builder: &FMU3Builder, scenario: &Scenario) -> Result<(), Failure> {
    let variables = &builder.model_description.modelVariables;
    let reference = |name: &String| {
        variables.iter().find(|variable| variable.name == *name).expect("a known name").valueReference
    };
    let outputs: Vec<_> = scenario.outputs.iter().map(reference).collect();
    let instance = builder.instantiate_cs("stand")?;
    for (name, value) in &scenario.start {
        good!(fmi3Status, instance.setFloat64(&[reference(name)], &[*value]));
    }
    good!(fmi3Status, instance.enterInitializationMode(None, 0.0, None));
    good!(fmi3Status, instance.exitInitializationMode());
    let mut values = vec![0.0; outputs.len()];
    for i in 0..=scenario.steps {
        if i > 0 {
            let (mut event, mut ends, mut early, mut last) = (false, false, false, 0.0);
            let time = (i - 1) as f64 * scenario.step;
            good!(fmi3Status, instance.doStep(time, scenario.step, true, &mut event, &mut ends, &mut early, &mut last));
        }
        good!(fmi3Status, instance.getFloat64(&outputs, &mut values));
        print(values.iter().copied());
    }
    good!(fmi3Status, instance.terminate());
    Ok(())
}

//! Opens an FMU, prints its variables, and makes ten steps of its suggested experiment.
//!
//! `cargo run -p fmu-import --example steps -- model.fmu`

use std::error::Error;
use std::path::Path;

use fmu_import::{Causality, Instance, Package};

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).ok_or("usage: steps FMU")?;
    let mut package = Package::open(Path::new(&path))?;
    let library = package.load()?;
    let description = package.description();
    for variable in description.variables.values() {
        let unit = variable.unit().unwrap_or("-");
        println!("{} [{unit}] {:?}", variable.name, variable.causality);
    }

    let experiment = description.default_experiment;
    let start = experiment.start.unwrap_or(0.0);
    let stop = experiment.stop.unwrap_or(start + 1.0);
    let time = |index: i32| start + f64::from(index) * (stop - start) / 10.0;

    let mut instance = Instance::new(&library, "example")?;
    instance.setup_experiment(start, stop, experiment.tolerance)?;
    instance.initialise()?;
    for index in 0..10 {
        instance.step(time(index), time(index + 1) - time(index))?;
        for output in description.with(Causality::Output) {
            let value = instance.value(output.handle())?;
            println!("{} s: {} = {value:?}", time(index + 1), output.name);
        }
    }
    instance.terminate()?;
    Ok(())
}

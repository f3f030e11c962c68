//! The simulator `fmi-sim` as a host, with the options of its command line.

use fmi_sim::options::{CoSimulationOptions, CommonOptions, FmiSimOptions, Interface};
use rust_importers::{Scenario, print};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let scenario = Scenario::from_arguments();
    let start = scenario.start.iter().map(|(name, value)| format!("{name}={value:?}"));
    let common = CommonOptions {
        initial_values: start.collect(),
        step_size: Some(scenario.step),
        output_interval: Some(scenario.step),
        start_time: Some(0.0),
        stop_time: Some(scenario.steps as f64 * scenario.step),
        ..Default::default()
    };
    let options = FmiSimOptions {
        interface: Interface::CoSimulation(CoSimulationOptions { common, ..Default::default() }),
        model: scenario.fmu.into(),
        ..Default::default()
    };
    let (table, _) = fmi_sim::simulate(&options)?;
    let columns = scenario.outputs.iter().map(|name| {
        let column = table.column_by_name(name).ok_or_else(|| format!("no column {name}"))?;
        let column = column.as_any().downcast_ref::<arrow::array::Float64Array>();
        column.ok_or_else(|| format!("{name} is not real"))
    });
    let columns = columns.collect::<Result<Vec<_>, _>>()?;
    for row in 0..table.num_rows() {
        print(columns.iter().map(|column| column.value(row)));
    }
    Ok(())
}

//! `synchronise`: from measured time series to criteria.

mod settings;

use std::path::Path;
use std::process::ExitCode;

use super::{CommandError, output};
use crate::analysis::synchronise::{Synchronised, criteria, synchronise};
use crate::cli;
use crate::report::figures::{Series, history};
use crate::report::svg;
use crate::results::{ResultsError, write_atomically};
use settings::Settings;

pub use settings::SettingsError;

pub(super) fn run(options: &cli::Synchronise) -> Result<ExitCode, CommandError> {
    let settings = Settings::read(&options.settings)?;
    let recording = settings.recording(&options.settings, &options.measured)?;
    let result = synchronise(&recording).map_err(|source| SettingsError::Signal {
        path: options.measured.clone(),
        source,
    })?;
    let folder = &options.output;
    std::fs::create_dir_all(folder).map_err(ResultsError::io(folder))?;
    let text = criteria::to_toml(&result, options.amplitudes);
    save(&folder.join("criteria.toml"), &text)?;
    save(&folder.join("synchronised.csv"), &table(&result))?;
    for (name, picture) in pictures(&result) {
        save(&folder.join(name), &svg::standalone(&picture))?;
    }
    output::print(&format!("{text}\nresults in {}\n", folder.display()));
    Ok(ExitCode::SUCCESS)
}

fn save(path: &Path, text: &str) -> Result<(), CommandError> {
    write_atomically(path, |out| out.write_all(text.as_bytes()))?;
    Ok(())
}

fn table(result: &Synchronised) -> String {
    let mut text =
        String::from("time_s,load_N,torque_before_Nm,torque_Nm,friction_before,friction,power_W\n");
    for (k, time) in result.time.iter().enumerate() {
        text += &format!(
            "{time:.6},{:.5e},{:.5e},{:.5e},{:.5e},{:.5e},{:.5e}\n",
            result.load[k],
            result.torque_before[k],
            result.torque[k],
            result.friction_before[k],
            result.friction[k],
            result.power[k]
        );
    }
    text
}

/// The last turns of the signals, before and after (the paper's Fig. 5).
fn pictures(result: &Synchronised) -> Vec<(&'static str, String)> {
    const SHOWN: f64 = 1.0;
    let end = result.time.last().copied().unwrap_or(0.0);
    let from = result.time.partition_point(|t| *t < end - SHOWN);
    let series = |name: &str, unit: &str, values: &[f64]| Series {
        name: name.to_owned(),
        unit: unit.to_owned(),
        time: result.time[from..].to_vec(),
        values: values[from..].to_vec(),
        accepted: None,
    };
    [
        ("load.svg", series("Load", "N", &result.load)),
        (
            "torque.svg",
            series("Torque, shifted", "N.m", &result.torque),
        ),
        ("power.svg", series("Friction power", "W", &result.power)),
        (
            "friction-before.svg",
            series(
                "Friction coefficient before the shift",
                "1",
                &result.friction_before,
            ),
        ),
        (
            "friction.svg",
            series("Friction coefficient", "1", &result.friction),
        ),
    ]
    .into_iter()
    .filter_map(|(name, series)| Some((name, history(&series)?)))
    .collect()
}

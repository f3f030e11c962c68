//! `synchronise`: from measured time series to criteria, and a page that shows how.

use std::process::ExitCode;

use super::output;
use crate::{
    cli,
    error::Result,
    recording::{Settings, columns::RecordedFiles},
    report::recording,
};
use number_tables::files::FileError;
use point_journal::files::{make_output, write_text};
use rig_signals::{
    RigRecording, Synchronised,
    case::{Case, Frame},
    criteria, synchronise,
};

/// Where nothing drives the model.
const NO_DRIVE: &str = "nothing drives the model in a case: add the FMU's variable to the speed, speed = { variable = \
                        \"drive.speed\", ... }, or inputs.\"VARIABLE\" = { column = \"...\" }";

pub fn run(options: &cli::Synchronise) -> Result<ExitCode> {
    let settings = Settings::read(&options.settings)?;
    let files = settings.files(&options.measured)?;
    let recorded = files.recording()?;
    let first = &options.measured[0];
    let mut result = synchronise(&recorded).map_err(|error| FileError::new(first, error.to_string()))?;
    result.warnings.extend(files.notes());
    if options.case.is_some() {
        result.warnings.extend(files.too_tight(&recorded, &result));
    }
    let folder = &options.output;
    make_output(folder)?;
    let mut text = criteria::to_toml(&result);
    write_text(&folder.join("criteria.toml"), &text)?;
    if recorded.bearing.is_some() {
        write_text(&folder.join("synchronised.csv"), table(&result))?;
    }
    let title = number_tables::files::name(first);
    recording::write(&recorded, &result, &title, folder)?;
    if let Some(name) = &options.case {
        text = case(name, options, (&settings, &files), &recorded, &result)?;
    }
    output::print(&format!("{text}\nresults in {}\n", folder.display()));
    Ok(ExitCode::SUCCESS)
}

/// Writes the recording as a case of a study; gives its text.
fn case(
    name: &str,
    options: &cli::Synchronise,
    (settings, files): (&Settings, &RecordedFiles),
    recorded: &RigRecording,
    result: &Synchronised,
) -> Result<String> {
    let (folder, drives) = (&options.output, files.drives()?);
    settings.check_case(name)?;
    if drives.is_empty() && recorded.bearing.is_some() {
        return Err(FileError::new(&options.settings, NO_DRIVE).into());
    }
    let case = Case::new(recorded, result, &drives);
    case.check().map_err(|error| FileError::new(&options.settings, error.to_string()))?;
    let frame = Frame {
        name,
        held_out: options.held_out,
        folder: &folder.to_string_lossy().replace('\\', "/"),
        tolerances: &settings.tolerances(),
        lag: settings.lag()?,
    };
    let text = case.to_toml(&frame);
    for (file, table) in case.tables() {
        write_text(&folder.join(file), table)?;
    }
    write_text(&folder.join("case.toml"), &text)?;
    Ok(text)
}

fn table(result: &Synchronised) -> String {
    let mut text = String::from("time_s,load_N,torque_before_Nm,torque_Nm,friction_before,friction\n");
    for (k, time) in result.time.iter().enumerate() {
        text += &format!(
            "{time:.6},{:.5e},{:.5e},{:.5e},{:.5e},{:.5e}\n",
            result.load[k], result.torque_before[k], result.torque[k], result.friction_before[k], result.friction[k]
        );
    }
    text
}

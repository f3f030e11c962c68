//! `init`: a starting study from an FMU's own variables.

use std::fmt::Write;
use std::path::Path;
use std::process::ExitCode;

use super::{CommandError, output};
use crate::cli::Init;
use crate::results::points::number;
use crate::results::{ResultsError, write_atomically};
use crate::task::Schedule;
use fmu_import::{Causality, Description, Kind, Package, Variability, Variable};
use sampling::design::Method;

pub(super) fn run(options: &Init) -> Result<ExitCode, CommandError> {
    let package = Package::open(&options.fmu)?;
    let absolute = std::path::absolute(&options.fmu).unwrap_or_else(|_| options.fmu.clone());
    let study = study(package.description(), &absolute);
    match &options.output {
        None => output::print(&study),
        Some(path) if path.exists() => {
            return Err(CommandError::Option {
                option: "output",
                message: format!("{} exists already", path.display()),
            });
        }
        Some(path) => {
            let written = write_atomically(path, |out| out.write_all(study.as_bytes()));
            written.map_err(|error: ResultsError| CommandError::Results(error))?;
            output::print(&format!("{}\n", path.display()));
        }
    }
    Ok(ExitCode::SUCCESS)
}

/// The text of the study. Everything that needs a decision is a comment.
fn study(fmu: &Description, path: &Path) -> String {
    let schedule = Schedule::suggested(fmu);
    let mut text = String::new();
    // Writing to a String cannot fail.
    let _ = writeln!(
        text,
        "# A starting study of {}. Remove the marks of what you need.\n\n\
         title = {:?}\nfmu = {:?}\n\n[simulation]\nstop = {} # s\nstep = {} # s\n\
         # warm-up = 1 # s that statistics leave out\n\n[design]\n\
         method = \"sobol\" # or {}\npoints = 64\nseed = 1",
        fmu.model_name,
        fmu.model_name,
        path.display().to_string(),
        schedule.stop,
        schedule.step,
        Method::named(|method| method != Method::Sobol)
    );
    text.push_str("\n# Uncertain parameters\n");
    for variable in fmu.with(Causality::Parameter) {
        parameter(&mut text, fmu, variable);
    }
    text.push_str("\n# Measured quantities; a study needs at least one criterion\n");
    for variable in measurable(fmu, &mut text) {
        criterion(&mut text, variable);
    }
    text
}

/// The variables that can be compared with a measurement: the outputs, or else what the FMU shows of its inside.
fn measurable<'a>(fmu: &'a Description, text: &mut String) -> Vec<&'a Variable> {
    const MOST: usize = 50;
    let real = |variable: &&Variable| {
        matches!(variable.kind, Kind::Real { .. }) && variable.variability != Variability::Constant
    };
    let outputs: Vec<&Variable> = fmu.with(Causality::Output).filter(real).collect();
    if !outputs.is_empty() {
        return outputs;
    }
    let locals: Vec<&Variable> = fmu.with(Causality::Local).filter(real).collect();
    if !locals.is_empty() {
        text.push_str(
            "# The FMU has no outputs of type Real. These are local variables: what it computes inside and shows, \
             which criteria may use, too.\n",
        );
    }
    if locals.len() > MOST {
        let _ = writeln!(
            text,
            "# The first {MOST} of {}; `orchestrator inspect --json` has all.",
            locals.len()
        );
    }
    locals.into_iter().take(MOST).collect()
}

fn parameter(text: &mut String, fmu: &Description, variable: &Variable) {
    let Kind::Real {
        start: Some(start), ..
    } = &variable.kind
    else {
        return;
    };
    let shown = variable.display_unit();
    let way = shown.and_then(|shown| fmu.conversion(shown, variable).ok());
    let mean = way.map_or(*start, |way| way.inverse().value(*start));
    // Twelve digits hide what the conversion rounds.
    let mean: f64 = format!("{mean:.11e}").parse().unwrap_or(mean);
    let deviation = if mean == 0.0 { 1.0 } else { mean.abs() / 10.0 };
    let deviation: f64 = format!("{deviation:.2e}").parse().unwrap_or(deviation);
    let about = variable.description.as_deref().unwrap_or(&variable.name);
    let _ = writeln!(
        text,
        "\n# {about}\n# [parameters.{:?}]\n# distribution = \"normal\"\n# mean = {}\n# deviation = {}",
        variable.name,
        number(mean),
        number(deviation)
    );
    if let (Some(unit), Some(_)) = (shown, way) {
        let _ = writeln!(text, "# unit = {unit:?}");
    }
}

fn criterion(text: &mut String, variable: &Variable) {
    let about = variable.description.as_deref().unwrap_or(&variable.name);
    let _ = writeln!(
        text,
        "\n# {about}\n# [criteria.{:?}]\n# variable = {:?}\n# statistic = \"final\" # or mean, min, max, rms, amplitude\n\
         # nominal = 1 # the measured value\n# tolerance = \"5 %\" # how far the model may be from the true value\n\
         # uncertainty = \"1 %\" # how far the measured value may be from it, k = 2",
        variable.name.replace('.', "_"),
        variable.name
    );
    if let Some(unit) = variable.display_unit() {
        let _ = writeln!(text, "# unit = {unit:?}");
    }
}

//! `init`: a starting study from an FMU's own variables.

use std::collections::HashSet;
use std::fmt::Write;
use std::path::Path;
use std::process::ExitCode;

use super::output;
use crate::cli::Init;
use crate::error::Error;
use crate::results::points::number;
use crate::results::write_atomically;
use fmu_import::{Causality, Description, Kind, Package, Variability, Variable};
use fmu_points::task::Schedule;
use fmu_points::tell::one_line;
use sampling::design::Method;

pub(super) fn run(options: &Init) -> Result<ExitCode, Error> {
    let package = Package::open(&options.fmu)?;
    let absolute = std::path::absolute(&options.fmu).unwrap_or_else(|_| options.fmu.clone());
    let study = study(package.description(), &absolute);
    match &options.output {
        None => output::print(&study),
        Some(path) if path.exists() => {
            let message = format!("{} exists already", path.display());
            return Err(Error::option("output", message));
        }
        Some(path) => {
            write_atomically(path, |out| out.write_all(study.as_bytes()))?;
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
         title = {}\nfmu = {}\n\n[simulation]\nstop = {} # s\nstep = {} # s\n\
         # warm-up = 1 # s that statistics leave out\n\n[design]\n\
         method = \"sobol\" # or {}\npoints = 64\nseed = 1",
        one_line(&fmu.model_name),
        quoted(&fmu.model_name),
        quoted(&path.display().to_string()),
        schedule.stop,
        schedule.step,
        Method::named(|method| method != Method::Sobol)
    );
    text.push_str("\n# Uncertain parameters\n");
    for variable in fmu.with(Causality::Parameter) {
        parameter(&mut text, fmu, variable);
    }
    text.push_str("\n# Measured quantities; a study needs at least one criterion\n");
    let mut names = HashSet::new();
    for variable in measurable(fmu, &mut text) {
        let short = variable.name.replace('.', "_");
        // `a.b` and `a_b` would both be a_b.
        let name = match names.insert(short.clone()) {
            true => short,
            false => variable.name.clone(),
        };
        criterion(&mut text, &name, variable);
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

/// A normal distribution around the start value, cut where the FMU's own limits are near.
fn parameter(text: &mut String, fmu: &Description, variable: &Variable) {
    let Kind::Real {
        start: Some(start),
        min,
        max,
        nominal,
        ..
    } = variable.kind
    else {
        return;
    };
    let shown = variable.display_unit();
    let way = shown.and_then(|shown| fmu.conversion(shown, variable).ok());
    let shown_value = |value: f64| {
        let Some(way) = way else { return value };
        // What the conversion rounds is hidden: at an offset such as that of degF a zero, and beyond twelve digits.
        let (zero, value) = (way.inverse().value(0.0), way.inverse().value(value));
        match value.abs() < 1e-12 * zero.abs() {
            true => 0.0,
            false => format!("{value:.11e}").parse().unwrap_or(value),
        }
    };
    let limit = |limit: Option<f64>| limit.map(shown_value).filter(|limit| limit.is_finite());
    let ends = [limit(min), limit(max)];
    // A unit may count the other way.
    let [min, max] = match way {
        Some(way) if way.difference(1.0) < 0.0 => [ends[1], ends[0]],
        _ => ends,
    };
    let about = about(variable);
    let _ = writeln!(text, "\n# {about}");
    let mean: f64 = shown_value(start);
    let inside = min.is_none_or(|min| min <= mean) && max.is_none_or(|max| mean <= max);
    let narrow = matches!((min, max), (Some(min), Some(max)) if min >= max);
    if !mean.is_finite() || !inside || narrow {
        let _ = writeln!(
            text,
            "# {}: its start value and limits leave no room for a distribution",
            one_line(&variable.name)
        );
        return;
    }
    let size = match (mean == 0.0, nominal) {
        (false, _) => mean.abs(),
        // A typical magnitude, in the shown unit.
        (true, Some(nominal)) if nominal.is_finite() && nominal != 0.0 => {
            (shown_value(start + nominal) - mean).abs()
        }
        (true, _) => 10.0,
    };
    let deviation: f64 = format!("{:.2e}", size / 10.0).parse().unwrap_or(size);
    // Beyond four deviations lies one point of 30,000.
    let near = |limit: &f64| (limit - mean).abs() < 4.0 * deviation;
    let [min, max] = [min.filter(near), max.filter(near)];
    let shape = match (min, max) {
        (None, None) => "normal",
        _ => "truncated-normal",
    };
    let _ = writeln!(
        text,
        "# [parameters.{}]\n# distribution = \"{shape}\"\n# mean = {}\n# deviation = {}",
        quoted(&variable.name),
        number(mean),
        number(deviation)
    );
    for (key, limit) in [("min", min), ("max", max)] {
        if let Some(limit) = limit {
            let _ = writeln!(text, "# {key} = {}", number(limit));
        }
    }
    if let (Some(unit), Some(_)) = (shown, way) {
        let _ = writeln!(text, "# unit = {}", quoted(unit));
    }
}

/// The FMU's description of a variable, else its name.
fn about(variable: &Variable) -> String {
    // A line end in it would end the comment, and the rest would become part of the study.
    one_line(variable.description.as_deref().unwrap_or(&variable.name)).into_owned()
}

/// A text as TOML writes it.
fn quoted(text: &str) -> String {
    let text = text.replace('\\', "\\\\").replace('"', "\\\"");
    format!("\"{}\"", one_line(&text))
}

fn criterion(text: &mut String, name: &str, variable: &Variable) {
    let _ = writeln!(
        text,
        "\n# {}\n# [criteria.{}]\n# variable = {}\n# statistic = \"final\" # or mean, min, max, rms, amplitude\n\
         # nominal = 1 # the measured value\n# tolerance = \"5 %\" # how far the model may be from the true value; or, instead of both, at-most = 2\n\
         # uncertainty = \"1 %\" # how far the measured value may be from it, k = 2",
        about(variable),
        quoted(name),
        quoted(&variable.name)
    );
    if let Some(unit) = variable.display_unit() {
        let _ = writeln!(text, "# unit = {}", quoted(unit));
    }
}

//! The text of a starting study: short, and complete.

use std::path::{Path, PathBuf};

use super::{
    measured::{Column, Measured},
    run::{SMALL, Signal, TOLERANCE},
};
use crate::{error::Error, results::points::number};
use curves::Metric;
use fmu_import::{Description, Kind, Variable, units::Conversion};
use fmu_points::{task::Schedule, tell::one_line};
use result_document::format::significant;
use sampling::{
    design::Method,
    statistics::moments::{deviation, mean},
};

/// More lines nobody reads.
const MOST_LINES: usize = 60;
/// Of a table with many columns, so many parameters are shown all the same.
const FEWEST_PARAMETERS: usize = 5;
/// How many outputs become criteria where nothing is measured.
const CRITERIA: usize = 3;

/// A study to be written.
pub struct Study<'a> {
    pub fmu: &'a Description,
    /// The FMU's path, as seen from the study.
    pub path: PathBuf,
    pub schedule: Schedule,
    pub parameters: Vec<(&'a Variable, Shown<'a>)>,
    /// Start values of the user's.
    pub set: Vec<(&'a Variable, String)>,
    pub criteria: Criteria,
}

/// The lines of the criteria, and how many criteria these are.
pub struct Criteria {
    lines: Vec<String>,
    /// What drives the model as it was measured.
    inputs: Vec<String>,
    count: usize,
    /// Whether their values come from the model.
    own: bool,
}

/// In what unit people read a variable.
struct View<'a> {
    unit: Option<&'a str>,
    to_variable: Conversion,
}

impl<'a> View<'a> {
    fn new(fmu: &Description, variable: &'a Variable) -> Self {
        let unit = variable.display_unit();
        let way = unit.and_then(|unit| fmu.conversion(unit, variable).ok());
        Self { unit: unit.filter(|_| way.is_some()), to_variable: way.unwrap_or(Conversion::IDENTITY) }
    }

    fn value(&self, value: f64) -> f64 {
        let (zero, shown) = (self.to_variable.inverse().value(0.0), self.to_variable.inverse().value(value));
        // At an offset such as that of degF a zero is rounded.
        if shown.abs() < 1e-12 * zero.abs() { 0.0 } else { shown }
    }
}

/// Six digits are enough for a first guess.
fn rounded(value: f64) -> f64 {
    significant(value, 6).parse().unwrap_or(value)
}

/// A parameter's range in the unit in which people read it.
pub struct Shown<'a> {
    view: View<'a>,
    ends: [f64; 2],
}

impl<'a> Shown<'a> {
    /// 10 % to both sides of the start value, within the FMU's own limits. None of what is no number, has no start value
    /// or 0, or has no room.
    pub fn about_start(fmu: &Description, variable: &'a Variable) -> Option<Self> {
        match variable.kind {
            Kind::Real { start: Some(start), .. } => Self::about(fmu, variable, start),
            _ => None,
        }
    }

    /// The same about another value, in the variable's own unit.
    pub fn about(fmu: &Description, variable: &'a Variable, start: f64) -> Option<Self> {
        const PART: f64 = 0.1;
        let Kind::Real { min, max, .. } = variable.kind else {
            return None;
        };
        let view = View::new(fmu, variable);
        let middle = view.value(start);
        let half = PART * middle.abs();
        let limit = |limit: Option<f64>| limit.map(|limit| view.value(limit));
        let limits = match [limit(min), limit(max)] {
            // A unit may count the other way.
            [min, max] if view.to_variable.difference(1.0) < 0.0 => [max, min],
            limits => limits,
        };
        let low = rounded(middle - half).max(limits[0].unwrap_or(f64::NEG_INFINITY));
        let high = rounded(middle + half).min(limits[1].unwrap_or(f64::INFINITY));
        let is_range = low < high && low.is_finite() && high.is_finite();
        is_range.then_some(Self { view, ends: [low, high] })
    }

    fn line(&self, variable: &Variable) -> String {
        let [low, high] = self.ends.map(number);
        format!(
            "{} = {{ distribution = \"uniform\", min = {low}, max = {high}{} }}{}",
            quoted(&variable.name),
            unit_key(self.view.unit),
            about(variable)
        )
    }
}

impl Criteria {
    /// The first outputs that move, with what they do in a run of the model.
    pub fn of_model(signals: &[Signal], fmu: &Description, path: &Path) -> Result<Self, Error> {
        let mut moving: Vec<_> = signals.iter().filter(|signal| signal.moves()).collect();
        let stands = moving.is_empty();
        if stands {
            // An equation without time says something, too.
            moving = signals.iter().filter(|signal| signal.is_finite && signal.most != 0.0).collect();
        }
        if moving.is_empty() {
            let message = "none of its outputs is a finite number other than 0 in a run: set its inputs (--set NAME=VALUE), choose another \
                           end (--stop), or write a study that feeds its inputs";
            return Err(Error::content(path, message));
        }
        let mut lines = vec![
            "# No measured value yet: the nominal values come from a run of the model. Put the measured value there and remove"
                .to_owned(),
            "# `nominal-from`. Then add how far it may be from the true one, such as uncertainty = \"1 %\" (k = 2)."
                .to_owned(),
        ];
        let others: Vec<_> = moving.iter().skip(CRITERIA).map(|s| &*s.variable.name).collect();
        lines.extend(stands.then(|| "# No output moves in this run.".to_owned()));
        lines.extend(more(&others, "Further outputs"));
        for signal in moving.iter().take(CRITERIA) {
            lines.push(String::new());
            lines.extend(own(signal, fmu));
        }
        let count = moving.len().min(CRITERIA);
        Ok(Self { lines, inputs: Vec::new(), count, own: true })
    }

    /// The columns of a table, as curves where it has a column of the time.
    pub fn of_table(table: &Measured, path: &Path) -> Self {
        let tolerance = "# The tolerances are a guess: they say how far the model may be from the true values. Add the accuracy \
                         of the";
        let is_of_points = table.time.is_none() && !table.inputs.is_empty();
        let uncertainty = match table.time {
            _ if is_of_points => {
                "# measurement: uncertainty = \"1 %\" (k = 2). Each row is an operating point, a case of its own."
            }
            Some(_) => "# measurement beside each `file`: uncertainty = \"0.3 degC\" (k = 2).",
            None => {
                "# measurement: uncertainty = \"1 %\" (k = 2). Several rows are taken as repeats of one measurement."
            }
        };
        let mut lines = vec![tolerance.to_owned(), uncertainty.to_owned()];
        if is_of_points {
            lines.extend((0..table.columns[0].values.len()).flat_map(|row| operating_point(table, row)));
            return Self { lines, inputs: Vec::new(), count: table.columns.len(), own: false };
        }
        let inputs =
            table.time.iter().flat_map(|time| table.inputs.iter().map(move |column| input(column, time, path)));
        let inputs: Vec<String> = inputs.collect();
        for column in &table.columns {
            lines.push(String::new());
            lines.extend(match &table.time {
                Some(time) => curve(column, time, path),
                None => reading(column),
            });
        }
        Self { lines, inputs, count: table.columns.len(), own: false }
    }
}

/// Names of things that are left out.
fn more(names: &[&str], what: &str) -> Option<String> {
    const SHOWN: usize = 3;
    let shown: Vec<_> = names.iter().take(SHOWN).map(|name| one_line(name)).collect();
    let rest = if names.len() > SHOWN { ", ..." } else { "" };
    (!names.is_empty()).then(|| format!("# {what}: {}{rest}", shown.join(", ")))
}

fn head(variable: &Variable) -> [String; 2] {
    // Columns of points.csv have these names already.
    let taken = ["point", "verified", "accepted", "conformance", "status"].contains(&&*variable.name);
    let name = one_line(&variable.name) + if taken { "_" } else { "" };
    [format!("[criteria.{}]", quoted(&name)), format!("variable = {}{}", quoted(&variable.name), about(variable))]
}

/// A criterion whose nominal value comes from the model.
fn own(signal: &Signal, fmu: &Description) -> Vec<String> {
    let view = View::new(fmu, signal.variable);
    let (statistic, value) = signal.value();
    let nominal = rounded(view.value(value));
    let range = (view.value(signal.most) - view.value(signal.least)).abs();
    let mut lines = head(signal.variable).to_vec();
    lines.push(format!("statistic = \"{}\"", statistic.name()));
    lines.push(format!("nominal = {} # put the measured value here,", number(nominal)));
    lines.push("nominal-from = \"model\" # and remove this line".to_owned());
    lines.push(tolerance(nominal, range));
    lines.extend(view.unit.map(|unit| format!("unit = {}", quoted(unit))));
    lines
}

/// A part of the value; where that is next to nothing, of the range.
fn tolerance(nominal: f64, range: f64) -> String {
    if nominal.abs() < SMALL * range {
        format!("tolerance = {}", number(rounded(TOLERANCE * range)))
    } else {
        format!("tolerance = \"{} %\"", 100.0 * TOLERANCE)
    }
}

/// An input that follows a column.
fn input(column: &Column, time: &str, path: &Path) -> String {
    format!(
        "{} = {{ file = {}, time = {}, column = {}{}, extrapolate = \"hold\" }}",
        quoted(&column.variable.name),
        file(path),
        quoted(time),
        quoted(&column.header),
        unit_key(column.unit.as_deref())
    )
}

/// A row whose inputs are those of an operating point.
fn operating_point(table: &Measured, row: usize) -> Vec<String> {
    let value = |column: &Column| {
        let unit = column.unit.as_ref().filter(|unit| *unit != "1");
        let unit = unit.map_or_else(String::new, |unit| format!(" {unit}"));
        quoted(&format!("{}{unit}", number(column.values[row])))
    };
    let mut lines = vec![String::new(), "[[cases]]".to_owned(), format!("name = \"row {}\"", row + 1)];
    lines.extend(
        table.inputs.iter().map(|column| format!("fixed.{} = {}", quoted(&column.variable.name), value(column))),
    );
    for column in &table.columns {
        let (name, measured) = (quoted(&column.variable.name), column.values[row]);
        let tolerance = if measured == 0.0 { "0.1" } else { "\"5 %\"" };
        lines.push(format!(
            "criteria.{name} = {{ variable = {name}, nominal = {}, tolerance = {tolerance}{} }}",
            number(measured),
            unit_key(column.unit.as_deref())
        ));
    }
    lines
}

fn unit_key(unit: Option<&str>) -> String {
    unit.map_or_else(String::new, |unit| format!(", unit = {}", quoted(unit)))
}

fn curve(column: &Column, time: &str, path: &Path) -> Vec<String> {
    let unit = unit_key(column.unit.as_deref());
    let [head, variable] = head(column.variable);
    let metrics = Metric::ALL.iter().map(|metric| metric.name());
    let others: Vec<String> = metrics.filter(|name| name != "nrmse").collect();
    vec![
        head,
        variable,
        format!(
            "reference = {{ file = {}, time = {}, column = {}{unit} }}",
            file(path),
            quoted(time),
            quoted(&column.header)
        ),
        format!("metric = \"nrmse\" # of the range; or {}", others.join(", ")),
        "tolerance = \"5 %\"".to_owned(),
    ]
}

fn reading(column: &Column) -> Vec<String> {
    let (value, count) = (rounded(mean(&column.values)), column.values.len());
    let noise = if count > 1 { deviation(&column.values, 1) } else { 0.0 };
    let mut lines = head(column.variable).to_vec();
    lines.push(format!("nominal = {}", number(value)));
    if noise > 0.0 {
        let noise = number(rounded(noise));
        lines.push(format!("noise = {noise} # the standard deviation of one row"));
        lines.push(format!("repeats = {count}"));
    }
    lines.push(format!("tolerance = {}", if value == 0.0 { "0.1" } else { "\"5 %\"" }));
    let unit = column.unit.as_deref();
    lines.extend(unit.map(|unit| format!("unit = {}", quoted(unit))));
    lines
}

impl Study<'_> {
    /// The text.
    pub fn text(&self) -> String {
        let Schedule { start, stop, step, .. } = self.schedule;
        let fmu = self.fmu;
        let mut lines = vec![
            format!("title = {}", quoted(&fmu.model_name)),
            format!("fmu = {}", file(&self.path)),
            String::new(),
            "[simulation]".to_owned(),
        ];
        if start != Schedule::suggested(fmu).start {
            lines.push(format!("start = {} # s", number(start)));
        }
        lines.extend([
            format!("stop = {} # s", number(stop)),
            format!("step = {} # s", number(step)),
            String::new(),
            "[design]".to_owned(),
            format!("method = \"monte-carlo\" # or {}", Method::named(|method| method != Method::MonteCarlo)),
            "points = 64".to_owned(),
            "seed = 1".to_owned(),
            String::new(),
        ]);
        let room = MOST_LINES.saturating_sub(lines.len() + self.criteria.lines.len() + 4);
        let shown = room.max(FEWEST_PARAMETERS).min(self.parameters.len());
        lines.push("# Start values +-10 %, a guess: write what your parts' tolerances are.".to_owned());
        let others: Vec<&str> = self.parameters[shown..].iter().map(|(v, _)| &*v.name).collect();
        lines.extend(more(&others, &format!("{} further ones keep their start values", others.len())));
        lines.push("[parameters]".to_owned());
        lines.extend(self.parameters[..shown].iter().map(|(variable, range)| range.line(variable)));
        lines.push(String::new());
        if !self.set.is_empty() {
            lines.push("[fixed]".to_owned());
            lines.extend(
                self.set.iter().map(|(variable, setting)| format!("{} = {}", quoted(&variable.name), quoted(setting))),
            );
            lines.push(String::new());
        }
        if !self.criteria.inputs.is_empty() {
            lines.push("[inputs]".to_owned());
            lines.extend(self.criteria.inputs.iter().cloned());
            lines.push(String::new());
        }
        lines.extend(self.criteria.lines.iter().cloned());
        lines.join("\n") + "\n"
    }

    /// What to do with it.
    pub fn told(&self, path: &Path) -> String {
        let path = path.display();
        let next = if self.criteria.own {
            "no measured value yet: write yours in place of the nominal values, and remove `nominal-from`\n"
        } else {
            "the tolerances are a guess: write how far the model may be from the true values\n"
        };
        let plural = if self.criteria.count == 1 { "on" } else { "a" };
        format!("{path}: {} criteri{plural}; `orchestrator verify {path}` runs it\n{next}", self.criteria.count)
    }
}

/// The FMU's description of a variable, as a comment behind a line. A line end in it would end the comment.
fn about(variable: &Variable) -> String {
    const MOST: usize = 60;
    let Some(text) = variable.description.as_deref().filter(|text| !text.is_empty()) else {
        return String::new();
    };
    let text = one_line(text);
    match text.char_indices().nth(MOST) {
        Some((end, _)) => format!(" # {}...", &text[..end]),
        None => format!(" # {text}"),
    }
}

/// A path with slashes, which every system takes.
fn file(path: &Path) -> String {
    let text = path.display().to_string();
    quoted(&if cfg!(windows) { text.replace('\\', "/") } else { text })
}

/// A text as TOML writes it.
fn quoted(text: &str) -> String {
    let text = text.replace('\\', "\\\\").replace('"', "\\\"");
    format!("\"{}\"", one_line(&text))
}

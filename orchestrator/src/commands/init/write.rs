//! The text of a starting study: short, and complete.

use std::path::{Path, PathBuf};

use super::{
    measured::{Column, MeasuredTable},
    run::{SMALL, Signal, TOLERANCE},
};
use crate::{
    error::Error,
    results::{points::number, words::unit_behind},
};
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

/// The text of the criteria, and how many criteria these are.
pub struct Criteria {
    text: String,
    /// What drives the model as it was measured.
    inputs: String,
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
            "{} = {{ distribution = \"uniform\", min = {low}, max = {high}{} }}{}\n",
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
        let mut text = "# No measured value yet: the nominal values come from a run of the model. Put the measured value there and \
                        remove\n# `nominal-from`. Then add how far it may be from the true one, such as uncertainty = \"1 %\" (k = 2).\n"
            .to_owned();
        if stands {
            text += "# No output moves in this run.\n";
        }
        let others: Vec<_> = moving.iter().skip(CRITERIA).map(|s| &*s.variable.name).collect();
        text += &more(&others, "Further outputs");
        let count = moving.len().min(CRITERIA);
        text.extend(moving[..count].iter().map(|signal| own(signal, fmu)));
        Ok(Self { text, inputs: String::new(), count, own: true })
    }

    /// The columns of a table, as curves where it has a column of the time.
    pub fn of_table(table: &MeasuredTable, path: &Path) -> Self {
        let is_of_points = table.time.is_none() && !table.inputs.is_empty();
        let uncertainty = match table.time {
            _ if is_of_points => {
                "measurement: uncertainty = \"1 %\" (k = 2). Each row is an operating point, a case of its own."
            }
            Some(_) => "measurement beside each `file`: uncertainty = \"0.3 degC\" (k = 2).",
            None => "measurement: uncertainty = \"1 %\" (k = 2). Several rows are taken as repeats of one measurement.",
        };
        let mut text = format!(
            "# The tolerances are a guess: they say how far the model may be from the true values. Add the accuracy of the\n\
             # {uncertainty}\n"
        );
        let mut inputs = String::new();
        if is_of_points {
            text.extend((0..table.columns[0].values.len()).map(|row| operating_point(table, row)));
        } else if let Some(time) = &table.time {
            inputs.extend(table.inputs.iter().map(|column| input(column, time, path)));
            text.extend(table.columns.iter().map(|column| curve(column, time, path)));
        } else {
            text.extend(table.columns.iter().map(reading));
        }
        Self { text, inputs, count: table.columns.len(), own: false }
    }
}

/// Names of things that are left out.
fn more(names: &[&str], what: &str) -> String {
    const SHOWN: usize = 3;
    if names.is_empty() {
        return String::new();
    }
    let shown: Vec<_> = names.iter().take(SHOWN).map(|name| one_line(name)).collect();
    let rest = if names.len() > SHOWN { ", ..." } else { "" };
    format!("# {what}: {}{rest}\n", shown.join(", "))
}

fn head(variable: &Variable) -> String {
    // Columns of points.csv have these names already.
    let taken = ["point", "verified", "accepted", "conformance", "status"].contains(&&*variable.name);
    let name = one_line(&variable.name) + if taken { "_" } else { "" };
    format!("\n[criteria.{}]\nvariable = {}{}\n", quoted(&name), quoted(&variable.name), about(variable))
}

/// A criterion whose nominal value comes from the model.
fn own(signal: &Signal, fmu: &Description) -> String {
    let view = View::new(fmu, signal.variable);
    let (statistic, value) = signal.value();
    let nominal = rounded(view.value(value));
    let range = (view.value(signal.most) - view.value(signal.least)).abs();
    format!(
        "{}statistic = \"{}\"\nnominal = {} # put the measured value here,\nnominal-from = \"model\" # and remove this line\n{}\n{}",
        head(signal.variable),
        statistic.name(),
        number(nominal),
        tolerance(nominal, range),
        unit_line(view.unit)
    )
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
        "{} = {{ file = {}, time = {}, column = {}{}, extrapolate = \"hold\" }}\n",
        quoted(&column.variable.name),
        file(path),
        quoted(time),
        quoted(&column.header),
        unit_key(column.unit.as_deref())
    )
}

/// A row whose inputs are those of an operating point.
fn operating_point(table: &MeasuredTable, row: usize) -> String {
    let mut text = format!("\n[[cases]]\nname = \"row {}\"\n", row + 1);
    text.extend(table.inputs.iter().map(|column| {
        let value = format!("{}{}", number(column.values[row]), unit_behind(column.unit.as_deref()));
        format!("fixed.{} = {}\n", quoted(&column.variable.name), quoted(&value))
    }));
    text.extend(table.columns.iter().map(|column| {
        let (name, measured) = (quoted(&column.variable.name), column.values[row]);
        format!(
            "criteria.{name} = {{ variable = {name}, nominal = {}, tolerance = {}{} }}\n",
            number(measured),
            part(measured),
            unit_key(column.unit.as_deref())
        )
    }));
    text
}

/// The tolerance of a measured value, a guess.
fn part(measured: f64) -> &'static str {
    if measured == 0.0 { "0.1" } else { "\"5 %\"" }
}

fn unit_key(unit: Option<&str>) -> String {
    unit.map_or_else(String::new, |unit| format!(", unit = {}", quoted(unit)))
}

fn unit_line(unit: Option<&str>) -> String {
    unit.map_or_else(String::new, |unit| format!("unit = {}\n", quoted(unit)))
}

fn curve(column: &Column, time: &str, path: &Path) -> String {
    let metrics = Metric::ALL.iter().map(|metric| metric.name());
    let others: Vec<String> = metrics.filter(|name| name != "nrmse").collect();
    format!(
        "{}reference = {{ file = {}, time = {}, column = {}{} }}\nmetric = \"nrmse\" # of the range; or {}\ntolerance = \"5 %\"\n",
        head(column.variable),
        file(path),
        quoted(time),
        quoted(&column.header),
        unit_key(column.unit.as_deref()),
        others.join(", ")
    )
}

fn reading(column: &Column) -> String {
    let (value, count) = (rounded(mean(&column.values)), column.values.len());
    let noise = if count > 1 { deviation(&column.values, 1) } else { 0.0 };
    let mut text = head(column.variable) + &format!("nominal = {}\n", number(value));
    if noise > 0.0 {
        let noise = number(rounded(noise));
        text += &format!("noise = {noise} # the standard deviation of one row\nrepeats = {count}\n");
    }
    text + &format!("tolerance = {}\n{}", part(value), unit_line(column.unit.as_deref()))
}

impl Study<'_> {
    /// The text.
    pub fn text(&self) -> String {
        let Schedule { start, stop, step, .. } = self.schedule;
        let fmu = self.fmu;
        let mut text = format!("title = {}\nfmu = {}\n\n[simulation]\n", quoted(&fmu.model_name), file(&self.path));
        if start != Schedule::suggested(fmu).start {
            text += &format!("start = {} # s\n", number(start));
        }
        text += &format!(
            "stop = {} # s\nstep = {} # s\n\n[design]\nmethod = \"monte-carlo\" # or {}\npoints = 64\nseed = 1\n\n",
            number(stop),
            number(step),
            Method::named(|method| method != Method::MonteCarlo)
        );
        let Criteria { text: criteria, inputs, .. } = &self.criteria;
        let room = MOST_LINES.saturating_sub(text.lines().count() + criteria.lines().count() + 4);
        let (shown, others) = self.parameters.split_at(room.max(FEWEST_PARAMETERS).min(self.parameters.len()));
        let others: Vec<&str> = others.iter().map(|(v, _)| &*v.name).collect();
        text += "# Start values +-10 %, a guess: write what your parts' tolerances are.\n";
        text += &more(&others, &format!("{} further ones keep their start values", others.len()));
        text += "[parameters]\n";
        text.extend(shown.iter().map(|(variable, range)| range.line(variable)));
        text += "\n";
        if !self.set.is_empty() {
            text += "[fixed]\n";
            text.extend(
                self.set.iter().map(|(variable, set)| format!("{} = {}\n", quoted(&variable.name), quoted(set))),
            );
            text += "\n";
        }
        if !inputs.is_empty() {
            text += &format!("[inputs]\n{inputs}\n");
        }
        text + criteria
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

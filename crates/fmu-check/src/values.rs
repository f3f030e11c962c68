//! Numbers that cannot be right: of the experiment, and of single variables (FMI 2.0.5, sections 2.2.3, 2.2.5, 2.2.7).

use crate::{
    definitions::unit_missing,
    document::{Document, NAME, Variable},
    hit::Hit,
};
use fmu_import::Kind;

/// The encoding in the XML declaration, where there is a declaration that names one.
fn declared_encoding<'a>(document: &Document<'a>) -> Option<&'a str> {
    let value = document
        .root
        .document()
        .input_text()
        .strip_prefix("<?xml")?
        .split("?>")
        .next()?
        .split_once("encoding")?
        .1
        .trim_start()
        .strip_prefix('=')?
        .trim_start();
    let quote = value.chars().next()?;
    value[1..].split(quote).next()
}

/// An encoding that FMI does not know.
pub fn other_encoding(document: &Document) -> Vec<Hit> {
    let other = declared_encoding(document).filter(|name| !name.eq_ignore_ascii_case("utf-8"));
    let text = |name| format!("the encoding is {name}: save the file as UTF-8");
    Vec::from_iter(other.map(|name| Hit::plain(text(name))))
}

/// A file that does not name its encoding.
pub fn no_encoding(document: &Document) -> Vec<Hit> {
    let text = "the first line does not name the encoding: begin with <?xml version=\"1.0\" encoding=\"UTF-8\"?>";
    let missing = declared_encoding(document).is_none();
    Vec::from_iter(missing.then(|| Hit::plain(text)))
}

pub fn version(document: &Document) -> Vec<Hit> {
    let version = &document.read.fmi_version;
    let text = format!("fmiVersion is {version}; FMI 2.0 is needed, which calls itself 2.0");
    Vec::from_iter((version != "2.0").then(|| Hit::of(NAME, text)))
}

/// A finding about the experiment.
fn experiment(text: Option<String>) -> Vec<Hit> {
    Vec::from_iter(text.map(|text| Hit::of(NAME, format!("DefaultExperiment: {text}"))))
}

/// A number of the experiment that must be greater than 0.
pub fn positive(name: &str, number: Option<f64>) -> Vec<Hit> {
    let wrong = number.filter(|number| !(*number > 0.0 && number.is_finite()));
    experiment(wrong.map(|number| format!("{name} is {number}; it must be greater than 0")))
}

pub fn stop(document: &Document) -> Vec<Hit> {
    let times = document.read.default_experiment;
    let start = times.start.unwrap_or(0.0);
    let wrong = times.stop.filter(|stop| *stop <= start || !(stop - start).is_finite());
    experiment(wrong.map(|stop| format!("stopTime is {stop}; it must be later than startTime, {start}")))
}

pub fn long_step(document: &Document) -> Vec<Hit> {
    let times = document.read.default_experiment;
    let length = times.stop.map(|stop| stop - times.start.unwrap_or(0.0));
    let wrong = times.step.zip(length).filter(|(step, length)| *length > 0.0 && step > length && step.is_finite());
    experiment(wrong.map(|(step, length)| {
        format!("stepSize is {step}, but the experiment lasts {length} s only: shorten the step")
    }))
}

/// A number of the variable as it was read, with what its type gives.
fn numbers(scalar: Variable) -> Option<[Option<f64>; 3]> {
    let kind = &scalar.read()?.kind;
    let (min, max) = kind.range();
    match kind {
        Kind::Real { start, .. } => Some([*start, min, max]),
        Kind::Integer { start, .. } => Some([start.map(|start| start as f64), min, max]),
        Kind::Enumeration { start, .. } => {
            let bound = |name| scalar.typed.attribute(name)?.trim().parse().ok();
            Some([start.map(|start| start as f64), bound("min"), bound("max")])
        }
        Kind::Boolean { .. } | Kind::String { .. } | Kind::Clock(_) => None,
    }
}

pub fn range(scalar: Variable) -> Option<String> {
    let [_, min, max] = numbers(scalar)?;
    let (min, max) = min.zip(max).filter(|(min, max)| min > max)?;
    Some(format!("min {min} is greater than max {max}: exchange or correct them"))
}

pub fn start(scalar: Variable) -> Option<String> {
    let [start, min, max] = numbers(scalar)?;
    let start = start?;
    let (bound, what) = match (min, max) {
        (Some(min), _) if start < min => (min, "less than min"),
        (_, Some(max)) if start > max => (max, "greater than max"),
        _ => return None,
    };
    Some(format!("start {start} is {what} {bound}: correct one of them"))
}

pub fn infinite(scalar: Variable) -> Option<String> {
    let [start, ..] = numbers(scalar)?;
    let start = start.filter(|start| !start.is_finite())?;
    Some(format!("start is {start}: it must be a finite number"))
}

pub fn nominal(scalar: Variable) -> Option<String> {
    let Kind::Real { nominal, .. } = &scalar.read()?.kind else { return None };
    let nominal = nominal.filter(|nominal| nominal.is_nan() || *nominal <= 0.0)?;
    Some(format!("nominal is {nominal}: it must be greater than 0, as importers divide by it"))
}

/// A variable may narrow the range of its type, not widen it.
pub fn beyond_type(scalar: Variable) -> Option<String> {
    let declared = scalar.declared()?;
    let number = |text: &str| text.trim().parse::<f64>().ok();
    let both = |name| Some((number(scalar.typed.attribute(name)?)?, number(declared.attribute(name)?)?));
    let (name, (number, of_type)) = [
        ("min", both("min").filter(|(number, other)| number < other)),
        ("max", both("max").filter(|(number, other)| number > other)),
    ]
    .into_iter()
    .find_map(|(name, wrong)| Some((name, wrong?)))?;
    Some(format!("{name} {number} goes beyond its type's {name} of {of_type}: narrow it"))
}

pub fn item(scalar: Variable) -> Option<String> {
    let Kind::Enumeration { start, items } = &scalar.read()?.kind else { return None };
    let start = (*start)?;
    let none = !items.is_empty() && items.iter().all(|(_, value)| *value != start);
    none.then(|| format!("start {start} is none of its type's items: choose one of them"))
}

pub fn unit(scalar: Variable) -> Option<String> {
    scalar.document.undefined_unit(scalar.effective("unit")?)
}

/// A display unit says nothing without a unit.
pub fn display_unit_alone(scalar: Variable) -> Option<String> {
    let shown = scalar.effective("displayUnit")?;
    scalar.effective("unit").is_none().then(|| unit_missing(shown))
}

/// An undefined display unit is ignored, as the standard says.
pub fn display_unit(scalar: Variable) -> Option<String> {
    let shown = scalar.effective("displayUnit")?;
    let unit = scalar.effective("unit")?;
    let defined = scalar.document.read.units.0.get(unit)?;
    let known = shown == unit || defined.display.iter().any(|other| other.name == shown);
    (!known).then(|| format!("displayUnit \"{shown}\" is not defined for unit \"{unit}\": add it there"))
}

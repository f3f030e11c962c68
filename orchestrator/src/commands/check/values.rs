//! Numbers that cannot be right: of the experiment, and of single variables (FMI 2.0.5, sections 2.2.3, 2.2.5, 2.2.7).

use super::document::{Document, NAME, Scalar};
use super::hit::Hit;
use fmu_import::description::About;
use fmu_import::description::Kind;

/// The reader's remarks of one kind.
fn remarks(document: &Document<'_>, about: About) -> Vec<Hit> {
    let remarks = document
        .read
        .remarks
        .iter()
        .filter(|remark| remark.about == about);
    let hit = |remark: &fmu_import::Remark| Hit {
        line: Some(remark.line),
        ..Hit::of(NAME, remark.text.clone())
    };
    remarks.map(hit).collect()
}

pub(super) fn encoding(document: &Document<'_>) -> Vec<Hit> {
    remarks(document, About::Encoding)
}

/// The encoding in the XML declaration, where there is a declaration that names one.
fn declared_encoding<'a>(document: &Document<'a>) -> Option<&'a str> {
    let text = document.root.document().input_text();
    let declaration = text.strip_prefix("<?xml")?.split("?>").next()?;
    let value = declaration.split_once("encoding")?.1.trim_start();
    let value = value.strip_prefix('=')?.trim_start();
    let quote = value.chars().next()?;
    value[1..].split(quote).next()
}

/// An encoding that FMI does not know.
pub(super) fn other_encoding(document: &Document<'_>) -> Vec<Hit> {
    let other = declared_encoding(document).filter(|name| !name.eq_ignore_ascii_case("utf-8"));
    let hit = |name| Hit::plain(format!("the encoding is {name}: save the file as UTF-8"));
    other.map(hit).into_iter().collect()
}

/// A file that does not name its encoding.
pub(super) fn no_encoding(document: &Document<'_>) -> Vec<Hit> {
    let text = "the first line does not name the encoding: begin with <?xml version=\"1.0\" encoding=\"UTF-8\"?>";
    let missing = declared_encoding(document).is_none();
    missing
        .then(|| Hit::plain(text.to_owned()))
        .into_iter()
        .collect()
}

pub(super) fn unreadable(document: &Document<'_>) -> Vec<Hit> {
    remarks(document, About::Value)
}

pub(super) fn not_usable(document: &Document<'_>) -> Vec<Hit> {
    remarks(document, About::Limit)
}

pub(super) fn left_out(document: &Document<'_>) -> Vec<Hit> {
    remarks(document, About::Variable)
}

pub(super) fn names_twice(document: &Document<'_>) -> Vec<Hit> {
    remarks(document, About::Name)
}

pub(super) fn version(document: &Document<'_>) -> Vec<Hit> {
    let version = &document.read.fmi_version;
    let text = format!("fmiVersion is {version}; FMI 2.0 is needed, which calls itself 2.0");
    if version == "2.0" {
        Vec::new()
    } else {
        vec![Hit::of(NAME, text)]
    }
}

/// A finding about the experiment.
fn experiment(text: Option<String>) -> Vec<Hit> {
    let hit = |text| Hit::of(NAME, format!("DefaultExperiment: {text}"));
    text.map(hit).into_iter().collect()
}

pub(super) fn step(document: &Document<'_>) -> Vec<Hit> {
    let step = document.read.default_experiment.step;
    let wrong = step.filter(|step| !(*step > 0.0 && step.is_finite()));
    experiment(wrong.map(|step| format!("stepSize is {step}; it must be greater than 0")))
}

pub(super) fn tolerance(document: &Document<'_>) -> Vec<Hit> {
    let tolerance = document.read.default_experiment.tolerance;
    let wrong = tolerance.filter(|tolerance| !(*tolerance > 0.0 && tolerance.is_finite()));
    experiment(
        wrong.map(|tolerance| format!("tolerance is {tolerance}; it must be greater than 0")),
    )
}

pub(super) fn stop(document: &Document<'_>) -> Vec<Hit> {
    let times = document.read.default_experiment;
    let start = times.start.unwrap_or(0.0);
    let wrong = times
        .stop
        .filter(|stop| *stop <= start || !(stop - start).is_finite());
    experiment(
        wrong.map(|stop| format!("stopTime is {stop}; it must be later than startTime, {start}")),
    )
}

pub(super) fn long_step(document: &Document<'_>) -> Vec<Hit> {
    let times = document.read.default_experiment;
    let length = times
        .stop
        .map(|stop| stop - times.start.unwrap_or(0.0))
        .filter(|length| *length > 0.0);
    let wrong = times
        .step
        .zip(length)
        .filter(|(step, length)| step > length && step.is_finite());
    experiment(wrong.map(|(step, length)| {
        format!("stepSize is {step}, but the experiment lasts {length} s only: shorten the step")
    }))
}

/// A number of the variable as it was read, with what its type gives.
fn numbers(scalar: &Scalar<'_>, document: &Document<'_>) -> Option<[Option<f64>; 3]> {
    let kind = &document.read.variables.get(scalar.name)?.kind;
    let (min, max) = kind.range();
    match kind {
        Kind::Real { start, .. } => Some([*start, min, max]),
        Kind::Integer { start, .. } => Some([start.map(|start| start as f64), min, max]),
        Kind::Enumeration { start, .. } => {
            let bound = |name| scalar.typed.attribute(name)?.trim().parse().ok();
            Some([start.map(|start| start as f64), bound("min"), bound("max")])
        }
        Kind::Boolean { .. } | Kind::String { .. } => None,
    }
}

pub(super) fn range(scalar: &Scalar<'_>, document: &Document<'_>) -> Option<String> {
    let [_, min, max] = numbers(scalar, document)?;
    let (min, max) = min.zip(max).filter(|(min, max)| min > max)?;
    Some(format!(
        "min {min} is greater than max {max}: exchange or correct them"
    ))
}

pub(super) fn start(scalar: &Scalar<'_>, document: &Document<'_>) -> Option<String> {
    let [start, min, max] = numbers(scalar, document)?;
    let start = start?;
    let (bound, what) = match (min, max) {
        (Some(min), _) if start < min => (min, "less than min"),
        (_, Some(max)) if start > max => (max, "greater than max"),
        _ => return None,
    };
    Some(format!(
        "start {start} is {what} {bound}: correct one of them"
    ))
}

pub(super) fn infinite(scalar: &Scalar<'_>, document: &Document<'_>) -> Option<String> {
    let [start, ..] = numbers(scalar, document)?;
    let start = start.filter(|start| !start.is_finite())?;
    Some(format!("start is {start}: it must be a finite number"))
}

pub(super) fn nominal(scalar: &Scalar<'_>, document: &Document<'_>) -> Option<String> {
    let Kind::Real { nominal, .. } = &document.read.variables.get(scalar.name)?.kind else {
        return None;
    };
    let nominal = nominal.filter(|nominal| nominal.is_nan() || *nominal <= 0.0)?;
    Some(format!(
        "nominal is {nominal}: it must be greater than 0, as importers divide by it"
    ))
}

/// A variable may narrow the range of its type, not widen it.
pub(super) fn beyond_type(scalar: &Scalar<'_>, document: &Document<'_>) -> Option<String> {
    let declared = document.declared(scalar)?;
    let number = |text: &str| text.trim().parse::<f64>().ok();
    let both = |name| {
        Some((
            number(scalar.typed.attribute(name)?)?,
            number(declared.attribute(name)?)?,
        ))
    };
    let (name, (own, of_type)) = [
        ("min", both("min").filter(|(own, other)| own < other)),
        ("max", both("max").filter(|(own, other)| own > other)),
    ]
    .into_iter()
    .find_map(|(name, wrong)| Some((name, wrong?)))?;
    Some(format!(
        "{name} {own} goes beyond its type's {name} of {of_type}: narrow it"
    ))
}

pub(super) fn item(scalar: &Scalar<'_>, document: &Document<'_>) -> Option<String> {
    let Kind::Enumeration { start, items } = &document.read.variables.get(scalar.name)?.kind else {
        return None;
    };
    let start = (*start)?;
    let none = !items.is_empty() && items.iter().all(|(_, value)| *value != start);
    none.then(|| format!("start {start} is none of its type's items: choose one of them"))
}

pub(super) fn unit(scalar: &Scalar<'_>, document: &Document<'_>) -> Option<String> {
    let unit = document.effective(scalar, "unit")?;
    let defined = document.read.units.get(unit).is_some();
    (!defined).then(|| format!("unit \"{unit}\" is not defined: add it to UnitDefinitions"))
}

/// A display unit says nothing without a unit.
pub(super) fn display_unit_alone(scalar: &Scalar<'_>, document: &Document<'_>) -> Option<String> {
    let shown = document.effective(scalar, "displayUnit")?;
    let alone = document.effective(scalar, "unit").is_none();
    alone.then(|| format!("displayUnit \"{shown}\" without a unit: add the unit"))
}

/// An undefined display unit is ignored, as the standard says.
pub(super) fn display_unit(scalar: &Scalar<'_>, document: &Document<'_>) -> Option<String> {
    let shown = document.effective(scalar, "displayUnit")?;
    let unit = document.effective(scalar, "unit")?;
    let defined = document.read.units.get(unit)?;
    let known = shown == unit || defined.display.iter().any(|other| other.name == shown);
    (!known).then(|| {
        format!("displayUnit \"{shown}\" is not defined for unit \"{unit}\": add it there")
    })
}

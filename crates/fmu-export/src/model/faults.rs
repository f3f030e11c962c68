//! A check of what a model declares: for a model's tests, and before it is packaged.

use std::collections::HashMap;

use super::{DisplayUnit, Enumeration, Kind, Model, Quantity, Role, Unit, Variable, elements, indicators, offered};

/// The mistakes in a model's variable table that no description of it shows, a sentence each; none for a sound model.
///
/// What a description shows (names, ranges, start and nominal values), a check of the FMU finds.
///
/// ```
/// # use fmu_export::model::{Experiment, Fault, Info, Log, Model, Variable, faults};
/// # #[derive(Clone, Default, serde::Serialize, serde::Deserialize)]
/// # struct Tank;
/// # impl Model for Tank {
/// #     const INFO: Info = fmu_export::info!();
/// #     fn variables() -> &'static [Variable<Self>] { &[] }
/// #     fn initialise(&mut self, _: &Experiment<'_>, _: &mut dyn Log) -> Result<(), Fault> { Ok(()) }
/// #     fn advance(&mut self, _: f64, _: f64, _: &mut dyn Log) -> Result<(), Fault> { Ok(()) }
/// # }
/// assert_eq!(faults::<Tank>(), Vec::<String>::new());
/// ```
pub fn faults<M: Model>() -> Vec<String> {
    let mut faults = Vec::new();
    check_listing::<M>(&mut faults);
    check_dependencies::<M>(&mut faults);
    check_definitions::<M>(&mut faults);
    check_left_out::<M>(&mut faults);
    check_events::<M>(&mut faults);
    check_arrays::<M>(&mut faults);
    for variable in M::variables() {
        check_role(variable, &mut |text| faults.push(format!("{}: {text}", variable.name)));
    }
    let restored = M::default().save().and_then(|bytes| M::default().restore(&bytes));
    if let Err(fault) = restored {
        faults.push(format!("a state that is saved and restored: {fault}"));
    }
    faults
}

fn check_listing<M: Model>(faults: &mut Vec<String>) {
    let mut listing = M::listing();
    listing.sort_unstable();
    if !listing.into_iter().eq(0..M::variables().len()) {
        faults.push("the listing does not name every variable once".to_owned());
    }
}

fn check_dependencies<M: Model>(faults: &mut Vec<String>) {
    for variable in M::variables() {
        for input in variable.depends_on {
            if !M::variables().iter().any(|other| other.name == *input && other.role == Role::Input) {
                let name = variable.name;
                faults.push(format!("{name}: it depends on {input:?}, which is not an input"));
            }
        }
    }
}

fn check_left_out<M: Model>(faults: &mut Vec<String>) {
    for left_out in without::<M>() {
        if M::variables().iter().all(|variable| variable.name != *left_out) {
            faults.push(format!("{left_out}: Model Exchange leaves it out, but there is no such variable"));
        }
    }
}

fn check_events<M: Model>(faults: &mut Vec<String>) {
    let known = |name: &str| M::variables().iter().find(|variable| variable.name == name);
    let is_clock = |variable: &Variable<M>| matches!(variable.kind, Kind::Clock { .. });
    for variable in M::variables() {
        let name = variable.name;
        if is_clock(variable) && (M::EVENTS.is_none() || variable.role != Role::Output) {
            faults.push(format!("{name}: a clock must be an output, and the model have events"));
        }
        let Some(clock) = variable.clock else { continue };
        let computed = matches!(variable.role, Role::Output | Role::Local);
        if !computed || !known(clock).is_some_and(is_clock) {
            faults.push(format!("{name}: the model must compute what ticks with a clock, and {clock:?} must be one"));
        }
    }
    if M::EVENTS.is_some() && M::INNER_STEP.is_some() {
        faults.push("a model with events has no INNER_STEP".to_owned());
    }
    for name in indicators::<M>() {
        if !known(name).is_some_and(|variable| matches!(variable.kind, Kind::Real(_))) || without::<M>().contains(name)
        {
            faults.push(format!("{name}: an indicator is a real variable, also in Model Exchange"));
        }
    }
}

fn check_arrays<M: Model>(faults: &mut Vec<String>) {
    for (place, head) in M::variables().iter().enumerate() {
        let (array, elements) = (head.array_name(), elements::<M>(place));
        // FMI 3.0 has these once for the whole array.
        let shared = |variable: &Variable<M>| match &variable.kind {
            Kind::Real(real) => (real.unit.name, real.display, [real.min, real.max, real.nominal]),
            Kind::Integer { min, max, .. } => ("", None, [min.map(f64::from), max.map(f64::from), None]),
            Kind::Enumeration { of, .. } => (of.name, None, [None; 3]),
            _ => ("", None, [None; 3]),
        };
        if head.elements != 1
            && (elements.len() < 2
                || !elements.iter().zip(1..).all(|(variable, number)| {
                    variable.name == format!("{array}[{number}]")
                        && (number == 1 || variable.elements == 1)
                        && (variable.role, variable.clock) == (head.role, head.clock)
                        && variable.type_name() == head.type_name()
                        && shared(variable) == shared(head)
                        && !matches!(variable.kind, Kind::Clock { .. })
                }))
        {
            let (name, count) = (head.name, head.elements);
            faults.push(format!("{name}: the {count} elements of an array stand in the table as name[1], name[2], ..., with the same role, type, unit, range and clock, and are no clocks"));
        }
        for list in [without::<M>(), indicators::<M>()] {
            let names = || elements.iter().map(|element| element.name);
            let mut parts = list.windows(elements.len().max(1));
            let is_whole = parts.any(|part| part.iter().copied().eq(names()));
            if names().any(|name| list.contains(&name)) && !is_whole {
                faults.push(format!(
                    "{array}: an array's elements are left out or are indicators all in their order, or none"
                ));
            }
        }
    }
}

/// The names of what Model Exchange leaves out.
fn without<M: Model>() -> &'static [&'static str] {
    offered::<M>().map_or(&[], |exchange| (exchange.without)())
}

/// The description defines a unit, a display unit and an enumeration once for each name, so that two of the same name
/// must be alike.
fn check_definitions<M: Model>(faults: &mut Vec<String>) {
    let mut units: HashMap<&str, &Unit> = HashMap::new();
    let mut displays: HashMap<(&str, &str), &DisplayUnit> = HashMap::new();
    let mut types: HashMap<&str, &Enumeration> = HashMap::new();
    for variable in M::variables() {
        match variable.kind {
            Kind::Real(Quantity { unit, .. }) => {
                if units.entry(unit.name).or_insert(unit).base != unit.base {
                    faults.push(format!("there are two units {}", unit.name));
                }
                for display in unit.display {
                    let place = (unit.name, display.name);
                    if *displays.entry(place).or_insert(display) != display {
                        faults.push(format!("{} has two display units {}", unit.name, display.name));
                    }
                }
            }
            Kind::Enumeration { of, .. } => {
                if *types.entry(of.name).or_insert(of) != of {
                    faults.push(format!("there are two enumerations {}", of.name));
                }
            }
            _ => {}
        }
    }
}

fn check_role<M>(variable: &Variable<M>, fault: &mut impl FnMut(String)) {
    let set = match &variable.kind {
        Kind::Real(real) => real.access.set.is_some(),
        Kind::Integer { access, .. } | Kind::Enumeration { access, .. } => access.set.is_some(),
        Kind::Boolean { access } => access.set.is_some(),
        Kind::String { access } => access.set.is_some(),
        Kind::Clock { .. } => false,
    };
    match (variable.role, set) {
        (Role::Output | Role::Local, true) => {
            fault("the model computes it, so that it cannot be set".to_owned());
        }
        (Role::Input | Role::Parameter | Role::TunableParameter, false) => {
            fault("hosts set it, so that it must be possible to set it".to_owned());
        }
        _ => {}
    }
    if variable.role != Role::Output && !variable.depends_on.is_empty() {
        fault("only outputs have dependencies".to_owned());
    }
    if let Kind::Real(real) = &variable.kind {
        if real.slope.is_some() && variable.role != Role::Input {
            fault("only inputs have slopes".to_owned());
        }
        if real.derivative.is_some() && variable.role != Role::Output {
            fault("only outputs have derivatives".to_owned());
        }
    }
}

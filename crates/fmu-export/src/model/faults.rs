//! A check of what a model declares: for a model's tests, and before it is packaged.

use std::{collections::HashMap, fmt::Debug};

use super::{
    Access, DisplayUnit, Enumeration, Info, Kind, Model, Quantity, Role, Unit, Variable, elements, indicators, inside,
    named, offered,
};

/// The mistakes in a model's [`Info`] and variable table, a sentence each; none for a sound model.
///
/// ```
/// # use fmu_export::model::{Experiment, Fault, Info, Log, Model, Variable, faults};
/// # #[derive(Clone, Default, serde::Serialize, serde::Deserialize)]
/// # struct Tank;
/// # impl Model for Tank {
/// #     const INFO: Info = fmu_export::info!();
/// #     fn variables() -> &'static [Variable<Self>] { &[] }
/// #     fn initialise(&mut self, _: &Experiment, _: &mut dyn Log) -> Result<(), Fault> { Ok(()) }
/// #     fn advance(&mut self, _: f64, _: f64, _: &mut dyn Log) -> Result<(), Fault> { Ok(()) }
/// # }
/// assert_eq!(faults::<Tank>(), Vec::<String>::new());
/// ```
pub fn faults<M: Model>() -> Vec<String> {
    let mut faults = Vec::new();
    check_info(&M::INFO, &mut faults);
    check_listing::<M>(&mut faults);
    check_names::<M>(&mut faults);
    check_definitions::<M>(&mut faults);
    check_states::<M>(&mut faults);
    check_events::<M>(&mut faults);
    check_arrays::<M>(&mut faults);
    let start = M::default();
    for variable in M::variables() {
        let mut fault = |text: &str| faults.push(format!("{}: {text}", variable.name));
        check_role(variable, &mut fault);
        check_kind(variable, &start, &mut fault);
    }
    let restored = start.save().and_then(|bytes| M::default().restore(&bytes));
    if let Err(fault) = restored {
        faults.push(format!("a state that is saved and restored: {fault}"));
    }
    faults
}

fn check_info(info: &Info, faults: &mut Vec<String>) {
    let mut characters = info.identifier.chars();
    let valid = characters.next().is_some_and(|c| c.is_ascii_alphabetic() || c == '_')
        && characters.all(|c| c.is_ascii_alphanumeric() || c == '_');
    if !valid {
        let identifier = info.identifier;
        faults.push(format!("the identifier {identifier:?} is not a C identifier"));
    }
    for (name, value) in [
        ("default_step", info.default_step),
        ("default_stop", info.default_stop),
        ("default_tolerance", info.default_tolerance),
    ] {
        if !(value > 0.0 && value.is_finite()) {
            faults.push(format!("{name} = {value}: it must be a number above 0"));
        }
    }
}

fn check_listing<M: Model>(faults: &mut Vec<String>) {
    let mut listing = M::listing();
    listing.sort_unstable();
    if !listing.into_iter().eq(0..M::variables().len()) {
        faults.push("the listing does not name every variable once".to_owned());
    }
}

fn check_names<M: Model>(faults: &mut Vec<String>) {
    let mut roles = HashMap::new();
    for variable in M::variables() {
        if variable.name.is_empty() {
            faults.push("a variable has no name".to_owned());
        } else if roles.insert(variable.name, variable.role).is_some() {
            faults.push(format!("{}: two variables have this name", variable.name));
        }
    }
    for variable in M::variables() {
        for input in variable.depends_on {
            if roles.get(input) != Some(&Role::Input) {
                let name = variable.name;
                faults.push(format!("{name}: it depends on {input:?}, which is not an input"));
            }
        }
    }
}

fn check_states<M: Model>(faults: &mut Vec<String>) {
    let Some(exchange) = &M::EXCHANGE else { return };
    for state in (exchange.states)() {
        let name = state.name;
        if named::<M>(name).is_some() {
            faults.push(format!("{name}: a state and a variable have this name"));
        }
        if !(state.nominal > 0.0 && state.nominal.is_finite()) {
            faults.push(format!("{name}: its nominal value must be above 0"));
        }
    }
    for left_out in (exchange.without)() {
        if named::<M>(left_out).is_none() {
            faults.push(format!("{left_out}: Model Exchange leaves it out, but there is no such variable"));
        }
    }
}

fn check_events<M: Model>(faults: &mut Vec<String>) {
    let is_clock = |variable: &Variable<M>| matches!(variable.kind, Kind::Clock { .. });
    for variable in M::variables() {
        let name = variable.name;
        if is_clock(variable) && (M::EVENTS.is_none() || variable.role != Role::Output) {
            faults.push(format!("{name}: a clock must be an output, and the model have events"));
        }
        let Some(clock) = variable.clock else { continue };
        let computed = matches!(variable.role, Role::Output | Role::Local);
        if !computed || !named::<M>(clock).is_some_and(is_clock) {
            faults.push(format!("{name}: the model must compute what ticks with a clock, and {clock:?} must be one"));
        }
    }
    if M::EVENTS.is_some() && M::INNER_STEP.is_some() {
        faults.push("a model with events has no INNER_STEP".to_owned());
    }
    for name in indicators::<M>() {
        if !named::<M>(name).is_some_and(|variable| matches!(variable.kind, Kind::Real(_)))
            || without::<M>().contains(name)
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
        if array != head.name && named::<M>(array).is_some() {
            faults.push(format!("{array}: an array and a variable have this name"));
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
                if named::<M>(of.name).is_some() {
                    faults.push(format!("a variable and an enumeration are called {}", of.name));
                }
            }
            _ => {}
        }
    }
}

fn check_role<M>(variable: &Variable<M>, fault: &mut impl FnMut(&str)) {
    let set = match &variable.kind {
        Kind::Real(real) => real.access.set.is_some(),
        Kind::Integer { access, .. } | Kind::Enumeration { access, .. } => access.set.is_some(),
        Kind::Boolean { access } => access.set.is_some(),
        Kind::String { access } => access.set.is_some(),
        Kind::Clock { .. } => false,
    };
    match (variable.role, set) {
        (Role::Output | Role::Local, true) => {
            fault("the model computes it, so that it cannot be set");
        }
        (Role::Input | Role::Parameter | Role::TunableParameter, false) => {
            fault("hosts set it, so that it must be possible to set it");
        }
        _ => {}
    }
    if variable.role != Role::Output && !variable.depends_on.is_empty() {
        fault("only outputs have dependencies");
    }
}

fn check_kind<M>(variable: &Variable<M>, start: &M, fault: &mut impl FnMut(&str)) {
    match &variable.kind {
        Kind::Real(real) => {
            let (access, unit) = (&real.access, real.unit);
            check_range(access, start, real.min, real.max, fault);
            let numbers = [real.min, real.max, real.nominal, Some((access.get)(start))];
            let settable = access.set.is_some();
            if settable && numbers.into_iter().flatten().any(|x| !x.is_finite()) {
                fault("its start value, range and nominal value must be finite");
            }
            if let Some(display) = real.display
                && unit.display.iter().all(|known| known.name != display)
            {
                fault(&format!("{display} is not a display unit of {}", unit.name));
            }
            if (real.nominal).is_some_and(|nominal| nominal.is_nan() || nominal <= 0.0) {
                fault("its nominal value must be above 0");
            }
            if real.slope.is_some() && variable.role != Role::Input {
                fault("only inputs have slopes");
            }
            if real.derivative.is_some() && variable.role != Role::Output {
                fault("only outputs have derivatives");
            }
        }
        Kind::Integer { access, min, max } => check_range(access, start, *min, *max, fault),
        Kind::Enumeration { access, of } => {
            let value = (access.get)(start);
            if of.items.iter().all(|item| item.value != value) {
                fault(&format!("its start value {value} is no item of {}", of.name));
            }
        }
        Kind::Boolean { .. } | Kind::String { .. } | Kind::Clock { .. } => {}
    }
}

fn check_range<M, T: PartialOrd + Copy + Debug>(
    access: &Access<M, T, T>,
    start: &M,
    min: Option<T>,
    max: Option<T>,
    fault: &mut impl FnMut(&str),
) {
    if let (Some(min), Some(max)) = (min, max)
        && min > max
    {
        fault(&format!("its range from {min:?} to {max:?} is empty"));
    }
    let value = (access.get)(start);
    if access.set.is_some() && !inside(value, min, max) {
        fault(&format!("its start value {value:?} is out of its range"));
    }
}

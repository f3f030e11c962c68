//! Reading and writing of variables and their derivatives: what both versions of the standard have in common.

use std::ffi::{CStr, CString};
use std::fmt::Debug;
use std::ptr::{null, null_mut};

use fmu_export::fmi3::types::{Component, Status, Text, ValueReference};
use fmu_export::model::{Kind, Model, Quantity, Role, Variable};
use plain_bearing_stand::stand::Stand;

use crate::host::Host;
use crate::states::bytes_of;

/// Whether an act is meant for a variable.
pub type Fits = fn(&Variable<Stand>) -> bool;

/// Up to four references of variables that fit; others now and then.
pub fn references(host: &mut Host, fits: Fits) -> Vec<ValueReference> {
    let table = Stand::variables();
    let random = &mut host.random;
    let n = random.one(&[0, 1, 1, 1, 2, 3, 4]);
    let mut references = Vec::new();
    while references.len() < n {
        let any = random.below(table.len() + 2);
        if random.once_in(200) {
            // Also states and their rates, which have references of their own.
            let far = [1_000_000_000, 1_000_000_007, 1_100_000_001, u32::MAX];
            let far = random.one(&far);
            references.push(random.one(&[any as u32, far, random_like(any)]));
        } else if table.get(any).is_some_and(fits) {
            references.push(any as u32);
        }
    }
    references
}

fn random_like(any: usize) -> u32 {
    (any as u32).wrapping_mul(0x9e37_79b9)
}

/// Pointers and count as they are passed: right, NULL, or a count that cannot be.
pub fn passed<A, B>(host: &mut Host, first: *const A, second: B, null: B, n: usize) -> (*const A, B, usize) {
    match host.random.below(200) {
        0 => (std::ptr::null(), second, n),
        1 => (first, null, n),
        2 => (std::ptr::null(), null, 0),
        3 if n > 0 => (first, second, usize::MAX),
        _ => (first, second, n),
    }
}

/// Reads variables that fit; `holds` is true of all values that the FMU may give, and false of `before`.
pub fn get<T: Copy + Debug>(
    host: &mut Host,
    component: Component,
    name: &'static str,
    (fits, before, holds): (Fits, T, fn(&T) -> bool),
    function: impl Fn(Component, *const ValueReference, usize, *mut T) -> Status,
) {
    let references = references(host, fits);
    let mut values = vec![before; references.len()];
    let place = values.as_mut_ptr();
    let (from, into, n) = passed(host, references.as_ptr(), place, null_mut(), values.len());
    let status = host.call(name, component, |c| function(c, from, n, into));
    if status == Status::Ok && n > 0 && !host.forged.contains(&component) {
        let all = values.iter().all(holds);
        assert!(all, "{name} {references:?} {values:?}");
    }
}

/// Expectations on real values.
pub const REALS: (Fits, f64, fn(&f64) -> bool) =
    (|v| matches!(v.kind, Kind::Real(_)), f64::NAN, |value| value.is_finite());

/// Expectations on texts.
pub const TEXTS: (Fits, Text, fn(&Text) -> bool) = (
    |v| matches!(v.kind, Kind::String { .. }),
    null(),
    |value| {
        // SAFETY: the FMU's own text, which ends with NUL and lives until the next call.
        unsafe { CStr::from_ptr(*value).to_str().is_ok() }
    },
);

/// Whether a variable is boolean.
pub fn boolean(variable: &Variable<Stand>) -> bool {
    matches!(variable.kind, Kind::Boolean { .. })
}

/// Calls a setter; when it refuses, nothing may have changed.
pub fn set<T>(
    host: &mut Host,
    component: Component,
    name: &'static str,
    (references, values): (&[ValueReference], &[T]),
    function: impl Fn(Component, *const ValueReference, usize, *const T) -> Status,
) {
    let (from, value) = (references.as_ptr(), values.as_ptr());
    let (from, value, n) = passed(host, from, value, null(), values.len());
    watched(host, component, name, |c| function(c, from, n, value));
}

/// Makes a call; now and then it looks whether anything has changed although it was refused.
pub fn watched(
    host: &mut Host,
    component: Component,
    name: &'static str,
    function: impl FnOnce(Component) -> Status,
) -> Status {
    let watched = host.random.once_in(10) && host.instances.contains(&component);
    let before = watched.then(|| bytes_of(host, component));
    let status = host.call(name, component, function);
    if let Some(before) = before
        && status != Status::Ok
    {
        let same = before == bytes_of(host, component);
        assert!(same, "{name} was refused, but changed something");
    }
    status
}

/// Whether the host may set a variable at some time.
pub fn settable(variable: &Variable<Stand>) -> bool {
    !matches!(variable.role, Role::Output | Role::Local)
}

/// Sets real variables.
pub fn set_reals(
    host: &mut Host,
    component: Component,
    name: &'static str,
    function: impl Fn(Component, *const ValueReference, usize, *const f64) -> Status,
) {
    let references = references(host, |v| settable(v) && matches!(v.kind, Kind::Real(_)));
    let value = |host: &mut Host, reference: &_| real_for(host, *reference);
    let values: Vec<_> = references.iter().map(|r| value(host, r)).collect();
    set(host, component, name, (&references, &values), function);
}

/// A value near the start value, from anywhere in the variable's range, or from nowhere in it.
fn real_for(host: &mut Host, reference: ValueReference) -> f64 {
    let random = &mut host.random;
    let Some(Variable { kind: Kind::Real(Quantity { access, min: Some(min), max: Some(max), .. }), .. }) =
        Stand::variables().get(reference as usize)
    else {
        return random.hostile();
    };
    match random.below(40) {
        0 | 1 => random.hostile(),
        2 => min + random.unit() * (max - min),
        3 => random.one(&[*min, *max]),
        4 if *min > 0.0 => random.magnitude(*min, *max),
        4 => random.one(&[*min, *max]) * random.magnitude(1e-9, 1.0),
        _ => (access.get)(&Stand::default()) * random.magnitude(0.5, 2.0),
    }
}

/// An integer for a variable: near its least value, or any.
pub fn integer_for(host: &mut Host, reference: ValueReference) -> i32 {
    let odd = host.random.one(&[0, 1, 4, -1, i32::MIN]);
    match Stand::variables().get(reference as usize) {
        Some(Variable { kind: Kind::Integer { min: Some(min), .. }, .. }) => min.wrapping_add(odd),
        _ => host.random.integer(),
    }
}

/// Sets texts.
pub fn set_texts(
    host: &mut Host,
    component: Component,
    name: &'static str,
    function: impl Fn(Component, *const ValueReference, usize, *const Text) -> Status,
) {
    let references = references(host, |v| settable(v) && matches!(v.kind, Kind::String { .. }));
    let texts =
        [c"", c"sae-15w-40.csv", c"sae-5w-30.csv", c"none.csv", c"../../../", c"%s%n%x", c"\xff\xfe", c"r\xc3\xa9s"];
    let long = CString::new(vec![b'x'; 5000]).unwrap_or_default();
    let value = |host: &mut Host| match host.random.below(20) {
        0 => null(),
        1 => long.as_ptr(),
        2..10 => c"".as_ptr(),
        _ => host.random.one(&texts).as_ptr(),
    };
    let values: Vec<_> = references.iter().map(|_| value(host)).collect();
    set(host, component, name, (&references, &values), function);
}

/// Asks for the rates of outputs.
pub fn get_rates(
    host: &mut Host,
    component: Component,
    name: &'static str,
    function: impl Fn(Component, *const ValueReference, usize, *const i32, *mut f64) -> Status,
) {
    let orders: Vec<_> = (0..4).map(|_| host.random.one(&[1, 1, 1, 1, 0])).collect();
    let outputs: Fits = |v| v.role == Role::Output;
    let (_, before, holds) = REALS;
    let function = |c, from, n, into| function(c, from, n, orders.as_ptr(), into);
    get(host, component, name, (outputs, before, holds), function);
}

/// Components of a direction or a seed, as many as references.
pub fn direction(host: &mut Host, references: &[ValueReference]) -> Vec<f64> {
    let component = |host: &mut Host| {
        if host.random.once_in(20) { host.random.hostile() } else { host.random.unit() }
    };
    references.iter().map(|_| component(host)).collect()
}

/// Asks for a directional derivative, or, with the unknowns as what is seeded, for an adjoint one. The function takes what is
/// seeded with its number and the seed, then what is asked for with its number and the places.
pub fn derivative(
    host: &mut Host,
    component: Component,
    name: &'static str,
    (seeded, asked): (Fits, Fits),
    function: impl Fn(Component, (&[ValueReference], &[f64]), (*const ValueReference, usize, *mut f64)) -> Status,
) {
    let seeded = references(host, seeded);
    let seed = direction(host, &seeded);
    let (_, before, holds) = REALS;
    let function = |c, from, n, into| function(c, (&seeded, &seed), (from, n, into));
    get(host, component, name, (asked, before, holds), function);
}

/// Whether a variable is a real output.
pub fn real_output(variable: &Variable<Stand>) -> bool {
    variable.role == Role::Output && matches!(variable.kind, Kind::Real(_))
}

/// Whether a variable is an input.
pub fn input(variable: &Variable<Stand>) -> bool {
    variable.role == Role::Input
}

/// Categories for the choice of messages, right and wrong.
pub fn categories(host: &mut Host) -> ([Text; 2], usize) {
    let names = [c"logAll", c"logStatusError", c"logEvents", c"logNothing", c"\xff"];
    let one = |host: &mut Host| host.random.one(&names).as_ptr();
    ([one(host), one(host)], host.random.below(3))
}

/// The tolerance, start and stop of an experiment.
pub fn experiment(host: &mut Host) -> [f64; 3] {
    let random = &mut host.random;
    if random.once_in(20) {
        return [(); 3].map(|()| random.hostile());
    }
    let start = random.one(&[0.0, 0.0, -5.0, 1e3]);
    [random.magnitude(1e-6, 1e-3), start, 2e3]
}

/// Where a step begins and how long it is, at a time.
pub fn step(host: &mut Host, time: f64) -> [f64; 2] {
    let random = &mut host.random;
    let odd = [f64::NAN, f64::INFINITY, -1.0, 0.0, 5e-324, 1e-300, 1e-30];
    match random.below(20) {
        0 => [random.hostile(), 1e-3],
        1 => [time, random.one(&odd)],
        2 => [time, random.one(&[0.1, 1.0 / 60.0, 1e-2])],
        3 if random.once_in(20) => [time, random.one(&[1.0, 10.0, 1e9])],
        _ => [time, random.magnitude(1e-7, 1e-2)],
    }
}

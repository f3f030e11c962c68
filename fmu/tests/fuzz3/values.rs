//! Reading and writing of variables and their derivatives.

use std::ffi::CString;
use std::ptr::{null, null_mut};

use fmu_export::fmi3::types::*;
use fmu_export::model::{Kind, Model, Role, Variable};
use plain_bearing_stand::fmi3_functions::*;
use plain_bearing_stand::stand::Stand;

use crate::host::Host;

/// Up to four references of variables that fit; others now and then.
fn references(host: &mut Host, fits: fn(&Variable<Stand>) -> bool) -> Vec<ValueReference> {
    let table = Stand::variables();
    let random = &mut host.random;
    let n = random.one(&[0, 1, 1, 1, 2, 3, 4]);
    let mut found = Vec::new();
    while found.len() < n {
        let any = random.below(table.len() + 2);
        if random.once_in(200) {
            found.push(random.one(&[any as u32, u32::MAX, random_like(any)]));
        } else if table.get(any).is_some_and(fits) {
            found.push(any as u32);
        }
    }
    found
}

fn random_like(any: usize) -> u32 {
    (any as u32).wrapping_mul(0x9e37_79b9)
}

/// Pointers and count as they are passed: right, NULL, or a count that cannot be.
fn passed<A, B>(
    host: &mut Host,
    first: *const A,
    second: B,
    null: B,
    n: usize,
) -> (*const A, B, usize) {
    match host.random.below(200) {
        0 => (std::ptr::null(), second, n),
        1 => (first, null, n),
        2 => (std::ptr::null(), null, 0),
        3 if n > 0 => (first, second, usize::MAX),
        _ => (first, second, n),
    }
}

macro_rules! getter {
    ($name:ident, $function:ident, $kinds:pat, $zero:expr, $holds:expr) => {
        pub fn $name(host: &mut Host, component: Component) {
            let references = references(host, |v| matches!(v.kind, $kinds));
            let mut values = vec![$zero; references.len()];
            let place = values.as_mut_ptr();
            let (from, into, n) =
                passed(host, references.as_ptr(), place, null_mut(), values.len());
            let n_values = if host.random.once_in(100) { n ^ 1 } else { n };
            // SAFETY: right, NULL, a count that no memory has, or counts that contradict each other.
            let status = host.call(stringify!($function), component, |c| unsafe {
                $function(c, from, n, into, n_values)
            });
            assert!(status != Status::Ok || n == n_values);
            if status == Status::Ok && n > 0 && !host.forged.contains(&component) {
                assert!(
                    values.iter().all($holds),
                    "{} {references:?} {values:?}",
                    stringify!($function)
                );
            }
        }
    };
}

getter!(
    get_float64,
    fmi3GetFloat64,
    Kind::Real { .. },
    f64::NAN,
    |value| value.is_finite()
);
getter!(
    get_int32,
    fmi3GetInt32,
    Kind::Integer { .. },
    i32::MIN,
    |value| *value != i32::MIN
);
getter!(
    get_int64,
    fmi3GetInt64,
    Kind::Enumeration { .. },
    i64::MIN,
    |value| *value != i64::MIN
);
getter!(
    get_boolean,
    fmi3GetBoolean,
    Kind::Boolean { .. },
    9,
    |value| [0, 1].contains(value)
);
// SAFETY: texts that the FMU gives end with NUL, and live until the next call.
getter!(
    get_string,
    fmi3GetString,
    Kind::String { .. },
    null(),
    |value| {
        // SAFETY: the FMU's own text, which ends with NUL and lives until the next call.
        unsafe { std::ffi::CStr::from_ptr(*value).to_str().is_ok() }
    }
);

type Set<T> =
    unsafe extern "C" fn(Component, *const ValueReference, usize, *const T, usize) -> Status;

/// Calls a setter with what it is given; when it refuses, nothing may have changed.
fn set<T>(
    host: &mut Host,
    component: Component,
    name: &'static str,
    function: Set<T>,
    references: &[ValueReference],
    values: &[T],
) {
    let (from, value, n) = passed(
        host,
        references.as_ptr(),
        values.as_ptr(),
        null(),
        values.len(),
    );
    let watched = host.random.once_in(10) && host.instances.contains(&component);
    let before = watched.then(|| host.bytes_of(component));
    // SAFETY: right, NULL, or a count that no memory has.
    let status = host.call(name, component, |c| unsafe {
        function(c, from, n, value, n)
    });
    if let Some(before) = before
        && status != Status::Ok
    {
        assert!(
            before == host.bytes_of(component),
            "{name} of {references:?} was refused, but changed something"
        );
    }
}

fn settable(variable: &Variable<Stand>) -> bool {
    !matches!(variable.role, Role::Output | Role::Local)
}

pub fn set_float64(host: &mut Host, component: Component) {
    let references = references(host, |v| settable(v) && matches!(v.kind, Kind::Real { .. }));
    let values = references
        .iter()
        .map(|r| real_for(host, *r))
        .collect::<Vec<_>>();
    set(
        host,
        component,
        "fmi3SetFloat64",
        fmi3SetFloat64,
        &references,
        &values,
    );
}

/// A value near the start value, from anywhere in the variable's range, or from nowhere in it.
fn real_for(host: &mut Host, reference: ValueReference) -> f64 {
    let random = &mut host.random;
    let Some(Variable {
        kind:
            Kind::Real {
                access,
                min: Some(min),
                max: Some(max),
                ..
            },
        ..
    }) = Stand::variables().get(reference as usize)
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

pub fn set_int32(host: &mut Host, component: Component) {
    let references = references(host, |v| {
        settable(v) && matches!(v.kind, Kind::Integer { .. })
    });
    let value = |host: &mut Host, reference: &ValueReference| {
        let odd = host.random.one(&[0, 1, 4, -1, i32::MIN]);
        match Stand::variables().get(*reference as usize) {
            Some(Variable {
                kind: Kind::Integer { min: Some(min), .. },
                ..
            }) => min.wrapping_add(odd),
            _ => host.random.integer(),
        }
    };
    let values: Vec<_> = references.iter().map(|r| value(host, r)).collect();
    let name = "fmi3SetInt32";
    set(host, component, name, fmi3SetInt32, &references, &values);
}

pub fn set_int64(host: &mut Host, component: Component) {
    let references = references(host, |v| {
        settable(v) && matches!(v.kind, Kind::Enumeration { .. })
    });
    let value = |host: &mut Host| {
        let far = [i64::MIN, i64::MAX, 1 << 32, (1 << 32) + 1];
        let near = host.random.integer().into();
        if host.random.once_in(10) {
            host.random.one(&far)
        } else {
            near
        }
    };
    let values: Vec<_> = references.iter().map(|_| value(host)).collect();
    let name = "fmi3SetInt64";
    set(host, component, name, fmi3SetInt64, &references, &values);
}

pub fn set_boolean(host: &mut Host, component: Component) {
    let references = references(host, |v| {
        settable(v) && matches!(v.kind, Kind::Boolean { .. })
    });
    let value = |host: &mut Host| host.random.bits() as u8 % 3;
    let values: Vec<_> = references.iter().map(|_| value(host)).collect();
    let name = "fmi3SetBoolean";
    set(host, component, name, fmi3SetBoolean, &references, &values);
}

pub fn set_string(host: &mut Host, component: Component) {
    let references = references(host, |v| {
        settable(v) && matches!(v.kind, Kind::String { .. })
    });
    let texts = [
        c"",
        c"sae-15w-40.csv",
        c"sae-5w-30.csv",
        c"none.csv",
        c"../../../",
        c"%s%n%x",
        c"\xff\xfe",
        c"r\xc3\xa9s",
    ];
    let long = CString::new(vec![b'x'; 5000]).unwrap_or_default();
    let values = references
        .iter()
        .map(|_| match host.random.below(20) {
            0 => null(),
            1 => long.as_ptr(),
            2..10 => c"".as_ptr(),
            _ => host.random.one(&texts).as_ptr(),
        })
        .collect::<Vec<_>>();
    set(
        host,
        component,
        "fmi3SetString",
        fmi3SetString,
        &references,
        &values,
    );
}

pub fn get_rates(host: &mut Host, component: Component) {
    let references = references(host, |v| v.role == Role::Output);
    let orders = references
        .iter()
        .map(|_| host.random.one(&[1, 1, 1, 1, 0]))
        .collect::<Vec<_>>();
    let mut values = vec![f64::NAN; references.len()];
    let place = values.as_mut_ptr();
    let (from, into, n) = passed(host, references.as_ptr(), place, null_mut(), values.len());
    // SAFETY: as for the getters.
    let status = host.call("fmi3GetOutputDerivatives", component, |c| unsafe {
        fmi3GetOutputDerivatives(c, from, n, orders.as_ptr(), into, n)
    });
    let asked = status == Status::Ok && n > 0 && !host.forged.contains(&component);
    assert!(!asked || values.iter().all(|value| value.is_finite()));
}

/// Components of a direction, as many as references.
fn direction(host: &mut Host, references: &[ValueReference]) -> Vec<f64> {
    let component = |host: &mut Host| {
        if host.random.once_in(20) {
            host.random.hostile()
        } else {
            host.random.unit()
        }
    };
    references.iter().map(|_| component(host)).collect()
}

fn real_output(variable: &Variable<Stand>) -> bool {
    variable.role == Role::Output && matches!(variable.kind, Kind::Real { .. })
}

pub fn directional(host: &mut Host, component: Component) {
    let unknowns = references(host, real_output);
    let knowns = references(host, |v| v.role == Role::Input);
    let seed = direction(host, &knowns);
    let mut values = vec![f64::NAN; unknowns.len()];
    let place = values.as_mut_ptr();
    let (from, into, n) = passed(host, unknowns.as_ptr(), place, null_mut(), values.len());
    let (known, n_known) = (knowns.as_ptr(), knowns.len());
    // SAFETY: as for the getters.
    let status = host.call("fmi3GetDirectionalDerivative", component, |c| unsafe {
        fmi3GetDirectionalDerivative(c, from, n, known, n_known, seed.as_ptr(), n_known, into, n)
    });
    assert!(status != Status::Ok || n == 0 || values.iter().all(|value| value.is_finite()));
}

pub fn adjoint(host: &mut Host, component: Component) {
    let unknowns = references(host, real_output);
    let knowns = references(host, |v| v.role == Role::Input);
    let seed = direction(host, &unknowns);
    let mut values = vec![f64::NAN; knowns.len()];
    let place = values.as_mut_ptr();
    let (from, into, n) = passed(host, knowns.as_ptr(), place, null_mut(), values.len());
    let (unknown, n_unknown) = (unknowns.as_ptr(), unknowns.len());
    // SAFETY: as for the getters.
    let status = host.call("fmi3GetAdjointDerivative", component, |c| unsafe {
        fmi3GetAdjointDerivative(
            c,
            unknown,
            n_unknown,
            from,
            n,
            seed.as_ptr(),
            n_unknown,
            into,
            n,
        )
    });
    assert!(status != Status::Ok || n == 0 || values.iter().all(|value| value.is_finite()));
}

//! Reading and writing of variables and their derivatives.

use std::ffi::CString;
use std::ptr::{null, null_mut};

use fmu_export::fmi2::types::*;
use fmu_export::model::{Kind, Model, Role, Variable};
use plain_bearing_stand::c_functions::*;
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
            // SAFETY: right, NULL, or a count that no memory has.
            let status = host.call(stringify!($function), component, |c| unsafe {
                $function(c, from, n, into)
            });
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
    get_real,
    fmi2GetReal,
    Kind::Real { .. },
    f64::NAN,
    |value| value.is_finite()
);
getter!(
    get_integer,
    fmi2GetInteger,
    Kind::Integer { .. } | Kind::Enumeration { .. },
    i32::MIN,
    |value| *value != i32::MIN
);
getter!(
    get_boolean,
    fmi2GetBoolean,
    Kind::Boolean { .. },
    i32::MIN,
    |value| [0, 1].contains(value)
);
// SAFETY: texts that the FMU gives end with NUL, and live until the next call.
getter!(
    get_string,
    fmi2GetString,
    Kind::String { .. },
    null(),
    |value| {
        // SAFETY: the FMU's own text, which ends with NUL and lives until the next call.
        unsafe { std::ffi::CStr::from_ptr(*value).to_str().is_ok() }
    }
);

/// Calls a setter with what it is given; when it refuses, nothing may have changed.
fn set<T>(
    host: &mut Host,
    component: Component,
    name: &'static str,
    function: unsafe extern "C" fn(Component, *const ValueReference, usize, *const T) -> Status,
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
    let status = host.call(name, component, |c| unsafe { function(c, from, n, value) });
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

pub fn set_real(host: &mut Host, component: Component) {
    let references = references(host, |v| settable(v) && matches!(v.kind, Kind::Real { .. }));
    let values = references
        .iter()
        .map(|r| real_for(host, *r))
        .collect::<Vec<_>>();
    set(
        host,
        component,
        "fmi2SetReal",
        fmi2SetReal,
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

pub fn set_integer(host: &mut Host, component: Component) {
    let references = references(host, |v| {
        settable(v) && matches!(v.kind, Kind::Integer { .. } | Kind::Enumeration { .. })
    });
    let values = references
        .iter()
        .map(
            |reference| match Stand::variables().get(*reference as usize) {
                Some(Variable {
                    kind: Kind::Integer { min: Some(min), .. },
                    ..
                }) => min + host.random.one(&[0, 1, 4, -1, i32::MIN]),
                _ => host.random.integer(),
            },
        )
        .collect::<Vec<_>>();
    set(
        host,
        component,
        "fmi2SetInteger",
        fmi2SetInteger,
        &references,
        &values,
    );
}

pub fn set_boolean(host: &mut Host, component: Component) {
    let references = references(host, |v| {
        settable(v) && matches!(v.kind, Kind::Boolean { .. })
    });
    let values = references
        .iter()
        .map(|_| host.random.integer())
        .collect::<Vec<_>>();
    set(
        host,
        component,
        "fmi2SetBoolean",
        fmi2SetBoolean,
        &references,
        &values,
    );
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
        "fmi2SetString",
        fmi2SetString,
        &references,
        &values,
    );
}

pub fn set_slopes(host: &mut Host, component: Component) {
    let references = references(host, |v| v.role == Role::Input);
    let n = references.len();
    let orders = (0..n)
        .map(|_| host.random.one(&[1, 1, 1, 1, 1, 0, 2]))
        .collect::<Vec<_>>();
    let values = (0..n)
        .map(|_| {
            if host.random.once_in(20) {
                host.random.hostile()
            } else {
                host.random.unit()
            }
        })
        .collect::<Vec<_>>();
    let (from, value, n) = passed(host, references.as_ptr(), values.as_ptr(), null(), n);
    // SAFETY: as for `set`.
    host.call("fmi2SetRealInputDerivatives", component, |c| unsafe {
        fmi2SetRealInputDerivatives(c, from, n, orders.as_ptr(), value)
    });
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
    let status = host.call("fmi2GetRealOutputDerivatives", component, |c| unsafe {
        fmi2GetRealOutputDerivatives(c, from, n, orders.as_ptr(), into)
    });
    let asked = status == Status::Ok && n > 0 && !host.forged.contains(&component);
    assert!(!asked || values.iter().all(|value| value.is_finite()));
}

pub fn directional(host: &mut Host, component: Component) {
    let unknowns = references(host, |v| {
        v.role == Role::Output && matches!(v.kind, Kind::Real { .. })
    });
    let knowns = references(host, |v| v.role == Role::Input);
    let direction = knowns
        .iter()
        .map(|_| {
            if host.random.once_in(20) {
                host.random.hostile()
            } else {
                host.random.unit()
            }
        })
        .collect::<Vec<_>>();
    let mut values = vec![f64::NAN; unknowns.len()];
    let (from, into, n) = passed(
        host,
        unknowns.as_ptr(),
        values.as_mut_ptr(),
        null_mut(),
        values.len(),
    );
    // SAFETY: as for the getters.
    let status = host.call("fmi2GetDirectionalDerivative", component, |c| unsafe {
        fmi2GetDirectionalDerivative(
            c,
            from,
            n,
            knowns.as_ptr(),
            knowns.len(),
            direction.as_ptr(),
            into,
        )
    });
    assert!(status != Status::Ok || n == 0 || values.iter().all(|value| value.is_finite()));
}

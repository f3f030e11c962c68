//! Functions for what the stand does not offer: whatever they are given, they end with `fmi3Error` and touch nothing.

use fmu_export::fmi3::types::*;
use plain_bearing_stand::fmi3_functions::*;

use crate::host::Host;

/// Calls one of them, and asserts that it was refused.
macro_rules! refused {
    ($host:ident, $component:ident: $($function:ident($($argument:expr),*);)*) => {{
        let all: &[(&'static str, &dyn Fn(Component) -> Status)] = &[
            $((stringify!($function), &|c| {
                // SAFETY: the pointers are ours, or dangle and are not followed.
                unsafe { $function(c, $($argument),*) }
            })),*
        ];
        let (name, function) = all[$host.random.below(all.len())];
        let status = $host.call(name, $component, function);
        assert_eq!(status, Status::Error, "{name}");
    }};
}

/// Calls one of these functions.
pub fn act(host: &mut Host, component: Component) {
    let r = std::ptr::without_provenance::<ValueReference>(4);
    let real = std::ptr::without_provenance_mut::<f64>(8);
    let (size, long) = (std::ptr::without_provenance_mut::<usize>(8), std::ptr::without_provenance_mut::<u64>(8));
    let (flag, kind) = (std::ptr::without_provenance_mut::<u8>(1), std::ptr::without_provenance_mut::<i32>(4));
    refused! { host, component:
        fmi3EnterStepMode();
        fmi3EvaluateDiscreteStates();
        fmi3EnterConfigurationMode();
        fmi3ExitConfigurationMode();
        fmi3GetNumberOfVariableDependencies(3, size);
        fmi3GetVariableDependencies(3, size, r.cast_mut(), size, kind, 1);
        fmi3GetIntervalDecimal(r, 1, real, kind);
        fmi3GetIntervalFraction(r, 1, long, long, kind);
        fmi3GetShiftDecimal(r, 1, real);
        fmi3GetShiftFraction(r, 1, long, long);
        fmi3SetIntervalDecimal(r, 1, real);
        fmi3SetIntervalFraction(r, 1, long, long);
        fmi3SetShiftDecimal(r, 1, real);
        fmi3SetShiftFraction(r, 1, long, long);
        fmi3ActivateModelPartition(0, 1.0);
        fmi3GetFloat32(&2, 1, real.cast(), 1);
        fmi3GetInt8(&2, 1, flag.cast(), 1);
        fmi3GetUInt8(&2, 1, flag, 1);
        fmi3GetInt16(&2, 1, real.cast(), 1);
        fmi3GetUInt16(&2, 1, real.cast(), 1);
        fmi3GetUInt32(&2, 1, real.cast(), 1);
        fmi3GetUInt64(&2, 1, long, 1);
        fmi3GetBinary(&2, 1, size, real.cast(), 1);
        fmi3GetClock(&2, 1, flag);
        fmi3SetFloat32(&2, 1, real.cast(), 1);
        fmi3SetInt8(&2, 1, flag.cast(), 1);
        fmi3SetUInt8(&2, 1, flag, 1);
        fmi3SetInt16(&2, 1, real.cast(), 1);
        fmi3SetUInt16(&2, 1, real.cast(), 1);
        fmi3SetUInt32(&2, 1, real.cast(), 1);
        fmi3SetUInt64(&2, 1, long, 1);
        fmi3SetBinary(&2, 1, size, real.cast(), 1);
        fmi3SetClock(&2, 1, flag);
    }
}

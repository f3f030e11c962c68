//! A simulation from its start to its end, and the phases between.

use std::ptr::{null, null_mut};

use fmu_export::fmi2::calls;
use lag::Lag;

use crate::answer;
use crate::host::{Discard, Error, Fatal, Host, Ok, guid};

#[test]
fn a_whole_run_meets_the_exact_solution() {
    let host = Host::started();
    assert_eq!(host.set("input", 3.0), Ok);
    for i in 0..60 {
        assert_eq!(host.step(f64::from(i) / 60.0, 1.0 / 60.0), Ok, "step {i}");
    }
    assert!((host.get("output") - answer(3.0, 1.0)).abs() < 1e-13);
    assert_eq!(host.get_integer("steps"), 60);
    assert_eq!(host.get_string("report").to_str().unwrap(), "lag is at 1 s");
    assert_eq!(host.terminate(), Ok);
}

#[test]
fn instantiation_is_refused_with_a_reason() {
    for (name, guid, kind, reason) in [
        (c"", guid().as_c_str(), 1, "`instanceName` = \"\": it must not be empty"),
        (c"a", c"{1}", 1, "does not belong to this binary"),
        (c"a", guid().as_c_str(), 7, "Model Exchange (0) or Co-Simulation (1)"),
        (c"a", guid().as_c_str(), 0, "does not belong to this binary"),
    ] {
        let mut host = Host::with(name, guid, kind, c"");
        assert!(host.component.is_null());
        assert!(host.said(reason), "{reason}");
    }
    let mut host = Host::with(c"a", &guid(), 1, c"http://localhost/resources");
    assert!(!host.component.is_null());
    assert!(host.said("is not a local folder"));
}

#[test]
fn names_in_another_encoding_are_taken() {
    let mut host = Host::with(c"l\xe4g", &guid(), 1, c"/tmp/r\xe9s");
    assert!(!host.component.is_null());
    assert!(host.said("is not a local folder"));
}

#[test]
fn the_state_machine_is_the_standards() {
    let mut host = Host::new();
    assert_eq!(host.try_get("output"), Err(Error), "nothing is computed yet");
    assert!(host.said("fmi2GetReal: this function must not be called before the initialization"));
    assert_eq!([host.step(0.0, 0.1), host.exit(), host.terminate()], [Error; 3]);
    assert_eq!([host.set("input", 1.0), host.set("timeConstant", 0.25)], [Ok; 2]);
    assert_eq!([host.setup(None), host.enter()], [Ok; 2]);
    assert_eq!([host.setup(None), host.enter(), host.step(0.0, 0.1)], [Error; 3]);
    assert_eq!(host.set("initialState", 7.0), Ok);
    assert_eq!(host.get("output"), 7.0, "the initialization follows what is set within it");
    assert_eq!(host.exit(), Ok);
    assert_eq!(host.set("initialState", 8.0), Error, "a fixed parameter");
    assert_eq!([host.set("gain", 3.0), host.set("input", 1.0), host.step(0.0, 0.1)], [Ok; 3]);
    // SAFETY: the component is alive.
    assert_eq!(unsafe { calls::fmi2CancelStep::<Lag>(host.component) }, Error);
    assert_eq!(host.terminate(), Ok);
    assert_eq!([host.terminate(), host.step(0.1, 0.1), host.set("input", 0.0)], [Error; 3]);
    assert!(host.try_get("output").is_ok());
    assert_eq!([host.reset(), host.enter(), host.exit()], [Ok; 3]);
    assert_eq!(host.get("output"), 1.0, "start values again");
}

#[test]
fn steps_past_the_stop_time_are_refused() {
    let mut host = Host::new();
    assert_eq!([host.setup(Some(1.0)), host.enter(), host.exit()], [Ok; 3]);
    let mut time = 0.0;
    for _ in 0..10 {
        assert_eq!(host.step(time, 0.1), Ok);
        time += 0.1;
    }
    assert_eq!(host.step(time, 0.1), Error);
    assert!(host.said("after the stop time"));
}

#[test]
fn late_steps_are_told_apart_as_well_as_early_ones() {
    for (late, step) in [(1e4, 1e-3), (1e7, 1e-4), (1e9, 1.0)] {
        let mut host = Host::new();
        let setup = host.setup(Some(late + step));
        assert_eq!([setup, host.enter(), host.exit()], [Ok; 3]);
        assert_eq!(host.step(0.0, late), Ok);
        assert_eq!(host.step(late, step), Ok);
        assert_eq!(host.step(late, step), Error, "twice at {late}");
        assert!(host.said("where the last one ended"));
        assert_eq!(host.step(late + step, step), Error, "beyond at {late}");
        assert!(host.said("after the stop time"));
    }
    // A host that counts in single precision, and steps shorter than the numbers are apart.
    let host = Host::started();
    assert_eq!(host.step(0.0, 100.0), Ok);
    let mut time = 100.0_f32;
    for _ in 0..100 {
        assert_eq!(host.step(time.into(), 1e-3_f32.into()), Ok);
        time += 1e-3;
    }
    let host = Host::started();
    assert_eq!(host.step(0.0, 100.0), Ok);
    for _ in 0..3 {
        assert_eq!(host.step(100.0, 1e-17), Ok);
    }
}

#[test]
fn experiments_may_have_no_length_or_no_end() {
    for (stop, status) in
        [(0.0, Ok), (f64::INFINITY, Ok), (-1e-9, Error), (f64::NEG_INFINITY, Error), (f64::NAN, Error)]
    {
        let host = Host::new();
        assert_eq!(host.setup(Some(stop)), status, "{stop}");
    }
    let host = Host::new();
    let setup = host.setup(Some(f64::INFINITY));
    assert_eq!([setup, host.enter(), host.exit()], [Ok; 3]);
    assert_eq!(host.step(0.0, 1e9), Ok);
}

#[test]
fn failed_steps_follow_the_standard() {
    let mut host = Host::started();
    assert_eq!(host.step(0.0, 0.25), Ok);
    let state = host.save();
    assert_eq!([host.set_integer("trouble", 2), host.step(0.25, 0.25)], [Ok, Discard]);
    let (mut time, mut ended, mut status) = (f64::NAN, -1, Ok);
    // SAFETY: the component is alive, and so are the values.
    unsafe {
        assert_eq!(calls::fmi2GetRealStatus::<Lag>(host.component, 2, &mut time), Ok);
        assert_eq!(calls::fmi2GetBooleanStatus::<Lag>(host.component, 3, &mut ended), Ok);
        assert_eq!(calls::fmi2GetStatus::<Lag>(host.component, 0, &mut status), Ok);
        assert_eq!(calls::fmi2GetIntegerStatus::<Lag>(host.component, 0, &mut ended), Discard);
        assert_eq!(calls::fmi2GetStringStatus::<Lag>(host.component, 1, &mut null()), Discard);
        assert_eq!(calls::fmi2GetStringStatus::<Lag>(host.component, 1, null_mut()), Error);
    }
    assert_eq!((time, ended, status), (0.25, 0, Discard));
    assert_eq!(host.step(0.25, 0.25), Error, "not before a state is restored");
    assert_eq!([host.restore(state), host.step(0.25, 0.25)], [Ok; 2]);
    assert_eq!([host.set_integer("trouble", 3), host.step(0.5, 0.25)], [Ok, Error]);
    assert!(host.said("fmi2DoStep: the lag does not like its input"));
    assert!(host.try_get("output").is_ok(), "values can be read for debugging");
    assert_eq!([host.step(0.5, 0.25), host.reset(), host.enter()], [Error, Ok, Ok]);
    assert_eq!(host.free(state), Ok);
}

#[test]
fn a_panic_stops_at_the_boundary() {
    let mut host = Host::started();
    let other = Host::started();
    assert_eq!([host.set_integer("trouble", 4), host.step(0.0, 0.1)], [Ok, Fatal]);
    if let Some(last) = host.log().last() {
        assert_eq!((last.status, last.category.as_str()), (Fatal, "logStatusFatal"));
    }
    assert!(host.said("the lag panics"));
    assert_eq!([host.reset(), host.step(0.0, 0.1), host.terminate()], [Fatal; 3]);
    assert_eq!(other.step(0.0, 0.1), Ok, "other instances go on");
}

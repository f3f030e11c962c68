//! The boundary's behaviour, seen by a C host.
// The host's logger stands in for a variadic one, which Apple's arm64 convention does not allow.
#![cfg(not(all(target_vendor = "apple", target_arch = "aarch64")))]
#![allow(clippy::unwrap_used)]

mod host;

use std::ptr::{null, null_mut};

use fmu_export::fmi2::calls;
use host::{Discard, Error, Fatal, Host, Ok, guid, vr};
use lag::Lag;

/// The lag's exact answer to a constant input after `t` seconds, from its start values.
fn answer(input: f64, t: f64) -> f64 {
    let end = 2.0 * input;
    end + (1.0 - end) * (-t / 0.5_f64).exp()
}

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
        (c"", guid().as_c_str(), 1, "needs a name"),
        (c"a", c"{1}", 1, "does not belong to this binary"),
        (c"a", guid().as_c_str(), 0, "Co-Simulation"),
    ] {
        let mut host = Host::with(name, guid, kind, c"");
        assert!(host.component.is_null());
        assert!(host.last_message().contains(reason), "{reason}");
    }
    let mut host = Host::with(c"a", &guid(), 1, c"http://localhost/resources");
    assert!(!host.component.is_null());
    assert!(host.last_message().contains("no local folder"));
}

#[test]
fn strange_handles_are_refused() {
    let mut foreign = [0_u64; 64];
    let component = foreign.as_mut_ptr().cast();
    let state = Host::new().save();
    for component in [null_mut(), component, state] {
        // SAFETY: NULL, or readable memory that is no component.
        unsafe {
            assert_eq!(calls::reset::<Lag>(component), Error);
            assert_eq!(
                calls::get_real::<Lag>(component, null(), 0, null_mut()),
                Error
            );
            calls::free_instance::<Lag>(component);
        }
    }
    let mut host = Host::started();
    assert_eq!(host.restore(null_mut()), Error);
    assert_eq!(host.restore(component), Error);
    assert_eq!(host.restore(host.component), Error);
    assert!(host.last_message().contains("FMUstate"));
    assert_eq!(host.free(state), Ok);
    assert_eq!(host.free(null_mut()), Ok);
}

#[test]
fn null_is_welcome_where_nothing_is_asked_for() {
    let mut host = Host::started();
    // SAFETY: no values, no pointers.
    unsafe {
        let component = host.component;
        assert_eq!(calls::get_real::<Lag>(component, null(), 0, null_mut()), Ok);
        assert_eq!(calls::set_string::<Lag>(component, null(), 0, null()), Ok);
        assert_eq!(calls::set_debug_logging::<Lag>(component, 1, 0, null()), Ok);
        assert_eq!(calls::free_fmu_state::<Lag>(component, null_mut()), Ok);
        assert_eq!(
            calls::get_real::<Lag>(component, null(), 1, &mut 0.0),
            Error
        );
        assert_eq!(calls::get_real::<Lag>(component, &0, 1, null_mut()), Error);
        assert_eq!(
            calls::get_real::<Lag>(component, &0, usize::MAX, &mut 0.0),
            Error
        );
        assert_eq!(calls::set_string::<Lag>(component, &8, 1, &null()), Error);
    }
    let texts = host
        .messages()
        .into_iter()
        .map(|message| message.text)
        .collect::<Vec<_>>();
    assert_eq!(texts[0], "fmi2GetReal: argument vr is NULL");
    assert_eq!(texts[1], "fmi2GetReal: argument value is NULL");
}

#[test]
fn the_state_machine_is_the_standards() {
    let mut host = Host::new();
    assert_eq!(
        host.try_get("output"),
        Err(Error),
        "nothing is computed yet"
    );
    assert_eq!(
        host.last_message(),
        "fmi2GetReal: not allowed before the initialization"
    );
    assert_eq!(
        [host.step(0.0, 0.1), host.exit(), host.terminate()],
        [Error; 3]
    );
    assert_eq!(
        [host.set("input", 1.0), host.set("timeConstant", 0.25)],
        [Ok; 2]
    );
    assert_eq!([host.setup(None), host.enter()], [Ok; 2]);
    assert_eq!(
        [host.setup(None), host.enter(), host.step(0.0, 0.1)],
        [Error; 3]
    );
    assert_eq!(host.set("initialState", 7.0), Ok);
    assert_eq!(
        host.get("output"),
        7.0,
        "the initialization follows what is set within it"
    );
    assert_eq!(host.exit(), Ok);
    assert_eq!(host.set("initialState", 8.0), Error, "a fixed parameter");
    assert_eq!(
        [
            host.set("gain", 3.0),
            host.set("input", 1.0),
            host.step(0.0, 0.1)
        ],
        [Ok; 3]
    );
    // SAFETY: the component is alive.
    assert_eq!(unsafe { calls::cancel_step::<Lag>(host.component) }, Error);
    assert_eq!(host.terminate(), Ok);
    assert_eq!(
        [
            host.terminate(),
            host.step(0.1, 0.1),
            host.set("input", 0.0)
        ],
        [Error; 3]
    );
    assert!(host.try_get("output").is_ok());
    assert_eq!([host.reset(), host.enter(), host.exit()], [Ok; 3]);
    assert_eq!(host.get("output"), 1.0, "start values again");
}

#[test]
fn unusable_values_are_refused_by_name_and_change_nothing() {
    let mut host = Host::started();
    for (status, says) in [
        (host.set("input", f64::NAN), "input cannot be set to NaN"),
        (
            host.set("input", f64::INFINITY),
            "from -1000000.0 to 1000000.0",
        ),
        (host.set("gain", 2e6), "variable gain"),
        (
            host.set("output", 1.0),
            "output is an output, which cannot be set",
        ),
        (
            host.set("timeConstant", 1.0),
            "a fixed parameter, which cannot be set while running",
        ),
        (host.set("steps", 1.0), "steps is an output"),
        (
            host.set("trouble", 1.0),
            "trouble is of type Enumeration, not Real",
        ),
        (
            host.set_integer("trouble", 5),
            "one of 1 (None), 2 (Discard)",
        ),
        (host.step(0.0, 0.0), "greater than 0"),
        (host.step(0.0, -1.0), "greater than 0"),
        (host.step(0.0, f64::NAN), "greater than 0"),
        (host.step(f64::NAN, 0.1), "currentCommunicationPoint"),
        (host.step(0.5, 0.1), "begin where the last one ended"),
        (host.slope("input", 2, 1.0), "order 1, not 2"),
        (host.slope("gain", 1, 1.0), "only continuous inputs"),
    ] {
        assert_eq!(status, Error, "{says}");
        let messages = host.messages();
        assert!(
            messages
                .iter()
                .any(|m| m.text.contains(says) && m.category == "logStatusError"),
            "{says}"
        );
        // Put them back for the next round.
        *host.log() = messages;
    }
    // The first of two is right, the second is not: neither is set.
    // SAFETY: two values each.
    let status = unsafe {
        calls::set_real::<Lag>(host.component, [0, 999].as_ptr(), 2, [5.0, 5.0].as_ptr())
    };
    assert_eq!(status, Error);
    assert_eq!(host.get("input"), 0.0);
    assert_eq!(host.step(0.0, 0.1), Ok, "still usable");
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
    assert!(host.last_message().contains("after the stop time"));
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
        assert!(host.last_message().contains("where the last one ended"));
        assert_eq!(host.step(late + step, step), Error, "beyond at {late}");
        assert!(host.last_message().contains("after the stop time"));
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
    for (stop, status) in [
        (0.0, Ok),
        (f64::INFINITY, Ok),
        (-1e-9, Error),
        (f64::NEG_INFINITY, Error),
        (f64::NAN, Error),
    ] {
        let host = Host::new();
        assert_eq!(host.setup(Some(stop)), status, "{stop}");
    }
    let host = Host::new();
    let setup = host.setup(Some(f64::INFINITY));
    assert_eq!([setup, host.enter(), host.exit()], [Ok; 3]);
    assert_eq!(host.step(0.0, 1e9), Ok);
}

#[test]
fn names_in_another_encoding_are_taken() {
    let mut host = Host::with(c"l\xe4g", &guid(), 1, c"/tmp/r\xe9s");
    assert!(!host.component.is_null());
    assert!(host.last_message().contains("no local folder"));
}

#[test]
fn failed_steps_follow_the_standard() {
    let mut host = Host::started();
    assert_eq!(host.step(0.0, 0.25), Ok);
    let state = host.save();
    assert_eq!(
        [host.set_integer("trouble", 2), host.step(0.25, 0.25)],
        [Ok, Discard]
    );
    let (mut time, mut ended, mut status) = (f64::NAN, -1, Ok);
    // SAFETY: the component is alive, and so are the values.
    unsafe {
        assert_eq!(
            calls::get_real_status::<Lag>(host.component, 2, &mut time),
            Ok
        );
        assert_eq!(
            calls::get_boolean_status::<Lag>(host.component, 3, &mut ended),
            Ok
        );
        assert_eq!(calls::get_status::<Lag>(host.component, 0, &mut status), Ok);
        assert_eq!(
            calls::get_integer_status::<Lag>(host.component, 0, &mut ended),
            Discard
        );
        assert_eq!(
            calls::get_string_status::<Lag>(host.component, 1, &mut null()),
            Discard
        );
        assert_eq!(
            calls::get_string_status::<Lag>(host.component, 1, null_mut()),
            Error
        );
    }
    assert_eq!((time, ended, status), (0.25, 0, Discard));
    assert_eq!(
        host.step(0.25, 0.25),
        Error,
        "not before a state is restored"
    );
    assert_eq!([host.restore(state), host.step(0.25, 0.25)], [Ok; 2]);
    assert_eq!(
        [host.set_integer("trouble", 3), host.step(0.5, 0.25)],
        [Ok, Error]
    );
    assert!(
        host.messages()
            .iter()
            .any(|m| m.text.contains("does not like its input"))
    );
    assert!(
        host.try_get("output").is_ok(),
        "values can be read for debugging"
    );
    assert_eq!(
        [host.step(0.5, 0.25), host.reset(), host.enter()],
        [Error, Ok, Ok]
    );
    assert_eq!(host.free(state), Ok);
}

#[test]
fn a_panic_stops_at_the_boundary() {
    let mut host = Host::started();
    let other = Host::started();
    assert_eq!(
        [host.set_integer("trouble", 4), host.step(0.0, 0.1)],
        [Ok, Fatal]
    );
    let last = host.messages().pop().unwrap();
    assert_eq!(
        (last.status, last.category.as_str()),
        (Fatal, "logStatusFatal")
    );
    assert!(last.text.contains("the lag panics"));
    assert_eq!(
        [host.reset(), host.step(0.0, 0.1), host.terminate()],
        [Fatal; 3]
    );
    assert_eq!(other.step(0.0, 0.1), Ok, "other instances go on");
}

#[test]
fn the_log_obeys_its_categories_and_takes_texts_as_data() {
    let mut host = Host::new();
    assert_eq!(host.set_string("label", c"%s%n%d"), Ok);
    let switch = |on, categories: &[_]| {
        // SAFETY: as many texts as are counted.
        unsafe {
            calls::set_debug_logging::<Lag>(
                host.component,
                on,
                categories.len(),
                categories.as_ptr(),
            )
        }
    };
    assert_eq!(switch(1, &[c"lag".as_ptr()]), Ok);
    assert_eq!([host.enter(), host.exit()], [Ok; 2]);
    assert_eq!(switch(1, &[c"other".as_ptr()]), Error);
    assert_eq!(switch(1, &[c"logStatusError".as_ptr()]), Ok);
    assert_eq!(host.step(0.0, 0.1), Ok);
    assert_eq!(switch(1, &[c"logAll".as_ptr()]), Ok);
    assert_eq!(host.step(0.1, 0.1), Ok);
    assert_eq!(switch(0, &[]), Ok);
    assert_eq!(host.step(0.2, 0.1), Ok);
    let texts = host
        .messages()
        .into_iter()
        .map(|message| message.text)
        .collect::<Vec<_>>();
    assert_eq!(
        texts,
        [
            "%s%n%d starts at 0 s 100 %s%n",
            "fmi2SetDebugLogging: log category \"other\" is unknown; the model description lists those there are",
            "step to 0.2 s",
        ]
    );
}

#[test]
fn texts_live_on() {
    let host = Host::new();
    assert_eq!([host.set_string("label", c"one"), host.enter()], [Ok; 2]);
    let one = host.get_string("label");
    let report = host.get_string("report");
    assert_eq!(host.exit(), Ok);
    assert_eq!(host.step(0.0, 0.1), Ok);
    assert_eq!(host.get_string("label").as_ptr(), one.as_ptr());
    assert_eq!(one, c"one");
    assert_eq!(report, c"one starts at 0 s");
    assert_eq!(host.set_boolean("inverted", -1), Ok);
    assert_eq!(host.get("output"), -answer(0.0, 0.1));
}

#[test]
fn inputs_with_slopes_meet_the_exact_solution() {
    let host = Host::started();
    for i in 0..10 {
        let t = f64::from(i) * 0.1;
        assert_eq!(
            [
                host.set("input", t),
                host.slope("input", 1, 1.0),
                host.step(t, 0.1)
            ],
            [Ok; 3]
        );
    }
    // tau y' = 2 t - y, y(0) = 1
    let exact = 2.0 * (1.0 - 0.5) + (1.0 + 2.0 * 0.5) * (-1.0 / 0.5_f64).exp();
    assert!((host.get("output") - exact).abs() < 1e-13);
    let held = host.get("input");
    assert_eq!(host.step(1.0, 0.1), Ok);
    assert_eq!(host.get("input"), held, "slopes hold for one step");
}

#[test]
fn output_derivatives_known_and_by_difference() {
    let host = Host::started();
    assert_eq!([host.set("input", 3.0), host.step(0.0, 0.2)], [Ok; 2]);
    let rate = (6.0 - answer(3.0, 0.2)) / 0.5;
    assert!((host.rate("output") - rate).abs() < 1e-12);
    assert_eq!(host.slope("input", 1, 4.0), Ok);
    assert!(
        (host.rate("feed") - 8.0).abs() < 1e-6,
        "{}",
        host.rate("feed")
    );
    assert_eq!(host.get("output"), answer(3.0, 0.2), "nothing has moved");
}

#[test]
fn directional_derivatives() {
    let host = Host::new();
    assert_eq!(host.enter(), Ok);
    assert!((host.derivative("output", "initialState") - 1.0).abs() < 1e-9);
    assert_eq!([host.set("input", 3.0), host.exit()], [Ok; 2]);
    assert!((host.derivative("feed", "input") - 2.0).abs() < 1e-9);
    assert!((host.derivative("feed", "gain") - 3.0).abs() < 1e-9);
    assert_eq!(host.derivative("output", "input"), 0.0);
    // At a bound the difference is one-sided.
    assert_eq!(host.set("input", 1e6), Ok);
    assert!((host.derivative("feed", "input") - 2.0).abs() < 1e-8);
    assert_eq!(host.get("input"), 1e6);
    let mut value = 0.0;
    let derivative = |unknown, known, direction| {
        // SAFETY: one value each.
        unsafe {
            calls::get_directional_derivative::<Lag>(
                host.component,
                &vr(unknown),
                1,
                &vr(known),
                1,
                &direction,
                &mut value,
            )
        }
    };
    let mut derivative = derivative;
    assert_eq!(derivative("feed", "input", 0.0), Ok);
    assert_eq!(derivative("feed", "input", f64::NAN), Error);
    assert_eq!(derivative("input", "input", 1.0), Error);
    assert_eq!(derivative("feed", "timeConstant", 1.0), Error);
    assert_eq!(derivative("feed", "inverted", 1.0), Error);
}

#[test]
fn saved_states_continue_bit_for_bit() {
    let host = Host::started();
    let run = |host: &Host| {
        for i in 2..20 {
            assert_eq!(host.step(f64::from(i) / 10.0, 0.1), Ok);
        }
        host.get("output").to_bits()
    };
    assert_eq!([host.set("input", 0.3), host.step(0.0, 0.2)], [Ok; 2]);
    let state = host.save();
    let bytes = host.bytes(state);
    let end = run(&host);
    assert_eq!(host.restore(state), Ok);
    assert_eq!(run(&host), end);
    let other = Host::new();
    let copy = other.state_of(&bytes).unwrap();
    assert_eq!(other.restore(copy), Ok);
    assert_eq!(run(&other), end);
    assert_eq!([host.free(state), other.free(copy)], [Ok; 2]);
}

#[test]
fn states_of_the_initialization_are_whole() {
    let host = Host::new();
    assert_eq!([host.enter(), host.set("initialState", 5.0)], [Ok; 2]);
    let state = host.save();
    let bytes = host.bytes(state);
    assert_eq!([host.free(state), host.reset()], [Ok; 2]);
    let state = host.state_of(&bytes).unwrap();
    assert_eq!(
        [
            host.restore(state),
            host.set("gain", 1.0),
            host.exit(),
            host.free(state)
        ],
        [Ok; 4]
    );
    assert_eq!(host.get("output"), 5.0);
}

#[test]
fn damaged_states_are_refused() {
    let host = Host::started();
    let state = host.save();
    let bytes = host.bytes(state);
    assert_eq!(host.free(state), Ok);
    for length in 0..bytes.len() {
        assert_eq!(
            host.state_of(&bytes[..length]),
            Err(Error),
            "cut at {length}"
        );
    }
    for place in 0..bytes.len() {
        let mut damaged = bytes.clone();
        damaged[place] ^= 0x10;
        assert_eq!(host.state_of(&damaged), Err(Error), "damaged at {place}");
    }
    let longer = [bytes.as_slice(), &[0]].concat();
    assert_eq!(host.state_of(&longer), Err(Error));
    assert_eq!(host.step(0.0, 0.1), Ok, "still usable");
}

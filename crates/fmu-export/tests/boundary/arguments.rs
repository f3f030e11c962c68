//! Arguments, messages and texts.

use std::ptr::{null, null_mut};

use fmu_export::fmi2::calls;
use fmu_export::fmi2::types::{Component, TRUE};
use lag::Lag;

use crate::answer;
use crate::host::{Error, Host, Ok};

#[test]
fn strange_handles_are_refused() {
    let mut foreign = [0_u64; 64];
    let component = foreign.as_mut_ptr().cast();
    let state = Host::new().save();
    for component in [null_mut(), component, state] {
        // SAFETY: NULL, or readable memory that is no component.
        unsafe {
            assert_eq!(calls::fmi2Reset::<Lag>(component), Error);
            assert_eq!(calls::fmi2GetReal::<Lag>(component, null(), 0, null_mut()), Error);
            calls::fmi2FreeInstance::<Lag>(component);
        }
    }
    let mut host = Host::started();
    assert_eq!(host.restore(null_mut()), Error);
    assert_eq!(host.restore(component), Error);
    assert_eq!(host.restore(host.component), Error);
    assert!(host.said("`FMUstate` is not a handle that this FMU gave, or it was freed"));
    assert_eq!(host.free(state), Ok);
    assert_eq!(host.free(null_mut()), Ok);
}

#[test]
fn null_is_welcome_where_nothing_is_asked_for() {
    let mut host = Host::started();
    // SAFETY: no values, no pointers.
    unsafe {
        let component = host.component;
        assert_eq!(calls::fmi2GetReal::<Lag>(component, null(), 0, null_mut()), Ok);
        assert_eq!(calls::fmi2SetString::<Lag>(component, null(), 0, null()), Ok);
        assert_eq!(calls::fmi2SetDebugLogging::<Lag>(component, 1, 0, null()), Ok);
        assert_eq!(calls::fmi2FreeFMUstate::<Lag>(component, null_mut()), Ok);
        assert_eq!(calls::fmi2GetReal::<Lag>(component, null(), 1, &mut 0.0), Error);
        assert_eq!(calls::fmi2GetReal::<Lag>(component, &0, 1, null_mut()), Error);
        assert_eq!(calls::fmi2GetReal::<Lag>(component, &0, usize::MAX, &mut 0.0), Error);
        assert_eq!(calls::fmi2SetString::<Lag>(component, &8, 1, &null()), Error);
    }
    if cfg!(miri) {
        return;
    }
    let texts = host.messages().into_iter().map(|message| message.text);
    assert_eq!(
        Vec::from_iter(texts),
        [
            "fmi2GetReal: `vr` is NULL although n > 0",
            "fmi2GetReal: `value` is NULL although n > 0",
            "fmi2GetReal: `vr` cannot point to n = 18446744073709551615 values, which are more than any memory holds",
            "fmi2SetString: `value` is NULL",
        ]
    );
}

#[test]
fn unusable_values_are_refused_by_name_and_change_nothing() {
    let mut host = Host::started();
    for (status, says) in [
        (host.set("input", f64::NAN), "input cannot be set to NaN"),
        (host.set("input", f64::INFINITY), "from -1000000.0 to 1000000.0"),
        (host.set("gain", 2e6), "gain cannot be set to 2000000.0"),
        (host.set("output", 1.0), "output is an output, which cannot be set"),
        (host.set("timeConstant", 1.0), "a fixed parameter, which cannot be set while running"),
        (host.set("steps", 1.0), "steps is an output"),
        (host.set("trouble", 1.0), "trouble is of type Enumeration, not Real"),
        (host.set_integer("trouble", 5), "one of 1 (None), 2 (Discard)"),
        (host.step(0.0, 0.0), "greater than 0"),
        (host.step(0.0, -1.0), "greater than 0"),
        (host.step(0.0, f64::NAN), "greater than 0"),
        (host.step(f64::NAN, 0.1), "currentCommunicationPoint"),
        (host.step(0.5, 0.1), "begin where the last one ended"),
        (host.slope("input", 2, 1.0), "must be 1, not 2"),
        (host.slope("gain", 1, 1.0), "only inputs that may vary"),
    ] {
        assert_eq!(status, Error, "{says}");
        let messages = host.messages();
        assert!(
            cfg!(miri) || messages.iter().any(|m| m.text.contains(says) && m.category == "logStatusError"),
            "{says}"
        );
        // Put them back for the next round.
        *host.log() = messages;
    }
    // The first of two is right, the second is not: neither is set.
    // SAFETY: two values each.
    let status = unsafe { calls::fmi2SetReal::<Lag>(host.component, [0, 999].as_ptr(), 2, [5.0, 5.0].as_ptr()) };
    assert_eq!(status, Error);
    assert_eq!(host.get("input"), 0.0);
    assert_eq!(host.step(0.0, 0.1), Ok, "still usable");
}

#[test]
#[cfg_attr(miri, ignore = "Miri cannot call the host's logger")]
fn the_log_obeys_its_categories_and_takes_texts_as_data() {
    let mut host = Host::new();
    assert_eq!(host.set_string("label", c"%s%n%d"), Ok);
    let switch = |on, categories: &[_]| {
        // SAFETY: as many texts as are counted.
        unsafe { calls::fmi2SetDebugLogging::<Lag>(host.component, on, categories.len(), categories.as_ptr()) }
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
    let texts = host.messages().into_iter().map(|message| message.text).collect::<Vec<_>>();
    assert_eq!(
        texts,
        [
            "%s%n%d starts at 0 s 100 %s%n",
            "fmi2SetDebugLogging: log category \"other\" is unknown; LogCategories in modelDescription.xml lists the known ones",
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

/// A component that two threads share, as a careless host does.
#[derive(Clone, Copy)]
struct Shared(Component);

// SAFETY: the boundary lets one call at a time into an instance; this is what the test is about.
unsafe impl Send for Shared {}

impl Shared {
    /// Tries to make 200 steps, so short that the time stays the same; returns how many were made.
    fn steps(self, late: f64) -> i32 {
        let step = || {
            // SAFETY: the component lives until both threads have ended.
            let status = unsafe { calls::fmi2DoStep::<Lag>(self.0, late, 1e-9, TRUE) };
            assert!(status == Ok || status == Error, "{status:?}");
            status == Ok
        };
        (0..200).filter(|_| step()).count() as i32
    }
}

#[test]
fn calls_from_two_threads_come_one_at_a_time() {
    const LATE: f64 = 1e9;
    let host = Host::started();
    assert_eq!(host.step(0.0, LATE), Ok);
    let shared = Shared(host.component);
    let made = std::thread::scope(|scope| {
        let threads = [0, 1].map(|_| scope.spawn(move || shared.steps(LATE)));
        threads.map(|thread| thread.join().unwrap())
    });
    assert_eq!(host.get_integer("steps"), 1 + made.iter().sum::<i32>());
}

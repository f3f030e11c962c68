//! Events, arrays and clocks: a host of the thermostat.
//!
//! Apart from the boundary's tests, which run the lag: both libraries export the functions of FMI by the same names, so no
//! program can be linked with the two.
#![allow(clippy::unwrap_used)]

use std::ffi::CString;
use std::marker::PhantomData;
use std::ptr::{null, null_mut};

use fmu_export::description::{Interface, Version, fingerprint, token};
use fmu_export::fmi3::calls;
use fmu_export::fmi3::types::Status::{Discard, Error, Ok};
use fmu_export::fmi3::types::{Boolean, Component, FmuState, Status, ValueReference};
use fmu_export::model::Model;
use thermostat::House;

fn vr<M: Model>(name: &str) -> ValueReference {
    let mut names = M::variables().iter();
    names.position(|variable| variable.array_name() == name).unwrap() as ValueReference
}

/// A model in a host of FMI 3.0.
struct Of<M: Model>(Component, PhantomData<M>);

/// The thermostat in one.
type Host = Of<House>;

impl<M: Model> Drop for Of<M> {
    fn drop(&mut self) {
        // SAFETY: our own component, freed once.
        unsafe { calls::fmi3FreeInstance::<M>(self.0) }
    }
}

fn of<M: Model>(interface: Interface) -> CString {
    let fingerprint = fingerprint::<M>(Version::Three, interface);
    CString::new(token(fingerprint)).unwrap()
}

// SAFETY of all: the component is alive, and the pointers are ours.
#[allow(clippy::undocumented_unsafe_blocks)]
impl<M: Model> Of<M> {
    fn exchange() -> Self {
        let (name, token) = (c"house".as_ptr(), of::<M>(Interface::ModelExchange));
        Self(
            unsafe {
                let token = token.as_ptr();
                calls::fmi3InstantiateModelExchange::<M>(name, token, null(), 0, 0, null_mut(), None)
            },
            PhantomData,
        )
        .started()
    }

    fn stepped(event_mode: Boolean, early: Boolean) -> Self {
        let (name, token) = (c"house".as_ptr(), of::<M>(Interface::CoSimulation));
        let (none, nowhere) = (null(), null_mut());
        Self(
            unsafe {
                let token = token.as_ptr();
                calls::fmi3InstantiateCoSimulation::<M>(
                    name,
                    token,
                    null(),
                    0,
                    0,
                    event_mode,
                    early,
                    none,
                    0,
                    nowhere,
                    None,
                    None,
                )
            },
            PhantomData,
        )
        .started()
    }

    fn started(self) -> Self {
        assert!(!self.0.is_null());
        let entered = unsafe { calls::fmi3EnterInitializationMode::<M>(self.0, 0, 0.0, 0.0, 0, 0.0) };
        let left = unsafe { calls::fmi3ExitInitializationMode::<M>(self.0) };
        assert_eq!([entered, left], [Ok; 2]);
        self
    }

    /// Whether the host has to come again, and the next event.
    fn update(&self) -> (bool, Option<f64>) {
        let ([mut again, mut ends, mut nominals, mut states, mut known], mut next) = ([7; 5], 7.0);
        let status = unsafe {
            calls::fmi3UpdateDiscreteStates::<M>(
                self.0,
                &mut again,
                &mut ends,
                &mut nominals,
                &mut states,
                &mut known,
                &mut next,
            )
        };
        assert_eq!((status, ends, nominals, states), (Ok, 0, 0, again));
        (again != 0, (known != 0).then_some(next))
    }

    fn step(&self, from: f64, step: f64) -> (Status, [bool; 2], f64) {
        let ([mut event, mut ends, mut early], mut reached) = ([7; 3], f64::NAN);
        let flags = (&mut event, &mut ends, &mut early);
        let status = unsafe { calls::fmi3DoStep::<M>(self.0, from, step, 1, flags.0, flags.1, flags.2, &mut reached) };
        (status, [event != 0, early != 0], reached)
    }

    fn clock(&self) -> bool {
        let mut active = 7;
        let status = unsafe { calls::fmi3GetClock::<M>(self.0, &vr::<M>("switched"), 1, &mut active) };
        assert_eq!(status, Ok);
        active != 0
    }

    fn get<const N: usize>(&self, name: &str) -> [f64; N] {
        let mut into = [f64::NAN; N];
        let place = into.as_mut_ptr();
        let status = unsafe { calls::fmi3GetFloat64::<M>(self.0, &vr::<M>(name), 1, place, N) };
        assert_eq!(status, Ok);
        into
    }

    fn set(&self, name: &str, values: &[f64]) -> Status {
        let (from, n) = (values.as_ptr(), values.len());
        unsafe { calls::fmi3SetFloat64::<M>(self.0, &vr::<M>(name), 1, from, n) }
    }

    fn enter_event(&self) -> Status {
        unsafe { calls::fmi3EnterEventMode::<M>(self.0) }
    }

    fn enter_step(&self) -> Status {
        unsafe { calls::fmi3EnterStepMode::<M>(self.0) }
    }

    fn enter_continuous(&self) -> Status {
        unsafe { calls::fmi3EnterContinuousTimeMode::<M>(self.0) }
    }
}

/// From 288.15 K to 294.15 K, with 308.15 K as the end.
fn first_switch() -> f64 {
    7200.0 * (20.0_f64 / 14.0).ln()
}

#[test]
fn steps_end_at_events_in_event_mode_alone() {
    let seen = Host::stepped(1, 1);
    assert_eq!(seen.step(0.0, 60.0).0, Error, "it is in event mode");
    assert_eq!(seen.update(), (false, Some(79_200.0)));
    assert_eq!([seen.enter_continuous(), seen.enter_step()], [Error, Ok]);
    assert_eq!(seen.step(0.0, 2000.0), (Ok, [false; 2], 2000.0));
    let (status, flags, reached) = seen.step(2000.0, 1000.0);
    assert_eq!((status, flags), (Ok, [true; 2]));
    assert!((reached - first_switch()).abs() < 1e-9);
    assert_eq!(seen.enter_event(), Ok);
    assert!(!seen.clock());
    assert_eq!(seen.update(), (true, Some(79_200.0)));
    assert!(seen.clock());
    assert_eq!(seen.get("switchTime"), [reached]);
    assert_eq!(seen.update(), (false, Some(79_200.0)));
    assert!(!seen.clock());
    assert_eq!([seen.enter_step(), seen.enter_step()], [Ok, Error]);
    assert_eq!(seen.step(reached, 3000.0 - reached).1, [false; 2]);
    // A step may end at an event and still be whole. An event that a new value makes due is handled before time passes.
    let at_end = Host::stepped(1, 1);
    assert_eq!([at_end.enter_step(), at_end.set("setpoint", &[288.15])], [Ok; 2]);
    let (_, flags, reached) = at_end.step(0.0, 7200.0 * (20.0_f64 / 19.0).ln());
    assert_eq!(flags, [true, false]);
    assert_eq!(at_end.set("setpoint", &[287.0]), Ok);
    assert_eq!(at_end.step(reached, 10.0), (Ok, [true; 2], reached));
    // Other hosts find the same temperatures.
    for unseen in [Host::stepped(0, 1), Host::stepped(0, 0), Host::stepped(1, 0)] {
        if unseen.step(0.0, 10.0).0 == Error {
            assert_eq!([unseen.enter_step(), unseen.step(0.0, 10.0).0], [Ok; 2]);
        } else {
            assert_eq!([unseen.enter_event(), unseen.enter_step()], [Error; 2]);
        }
        assert_eq!(unseen.step(10.0, 2990.0), (Ok, [false; 2], 3000.0));
        let expected: [f64; 3] = seen.get("temperature");
        for (one, other) in expected.into_iter().zip(unseen.get::<3>("temperature")) {
            assert!((one - other).abs() < 1e-9, "{one} {other}");
        }
    }
}

#[test]
fn a_host_that_integrates_sees_the_events() {
    let host = Host::exchange();
    let (mut n, mut margins) = (0, [0.0; 3]);
    assert_eq!([host.enter_step(), host.enter_continuous()], [Error, Ok]);
    // SAFETY: the component is alive, and the pointers are ours.
    unsafe {
        calls::fmi3GetNumberOfEventIndicators::<House>(host.0, &mut n);
        assert_eq!(n, 3);
        let indicators = calls::fmi3GetEventIndicators::<House>;
        assert_eq!(indicators(host.0, margins.as_mut_ptr(), 2), Error);
        assert_eq!(indicators(host.0, margins.as_mut_ptr(), 3), Ok);
        assert!(margins.iter().all(|margin| (margin - 6.0).abs() < 1e-12), "{margins:?}");
        let states = [290.0, 294.15 + 1e-6, 294.0];
        calls::fmi3SetTime::<House>(host.0, 1234.0);
        calls::fmi3SetContinuousStates::<House>(host.0, states.as_ptr(), 3);
        assert_eq!(indicators(host.0, margins.as_mut_ptr(), 3), Ok);
        assert!(margins[1] < 0.0 && margins[0] > 0.0);
        assert_eq!(host.enter_event(), Ok);
        assert_eq!(host.update(), (true, Some(79_200.0)));
        assert!(host.clock());
        assert_eq!((host.get("switchTime"), host.get::<3>("margin")[1] > 1.9), ([1234.0], true));
        assert_eq!(host.update(), (false, Some(79_200.0)));
        // Night falls: nothing more is known beforehand.
        assert_eq!(host.enter_continuous(), Ok);
        calls::fmi3SetTime::<House>(host.0, 79_200.0);
        assert_eq!(host.enter_event(), Ok);
        assert_eq!(host.update(), (true, None));
        assert_eq!(host.update(), (false, None));
    }
}

/// Clocks are outputs, and arrays whole.
#[test]
fn what_cannot_be_is_refused() {
    let host = Host::stepped(1, 1);
    // SAFETY: the component is alive, and the pointers are ours.
    unsafe {
        let set = calls::fmi3SetClock::<House>;
        assert_eq!(
            [set(host.0, &vr::<House>("switched"), 1, &1), set(host.0, &vr::<House>("band"), 1, &1)],
            [Error; 2]
        );
        let mut active = 7;
        let get = calls::fmi3GetClock::<House>;
        assert_eq!(get(host.0, &vr::<House>("band"), 1, &mut active), Error);
        let mut derivatives = [f64::NAN; 3];
        assert_eq!(host.enter_step(), Ok);
        let rates = calls::fmi3GetOutputDerivatives::<House>;
        let temperature = vr::<House>("temperature");
        assert_eq!(rates(host.0, &temperature, 1, &1, derivatives.as_mut_ptr(), 1), Error);
        assert_eq!(rates(host.0, &temperature, 1, &1, derivatives.as_mut_ptr(), 3), Ok);
        for (rate, constant) in derivatives.into_iter().zip([7200.0, 10800.0, 18000.0]) {
            assert!((rate - 20.0 / constant).abs() < 1e-15);
        }
    }
    assert_eq!(host.set("timeConstant", &[1.0]), Error);
    assert_eq!(host.set("setpoint", &[290.0]), Ok);
}

#[test]
fn saved_states_know_their_mode() {
    let (host, other) = (Host::stepped(1, 1), Host::stepped(0, 1));
    let saved = |host: &Host| {
        let mut state: FmuState = null_mut();
        // SAFETY: the component is alive, and the place is ours.
        let status = unsafe { calls::fmi3GetFMUState::<House>(host.0, &mut state) };
        assert_eq!(status, Ok);
        state
    };
    let in_event_mode = saved(&host);
    let mut size = 0;
    // SAFETY: components and states are alive, and the places are ours.
    unsafe {
        assert_eq!(calls::fmi3SetFMUState::<House>(other.0, in_event_mode), Error);
        assert_eq!(calls::fmi3SerializedFMUStateSize::<House>(host.0, in_event_mode, &mut size), Ok);
        let mut bytes = vec![0_u8; size];
        let serialize = calls::fmi3SerializeFMUState::<House>;
        assert_eq!(serialize(host.0, in_event_mode, bytes.as_mut_ptr(), size), Ok);
        assert_eq!(host.enter_step(), Ok);
        let in_step_mode = saved(&host);
        let mut again = null_mut();
        let deserialize = calls::fmi3DeserializeFMUState::<House>;
        assert_eq!(deserialize(host.0, bytes.as_ptr(), size, &mut again), Ok);
        assert_eq!(calls::fmi3SetFMUState::<House>(host.0, again), Ok);
        assert_eq!(host.enter_step(), Ok, "from event mode");
        assert_eq!(calls::fmi3SetFMUState::<House>(other.0, in_step_mode), Ok);
        for mut state in [in_event_mode, in_step_mode, again] {
            assert_eq!(calls::fmi3FreeFMUState::<House>(host.0, &mut state), Ok);
        }
    }
}

#[test]
fn event_mode_has_derivatives_in_co_simulation() {
    for (host, expected) in [(Host::stepped(1, 1), (Ok, [1.0; 3])), (Host::exchange(), (Error, [7.0; 3]))] {
        let (margin, setpoint) = (vr::<House>("margin"), vr::<House>("setpoint"));
        let mut slopes = [7.0; 3];
        let place = slopes.as_mut_ptr();
        let derivative = calls::fmi3GetDirectionalDerivative::<House>;
        // SAFETY: the component is alive, and the places are ours.
        let status = unsafe { derivative(host.0, &margin, 1, &setpoint, 1, &1.0, 1, place, 3) };
        assert_eq!((status, slopes.map(f64::round)), expected);
    }
}

mod stuck {
    use fmu_export::declare::output;
    use fmu_export::model::{
        Complete, Continuous, Events, Exchange, Experiment, Fault, Info, Log, Model, State, Variable,
    };
    use fmu_export::units::{ONE, PER_SECOND};
    use serde::{Deserialize, Serialize};

    /// Its event never ends; above 1 it cannot be handled, and no value exists.
    #[derive(Clone, Default, Serialize, Deserialize)]
    pub struct Stuck(f64);

    static STUCK: [Variable<Stuck>; 1] = [output("x", &ONE, |stuck: &Stuck| stuck.exists(), "x")];

    impl Stuck {
        fn exists(&self) -> f64 {
            if self.0 > 1.0 { f64::NAN } else { self.0 }
        }

        fn handle(&mut self) -> Result<bool, Fault> {
            let changed = std::mem::replace(&mut self.0, 0.5);
            match changed > 1.0 {
                true => Err(Fault::Failed("too much".to_owned())),
                false => Ok(true),
            }
        }
    }

    impl Model for Stuck {
        const INFO: Info = fmu_export::info!();

        const EXCHANGE: Option<Exchange<Self>> = Some(Exchange::of());

        const EVENTS: Option<Events<Self>> = Some(Events {
            indicators: &["x"],
            next: |_| Some(f64::INFINITY),
            until: |_, _, _, _| Ok(Some(0.0)),
            handle: Self::handle,
        });

        fn variables() -> &'static [Variable<Self>] {
            &STUCK
        }

        fn initialise(&mut self, _: &Experiment<'_>, _: &mut dyn Log) -> Result<(), Fault> {
            Ok(())
        }

        fn advance(&mut self, _: f64, _: f64, _: &mut dyn Log) -> Result<(), Fault> {
            Ok(())
        }
    }

    impl Continuous for Stuck {
        fn states() -> &'static [State<Self>] {
            static STATES: [State<Stuck>; 1] = [State {
                name: "state.x",
                description: "x",
                unit: &ONE,
                rate_unit: &PER_SECOND,
                nominal: 1.0,
                get: |stuck| stuck.0,
                set: |stuck, x| stuck.0 = x,
            }];
            &STATES
        }

        const COMPLETE: Option<Complete<Self>> = Some(|stuck, _| stuck.0 > 0.9);

        fn set_time(&mut self, _: f64) {}

        fn rates(&self, rates: &mut [f64]) -> Result<(), Fault> {
            rates[0] = self.exists();
            Ok(())
        }
    }
}
use stuck::Stuck;

impl Of<Stuck> {
    fn status(&self) -> Status {
        let ([mut a, mut b, mut c, mut d, mut e], mut next) = ([0; 5], 0.0);
        let update = calls::fmi3UpdateDiscreteStates::<Stuck>;
        // SAFETY: the component is alive, and the places are ours.
        let status = unsafe { update(self.0, &mut a, &mut b, &mut c, &mut d, &mut e, &mut next) };
        assert_eq!((e, next), (0, 0.0), "no event is known");
        status
    }
}

#[test]
fn events_that_do_not_end_or_fail_are_discarded_and_change_nothing() {
    let host = Of::<Stuck>::exchange();
    let rounds = (0..20_000).take_while(|_| host.status() == Ok).count();
    assert_eq!(rounds, 10_000);
    assert_eq!([host.status(), host.enter_continuous()], [Discard, Ok]);
    let [mut rate, mut margin, mut state] = [0.0; 3];
    // SAFETY: the component is alive, and the places are ours.
    unsafe {
        calls::fmi3SetTime::<Stuck>(host.0, 1.0);
        let rates = calls::fmi3GetContinuousStateDerivatives::<Stuck>;
        let margins = calls::fmi3GetEventIndicators::<Stuck>;
        assert_eq!([rates(host.0, &mut rate, 1), margins(host.0, &mut margin, 1)], [Ok; 2]);
        calls::fmi3SetContinuousStates::<Stuck>(host.0, &2.0, 1);
        assert_eq!([rates(host.0, &mut rate, 1), margins(host.0, &mut margin, 1)], [Discard; 2]);
        assert_eq!([host.enter_event(), host.status()], [Ok, Discard]);
        calls::fmi3GetContinuousStates::<Stuck>(host.0, &mut state, 1);
    }
    assert_eq!(state, 2.0);
    // Another instant.
    assert_eq!(host.enter_continuous(), Ok);
    // SAFETY: the component is alive, and the places are ours.
    unsafe { calls::fmi3SetContinuousStates::<Stuck>(host.0, &1.0, 1) };
    assert_eq!([host.enter_event(), host.status()], [Ok; 2]);
}

/// A model that wants to know of completed steps says so, and decides which of them end in the event mode.
#[test]
fn a_completed_step_may_ask_for_the_event_mode() {
    let host = Of::<Stuck>::exchange();
    assert_eq!([host.status(), host.enter_continuous()], [Ok; 2]);
    let completed = |x: f64| {
        let [mut event, mut terminate] = [7; 2];
        // SAFETY: the component is alive, and the places are ours.
        let all = unsafe {
            let completed = calls::fmi3CompletedIntegratorStep::<Stuck>;
            [calls::fmi3SetContinuousStates::<Stuck>(host.0, &x, 1), completed(host.0, 1, &mut event, &mut terminate)]
        };
        assert_eq!((all, terminate), ([Ok; 2], 0));
        event
    };
    assert_eq!([0.4, 0.95, 0.4].map(completed), [0, 1, 0]);
}

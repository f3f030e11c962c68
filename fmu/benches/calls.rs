//! Cost of calls to the stand's C functions other than steps: `cargo bench -p plain-bearing-stand --bench calls`.

use std::ffi::c_int;
use std::hint::black_box;
use std::ptr::{null, null_mut};

use divan::Bencher;
use fmu_export::description::{self, Interface, Version};
use fmu_export::fmi2::types::*;
use fmu_export::model::{Model, Role};
use plain_bearing_stand::c_functions::*;
use plain_bearing_stand::stand::Stand;

fn main() {
    divan::main();
}

/// The films by their items of the enumeration.
const FILMS: [Film; 2] = [Film("mobility", 1), Film("reynolds", 2)];
const STEP: f64 = 1e-3;

/// A film model: name and item.
struct Film(&'static str, c_int);

impl std::fmt::Display for Film {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.0)
    }
}

/// A stand after 20 steps.
struct Host {
    component: Component,
    time: f64,
}

impl Host {
    fn new(film: &Film) -> Self {
        let guid = description::token(description::fingerprint::<Stand>(Version::Two, Interface::CoSimulation)) + "\0";
        let callbacks = CallbackFunctions {
            logger: None,
            allocate_memory: None,
            free_memory: None,
            step_finished: None,
            component_environment: null_mut(),
        };
        let choice = references(|name, _| name == "bearing.film");
        // SAFETY: all arguments are what the standard asks for.
        let component = unsafe {
            let (name, guid) = (c"bench".as_ptr(), guid.as_ptr().cast());
            let callbacks = &raw const callbacks;
            let component = fmi2Instantiate(name, CO_SIMULATION, guid, null(), callbacks, FALSE, FALSE);
            let done = [
                fmi2SetInteger(component, choice.as_ptr(), 1, &film.1),
                fmi2SetupExperiment(component, FALSE, 0.0, 0.0, FALSE, 0.0),
                fmi2EnterInitializationMode(component),
                fmi2ExitInitializationMode(component),
            ];
            assert_eq!(done, [Status::Ok; 4]);
            component
        };
        let mut host = Self { component, time: 0.0 };
        for _ in 0..20 {
            assert_eq!(host.step(), Status::Ok);
        }
        host
    }

    fn step(&mut self) -> Status {
        // SAFETY: the component is alive.
        let status = unsafe { fmi2DoStep(self.component, self.time, STEP, TRUE) };
        self.time += STEP;
        status
    }
}

impl Drop for Host {
    fn drop(&mut self) {
        // SAFETY: our own component, freed once.
        unsafe { fmi2FreeInstance(self.component) }
    }
}

fn references(wanted: impl Fn(&str, Role) -> bool) -> Vec<ValueReference> {
    (0..)
        .zip(Stand::variables())
        .filter(|(_, variable)| wanted(variable.name, variable.role))
        .map(|(reference, _)| reference)
        .collect()
}

/// A step of 1 ms.
#[divan::bench(args = FILMS, sample_count = 300, sample_size = 4)]
fn do_step(bencher: Bencher<'_, '_>, film: &Film) {
    let mut host = Host::new(film);
    bencher.bench_local(|| host.step());
}

/// The rates of all outputs in one call, after a step.
#[divan::bench(args = FILMS, sample_count = 100, sample_size = 1)]
fn rates_of_all_outputs(bencher: Bencher<'_, '_>, film: &Film) {
    let mut host = Host::new(film);
    let outputs = references(|_, role| role == Role::Output);
    let orders = vec![1; outputs.len()];
    let mut rates = vec![0.0; outputs.len()];
    let component = host.component;
    bencher.with_inputs(|| host.step()).bench_local_values(|_| {
        // SAFETY: the component is alive, and there is a place for each output.
        let status = unsafe {
            let (references, orders, n) = (outputs.as_ptr(), orders.as_ptr(), outputs.len());
            fmi2GetRealOutputDerivatives(component, references, n, orders, rates.as_mut_ptr())
        };
        assert_eq!(black_box(status), Status::Ok);
    });
}

/// A state saved, in the place of an earlier one.
#[divan::bench(args = FILMS, sample_count = 1000, sample_size = 1)]
fn get_state(bencher: Bencher<'_, '_>, film: &Film) {
    let mut host = Host::new(film);
    let component = host.component;
    let mut state = null_mut();
    bencher.with_inputs(|| host.step()).bench_local_values(|_| {
        // SAFETY: the component and the state are alive.
        unsafe { fmi2GetFMUstate(component, &raw mut state) }
    });
    // SAFETY: as above; freed once.
    unsafe { fmi2FreeFMUstate(component, &raw mut state) };
}

/// A state saved, a step of 1 ms, and the state restored, as a host does that may take a step back.
#[divan::bench(args = FILMS, sample_count = 300, sample_size = 4)]
fn save_step_restore(bencher: Bencher<'_, '_>, film: &Film) {
    let host = Host::new(film);
    let (component, time) = (host.component, host.time);
    let mut state = null_mut();
    bencher.bench_local(|| {
        // SAFETY: the component and the state are alive.
        let done = unsafe {
            [
                fmi2GetFMUstate(component, &raw mut state),
                fmi2DoStep(component, time, STEP, FALSE),
                fmi2SetFMUstate(component, state),
            ]
        };
        assert_eq!(done, [Status::Ok; 3]);
    });
    // SAFETY: as above; freed once.
    unsafe { fmi2FreeFMUstate(component, &raw mut state) };
}

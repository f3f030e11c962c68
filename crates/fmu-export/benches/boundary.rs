//! Cost of the boundary per call: `cargo bench -p fmu-export --bench boundary`.
//!
//! The functions are called through pointers, as a host calls them that has loaded the FMU. The empty model does
//! nothing in a step, so that its times are the boundary's own; the lag shows what hardly any work adds.

use std::hint::black_box;
use std::ptr::{null, null_mut};

use divan::Bencher;
use fmu_export::declare::input;
use fmu_export::description::{self, Interface, Version};
use fmu_export::fmi2::calls;
use fmu_export::fmi2::types::{
    Boolean, CO_SIMULATION, CallbackFunctions, Component, FALSE, Real, Status, TRUE, ValueReference,
};
use fmu_export::fmi3;
use fmu_export::model::{Experiment, Fault, Info, Log, Model, Variable};
use fmu_export::units;
use lag::Lag;
use serde::{Deserialize, Serialize};

fn main() {
    divan::main();
}

/// A model whose steps do nothing.
#[derive(Clone, Default, Serialize, Deserialize)]
struct Empty {
    value: f64,
}

static VARIABLES: [Variable<Empty>; 1] = [input("value", &units::ONE, fmu_export::field!(Empty: value), "A number")];

impl Model for Empty {
    const INFO: Info = fmu_export::info!();

    fn variables() -> &'static [Variable<Self>] {
        &VARIABLES
    }

    fn initialise(&mut self, _: &Experiment<'_>, _: &mut dyn Log) -> Result<(), Fault> {
        Ok(())
    }

    fn advance(&mut self, _: f64, _: f64, _: &mut dyn Log) -> Result<(), Fault> {
        Ok(())
    }
}

/// An instance at its first communication point.
struct Host<M: Model> {
    component: Component,
    model: std::marker::PhantomData<M>,
}

impl<M: Model> Host<M> {
    fn new() -> Self {
        let guid = description::token(description::fingerprint::<M>(Version::Two, Interface::CoSimulation)) + "\0";
        let callbacks = CallbackFunctions {
            logger: None,
            allocate_memory: None,
            free_memory: None,
            step_finished: None,
            component_environment: null_mut(),
        };
        // SAFETY: all arguments are what the standard asks for.
        let component = unsafe {
            let (name, guid) = (c"bench".as_ptr(), guid.as_ptr().cast());
            let component =
                calls::fmi2Instantiate::<M>(name, CO_SIMULATION, guid, null(), &raw const callbacks, FALSE, FALSE);
            let done = [
                calls::fmi2SetupExperiment::<M>(component, FALSE, 0.0, 0.0, FALSE, 0.0),
                calls::fmi2EnterInitializationMode::<M>(component),
                calls::fmi2ExitInitializationMode::<M>(component),
            ];
            assert_eq!(done, [Status::Ok; 3]);
            component
        };
        Self { component, model: std::marker::PhantomData }
    }
}

impl<M: Model> Drop for Host<M> {
    fn drop(&mut self) {
        // SAFETY: our own component, freed once.
        unsafe { calls::fmi2FreeInstance::<M>(self.component) }
    }
}

type Step = unsafe fn(Component, Real, Real, Boolean) -> Status;
type Get = unsafe fn(Component, *const ValueReference, usize, *mut Real) -> Status;
type Set = unsafe fn(Component, *const ValueReference, usize, *const Real) -> Status;

/// A step of 1 ms.
#[divan::bench(types = [Empty, Lag], sample_size = 10_000)]
fn do_step<M: Model>(bencher: Bencher<'_, '_>) {
    let host = Host::<M>::new();
    let call: Step = black_box(calls::fmi2DoStep::<M>);
    let mut time = 0.0;
    bencher.bench_local(move || {
        // SAFETY: the component is alive.
        let status: Status = unsafe { call(host.component, time, 1e-3, TRUE) };
        time += 1e-3;
        status
    });
}

/// One real value read.
#[divan::bench(types = [Empty, Lag], sample_size = 10_000)]
fn get_real<M: Model>(bencher: Bencher<'_, '_>) {
    let host = Host::<M>::new();
    let call: Get = black_box(calls::fmi2GetReal::<M>);
    bencher.bench_local(move || {
        let mut value = 0.0;
        // SAFETY: the component is alive, and there is one value.
        let status: Status = unsafe { call(host.component, &0, 1, &raw mut value) };
        (status, value)
    });
}

/// One real input set.
#[divan::bench(types = [Empty, Lag], sample_size = 10_000)]
fn set_real<M: Model>(bencher: Bencher<'_, '_>) {
    let host = Host::<M>::new();
    let call: Set = black_box(calls::fmi2SetReal::<M>);
    bencher.bench_local(move || {
        // SAFETY: the component is alive, and there is one value.
        let status: Status = unsafe { call(host.component, &0, 1, &0.5) };
        status
    });
}

/// A step of 1 ms in FMI 3.0, of a host that does not look into it.
#[divan::bench(types = [Empty, Lag], sample_size = 10_000)]
fn do_step_of_fmi_3<M: Model>(bencher: Bencher<'_, '_>) {
    let token = description::token(description::fingerprint::<M>(Version::Three, Interface::CoSimulation)) + "\0";
    let (name, token) = (c"bench".as_ptr(), token.as_ptr().cast());
    // SAFETY: all arguments are what the standard asks for.
    let component = unsafe {
        let component = fmi3::calls::fmi3InstantiateCoSimulation::<M>(
            name,
            token,
            null(),
            0,
            0,
            0,
            1,
            null(),
            0,
            null_mut(),
            None,
            None,
        );
        let done = [
            fmi3::calls::fmi3EnterInitializationMode::<M>(component, 0, 0.0, 0.0, 0, 0.0),
            fmi3::calls::fmi3ExitInitializationMode::<M>(component),
        ];
        assert_eq!(done, [Status::Ok; 2]);
        component
    };
    let call = black_box(fmi3::calls::fmi3DoStep::<M>);
    let mut time = 0.0;
    bencher.bench_local(|| {
        let (mut event, mut end, mut early) = (0, 0, 0);
        let places = (&raw mut event, &raw mut end, &raw mut early);
        // SAFETY: the component is alive, and the places are ours.
        unsafe { call(component, time, 1e-3, 1, places.0, places.1, places.2, &raw mut time) }
    });
    // SAFETY: our own component, freed once.
    unsafe { fmi3::calls::fmi3FreeInstance::<M>(component) }
}

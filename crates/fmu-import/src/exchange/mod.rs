//! Model Exchange: the FMU gives rates, and the importer integrates them; and events, which it handles in Co-Simulation with
//! event mode, too: there the FMU takes the steps between them.
//!
//! Between two communication points the states follow a Rosenbrock method whose error is controlled in every state,
//! by its nominal value. Steps end exactly at communication points, at the time events that the FMU announces, and
//! at the crossings of its event indicators, which are found by shorter steps of the same method rather than by
//! interpolation. Inputs have their value of that time in every evaluation. Clocks of FMI 3.0 tick at events.

mod clocks;
mod equations;
mod jacobian;
mod march;
mod rosenbrock;
mod rounding;
mod sparse;

use crate::{
    call::Called,
    component::ComponentBase,
    simulation::{Experiment, Simulation, Within},
    value::{Content, Handle, Value},
};
pub use clocks::Clocks;
pub use equations::Functions;
use equations::Ramp;
pub use march::Exchange;
use march::{March, Mode};

impl Simulation for Exchange {
    fn base(&self) -> &ComponentBase {
        self.plant.model.base()
    }

    fn base_mut(&mut self) -> &mut ComponentBase {
        self.plant.model.base_mut()
    }

    fn set_up(&mut self, experiment: Experiment) -> Called {
        self.march = March::new(experiment);
        // The tolerance is that of who integrates. FMUs of Dymola warn at every point when they are told one.
        let told = Experiment { tolerance: experiment.tolerance.filter(|_| self.plant.steps()), ..experiment };
        self.plant.model.set_up(told)
    }

    fn hear(&mut self, categories: &[String]) {
        self.plant.model.hear(categories);
    }

    fn resize(&mut self, sizes: &[(u32, u64)]) -> Called {
        self.plant.model.resize(sizes)
    }

    fn initialise(&mut self, _: Within) -> Called {
        let waiting = std::mem::take(&mut self.waiting);
        let (clocks, start) = (&mut self.clocks, self.march.time);
        self.plant.model.initialise(&mut |model| {
            for (reference, value) in &waiting {
                model.set(*reference, value)?;
            }
            clocks.begin(model, start, &waiting)
        })?;
        // FMI leaves the initialisation in event mode.
        self.mode = Mode::Events;
        self.march.size(self.plant.sizes()?);
        // An end before the first step is told by that step.
        self.settle()
    }

    fn reals(&mut self, references: &[u32], into: &mut [f64]) -> Called {
        if self.clocks.are_there() {
            for (&reference, place) in references.iter().zip(into) {
                let content = Content::Real;
                *place = self.value(Handle { reference, content })?.number();
            }
            return Ok(());
        }
        self.plant.model.reals(references, into)
    }

    fn value(&mut self, handle: Handle) -> Called<Value> {
        match self.clocks.value(handle) {
            Some(value) => Ok(value),
            None => self.plant.model.value(handle),
        }
    }

    fn set(&mut self, reference: u32, value: &Value) -> Called {
        self.plant.ramps.retain(|ramp| ramp.reference != reference);
        let content = value.content();
        let handle = Handle { reference, content };
        if self.mode != Mode::New && self.clocks.hold(handle, value) {
            return Ok(());
        }
        let ticks = self.clocks.trigger(handle, value);
        if ticks == Some(false) {
            return Ok(());
        }
        let is_continuous = self.inputs.get(&handle);
        // By the standard a discrete input is set in initialisation or event mode only.
        if self.mode == Mode::New && is_continuous == Some(&false) && ticks.is_none() {
            self.waiting.push((reference, value.clone()));
            return Ok(());
        }
        // All but continuous inputs change by an event.
        if self.mode == Mode::Continuous && is_continuous != Some(&true) {
            self.plant.enter_events()?;
            self.mode = Mode::Events;
        }
        match ticks {
            Some(_) => Ok(()),
            None => self.plant.model.set(reference, value),
        }
    }

    fn set_slope(&mut self, reference: u32, slope: f64) -> Called {
        let mut value = [0.0];
        self.plant.model.reals(&[reference], &mut value)?;
        self.plant.ramps.retain(|ramp| ramp.reference != reference);
        self.plant.ramps.push(Ramp { reference, value: value[0], from: self.march.time, slope });
        Ok(())
    }

    fn step(&mut self, time: f64, step: f64) -> Called {
        self.advance(time, time + step)
    }

    fn reset(&mut self) -> Called {
        self.mode = Mode::New;
        self.plant.ramps.clear();
        self.waiting.clear();
        self.clocks.reset();
        self.march = March::default();
        self.plant.model.reset()
    }
}

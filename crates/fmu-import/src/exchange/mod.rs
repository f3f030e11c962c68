//! Model Exchange: the FMU gives rates, and the importer integrates them.
//!
//! Between two communication points the states follow a Rosenbrock method whose error is controlled in every state,
//! by its nominal value. Steps end exactly at communication points, at the time events that the FMU announces, and
//! at the crossings of its event indicators, which are found by shorter steps of the same method rather than by
//! interpolation. Inputs have their value of that time in every evaluation.

mod equations;
mod march;
mod rosenbrock;

use crate::call::Call;
use crate::component::Base;
use crate::simulation::{Experiment, Simulation};
use crate::symbols::Saved;
use crate::value::{Handle, Value};
pub(crate) use equations::Functions;
use equations::Ramp;
pub(crate) use march::Exchange;
use march::{March, Mode};

impl Simulation for Exchange {
    fn base(&self) -> &Base {
        self.plant.model.base()
    }

    fn base_mut(&mut self) -> &mut Base {
        self.plant.model.base_mut()
    }

    fn set_up(&mut self, experiment: Experiment) -> Result<(), Call> {
        self.march = March::new(experiment);
        // The tolerance is this solver's. FMUs of Dymola warn at every point when they are told one.
        let told = Experiment {
            tolerance: None,
            ..experiment
        };
        self.plant.model.set_up(told)
    }

    fn hear(&mut self, categories: &[String]) {
        self.plant.model.hear(categories);
    }

    fn initialise(&mut self, _: &[(u32, Value)]) -> Result<(), Call> {
        let waiting = std::mem::take(&mut self.waiting);
        self.plant.model.initialise(&waiting)?;
        // FMI leaves the initialisation in event mode.
        self.mode = Mode::Events;
        let sizes = self.plant.sizes()?;
        self.march.size(sizes);
        // An end before the first step is told by that step.
        self.settle()
    }

    fn reals(&mut self, references: &[u32], into: &mut [f64]) -> Result<(), Call> {
        self.plant.model.reals(references, into)
    }

    fn value(&mut self, handle: Handle) -> Result<Value, Call> {
        self.plant.model.value(handle)
    }

    fn set(&mut self, reference: u32, value: &Value) -> Result<(), Call> {
        self.plant.ramps.retain(|ramp| ramp.reference != reference);
        let content = value.content();
        let is_continuous = self.inputs.get(&Handle { reference, content });
        // By the standard a discrete input is set in initialisation or event mode only.
        if self.mode == Mode::New && is_continuous == Some(&false) {
            self.waiting.push((reference, value.clone()));
            return Ok(());
        }
        // All but continuous inputs change by an event.
        if self.mode == Mode::Continuous && is_continuous != Some(&true) {
            self.plant.enter_events()?;
            self.mode = Mode::Events;
        }
        self.plant.model.set(reference, value)
    }

    fn set_slope(&mut self, reference: u32, slope: f64) -> Result<(), Call> {
        let mut value = [0.0];
        self.plant.model.reals(&[reference], &mut value)?;
        self.plant.ramps.retain(|ramp| ramp.reference != reference);
        self.plant.ramps.push(Ramp {
            reference,
            value: value[0],
            from: self.march.time,
            slope,
        });
        Ok(())
    }

    fn step(&mut self, time: f64, step: f64) -> Result<(), Call> {
        self.advance(time, time + step)
    }

    fn reset(&mut self) -> Result<(), Call> {
        self.mode = Mode::New;
        self.plant.ramps.clear();
        self.waiting.clear();
        self.march = March::default();
        self.plant.model.reset()
    }

    /// The integrator has a state, too, which no state of the FMU holds: instances are made anew instead.
    fn save(&mut self) -> Option<Saved> {
        None
    }
}

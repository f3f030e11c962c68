//! Model Exchange: an instance whose states the host integrates; and events, which hosts see there and, if they want to, in
//! FMI 3.0 Co-Simulation.

use super::{
    instance::{Instance, finite},
    phase::Phase,
    refusal::{Outcome, Refusal},
    types::{Real, ValueReference},
};
use crate::model::{Exchange, Fault, Kind, Model, State, check_end, events, indicators, named, offered};

/// The value reference of the first state, and that of its derivative; the others follow. They are far above those of the
/// table, which may grow.
pub const STATE: ValueReference = 1_000_000_000;
/// The value reference of the first state's derivative.
pub const RATE: ValueReference = 1_100_000_000;

impl<M: Model> Instance<M> {
    fn exchange(&self) -> Outcome<&'static Exchange<M>> {
        offered::<M>().filter(|_| self.run.exchange).ok_or(Refusal::Absent("this instance is for Co-Simulation"))
    }

    /// The states, of which the host passes so many values.
    fn states_for(&self, given: usize) -> Outcome<&'static [State<M>]> {
        let states = (self.exchange()?.states)();
        count("nContinuousStates", given, states.len())?;
        Ok(states)
    }

    /// Leaves the event mode for the continuous time.
    pub fn enter_continuous(&mut self) -> Outcome {
        self.exchange()?;
        self.run.phase = Phase::Continuous;
        Ok(())
    }

    /// Enters the event mode.
    pub fn enter_event(&mut self) -> Outcome {
        if !self.run.exchange && self.event_mode.is_none() {
            return Err(Refusal::Phase(self.run.phase));
        }
        self.run.phase = Phase::Event;
        Ok(())
    }

    /// Leaves the event mode of Co-Simulation.
    pub fn enter_step(&mut self) -> Outcome {
        if self.event_mode.is_none() {
            return Err(Refusal::Absent("this instance has no event mode in Co-Simulation"));
        }
        if self.run.phase != Phase::Event {
            return Err(Refusal::Phase(self.run.phase));
        }
        self.run.phase = Phase::StepComplete;
        Ok(())
    }

    /// Handles the events of this instant: whether there were any, and the time of the next that is known. Where there were some, the
    /// host comes again: their clocks are active in that round, which ends it. It is also told that states have changed, as some
    /// hosts start their solver anew only then, and rates may have jumped.
    pub fn handle_events(&mut self) -> Outcome<(bool, Option<f64>)> {
        let Some(events) = events::<M>() else { return Ok((false, None)) };
        self.refresh()?;
        let before = self.run.model.clone();
        let (time, rounds) = self.run.at_once;
        let rounds = if time == self.run.time { rounds } else { 0 };
        let any = check_end(rounds, time).and_then(|()| (events.handle)(&mut self.run.model)).map_err(|fault| {
            self.run.model = before;
            Refusal::Step(fault)
        })?;
        self.run.at_once = (self.run.time, rounds + u32::from(any));
        self.run.stale = true;
        let next = (events.next)(&self.run.model);
        Ok((any, next.filter(|time| time.is_finite())))
    }

    /// Takes the time.
    pub fn set_time(&mut self, time: Real) -> Outcome {
        let exchange = self.exchange()?;
        finite("time", time)?;
        (exchange.set_time)(&mut self.run.model, time);
        self.run.time = time;
        self.run.stale = true;
        Ok(())
    }

    /// Takes note of a completed step, and tells whether it asks for the event mode.
    pub fn complete_step(&mut self) -> Outcome<bool> {
        let Some(complete) = self.exchange()?.complete else { return Ok(false) };
        self.refresh()?;
        Ok(complete(&mut self.run.model, &mut self.logger))
    }

    /// The number of states.
    pub fn states(&self) -> Outcome<usize> {
        Ok((self.exchange()?.states)().len())
    }

    /// Takes the states. Those that are not finite are discarded, so that a solver tries a shorter step.
    pub fn set_states(&mut self, values: &[Real]) -> Outcome {
        let states = self.states_for(values.len())?;
        if !values.iter().all(|value| value.is_finite()) {
            return Err(Refusal::Unsupported("a state is not finite"));
        }
        for (state, value) in states.iter().zip(values) {
            (state.set)(&mut self.run.model, *value);
        }
        self.run.stale = true;
        Ok(())
    }

    /// Reads the states.
    pub fn get_states(&mut self, values: &mut [Real]) -> Outcome {
        let states = self.states_for(values.len())?;
        self.start_if_needed()?;
        for (state, value) in states.iter().zip(values) {
            *value = (state.get)(&self.run.model);
        }
        Ok(())
    }

    /// Reads the states' typical magnitudes.
    pub fn get_nominals(&mut self, values: &mut [Real]) -> Outcome {
        let states = self.states_for(values.len())?;
        for (state, value) in states.iter().zip(values) {
            *value = state.nominal;
        }
        Ok(())
    }

    /// The number of event indicators.
    pub fn indicators(&self) -> Outcome<usize> {
        self.exchange()?;
        Ok(indicators::<M>().len())
    }

    /// Reads the event indicators.
    pub fn get_indicators(&mut self, values: &mut [Real]) -> Outcome {
        count("nEventIndicators", values.len(), self.indicators()?)?;
        self.refresh()?;
        for (value, name) in values.iter_mut().zip(indicators::<M>()) {
            if let Some(Kind::Real(real)) = named::<M>(name).map(|variable| &variable.kind) {
                *value = existing(name, (real.access.get)(&self.run.model))?;
            }
        }
        Ok(())
    }

    /// Reads the states' time derivatives, which do not need the outputs.
    pub fn get_rates(&mut self, values: &mut [Real]) -> Outcome {
        let states = self.states_for(values.len())?;
        self.start_if_needed()?;
        (self.exchange()?.rates)(&self.run.model, values).map_err(Refusal::Step)?;
        for (state, rate) in states.iter().zip(values) {
            existing(&format!("der({})", state.name), *rate)?;
        }
        Ok(())
    }

    /// A state or a derivative as a variable.
    pub fn state_or_rate(&self, reference: ValueReference) -> Outcome<Option<Real>> {
        let Ok(exchange) = self.exchange() else { return Ok(None) };
        let states = (exchange.states)();
        let place = |first| usize::try_from(reference.checked_sub(first)?).ok();
        if let Some(state) = place(STATE).and_then(|place| states.get(place)) {
            return Ok(Some((state.get)(&self.run.model)));
        }
        let Some(place) = place(RATE).filter(|place| *place < states.len()) else {
            return Ok(None);
        };
        let mut rates = vec![0.0; states.len()];
        (exchange.rates)(&self.run.model, &mut rates).map_err(Refusal::Step)?;
        Ok(Some(rates[place]))
    }

    /// In initialization mode the states follow from the parameters.
    fn start_if_needed(&mut self) -> Outcome {
        if self.run.phase == Phase::Initialization {
            self.refresh()?;
        }
        Ok(())
    }
}

/// A value at the host's states; where there is none, its solver tries a shorter step.
pub fn existing(name: &str, value: Real) -> Outcome<Real> {
    if value.is_finite() {
        return Ok(value);
    }
    Err(Refusal::Step(Fault::Failed(format!("{name} is {value} at these states"))))
}

/// Checks a number that the host passes.
fn count(name: &'static str, given: usize, known: usize) -> Outcome {
    if given == known {
        return Ok(());
    }
    Err(Refusal::Argument { name, value: given.to_string(), why: "it is not the number that the model has" })
}

//! The way of an FMU from one communication point to the next, with its events.

use std::{collections::HashMap, sync::Arc};

use super::{
    clocks::Clocks,
    equations::{Functions, Plant},
    rosenbrock::Rosenbrock,
    rounding::are_near,
};
use crate::{
    call::{Call, Called, EarlyEnd, Status},
    description::ExchangeSizes,
    simulation::{Experiment, Simulation},
    value::{Handle, Value},
};

/// The relative tolerance where neither the user nor the FMU states one.
const TOLERANCE: f64 = 1e-8;
/// More tries of steps than one communication step takes that gets anywhere.
const MOST_TRIES: usize = 1_000_000;
/// More events than one communication step has, unless they come faster and faster.
const MOST_EVENTS: usize = 100_000;
/// More rounds than the events of one moment take.
const MOST_ROUNDS: usize = 10_000;

/// Where a simulation stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mode {
    /// Before its initialisation.
    New,
    /// In event mode.
    Events,
    /// In continuous-time mode, or step mode.
    Continuous,
}

/// A simulation of an FMU whose events are handled here.
#[derive(Debug)]
pub struct Exchange {
    pub plant: Plant,
    /// The inputs, and whether each may be set without an event.
    pub inputs: Arc<HashMap<Handle, bool>>,
    /// The inputs that were set before the initialisation and may be set within it only.
    pub waiting: Vec<(u32, Value)>,
    pub clocks: Clocks,
    pub mode: Mode,
    pub march: March,
}

impl Exchange {
    /// One of a newly created component with these inputs, and whether each is continuous.
    pub fn new(
        model: Box<dyn Simulation>,
        functions: Functions,
        declared: ExchangeSizes,
        inputs: Arc<HashMap<Handle, bool>>,
        clocks: Clocks,
    ) -> Self {
        Self {
            plant: Plant { model, functions, declared, ramps: Vec::new() },
            inputs,
            waiting: Vec::new(),
            clocks,
            mode: Mode::New,
            march: March::default(),
        }
    }
}

/// The integrator's state.
#[derive(Debug, Default)]
pub struct March {
    /// An FMU refuses times after its stop.
    experiment: Experiment,
    method: Rosenbrock,
    pub time: f64,
    states: Vec<f64>,
    nominals: Vec<f64>,
    /// The event indicators at the present time.
    indicators: Vec<f64>,
    /// The step that suits the solution, s; 0 where that is not known.
    step: f64,
    /// The next event that is known beforehand, s.
    next: Option<f64>,
    /// Whether the FMU has ended the simulation.
    ended: bool,
}

impl March {
    /// At the beginning of an experiment.
    pub fn new(experiment: Experiment) -> Self {
        Self { time: experiment.start, experiment, ..Self::default() }
    }

    /// Makes room for so many states and event indicators.
    pub fn size(&mut self, [states, indicators]: [usize; 2]) {
        self.method = Rosenbrock::new(states);
        self.states = vec![0.0; states];
        self.nominals = vec![1.0; states];
        self.indicators = vec![0.0; indicators];
    }

    /// The error allowed in each state.
    fn allowed(&self) -> Vec<f64> {
        let tolerance = self.experiment.tolerance.unwrap_or(TOLERANCE);
        self.states.iter().zip(&self.nominals).map(|(state, nominal)| tolerance * state.abs().max(*nominal)).collect()
    }
}

/// Whether an indicator has changed its side: above zero, or not.
fn crossed(before: &[f64], after: &[f64]) -> bool {
    let mut pairs = before.iter().zip(after);
    pairs.any(|(before, after)| (*before > 0.0) != (*after > 0.0))
}

/// A step that was taken: its length, s, and the states at its end.
struct Taken {
    length: f64,
    states: Vec<f64>,
    /// Whether an event indicator has changed its side.
    crossed: bool,
}

impl Exchange {
    /// Follows the equations from one communication point to another, s.
    pub fn advance(&mut self, from: f64, to: f64) -> Called {
        // By rounding, the last step may have ended a little later; time never goes back for an FMU.
        let reached = self.march.time;
        self.march.time = if are_near(reached, from) { reached.max(from) } else { from };
        let mut events = 0;
        self.clocks.pass_point();
        if self.mode == Mode::Events {
            self.settle()?;
        } else {
            // An input may have taken an indicator to its other side.
            self.plant.place(self.march.time, &self.march.states)?;
            if self.has_crossed()? {
                self.events()?;
            }
        }
        while self.march.time < self.goal(to) && !self.march.ended {
            let to = self.goal(to);
            let (time, cuts) = (self.march.time, !self.plant.declared.even_steps);
            let next = self.march.next.filter(|next| *next < to && (cuts || *next <= time));
            let is_due = |time: f64| next.is_some_and(|next| next <= time);
            let mut event = is_due(self.march.time);
            if !event {
                event = self.stride(next.unwrap_or(to))? || is_due(self.march.time);
            }
            if event && !self.march.ended {
                self.events()?;
                events += 1;
            }
            if events > MOST_EVENTS {
                return Err(self.plant.failed(format!("more than {MOST_EVENTS} events between {from} s and {to} s")));
            }
        }
        // An event at the communication point itself belongs to it.
        let due = self.march.next.is_some_and(|next| next <= self.goal(to));
        if due && !self.march.ended {
            self.events()?;
        }
        if self.march.ended {
            let at = self.march.time;
            return Err(Call {
                function: self.plant.step(),
                status: Status::Discard,
                message: Some("the FMU wants no further step".to_owned()),
                ended: Some(EarlyEnd { from, at }),
            });
        }
        Ok(())
    }

    /// The end of a step to a time, s: the next event or the stop where the two differ by rounding only.
    fn goal(&self, to: f64) -> f64 {
        let stop = self.march.experiment.stop;
        match self.march.next.filter(|next| are_near(*next, to) && *next <= stop) {
            Some(next) => next,
            None if are_near(to, stop) => to.min(stop),
            None => to,
        }
    }

    /// Whether an indicator is on another side than it was.
    fn has_crossed(&mut self) -> Called<bool> {
        let mut now = vec![0.0; self.march.indicators.len()];
        self.plant.indicators(&mut now)?;
        Ok(crossed(&self.march.indicators, &now))
    }

    /// Handles the events of the present time.
    fn events(&mut self) -> Called {
        self.plant.enter_events()?;
        self.mode = Mode::Events;
        self.settle()
    }

    /// Makes rounds of events until nothing changes, and leaves event mode, unless the FMU ends the simulation.
    pub fn settle(&mut self) -> Called {
        // At first no states have been read.
        let is_first = self.march.step == 0.0;
        let (mut states, mut nominals) = (is_first, is_first);
        let time = self.march.time;
        for round in 0.. {
            self.clocks.tick(&mut *self.plant.model, time)?;
            let update = self.plant.update()?;
            states |= update.states;
            nominals |= update.nominals;
            if update.ends {
                self.march.ended = true;
                return Ok(());
            }
            let ticks_again = self.clocks.follow(&mut *self.plant.model, time)?;
            let next = update.next.into_iter().chain(self.clocks.next());
            self.march.next = next.min_by(f64::total_cmp);
            if !update.again && !ticks_again {
                break;
            }
            if round == MOST_ROUNDS {
                return Err(self.plant.failed(format!("the events at {time} s do not settle in {MOST_ROUNDS} rounds")));
            }
        }
        self.plant.leave_events()?;
        self.mode = Mode::Continuous;
        let march = &mut self.march;
        let has_states = !march.states.is_empty();
        if has_states && states {
            self.plant.states(&mut march.states)?;
        }
        if has_states && nominals {
            self.plant.nominals(&mut march.nominals)?;
            for nominal in &mut march.nominals {
                *nominal = match nominal.abs() {
                    size if size > 0.0 && size.is_finite() => size,
                    _ => 1.0,
                };
            }
        }
        if is_first {
            // What is left of it the FMU never wrote.
            march.indicators.fill(f64::NAN);
        }
        self.plant.indicators(&mut march.indicators)?;
        let counted = march.indicators.len();
        let written = march.indicators.iter().filter(|indicator| !indicator.is_nan()).count();
        if is_first && written < counted {
            let text =
                format!("the description counts {counted} event indicators, of which the FMU computes {written}");
            self.plant.model.base_mut().caller.log.returned_warning(&text);
        }
        Ok(())
    }

    /// Takes one step towards a time, s. Whether an event is to be handled at its end.
    fn stride(&mut self, to: f64) -> Called<bool> {
        if self.plant.steps() {
            let (time, step) = (self.march.time, to - self.march.time);
            let (reached, event) = self.plant.model.part(time, step)?;
            self.march.time = if reached == time + step { to } else { reached };
            return Ok(event);
        }
        let Taken { length, states, crossed } = self.taken(to)?;
        let march = &mut self.march;
        march.time = if length == to - march.time { to } else { march.time + length };
        march.states = states;
        self.plant.place(march.time, &march.states)?;
        let [event, ends] = self.plant.completed()?;
        march.ended |= ends;
        if !crossed && !event {
            self.plant.indicators(&mut march.indicators)?;
        }
        Ok(crossed || event)
    }

    /// Finds a step whose error is allowed, and cuts it where an event indicator changes its side.
    fn taken(&mut self, to: f64) -> Called<Taken> {
        let time = self.march.time;
        let left = to - time;
        let least = 8.0 * f64::EPSILON * time.abs().max(to.abs());
        if self.march.step <= 0.0 {
            self.march.step = left;
        }
        self.linearise(to)?;
        let allowed = self.march.allowed();
        let mut end = vec![0.0; self.march.states.len()];
        for _ in 0..MOST_TRIES {
            // No sliver is left for the last step.
            let step = self.march.step;
            let h = if step >= left {
                left
            } else if 2.0 * step > left {
                0.5 * left
            } else {
                step
            };
            let error = self.attempt(h, &allowed, &mut end)?;
            let fits = error.is_some_and(|error| error <= 1.0);
            let factor = error.map_or(0.1, |error| 0.9 * error.max(1e-10).powf(-0.25));
            let next = h * factor.clamp(0.1, 5.0);
            if fits {
                // A step cut short by its end says nothing against the longer one.
                self.march.step = if h < step { next.max(step) } else { next };
                return self.cut(h, &allowed, end);
            }
            self.march.step = next.min(0.9 * h);
            if self.march.step < least && h < left {
                return Err(self.plant.failed(format!(
                    "the internal step fell below {least:.1e} s at {time} s: then the rates are no numbers or too rough"
                )));
            }
        }
        Err(self.plant.failed(format!("more than {MOST_TRIES} tries of a step at {time} s")))
    }

    /// Cuts a step at the first moment, to the resolution of time, after which an indicator has changed its side.
    fn cut(&mut self, length: f64, allowed: &[f64], states: Vec<f64>) -> Called<Taken> {
        let mut taken = Taken { length, crossed: self.crosses(length, &states)?, states };
        if !taken.crossed {
            return Ok(taken);
        }
        let resolution = 4.0 * f64::EPSILON * self.march.time.abs().max(length);
        let (mut before, mut after) = (0.0, length);
        let mut trial = vec![0.0; self.march.states.len()];
        while after - before > resolution {
            let h = 0.5 * (before + after);
            if h <= before || h >= after {
                break;
            }
            let known = self.attempt(h, allowed, &mut trial)?;
            if known.is_some() && !self.crosses(h, &trial)? {
                before = h;
            } else if known.is_some() {
                after = h;
                taken.states.copy_from_slice(&trial);
            } else {
                break;
            }
        }
        taken.length = after;
        Ok(taken)
    }

    /// Whether an indicator has changed its side after a step.
    fn crosses(&mut self, h: f64, states: &[f64]) -> Called<bool> {
        if self.march.indicators.is_empty() {
            return Ok(false);
        }
        self.plant.place(self.march.time + h, states)?;
        self.has_crossed()
    }

    /// Linearises at the present time; no rates are asked for after `to`, s.
    fn linearise(&mut self, to: f64) -> Called {
        let Self { plant, march, .. } = self;
        let (time, ahead) = (march.time, march.step.min(to - march.time));
        let mut rates = |t: f64, x: &[f64], into: &mut [f64]| plant.rates_at(t, x, into);
        let method = &mut march.method;
        let computed = method.linearise(&mut rates, time, &march.states, &march.nominals, ahead)?;
        let why = match method.unfit() {
            _ if !computed => format!("the FMU refuses to compute rates at {time} s, or with a state a little changed"),
            Some((state, rate)) => {
                format!("the rate of the continuous state {state} is {rate} at {time} s")
            }
            None => return Ok(()),
        };
        Err(plant.failed(why))
    }

    fn attempt(&mut self, h: f64, allowed: &[f64], end: &mut [f64]) -> Called<Option<f64>> {
        let Self { plant, march, .. } = self;
        let rates = &mut |t: f64, x: &[f64], into: &mut [f64]| plant.rates_at(t, x, into);
        march.method.attempt(rates, march.time, &march.states, h, allowed, end)
    }
}

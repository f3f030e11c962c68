//! The clocks of FMI 3.0: when they tick, and the variables that are set and computed at their ticks.
//!
//! Time-based clocks tick by themselves, triggered inputs where they are set. A clocked input that is set waits for the next
//! tick; between ticks a clocked variable has its value of the last one.

use std::{collections::HashMap, ffi::c_int};

use super::rounding::are_near;
use crate::{
    call::{Call, Called, Status},
    description::{Causality, Description, Kind, Ticking, Timing, Variable},
    simulation::Simulation,
    symbols::{Component, Function, Symbols},
    value::{Content, Handle, Value},
};

/// An interval that is not yet known, and one that is new, as `fmi3IntervalQualifier` numbers them.
const NOT_YET_KNOWN: c_int = 0;
const CHANGED: c_int = 2;

#[derive(Clone, Copy, Debug)]
struct Functions {
    get: Function<unsafe extern "C" fn(Component, *const u32, usize, *mut u8) -> c_int>,
    set: Function<unsafe extern "C" fn(Component, *const u32, usize, *const u8) -> c_int>,
    get_interval: Function<unsafe extern "C" fn(Component, *const u32, usize, *mut f64, *mut c_int) -> c_int>,
    get_shift: Function<unsafe extern "C" fn(Component, *const u32, usize, *mut f64) -> c_int>,
}

impl Functions {
    /// Which of these clocks are active.
    fn active(self, model: &mut dyn Simulation, clocks: &[u32]) -> Called<Vec<bool>> {
        let mut active = vec![0; clocks.len()];
        let into = active.as_mut_ptr();
        // SAFETY: the component is alive, and there is room for as many flags as clocks.
        model.base_mut().call(self.get, |get, of| unsafe { get(of, clocks.as_ptr(), clocks.len(), into) })?;
        Ok(active.iter().map(|flag| *flag != 0).collect())
    }

    fn activate(self, model: &mut dyn Simulation, clocks: &[u32]) -> Called {
        let active = vec![1; clocks.len()];
        // SAFETY: the component is alive, and there are as many flags as clocks.
        model.base_mut().call(self.set, |set, of| unsafe { set(of, clocks.as_ptr(), clocks.len(), active.as_ptr()) })
    }

    /// The interval of a clock, s, with its qualifier.
    fn interval(self, model: &mut dyn Simulation, clock: u32) -> Called<(f64, c_int)> {
        let (mut interval, mut qualifier) = (0.0, CHANGED);
        // SAFETY: the component is alive, and all three places are of one element.
        model.base_mut().call(self.get_interval, |get, of| unsafe {
            get(of, &raw const clock, 1, &raw mut interval, &raw mut qualifier)
        })?;
        let is_time = interval >= 0.0;
        if qualifier != NOT_YET_KNOWN && !is_time {
            return Err(Call::impossible(
                self.get_interval.name,
                format!("the interval {interval} s of the clock {clock} is no time"),
            ));
        }
        Ok((interval, qualifier))
    }

    fn shift(self, model: &mut dyn Simulation, clock: u32) -> Called<f64> {
        let mut shift = 0.0;
        // SAFETY: the component is alive, and both places are of one element.
        model.base_mut().call(self.get_shift, |get, of| unsafe { get(of, &raw const clock, 1, &raw mut shift) })?;
        Ok(shift)
    }
}

/// A clock of a simulation.
#[derive(Clone, Debug)]
struct Clock {
    reference: u32,
    handle: Handle,
    is_input: bool,
    timing: Timing,
    /// The variables that it computes, and the inputs that are set at its ticks.
    clocked: Vec<Handle>,
    /// The time of the next tick, where it is known, s.
    next: Option<f64>,
    /// The tick from which periods count, the ticks since then with itself, and the period, s.
    first: f64,
    ticks: u32,
    interval: f64,
    is_active: bool,
    has_ticked: bool,
}

impl Clock {
    fn is_periodic(&self) -> bool {
        use Ticking::{Constant, Fixed, Tunable};
        matches!(self.timing.by, Constant | Fixed | Tunable)
    }

    /// The time of the tick of a period.
    fn tick(&self, number: u32) -> f64 {
        self.first + f64::from(number) * self.interval
    }

    fn is_due(&self, time: f64) -> bool {
        self.next.is_some_and(|next| next <= time || are_near(next, time))
    }

    /// Takes the present tick for done.
    fn pass(&mut self) {
        self.ticks += 1;
        self.next = self.is_periodic().then(|| self.tick(self.ticks));
    }

    /// Asks for the first tick after a start, s.
    fn begin(&mut self, functions: Functions, model: &mut dyn Simulation, start: f64) -> Called {
        if self.timing.by == Ticking::Triggered {
            return Ok(());
        }
        let (interval, qualifier) = match self.timing.interval {
            Some(interval) => (interval, CHANGED),
            None => functions.interval(model, self.reference)?,
        };
        if !self.is_periodic() {
            self.next = (qualifier != NOT_YET_KNOWN).then_some(start + interval);
            return Ok(());
        }
        let is_period = interval > 0.0;
        if !is_period {
            return Err(Call::impossible(
                functions.get_interval.name,
                format!("the clock {} has a period of {interval} s", self.reference),
            ));
        }
        let shift = match (self.timing.shift, self.timing.interval) {
            (Some(shift), _) => shift,
            (None, Some(_)) => 0.0,
            (None, None) => functions.shift(model, self.reference)?,
        };
        (self.first, self.ticks, self.interval) = (start + shift, 0, interval);
        self.next = Some(self.first);
        Ok(())
    }

    /// Asks for the next tick after a round of events at a time, s, where that may have become known.
    fn follow(&mut self, functions: Functions, model: &mut dyn Simulation, time: f64) -> Called {
        let may_be_new = match self.timing.by {
            Ticking::Changing => self.is_active,
            Ticking::Countdown => true,
            Ticking::Tunable => self.timing.interval.is_none(),
            _ => false,
        };
        if !may_be_new {
            return Ok(());
        }
        let (interval, qualifier) = functions.interval(model, self.reference)?;
        if self.is_periodic() {
            if qualifier == CHANGED && interval > 0.0 && interval != self.interval {
                // From now on, as the standard says since its issue 2050; a first tick that is still to come keeps its time.
                if self.ticks > 0 {
                    (self.first, self.ticks) = (time, 1);
                }
                self.interval = interval;
                self.next = Some(self.tick(self.ticks));
            }
        } else if qualifier == CHANGED || self.is_active && qualifier != NOT_YET_KNOWN {
            self.next = Some(time + interval);
        }
        Ok(())
    }
}

/// What a variable has before the first tick that gives it a value.
fn blank(content: Content) -> Value {
    match content {
        Content::Real => Value::Real(f64::NAN),
        Content::Text => Value::String(String::new()),
        other => other.value(0.0),
    }
}

/// The clocks of an FMU, and their variables.
#[derive(Clone, Debug, Default)]
pub struct Clocks {
    functions: Option<Functions>,
    all: Vec<Clock>,
    /// The clocked inputs with their start values: what was set is known, and needs no reading.
    inputs: HashMap<Handle, Value>,
    /// The values of clocked variables at their last ticks.
    values: HashMap<Handle, Value>,
    /// The clocked inputs that wait for a tick.
    held: Vec<(Handle, Value)>,
}

impl Clocks {
    /// Those of a description; none where there are none.
    pub fn find(symbols: &Symbols, description: &Description) -> Self {
        let mut all: Vec<Clock> = Vec::new();
        for variable in description.variables.values() {
            let (reference, handle) = (variable.value_reference, variable.handle());
            let Kind::Clock(timing) = variable.kind else { continue };
            // A clock may have several names.
            if all.iter().any(|clock| clock.handle == handle) {
                continue;
            }
            let clocked = description.variables.values().filter(|other| other.clocks.contains(&reference));
            all.push(Clock {
                reference,
                handle,
                is_input: variable.causality == Causality::Input,
                timing,
                clocked: clocked.map(|other| other.handle()).collect(),
                next: None,
                first: 0.0,
                ticks: 0,
                interval: f64::INFINITY,
                is_active: false,
                has_ticked: false,
            });
        }
        if all.is_empty() {
            return Self::default();
        }
        let inputs =
            description.variables.values().filter(|one| one.causality == Causality::Input && !one.clocks.is_empty());
        let start = |one: &Variable| one.kind.start_value().unwrap_or_else(|| blank(one.handle().content));
        Self {
            inputs: inputs.map(|one| (one.handle(), start(one))).collect(),
            functions: Some(Functions {
                get: symbols.find("GetClock"),
                set: symbols.find("SetClock"),
                get_interval: symbols.find("GetIntervalDecimal"),
                get_shift: symbols.find("GetShiftDecimal"),
            }),
            all,
            ..Self::default()
        }
    }

    pub fn are_there(&self) -> bool {
        !self.all.is_empty()
    }

    /// The present value of a clock, or of a variable of one.
    pub fn value(&self, handle: Handle) -> Option<Value> {
        let clock = self.all.iter().find(|clock| clock.handle == handle);
        clock.map(|clock| Value::Boolean(clock.has_ticked)).or_else(|| self.values.get(&handle).cloned())
    }

    /// Keeps the value of a clocked input for the next tick; whether it is one.
    pub fn hold(&mut self, handle: Handle, value: &Value) -> bool {
        let is_clocked = self.all.iter().any(|clock| clock.clocked.contains(&handle));
        if is_clocked {
            self.held.retain(|(other, _)| *other != handle);
            self.held.push((handle, value.clone()));
        }
        is_clocked
    }

    /// Lets a triggered input tick at the next event where it is set to yes; whether it does, or `None` for what is no clock.
    pub fn trigger(&mut self, handle: Handle, value: &Value) -> Option<bool> {
        let mut clocks = self.all.iter_mut();
        let clock = clocks.find(|clock| clock.is_input && clock.handle == handle)?;
        let ticks = *value == Value::Boolean(true);
        clock.next = ticks.then_some(f64::NEG_INFINITY);
        Some(ticks)
    }

    /// Asks for the first ticks, and reads what clocks compute, in initialisation mode; `set` are the inputs set before.
    pub fn begin(&mut self, model: &mut dyn Simulation, start: f64, set: &[(u32, Value)]) -> Called {
        let Some(functions) = self.functions else { return Ok(()) };
        for clock in self.all.iter_mut().filter(|clock| clock.is_input) {
            clock.begin(functions, model, start)?;
        }
        self.values.extend(self.inputs.iter().map(|(handle, value)| (*handle, value.clone())));
        for (reference, value) in set {
            let handle = Handle { reference: *reference, content: value.content() };
            self.values.entry(handle).and_modify(|known| known.clone_from(value));
        }
        let clocked = self.all.iter().flat_map(|clock| &clock.clocked);
        for handle in clocked.filter(|handle| !self.inputs.contains_key(handle)) {
            let value = match model.value(*handle) {
                // It has none before the first tick.
                Err(call) if call.status == Status::Discard => blank(handle.content),
                told => told?,
            };
            self.values.insert(*handle, value);
        }
        Ok(())
    }

    /// Lets the inputs tick that are due at a time, s, with the inputs that wait for them, and reads what ticks compute.
    pub fn tick(&mut self, model: &mut dyn Simulation, time: f64) -> Called {
        let Some(functions) = self.functions else { return Ok(()) };
        for clock in &mut self.all {
            clock.is_active = clock.is_due(time);
            if clock.is_active {
                clock.pass();
            }
        }
        let references = |wanted: fn(&&Clock) -> bool| -> Vec<u32> {
            self.all.iter().filter(wanted).map(|clock| clock.reference).collect()
        };
        let due = references(|clock| clock.is_active);
        let own = references(|clock| !clock.is_input);
        if !due.is_empty() {
            functions.activate(model, &due)?;
        }
        self.set_held(model)?;
        if !own.is_empty() {
            let active = functions.active(model, &own)?;
            let clocks = self.all.iter_mut().filter(|clock| !clock.is_input);
            for (clock, is_active) in clocks.zip(active) {
                clock.is_active = is_active;
            }
        }
        for clock in self.all.iter_mut().filter(|clock| clock.is_active) {
            clock.has_ticked = true;
            for handle in clock.clocked.iter().filter(|handle| !self.inputs.contains_key(handle)) {
                self.values.insert(*handle, model.value(*handle)?);
            }
        }
        Ok(())
    }

    /// Sets the inputs that waited for a clock that is active now.
    fn set_held(&mut self, model: &mut dyn Simulation) -> Called {
        for (handle, value) in std::mem::take(&mut self.held) {
            let mut clocks = self.all.iter();
            if clocks.any(|clock| clock.is_active && clock.clocked.contains(&handle)) {
                model.set(handle.reference, &value)?;
                self.values.insert(handle, value);
            } else {
                self.held.push((handle, value));
            }
        }
        Ok(())
    }

    /// Asks for the next ticks after a round of events at a time, s; whether that has one at the same time.
    pub fn follow(&mut self, model: &mut dyn Simulation, time: f64) -> Called<bool> {
        let Some(functions) = self.functions else { return Ok(false) };
        for clock in self.all.iter_mut().filter(|clock| clock.is_input) {
            clock.follow(functions, model, time)?;
        }
        // A periodic clock ticks once in an event mode.
        let mut clocks = self.all.iter();
        Ok(clocks.any(|clock| !clock.is_periodic() && clock.is_due(time)))
    }

    /// When the next tick is, s.
    pub fn next(&self) -> Option<f64> {
        self.all.iter().filter_map(|clock| clock.next).min_by(f64::total_cmp)
    }

    /// Forgets what has ticked up to a communication point.
    pub fn pass_point(&mut self) {
        for clock in &mut self.all {
            clock.has_ticked = false;
        }
    }

    /// As before a simulation.
    pub fn reset(&mut self) {
        self.values.clear();
        self.held.clear();
        for clock in &mut self.all {
            (clock.next, clock.is_active, clock.has_ticked) = (None, false, false);
        }
    }
}

//! Events: instants at which a model changes its equations or what is discrete in it.

use super::{Fault, Log, Model};

/// More events than one instant has.
const MOST_AT_ONCE: u32 = 10_000;

/// What a boundary needs to know of a model with events, for [`Model::EVENTS`].
pub struct Events<M: 'static> {
    /// Model Exchange: the names of real variables, by the changes of whose signs the host finds the events of the states.
    pub indicators: &'static [&'static str],
    /// The time of the next event that is known beforehand, s.
    pub next: fn(&M) -> Option<f64>,
    /// Lets at most so many seconds pass from a time, as [`Model::advance`] does, and stops at the first instant at which an
    /// event is due, be it the last one: then it says how many have passed.
    pub until: Until<M>,
    /// Handles all events that are due at the present time and state; whether there were any. The clocks have ticked that it
    /// lets tick, until the next call.
    pub handle: fn(&mut M) -> Result<bool, Fault>,
}

/// The type of [`Events::until`].
pub type Until<M> = fn(&mut M, f64, f64, &mut dyn Log) -> Result<Option<f64>, Fault>;

impl<M: Model> Events<M> {
    /// [`Model::advance`] of a model with events: from one to the next.
    ///
    /// # Errors
    /// Those of [`until`](Self::until) and [`handle`](Self::handle), and where the events of an instant do not end. The model
    /// is as before then.
    pub fn pass(
        &self,
        model: &mut M,
        time: f64,
        step: f64,
        log: &mut dyn Log,
    ) -> Result<(), Fault> {
        let before = model.clone();
        let passed = self.pass_all(model, time, step, log);
        passed.inspect_err(|_| *model = before)
    }

    fn pass_all(
        &self,
        model: &mut M,
        time: f64,
        step: f64,
        log: &mut dyn Log,
    ) -> Result<(), Fault> {
        let (mut passed, mut at_once) = (0.0, 0);
        while let Some(part) = (self.until)(model, time + passed, step - passed, log)? {
            (self.handle)(model)?;
            if passed + part >= step {
                break;
            }
            at_once = if part > 0.0 { 0 } else { at_once + 1 };
            if at_once == MOST_AT_ONCE {
                let at = time + passed;
                let why = format!(
                    "the events at {at} s do not end: handling one must change what makes it due"
                );
                return Err(Fault::Failed(why));
            }
            passed += part;
        }
        Ok(())
    }
}

/// The names of a model's event indicators.
pub fn indicators<M: Model>() -> &'static [&'static str] {
    events::<M>().map_or(&[], |events| events.indicators)
}

/// A model's events, if it has any.
pub fn events<M: Model>() -> Option<&'static Events<M>> {
    const { &M::EVENTS }.as_ref()
}

//! Events: instants at which a model changes its equations or what is discrete in it.

use super::{Fault, Log, Model};

/// More events than one instant has.
const MOST_AT_ONCE: u32 = 10_000;

/// What a boundary needs to know of a model with events, for [`Model::EVENTS`].
///
/// The model keeps its own time: [`Model::initialise`], [`until`](Self::until) and, in Model Exchange,
/// [`Continuous::set_time`](super::Continuous::set_time) set it. Events of the start belong to `initialise`, as hosts that do not see
/// events never have them handled.
pub struct Events<M: 'static> {
    /// Model Exchange: the names of real variables, by the changes of whose signs the host finds the events of the states.
    pub indicators: &'static [&'static str],
    /// The time of the next event that is known beforehand, s.
    pub next: fn(&M) -> Option<f64>,
    /// Lets at most so many seconds pass from a time, perhaps none, as [`Model::advance`] does. It stops where an event is due, also
    /// at the end, and returns the seconds that have passed until then; `None` if no event is due.
    pub until: Until<M>,
    /// Handles all events that are due at the present time and state, and tells whether there were any. Hosts stop a little before or
    /// after an event, so compare with a margin. A clock that ticks here counts as active until the next call.
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
    pub fn pass(&self, model: &mut M, time: f64, step: f64, log: &mut dyn Log) -> Result<(), Fault> {
        let before = model.clone();
        self.pass_all(model, time, step, log).inspect_err(|_| *model = before)
    }

    fn pass_all(&self, model: &mut M, time: f64, step: f64, log: &mut dyn Log) -> Result<(), Fault> {
        let (mut passed, mut at_once) = (0.0, 0);
        // After an event at the end, too: handling it may have made another one due.
        while let Some(part) = self.stop(model, time + passed, step - passed, log)? {
            passed = (passed + part).min(step);
            (self.handle)(model)?;
            // What is less than the spacing of the times is no progress.
            let stays = part <= f64::EPSILON * (time.abs() + step);
            at_once = if stays { at_once + 1 } else { 0 };
            check_end(at_once, time + passed)?;
        }
        Ok(())
    }

    /// [`until`](Self::until), with a check of what it returns: seconds, not a time.
    pub(crate) fn stop(&self, model: &mut M, time: f64, step: f64, log: &mut dyn Log) -> Result<Option<f64>, Fault> {
        let Some(part) = (self.until)(model, time, step, log)? else { return Ok(None) };
        let rounding = 1e-9 * step + 4.0 * f64::EPSILON * time.abs();
        if (-rounding..=step + rounding).contains(&part) {
            return Ok(Some(part.clamp(0.0, step)));
        }
        Err(Fault::Failed(format!("`until` has stopped after {part} s of a step of {step} s from {time} s")))
    }
}

/// Refuses more events than one instant has.
pub fn check_end(at_once: u32, time: f64) -> Result<(), Fault> {
    if at_once < MOST_AT_ONCE {
        return Ok(());
    }
    Err(Fault::Failed(format!(
        "the events at {time} s do not end: handling one must change what makes it due, and what comes ever faster must come to rest"
    )))
}

/// The names of a model's event indicators.
pub fn indicators<M: Model>() -> &'static [&'static str] {
    events::<M>().map_or(&[], |events| events.indicators)
}

/// A model's events, if it has any.
pub fn events<M: Model>() -> Option<&'static Events<M>> {
    const { &M::EVENTS }.as_ref()
}

//! Continuous states, for models whose differential equations another solver may integrate.

use super::{Fault, Log, Model, Unit};

/// A continuous state of a model.
pub struct State<M: 'static> {
    /// The structured name, such as `state.angle`; no variable of the table has it.
    pub name: &'static str,
    /// One sentence for users.
    pub description: &'static str,
    /// The unit.
    pub unit: &'static Unit,
    /// The unit of its time derivative.
    pub rate_unit: &'static Unit,
    /// A typical magnitude, by which solvers scale their errors; above 0.
    pub nominal: f64,
    /// Reads it.
    pub get: fn(&M) -> f64,
    /// Writes it.
    pub set: fn(&mut M, f64),
}

/// A model whose state can be given to it from outside at any instant, so that its host may integrate it (Model Exchange).
///
/// The boundary calls [`Model::initialise`] and [`allow`](Continuous::allow) at the start. After that it never calls
/// [`Model::advance`]: it sets time, states and inputs, and reads [`rates`](Continuous::rates) and, after
/// [`Model::update`], the variables. Between two [events](Model::EVENTS) the rates must be smooth in time, states and inputs.
pub trait Continuous: Model {
    /// The states, in the order in which hosts know them.
    fn states() -> &'static [State<Self>];

    /// Names of outputs that need the model's own steps, such as means over a turn: Model Exchange leaves them out.
    fn without() -> &'static [&'static str] {
        &[]
    }

    /// Takes note of a step that the host's solver has completed, if the model wants to know of them: at the time and states that
    /// are set, after [`Model::update`]. Whether what is discrete has changed: the host then enters the event mode.
    const COMPLETE: Option<Complete<Self>> = None;

    /// Whether the parameters that were chosen allow it.
    ///
    /// # Errors
    /// When they choose a part of the model that has states of another kind; the message should name the remedy.
    fn allow(&self) -> Result<(), Fault> {
        Ok(())
    }

    /// Sets the time, s.
    fn set_time(&mut self, time: f64);

    /// The time derivatives of the states, per second, into as many places. They depend on time, states, inputs and
    /// parameters alone, and not on the calls before.
    ///
    /// # Errors
    /// [`Fault::Failed`] where they do not exist; the host then tries a shorter step.
    fn rates(&self, rates: &mut [f64]) -> Result<(), Fault>;
}

/// The type of [`Continuous::COMPLETE`].
pub type Complete<M> = fn(&mut M, &mut dyn Log) -> bool;

/// The functions of [`Continuous`] that the boundary calls, for [`Model::EXCHANGE`].
pub struct Exchange<M: 'static> {
    /// [`Continuous::states`].
    pub states: fn() -> &'static [State<M>],
    /// [`Continuous::without`].
    pub without: fn() -> &'static [&'static str],
    /// [`Continuous::COMPLETE`].
    pub complete: Option<Complete<M>>,
    /// [`Continuous::allow`].
    pub allow: fn(&M) -> Result<(), Fault>,
    /// [`Continuous::set_time`].
    pub set_time: fn(&mut M, f64),
    /// [`Continuous::rates`].
    pub rates: fn(&M, &mut [f64]) -> Result<(), Fault>,
}

impl<M: Continuous> Exchange<M> {
    /// The model's own.
    pub const fn of() -> Self {
        Self {
            states: M::states,
            without: M::without,
            complete: M::COMPLETE,
            allow: M::allow,
            set_time: M::set_time,
            rates: M::rates,
        }
    }
}

/// A model's functions for Model Exchange, if it has them.
pub fn offered<M: Model>() -> Option<&'static Exchange<M>> {
    const { &M::EXCHANGE }.as_ref()
}

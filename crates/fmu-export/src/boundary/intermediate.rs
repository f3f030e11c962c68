//! Intermediate updates of FMI 3.0 Co-Simulation: the host looks into a communication step.
//!
//! The boundary advances the model by its [inner steps](Model::INNER_STEP) and calls the host after each of them. During the
//! callback the host may call this instance again, so no reference to it may be held: a step pauses, the caller asks the host,
//! and the step goes on with the answer.

use super::{
    instance::Instance,
    phase::Phase,
    refusal::{Outcome, Refusal},
    run::Run,
    types::{ComponentEnvironment, IntermediateUpdateCallback, ValueReference},
    values::{all_elements, variable},
    watch::{Underway, Watch},
};
use crate::model::{Kind, Model, Role, Variable};

/// The most updates in a communication step: where a model takes more inner steps, an update comes after several of them.
const MOST_UPDATES: f64 = 1000.0;

/// A call of the host that is due.
pub struct Update {
    callback: IntermediateUpdateCallback,
    environment: ComponentEnvironment,
    time: f64,
    /// Whether something of the step is left, so that inputs matter.
    more: bool,
    /// Whether the step can end here.
    early: bool,
}

/// Whether and when the host wants a step to end.
pub type Answer = Option<f64>;

impl Update {
    /// Calls the host. An answer counts only if it was allowed.
    pub fn ask(self) -> Answer {
        let (mut requested, mut at) = (0, self.time);
        let (more, early) = (self.more, self.early);
        // SAFETY: the host vouches for its callback when it instantiates; the places live until it returns.
        unsafe {
            (self.callback)(self.environment, self.time, more, true, true, early, &raw mut requested, &raw mut at);
        }
        (early && requested != 0).then_some(at)
    }
}

/// Whether hosts may access a variable within steps: continuous inputs and outputs.
pub fn is_intermediate<M: Model>(variable: &Variable<M>) -> bool {
    M::INNER_STEP.is_some()
        && matches!(variable.kind, Kind::Real(_))
        && matches!(variable.role, Role::Input | Role::Output)
}

impl<M: Model> Watch<M> {
    /// Takes what the host has said when it made the instance.
    pub fn new(
        callback: IntermediateUpdateCallback,
        environment: ComponentEnvironment,
        early: bool,
        variables: &[ValueReference],
        inner_step: fn(&M, f64) -> f64,
    ) -> Outcome<Self> {
        let mut variables = all_elements::<M>(variables).into_owned();
        variables.sort_unstable();
        for reference in &variables {
            let variable = variable::<M>(*reference)?;
            if !is_intermediate(variable) {
                let (name, why) = (variable.name, "it has no intermediateUpdate attribute");
                return Err(Refusal::NotIntermediate { name, why });
            }
        }
        Ok(Self { callback, environment, early, variables, inner_step, underway: None })
    }
}

impl<M: Model> Instance<M> {
    /// Takes a communication step, or its first part if the host looks into steps: `pause` then holds the call that is due.
    pub fn begin_step(&mut self, from: f64, step: f64, pause: &mut Option<Update>) -> Outcome {
        if self.watch.is_none() {
            return self.step(from, step);
        }
        self.check_step(from, step)?;
        self.refresh()?;
        if let Some(watch) = &mut self.watch {
            watch.underway = Some(Underway {
                before: Box::new(self.run.clone()),
                until: from + step,
                left: step,
                least: step / MOST_UPDATES,
            });
        }
        self.run.time = from;
        self.advance_by_part(pause)
    }

    /// Goes on with a step after the host has answered.
    pub fn go_on(&mut self, answer: Answer, pause: &mut Option<Update>) -> Outcome {
        let time = self.run.time;
        self.run.phase = Phase::StepComplete;
        if let Some(underway) = self.underway()
            && let Some(at) = answer
            && (at.is_nan() || at < underway.until)
        {
            // A time that has passed, or none, means now.
            underway.until = at.max(time);
            underway.left = underway.until - time;
        }
        match self.underway() {
            Some(underway) if underway.left > 0.0 => {}
            _ => {
                self.end();
                return Ok(());
            }
        }
        match self.refresh() {
            Ok(()) => self.advance_by_part(pause),
            Err(refusal) => Err(self.take_back(refusal)),
        }
    }

    fn underway(&mut self) -> Option<&mut Underway<M>> {
        self.watch.as_mut()?.underway.as_mut()
    }

    fn end(&mut self) -> Option<Underway<M>> {
        self.watch.as_mut()?.underway.take()
    }

    /// Takes a step that has failed back to its start, as a discarded step must change nothing.
    fn take_back(&mut self, refusal: Refusal) -> Refusal {
        if let Some(underway) = self.end() {
            let (phase, last_step) = (self.run.phase, self.run.last_step);
            self.run = Run { phase, last_step, ..*underway.before };
        }
        refusal
    }

    /// Advances by one inner step and pauses.
    fn advance_by_part(&mut self, pause: &mut Option<Update>) -> Outcome {
        let time = self.run.time;
        let (watch, underway) = self
            .watch
            .as_ref()
            .and_then(|watch| Some((watch, watch.underway.as_ref()?)))
            .ok_or(Refusal::Phase(self.run.phase))?;
        let inner = (watch.inner_step)(&self.run.model, underway.left).max(underway.least);
        // No tiny rest, and none that does not move the time.
        let part = if inner < 0.999 * underway.left && time + inner > time { inner } else { underway.left };
        let left = underway.left - part;
        let to = if left > 0.0 { time + part } else { underway.until };
        if let Err(refusal) = self.advance(time, part, to) {
            return Err(self.take_back(refusal));
        }
        self.run.phase = Phase::Intermediate;
        if let Some(underway) = self.underway() {
            underway.left = left;
        }
        let more = left > 0.0;
        *pause = self.watch.as_ref().map(|watch| Update {
            callback: watch.callback,
            environment: watch.environment,
            time: to,
            more,
            early: watch.early && more,
        });
        Ok(())
    }

    /// In intermediate update mode a host sets inputs that it has announced, and reads continuous inputs and outputs. By the
    /// standard it must announce those, too; its own example (3.0.2, section 4.3) does not, and reading does no harm.
    #[inline]
    pub fn check_intermediate(&self, references: &[ValueReference], set: bool) -> Outcome {
        if self.run.phase == Phase::Intermediate {
            return self.check_announced(references, set);
        }
        Ok(())
    }

    #[cold]
    fn check_announced(&self, references: &[ValueReference], set: bool) -> Outcome {
        let Some(watch) = &self.watch else { return Err(Refusal::Phase(self.run.phase)) };
        let more = matches!(&watch.underway, Some(underway) if underway.left > 0.0);
        for reference in references {
            let variable = variable::<M>(*reference)?;
            let why = if !is_intermediate(variable) {
                "it has no intermediateUpdate attribute"
            } else if set && watch.variables.binary_search(reference).is_err() {
                "it is not among the requiredIntermediateVariables"
            } else if set && !more {
                "the step is complete, so intermediateVariableSetRequested is false"
            } else {
                continue;
            };
            let name = variable.name;
            return Err(Refusal::NotIntermediate { name, why });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::ptr::null_mut;

    use serde::{Deserialize, Serialize};

    use super::*;
    use crate::boundary::logger::Logger;
    use crate::boundary::types::Status;
    use crate::boundary::version::Version;
    use crate::declare::input;
    use crate::model::{Experiment, Fault, Info, Log};
    use crate::{field, units};

    /// A clock that takes steps of a second and stops at its limit.
    #[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
    struct Clock {
        seconds: f64,
        limit: f64,
    }

    static VARIABLES: [Variable<Clock>; 1] = [input("limit", &units::SECOND, field!(Clock: limit), "Its end")];

    impl Model for Clock {
        const INFO: Info = crate::info!();

        const INNER_STEP: Option<fn(&Self, f64) -> f64> = Some(|_, _| 1.0);

        fn variables() -> &'static [Variable<Self>] {
            &VARIABLES
        }

        fn initialise(&mut self, _: &Experiment, _: &mut dyn Log) -> Result<(), Fault> {
            Ok(())
        }

        fn advance(&mut self, _: f64, step: f64, _: &mut dyn Log) -> Result<(), Fault> {
            if self.seconds + step > self.limit {
                return Err(Fault::Failed("it is worn".to_owned()));
            }
            self.seconds += step;
            Ok(())
        }
    }

    unsafe extern "C" fn ignore(
        _: ComponentEnvironment,
        _: f64,
        _: bool,
        _: bool,
        _: bool,
        _: bool,
        _: *mut u8,
        _: *mut f64,
    ) {
    }

    #[test]
    fn a_step_that_fails_after_some_updates_changes_nothing() -> Outcome {
        let logger = Logger::new(None, null_mut(), false);
        let mut clock = Instance::<Clock>::new("instantiate", (Version::Three, false), 0, None, logger);
        clock.watch = Some(Watch::new(ignore, null_mut(), true, &[0], |_, _| 1.0)?);
        clock.enter_initialization()?;
        clock.set_real(&[0], &[2.5])?;
        clock.exit_initialization()?;
        let before = clock.run.model.clone();
        let mut pause = None;
        clock.begin_step(0.0, 4.0, &mut pause)?;
        assert_eq!(clock.run.time, 1.0);
        clock.set_real(&[0], &[2.75])?;
        clock.go_on(None, &mut pause)?;
        assert_eq!((clock.run.time, clock.run.phase), (2.0, Phase::Intermediate));
        let failed = clock.go_on(None, &mut pause).unwrap_err();
        assert_eq!(failed.status(), Status::Discard);
        assert_eq!((clock.run.model.clone(), clock.run.time), (before, 0.0));
        assert_eq!(clock.run.phase, Phase::StepFailed);
        // The whole step in one go fails as well, one to the limit does not.
        clock.run.phase = Phase::StepComplete;
        clock.begin_step(0.0, 2.5, &mut pause)?;
        clock.go_on(None, &mut pause)?;
        clock.go_on(None, &mut pause)?;
        assert_eq!(clock.run.time, 2.5);
        clock.go_on(None, &mut pause)?;
        assert_eq!((clock.run.time, clock.run.phase), (2.5, Phase::StepComplete));
        Ok(())
    }
}

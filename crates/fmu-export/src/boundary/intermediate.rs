//! Intermediate updates of FMI 3.0 Co-Simulation: the host looks into a communication step.
//!
//! The boundary advances the model by its [inner steps](Model::INNER_STEP) and calls the host after each of them. During the
//! callback the host may call this instance again, so no reference to it may be held: a step pauses, the caller asks the host,
//! and the step goes on with the answer.

use super::{
    instance::Instance,
    lookup::variable_of,
    phase::Phase,
    refusal::{Outcome, Refusal},
    run::Run,
    types::ValueReference,
    watch::{StepEnd, Underway, Update, check_intermediate_access},
};
use crate::model::Model;

impl<M: Model> Instance<M> {
    /// Takes a communication step, or its first part if the host looks into steps, and returns the call of the host that is due.
    pub fn begin_step(&mut self, from: f64, step: f64) -> Outcome<Option<Update>> {
        if self.watch.is_none() {
            return self.step(from, step).map(|()| None);
        }
        self.check_step(from, step)?;
        self.refresh()?;
        if let Some(watch) = &mut self.watch {
            watch.underway = Some(Underway::new(&self.run, from, step));
        }
        self.run.time = from;
        self.advance_by_part()
    }

    /// Goes on with a step after the host has answered, and returns the call that is due then.
    pub fn go_on(&mut self, answer: StepEnd) -> Outcome<Option<Update>> {
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
                return Ok(None);
            }
        }
        match self.refresh() {
            Ok(()) => self.advance_by_part(),
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

    /// Advances by one part of the step, and returns the call of the host that is due behind it.
    fn advance_by_part(&mut self) -> Outcome<Option<Update>> {
        let time = self.run.time;
        let part = self.watch.as_ref().and_then(|watch| watch.next_part(&self.run.model, time));
        let part = part.ok_or(Refusal::Phase(self.run.phase))?;
        if let Err(refusal) = self.advance(time, part.length, part.to) {
            return Err(self.take_back(refusal));
        }
        self.run.phase = Phase::Intermediate;
        Ok(self.watch.as_mut().map(|watch| watch.behind(&part)))
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
            let variable = variable_of::<M>(*reference)?;
            check_intermediate_access(variable)?;
            let why = if set && watch.variables.binary_search(reference).is_err() {
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
    use crate::boundary::types::ComponentEnvironment;
    use crate::boundary::types::Status;
    use crate::boundary::version::Version;
    use crate::boundary::watch::Watch;
    use crate::declare::input;
    use crate::model::{Experiment, Fault, Info, Log, Variable};
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
        clock.begin_step(0.0, 4.0)?;
        assert_eq!(clock.run.time, 1.0);
        clock.set_real(&[0], &[2.75])?;
        clock.go_on(None)?;
        assert_eq!((clock.run.time, clock.run.phase), (2.0, Phase::Intermediate));
        let Err(failed) = clock.go_on(None) else { panic!("the step ends beyond the limit") };
        assert_eq!(failed.status(), Status::Discard);
        assert_eq!((clock.run.model.clone(), clock.run.time), (before, 0.0));
        assert_eq!(clock.run.phase, Phase::StepFailed);
        // The whole step in one go fails as well, one to the limit does not.
        clock.run.phase = Phase::StepComplete;
        clock.begin_step(0.0, 2.5)?;
        clock.go_on(None)?;
        clock.go_on(None)?;
        assert_eq!(clock.run.time, 2.5);
        clock.go_on(None)?;
        assert_eq!((clock.run.time, clock.run.phase), (2.5, Phase::StepComplete));
        Ok(())
    }
}

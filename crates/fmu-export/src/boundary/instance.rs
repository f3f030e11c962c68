//! An instance: a model in one of the phases of a simulation.

use std::{ffi::CString, path::PathBuf};

use super::{
    describe::token,
    logger::Logger,
    phase::Phase,
    refusal::{Outcome, Refusal},
    resources,
    run::Run,
    types::Status,
    version::Version,
    watch::Watch,
};
use crate::model::{Fault, Model, events, offered};

/// All that belongs to one instance.
pub struct Instance<M> {
    /// Sends messages to the host.
    pub logger: Logger,
    /// The model with its phase and times: what a saved state holds.
    pub run: Run<M>,
    /// The text that the host last got of each variable. The host reads it until it asks again.
    pub texts: Vec<Option<CString>>,
    /// A hash of the description: states of another version are refused by it.
    pub fingerprint: u128,
    /// The version of the standard that the host uses.
    pub version: Version,
    /// The callback by which the host sees values within communication steps, if it asked for one.
    pub watch: Option<Watch<M>>,
    /// Whether the host uses the event mode of Co-Simulation, and whether steps may end early at events then.
    pub event_mode: Option<bool>,
    /// Whether the last step has ended at an event that the host has to handle.
    pub event_due: bool,
    resources: Option<PathBuf>,
}

impl<M: Model> Instance<M> {
    /// Makes an instance for a description with this fingerprint, for Model Exchange if `exchange` says so. `function` is the
    /// host's call, and `resources` the folder of the resources as a URI or a path.
    pub fn new(
        function: &str,
        (version, exchange): (Version, bool),
        fingerprint: u128,
        resources: Option<&str>,
        logger: Logger,
    ) -> Self {
        let given = resources.filter(|given| !given.is_empty());
        let folder = given.and_then(resources::folder);
        if let (Some(given), None) = (given, &folder) {
            let message = format!("{function}: {given} is not a local folder; going on without resources");
            logger.send(Status::Warning, "logStatusWarning", &message);
        }
        Self {
            logger,
            run: Run { exchange, ..Run::default() },
            texts: vec![None; M::variables().len()],
            fingerprint,
            version,
            watch: None,
            event_mode: None,
            event_due: false,
            resources: folder,
        }
    }

    /// Chooses the messages that the host gets.
    pub fn set_logging(&mut self, on: bool, categories: &[&str]) -> Outcome {
        self.logger.switch::<M>(on, categories)
    }

    /// Takes the experiment's tolerance, start and stop.
    pub fn setup(&mut self, tolerance: Option<f64>, start: f64, stop: Option<f64>) -> Outcome {
        finite("startTime", start)?;
        // Some hosts, Simulink for one, pass infinity when a simulation has no end.
        let stop = stop.filter(|stop| *stop != f64::INFINITY);
        if let Some(stop) = stop {
            require(stop >= start, "stopTime", stop, "it must not be earlier than startTime")?;
        }
        if let Some(tolerance) = tolerance {
            require(tolerance > 0.0 && tolerance.is_finite(), "tolerance", tolerance, "it must be greater than 0")?;
        }
        self.run.start = start;
        self.run.time = start;
        self.run.stop = stop;
        self.run.tolerance = tolerance;
        Ok(())
    }

    /// Enters the initialization mode. The model is initialised when the first value is read or the mode is left, as the
    /// host may set more parameters until then.
    pub fn enter_initialization(&mut self) -> Outcome {
        self.run.seed = Some(self.run.model.clone());
        self.run.stale = true;
        self.run.phase = Phase::Initialization;
        Ok(())
    }

    /// Leaves the initialization mode.
    pub fn exit_initialization(&mut self) -> Outcome {
        self.refresh()?;
        self.run.seed = None;
        self.run.phase =
            if self.run.exchange || self.event_mode.is_some() { Phase::Event } else { Phase::StepComplete };
        Ok(())
    }

    /// Ends the simulation.
    pub fn terminate(&mut self) -> Outcome {
        self.refresh()?;
        self.run.phase = Phase::Terminated;
        Ok(())
    }

    /// Goes back to the instantiation.
    pub fn reset(&mut self) -> Outcome {
        self.run = Run { exchange: self.run.exchange, ..Run::default() };
        Ok(())
    }

    /// Takes a communication step.
    pub fn step(&mut self, from: f64, step: f64) -> Outcome {
        self.check_step(from, step)?;
        self.refresh()?;
        self.advance(from, step, from + step)
    }

    /// Checks a communication step before anything is done.
    pub fn check_step(&self, from: f64, step: f64) -> Outcome {
        finite("currentCommunicationPoint", from)?;
        require(step > 0.0 && step.is_finite(), "communicationStepSize", step, "a step must be greater than 0")?;
        self.check_times(from, step)
    }

    /// Lets `step` seconds pass in the model, to the time `to`.
    pub fn advance(&mut self, from: f64, step: f64, to: f64) -> Outcome {
        self.run.differentiated = false;
        let (model, log) = (&mut self.run.model, &mut self.logger);
        // A host that does not see the events leaves them to the model.
        let result = match events::<M>().filter(|_| self.event_mode == Some(true)) {
            Some(events) => events.stop(model, from, step, log),
            None => model.advance(from, step, log).map(|()| None),
        };
        match &result {
            Ok(event) => {
                self.event_due = event.is_some();
                let passed = event.filter(|passed| *passed < step);
                self.run.time = passed.map_or(to, |passed| from + passed);
                self.clear_slopes();
                self.run.last_step = Status::Ok;
            }
            Err(Fault::Failed(_)) => {
                self.run.phase = Phase::StepFailed;
                self.run.last_step = Status::Discard;
            }
            Err(Fault::Invalid(_)) => {
                self.run.phase = Phase::Error;
                self.run.last_step = Status::Error;
            }
        }
        result.map(drop).map_err(Refusal::Step)
    }

    /// Checks that the step begins where the last one ended, and ends by the stop time.
    ///
    /// Hosts compute their times by adding up steps, by multiplying, or in single precision, so the times need not be
    /// equal. They must be near enough that no step is left out or made twice: less than half a step apart, or than
    /// the spacing of floating-point numbers, if that is more.
    fn check_times(&self, from: f64, step: f64) -> Outcome {
        let time = from.abs().max(self.run.time.abs());
        let near = (1e-3 * step + 1e-6 * time).min(0.5 * step).max(4.0 * f64::EPSILON * time);
        require(
            (from - self.run.time).abs() <= near,
            "currentCommunicationPoint",
            from,
            "a step must begin where the last one ended",
        )?;
        require(
            self.run.stop.is_none_or(|stop| from + step - stop <= near),
            "communicationStepSize",
            step,
            "the step would end after the stop time that was announced",
        )
    }

    /// Recomputes the outputs if something was set. After this, `run.model` is up to date in every phase in which values
    /// can be read.
    #[inline]
    pub fn refresh(&mut self) -> Outcome {
        if !self.run.stale {
            return Ok(());
        }
        self.recompute()
    }

    fn recompute(&mut self) -> Outcome {
        match self.run.phase {
            Phase::Initialization => {
                if let Some(seed) = self.run.seed.clone() {
                    self.run.model = self.initialised(seed)?;
                }
            }
            Phase::StepComplete | Phase::Intermediate => self.run.model.update()?,
            Phase::Event | Phase::Continuous => self.run.model.update().map_err(Refusal::Step)?,
            // Before the initialization, which computes the outputs anyway, and after the end.
            _ => return Ok(()),
        }
        self.run.stale = false;
        self.run.differentiated = false;
        Ok(())
    }

    /// Initialises a configured model for this experiment.
    fn initialised(&mut self, mut model: M) -> Outcome<M> {
        let experiment = self.run.experiment(self.resources.as_deref());
        model.initialise(&experiment, &mut self.logger)?;
        if let (true, Some(exchange)) = (self.run.exchange, offered::<M>()) {
            (exchange.allow)(&model)?;
        }
        Ok(model)
    }

    /// A copy of the model after `change`, with its outputs: initialised in initialization mode, updated later.
    pub fn variant(&self, change: impl FnOnce(&mut M)) -> Outcome<M> {
        let mut model = self.run.seed.as_ref().unwrap_or(&self.run.model).clone();
        change(&mut model);
        if self.run.seed.is_some() {
            model.initialise(&self.run.experiment(self.resources.as_deref()), &mut ())?;
        } else {
            model.update()?;
        }
        Ok(model)
    }
}

/// Refuses a host that gives an instance no name, or has read another description than that with this fingerprint.
pub fn check_host(version: Version, name: &str, given: &str, fingerprint: u128) -> Outcome {
    if name.trim().is_empty() {
        return Err(Refusal::Argument {
            name: "instanceName",
            value: format!("{name:?}"),
            why: "it must not be empty",
        });
    }
    if given != token(fingerprint) {
        return Err(Refusal::Argument {
            name: version.token(),
            value: given.to_owned(),
            why: "the modelDescription.xml in use does not belong to this binary; unpack the FMU again",
        });
    }
    Ok(())
}

/// Refuses an argument that is not finite.
pub fn finite(name: &'static str, value: f64) -> Outcome {
    require(value.is_finite(), name, value, "it must be a finite number")
}

fn require(holds: bool, name: &'static str, value: f64, why: &'static str) -> Outcome {
    if holds {
        return Ok(());
    }
    Err(Refusal::Argument { name, value: format!("{value:?}"), why })
}

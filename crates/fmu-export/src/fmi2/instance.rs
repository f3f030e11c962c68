//! One instance: a model on its way through the phases of a simulation.

use std::ffi::{CString, c_int};
use std::path::{Path, PathBuf};

use super::description;
use super::logger::{self, Logger};
use super::phase::Phase;
use super::refusal::{Outcome, Refusal};
use super::resources;
use super::types::{CO_SIMULATION, CallbackFunctions, Status};
use crate::model::{Experiment, Fault, Model};

/// All that belongs to one instance.
pub struct Instance<M> {
    /// The way to the host's log.
    pub logger: Logger,
    /// The run: all that a saved state holds.
    pub run: Run<M>,
    /// The texts that the host was given, one place a variable.
    pub texts: Vec<Option<CString>>,
    /// Which variable table this is: see [`description::fingerprint`].
    pub fingerprint: u128,
    resources: Option<PathBuf>,
}

/// The part of an instance that a saved state holds.
#[derive(Clone)]
pub struct Run<M> {
    /// Where the instance is in its life.
    pub phase: Phase,
    /// The model; in initialization mode, the model as `seed` makes it.
    pub model: M,
    /// In initialization mode: the model as it was configured, but not initialised.
    pub seed: Option<M>,
    /// Whether something was set since the model was last evaluated.
    pub stale: bool,
    /// Whether an input has a slope for the next step.
    pub sloped: bool,
    /// The present communication point, s.
    pub time: f64,
    /// The start time, s.
    pub start: f64,
    /// The stop time, s, where the host named one.
    pub stop: Option<f64>,
    /// The relative tolerance, where the host named one.
    pub tolerance: Option<f64>,
    /// How the last step ended.
    pub last_step: Status,
}

impl<M: Model> Default for Run<M> {
    fn default() -> Self {
        Self {
            phase: Phase::Instantiated,
            model: M::default(),
            seed: None,
            stale: false,
            sloped: false,
            time: 0.0,
            start: 0.0,
            stop: None,
            tolerance: None,
            last_step: Status::Ok,
        }
    }
}

/// What the host says when it makes an instance.
pub struct Request<'a> {
    pub name: &'a str,
    pub kind: c_int,
    pub guid: &'a str,
    pub resources: Option<&'a str>,
    pub logging: bool,
}

impl<M: Model> Instance<M> {
    /// Makes an instance. Why not, where not, goes to the host's log.
    pub fn new(request: &Request<'_>, callbacks: &CallbackFunctions) -> Option<Self> {
        let logger = Logger::new(callbacks, logger::c_string(request.name), request.logging);
        let fingerprint = description::fingerprint::<M>();
        if let Err(refusal) = check(request, fingerprint) {
            logger.refuse("fmi2Instantiate", &refusal);
            return None;
        }
        let uri = request.resources.filter(|uri| !uri.is_empty());
        let folder = uri.and_then(resources::folder);
        if let (Some(uri), None) = (uri, &folder) {
            let message =
                format!("fmi2Instantiate: {uri} is no local folder; going on without resources");
            logger.send(Status::Warning, "logStatusWarning", &message);
        }
        Some(Self {
            logger,
            run: Run::default(),
            texts: vec![None; M::variables().len()],
            fingerprint,
            resources: folder,
        })
    }

    /// Where the instance is in its life.
    pub fn phase(&self) -> Phase {
        self.run.phase
    }

    /// After a panic: nothing works any more.
    pub fn poison(&mut self) {
        self.run.phase = Phase::Fatal;
    }

    /// `fmi2SetDebugLogging`.
    pub fn set_logging(&mut self, on: bool, categories: &[&str]) -> Outcome {
        self.logger.switch::<M>(on, categories)?;
        Ok(Status::Ok)
    }

    /// `fmi2SetupExperiment`.
    pub fn setup(&mut self, tolerance: Option<f64>, start: f64, stop: Option<f64>) -> Outcome {
        finite("startTime", start)?;
        // Simulink, for one, calls a simulation without an end one that stops at infinity.
        let stop = stop.filter(|stop| *stop != f64::INFINITY);
        if let Some(stop) = stop {
            let why = "it must not be earlier than startTime";
            require(stop >= start, "stopTime", stop, why)?;
        }
        if let Some(tolerance) = tolerance {
            let why = "it must be greater than 0";
            require(
                tolerance > 0.0 && tolerance.is_finite(),
                "tolerance",
                tolerance,
                why,
            )?;
        }
        self.run.start = start;
        self.run.time = start;
        self.run.stop = stop;
        self.run.tolerance = tolerance;
        Ok(Status::Ok)
    }

    /// `fmi2EnterInitializationMode`. The model is initialised as late as possible, so that the
    /// host may still set parameters.
    pub fn enter_initialization(&mut self) -> Outcome {
        self.run.seed = Some(self.run.model.clone());
        self.run.stale = true;
        self.run.phase = Phase::Initialization;
        Ok(Status::Ok)
    }

    /// `fmi2ExitInitializationMode`.
    pub fn exit_initialization(&mut self) -> Outcome {
        self.refresh()?;
        self.run.seed = None;
        self.run.phase = Phase::StepComplete;
        Ok(Status::Ok)
    }

    /// `fmi2Terminate`.
    pub fn terminate(&mut self) -> Outcome {
        self.refresh()?;
        self.run.phase = Phase::Terminated;
        Ok(Status::Ok)
    }

    /// `fmi2Reset`.
    pub fn reset(&mut self) -> Outcome {
        self.run = Run::default();
        Ok(Status::Ok)
    }

    /// `fmi2DoStep`.
    pub fn step(&mut self, from: f64, step: f64) -> Outcome {
        finite("currentCommunicationPoint", from)?;
        let why = "a step must be greater than 0";
        require(
            step > 0.0 && step.is_finite(),
            "communicationStepSize",
            step,
            why,
        )?;
        self.check_times(from, step)?;
        self.refresh()?;
        let result = self.run.model.advance(from, step, &mut self.logger);
        match &result {
            Ok(()) => {
                self.run.time = from + step;
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
        result.map(|()| Status::Ok).map_err(Refusal::Step)
    }

    /// Hosts compute their times by adding up steps, by multiplying, or in single precision: what
    /// counts is that no step is left out or done twice, and that none ends after the stop time.
    /// Half a step away is another point, unless neighbouring numbers are as far apart.
    fn check_times(&self, from: f64, step: f64) -> Outcome<()> {
        let time = from.abs().max(self.run.time.abs());
        let near = (1e-3 * step + 1e-6 * time)
            .min(0.5 * step)
            .max(4.0 * f64::EPSILON * time);
        if (from - self.run.time).abs() > near {
            return Err(Refusal::Argument {
                name: "currentCommunicationPoint",
                value: format!("{from:?}"),
                why: "the step must begin where the last one ended",
            });
        }
        let Some(stop) = self.run.stop else {
            return Ok(());
        };
        if from + step - stop > near {
            return Err(Refusal::Argument {
                name: "communicationStepSize",
                value: format!("{step:?}"),
                why: "the step would end after the stop time given to fmi2SetupExperiment",
            });
        }
        Ok(())
    }

    /// Brings the model's outputs up to date with what was set. After this, `run.model` is
    /// consistent in every phase in which values can be read.
    pub fn refresh(&mut self) -> Outcome<()> {
        if !self.run.stale {
            return Ok(());
        }
        match self.run.phase {
            Phase::Initialization => {
                if let Some(seed) = self.run.seed.clone() {
                    self.run.model = self.initialised(seed)?;
                }
            }
            Phase::StepComplete => self.run.model.update()?,
            // What was set before the initialization is evaluated by it; after the end nothing is.
            _ => return Ok(()),
        }
        self.run.stale = false;
        Ok(())
    }

    /// A configured model, initialised for this experiment.
    fn initialised(&mut self, mut model: M) -> Outcome<M> {
        let experiment = self.run.experiment(self.resources.as_deref());
        model.initialise(&experiment, &mut self.logger)?;
        Ok(model)
    }

    /// A copy of the model with something set on it by `change`, evaluated: initialised in
    /// initialization mode, updated later.
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

impl<M> Run<M> {
    fn experiment<'a>(&self, resources: Option<&'a Path>) -> Experiment<'a> {
        Experiment {
            start: self.start,
            stop: self.stop,
            tolerance: self.tolerance,
            resources,
        }
    }
}

fn check(request: &Request<'_>, fingerprint: u128) -> Outcome<()> {
    if request.name.trim().is_empty() {
        return Err(Refusal::Argument {
            name: "instanceName",
            value: format!("{:?}", request.name),
            why: "an instance needs a name",
        });
    }
    if request.kind != CO_SIMULATION {
        return Err(Refusal::Argument {
            name: "fmuType",
            value: request.kind.to_string(),
            why: "this FMU is for Co-Simulation (1) only",
        });
    }
    if request.guid != description::guid(fingerprint) {
        return Err(Refusal::Argument {
            name: "fmuGUID",
            value: request.guid.to_owned(),
            why: "the modelDescription.xml in use does not belong to this binary",
        });
    }
    Ok(())
}

fn finite(name: &'static str, value: f64) -> Outcome<()> {
    require(value.is_finite(), name, value, "it must be a finite number")
}

fn require(holds: bool, name: &'static str, value: f64, why: &'static str) -> Outcome<()> {
    if holds {
        return Ok(());
    }
    Err(Refusal::Argument {
        name,
        value: format!("{value:?}"),
        why,
    })
}

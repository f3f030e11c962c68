//! A model with variables: all that a simulation boundary needs to know of the physics.
//!
//! A [`Model`] declares its variables once, in a table of [`Variable`]s. Value references, units, start values,
//! descriptions and the model description follow from that table. Nothing here knows FMI.

mod continuous;
mod events;
mod faults;
mod variable;

use std::{
    fmt,
    path::{Path, PathBuf},
};

use serde::{Serialize, de::DeserializeOwned};
use thiserror::Error;

pub use continuous::{Complete, Continuous, Exchange, State, offered};
pub(crate) use events::check_end;
pub use events::{Events, Until, events, indicators};
pub use faults::faults;
pub use variable::{
    Access, BaseExponents, DisplayUnit, Enumeration, Item, Kind, Quantity, Role, Unit, Variable, check_fixed,
    check_ranges, elements,
};
pub(crate) use variable::{inside, named};

/// A simulation model that a boundary (an FMU, a test, a benchmark) can drive.
///
/// The life of a model: `default()`, set parameters and inputs, [`initialise`](Model::initialise), then any number of
/// times: set inputs, [`advance`](Model::advance), read outputs.
///
/// A saved state is a `clone()` within the process and the bytes of [`save`](Model::save) between processes. Both
/// must hold everything that the next steps depend on.
pub trait Model: Clone + Default + Serialize + DeserializeOwned + Send + Sync + 'static {
    /// Name, identifier, description, version, licence and default experiment; [`info!`](crate::info) fills in most of it.
    const INFO: Info;

    /// What Model Exchange needs: `Some(Exchange::of())` for a model that is [`Continuous`]. Without it, FMUs of the model
    /// are for Co-Simulation only.
    const EXCHANGE: Option<Exchange<Self>> = None;

    /// The model's events, if it has any: for Model Exchange, and for hosts of FMI 3.0 Co-Simulation that want to see them (event
    /// mode). For other hosts [`advance`](Model::advance) handles them: [`Events::pass`] does so. Such a model has no inner steps.
    const EVENTS: Option<Events<Self>> = None;

    /// For hosts of FMI 3.0 that look into a communication step (intermediate update): the length of the first inner step of
    /// [`advance`](Model::advance) over so many seconds. The boundary then advances the model by its inner steps, one after
    /// another, and the host reads outputs, sets inputs or ends the communication step in between. Other hosts are not concerned.
    /// Without it there are no intermediate updates.
    const INNER_STEP: Option<fn(&Self, f64) -> f64> = None;

    /// All variables. A variable's place in this table is its value reference: hosts store it, so that variables may
    /// only be added at the end.
    fn variables() -> &'static [Variable<Self>];

    /// The order in which the variables are listed to people, as places in [`variables`](Model::variables). By default
    /// the table's own; a large model that grows can list what was added later beside what it belongs to.
    fn listing() -> Vec<usize> {
        (0..Self::variables().len()).collect()
    }

    /// Checks the parameters and computes the state at the start time. Outputs are valid afterwards.
    ///
    /// # Errors
    /// When a parameter, an input or a file is not usable ([`Fault::Invalid`]).
    fn initialise(&mut self, experiment: &Experiment, log: &mut dyn Log) -> Result<(), Fault>;

    /// Recomputes the outputs from the present state, inputs and tunable parameters, without letting time pass. It is
    /// called after inputs or tunable parameters were set. A model whose outputs are computed when they are read has
    /// nothing to do here.
    ///
    /// # Errors
    /// When an input or a tunable parameter is not usable.
    fn update(&mut self) -> Result<(), Fault> {
        Ok(())
    }

    /// Computes what the outputs' [derivatives](Quantity::derivative) read, where that is work that they share. It is called
    /// once before any of them is read, and again only after something has changed. It must not change an output.
    ///
    /// # Errors
    /// [`Fault::Failed`] when there are none at the present state.
    fn differentiate(&mut self) -> Result<(), Fault> {
        Ok(())
    }

    /// Lets `step` seconds pass from `time`. Inputs are held or, where a [slope](Quantity::slope) was set, vary linearly.
    /// Outputs are valid at `time + step` afterwards.
    ///
    /// # Errors
    /// [`Fault::Failed`] when the step cannot be computed, [`Fault::Invalid`] when an input is not usable. The state
    /// is then as before the call.
    fn advance(&mut self, time: f64, step: f64, log: &mut dyn Log) -> Result<(), Fault>;

    /// The state as bytes, parameters and inputs included. [`restore`](Model::restore) of them continues bit for bit.
    ///
    /// # Errors
    /// When the model cannot be serialised.
    fn save(&self) -> Result<Vec<u8>, Fault> {
        postcard::to_stdvec(self).map_err(|error| Fault::Failed(format!("the state cannot be saved: {error}")))
    }

    /// Takes a saved state back.
    ///
    /// # Errors
    /// When the bytes are no state of this model; nothing has changed then.
    fn restore(&mut self, bytes: &[u8]) -> Result<(), Fault> {
        *self = postcard::from_bytes(bytes)
            .map_err(|error| Fault::Invalid(format!("the saved state cannot be read: {error}")))?;
        Ok(())
    }
}

/// A model's name, its origin, and its default simulation. Write
/// `Info { name: "...", ..fmu_export::info!() }`.
#[derive(Clone, Copy, Debug)]
pub struct Info {
    /// The model's name, for people.
    pub name: &'static str,
    /// The model's identifier: a valid C identifier, and the name of the binary in the FMU.
    pub identifier: &'static str,
    /// One sentence on its meaning.
    pub description: &'static str,
    /// The model's version.
    pub version: &'static str,
    /// Its licence, as an SPDX expression such as `MIT`; empty for none.
    pub license: &'static str,
    /// Its authors, separated by colons as cargo gives them; empty for none.
    pub author: &'static str,
    /// Whose copyright it is; empty for none.
    pub copyright: &'static str,
    /// The communication step that is suggested to hosts, s. Where the model does not know an output's derivative, a
    /// thousandth of it is the step of the difference that stands in.
    pub default_step: f64,
    /// The stop time that is suggested to hosts, s.
    pub default_stop: f64,
    /// The relative tolerance that is suggested to hosts.
    pub default_tolerance: f64,
    /// The model's log categories with their descriptions.
    pub log_categories: &'static [(&'static str, &'static str)],
}

/// An [`Info`] filled in from the `Cargo.toml` of the crate that calls it: name, identifier (the crate's name with
/// underscores), description, version, licence and authors. The default experiment is 1 s in steps of 10 ms at a
/// tolerance of 1e-6, without log categories.
///
/// ```
/// use fmu_export::model::Info;
///
/// const INFO: Info = Info { name: "Draining tank", default_stop: 60.0, ..fmu_export::info!() };
/// assert_eq!(INFO.license, env!("CARGO_PKG_LICENSE"));
/// ```
#[macro_export]
macro_rules! info {
    () => {
        $crate::model::Info {
            name: env!("CARGO_PKG_NAME"),
            identifier: env!("CARGO_CRATE_NAME"),
            description: env!("CARGO_PKG_DESCRIPTION"),
            version: env!("CARGO_PKG_VERSION"),
            license: env!("CARGO_PKG_LICENSE"),
            author: env!("CARGO_PKG_AUTHORS"),
            copyright: "",
            default_step: 0.01,
            default_stop: 1.0,
            default_tolerance: 1e-6,
            log_categories: &[],
        }
    };
}

/// The simulation as the host announces it before the start. By default it starts at zero, and nothing else is known.
#[derive(Clone, Copy, Debug, Default)]
pub struct Experiment<'a> {
    /// The time at which the simulation starts, s.
    pub start: f64,
    /// The time at which it stops, s, if the host has said so.
    pub stop: Option<f64>,
    /// The relative tolerance that the host asks for, if it asks for one.
    pub tolerance: Option<f64>,
    /// The folder of the FMU's resource files, if the host has named one.
    pub resources: Option<&'a Path>,
}

impl Experiment<'_> {
    /// The path of a file that a parameter names: a relative name is looked up among the resources first, then in the
    /// working directory.
    pub fn file(&self, name: &str) -> PathBuf {
        self.resources
            .map(|folder| folder.join(name))
            .filter(|path| path.is_file())
            .unwrap_or_else(|| PathBuf::from(name))
    }
}

/// Why a model cannot go on.
#[derive(Clone, Debug, Error)]
pub enum Fault {
    /// A parameter, an input, a file or a saved state is not usable. The message should name it, its value and the
    /// remedy.
    #[error("{0}")]
    Invalid(String),
    /// The step could not be computed. The state is as before the call, and a shorter step may succeed.
    #[error("{0}")]
    Failed(String),
}

/// Takes a model's messages.
pub trait Log {
    /// Takes one message of one of the [`Info::log_categories`].
    fn log(&mut self, category: &'static str, message: fmt::Arguments);
}

/// Drops every message.
impl Log for () {
    fn log(&mut self, _: &'static str, _: fmt::Arguments) {}
}

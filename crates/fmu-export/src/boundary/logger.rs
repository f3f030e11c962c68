//! Messages to the host's logger callback.

use std::{ffi::CString, fmt};

use super::{
    refusal::Refusal,
    types::{CallbackLogger, ComponentEnvironment, LogMessageCallback, Status},
};
use crate::model::{Log, Model};

/// The boundary's own log categories, with the names of the standard.
const CATEGORIES: &[(&str, &str)] = &[
    ("logStatusWarning", "Oddities that do not stop the simulation."),
    ("logStatusDiscard", "Steps and requests that could not be carried out, and why."),
    ("logStatusError", "Calls that were refused or failed, and why."),
    ("logStatusFatal", "Internal errors, after which an instance is unusable."),
    ("logAll", "All messages."),
];

/// All log categories of an FMU: the boundary's, then the model's own.
pub fn categories<M: Model>() -> impl Iterator<Item = (&'static str, &'static str)> {
    let of_boundary = |name: &str| CATEGORIES.iter().any(|(category, _)| *category == name);
    let models = M::INFO.log_categories.iter().filter(move |(name, _)| !of_boundary(name));
    CATEGORIES.iter().chain(models).copied()
}

/// The host's function for messages.
pub enum Callback {
    /// That of FMI 2.0, which also takes the instance's name.
    Two(CallbackLogger, CString),
    /// That of FMI 3.0.
    Three(LogMessageCallback),
}

/// Sends an instance's messages to the host's logger.
///
/// Warnings and errors are always sent; the model's messages only while debug logging is on and their category is chosen.
pub struct Logger {
    callback: Option<Callback>,
    environment: ComponentEnvironment,
    on: bool,
    /// The chosen categories; `None` for all.
    chosen: Option<Vec<&'static str>>,
}

impl Logger {
    /// A logger for this function of the host, if it has one, and the pointer that goes with it.
    pub fn new(callback: Option<Callback>, environment: ComponentEnvironment, on: bool) -> Self {
        Self { callback, environment, on, chosen: None }
    }

    /// Switches debug logging on or off, for the chosen categories or, if none is chosen, for all.
    pub fn switch<M: Model>(&mut self, on: bool, chosen: &[&str]) -> Result<(), Refusal> {
        let chosen = chosen
            .iter()
            .map(|category| {
                categories::<M>()
                    .map(|(name, _)| name)
                    .find(|name| name == category)
                    .ok_or_else(|| Refusal::Category((*category).to_owned()))
            })
            .collect::<Result<Vec<_>, _>>()?;
        self.on = on;
        self.chosen = (!chosen.is_empty() && !chosen.contains(&"logAll")).then_some(chosen);
        Ok(())
    }

    /// Sends a message with a status. In FMI 2.0 it is an argument of the format `%s`, so that a `%` in it does no harm.
    pub fn send(&self, status: Status, category: &str, message: &str) {
        let Some(callback) = &self.callback else { return };
        let (category, message) = (c_string(category), c_string(message));
        let (environment, category, message) = (self.environment, category.as_ptr(), message.as_ptr());
        // SAFETY of both: the host vouches for its callback when it instantiates; all strings end with NUL and live
        // until it returns; the format takes exactly the one argument given.
        match callback {
            // SAFETY: as said above.
            Callback::Two(log, name) => unsafe {
                log(environment, name.as_ptr(), status, category, c"%s".as_ptr(), message);
            },
            // SAFETY: as said above.
            Callback::Three(log) => unsafe { log(environment, status, category, message) },
        }
    }

    /// Sends the reason why a call of `function` is refused.
    pub fn refuse(&self, function: &str, refusal: &Refusal) {
        let status = refusal.status();
        let category = if status == Status::Discard { "logStatusDiscard" } else { "logStatusError" };
        self.send(status, category, &format!("{function}: {refusal}"));
    }
}

impl Log for Logger {
    fn log(&mut self, category: &'static str, message: fmt::Arguments) {
        if self.on && self.chosen.as_ref().is_none_or(|chosen| chosen.contains(&category)) {
            self.send(Status::Ok, category, &message.to_string());
        }
    }
}

/// A C string; NULs within the text become spaces.
pub fn c_string(text: &str) -> CString {
    CString::new(text.replace('\0', " ")).unwrap_or_default()
}

//! The log: what goes to the host's logger callback, and what is kept back.

use std::ffi::CString;
use std::fmt;

use super::refusal::Refusal;
use super::types::{CallbackFunctions, CallbackLogger, ComponentEnvironment, Status};
use crate::model::{Log, Model};

/// Categories of the boundary itself, beside the model's own. The names are the standard's.
const CATEGORIES: &[(&str, &str)] = &[
    (
        "logStatusWarning",
        "What is odd, but does not stop the simulation.",
    ),
    (
        "logStatusDiscard",
        "Why a step or a request could not be carried out.",
    ),
    ("logStatusError", "Why a call was refused or failed."),
    ("logStatusFatal", "Why an instance became unusable."),
    ("logAll", "All messages."),
];

/// All categories of an FMU: the boundary's, then those that only the model has.
pub fn categories<M: Model>() -> impl Iterator<Item = (&'static str, &'static str)> {
    let own = |name: &str| CATEGORIES.iter().any(|(category, _)| *category == name);
    let models = M::INFO
        .log_categories
        .iter()
        .filter(move |(name, _)| !own(name));
    CATEGORIES.iter().chain(models).copied()
}

/// An instance's way to the host's logger.
///
/// Messages of status warning and worse always go to the host; the model's messages go while
/// debug logging is on and their category is chosen.
pub struct Logger {
    callback: Option<CallbackLogger>,
    environment: ComponentEnvironment,
    instance: CString,
    on: bool,
    /// The chosen categories; `None` stands for all.
    chosen: Option<Vec<&'static str>>,
}

impl Logger {
    /// Copies what it needs of the callbacks: hosts may keep that struct on their stack.
    pub fn new(callbacks: &CallbackFunctions, instance: CString, on: bool) -> Self {
        Self {
            callback: callbacks.logger,
            environment: callbacks.component_environment,
            instance,
            on,
            chosen: None,
        }
    }

    /// Switches debug logging; without categories, for all.
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

    /// Sends a message with a status. The message is data, never a format.
    pub fn send(&self, status: Status, category: &str, message: &str) {
        let Some(callback) = self.callback else {
            return;
        };
        let (category, message) = (c_string(category), c_string(message));
        // SAFETY: the host vouches for its callback at fmi2Instantiate; all strings end with NUL
        // and live until it returns; the format takes exactly the one argument given.
        unsafe {
            callback(
                self.environment,
                self.instance.as_ptr(),
                status,
                category.as_ptr(),
                c"%s".as_ptr(),
                message.as_ptr(),
            );
        }
    }

    /// Tells the host why a call of `function` is refused.
    pub fn refuse(&self, function: &str, refusal: &Refusal) {
        let status = refusal.status();
        let category = if status == Status::Discard {
            "logStatusDiscard"
        } else {
            "logStatusError"
        };
        self.send(status, category, &format!("{function}: {refusal}"));
    }
}

impl Log for Logger {
    fn log(&mut self, category: &'static str, message: fmt::Arguments<'_>) {
        if self.on
            && self
                .chosen
                .as_ref()
                .is_none_or(|chosen| chosen.contains(&category))
        {
            self.send(Status::Ok, category, &message.to_string());
        }
    }
}

/// A C string; NULs within the text become spaces.
pub fn c_string(text: &str) -> CString {
    CString::new(text.replace('\0', " ")).unwrap_or_default()
}

//! The importer's side of an instance's calls: the FMU's floating-point mode, its messages, and its end.

use std::ffi::c_int;

use crate::{
    call::{Call, Called, Status},
    floating_point::{Mode, within},
    logger::Log,
};

/// Makes the calls of one instance and judges what they return.
#[derive(Debug)]
pub struct Caller {
    pub log: Log,
    /// The FMU's own mode, which its next call finds again.
    pub mode: Mode,
    /// Whether a call ended with `fmi2Fatal` or `fmi3Fatal`: nothing may be called any more.
    pub dead: bool,
    /// How many calls were made: what one told is known until the next.
    pub calls: u64,
}

impl Caller {
    /// A caller of an FMU whose binary left the processor in this mode.
    pub fn new(mode: Mode) -> Self {
        Self { log: Log::open(), mode, dead: false, calls: 0 }
    }

    /// Makes a call in the FMU's own floating-point mode.
    #[inline(always)]
    pub fn call<T>(&mut self, call: impl FnOnce() -> T) -> T {
        self.calls += 1;
        within(&mut self.mode, call)
    }

    /// Judges the status that a function returned.
    #[inline]
    pub fn check(&mut self, function: &'static str, status: c_int) -> Called {
        match status {
            0 => Ok(()),
            1 => {
                self.log.returned_warning(function);
                Ok(())
            }
            status => Err(self.failed(function, Status::from(status))),
        }
    }

    #[cold]
    pub fn failed(&mut self, function: &'static str, status: Status) -> Call {
        self.dead |= status == Status::Fatal;
        Call { function, status, message: self.log.last(), ended: None }
    }
}

impl Call {
    /// A call of the optional function `function`, which some FMUs leave out.
    pub fn missing(function: &'static str) -> Self {
        Self::impossible(function, "the FMU does not export the function".to_owned())
    }

    /// A call that was not made, and why.
    pub fn impossible(function: &'static str, why: String) -> Self {
        Self { function, status: Status::Error, message: Some(why), ended: None }
    }
}

//! The traces that a simulation leaves in its process: not looked at on Windows.

/// The threads and signals of this process at some moment.
#[derive(Debug)]
pub struct Traces;

impl Traces {
    /// Those at this moment.
    pub fn now() -> Self {
        Self
    }

    /// Whether a thread runs now that did not run then.
    pub fn has_further_threads(&self) -> bool {
        false
    }

    /// Whether a signal is handled in another way than then.
    pub fn has_other_signals(&self) -> bool {
        false
    }
}

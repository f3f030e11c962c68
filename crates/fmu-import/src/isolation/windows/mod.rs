//! Processes on Windows.
//!
//! - `birth`: how a child starts;
//! - [`job`]: processes that end together;
//! - [`keeper`]: a process that starts children and watches them;
//! - [`pipe`]: waits for a pipe for a limited time;
//! - [`process`]: memory, end and modes of processes;
//! - `words`: what a child prints.

pub mod birth;
pub mod job;
pub mod keeper;
pub mod pipe;
pub mod process;
mod words;

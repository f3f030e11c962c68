//! One point with its trajectory, in a process of its own: what the FMU does to it is one clear failure.

use std::path::Path;

use super::EngineError;
use super::process::{Limits, Loss, Process};
use super::wire::{End, Reader, read_frame};
use crate::failure::Failure;
use crate::task::{Record, Task};
use fmu_import::{Handle, Value};

/// Where and within which limits a point is recorded.
#[derive(Clone, Copy, Debug)]
pub struct Recorder<'a> {
    /// The folder of the unpacked FMU.
    pub fmu: &'a Path,
    /// What the user calls the FMU.
    pub name: &'a Path,
    /// A folder for the worker's notes.
    pub scratch: &'a Path,
    /// What the point may use; the time is that between two messages of the worker.
    pub limits: Limits,
    /// Whether what the FMU prints is shown on standard error.
    pub echo: bool,
}

impl Recorder<'_> {
    /// Simulates a point and hands over time and columns at every communication point.
    ///
    /// # Errors
    /// When no worker can be started, when the simulation fails, and what `row` returns.
    pub fn record<E: From<Failure> + From<EngineError>>(
        &self,
        task: &Task,
        values: &[f64],
        columns: &[Handle],
        mut row: impl FnMut(f64, &[Value]) -> Result<(), E>,
    ) -> Result<(), E> {
        let mut process = Process::new(self.fmu, task, self.limits, self.scratch, 0)?;
        process.name(self.name, self.echo);
        process.record(Record {
            values: values.to_vec(),
            columns: columns.to_vec(),
        });
        let mut payload = Vec::new();
        loop {
            let running = process.running()?;
            let loss = running.wait(self.limits).or_else(|| {
                let read = read_frame(&mut running.answers, &mut payload);
                (!read.unwrap_or(false)).then_some(Loss::Ended)
            });
            if let Some(loss) = loss {
                return Err(process.failure(&loss).into());
            }
            let mut reader = Reader(&payload);
            let end = reader.end();
            if self.echo && !matches!(end, Some(End::Not)) {
                // What it has printed may still be on its way.
                running.last_words.text();
            }
            match end {
                Some(End::Not) => {}
                Some(End::Done) => return Ok(()),
                Some(End::Failed(failure)) => return Err(failure.into()),
                None => return Err(EngineError::Lost("its answer is damaged".to_owned()).into()),
            }
            while let Some((time, values)) = reader.row(columns) {
                row(time, &values)?;
            }
        }
    }
}

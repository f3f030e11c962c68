//! The steps of a component of FMI 2.0, with those that return before they are done.

use std::ffi::c_int;
use std::time::Duration;

use super::functions::Functions;
use super::simulation::{Batch, Model};
use crate::call::{Call, End, Status};
use crate::caller::Caller;
use crate::simulation::Simulation;

/// A status other than `fmi2OK`, by the function that returned it.
pub(super) enum Halt {
    Step(c_int),
    Read(c_int),
}

impl Model {
    /// Takes the steps. Returns how many were taken and read, and why not all.
    #[inline]
    pub(super) fn take(
        &mut self,
        caller: &mut Caller,
        batch: Batch<'_>,
    ) -> (usize, Result<(), Call>) {
        let mut batch = batch;
        let mut halt = None;
        let done = self.usual_steps(caller, batch.from(0), &mut halt);
        match halt {
            None => (done, Ok(())),
            Some(halt) => self.further_steps(caller, done, halt, batch),
        }
    }

    /// The rest of some steps, after one that returned anything but `fmi2OK`.
    #[cold]
    fn further_steps(
        &mut self,
        caller: &mut Caller,
        mut done: usize,
        mut halt: Halt,
        mut batch: Batch<'_>,
    ) -> (usize, Result<(), Call>) {
        loop {
            let rest = batch.from(done);
            let outcome = match halt {
                Halt::Step(status) => self
                    .slow_step(caller, status, rest.times[0], rest.sizes[0])
                    .and_then(|()| match rest.references.len() {
                        0 => Ok(()),
                        width => self.reals(caller, rest.references, &mut rest.rows[..width]),
                    }),
                Halt::Read(status) => caller.check("fmi2GetReal", status),
            };
            if outcome.is_err() {
                return (done, outcome);
            }
            done += 1;
            let mut next = None;
            done += self.usual_steps(caller, batch.from(done), &mut next);
            match next {
                None => return (done, Ok(())),
                Some(next) => halt = next,
            }
        }
    }

    /// Takes steps until one returns anything but `fmi2OK`, and reads after each. Returns how many.
    #[inline(always)]
    fn usual_steps(
        &mut self,
        caller: &mut Caller,
        batch: Batch<'_>,
        halt: &mut Option<Halt>,
    ) -> usize {
        match batch.references.len() {
            0 => self.steps_only(caller, batch.times, batch.sizes, halt),
            _ => self.steps_and_rows(caller, batch, halt),
        }
    }

    #[inline(never)]
    fn steps_only(
        &mut self,
        caller: &mut Caller,
        times: &[f64],
        sizes: &[f64],
        halt: &mut Option<Halt>,
    ) -> usize {
        let (component, do_step) = (self.component, self.functions.do_step);
        caller.call(move || {
            for (taken, (&time, &size)) in times.iter().zip(sizes).enumerate() {
                // SAFETY: the component is alive.
                let status = unsafe { do_step(component, time, size, 1) };
                if status != 0 {
                    *halt = Some(Halt::Step(status));
                    return taken;
                }
            }
            times.len()
        })
    }

    #[inline(never)]
    fn steps_and_rows(
        &mut self,
        caller: &mut Caller,
        batch: Batch<'_>,
        halt: &mut Option<Halt>,
    ) -> usize {
        let Functions {
            do_step, get_real, ..
        } = self.functions;
        let Batch {
            times,
            sizes,
            references,
            rows,
        } = batch;
        let (component, width) = (self.component, references.len());
        assert!(rows.len() >= times.len() * width);
        let (references, mut row) = (references.as_ptr(), rows.as_mut_ptr());
        caller.call(move || {
            for (taken, (&time, &size)) in times.iter().zip(sizes).enumerate() {
                // SAFETY: the component is alive.
                let status = unsafe { do_step(component, time, size, 1) };
                if status != 0 {
                    *halt = Some(Halt::Step(status));
                    return taken;
                }
                // SAFETY: there are `width` references, and as many values in each of the rows.
                let status = unsafe { get_real(component, references, width, row) };
                if status != 0 {
                    *halt = Some(Halt::Read(status));
                    return taken;
                }
                row = row.wrapping_add(width);
            }
            times.len()
        })
    }

    #[cold]
    pub(super) fn slow_step(
        &mut self,
        caller: &mut Caller,
        mut status: c_int,
        time: f64,
        step: f64,
    ) -> Result<(), Call> {
        while Status::from(status) == Status::Pending {
            std::thread::sleep(Duration::from_micros(100));
            status = self.pending_step(caller)?;
        }
        let result = caller.check("fmi2DoStep", status);
        result.map_err(|mut call| {
            if call.status == Status::Discard && self.wants_to_stop(caller) {
                let at = self.reached(caller, time, step);
                call.ended = Some(End { from: time, at });
            }
            call
        })
    }

    /// The present status of a step that returned before it was done.
    fn pending_step(&mut self, caller: &mut Caller) -> Result<c_int, Call> {
        const DO_STEP_STATUS: c_int = 0;
        let forsaken = |why: &str| Call {
            function: "fmi2DoStep",
            status: Status::Pending,
            message: Some(format!("nobody can tell when the step is done, as {why}")),
            ended: None,
        };
        let Some(function) = self.functions.get_status else {
            return Err(forsaken("the FMU does not export fmi2GetStatus"));
        };
        let mut status: c_int = 0;
        // SAFETY: the component is alive, and the status is a valid place to write to.
        let call =
            caller.call(|| unsafe { function(self.component, DO_STEP_STATUS, &raw mut status) });
        match caller.check("fmi2GetStatus", call) {
            Ok(()) => Ok(status),
            Err(Call {
                status: Status::Fatal,
                message,
                ..
            }) => Err(Call {
                status: Status::Fatal,
                message,
                ..forsaken("")
            }),
            Err(call) => {
                let status = call.status.name(call.function);
                Err(forsaken(&format!("fmi2GetStatus returned {status}")))
            }
        }
    }

    /// Whether the FMU refused the step because it wants no further ones.
    fn wants_to_stop(&mut self, caller: &mut Caller) -> bool {
        const TERMINATED: c_int = 3;
        let mut terminated: c_int = 0;
        self.functions.get_boolean_status.is_some_and(|function| {
            // SAFETY: the component is alive, and the flag is a valid place to write to.
            let status = caller
                .call(|| unsafe { function(self.component, TERMINATED, &raw mut terminated) });
            matches!(status, 0 | 1) && terminated != 0
        })
    }

    /// The time up to which a refused step was computed; its beginning where the FMU says nothing sensible.
    fn reached(&mut self, caller: &mut Caller, time: f64, step: f64) -> f64 {
        const LAST_SUCCESSFUL_TIME: c_int = 2;
        let mut reached = time;
        if let Some(function) = self.functions.get_real_status {
            // SAFETY: the component is alive, and the time is a valid place to write to.
            let status = caller.call(|| unsafe {
                function(self.component, LAST_SUCCESSFUL_TIME, &raw mut reached)
            });
            if !matches!(status, 0 | 1) || !(time..=time + step).contains(&reached) {
                return time;
            }
        }
        reached
    }
}

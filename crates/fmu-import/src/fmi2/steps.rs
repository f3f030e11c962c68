//! The steps of a component of FMI 2.0, with those that return before they are done.

use std::ffi::c_int;
use std::time::Duration;

use super::simulation::Model;
use crate::call::{Call, End, Status};
use crate::caller::Caller;
use crate::simulation::{Batch, Simulation};

/// A status other than `fmi2OK`, by the function that returned it.
enum Halt {
    Step(c_int),
    Read(c_int),
}

impl Model {
    /// Takes the steps. Returns how many were taken and read, and why not all.
    pub(super) fn take(
        &mut self,
        caller: &mut Caller,
        mut batch: Batch<'_>,
    ) -> (usize, Result<(), Call>) {
        let mut done = 0;
        loop {
            let outcome = match self.usual_steps(caller, &mut batch, &mut done) {
                Ok(None) => return (done, Ok(())),
                Ok(Some(Halt::Step(status))) => {
                    let (time, size) = (batch.times[done], batch.sizes[done]);
                    let step = self.slow_step(caller, status, time, size);
                    step.and_then(|()| match batch.references {
                        [] => Ok(()),
                        references => self.reals(caller, references, batch.row(done)),
                    })
                }
                Ok(Some(Halt::Read(status))) => caller.check(self.functions.real.get.name, status),
                Err(call) => Err(call),
            };
            if outcome.is_err() {
                return (done, outcome);
            }
            done += 1;
        }
    }

    /// Takes steps from `done` on until one returns anything but `fmi2OK`, reads after each, and counts them.
    #[inline(never)]
    fn usual_steps(
        &self,
        caller: &mut Caller,
        batch: &mut Batch<'_>,
        done: &mut usize,
    ) -> Result<Option<Halt>, Call> {
        let do_step = self.functions.do_step.get()?;
        let get_real = self.functions.real.get.get()?;
        let (component, width) = (self.base.component, batch.references.len());
        let (times, sizes) = (&batch.times[*done..], &batch.sizes[*done..]);
        let rows = &mut batch.rows[*done * width..];
        assert!(rows.len() >= times.len() * width);
        let (references, mut row) = (batch.references.as_ptr(), rows.as_mut_ptr());
        Ok(caller.call(move || {
            for (&time, &size) in times.iter().zip(sizes) {
                // SAFETY: the component is alive.
                let status = unsafe { do_step(component, time, size, 1) };
                if status != 0 {
                    return Some(Halt::Step(status));
                }
                if width > 0 {
                    // SAFETY: there are `width` references, and as many values in each of the rows.
                    let status = unsafe { get_real(component, references, width, row) };
                    if status != 0 {
                        return Some(Halt::Read(status));
                    }
                    row = row.wrapping_add(width);
                }
                *done += 1;
            }
            None
        }))
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
        let (function, component) = (self.functions.get_status, self.base.component);
        let Ok(get) = function.get() else {
            return Err(forsaken("the FMU does not export fmi2GetStatus"));
        };
        let mut status: c_int = 0;
        // SAFETY: the component is alive, and the status is a valid place to write to.
        let call = caller.call(|| unsafe { get(component, DO_STEP_STATUS, &raw mut status) });
        match caller.check(function.name, call) {
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
    fn wants_to_stop(&self, caller: &mut Caller) -> bool {
        const TERMINATED: c_int = 3;
        let (get, mut terminated) = (self.functions.get_boolean_status.get(), 0);
        get.is_ok_and(|get| {
            // SAFETY: the component is alive, and the flag is a valid place to write to.
            let status = caller
                .call(|| unsafe { get(self.base.component, TERMINATED, &raw mut terminated) });
            matches!(status, 0 | 1) && terminated != 0
        })
    }

    /// The time up to which a refused step was computed; its beginning where the FMU says nothing sensible.
    fn reached(&self, caller: &mut Caller, time: f64, step: f64) -> f64 {
        const LAST_SUCCESSFUL_TIME: c_int = 2;
        let (get, mut reached) = (self.functions.get_real_status.get(), time);
        let told = get.is_ok_and(|get| {
            // SAFETY: the component is alive, and the time is a valid place to write to.
            let status = caller.call(|| unsafe {
                get(self.base.component, LAST_SUCCESSFUL_TIME, &raw mut reached)
            });
            matches!(status, 0 | 1) && (time..=time + step).contains(&reached)
        });
        if told { reached } else { time }
    }
}

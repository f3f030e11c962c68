//! The steps of a component of FMI 2.0, with those that return before they are done.

use std::{ffi::c_int, time::Duration};

use super::{functions::GetStatus, simulation::Model};
use crate::{
    call::{Call, Called, EarlyEnd, Status},
    simulation::{Batch, Simulation},
    symbols::Function,
};

/// The questions about a step, as `fmi2StatusKind` numbers them.
const DO_STEP_STATUS: c_int = 0;
const LAST_SUCCESSFUL_TIME: c_int = 2;
const TERMINATED: c_int = 3;

/// A status other than `fmi2OK`, by the function that returned it.
enum Halt {
    Step(c_int),
    Read(c_int),
}

impl Model {
    /// Takes the steps. Returns how many were taken and read, and why not all.
    pub fn take(&mut self, mut batch: Batch) -> (usize, Called) {
        let mut done = 0;
        loop {
            let outcome = match self.usual_steps(&mut batch, &mut done) {
                Ok(None) => return (done, Ok(())),
                Ok(Some(Halt::Step(status))) => {
                    let (time, size) = (batch.times[done], batch.sizes[done]);
                    self.slow_step(status, time, size).and_then(|()| match batch.references {
                        [] => Ok(()),
                        references => self.reals(references, batch.row(done)),
                    })
                }
                Ok(Some(Halt::Read(status))) => self.base.caller.check(self.functions.real.get.name, status),
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
    fn usual_steps(&mut self, batch: &mut Batch, done: &mut usize) -> Called<Option<Halt>> {
        let do_step = self.functions.do_step.get()?;
        let get_real = self.functions.real.get.get()?;
        let (component, width) = (self.base.component, batch.references.len());
        let (times, sizes) = (&batch.times[*done..], &batch.sizes[*done..]);
        let rows = &mut batch.rows[*done * width..];
        assert!(rows.len() >= times.len() * width);
        let (references, mut row) = (batch.references.as_ptr(), rows.as_mut_ptr());
        Ok(self.base.caller.call(move || {
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
    pub fn slow_step(&mut self, mut status: c_int, time: f64, step: f64) -> Called {
        while Status::from(status) == Status::Pending {
            std::thread::sleep(Duration::from_micros(100));
            status = self.pending_step()?;
        }
        self.base.caller.check("fmi2DoStep", status).map_err(|mut call| {
            let stopped = self.functions.get_boolean_status;
            if call.status == Status::Discard && self.told(stopped, TERMINATED, 0).is_some_and(|is| is != 0) {
                let at = self.told(self.functions.get_real_status, LAST_SUCCESSFUL_TIME, time);
                // Its beginning where the FMU says nothing sensible.
                let end = time + step;
                let at = at.filter(|at| (time..=end + 1e-9 * end.abs()).contains(at));
                call.ended = Some(EarlyEnd { from: time, at: at.unwrap_or(time) });
            }
            call
        })
    }

    /// The present status of a step that returned before it was done.
    fn pending_step(&mut self) -> Called<c_int> {
        let forsaken = |why: &str| Call {
            function: "fmi2DoStep",
            status: Status::Pending,
            message: Some(format!("nobody can tell when the step is done, as {why}")),
            ended: None,
        };
        let function = self.functions.get_status;
        if !function.is_there() {
            return Err(forsaken("the FMU does not export fmi2GetStatus"));
        }
        let mut status: c_int = 0;
        // SAFETY: the component is alive, and the status is a valid place to write to.
        let told = self.base.call(function, |get, of| unsafe { get(of, DO_STEP_STATUS, &raw mut status) });
        match told {
            Ok(()) => Ok(status),
            Err(Call { status: Status::Fatal, message, .. }) => {
                Err(Call { status: Status::Fatal, message, ..forsaken("") })
            }
            Err(call) => {
                let status = call.status.name(call.function);
                Err(forsaken(&format!("fmi2GetStatus returned {status}")))
            }
        }
    }

    /// What the FMU tells of a step that it refused; none where it does not.
    fn told<T>(&mut self, function: Function<GetStatus<T>>, kind: c_int, blank: T) -> Option<T> {
        let (get, of, mut value) = (function.get().ok()?, self.base.component, blank);
        // SAFETY: the component is alive, and the value is a valid place to write to.
        let status = self.base.caller.call(|| unsafe { get(of, kind, &raw mut value) });
        matches!(status, 0 | 1).then_some(value)
    }
}

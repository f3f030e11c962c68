//! The steps of a simulation.

use std::ffi::c_int;
use std::time::Duration;

use crate::call::{Call, End, Status};
use crate::floating_point::within;
use crate::instance::Instance;
use crate::library::Functions;

/// A step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Step {
    /// When it begins, s.
    pub time: f64,
    /// How long it is, s.
    pub size: f64,
}

/// A status other than `fmi2OK`, by the function that returned it.
enum Halt {
    Step(c_int),
    Read(c_int),
}

impl Instance {
    /// Lets `step` seconds pass from `time`.
    ///
    /// # Errors
    /// When the step is refused or fails, and when the FMU ends the simulation by itself: then [`Call::ended`] says
    /// when, and the instance holds its last values.
    #[inline(never)]
    pub fn step(&mut self, time: f64, step: f64) -> Result<(), Call> {
        // SAFETY: the component is alive.
        let status = within(&mut self.mode, || unsafe {
            (self.functions.do_step)(self.component, time, step, 1)
        });
        if status == 0 {
            return Ok(());
        }
        self.slow_step(status, time, step)
    }

    /// Lets several steps pass, one after another, and reads real variables after each: `references` names them, and
    /// `rows` gets as many values a step. What a call costs beside the FMU's own work is paid once for all of them.
    ///
    /// Returns how many steps were taken and read, and why not all of them: see [`step`](Self::step) and
    /// [`reals`](Self::reals).
    ///
    /// # Panics
    /// When `rows` has no room for the values of all steps.
    pub fn steps(
        &mut self,
        steps: &[Step],
        references: &[u32],
        rows: &mut [f64],
    ) -> (usize, Result<(), Call>) {
        let width = references.len();
        assert!(
            rows.len() >= steps.len() * width,
            "each step needs a row of its own"
        );
        let mut done = 0;
        while done < steps.len() {
            let (taken, halt) =
                self.usual_steps(&steps[done..], references, &mut rows[done * width..]);
            done += taken;
            let Some(halt) = halt else { break };
            let Step { time, size } = steps[done];
            let outcome = match halt {
                Halt::Step(status) => {
                    self.slow_step(status, time, size)
                        .and_then(|()| match width {
                            0 => Ok(()),
                            _ => self.reals(references, &mut rows[done * width..]),
                        })
                }
                Halt::Read(status) => self.check("fmi2GetReal", status),
            };
            if outcome.is_err() {
                return (done, outcome);
            }
            done += 1;
        }
        (done, Ok(()))
    }

    /// Takes steps until one returns anything but `fmi2OK`.
    #[inline(never)]
    fn usual_steps(
        &mut self,
        steps: &[Step],
        references: &[u32],
        rows: &mut [f64],
    ) -> (usize, Option<Halt>) {
        let Functions {
            do_step, get_real, ..
        } = self.functions;
        let (component, width) = (self.component, references.len());
        if width == 0 {
            return within(&mut self.mode, move || {
                for (taken, step) in steps.iter().enumerate() {
                    // SAFETY: the component is alive.
                    let status = unsafe { do_step(component, step.time, step.size, 1) };
                    if status != 0 {
                        return (taken, Some(Halt::Step(status)));
                    }
                }
                (steps.len(), None)
            });
        }
        within(&mut self.mode, move || {
            let rows = rows.chunks_exact_mut(width);
            for (taken, (step, row)) in steps.iter().zip(rows).enumerate() {
                // SAFETY: the component is alive.
                let status = unsafe { do_step(component, step.time, step.size, 1) };
                if status != 0 {
                    return (taken, Some(Halt::Step(status)));
                }
                // SAFETY: both arrays hold `width` elements.
                let status =
                    unsafe { get_real(component, references.as_ptr(), width, row.as_mut_ptr()) };
                if status != 0 {
                    return (taken, Some(Halt::Read(status)));
                }
            }
            (steps.len(), None)
        })
    }

    #[cold]
    fn slow_step(&mut self, mut status: c_int, time: f64, step: f64) -> Result<(), Call> {
        while Status::from(status) == Status::Pending {
            std::thread::sleep(Duration::from_micros(100));
            status = self.pending_step()?;
        }
        let result = self.check("fmi2DoStep", status);
        result.map_err(|mut call| {
            if call.status == Status::Discard && self.wants_to_stop() {
                let at = self.reached(time, step);
                call.ended = Some(End { from: time, at });
            }
            call
        })
    }

    /// The present status of a step that returned before it was done.
    fn pending_step(&mut self) -> Result<c_int, Call> {
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
        let call = within(&mut self.mode, || unsafe {
            function(self.component, DO_STEP_STATUS, &raw mut status)
        });
        match self.check("fmi2GetStatus", call) {
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
            Err(call) => Err(forsaken(&format!("fmi2GetStatus returned {}", call.status))),
        }
    }

    /// Whether the FMU refused the step because it wants no further ones.
    fn wants_to_stop(&mut self) -> bool {
        const TERMINATED: c_int = 3;
        let mut terminated: c_int = 0;
        self.functions.get_boolean_status.is_some_and(|function| {
            // SAFETY: the component is alive, and the flag is a valid place to write to.
            let status = within(&mut self.mode, || unsafe {
                function(self.component, TERMINATED, &raw mut terminated)
            });
            matches!(status, 0 | 1) && terminated != 0
        })
    }

    /// The time up to which a refused step was computed; its beginning where the FMU says nothing sensible.
    fn reached(&mut self, time: f64, step: f64) -> f64 {
        const LAST_SUCCESSFUL_TIME: c_int = 2;
        let mut reached = time;
        if let Some(function) = self.functions.get_real_status {
            // SAFETY: the component is alive, and the time is a valid place to write to.
            let status = within(&mut self.mode, || unsafe {
                function(self.component, LAST_SUCCESSFUL_TIME, &raw mut reached)
            });
            if !matches!(status, 0 | 1) || !(time..=time + step).contains(&reached) {
                return time;
            }
        }
        reached
    }
}

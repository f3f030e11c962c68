//! The steps of a simulation.

use std::ffi::c_int;
use std::time::Duration;

use crate::call::{Call, End, Status};
use crate::floating_point::within;
use crate::instance::Instance;
use crate::library::Functions;

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

    /// Lets several steps pass, one after another, and reads real variables after each: `times` says when the steps
    /// begin and `sizes` how long they are, in s, `references` names the variables, and `rows` gets as many values a
    /// step. What a call costs beside the FMU's own work is paid once for all of them.
    ///
    /// Returns how many steps were taken and read, and why not all of them: see [`step`](Self::step) and
    /// [`reals`](Self::reals).
    ///
    /// # Panics
    /// When there are not as many times as sizes, or `rows` has no room for the values of all steps.
    #[inline]
    pub fn steps(
        &mut self,
        times: &[f64],
        sizes: &[f64],
        references: &[u32],
        rows: &mut [f64],
    ) -> (usize, Result<(), Call>) {
        assert!(
            times.len() == sizes.len() && rows.len() >= times.len() * references.len(),
            "each step needs a size, and a row of its own"
        );
        let mut halt = None;
        let done = self.usual_steps(times, sizes, references, rows, &mut halt);
        match halt {
            None => (done, Ok(())),
            Some(halt) => self.further_steps(done, halt, times, sizes, references, rows),
        }
    }

    /// The rest of some steps, after one that returned anything but `fmi2OK`.
    #[cold]
    fn further_steps(
        &mut self,
        mut done: usize,
        mut halt: Halt,
        times: &[f64],
        sizes: &[f64],
        references: &[u32],
        rows: &mut [f64],
    ) -> (usize, Result<(), Call>) {
        let width = references.len();
        loop {
            let rest = &mut rows[done * width..];
            let outcome = match halt {
                Halt::Step(status) => {
                    self.slow_step(status, times[done], sizes[done])
                        .and_then(|()| match width {
                            0 => Ok(()),
                            _ => self.reals(references, rest),
                        })
                }
                Halt::Read(status) => self.check("fmi2GetReal", status),
            };
            if outcome.is_err() {
                return (done, outcome);
            }
            done += 1;
            let rest = &mut rows[done * width..];
            let mut next = None;
            done += self.usual_steps(&times[done..], &sizes[done..], references, rest, &mut next);
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
        times: &[f64],
        sizes: &[f64],
        references: &[u32],
        rows: &mut [f64],
        halt: &mut Option<Halt>,
    ) -> usize {
        match references.len() {
            0 => self.steps_only(times, sizes, halt),
            _ => self.steps_and_rows(times, sizes, references, rows, halt),
        }
    }

    #[inline(never)]
    fn steps_only(&mut self, times: &[f64], sizes: &[f64], halt: &mut Option<Halt>) -> usize {
        let (component, do_step) = (self.component, self.functions.do_step);
        within(&mut self.mode, move || {
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
        times: &[f64],
        sizes: &[f64],
        references: &[u32],
        rows: &mut [f64],
        halt: &mut Option<Halt>,
    ) -> usize {
        let Functions {
            do_step, get_real, ..
        } = self.functions;
        let (component, width) = (self.component, references.len());
        assert!(rows.len() >= times.len() * width);
        let (references, mut row) = (references.as_ptr(), rows.as_mut_ptr());
        within(&mut self.mode, move || {
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

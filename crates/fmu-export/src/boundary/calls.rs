//! Functions that have the same arguments in all versions of the standard, under different names. Each version defines them with
//! its own list of `functions`.

/// Defines functions that take nothing but the instance.
macro_rules! plain {
    ($($(#[$doc:meta])* $name:ident = $function:ident, $method:ident;)*) => {$(
        $(#[$doc])*
        pub unsafe fn $name<M: Model>(component: Component) -> Status {
            // SAFETY: as the host vouches.
            unsafe { enter(component, &functions::$function, Instance::<M>::$method) }
        }
    )*};
}
pub(crate) use plain;

/// Defines functions that take or give a number for each state.
macro_rules! vectors {
    ($($(#[$doc:meta])* $name:ident = $function:ident, $method:ident($pointer:ty, $slice:ident);)*) => {$(
        $(#[$doc])*
        pub unsafe fn $name<M: Model>(component: Component, value: $pointer, n: usize) -> Status {
            let body = |instance: &mut Instance<M>| {
                // SAFETY: as the host vouches.
                let value = unsafe { $slice(value, n, "values") }?;
                instance.$method(value)
            };
            // SAFETY: as the host vouches.
            unsafe { enter(component, &functions::$function, body) }
        }
    )*};
}
pub(crate) use vectors;

/// Defines the function that takes the time, and the one that ends a step of the host's solver, which changes nothing.
macro_rules! integration {
    ($(#[$time:meta])* $set_time:ident; $(#[$completed:meta])* $completed_step:ident;) => {
        $(#[$time])*
        pub unsafe fn $set_time<M: Model>(component: Component, time: Real) -> Status {
            let body = |instance: &mut Instance<M>| instance.set_time(time);
            // SAFETY: as the host vouches.
            unsafe { enter(component, &functions::SET_TIME, body) }
        }

        $(#[$completed])*
        pub unsafe fn $completed_step<M: Model>(
            component: Component,
            _no_set_state_prior: Boolean,
            enter_event_mode: *mut Boolean,
            terminate: *mut Boolean,
        ) -> Status {
            let body = |_: &mut Instance<M>| {
                // SAFETY: as the host vouches.
                let flags = unsafe {
                    [
                        place(enter_event_mode, "enterEventMode")?,
                        place(terminate, "terminateSimulation")?,
                    ]
                };
                for flag in flags {
                    *flag = FALSE;
                }
                Ok(Status::Ok)
            };
            // SAFETY: as the host vouches.
            unsafe { enter(component, &functions::COMPLETED_STEP, body) }
        }
    };
}
pub(crate) use integration;

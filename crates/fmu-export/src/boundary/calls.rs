//! The C functions of a version of the standard, from one table: name, arguments, the phases in which each may be called, and
//! what it does.

use super::refusal::Outcome;

/// Defines the C functions for a model, the 44 of FMI 2.0 and the 75 of FMI 3.0:
/// `fmu_export::export!(Tank);`
///
/// Write it once, at the root of a crate whose `crate-type` is `["lib", "cdylib"]`. Which interface a library serves is
/// said by the model description beside it.
#[macro_export]
macro_rules! export {
    ($model:ty) => {
        $crate::export_fmi2! { $model }
        $crate::export_fmi3! { $model }
    };
}

/// Makes the functions of a table, generic over the model `M`, and a macro that exports them to C for one model.
///
/// `texts` give a constant text. `whole` functions have no instance yet, or no status. The others are called in some phases
/// of an instance, which they get, and what they do is `unsafe` as it relies on the host's pointers.
macro_rules! c_functions {
    (
        ($d:tt) $standard:ident $version:ident, $export:ident makes $module:ident;
        types $($type:ident)*;
        texts {$($text_name:ident = $text:literal;)*}
        whole {$(
            $(#[$whole_doc:meta])*
            $whole:ident($($whole_argument:ident: $whole_type:ty),* $(,)?) $(-> $result:ty)? => $run:expr;
        )*}
        calls {$(
            $(#[$doc:meta])*
            $call:ident($($argument:ident: $of:ty),* $(,)?) in $phases:expr => |$instance:tt| $body:expr;
        )*}
    ) => {
        use super::types::{$($type),*};

        $(
            #[doc = concat!("`", stringify!($whole), "`.")]
            $(#[$whole_doc])*
            #[allow(non_snake_case, unused_variables)]
            pub unsafe fn $whole<M: Model>($($whole_argument: $whole_type),*) $(-> $result)? {
                // SAFETY: as the host vouches.
                unsafe { $run }
            }
        )*

        $(
            #[doc = concat!("`", stringify!($call), "`.")]
            $(#[$doc])*
            #[allow(non_snake_case, unused_variables, unused_unsafe)]
            pub unsafe fn $call<M: Model>(component: Component, $($argument: $of),*) -> Status {
                const FUNCTION: Function = Function { name: stringify!($call), version: Version::$version, phases: $phases };
                // SAFETY: as the host vouches.
                let body = |$instance: &mut Instance<M>| -> Outcome { unsafe { $body } };
                // SAFETY: as the host vouches.
                unsafe { enter(component, &FUNCTION, body) }
            }
        )*

        /// Exports the functions for a model; [`export!`](crate::export) calls it.
        #[doc(hidden)]
        #[macro_export]
        macro_rules! $export {
            ($d model:ty) => {
                /// The C functions of one version of FMI. `calls` of `fmu_export` says what they rely on.
                #[allow(non_snake_case, missing_docs)]
                #[allow(clippy::missing_safety_doc, clippy::too_many_arguments)]
                pub mod $module {
                    // The model. If its crate has a type `Status`, too, the one below counts: it is imported by its name.
                    #[allow(unused_imports)]
                    use super::*;
                    use $crate::$standard::calls;
                    use $crate::$standard::types::{$($type),*};

                    $(
                        #[unsafe(no_mangle)]
                        pub extern "C" fn $text_name() -> Text {
                            $text.as_ptr()
                        }
                    )*

                    $(
                        #[unsafe(no_mangle)]
                        pub unsafe extern "C" fn $whole($($whole_argument: $whole_type),*) $(-> $result)? {
                            // SAFETY: the generic function asks the same of its caller.
                            unsafe { calls::$whole::<$d model>($($whole_argument),*) }
                        }
                    )*

                    $(
                        #[unsafe(no_mangle)]
                        pub unsafe extern "C" fn $call(component: Component, $($argument: $of),*) -> Status {
                            // SAFETY: the generic function asks the same of its caller.
                            unsafe { calls::$call::<$d model>(component, $($argument),*) }
                        }
                    )*
                }
            };
        }
    };
}
pub(crate) use c_functions;

/// Answers with a value.
pub fn answer<T>(place: &mut T, value: T) -> Outcome {
    *place = value;
    Ok(())
}

/// Answers that nothing has happened.
pub fn nothing<T: Default, const N: usize>(flags: [&mut T; N]) -> Outcome {
    for flag in flags {
        *flag = T::default();
    }
    Ok(())
}

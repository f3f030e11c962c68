//! The boundary's behaviour, as a C host sees it.
//!
//! Miri can run these tests, without the host's log:
//! `MIRIFLAGS=-Zmiri-deterministic-floats cargo +nightly miri test -p fmu-export --test boundary`.
// The host's logger stands in for a variadic one, which Apple's arm64 convention does not allow.
#![cfg(not(all(target_vendor = "apple", target_arch = "aarch64")))]
#![allow(clippy::unwrap_used)]

mod arguments;
mod derivatives;
mod exchange;
mod host;
mod intermediate;
mod life;
mod states;
mod three;

/// The lag's exact answer to a constant input after `t` seconds, from its start values.
fn answer(input: f64, t: f64) -> f64 {
    let end = 2.0 * input;
    end + (1.0 - end) * (-t / 0.5_f64).exp()
}

//! The errors of a film, and the checks that find them.

use thiserror::Error;

/// Refuses a value unless it is usable.
pub fn within(name: &'static str, value: f64, usable: bool, must: &'static str) -> Result<(), FilmError> {
    if usable { Ok(()) } else { Err(FilmError::Setting { name, value, must }) }
}

/// Refuses what is not positive.
pub fn positive(name: &'static str, value: f64) -> Result<(), FilmError> {
    let usable = value.is_finite() && value > 0.0;
    within(name, value, usable, "a positive number")
}

pub fn finite(name: &'static str, value: f64) -> Result<(), FilmError> {
    within(name, value, value.is_finite(), "a finite number")
}

/// Why a film cannot be set up or advanced.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum FilmError {
    /// A setting, the interval or a number of the drive is out of range.
    #[error("the film's {name} is {value:?}; it must be {must}")]
    Setting {
        /// The setting's name.
        name: &'static str,
        /// Its value.
        value: f64,
        /// The rule that it breaks.
        must: &'static str,
    },
    /// The surfaces touch at the starting eccentricity ratio, which is given.
    #[error("form error and tilt leave no gap at eccentricity ratio {0:?}; reduce them, or start nearer the centre")]
    NoGap(f64),
    /// Tilt or form error bring smooth surfaces together under the load, at the eccentricity ratio given.
    #[error(
        "tilt or form error bring the smooth surfaces together at eccentricity ratio {0:?}, where no film carries the load; give the surfaces a roughness, or reduce them"
    )]
    Touches(f64),
    /// The film's balances found no solution, however short the internal step.
    #[error("the film's step did not converge at eccentricity ratio {eccentricity:?} with steps of {step:?} s")]
    NotConverged {
        /// The eccentricity ratio at which it happened, 1.
        eccentricity: f64,
        /// The shortest internal step tried, s.
        step: f64,
    },
}

//! The bearing: film, asperity contact and friction of the journal in its bush.
//!
//! The frame's origin is the bush's centre. x lies along the load, y a quarter turn ahead of it in the direction of
//! positive shaft rotation. The journal's centre is at `c*(ex, ey)`, with the present radial clearance c and the
//! eccentricity-ratio vector `(ex, ey)`. The attitude angle is the angle from the load line to the eccentricity, positive
//! in the direction of rotation.

mod film;
pub mod friction;
mod hot;
mod journal;
mod parameters;
mod supply;
mod wear;

pub use film::{FILM, Film, FilmModel, sommerfeld};
pub use hot::{Expansion, ThermalClearance};
pub use journal::{Drift, FilmSetup, Flows, Interval, Motion, Passed, Press, Situation, Strain, TransientFilm};
pub use parameters::{Bearing, FilmEnergy, Resolution};
pub use supply::{Feeding, Supply};
pub use wear::Wear;

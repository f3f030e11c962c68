//! The Reynolds equation of the film between journal and bush.
//!
//! # Frame
//! Fixed frame, origin in the bush centre, `x` along the load line (a positive load pushes the
//! journal to `+x`), `y` 90 degrees ahead in the direction of positive rotation
//! (counter-clockwise). `eps = (ex, ey) / c` is the eccentricity-ratio vector from the bush centre
//! to the journal centre. `theta` is measured counter-clockwise; with `n = (cos theta, sin theta)`
//! the gap is `h = c H`, `H = 1 - eps . n`: smallest in the direction of `eps`.
//!
//! # Equation
//! With journal and bush turning at a mean `omega = (omega_journal + omega_bush) / 2`, the wedge
//! and squeeze terms together are `omega dh/dtheta + dh/dt = -c v . n`, where
//! `v = d eps/dt - omega z x eps` is the velocity of the eccentricity as seen from a frame that turns
//! with `omega` (Booker 1965, "Dynamically loaded journal bearings: mobility method of solution").
//! With the pressure `p = 12 eta (R/c)^2 P` and `zeta = 2 z / B`, the Reynolds equation (1886) is
//!
//! ```text
//! d/dtheta(H^3 dP/dtheta) + (D/B)^2 d/dzeta(H^3 dP/dzeta) = -v . n
//! ```
//!
//! and the external load that the film carries is `F = 12 eta (R/c)^2 R B W`, `W` the integral of
//! `P n` over `theta` and `zeta` in 0..1 (the mean over the width).

mod active_set;
mod asperities;
mod assembly;
mod balance;
mod block;
mod cells;
mod centring;
mod compression;
mod diagnostics;
mod field;
mod film;
mod gap;
mod grid;
mod landing;
mod lanes;
mod linear;
mod liquid;
mod newton;
mod quasi_static;
mod ring;
mod roughness;
mod settings;
mod skyline;
mod step;
mod stress;
mod support;
mod thickening;
mod way;

#[cfg(test)]
mod compression_tests;
#[cfg(test)]
mod film_tests;
#[cfg(test)]
mod life_tests;
#[cfg(test)]
mod quasi_static_tests;
#[cfg(test)]
mod ring_tests;

pub use asperities::Asperities;
pub use cells::Cavitation;
pub use diagnostics::Diagnostics;
pub use film::ReynoldsFilm;
pub use grid::Grid;
pub use quasi_static::{Boundary, Carried, NotConverged, QuasiStatic};
pub use roughness::{RoughFilm, pressure_flow_factor, shear_flow_factor};
pub use settings::{Drive, FilmError, FilmSettings};
pub use stress::{pressure_stress_factor, shear_stress_factor, sliding_stress_factor};

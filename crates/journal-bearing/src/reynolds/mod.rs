//! The Reynolds equation for the film between journal and bush.
//!
//! [`ReynoldsFilm`] is the transient film with mass-conserving cavitation; it carries its journal along. [`QuasiStatic`]
//! is the film with `p >= 0` and no memory, from which the mobility map is made.
//!
//! # Frame
//! The frame is fixed in the bush centre. `x` lies along the load line: a positive load pushes the journal to `+x`. `y`
//! is 90 degrees ahead in the direction of positive (counter-clockwise) rotation. `eps = (ex, ey) / c` is the
//! eccentricity-ratio vector from the bush centre to the journal centre. `theta` is measured counter-clockwise. With
//! `n = (cos theta, sin theta)` the gap is `h = c H`, `H = 1 - eps . n`: it is smallest in the direction of `eps`.
//!
//! # Equation
//! Journal and bush turn at the mean `omega = (omega_journal + omega_bush) / 2`. The wedge and squeeze terms together
//! are `omega dh/dtheta + dh/dt = -c v . n`, where `v = d eps/dt - omega z x eps` is the velocity of the eccentricity
//! seen from a frame that turns with `omega` (Booker 1965, J. Basic Eng. 87, 537-546). With the pressure
//! `p = 12 eta (R/c)^2 P` and `zeta = 2 z / B`, the Reynolds equation (Reynolds 1886, Phil. Trans. R. Soc. 177) is
//!
//! ```text
//! d/dtheta(H^3 dP/dtheta) + (D/B)^2 d/dzeta(H^3 dP/dzeta) = -v . n
//! ```
//!
//! The film carries the external load `F = 12 eta (R/c)^2 R B W`, where `W` is the integral of `P n` over `theta` and
//! `zeta` in 0..1 (the mean over the width). `P`, `v` and `W` have the unit 1/s.

mod coefficients;
mod error;
mod feed;
mod grid;
mod lanes;
mod quasi_static;
mod ring;
mod settings;
mod transient;

pub use crate::roughness::{
    RoughFilm, mean_gap, pressure_flow_factor, shear_flow_factor, shear_stress_factor, sliding_stress_factor,
};
pub use coefficients::Coefficients;
pub use error::FilmError;
pub use feed::{Feed, FeedShape};
pub use grid::Grid;
pub use quasi_static::{Boundary, Carried, Groove, NotConverged, QuasiStatic};
pub use settings::{Cavitation, Drive, FilmSettings};
pub use transient::{Diagnostics, FilmState, HeatExchange, HeatGiven, PeriodicSearch, ReynoldsFilm};

//! Mobility of a journal bearing: how fast a load moves the journal.
//!
//! In the frame of [`reynolds`](super::reynolds), a bearing of radial clearance `c`, radius `R`,
//! width `B` and diameter `D`, filled with oil of viscosity `eta` and loaded by `F`, moves its
//! journal by (Booker 1965, 1971; eq. 2 of the paper)
//!
//! ```text
//! d eps/dt = |F| (c/R)^2 / (eta B D) * M + omega z x eps
//! ```
//!
//! where `M` depends on the eccentricity ratio, on the direction of the load relative to the
//! eccentricity and on `B/D` only, and `omega = (omega_journal + omega_bush) / 2` is the *mean* rotation of
//! the two surfaces: a bush that turns drags as much oil along as a journal. For an oil film
//! whose pressure is nowhere below that of the surroundings the relation is exact, not a fit.
//!
//! # Where the numbers come from
//! Goenka's (1984) curve-fit coefficients were not found in any public source. The numbers here
//! are no fit of his kind: they are the solutions of our own [`QuasiStatic`](super::reynolds::QuasiStatic)
//! film, tabulated by [`generate`] (`cargo run --release --bin mobility-map`) and interpolated
//! with a continuous first derivative.
//!
//! # What is interpolated
//! The logarithm of `|M|` and the angle by which `M` leads the load, over
//! `u = -ln(1 - e)`, over the load direction stretched by `sqrt(1 - e)` (see [`coordinates`]), and
//! over `ln(B/D)`. Powers of the smallest gap and of `B/D`, the asymptotes of the lubrication
//! theory, are straight lines in these coordinates; beyond the table they are continued as such:
//! under a finite load the journal never reaches the bush.

mod coordinates;
mod family;
mod generate;
mod map;
mod slice;
mod spline;

pub use family::SliceFamily;
pub use generate::{Sample, exact, generate};
pub use map::{MapError, MobilityMap};
pub use slice::{Film, MobilitySlice};

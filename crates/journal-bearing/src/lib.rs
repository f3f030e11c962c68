//! Oil films of plain journal bearings.
//!
//! Two models of the film between a turning journal and its bush:
//! - [`reynolds`]: the two-dimensional Reynolds equation, transient, with mass-conserving cavitation, roughness, form error,
//!   tilt, and oils whose viscosity and density depend on pressure;
//! - [`mobility`]: Booker's mobility method on a map computed with [`reynolds`]; a look-up takes about 0.13 us.
//!
//! [`contact`] of asperities, [`profile`]s of surfaces that are not round and the oil's [`rheology`] go with them. All
//! quantities are in SI units. Vectors are those of [`nalgebra`], which is re-exported.
//!
//! # Examples
//! The journal's orbit under a load that varies with each turn, for one turn, by the Reynolds equation:
//! ```
//! use journal_bearing::nalgebra::Vector2;
//! use journal_bearing::reynolds::{Drive, FilmSettings, ReynoldsFilm};
//!
//! let mut film = ReynoldsFilm::new(FilmSettings::new(0.019, 0.025, 20e-6))?;
//! let speed = 31.416; // rad/s
//! let load = |t: f64| Vector2::new(750.0 * (1.0 + 0.2 * (speed * t).sin()), 0.0); // N
//! let step = 2e-3; // s
//! let mut thinnest = f64::INFINITY;
//! for k in 0..100 {
//!     let t = step * f64::from(k);
//!     let drive = Drive {
//!         load_before: load(t),
//!         load_after: load(t + step),
//!         ..Drive::steady(Vector2::zeros(), speed, 0.02)
//!     };
//!     let report = film.advance(step, &drive, &|_| 0.0)?;
//!     thinnest = report.smallest_gap.min(thinnest);
//! }
//! assert!(thinnest > 1e-6 && thinnest < 4e-6); // m
//! # Ok::<(), journal_bearing::reynolds::FilmError>(())
//! ```
//!
//! The same bearing by the mobility method needs only the velocity, which any integrator of ordinary differential equations
//! can follow; see [`mobility::MobilitySlice::look_up`].

#![forbid(unsafe_code)]

pub use nalgebra;

pub mod contact;
pub mod mobility;
pub mod profile;
pub mod reynolds;
pub mod rheology;
mod roughness;
mod spline;

/// The README's example, as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

//! Oil films of plain journal bearings.
//!
//! Two models of the film between a turning journal and its bush:
//! - [`reynolds`]: the Reynolds equation in two dimensions, transient, with mass-conserving cavitation,
//!   roughness, form error, tilt and elastic oil laws;
//! - [`mobility`]: Booker's mobility method on a map that was computed with [`reynolds`], some thousand times faster.
//!
//! Beside them stand what both need: [`contact`] of asperities, [`profile`]s of surfaces that are not round, and
//! the oil's [`rheology`]. All quantities are in SI units.

pub use nalgebra;

pub mod contact;
pub mod literature;
pub mod mobility;
pub mod profile;
pub mod reynolds;
pub mod rheology;

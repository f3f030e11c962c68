//! A second, tiny FMU from the same boundary: a first-order lag.
//!
//! It shows how another model becomes an FMU, and serves the tests as a model that can be checked
//! by hand and that fails on demand. It takes the sources of the boundary, not the library, since
//! that exports the stand under the same C names.

#[path = "../../src/fmi2/mod.rs"]
pub mod fmi2;
#[path = "model.rs"]
pub mod lag;
#[path = "../../src/model.rs"]
pub mod model;

export!(lag::Lag);

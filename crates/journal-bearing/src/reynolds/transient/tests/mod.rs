//! Tests of the transient film as a whole.

mod compression;
mod film;
mod lives;
mod periodic;

//! Tests of the transient film as a whole.

mod compression;
mod feed;
mod film;
mod lives;
mod periodic;
mod warm;

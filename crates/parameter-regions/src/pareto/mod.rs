//! Many criteria at once: which points no other point beats in everything.
//!
//! The objectives are the normalised deviations of the criteria; all are minimised.

mod front;
pub mod study;

pub use front::front;

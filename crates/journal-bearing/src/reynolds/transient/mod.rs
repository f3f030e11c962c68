//! The transient film, from the ground up; each layer uses only those above it in this list.
//!
//! * `sweeps`: arithmetic over arrays, with that of `lanes` in an order that is the same on every machine.
//! * `cells`, `gap`, `state`, `stage`, `liquid`, `upwind`, `balance`, `active_set`: the film cell by cell.
//! * `linear`: the balances linearised, and their matrix, which `ring` factorises.
//! * `geometry`, `workspace`: the film at a place of the journal, with all buffers; a step allocates nothing.
//! * `asperities`, `forces`, `way`: the journal in it.
//! * `newton`, `landing`: the solution of one implicit stage.
//! * `warmth`, `heating`: the film's temperature around the bearing.
//! * `compression`, `evaluation`, `step`: one internal step of two stages, with its forces, flows and balances.
//! * `periodic`: the search for the orbit that a turn of the load leads back to.
//! * `film`: intervals of controlled error, and the public face.

mod active_set;
mod asperities;
mod balance;
mod cells;
mod coefficients;
mod compression;
mod diagnostics;
mod evaluation;
mod film;
mod forces;
mod gap;
mod geometry;
mod heating;
mod landing;
mod linear;
mod liquid;
mod newton;
mod periodic;
mod stage;
mod state;
mod step;

mod sweeps;
mod upwind;
mod warmth;
mod way;
mod workspace;

#[cfg(test)]
mod tests;

pub use diagnostics::Diagnostics;
pub use film::{FilmState, ReynoldsFilm};
pub use periodic::PeriodicSearch;
pub use warmth::{HeatExchange, HeatGiven};

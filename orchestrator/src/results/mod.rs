//! The files of a study: the journal while it runs, `points.csv` and `summary.json` when
//! it is done.
//!
//! The final files are a function of the study, the FMU and the journal's content alone, so they
//! are the same, byte for byte, however the points were computed; only [`Summary::run`] and [`Summary::conduct`] tell how that
//! was, and a verdict by a rule knows of those that were drawn before ([`Looked`]).

pub mod answer;
pub mod asides;
pub mod by_surrogate;
pub mod choice;
pub mod concerns;
mod failed;
pub mod looked;
pub mod origin;
pub mod points;
mod resampled;
pub mod settled;
pub mod summary;
pub mod surrogate;
pub mod survey;
pub mod table;
pub mod tally;
pub mod validity;
pub mod words;

pub use concerns::{FEWEST, confusions};
pub use failed::place;
pub use looked::Looked;
pub use settled::MOST_EXTRA_RUNS;
pub use summary::Summary;

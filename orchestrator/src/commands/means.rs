//! With how many cores a study is run.

use std::num::NonZeroUsize;
use std::thread::available_parallelism;

use crate::cli::Means;

impl Means {
    /// How many simulations at a time: as many as cores, unless the user says otherwise.
    pub(super) fn jobs(&self) -> usize {
        let cores = || available_parallelism().map_or(1, Into::into);
        self.jobs.map_or_else(cores, NonZeroUsize::get)
    }
}

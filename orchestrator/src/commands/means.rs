//! With what a study is run: the FMU and the cores.

use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::thread::available_parallelism;

use crate::cli::Means;
use crate::study::Study;

impl Means {
    /// The FMU that the user names, or else the study's.
    pub(super) fn fmu(&self, study: &Study) -> PathBuf {
        self.fmu.clone().unwrap_or_else(|| study.fmu_path())
    }

    /// How many simulations at a time: as many as cores, unless the user says otherwise.
    pub(super) fn jobs(&self) -> usize {
        let cores = || available_parallelism().map_or(1, Into::into);
        self.jobs.map_or_else(cores, NonZeroUsize::get)
    }
}

//! A study with everything that its run needs: tied to its FMU, its points known.

mod finale;
mod request;
mod until;

use std::fs;
use std::path::{Path, PathBuf};

use tempfile::TempDir;
use thiserror::Error;

use crate::engine::crew::{Crew, Place};
use crate::engine::{EngineError, Job};
use crate::judge::Judge;
use crate::results::finished::Finished;
use crate::results::lines;
use crate::results::{Header, Journal, Outcome, ResultsError};
use crate::source::Source;
use crate::study::plan::Plan;
use crate::study::{Study, StudyError};
use crate::table::TableError;
use fmu_import::{FmuError, Package, digest};

pub use finale::{FileSet, provenance};
pub use request::{Request, Shard};
pub use until::{Front, Until};

/// Why a study cannot be run.
#[derive(Debug, Error)]
pub enum SessionError {
    /// The FMU cannot be used.
    #[error(transparent)]
    Fmu(#[from] FmuError),
    /// The study cannot be used.
    #[error(transparent)]
    Study(#[from] StudyError),
    /// A table cannot be used.
    #[error(transparent)]
    Table(#[from] TableError),
    /// The results cannot be written or read.
    #[error(transparent)]
    Results(#[from] ResultsError),
    /// The points cannot be run.
    #[error(transparent)]
    Engine(#[from] EngineError),
}

/// A study that is ready to run.
#[derive(Debug)]
pub struct Session {
    /// What was asked for.
    pub request: Request,
    /// The study.
    pub study: Study,
    /// The FMU.
    pub package: Package,
    /// The study, tied to the FMU.
    pub plan: Plan,
    /// The criteria.
    pub judge: Judge,
    /// The points.
    pub source: Source,
    header: Header,
}

impl Session {
    /// Reads the study, the FMU and, where one is given, the table of points.
    ///
    /// # Errors
    /// When any of them cannot be used.
    pub fn open(request: Request) -> Result<Self, SessionError> {
        let mut study = Study::read(&request.study)?;
        if let Some(folder) = &request.base {
            study.rebase(folder.clone());
        }
        study.design.points = request.points.unwrap_or(study.design.points);
        study.design.seed = request.seed.unwrap_or(study.design.seed);
        let fmu = request.fmu.clone().unwrap_or_else(|| study.fmu_path());
        let package = Package::open(&fmu)?;
        let judge = Judge::new(&study, Some(package.description()))?;
        let plan = Plan::new(&study, package.description())?;
        let (source, table) = match &request.points_from {
            Some(path) => {
                let source = Source::from_table(&study, &plan.inputs, path)?;
                let bytes = fs::read(path).map_err(ResultsError::io(path))?;
                (source, Some(digest(&bytes)))
            }
            None => {
                let design = plan.design(&study.design);
                let design =
                    design.map_err(|message| study.error(format!("[design] {message}")))?;
                (Source::Design(design), None)
            }
        };
        let header = Header {
            orchestrator: env!("CARGO_PKG_VERSION").to_owned(),
            study: study.digest(),
            fmu: package.digest()?,
            table,
            seed: study.design.seed,
            points: source.len(),
            shard: request.shard.map(|shard| shard.to_string()),
        };
        Ok(Self {
            request,
            study,
            package,
            plan,
            judge,
            source,
            header,
        })
    }

    /// Opens the study of a folder again, as it was run there; `fmu` is another place of the FMU.
    ///
    /// # Errors
    /// When there is none, or the FMU is another one.
    pub fn reopen(folder: &Path, fmu: Option<PathBuf>) -> Result<Self, SessionError> {
        let mut request = Request::read(folder)?;
        request.fmu = fmu.or(request.fmu);
        let session = Self::open(request)?;
        let then = lines::header(folder)?;
        session.header.check(&then, folder)?;
        Ok(session)
    }

    /// What the journal of this session belongs to.
    pub fn header(&self) -> &Header {
        &self.header
    }

    /// The indexes of the points of this session: all, or those of its shard.
    pub fn indexes(&self) -> impl Iterator<Item = u64> + Send + use<> {
        let (first, step) = match self.request.shard {
            Some(shard) => (shard.number - 1, shard.of),
            None => (0, 1),
        };
        let step = usize::try_from(step).unwrap_or(usize::MAX);
        (first..self.source.len()).step_by(step)
    }

    /// How many points this session has.
    pub fn expected(&self) -> u64 {
        match self.request.shard {
            Some(shard) => (self.source.len() + shard.of - shard.number) / shard.of,
            None => self.source.len(),
        }
    }

    /// How many points may be enough already: a Latin hypercube needs all of its points.
    pub fn is_extensible(&self) -> bool {
        self.header.table.is_some() || self.study.design.method.is_extensible()
    }

    /// The journal of a folder: a new one, or with `resume` the one that is there. A study that
    /// is complete, or has no point yet, is simply done again.
    ///
    /// # Errors
    /// When the folder holds something else, and when the system says no.
    pub fn journal(
        &self,
        folder: &Path,
        resume: bool,
    ) -> Result<(Journal, Option<Finished>), SessionError> {
        if resume && lines::path_in(folder).exists() {
            let (journal, finished) = Journal::resume(folder, &self.header)?;
            // A run that was killed early may not have come so far.
            self.request.write(folder, &self.study)?;
            return Ok((journal, Some(finished)));
        }
        let complete = folder.join("summary.json").exists();
        // Nothing is lost with a run that came to no point, because its FMU could not be loaded.
        let vain = || Finished::read(folder).is_ok_and(|finished| finished.count == 0);
        if lines::path_in(folder).exists() && (complete || vain()) {
            Journal::remove(folder)?;
        }
        let journal = Journal::create(folder, &self.header)?;
        self.request.write(folder, &self.study)?;
        Ok((journal, None))
    }

    /// A point to run.
    pub fn job(&self, index: u64) -> Job {
        let mut values = Vec::new();
        self.plan
            .to_fmu(&self.source.parameters(index), &mut values);
        Job { index, values }
    }

    /// An answer in the study's units.
    pub fn outcome(&self, answer: crate::engine::Answer) -> Outcome {
        answer.map(|mut values| {
            self.plan.to_study(&mut values);
            values
        })
    }

    /// The crew that runs its points, so many at a time; `scratch` is a folder for their files.
    ///
    /// # Errors
    /// When the FMU cannot be unpacked or loaded.
    pub fn crew(
        &mut self,
        place: Place,
        scratch: &Path,
        jobs: usize,
    ) -> Result<Crew, SessionError> {
        Ok(Crew::new(&mut self.package, place, scratch, jobs)?)
    }
}

/// A folder within `folder` for what is needed while points run. Those of runs that were killed
/// are removed; the journal's lock says that they are not in use.
///
/// # Errors
/// When the system says no.
pub fn scratch(folder: &Path) -> Result<TempDir, ResultsError> {
    const PREFIX: &str = ".running-";
    const LEFT_OVERS: [&str; 3] = [PREFIX, ".points-", ".writing-"];
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let name = entry.file_name();
        if LEFT_OVERS
            .iter()
            .any(|prefix| name.to_string_lossy().starts_with(prefix))
        {
            // What cannot be removed only takes up room.
            let _ = fs::remove_dir_all(entry.path()).or_else(|_| fs::remove_file(entry.path()));
        }
    }
    let scratch = tempfile::Builder::new().prefix(PREFIX).tempdir_in(folder);
    scratch.map_err(ResultsError::io(folder))
}

//! The set-up of a run, whatever it is for: its folder, its processes, and the pipeline from one to the other.

use crate::{
    error::{Error, Result},
    options::Means,
    session::{Request, Session, Verification},
};
use fmu_import::Package;
use fmu_points::{crew::Crew, task::Case};
use point_journal::{
    Header, Lock, lines,
    pipeline::{
        Model, Pipeline, ShardPart,
        folder::{Earlier, Kept, RunFolder},
    },
};
use std::path::{Path, PathBuf};
use study::Study;

/// A study that is tied to its FMU, whose points are run.
pub trait Runnable {
    /// The FMU.
    fn package(&mut self) -> &mut Package;

    /// All else that a run needs.
    fn parts(&self) -> SourceParts<'_>;
}

/// The parts of its source that a run needs.
pub struct SourceParts<'a> {
    /// The user's request.
    pub request: &'a Request,
    /// The study.
    pub study: &'a Study,
    /// The FMU.
    pub package: &'a Package,
    /// Translates points and their outcomes.
    pub model: &'a dyn Model,
    /// The simulations of a point.
    pub cases: &'a [Case],
}

impl Runnable for Session {
    fn package(&mut self) -> &mut Package {
        &mut self.package
    }

    fn parts(&self) -> SourceParts<'_> {
        SourceParts {
            request: &self.request,
            study: &self.study,
            package: &self.package,
            model: self,
            cases: &self.plan.cases,
        }
    }
}

impl Runnable for Verification {
    fn package(&mut self) -> &mut Package {
        &mut self.session.package
    }

    fn parts(&self) -> SourceParts<'_> {
        self.session.parts()
    }
}

/// Where the results of a run go.
pub struct ResultFolder<'a> {
    /// The folder of all results.
    pub output: &'a Path,
    /// The analysis that keeps its journal in a folder of its own there.
    pub analysis: Option<&'static str>,
    /// The treatment of an earlier run.
    pub earlier: Earlier,
}

impl ResultFolder<'_> {
    /// The folder of the journal.
    pub fn state(&self) -> PathBuf {
        self.analysis.map(|name| self.output.join(name)).unwrap_or_else(|| self.output.to_owned())
    }

    /// Takes the folder for a run, and keeps there what was asked for. `prepare` may change what an earlier run left, when
    /// nobody else has the folder any more.
    ///
    /// # Errors
    /// When the folder holds something else, and when the system says no.
    pub fn take(&self, source: SourceParts, header: &Header, prepare: impl FnOnce() -> Result) -> Result<RunFolder> {
        let SourceParts { request, study, .. } = source;
        request.check(self.output, self.analysis, Some(study), self.earlier)?;
        if self.analysis.is_none() {
            request.check_files(self.output, self.earlier)?;
        }
        let state = self.state();
        let lock = Lock::take(&state)?;
        prepare()?;
        let complete = self.analysis.is_none() && state.join("summary.json").exists();
        let taken = RunFolder::open(lock, &state, header, self.earlier, complete)?;
        // A run that was killed early may not have come so far.
        request.write(&state, study)?;
        Ok(taken)
    }
}

/// The processes of a run, and how many points they compute at a time.
#[derive(Debug)]
pub struct Work<'a> {
    /// The processes and their limits.
    pub means: &'a Means,
    /// How many points at a time.
    pub jobs: usize,
    /// Whether no further points are needed once the analysis has its answer.
    pub ends: bool,
}

/// Hands the points that `ask` wants to processes, and notes them in the folder. Nobody else gets the folder as long as what
/// comes with the answer is there.
///
/// # Errors
/// Those of the processes, of the system, and of `ask`; whichever it is, one that says so where the folder was removed.
pub fn run<S: Runnable, T>(
    source: &mut S,
    header: &Header,
    folder: RunFolder,
    work: Work,
    ask: impl FnOnce(&S, &mut Pipeline) -> Result<T>,
) -> Result<(T, Kept)> {
    let place = folder.journal.folder().to_owned();
    let RunFolder { journal, finished, kept } = folder;
    let told = || {
        let crew = Crew::new(source.package(), work.means.place(work.jobs)?, kept.scratch.path(), work.jobs)?;
        let source = &*source;
        let parts = source.parts();
        let part = ShardPart::of(parts.request.shard, header);
        let mut pipeline = Pipeline::new(parts.model, (&crew, parts.cases), journal, finished, part);
        let told = ask(source, &mut pipeline);
        if told.is_ok() && work.ends {
            pipeline.end()?
        } else {
            pipeline.pause()?
        }
        told
    };
    let told = told();
    if lines::path_in(&place).exists() {
        Ok((told?, kept))
    } else {
        Err(Error::Refused(format!(
            "{}: this folder, or the journal in it, was removed or moved while points ran; run the command again",
            place.display()
        )))
    }
}

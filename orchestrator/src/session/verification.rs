//! The points of `verify`: a design's, or those of a table.

use std::fs;
use std::path::{Path, PathBuf};

use super::{Ending, Request, Session, SessionError, Until};
use crate::engine::Job;
use crate::pipeline::{Model, Shard};
use crate::results::{Header, ResultsError, lines};
use crate::source::Source;
use fmu_import::digest;

/// A study whose points are known beforehand.
#[derive(Debug)]
pub struct Verification {
    /// The study.
    pub session: Session,
    /// The points.
    pub source: Source,
    header: Header,
}

impl Verification {
    /// Reads the study, the FMU and, where one is given, the table of points.
    ///
    /// # Errors
    /// When any of them cannot be used.
    pub fn open(request: Request) -> Result<Self, SessionError> {
        let session = Session::open(request)?;
        let Session { study, plan, .. } = &session;
        let (source, table) = match &session.request.points_from {
            Some(path) => {
                let source = Source::from_table(study, &plan.inputs, path)?;
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
            table,
            ..session.header(study.design.seed, Some(source.len()))?
        };
        Ok(Self {
            session,
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
        let verification = Self::open(request)?;
        let then = lines::header(folder)?;
        verification.header.check(&then, folder)?;
        Ok(verification)
    }

    /// Identity of the run.
    pub fn header(&self) -> &Header {
        &self.header
    }

    /// The part of the points that is to be run.
    pub fn shard(&self) -> Shard {
        self.session.request.shard.unwrap_or(Shard::WHOLE)
    }

    /// The indexes of the points to be run: all, or those of the shard.
    pub fn indexes(&self) -> impl Iterator<Item = u64> + Send + use<> {
        let shard = self.shard();
        let step = usize::try_from(shard.of).unwrap_or(usize::MAX);
        (shard.number - 1..self.source.len()).step_by(step)
    }

    /// How many points are to be run.
    pub fn expected(&self) -> u64 {
        self.shard().count(self.source.len())
    }

    /// When the study may end before its last point.
    ///
    /// # Errors
    /// When its points allow no such ending; says what to do.
    pub fn ending(&self, until: Until) -> Result<Ending, String> {
        let Session { study, judge, .. } = &self.session;
        let design = (study.design.method, study.design.replicates);
        Ending::new(until, judge, self.header.table.is_none().then_some(design))
    }

    /// A point to run.
    pub fn job(&self, index: u64) -> Job {
        Job {
            index,
            values: self.session.values(&self.source.parameters(index)),
        }
    }
}

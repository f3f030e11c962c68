//! The points of `verify`: a design's, or those of a table.

use std::path::{Path, PathBuf};

use super::{Ending, Request, Session, Until, budget, header};
use crate::{
    error::{Error, Result},
    results::Looked,
    source::PointSource,
};
use conformity::looks::History;
use fmu_points::Job;
use number_tables::files;
use point_journal::{
    Header, lines,
    pipeline::{Model, ShardPart},
};
use sampling::design::Sampling;

/// A study whose points are known beforehand.
pub struct Verification {
    /// The study.
    pub session: Session,
    /// The points.
    pub source: PointSource,
    /// Identity of the run.
    pub header: Header,
}

impl Verification {
    /// Reads the study, the FMU and, where one is given, the table of points.
    ///
    /// # Errors
    /// When any of them cannot be used.
    pub fn open(request: Request) -> Result<Self> {
        let session = Session::open_with_risk(request)?;
        let Session { request, study, package, plan, .. } = &session;
        let (source, table) = match (&request.points_from, &request.budget) {
            (None, Some(budget)) => {
                let design = budget::sample(&session)?;
                (PointSource::Chosen { design, places: budget.places.clone() }, None)
            }
            (Some(path), _) => {
                let source = PointSource::from_table(study, &plan.inputs, path)?;
                let digest = files::digest(path).map_err(Error::io(path))?;
                (source, Some(digest))
            }
            (None, None) => {
                let Sampling { points, replicates, .. } = study.design;
                let key = if points > 0 && replicates != 1 { "replicates" } else { "points" };
                let design = plan.design(&study.design).map_err(|message| match request.points {
                    Some(points) => study.error(format!("--points {points}: {message}")),
                    None => study.error_in("design", &[key], message),
                })?;
                (PointSource::Design(design), None)
            }
        };
        let budget = request.budget.as_ref();
        let points = budget.is_none().then(|| source.len());
        let analysis = budget.map(|_| budget::ANALYSIS.to_owned());
        let shard = request.shard.map(|shard| shard.to_string());
        let header = Header { table, analysis, shard, ..header(study, package, study.design.seed, points)? };
        Ok(Self { session, source, header })
    }

    /// Opens the study of a folder again, as it was run there; `fmu` is another place of the FMU.
    ///
    /// # Errors
    /// When there is none, or the FMU is another one.
    pub fn reopen(folder: &Path, fmu: Option<PathBuf>) -> Result<Self> {
        let then = lines::header(folder)?;
        let mut request = Request::read(folder)?;
        request.fmu = fmu.or(request.fmu);
        let verification = Self::open(request)?;
        verification.header.check(&then, folder)?;
        Ok(verification)
    }

    /// The part of the points that is to be run: all, or those of the shard.
    pub fn part(&self) -> ShardPart {
        ShardPart::of(self.session.request.shard, &self.header)
    }

    /// The indexes of the points to be run.
    pub fn indexes(&self) -> impl Iterator<Item = u64> + Send + use<> {
        let part = self.part();
        (0..self.source.len()).filter(move |&index| part.has(index))
    }

    /// How many points are to be run.
    pub fn expected(&self) -> u64 {
        self.part().count().unwrap_or_else(|| self.source.len())
    }

    /// When the study may end before its last point.
    ///
    /// # Errors
    /// When its points allow no such ending; says what to do.
    /// `history` are the verdicts that were drawn from its points before.
    pub fn ending(&self, until: Until, history: &History) -> Result<Ending, String> {
        let Session { study, judge, .. } = &self.session;
        let design = self.header.table.is_none().then_some(study.design.method);
        Ending::new(until, judge, design, history)
    }

    /// Whether the first points of a longer run are those of a shorter one: those of a Latin hypercube are not.
    pub fn is_extensible(&self) -> bool {
        self.header.table.is_some() || self.session.study.design.method.is_extensible()
    }

    /// The verdicts that were drawn from points of this study, which a folder keeps. `from` are further folders of the same
    /// points, such as those of shards.
    ///
    /// # Errors
    /// When they are there and cannot be read.
    pub fn looked(&self, folder: &Path, from: &[PathBuf]) -> Result<Looked> {
        let study = Header {
            points: self.header.points.filter(|_| !self.is_extensible()),
            table: None,
            shard: None,
            ..self.header.clone()
        };
        let mut longest = Looked::read(folder, &study)?;
        for other in from {
            let other = Looked::read(other, &study)?;
            if other.history.looks.len() > longest.history.looks.len() {
                longest.history = other.history;
            }
        }
        Ok(longest)
    }

    /// A point to run.
    pub fn job(&self, index: u64) -> Job {
        Job { index, values: self.session.values(&self.source.parameters(index)) }
    }
}

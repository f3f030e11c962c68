//! Analyses that ask for points of their own, however they come to be run: begun, resumed, in parts, or joined.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use super::CommandError;
use super::finding::{self, AnalysisResult};
use super::limits::place;
use crate::cli::{Parts, Work};
use crate::pipeline::folder::RunFolder;
use crate::pipeline::{Part, Pipeline, Shard};
use crate::results::Header;
use crate::results::lock::Lock;
use crate::results::origin::Origin;
use crate::session::{Asking, Request, Session};
use fmu_points::crew::Crew;

/// An analysis that asks for points of its own.
pub(super) trait Analysis {
    /// Its name: that of its command, and of the folder of its journal.
    fn name(&self) -> &'static str;

    /// Its options, as the request keeps them.
    fn options(&self) -> serde_json::Value;

    /// The seed, how many points it asks for where that is known beforehand, and what else the points depend on
    /// beside study and FMU.
    fn points(&self, session: &Session) -> Result<PointSet, CommandError>;

    /// Why parts of the points cannot be computed apart, if they cannot.
    fn one_piece(&self) -> Option<&'static str> {
        None
    }

    /// Whether it keeps correlated parameters together.
    fn takes_correlations(&self) -> bool {
        false
    }

    /// Whether it takes rows of a sample as they are.
    fn takes_samples(&self) -> bool {
        false
    }

    /// Refuses what it cannot do, before the folder is taken and what an earlier run left there is replaced.
    fn check(&self, _: &Session) -> Result<(), CommandError> {
        Ok(())
    }

    /// Asks for the points and says what they tell; tables of its own go into `folder`.
    fn find(
        &self,
        session: &Session,
        pipeline: &mut Pipeline<'_>,
        folder: &Path,
    ) -> Result<AnalysisResult, CommandError>;
}

/// Identity of an analysis's points, besides study and FMU: seed, number, method.
pub(super) struct PointSet {
    pub(super) seed: u64,
    /// How many there are, where that is known beforehand.
    pub(super) points: Option<u64>,
    /// The method and its sizes, for people.
    pub(super) method: String,
    /// The digest of the points that it begins with.
    pub(super) table: Option<String>,
}

/// Where the results go unless the user says otherwise; a part of them goes beside the others.
pub(super) fn folder(
    output: Option<&Path>,
    study: &Path,
    parts: &Parts,
    analysis: Option<&str>,
) -> Result<PathBuf, CommandError> {
    let shard = shard(parts)?;
    let usual = || {
        let folder = finding::folder_of(study);
        let name = analysis.map_or(String::new(), |name| format!("{name}-"));
        match shard {
            Some(shard) => folder.join(format!("{name}shard-{}-of-{}", shard.number, shard.of)),
            None => folder,
        }
    };
    Ok(output.map_or_else(usual, Path::to_owned))
}

/// The part of the points that the options name.
pub(super) fn shard(parts: &Parts) -> Result<Option<Shard>, CommandError> {
    parts.shard().map_err(|message| CommandError::Option {
        option: "shard-index",
        message,
    })
}

/// Refuses a folder that holds the results of another study file, where these are not to be replaced, for what is told
/// without new runs.
pub(super) fn check(work: &Work, folder: &Path) -> Result<(), CommandError> {
    let request = Request {
        study: work.study.clone(),
        ..Request::default()
    };
    Ok(request.check(folder, None, None, work.parts.earlier())?)
}

/// A study for an analysis.
pub(super) fn open(work: &Work, analysis: &dyn Analysis) -> Result<Session, CommandError> {
    let shard = shard(&work.parts)?;
    if let (Some(_), Some(message)) = (shard, analysis.one_piece()) {
        return Err(CommandError::Option {
            option: "shard",
            message: message.to_owned(),
        });
    }
    let session = Session::open(Request {
        study: work.study.clone(),
        fmu: work.means.fmu.clone(),
        shard,
        analysis: Some(Asking {
            name: analysis.name().to_owned(),
            options: analysis.options(),
        }),
        ..Request::default()
    })?;
    if session.plan.correlation().is_some() && !analysis.takes_correlations() {
        let message = "this analysis takes every parameter on its own, and correlated ones cannot be changed alone; remove \
                       [[correlations]], or use `sensitivity STUDY --shapley N`, which keeps them together";
        return Err(session.study.error(message).into());
    }
    let together = session.plan.together();
    if !together.is_empty() && !analysis.takes_samples() {
        let message = format!(
            "{} are drawn together from a sample, and this analysis changes every parameter alone; give them other \
             distributions, or use verify, robustness or tolerances, which draw whole rows",
            together.join(", ")
        );
        return Err(session.study.error(message).into());
    }
    Ok(session)
}

/// The journal's header: which study, FMU and analysis its points belong to.
pub(super) fn header(session: &Session, analysis: &dyn Analysis) -> Result<Header, CommandError> {
    let set = analysis.points(session)?;
    Ok(Header {
        table: set.table,
        analysis: Some(format!("{}, {}", analysis.name(), set.method)),
        ..session.header(set.seed, set.points)?
    })
}

/// Runs an analysis; its findings go into `folder`.
pub(super) fn run(
    mut session: Session,
    analysis: &dyn Analysis,
    work: &Work,
    folder: &Path,
) -> Result<ExitCode, CommandError> {
    let Work { means, parts, .. } = work;
    analysis.check(&session)?;
    let header = header(&session, analysis)?;
    let state = folder.join(analysis.name());
    let earlier = parts.earlier();
    session
        .request
        .check(folder, Some(analysis.name()), Some(&session.study), earlier)?;
    let RunFolder {
        journal,
        finished,
        scratch,
        lock: _lock,
    } = RunFolder::open(Lock::take(&state)?, &state, &header, earlier, false)?;
    session.request.write(&state, &session.study)?;
    let jobs = means.jobs();
    let crew = Crew::new(
        &mut session.package,
        place(means, jobs)?,
        scratch.path(),
        jobs,
    )?;
    let part = Part::of(session.request.shard, &header);
    let mut pipeline = Pipeline::new(
        &session,
        Some((&crew, &session.plan.cases[..])),
        journal,
        finished,
        part,
    )
    .repeating(header.seed, false);
    match analysis.find(&session, &mut pipeline, folder) {
        Ok(finding) => {
            pipeline.end()?;
            finding.tell(folder)
        }
        Err(error) => {
            pipeline.pause()?;
            Err(error)
        }
    }
}

/// Which study and FMU the results of an analysis with runs of its own came from.
pub(super) fn origin(session: &Session) -> Result<Origin, CommandError> {
    Ok(Origin {
        study_sha256: session.study.digest(),
        fmu_sha256: Some(session.package.digest()?),
        points: None,
    })
}

//! Analyses that ask for points of their own, however they come to be run: begun or resumed.

use std::{
    path::{Path, PathBuf},
    process::ExitCode,
    sync::atomic::Ordering,
};

use serde::Serialize;

use super::setup::{self, ResultFolder, Runnable, SourceParts};
use crate::{
    error::Result,
    options::{Means, Work},
    results::{origin::Origin, validity::Validity},
    session::{self, Request, Session},
};
use conformity::decision::Decision;
use fmu_points::stop;
use point_journal::{
    Header,
    files::{make_output, write_json},
    pipeline::{
        Pipeline,
        folder::{Earlier, Kept},
    },
};
use result_document::Document;
use study::judge::Judge;

/// An analysis that asks for points of its own. Its fields are its options.
pub trait Analysis {
    /// Its name: that of its command, and of the folder of its journal.
    const NAME: &'static str;

    /// The study that its points are run of.
    type Source: Runnable;

    /// Reads the study and the FMU, and refuses what it can do nothing with.
    ///
    /// # Errors
    /// When either cannot be used.
    fn open(&self, request: Request) -> Result<Self::Source>;

    /// The seed, how many points it asks for where that is known beforehand, and what else the points depend on
    /// beside study and FMU.
    ///
    /// # Errors
    /// When the options say nothing that can be run.
    fn points(&self, source: &Self::Source) -> Result<PointSet>;

    /// Refuses what it cannot do, before the folder is taken and what an earlier run left there is replaced.
    ///
    /// # Errors
    /// Says why.
    fn check(&self, _: &Self::Source) -> Result {
        Ok(())
    }

    /// Asks for the points and says what they tell; tables of its own go into `folder`.
    ///
    /// # Errors
    /// Why there is no answer.
    fn find(&self, source: &Self::Source, pipeline: &mut Pipeline, folder: &Path) -> Result<AnalysisResult>;
}

/// Identity of an analysis's points, besides study and FMU: seed, number, method.
pub struct PointSet {
    /// The seed.
    pub seed: u64,
    /// How many there are, where that is known beforehand.
    pub points: Option<u64>,
    /// The method and its sizes, for people.
    pub method: String,
    /// The digest of the points that it begins with.
    pub table: Option<String>,
}

/// The result of an analysis.
pub struct AnalysisResult {
    /// Which study, FMU and points it came from.
    pub origin: Origin,
    /// The same for people.
    pub text: String,
    /// The verdict's exit code; 0 unless there is a verdict.
    pub code: ExitCode,
    /// What explains that a study is not verified, where it was looked for.
    pub causes: Vec<String>,
    file: &'static str,
    /// The content of the file, with the origin.
    content: serde_json::Map<String, serde_json::Value>,
}

impl AnalysisResult {
    /// A result that becomes the content of `file`.
    pub(super) fn new(result: &impl Serialize, origin: Origin, document: &Document, file: &'static str) -> Self {
        let mut content = serde_json::Map::new();
        content.insert("origin".to_owned(), serde_json::json!(origin));
        let told = serde_json::to_value(result).expect("a result is made of texts and numbers");
        content.extend(told.as_object().cloned().unwrap_or_default());
        Self { origin, text: document.as_text(), file, code: ExitCode::SUCCESS, causes: Vec::new(), content }
    }

    /// Tells how many of the points in a journal went beyond what the model is valid for.
    pub(super) fn tell_validity(&mut self, of: SourceParts, folder: &Path) -> Result {
        if let Some(told) = Validity::of_journal(of.package.description(), folder)? {
            self.text += &format!("\nwarning: {told}\n");
            self.add("beyond_validity", &told);
        }
        Ok(())
    }

    /// Adds something to the file.
    pub(super) fn add(&mut self, name: &str, value: &impl Serialize) {
        self.content.insert(name.to_owned(), serde_json::json!(value));
    }

    /// Writes the file.
    ///
    /// # Errors
    /// When the system says no.
    pub fn write(&self, folder: &Path) -> Result {
        make_output(folder)?;
        Ok(write_json(&folder.join(self.file), &self.content)?)
    }
}

/// A result, the folder that it goes into, and what keeps that folder for it.
pub struct Delivery {
    /// The result.
    pub result: AnalysisResult,
    /// The folder.
    pub folder: PathBuf,
    _kept: Option<Kept>,
}

impl Delivery {
    /// A result without runs; refuses a folder that holds the results of another study file, where these are not to be
    /// replaced.
    pub(super) fn without_runs(
        result: AnalysisResult,
        study: &Path,
        earlier: Earlier,
        folder: PathBuf,
    ) -> Result<Self> {
        let request = Request { study: study.to_owned(), ..Request::default() };
        request.check(&folder, None, None, earlier)?;
        Ok(Self { result, folder, _kept: None })
    }
}

/// Which parameters that belong together an analysis can take.
pub struct Takes {
    /// Whether it keeps correlated parameters together.
    pub correlations: bool,
    /// Whether it takes rows of a sample as they are.
    pub samples: bool,
}

impl Takes {
    /// It draws whole points only.
    pub const ALL: Self = Self { correlations: true, samples: true };
}

/// A study whose parameters are as free as an analysis needs them.
pub fn session(request: Request, takes: Takes) -> Result<Session> {
    let session = Session::open(request)?;
    if session.plan.correlation.is_some() && !takes.correlations {
        return Err(session
            .study
            .error_near(
                "correlations",
                format!(
                    "this analysis takes every parameter on its own, and correlated ones cannot be changed alone; remove \
                     [[correlations]], or use `orchestrator sensitivity {} --budget 100`, which keeps them together",
                    session.study.path().display()
                ),
            )
            .into());
    }
    let together = session.plan.together();
    if !together.is_empty() && !takes.samples {
        return Err(session
            .study
            .error(format!(
                "{} are drawn together from a sample, and this analysis changes every parameter alone; give them other \
             distributions, or use verify, robustness or tolerances, which draw whole rows",
                together.join(", ")
            ))
            .into());
    }
    Ok(session)
}

/// Reads what the points of an analysis are run of.
pub fn open<A: Analysis>(work: &Work, analysis: &A) -> Result<A::Source> {
    analysis.open(request(&work.study, &work.means))
}

/// What was asked for.
pub fn request(study: &Path, means: &Means) -> Request {
    Request { study: study.to_owned(), fmu: means.fmu.clone(), ..Request::default() }
}

/// The journal's header: which study, FMU and analysis its points belong to.
///
/// # Errors
/// When the options say nothing that can be run, or the FMU cannot be read any more.
pub fn header<A: Analysis>(source: &A::Source, analysis: &A) -> Result<Header> {
    let set = analysis.points(source)?;
    let SourceParts { study, package, .. } = source.parts();
    Ok(Header {
        table: set.table,
        analysis: Some(format!("{}, {}", A::NAME, set.method)),
        ..session::header(study, package, set.seed, set.points)?
    })
}

/// Runs an analysis whose results go into `folder`.
pub fn run<A: Analysis>(source: A::Source, analysis: &A, work: &Work, folder: PathBuf) -> Result<Delivery> {
    run_by(source, analysis, (&work.means, work.resuming.earlier()), folder)
}

/// The same by these processes, with this treatment of an earlier run.
pub fn run_by<A: Analysis>(
    mut source: A::Source,
    analysis: &A,
    (means, earlier): (&Means, Earlier),
    folder: PathBuf,
) -> Result<Delivery> {
    analysis.check(&source)?;
    let header = header(&source, analysis)?;
    let place = ResultFolder { output: &folder, analysis: Some(A::NAME), earlier };
    let taken = place.take(source.parts(), &header, || Ok(()))?;
    let state = place.state();
    let means = setup::Work { means, jobs: means.jobs_of(usize::MAX)?, ends: true };
    let mut points = 0;
    let found = setup::run(&mut source, &header, taken, means, |source, pipeline| {
        let found = analysis.find(source, pipeline, &folder);
        points = pipeline.asked();
        found
    });
    let SourceParts { request, study, .. } = source.parts();
    // For what was only interrupted its runs are held.
    let has_ended = found.is_ok() || !stop::flag().load(Ordering::Relaxed);
    let noted = match &request.account {
        Some(account) if has_ended => {
            Request { account: Some(account.after(points)), ..request.clone() }.write(&state, study)
        }
        _ => Ok(()),
    };
    let (mut result, kept) = found?;
    noted?;
    result.tell_validity(source.parts(), &state)?;
    Ok(Delivery { result, folder, _kept: Some(kept) })
}

/// Which study and FMU the results of an analysis with runs of its own came from.
pub fn origin(source: &impl Runnable) -> Result<Origin> {
    let SourceParts { study, package, .. } = source.parts();
    Ok(Origin { study_sha256: study.digest(), fmu_sha256: Some(package.digest()?), points: None })
}

/// 0 when the model is verified, 1 when it is not, 3 when the points do not tell.
pub fn exit_code(verdict: Option<Decision>) -> ExitCode {
    const INCONCLUSIVE: u8 = 3;
    match verdict {
        Some(Decision::Inconclusive) => ExitCode::from(INCONCLUSIVE),
        Some(Decision::Verified) => ExitCode::SUCCESS,
        Some(Decision::NotVerified) | None => ExitCode::FAILURE,
    }
}

/// Says what the user should know of a study that can be used all the same.
pub fn warn(judge: &Judge) {
    for warning in &judge.warnings {
        fmu_points::tell::line!("warning: {warning}");
    }
}

//! The final files of a study, made from its journal.

use std::{
    fs,
    io::{self, BufWriter},
    path::{Path, PathBuf},
};

use conformity::{
    looks::{Look, Looks},
    risk::Guard,
};
use tempfile::NamedTempFile;

use super::{
    Ending, Front, Session, Verification,
    budget::{self, ChosenPoints},
};
use crate::{
    error::{Error, Result},
    results::{
        Looked,
        asides::Asides,
        points,
        summary::{ParameterSummary, Provenance, Run, Summary},
        survey::Survey,
        tally::{Sample, Tally},
        validity::Validity,
    },
};
use point_journal::{
    Finished, PointOutcome,
    files::{draft, keep, write_json},
};
use study::{
    Study,
    inputs::taken_as_exact,
    judge::{Judge, PointVerdict},
    plan::Input,
};

impl Verification {
    /// Writes `points.csv` and `summary.json` from the journal, in the order of the points, up to the last one or to
    /// where the study may end. Where it is judged by a rule, it is noted among the verdicts on its points.
    ///
    /// # Errors
    /// When points are missing, and when the system says no.
    pub fn conclude(
        &self,
        folder: &Path,
        run: Option<Run>,
        ending: Option<&Ending>,
        looked: &mut Looked,
        told: Option<&ChosenPoints>,
    ) -> Result<Summary> {
        let session = &self.session;
        let finished = Finished::read(folder)?;
        let provenance = self.provenance();
        let replicates = provenance.replicates.unwrap_or(1);
        // Rows of a table are drawn as the study says, and nobody knows which belong to one net.
        let nets = if self.header.table.is_some() { 1 } else { replicates };
        let sample = match told {
            Some(_) => Sample::Dependent,
            None => Sample::of(&session.study, self.source.len(), nets),
        };
        let Gathered { tally, survey, asides, files } = self.gather(&finished, folder, sample, ending)?;
        let awaited = ending.and_then(Ending::looks);
        let samples = usize::try_from(replicates).unwrap_or(usize::MAX);
        let looks = awaited.unwrap_or_else(|| match told {
            Some(_) => Looks::default(),
            None => looked.history.at(tally.points, samples),
        });
        let is_awaited = awaited.is_some() || told.is_some_and(|told| told.awaited);
        let mut look = 1;
        if session.judge.rule.is_some() {
            look = looked.history.note(Look { points: tally.points, way: looks.way, awaited: is_awaited });
            // Nobody may see the verdict before it is noted.
            looked.write(folder)?;
        }
        let parameters = session.plan.inputs.iter().map(ParameterSummary::new).collect();
        let mut summary = tally.looked_at(looks, look).summary(session.study.title.clone(), provenance, parameters);
        summary.asides = Some(asides);
        survey.complete(&mut summary);
        if let Some(told) = told {
            told.complete(session, &looked.history, &mut summary);
        }
        self.add_concerns(&mut summary);
        let mut conduct = finished.conduct();
        conduct.reproducibility = conduct.told_reproducibility();
        summary.conduct = Some(conduct);
        summary.dossier = session.study.dossier.clone();
        summary.run = run;
        files.finish(&summary)?;
        Ok(summary)
    }

    /// Reads the points in their order, writes them into the table, and counts them.
    fn gather(
        &self,
        finished: &Finished,
        folder: &Path,
        sample: Sample,
        ending: Option<&Ending>,
    ) -> Result<Gathered<'_>> {
        let Session { judge, plan, package, .. } = &self.session;
        let mut outcomes = finished.outcomes()?;
        let mut tally = Tally::new(judge, sample);
        let mut survey = Survey::new(judge, Some(plan));
        let mut asides = Asides {
            validity: Validity::of(package.description()),
            needs_execution_tool: package.description().capabilities.needs_execution_tool,
            ..Asides::default()
        };
        let mut files = FileSet::new(folder, &plan.inputs, judge)?;
        let mut ending = ending.map(|ending| (ending, Front::new(ending)));
        for index in 0..self.source.len() {
            let (outcome, notices) = outcomes.get_noted(index)?.ok_or_else(|| Error::Incomplete {
                path: folder.to_owned(),
                missing: self.source.len() - finished.count,
                points: self.source.len(),
            })?;
            let (label, parameters) = (self.source.label(index), self.source.parameters(index));
            let verdict = tally.add(label, &parameters, &outcome, notices.as_ref());
            let notices = notices.unwrap_or_default();
            survey.add(&parameters, &outcome, !notices.beyond.is_empty());
            asides.add(label, verdict.verified(), &notices);
            files.write(label, &parameters, &outcome, &verdict)?;
            if let Some((ending, front)) = &mut ending
                && front.add(index, ending.counts(judge, &outcome))
            {
                break;
            }
        }
        Ok(Gathered { tally, survey, asides, files })
    }

    /// Tells what is to be minded of parameters, samples and the errors of inputs.
    fn add_concerns(&self, summary: &mut Summary) {
        let plan = &self.session.plan;
        summary.concerns.extend(plan.concerns());
        if self.header.table.is_none() {
            summary.concerns.extend(plan.concerns_of_samples(summary.points));
        }
        let exact = plan.input_errors.iter().filter(|error| self.source.lacks(&plan.inputs, error));
        summary.concerns.extend(exact.map(|error| taken_as_exact(&error.name, "the points of a table")));
    }

    /// Versions, seed and hashes of this run.
    pub fn provenance(&self) -> Provenance {
        let Session { request, study, package, .. } = &self.session;
        let fmu = package.description();
        let header = &self.header;
        let given = header.table.is_some();
        Provenance {
            study: number_tables::files::name(request.own_study()),
            fmu: Some(fmu.model_name.clone()),
            fmu_version: fmu.version.clone(),
            fmu_guid: Some(fmu.guid.clone()),
            fmu_sha256: Some(header.fmu.clone()),
            method: match (given, &request.budget) {
                (true, _) => "table".to_owned(),
                (false, Some(_)) => budget::ANALYSIS.to_owned(),
                (false, None) => study.design.method.name(),
            },
            seed: (!given).then_some(header.seed),
            replicates: Some(study.design.replicates).filter(|&n| !given && request.budget.is_none() && n > 1),
            ..provenance(study)
        }
    }
}

/// What the points of a study are gathered in.
struct Gathered<'a> {
    tally: Tally<'a>,
    survey: Survey<'a>,
    asides: Asides,
    files: FileSet,
}

/// Everything about a study that is known without its FMU.
pub fn provenance(study: &Study) -> Provenance {
    Provenance {
        orchestrator: env!("CARGO_PKG_VERSION").to_owned(),
        study: number_tables::files::name(study.path()),
        study_sha256: study.digest(),
        ..Provenance::default()
    }
}

/// `points.csv` and `summary.json`, which appear when they are complete.
pub struct FileSet {
    folder: PathBuf,
    file: NamedTempFile,
    guard: Guard,
    points: points::Writer,
}

impl FileSet {
    /// Begins the files of a folder.
    ///
    /// # Errors
    /// When the system says no.
    pub fn new(folder: &Path, inputs: &[Input], judge: &Judge) -> Result<Self> {
        let begin = || -> io::Result<Self> {
            fs::create_dir_all(folder)?;
            let file = draft(folder)?;
            let writer = BufWriter::with_capacity(1 << 16, file.reopen()?);
            let points = points::Writer::new(writer, inputs, judge)?;
            Ok(Self { folder: folder.to_owned(), file, guard: judge.guard, points })
        };
        begin().map_err(Error::io(folder))
    }

    /// Writes a point.
    ///
    /// # Errors
    /// When the system says no.
    pub fn write(&mut self, label: u64, parameters: &[f64], outcome: &PointOutcome, verdict: &PointVerdict) -> Result {
        self.points.write(label, parameters, outcome, verdict).map_err(Error::io(&self.folder))
    }

    /// Puts the files in place; each one is either as before or complete.
    ///
    /// # Errors
    /// When the system says no.
    pub fn finish(self, summary: &Summary) -> Result {
        let path = self.folder.join("points.csv");
        self.points.finish().map_err(Error::io(&path))?;
        let file = match self.guard {
            Guard::Given(0.0) => self.file,
            guard => {
                let band = summary.conclusion.as_ref().and_then(|c| c.guard_band);
                settled(&self.file, &self.folder, guard, band).map_err(Error::io(&path))?
            }
        };
        keep(file, &path)?;
        Ok(write_json(&self.folder.join("summary.json"), summary)?)
    }
}

/// The table with the decisions of the guard band.
fn settled(file: &NamedTempFile, folder: &Path, guard: Guard, band: Option<f64>) -> io::Result<NamedTempFile> {
    let settled = draft(folder)?;
    let writer = BufWriter::with_capacity(1 << 16, settled.reopen()?);
    points::settle(file.reopen()?, writer, guard, band)?;
    Ok(settled)
}

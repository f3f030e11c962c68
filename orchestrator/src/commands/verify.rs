//! `verify`: simulates a study's points and judges them.

use std::fs::{self, File};
use std::io::{self, BufWriter};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};
use std::thread::available_parallelism;
use std::time::{Duration, Instant};

use sha2::{Digest, Sha256};
use tempfile::TempDir;

use super::limits::limits;
use super::progress::Progress;
use super::{CommandError, output, report, table, verdict};
use crate::cli::Verify;
use crate::design::Design;
use crate::engine::local::Local;
use crate::engine::process::Process;
use crate::engine::{self, Job, Worker};
use crate::fmu::{Package, hexadecimal};
use crate::judge::{Judge, Verdict};
use crate::results::journal::{Finished, Header};
use crate::results::summary::{ParameterSummary, Provenance, Run, Summary, Tally};
use crate::results::{Journal, Outcome, ResultsError, points, write_atomically};
use crate::source::Source;
use crate::study::Study;
use crate::study::plan::{Input, Plan};

pub(super) fn run(options: &Verify) -> Result<ExitCode, CommandError> {
    let begun = Instant::now();
    let mut session = Session::new(options)?;
    let folder = output_folder(options);
    let (mut journal, finished) = session.journal(&folder, options.resume)?;
    let before = finished.as_ref().map_or(0, |finished| finished.count);
    let jobs = options
        .jobs
        .unwrap_or_else(|| available_parallelism().map_or(1, Into::into));
    let computed = session.compute(
        options,
        &folder,
        &mut journal,
        finished.as_ref(),
        jobs.max(1),
    )?;
    journal.sync()?;
    if before + computed < session.source.len() {
        let (done, all) = (before + computed, session.source.len());
        eprintln!(
            "interrupted: {done} of {all} points are done; the same command with --resume goes on"
        );
        return Ok(ExitCode::from(130));
    }
    let mut summary = session.conclude(&folder)?;
    summary.run = Some(Run {
        wall_seconds: begun.elapsed().as_secs_f64(),
        computed,
        jobs,
    });
    write_summary(&folder, &summary)?;
    report::complete(
        &folder,
        &session.study,
        &session.plan,
        &mut session.package,
        &summary,
    )?;
    output::print(&format!(
        "{}{}\nresults in {}\n",
        table::counts(&summary),
        table::best(&summary),
        folder.display()
    ));
    Ok(verdict(summary.verified))
}

/// `results/` and the study's name, unless the user says otherwise.
fn output_folder(options: &Verify) -> PathBuf {
    options.output.clone().unwrap_or_else(|| {
        Path::new("results").join(options.study.file_stem().unwrap_or("study".as_ref()))
    })
}

/// Everything that a run of a study needs.
struct Session {
    study: Study,
    package: Package,
    plan: Plan,
    judge: Judge,
    source: Source,
    table_digest: Option<String>,
}

impl Session {
    fn new(options: &Verify) -> Result<Self, CommandError> {
        let mut study = Study::read(&options.study)?;
        study.design.points = options.points.unwrap_or(study.design.points);
        study.design.seed = options.seed.unwrap_or(study.design.seed);
        let path = options.fmu.clone().unwrap_or_else(|| study.fmu_path());
        let package = Package::open(&path)?;
        let judge = Judge::new(&study, Some(package.description()))?;
        let plan = Plan::new(&study, package.description())?;
        let (source, table_digest) = match &options.points_from {
            Some(path) => {
                let source = Source::from_table(&study, &plan.inputs, path)?;
                let bytes = fs::read(path).map_err(ResultsError::io(path))?;
                (source, Some(hexadecimal(&Sha256::digest(&bytes))))
            }
            None => {
                let inputs = plan.inputs.iter().map(|input| input.distribution).collect();
                let design = Design::new(&study.design, inputs);
                let design =
                    design.map_err(|message| study.error(format!("[design] {message}")))?;
                (Source::Design(design), None)
            }
        };
        Ok(Self {
            study,
            package,
            plan,
            judge,
            source,
            table_digest,
        })
    }

    fn header(&self) -> Result<Header, CommandError> {
        Ok(Header {
            orchestrator: env!("CARGO_PKG_VERSION").to_owned(),
            study: self.study.digest(),
            fmu: self.package.digest()?,
            table: self.table_digest.clone(),
            seed: self.study.design.seed,
            points: self.source.len(),
            shard: None,
        })
    }

    fn journal(
        &self,
        folder: &Path,
        resume: bool,
    ) -> Result<(Journal, Option<Finished>), CommandError> {
        let header = self.header()?;
        if resume && Journal::path_in(folder).exists() {
            let (journal, finished) = Journal::resume(folder, &header)?;
            return Ok((journal, Some(finished)));
        }
        // A study that is complete is simply done again.
        let complete = |finished: Finished| finished.count == finished.header.points;
        if Finished::read(folder).is_ok_and(complete) {
            let path = Journal::path_in(folder);
            fs::remove_file(&path).map_err(ResultsError::io(&path))?;
        }
        Ok((Journal::create(folder, &header)?, None))
    }

    /// Runs all points that are not finished; returns how many were.
    fn compute(
        &mut self,
        options: &Verify,
        folder: &Path,
        journal: &mut Journal,
        finished: Option<&Finished>,
        jobs: usize,
    ) -> Result<u64, CommandError> {
        let scratch = scratch(folder)?;
        let workers = self.workers(options, scratch.path(), jobs)?;
        let (plan, source, judge) = (&self.plan, &self.source, &self.judge);
        let open = (0..source.len()).filter(|&index| !finished.is_some_and(|f| f.has(index)));
        let job = |index| {
            let mut values = Vec::new();
            plan.to_fmu(&source.parameters(index), &mut values);
            Job { index, values }
        };
        let before = finished.map_or(0, |finished| finished.count);
        let progress = Progress::new(source.len(), before);
        let mut tally = Tally::new(judge);
        let mut synced = Instant::now();
        let result = engine::run(workers, open.map(job), stop(), |index, answer| {
            let outcome: Outcome = answer.map(|mut values| {
                plan.to_study(&mut values);
                values
            });
            journal.append(index, &outcome)?;
            const OFTEN: Duration = Duration::from_millis(200);
            if synced.elapsed() > OFTEN {
                journal.flush()?;
                synced = Instant::now();
            }
            tally.add(index, &[], &outcome);
            progress.step(tally.verified(), tally.failed(), tally.points());
            Ok::<_, CommandError>(ControlFlow::Continue(()))
        });
        progress.finish();
        result?;
        Ok(tally.points())
    }

    /// As many workers as points are to be run at a time.
    fn workers(
        &mut self,
        options: &Verify,
        scratch: &Path,
        jobs: usize,
    ) -> Result<Vec<Box<dyn Worker>>, CommandError> {
        let task = &self.plan.task;
        if options.in_process {
            let library = self.package.load()?;
            let capabilities = self.package.description().capabilities;
            let once = capabilities.can_be_instantiated_only_once_per_process;
            let worker = |_| Box::new(Local::new(&library, task)) as Box<dyn Worker>;
            return Ok((0..if once { 1 } else { jobs }).map(worker).collect());
        }
        let limits = limits(options, jobs)?;
        let fmu = self.package.unpack(scratch)?;
        let worker = |number| {
            let process = Process::new(&fmu, task, limits, scratch, number)?;
            Ok(Box::new(process) as Box<dyn Worker>)
        };
        (0..jobs).map(worker).collect()
    }

    /// Writes the final files from the journal, in the order of the points.
    fn conclude(&self, folder: &Path) -> Result<Summary, CommandError> {
        let finished = Finished::read(folder)?;
        let mut outcomes = finished.outcomes()?;
        let mut tally = Tally::new(&self.judge);
        let mut files = FileSet::new(Some(folder), &self.plan.inputs, &self.judge)?;
        for index in 0..self.source.len() {
            let outcome = outcomes
                .get(index)?
                .ok_or_else(|| ResultsError::Incomplete {
                    path: folder.to_owned(),
                    missing: self.source.len() - finished.count,
                    points: self.source.len(),
                })?;
            let (label, parameters) = (self.source.label(index), self.source.parameters(index));
            let verdict = tally.add(label, &parameters, &outcome);
            files.write(label, &parameters, &outcome, &verdict)?;
        }
        let parameters = self.plan.inputs.iter().map(ParameterSummary::new).collect();
        let summary = tally.summary(self.study.title.clone(), self.provenance()?, parameters);
        files.finish(&summary)?;
        Ok(summary)
    }

    fn provenance(&self) -> Result<Provenance, CommandError> {
        let fmu = self.package.description();
        let method = serde_json::to_value(self.study.design.method).ok();
        let method = method.and_then(|name| name.as_str().map(str::to_owned));
        let given = self.table_digest.is_some();
        Ok(Provenance {
            fmu: Some(fmu.model_name.clone()),
            fmu_version: fmu.version.clone(),
            fmu_guid: Some(fmu.guid.clone()),
            fmu_sha256: Some(self.package.digest()?),
            method: method
                .filter(|_| !given)
                .unwrap_or_else(|| "table".to_owned()),
            seed: (!given).then_some(self.study.design.seed),
            ..provenance(&self.study)
        })
    }
}

/// A folder for what is needed while points run. Those of runs that were killed are removed; the
/// journal's lock says that they are not in use.
fn scratch(folder: &Path) -> Result<TempDir, CommandError> {
    const PREFIX: &str = ".running-";
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        if entry.file_name().to_string_lossy().starts_with(PREFIX) {
            // What cannot be removed only takes up room.
            let _ = fs::remove_dir_all(entry.path());
        }
    }
    let scratch = tempfile::Builder::new().prefix(PREFIX).tempdir_in(folder);
    Ok(scratch.map_err(ResultsError::io(folder))?)
}

/// What is known of a study without its FMU.
pub(super) fn provenance(study: &Study) -> Provenance {
    let name = study.path().file_name().unwrap_or_default();
    Provenance {
        orchestrator: env!("CARGO_PKG_VERSION").to_owned(),
        study: name.to_string_lossy().into_owned(),
        study_sha256: study.digest(),
        ..Provenance::default()
    }
}

/// Set by Ctrl-C: points that have begun are finished, no further ones are begun.
fn stop() -> &'static AtomicBool {
    static STOP: OnceLock<Arc<AtomicBool>> = OnceLock::new();
    STOP.get_or_init(|| {
        let stop = Arc::new(AtomicBool::new(false));
        let handler = Arc::clone(&stop);
        // Without a handler, Ctrl-C ends the process at once, and the journal is sound all the same.
        let _ = ctrlc::set_handler(move || {
            if handler.swap(true, Ordering::Relaxed) {
                // The second Ctrl-C does not wait.
                std::process::exit(130);
            }
        });
        stop
    })
}

/// The final files of a folder, or nothing at all.
pub(super) struct FileSet {
    points: Option<(
        PathBuf,
        tempfile::NamedTempFile,
        points::Writer<BufWriter<File>>,
    )>,
}

impl FileSet {
    pub(super) fn new(
        folder: Option<&Path>,
        inputs: &[Input],
        judge: &Judge,
    ) -> Result<Self, CommandError> {
        let Some(folder) = folder else {
            return Ok(Self { points: None });
        };
        let begin = || -> io::Result<_> {
            fs::create_dir_all(folder)?;
            let file = tempfile::Builder::new()
                .prefix(".points-")
                .tempfile_in(folder)?;
            let writer = BufWriter::with_capacity(1 << 16, file.reopen()?);
            Ok((
                folder.to_owned(),
                file,
                points::Writer::new(writer, inputs, judge)?,
            ))
        };
        let points = Some(begin().map_err(ResultsError::io(folder))?);
        Ok(Self { points })
    }

    pub(super) fn write(
        &mut self,
        label: u64,
        parameters: &[f64],
        outcome: &Outcome,
        verdict: &Verdict,
    ) -> Result<(), CommandError> {
        if let Some((folder, _, points)) = &mut self.points {
            let written = points.write(label, parameters, outcome, verdict);
            written.map_err(ResultsError::io(folder))?;
        }
        Ok(())
    }

    /// Puts the files in place; each one is either as before or complete.
    pub(super) fn finish(self, summary: &Summary) -> Result<(), CommandError> {
        if let Some((folder, file, points)) = self.points {
            let path = folder.join("points.csv");
            points.finish().map_err(ResultsError::io(&path))?;
            crate::results::keep(file, &path)?;
            write_summary(&folder, summary)?;
        }
        Ok(())
    }
}

fn write_summary(folder: &Path, summary: &Summary) -> Result<(), CommandError> {
    let path = folder.join("summary.json");
    write_atomically(&path, |out| {
        serde_json::to_writer_pretty(&mut *out, summary)?;
        writeln!(out)
    })?;
    Ok(())
}

//! `identify`: finds the parameters that make the FMU's outputs most probable.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde::{Deserialize, Serialize};

use super::limits::place;
use super::{CommandError, finding, output};
use crate::cli::Identify;
use crate::design::{Design, Method, Sampling};
use crate::distribution::Distribution;
use crate::engine::crew::Crew;
use crate::identify::bind::Bound;
use crate::identify::error::BindError;
use crate::identify::local::End;
use crate::identify::model::FmuModel;
use crate::identify::objective::Objective;
use crate::identify::outcome::Outcome;
use crate::identify::posterior::Posterior;
use crate::identify::search::{self, SearchError, State, search};
use crate::identify::settings::{Document, Settings};
use crate::identify::text;
use crate::results::{ResultsError, write_atomically};
use crate::study::Study;
use crate::table::csv_file::{CsvFile, cell, reason};
use fmu_import::Package;

pub(super) fn run(options: &Identify) -> Result<ExitCode, CommandError> {
    let study = Study::read(&options.study)?;
    let mut settings = study.section::<Document>()?.identify.ok_or_else(|| {
        study.error("identify needs a section [identify]; `orchestrator identify --help` shows one")
    })?;
    settings.starts = options.starts.unwrap_or(settings.starts);
    settings.seed = options.seed.unwrap_or(settings.seed);
    let path = options.means.fmu(&study);
    let mut package = Package::open(&path)?;
    let bound =
        Bound::new(&study, &settings, package.description()).map_err(|error| match error {
            BindError::Study(error) => CommandError::from(error),
            BindError::Table(error) => CommandError::from(error),
        })?;
    let folder = options
        .output
        .clone()
        .unwrap_or_else(|| finding::folder_of(&options.study));
    let mut saved = Saved::begin(&folder, key(&study, &package, &settings)?, options.resume)?;
    let scratch = tempfile::tempdir().map_err(ResultsError::io(&std::env::temp_dir()))?;
    let jobs = options.means.jobs();
    let place = place(&options.means, jobs)?;
    let crew = Crew::new(&mut package, place, scratch.path(), jobs)?;
    let model = FmuModel::new(&bound, &crew);
    let objective = Objective::new(&bound.problem, &model, settings.difference);
    let starts = starts(&study, &settings)?;
    let limits = search::Settings {
        descents: settings.descents.max(1),
        iterations: settings.iterations.max(1),
        deadline: options
            .time_limit
            .map(|seconds| Instant::now() + Duration::from_secs_f64(seconds.clamp(0.0, 1e9))),
    };
    let found = pool(crew.size())?.install(|| {
        let progress = Progress::new(starts.len(), limits.descents.min(starts.len()));
        let mut state = std::mem::take(&mut saved.state);
        let minimum = search(&objective, &starts, &limits, &mut state, &mut |state| {
            progress.show(state);
            saved.keep(state)
        });
        progress.bar.finish_and_clear();
        let minimum = minimum?;
        let posterior = Posterior::at(&objective, &minimum).map_err(SearchError::Simulation)?;
        Ok(Outcome::new(&bound.problem, &minimum, &posterior, &state))
    });
    let outcome = found.map_err(|error: SearchError| CommandError::Search(error.to_string()))?;
    write(&folder, &study, &outcome)?;
    write_cases(&folder, &study, &settings, &outcome)?;
    output::print(&format!(
        "{}results in {}\n",
        text::summary(&outcome),
        folder.display()
    ));
    Ok(match outcome.end {
        End::Time | End::Iterations => ExitCode::FAILURE,
        End::Converged => ExitCode::SUCCESS,
    })
}

/// Starts from a scrambled Sobol net between the bounds.
fn starts(study: &Study, settings: &Settings) -> Result<Vec<Vec<f64>>, CommandError> {
    let place = Distribution::Uniform { min: 0.0, max: 1.0 };
    let design = Sampling {
        method: Method::Sobol,
        points: settings.starts.max(1),
        seed: settings.seed,
        ..Sampling::default()
    };
    let design = Design::new(&design, vec![place; settings.free.len()])
        .map_err(|message| study.error(format!("[identify] {message}")))?;
    Ok((0..design.len()).map(|index| design.point(index)).collect())
}

fn pool(jobs: usize) -> Result<rayon::ThreadPool, CommandError> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(jobs).build();
    pool.map_err(|error| CommandError::Option {
        option: "jobs",
        message: error.to_string(),
    })
}

/// What a search depends on: only the same one can be resumed.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
struct Key {
    study: String,
    table: Option<String>,
    fmu: String,
    seed: u64,
}

fn key(study: &Study, package: &Package, settings: &Settings) -> Result<Key, CommandError> {
    let table = settings.cases.as_ref().map(|path| {
        let path = beside(study, path.as_ref());
        fs::read_to_string(&path).map_err(ResultsError::io(&path))
    });
    Ok(Key {
        study: study.digest(),
        table: table.transpose()?,
        fmu: package.digest()?,
        seed: settings.seed,
    })
}

/// The state file: how far the search has got.
#[derive(Debug)]
struct Saved {
    path: PathBuf,
    key: Key,
    state: State,
}

#[derive(Serialize, Deserialize)]
struct File<K, S> {
    key: K,
    state: S,
}

impl Saved {
    fn begin(folder: &Path, key: Key, resume: bool) -> Result<Self, CommandError> {
        fs::create_dir_all(folder).map_err(ResultsError::io(folder))?;
        let path = folder.join("identification-state.json");
        let state = if resume && path.exists() {
            let text = fs::read_to_string(&path).map_err(ResultsError::io(&path))?;
            let file: File<Key, State> =
                serde_json::from_str(&text).map_err(|error| ResultsError::Content {
                    path: path.clone(),
                    message: error.to_string(),
                })?;
            if file.key != key {
                let message = "it was made with another study, table, FMU or seed; start again without --resume";
                return Err(ResultsError::Content {
                    path,
                    message: message.to_owned(),
                }
                .into());
            }
            file.state
        } else {
            State::default()
        };
        Ok(Self { path, key, state })
    }

    fn keep(&self, state: &State) -> std::io::Result<()> {
        let file = File {
            key: &self.key,
            state,
        };
        let written = write_atomically(&self.path, |out| Ok(serde_json::to_writer(out, &file)?));
        written.map_err(std::io::Error::other)
    }
}

fn write(folder: &Path, study: &Study, outcome: &Outcome) -> Result<(), CommandError> {
    write_atomically(&folder.join("identification.json"), |out| {
        serde_json::to_writer_pretty(&mut *out, outcome)?;
        writeln!(out)
    })?;
    let name = study
        .path()
        .file_name()
        .unwrap_or_default()
        .to_string_lossy();
    write_atomically(&folder.join("optimum.toml"), |out| {
        write!(out, "{}", text::fixed_section(&name, outcome))
    })?;
    Ok(())
}

/// The table of cases with the latent parameters' most probable values in place of what it had.
fn write_cases(
    folder: &Path,
    study: &Study,
    settings: &Settings,
    outcome: &Outcome,
) -> Result<(), CommandError> {
    let Some(path) = &settings.cases else {
        return Ok(());
    };
    let path = beside(study, path.as_ref());
    let failed = |error: csv::Error| ResultsError::Content {
        path: path.clone(),
        message: reason(&error),
    };
    let mut reader = CsvFile::open(&path, Some(b'#')).map_err(failed)?.reader;
    let header = reader.headers().map_err(failed)?.clone();
    let latents = settings.latent.values();
    let places: Vec<Option<usize>> = latents
        .map(|latent| {
            header
                .iter()
                .position(|name| Some(name) == latent.column.as_deref())
        })
        .collect();
    let mut writer = csv::Writer::from_writer(Vec::new());
    let names = header.iter().map(|name| cell(name).into_owned());
    writer.write_record(names).map_err(failed)?;
    for (record, case) in reader.records().zip(&outcome.cases) {
        let mut cells: Vec<String> = record.map_err(failed)?.iter().map(str::to_owned).collect();
        for (place, latent) in places.iter().zip(&case.latents) {
            if let Some(cell) = place.and_then(|place| cells.get_mut(place)) {
                *cell = text::digits(latent.value).to_string();
            }
        }
        let cells = cells.iter().map(|text| cell(text).into_owned());
        writer.write_record(cells).map_err(failed)?;
    }
    let bytes = writer.into_inner().unwrap_or_default();
    write_atomically(&folder.join("cases.csv"), |out| out.write_all(&bytes))?;
    Ok(())
}

/// A path that the study gives relative to itself.
fn beside(study: &Study, path: &Path) -> PathBuf {
    study.path().parent().unwrap_or("".as_ref()).join(path)
}

/// Progress on standard error, when that is a terminal.
struct Progress {
    bar: ProgressBar,
}

impl Progress {
    fn new(starts: usize, descents: usize) -> Self {
        const LINE: &str = "{bar:30} {pos}/{len} searches, {elapsed}, {msg}";
        let target = ProgressDrawTarget::stderr_with_hz(5);
        let bar = ProgressBar::with_draw_target(Some((starts + descents) as u64), target);
        if let Ok(style) = ProgressStyle::with_template(LINE) {
            bar.set_style(style);
        }
        bar.enable_steady_tick(Duration::from_millis(500));
        Self { bar }
    }

    fn show(&self, state: &State) {
        self.bar
            .set_position((state.screened.len() + state.descents.len()) as u64);
        if let Some(best) = state.best() {
            self.bar
                .set_message(format!("sum of squares {:.4}", best.cost));
        }
    }
}

//! Options of every command that runs points of a study: processes, limits, resuming; and the shards of `verify`.

use std::{
    num::NonZeroUsize,
    path::{Component, Path, PathBuf},
    thread::available_parallelism,
    time::Duration,
};

use crate::error::{Error, Result};
use clap::Args;
use fmu_points::{Isolation, Launcher, PointLimits, crew::WorkerSite, system};
use point_journal::pipeline::{Shard, folder::Earlier};

/// Resuming.
#[derive(Debug, Args)]
pub struct Resuming {
    /// Continue a run that was interrupted
    #[arg(long)]
    pub resume: bool,
    /// Replace the folder's results, also unfinished ones and those of another study or FMU
    #[arg(long, conflicts_with = "resume")]
    pub force: bool,
}

/// A part of the points.
#[derive(Debug, Args)]
pub struct Shards {
    /// Simulate only part I of N of the points (exit code 0); `merge` joins them
    #[arg(long, value_name = "I/N")]
    shard: Option<Shard>,
    /// The part, counted from 0, with --shards
    #[arg(long, value_name = "I", requires = "shards", conflicts_with = "shard")]
    shard_index: Option<u64>,
    /// How many parts there are, with --shard-index
    #[arg(long, value_name = "N", requires = "shard_index")]
    shards: Option<u64>,
}

impl Shards {
    /// The part to simulate, if not all.
    ///
    /// # Errors
    /// When there is no such part.
    pub fn chosen(&self) -> Result<Option<Shard>> {
        match (self.shard_index, self.shards) {
            (Some(index), Some(of)) if index < of => {
                let number = index + 1;
                Ok(Some(Shard { number, of }))
            }
            (Some(index), Some(of)) => {
                Err(Error::option("shard-index", format!("{index} is none of {of} parts, which are counted from 0")))
            }
            _ => Ok(self.shard),
        }
    }
}

impl Resuming {
    /// The treatment of an earlier run in the output folder.
    pub fn earlier(&self) -> Earlier {
        match (self.resume, self.force) {
            (true, _) => Earlier::Resumed,
            (_, true) => Earlier::Replaced,
            _ => Earlier::Complete,
        }
    }
}

/// Processes that run the points, and their limits.
#[derive(Debug, Args)]
pub struct Means {
    /// The FMU, instead of the study's
    #[arg(long, value_name = "FMU")]
    pub fmu: Option<PathBuf>,
    /// The number of parallel simulations [default: the cores that this process may use]
    #[arg(long, value_name = "J", allow_negative_numbers = true)]
    pub jobs: Option<NonZeroUsize>,
    /// fresh: each point alone in a process of its own; shared: points share processes, for an FMU that you trust; none: all
    /// in this process, which a crash of the FMU ends
    #[arg(long, value_name = "HOW", default_value = "fresh")]
    pub isolation: Isolation,
    /// The longest time that a point may take, s
    #[arg(long, value_name = "T", default_value_t = 3600.0, allow_negative_numbers = true)]
    pub point_timeout: f64,
    /// The most memory that a worker process may take, such as 500MB [default: a fair share of
    /// the machine's]
    #[arg(long, value_name = "SIZE")]
    pub memory_limit: Option<String>,
    /// Start workers elsewhere
    #[command(flatten)]
    pub afar: Box<Afar>,
}

/// Workers on other machines.
#[derive(Debug, Args)]
pub struct Afar {
    /// Start each worker by this command, such as `srun -n1 -c1` or `ssh node7`
    #[arg(long, value_name = "COMMAND")]
    launcher: Option<String>,
    /// Hosts, a line each with the number of workers; `{host}` in the command becomes the name
    #[arg(long, value_name = "FILE", requires = "launcher", conflicts_with = "jobs")]
    hosts: Option<PathBuf>,
    /// Send the FMU to hosts that do not share the disk
    #[arg(long, requires = "launcher")]
    ship: bool,
    /// The program on the hosts [default: this program's path]
    #[arg(long, value_name = "PATH", requires = "launcher")]
    worker_program: Option<PathBuf>,
    /// The longest time for a worker to start, or to be silent, s [default: 30]
    #[arg(long, value_name = "T", requires = "launcher", allow_negative_numbers = true)]
    launcher_timeout: Option<f64>,
}

impl Afar {
    /// How workers are started elsewhere, if they are, `jobs` of them unless hosts say otherwise.
    fn launcher(&self, jobs: usize) -> Result<Option<Launcher>> {
        let Some(command) = &self.launcher else { return Ok(None) };
        let mut launcher = Launcher::new(command, jobs).map_err(|message| Error::option("launcher", message))?;
        if self.hosts.is_none() && launcher.wants_hosts() {
            return Err(Error::option("launcher", "{host} stands for a name of a file of hosts: add --hosts FILE"));
        }
        if let Some(path) = &self.hosts {
            let hosts = std::fs::read_to_string(path).map_err(Error::io(path))?;
            let on = launcher.on(&hosts);
            launcher = on.map_err(|message| Error::content(path, message))?;
        }
        if let Some(program) = &self.worker_program {
            launcher.program.clone_from(program);
        }
        launcher.ship = self.ship;
        if let Some(seconds) = self.launcher_timeout {
            launcher.patience = time("launcher-timeout", seconds)?;
        }
        Ok(Some(launcher))
    }
}

impl Means {
    /// How many simulations at a time: as many as cores, unless the user says otherwise.
    pub fn jobs(&self) -> usize {
        self.jobs.map_or_else(|| available_parallelism().map_or(1, Into::into), NonZeroUsize::get)
    }

    /// How many simulations at a time in this machine.
    pub fn jobs_here(&self) -> usize {
        match self.afar.launcher {
            Some(_) => available_parallelism().map_or(1, Into::into),
            None => self.jobs(),
        }
    }

    /// The same of `points`, wherever: no more than there are, and as many as hosts have.
    ///
    /// # Errors
    /// When the hosts cannot be used.
    pub fn jobs_of(&self, points: usize) -> Result<usize> {
        let jobs = self.jobs().min(points.max(1));
        let launcher = self.afar.launcher(jobs)?;
        Ok(launcher.map_or(jobs, |launcher| launcher.slots()))
    }

    /// Where `jobs` points at a time are run.
    ///
    /// # Errors
    /// When a limit cannot be used.
    pub fn place(&self, jobs: usize) -> Result<WorkerSite> {
        let limits = self.limits(jobs)?;
        let launcher = self.afar.launcher(jobs)?;
        if self.isolation == Isolation::None {
            return match launcher {
                None => Ok(WorkerSite::Here),
                Some(_) => Err(Error::option(
                    "isolation",
                    "`none` is this process, and a launcher starts others: leave one out",
                )),
            };
        }
        let Some(mut launcher) = launcher else { return Ok(WorkerSite::Processes(limits, self.isolation)) };
        launcher.memory = self.memory_limit.as_ref().map(|_| limits.memory);
        Ok(WorkerSite::Elsewhere(limits, self.isolation, launcher))
    }

    /// The limits for one of `jobs` workers.
    ///
    /// # Errors
    /// When a limit cannot be used.
    pub fn limits(&self, jobs: usize) -> Result<PointLimits> {
        let time = time("point-timeout", self.point_timeout)?;
        let memory = match &self.memory_limit {
            Some(text) => size(text).ok_or_else(|| {
                Error::option("memory-limit", format!("`{text}` is not a size of at least 1 MB, such as 500MB or 2GB"))
            })?,
            None => system::share_of_memory(jobs),
        };
        Ok(PointLimits { time, memory })
    }
}

/// The options that every analysis of a study takes.
#[derive(Debug, Args)]
pub struct Work {
    /// The study, a TOML file
    pub study: PathBuf,
    /// The folder for the results [default: results/ and the study's name, or that of any --from]
    #[arg(long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Run settings
    #[command(flatten)]
    pub means: Means,
    /// Resuming
    #[command(flatten)]
    pub resuming: Resuming,
}

impl Work {
    /// Where the results go.
    pub fn folder(&self) -> PathBuf {
        self.output.clone().unwrap_or_else(|| folder_of(&self.study))
    }
}

/// Where a study's results lie unless the user says otherwise.
pub fn folder_of(study: &Path) -> PathBuf {
    Path::new("results").join(study.file_stem().unwrap_or("study".as_ref()))
}

/// A file's path as seen from the folder of the study, or from here where the study goes to standard output.
pub fn relative(file: &Path, study: Option<&Path>) -> PathBuf {
    let folder = |path: &Path| {
        let parent = path.parent().filter(|parent| !parent.as_os_str().is_empty());
        parent.unwrap_or(Path::new(".")).canonicalize()
    };
    let from = folder(study.unwrap_or(Path::new("study.toml")));
    let (Ok(from), Ok(to), Some(name)) = (from, folder(file), file.file_name()) else {
        return file.to_owned();
    };
    let common = from.components().zip(to.components());
    let common = common.take_while(|(a, b)| a == b).count();
    if common == 0 {
        // Another drive.
        return to.join(name);
    }
    let up = from.components().skip(common).map(|_| Component::ParentDir);
    let path: PathBuf = up.chain(to.components().skip(common)).collect();
    path.join(name)
}

/// A size with a unit, bytes.
fn size(text: &str) -> Option<u64> {
    let text = text.trim();
    let digits = text.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(text.len());
    let number: f64 = text[..digits].parse().ok()?;
    let factor = match text[digits..].trim().to_uppercase().as_str() {
        "" | "B" => 1.0,
        "K" | "KB" | "KIB" => 1024.0,
        "M" | "MB" | "MIB" => 1024.0 * 1024.0,
        "G" | "GB" | "GIB" => 1024.0 * 1024.0 * 1024.0,
        _ => return None,
    };
    let bytes = number * factor;
    // Without a unit it is bytes: `10` cannot be meant.
    (bytes >= 1e6).then_some(bytes as u64)
}

/// A time that an option gives, s.
fn time(option: &'static str, seconds: f64) -> Result<Duration> {
    let time = Duration::try_from_secs_f64(seconds).ok();
    time.filter(|time| !time.is_zero())
        .ok_or_else(|| Error::option(option, format!("{seconds:?} s is not a positive time")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes() {
        assert_eq!(size("500MB"), Some(500 << 20));
        assert_eq!(size("1.5 G"), Some(3 << 29));
        assert_eq!(size("4194304"), Some(4 << 20));
        assert_eq!(size("10"), None);
        assert_eq!(size("many"), None);
        assert_eq!(size("0"), None);
    }
}

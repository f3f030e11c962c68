//! Single points, each in a process of its own, with their trajectories as csv.

use std::{
    borrow::Cow,
    io::{BufWriter, Write},
    path::{Path, PathBuf},
    time::Instant,
};

use crate::{
    error::{Error, Result},
    results::points::number,
};
use fmu_import::{Causality, Description, Handle, Package, Value, Variable};
use fmu_points::{
    Job, PointLimits, PointResult, RunError,
    scratch::Scratch,
    single::Recorder,
    stop,
    task::{Case, Task},
    working_directory,
};
use number_tables::csv_file;

/// The variables that a trajectory shows.
pub struct Columns(pub Vec<Variable>);

impl Columns {
    /// The outputs, or where there are none the local variables, of which `aloud` tells the user.
    pub fn usual(fmu: &Description, aloud: bool) -> Self {
        let all = |causality| fmu.with(causality).cloned().collect::<Vec<Variable>>();
        let outputs = all(Causality::Output);
        if !outputs.is_empty() {
            return Self(outputs);
        }
        let locals = all(Causality::Local);
        match locals.len() {
            _ if !aloud => {}
            0 => fmu_points::tell::line!(
                "note: the FMU has neither outputs nor local variables, so only the time is recorded; --record \
                 chooses others"
            ),
            count => fmu_points::tell::line!(
                "note: the FMU has no outputs, so its {count} local variables are recorded; --record chooses others"
            ),
        }
        Self(locals)
    }

    /// The values of a row, for people.
    pub fn summary(&self, row: &[String]) -> String {
        self.0
            .iter()
            .zip(row)
            .map(|(variable, value)| {
                let unit = variable.unit().unwrap_or("");
                format!("{} = {value} {unit}", variable.name).trim_end().to_owned() + "\n"
            })
            .collect()
    }
}

fn cell(value: &Value) -> String {
    match value {
        Value::Real(value) => number(*value),
        Value::Integer(value) => value.to_string(),
        Value::Boolean(value) => u8::from(*value).to_string(),
        Value::String(text) => csv_file::cell(text).into_owned(),
    }
}

/// An FMU of which single points run in a process of its own.
pub struct Isolated {
    fmu: PathBuf,
    name: PathBuf,
    /// Where its processes have their folders.
    rooms: PathBuf,
    _scratch: Scratch,
    /// Whether a start value names a file in the user's working directory.
    named: bool,
}

impl Isolated {
    pub fn new(package: &mut Package) -> Result<Self> {
        let scratch = stop::scratch()?;
        let rooms = scratch.path().to_owned();
        let fmu = package.unpack(&rooms)?;
        Ok(Self::at(fmu, package, rooms, scratch))
    }

    /// The same from another path than that of all other commands: an FMU whose results depend on where it lies shows it there.
    pub fn elsewhere(package: &mut Package) -> Result<Self> {
        let scratch = stop::scratch()?;
        let folder = scratch.path().join("again");
        std::fs::create_dir(&folder).map_err(Error::io(&folder))?;
        let fmu = package.unpack_anew(&folder)?.keep();
        Ok(Self::at(fmu, package, folder, scratch))
    }

    fn at(fmu: PathBuf, package: &Package, rooms: PathBuf, scratch: Scratch) -> Self {
        let named = working_directory::is_kept(package.description(), []);
        Self { fmu, name: package.path().to_owned(), rooms, _scratch: scratch, named }
    }

    /// How single points are recorded: without a limit of time, as a person watches and can press Ctrl-C.
    fn recorder<'t>(&self, mut tasks: impl Iterator<Item = &'t Task>) -> Recorder<'_> {
        Recorder {
            fmu: &self.fmu,
            name: &self.name,
            scratch: &self.rooms,
            here: self.named || tasks.any(working_directory::is_named_in),
            limits: PointLimits::NONE,
            echo: true,
        }
    }

    /// Simulates, writes the trajectory as csv into what is called `path`, and returns the last row.
    pub fn trajectory(
        &self,
        task: &Task,
        values: &[f64],
        columns: &Columns,
        into: impl Write,
        path: &Path,
    ) -> Result<Vec<String>> {
        let failed = |error: csv::Error| Error::io(path)(error.into());
        let mut csv = csv::Writer::from_writer(BufWriter::new(into));
        let names = columns.0.iter().map(|variable| csv_file::cell(&variable.name));
        let head = std::iter::once("time".into()).chain(names);
        csv.write_record(head.map(Cow::into_owned)).map_err(failed)?;
        let mut last = Vec::new();
        let handles: Vec<Handle> = columns.0.iter().map(Variable::handle).collect();
        let mut recording = self.recorder([task].into_iter()).of(task)?;
        let recorded = recording.record(values, &handles, None, |time, values| {
            last = values.iter().map(cell).collect();
            csv.write_field(number(time)).map_err(failed)?;
            csv.write_record(&last).map_err(failed)
        });
        stop::give_way();
        // Rows before the failure are kept.
        recorded.and(csv.flush().map_err(Error::io(path))).map(|()| last)
    }

    /// Simulates, and hands over time and values at every communication point; at `until` it has failed.
    pub fn observe(
        &self,
        task: &Task,
        variables: &[Handle],
        until: Option<Instant>,
        mut take: impl FnMut(f64, &[Value]),
    ) -> Result {
        let mut recording = self.recorder([task].into_iter()).of(task)?;
        recording.record(&[], variables, until, |time, values| {
            take(time, values);
            Ok(())
        })
    }

    /// Simulates a point as `verify` does.
    pub fn run(&self, cases: &[Case], job: &Job) -> Result<PointResult, RunError> {
        let silent = Recorder { echo: false, ..self.recorder(cases.iter().map(|case| &case.task)) };
        silent.run(cases, job)
    }
}

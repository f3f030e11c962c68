//! The best point's trajectory, as a file beside the results.

use super::{figures::Series, overlay::ReferenceCurve};
use crate::results::Summary;
use indexmap::IndexMap;
use number_tables::csv_file;
use parameter_regions::table::PointTable;
use sampling::statistics::Statistic;
use std::path::Path;
use study::{Study, judge::Criterion};

/// The file: `time` in seconds, and the criteria's signals in the criteria's units. Where the study has cases, each of them
/// has a file, `best-point-1.csv` and so on, in the order of the study.
pub fn file(case: Option<usize>) -> String {
    match case {
        Some(case) => format!("best-point-{}.csv", case + 1),
        None => "best-point.csv".to_owned(),
    }
}

/// The measured curves of the criteria that have one: criterion, `time` of the model in seconds, and value and expanded
/// uncertainty in the criterion's unit.
pub const MEASURED: &str = "measured-curves.csv";

/// The columns of [`MEASURED`].
pub const MEASURED_COLUMNS: [&str; 4] = ["criterion", "time", "value", "uncertainty"];

/// Reads the trajectory of a folder: a signal a variable, with the accepted range of the criterion.
/// Nothing where there is no such file or it does not fit.
/// Without the study it is not known when its criteria look at the signals.
pub fn read(folder: &Path, (summary, table): (&Summary, &PointTable), study: Option<&Study>) -> Vec<Series> {
    let mut curves = measured(&folder.join(MEASURED)).unwrap_or_default();
    let mut series = |time: &[f64], (name, values): Signal| {
        let run = [time.first(), time.last()].map(|end| end.copied().unwrap_or_default());
        let (k, _, count) = summary.criteria.get_full(&name)?;
        let (criterion, column) = (&count.criterion, &table.criteria[k]);
        let statistic = Some(criterion.statistic).filter(|_| criterion.metric.is_none());
        // A time or a frequency has another axis than its signal.
        if statistic.is_some_and(|statistic| statistic.unit().is_some()) {
            return None;
        }
        Some(Series {
            judged: study.and_then(|study| judged(study, criterion, run)),
            measured: curves.swap_remove(&name),
            name,
            unit: column.unit.clone(),
            time: time.to_vec(),
            values,
            accepted: statistic
                .is_some_and(|statistic| !statistic.is_difference())
                .then_some([column.lower, column.upper]),
        })
    };
    let mut all = Vec::new();
    for (time, signals) in trajectories(folder) {
        let signals = signals.into_iter();
        all.extend(signals.filter_map(|signal| series(&time, signal)));
    }
    all
}

/// The times between which a criterion looks at a signal of a run; equal ones for its last value.
fn judged(study: &Study, criterion: &Criterion, run: [f64; 2]) -> Option<[f64; 2]> {
    let [start, stop] = run;
    let text = study.criteria.get(&*criterion.name)?;
    let case = text.case.and_then(|case| study.cases.get(case));
    let simulation = match case {
        Some(case) => case.simulation.or(&study.simulation),
        None => study.simulation.clone(),
    };
    let [from, to] = match (&text.window, simulation.warm_up, simulation.window) {
        (Some(window), ..) => window.as_ref().times(run).ok()?,
        (None, Some(warm_up), _) => [start + warm_up, stop],
        (None, None, Some(window)) => [stop - window, stop],
        (None, None, None) => run,
    };
    let last = matches!((criterion.detail, criterion.metric, criterion.statistic), (None, None, Statistic::Final));
    Some([if last { to } else { from }, to])
}

/// The measured curves by the names of their criteria.
fn measured(path: &Path) -> csv::Result<IndexMap<String, ReferenceCurve>> {
    let mut curves = IndexMap::<String, ReferenceCurve>::new();
    for record in csv::Reader::from_path(path)?.records() {
        let record = record?;
        let number = |place: usize| record.get(place).and_then(|cell| cell.parse::<f64>().ok());
        let (Some(name), Some(time), Some(value)) = (record.get(0), number(1), number(2)) else { continue };
        let curve = curves.entry(csv_file::text(name).into_owned()).or_default();
        curve.time.push(time);
        curve.values.push(value);
        curve.uncertainty.extend(number(3));
    }
    Ok(curves)
}

/// A criterion's name, and its signal in the criterion's unit.
pub type Signal = (String, Vec<f64>);

/// The time, s, and the signals by the names of their criteria.
pub type Trajectory = (Vec<f64>, Vec<Signal>);

/// The trajectories of a folder: one, or one a case. None where there is no such file or it is damaged.
pub fn trajectories(folder: &Path) -> Vec<Trajectory> {
    let only = trajectory(&folder.join(file(None)));
    let cases = (0..).map_while(|case| trajectory(&folder.join(file(Some(case)))));
    only.map_or_else(|| cases.collect(), |only| vec![only])
}

fn trajectory(path: &Path) -> Option<Trajectory> {
    let (header, columns) = columns(path).ok()?;
    let mut columns = header.iter().map(|name| csv_file::text(name).into_owned()).zip(columns);
    let (_, time) = columns.next()?;
    Some((time, columns.collect()))
}

/// The names of a table, and its columns.
fn columns(path: &Path) -> csv::Result<(csv::StringRecord, Vec<Vec<f64>>)> {
    let mut table = csv::Reader::from_path(path)?;
    let header = table.headers()?.clone();
    let mut columns = vec![Vec::new(); header.len()];
    for record in table.records() {
        for (column, cell) in columns.iter_mut().zip(&record?) {
            column.push(cell.parse().unwrap_or(f64::NAN));
        }
    }
    Ok((header, columns))
}

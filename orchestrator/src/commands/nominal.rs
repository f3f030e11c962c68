//! The nominal run that travels with a study, every parameter at its median: a smoke test wherever the FMU comes.

use std::collections::{HashMap, HashSet};
use std::path::Path;

use super::isolated::{Columns, Isolated};
use crate::compare::is_rounding;
use crate::error::Error;
use crate::reruns::refined_case;
use crate::session::Session;
use conformity::validation::Refined;
use fmu_points::task::Case;
use result_document::format::number;

/// The trajectories of a case: with the study's communication steps, and with half of them.
pub(super) type Trajectories = [Vec<u8>; 2];

/// The names of the files of a case's trajectories.
pub(super) fn files(case: usize) -> [String; 2] {
    ["", "-finer"].map(|kind| format!("nominal-{}{kind}.csv", case + 1))
}

/// Simulates the nominal run of each case.
pub(super) fn run(session: &mut Session) -> Result<Vec<Trajectories>, Error> {
    let cases = session.plan.cases.clone();
    cases.iter().map(|case| Ok(thinned([once(session, case, 0)?, once(session, case, 1)?]))).collect()
}

/// How many rows of a trajectory travel: what the comparison of a smoke test needs.
const MOST_ROWS: usize = 2_000;

/// Evenly chosen rows of the first trajectory, its last among them, and those of the second at the same times.
fn thinned([coarse, finer]: Trajectories) -> Trajectories {
    let rows =
        |text: &[u8]| -> Vec<Vec<u8>> { text.split_inclusive(|&byte| byte == b'\n').map(<[u8]>::to_vec).collect() };
    let time = |row: &[u8]| -> Vec<u8> { row.split(|&byte| byte == b',').next().unwrap_or(row).to_vec() };
    let all = rows(&coarse);
    let (last, step) = (all.len() - 1, all.len().div_ceil(MOST_ROWS).max(1));
    let kept: Vec<Vec<u8>> = all
        .into_iter()
        .enumerate()
        // The first line is the head.
        .filter(|(k, _)| *k == 0 || *k == last || (k - 1).is_multiple_of(step))
        .map(|(_, row)| row)
        .collect();
    let times: HashSet<Vec<u8>> = kept.iter().map(|row| time(row)).collect();
    let mut finer = rows(&finer);
    finer.retain(|row| times.contains(&time(row)));
    [kept.concat(), finer.concat()]
}

/// One simulation, with steps halved so many times, as csv.
pub(super) fn once(session: &mut Session, case: &Case, halved: i32) -> Result<Vec<u8>, Error> {
    let inputs = session.plan.inputs.iter();
    let medians: Vec<f64> = inputs.map(|input| input.distribution.quantile(0.5)).collect();
    let mut values = Vec::new();
    session.plan.to_fmu(&medians, &mut values);
    let case = [refined_case(case, Refined::Step, halved)];
    let run = Isolated::new(&mut session.package)?;
    let columns = Columns::usual(session.package.description(), false);
    let mut csv = Vec::new();
    run.trajectory(&case[0].task, &values, &columns, &mut csv, Path::new("the nominal run"))?;
    Ok(csv)
}

/// Rows by their times, under the names of their columns.
struct Rows {
    head: csv::StringRecord,
    rows: Vec<csv::StringRecord>,
}

impl Rows {
    fn read(bytes: &[u8]) -> Result<Self, csv::Error> {
        let mut reader = csv::Reader::from_reader(bytes);
        let head = reader.headers()?.clone();
        let rows = reader.into_records().collect::<Result<_, _>>()?;
        Ok(Self { head, rows })
    }

    /// The cells of a column by their times; none where there is no such column.
    fn column(&self, name: &str) -> Option<HashMap<&str, &str>> {
        let place = self.head.iter().position(|head| head == name)?;
        let cells = self.rows.iter().filter_map(|row| Some((row.get(0)?, row.get(place)?)));
        Some(cells.collect())
    }
}

/// The first difference of a trajectory from the carried one, beyond rounding and twice what half the steps change.
///
/// # Errors
/// When one of them is damaged.
pub(super) fn difference(carried: &Trajectories, now: &[u8]) -> Result<Option<String>, csv::Error> {
    let [coarse, finer] = [Rows::read(&carried[0])?, Rows::read(&carried[1])?];
    let now = Rows::read(now)?;
    for name in coarse.head.iter().skip(1) {
        let Some(cells) = now.column(name) else {
            return Ok(Some(format!("{name} is no output any more")));
        };
        let (wanted, halved) = (coarse.column(name).unwrap_or_default(), finer.column(name).unwrap_or_default());
        let away = |time: &str, cell: &str, others: &HashMap<&str, &str>| -> Option<f64> {
            let (one, other): (f64, f64) = (cell.parse().ok()?, others.get(time)?.parse().ok()?);
            Some((one - other).abs())
        };
        let allowed = 2.0 * wanted.iter().filter_map(|(time, cell)| away(time, cell, &halved)).fold(0.0, f64::max);
        for row in &coarse.rows {
            let time = row.get(0).unwrap_or_default();
            let (Some(then), Some(now)) = (wanted.get(time), cells.get(time)) else {
                return Ok(Some(format!("{name} has no value at {time} s")));
            };
            let same = match (then.parse::<f64>(), now.parse::<f64>()) {
                (Ok(then), Ok(now)) => is_rounding(then, now, 0.0) || (then - now).abs() <= allowed,
                // Texts, such as paths, belong to the machine.
                (then, now) => then.is_err() && now.is_err(),
            };
            if !same {
                let allowed = number(allowed, 2);
                return Ok(Some(format!("{name} was {then} at {time} s and is {now}, where {allowed} is numerical")));
            }
        }
    }
    Ok(None)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thinned_trajectories_have_the_same_times_and_the_last() {
        let text = |steps: usize, h: f64| -> Vec<u8> {
            let rows = (0..=steps).map(|k| format!("{},{k}\n", k as f64 * h));
            format!("time,x\n{}", rows.collect::<String>()).into_bytes()
        };
        let short = [text(4, 1.0), text(8, 0.5)];
        let [coarse, finer] = thinned(short.clone());
        assert_eq!(coarse, short[0]);
        assert_eq!(finer, b"time,x\n0,0\n1,2\n2,4\n3,6\n4,8\n");
        let long = [text(15_001, 1.0), text(30_002, 0.5)];
        let [coarse, finer] = thinned(long.clone()).map(|text| String::from_utf8(text).unwrap());
        assert!((1_800..=2_002).contains(&coarse.lines().count()));
        assert!(coarse.ends_with("\n15001,15001\n") && finer.ends_with("\n15001,30002\n"));
        assert_eq!(coarse.lines().count(), finer.lines().count());
        // Each of them counts in the comparison with the whole run.
        let carried = [coarse.into_bytes(), finer.into_bytes()];
        assert_eq!(difference(&carried, &long[0]).unwrap(), None);
        let other = String::from_utf8(long[0].clone()).unwrap().replace("\n15001,", "\n15001,9");
        assert!(difference(&carried, other.as_bytes()).unwrap().is_some());
    }

    #[test]
    fn what_half_the_steps_change_is_no_difference() {
        let carried = ["time,x,s\n0,1,a\n1,2,a\n", "time,x,s\n0,1,a\n0.5,1.6,a\n1,2.1,a\n"];
        let carried = carried.map(|text| text.as_bytes().to_vec());
        let found = |now: &str| difference(&carried, now.as_bytes()).unwrap();
        assert_eq!(found("time,s,x\n0,a,1\n1,a,2.19\n"), None);
        let told = found("time,s,x\n0,a,1\n1,a,2.21\n").unwrap();
        assert_eq!(told, "x was 2 at 1 s and is 2.21, where 0.2 is numerical");
        assert_eq!(found("time,x\n0,1\n1,2\n").unwrap(), "s is no output any more");
        assert_eq!(found("time,x,s\n0,1,a\n").unwrap(), "x has no value at 1 s");
        assert_eq!(found("time,x,s\n0,1,a\n1,2,b\n"), None);
        assert!(found("time,x,s\n0,1,a\n1,,a\n").unwrap().starts_with("x was 2"));
    }
}

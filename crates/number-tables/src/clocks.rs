//! Days and clocks that are written as numbers, such as 20261103 and 131507: read as seconds they would be wrong without a word.

use std::path::Path;

use crate::files::convert;

/// Why times without a unit may be no seconds; `units` says how their unit is stated.
pub fn doubt(path: &Path, name: &str, times: &[f64], beside_days: bool, units: &str) -> Option<String> {
    let known: Vec<f64> = times.iter().copied().filter(|time| time.is_finite()).collect();
    // Seconds since 1970 have ten digits.
    let is_large = known.iter().any(|time| time.abs() > 1e11);
    let are_days = known.len() > 1 && known.iter().all(|time| is_day("", &time.to_string()));
    (is_large || are_days || are_clocks(&known, beside_days)).then(|| {
        format!(
            "time `{name}` has no unit and begins at {}, which is too much for s, or a clock such as 131507; {units}, or s, us or ns; of \
             stamps such as 20261103131507 {}, of clocks with --format \"%H%M%S\", or \"%H%M\"",
            known[0],
            convert(path)
        )
    })
}

/// Whether a cell of a column is a day: by the column's name, by two marks, or by eight figures.
pub(crate) fn is_day(column: &str, cell: &str) -> bool {
    const MARKS: [char; 3] = ['-', '.', '/'];
    let is_named = ["date", "datum", "day", "tag"].iter().any(|word| column.eq_ignore_ascii_case(word));
    let marks = cell.trim_start_matches('-').matches(MARKS).count();
    let is_so = |figures| marks == 2 || marks == 0 && (19_000_000..21_000_000).contains(&figures);
    is_named || cell.replace(MARKS, "").parse::<u32>().is_ok_and(is_so)
}

/// Whether numbers are clocks such as 131507 or 1315: never 60 to 99 seconds or minutes, though they pass them; late in the day or
/// for long, beside days, or in steps that are regular only so.
fn are_clocks(times: &[f64], beside_days: bool) -> bool {
    let part = |time: f64, of: f64| (time / of).floor() % 100.0;
    let is_clock = |time: &f64| part(*time, 1.0) < 60.0 && part(*time, 100.0) < 60.0;
    let passes = times.windows(2).any(|pair| (pair[0] / 100.0).floor() != (pair[1] / 100.0).floor());
    let seconds = |time: &f64| (time / 1e4).floor() * 3600.0 + part(*time, 100.0) * 60.0 + time % 100.0;
    let is_regular = |row: &[f64]| row.windows(3).all(|three| three[2] - three[1] == three[1] - three[0]);
    let has_steps = times.len() > 4 && is_regular(&times.iter().map(seconds).collect::<Vec<_>>()) && !is_regular(times);
    let late = times.iter().filter(|time| **time >= 1e4).count();
    let is_late = late == times.len() || times.len() > 9 && late > 0;
    times.iter().all(is_clock) && passes && (is_late || beside_days || has_steps)
}

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

/// Whether a cell of a column is a day: by the column's name, or by its figures.
pub(crate) fn is_day(column: &str, cell: &str) -> bool {
    let is_named = ["date", "datum", "day", "tag"].iter().any(|word| column.eq_ignore_ascii_case(word));
    let parts: Vec<&str> = cell.split(['-', '.', '/']).collect();
    let are_figures = parts.iter().all(|part| !part.is_empty() && part.bytes().all(|c| c.is_ascii_digit()));
    let within = |from: usize, range: std::ops::RangeInclusive<u32>| {
        cell.get(from..from + 2).and_then(|part| part.parse().ok()).is_some_and(|number| range.contains(&number))
    };
    let is_compact = || cell.len() == 8 && within(0, 19..=20) && within(4, 1..=12) && within(6, 1..=31);
    is_named || are_figures && (parts.len() == 3 || parts.len() == 1 && is_compact())
}

/// Whether numbers are clocks such as 131507 or 1315: never 60 to 99 seconds or minutes, though they pass them; late in the day or
/// for long, beside days, or in steps that are regular only so.
fn are_clocks(times: &[f64], beside_days: bool) -> bool {
    let is_clock = |time: &f64| time % 100.0 < 60.0 && time / 100.0 % 100.0 < 60.0;
    let passes = times.windows(2).any(|pair| (pair[0] / 100.0).floor() != (pair[1] / 100.0).floor());
    let is_regular = |way: fn(f64) -> f64| {
        let mut steps = times.windows(2).map(|pair| way(pair[1]) - way(pair[0]));
        let first = steps.next();
        steps.all(|step| Some(step) == first)
    };
    let seconds = |time: f64| (time / 1e4).floor() * 3600.0 + (time / 100.0).floor() % 100.0 * 60.0 + time % 100.0;
    let has_steps = times.len() > 4 && is_regular(seconds) && !is_regular(|time| time);
    let mut late = times.iter().map(|time| *time >= 1e4);
    let is_late = if times.len() > 9 { late.any(|late| late) } else { late.all(|late| late) };
    times.iter().all(is_clock) && passes && (is_late || beside_days || has_steps)
}

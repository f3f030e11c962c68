//! The page's parts on the model's own error, and on what to improve first.

use serde::Serialize;

use super::format::{number, percent};
use crate::results::Summary;
use crate::results::improvement::{Change, Halved, Prospect, Sign};
use crate::results::validation::Comparison;

/// Both parts as the template shows them.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Outlook {
    /// A row for every criterion: its name, and the numbers of the comparison.
    comparison: Vec<(String, [String; 7])>,
    /// Which of the uncertainties dominates, and why the numerical one is not known.
    notes: Vec<String>,
    /// The first row tells of the study as it is.
    improvements: Vec<[String; 8]>,
    /// How many points the improvements rest on.
    points: u64,
}

impl Outlook {
    /// Conclusions from a finished study.
    pub fn new(summary: &Summary) -> Self {
        let row = |(name, found): (&String, &Comparison)| {
            let unit = summary
                .criteria
                .get(name)
                .and_then(|c| c.criterion.unit.clone());
            let name = unit.map_or_else(|| name.clone(), |unit| format!("{name} ({unit})"));
            (name, compared(found))
        };
        let note = |(name, found): (&String, &Comparison)| {
            let bound = if found.complete {
                ""
            } else {
                "; since not all uncertainties are known, E ± 2 u_val is wider than stated"
            };
            format!(
                "{name}: the {} uncertainty dominates; numerical uncertainty {}{bound}",
                found.dominant, found.u_num_note
            )
        };
        let missing = (summary.failed > 0 && !summary.validation.is_empty()).then(|| {
            format!(
                "Mean and spread are those of the {} points that have a result; {} failed",
                summary.points - summary.failed,
                summary.failed
            )
        });
        let improvements = summary.improvements.as_ref();
        Self {
            comparison: summary.validation.iter().map(row).collect(),
            notes: summary.validation.iter().map(note).chain(missing).collect(),
            improvements: improvements.map_or_else(Vec::new, |found| {
                let now = prospect("as it is", "", [String::new(), String::new()], &found.now);
                std::iter::once(now)
                    .chain(found.changes.iter().map(change))
                    .collect()
            }),
            points: improvements.map_or(0, |found| found.points),
        }
    }
}

fn compared(found: &Comparison) -> [String; 7] {
    let known = |u: Option<f64>| u.map_or_else(|| "not known".to_owned(), |u| number(u, 3));
    let least = if found.complete { "" } else { "at least " };
    let [low, high] = found.model_error.map(|limit| number(limit, 3));
    [
        number(found.error, 3),
        known(found.u_num),
        number(found.u_input, 3),
        known(found.u_d),
        format!("{least}{}", number(found.u_val, 3)),
        format!("{least}{low} … {high}"),
        found.dominant.clone(),
    ]
}

fn change(found: &Change) -> [String; 8] {
    let what = match found.halved {
        Halved::Uncertainty => "measured value's uncertainty",
        Halved::Tolerance => "parameter's tolerance",
    };
    let plus = |gain: f64| {
        let sign = if gain > 0.0 { "+" } else { "" };
        format!("{sign}{}", number(100.0 * gain, 2))
    };
    let interval = match (found.gain_interval, found.sign()) {
        (None, _) => "–".to_owned(),
        (Some(ends), sign) => {
            let [low, high] = ends.map(plus);
            let open = match sign {
                Sign::Open => ": not distinguishable from 0",
                Sign::Gain | Sign::Loss => "",
            };
            format!("{low} … {high}{open}")
        }
    };
    prospect(
        &found.name,
        what,
        [plus(found.gain), interval],
        &found.prospect,
    )
}

fn prospect(
    name: &str,
    what: &str,
    [gain, interval]: [String; 2],
    found: &Prospect,
) -> [String; 8] {
    [
        name.to_owned(),
        what.to_owned(),
        gain,
        interval,
        percent(found.accepted),
        found
            .not_conforming_given_accepted
            .map_or_else(|| "–".to_owned(), percent),
        found
            .verdict
            .map_or_else(|| "–".to_owned(), |verdict| verdict.to_string()),
        number(found.effective_points, 3),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_known_is_not_shown_as_0() {
        let found = Comparison {
            model: 81.0,
            error: -1.0,
            u_num: None,
            u_num_note: "not observed".into(),
            u_input: 0.5,
            u_d: None,
            u_val: 0.5,
            complete: false,
            coverage: 2.0,
            model_error: [-2.0, 0.0],
            dominant: "input".into(),
        };
        let row = compared(&found);
        assert_eq!(
            [&row[1][..], &row[3], &row[4]],
            ["not known", "not known", "at least 0.5"]
        );
    }
}

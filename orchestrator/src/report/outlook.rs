//! The page's parts on the model's own error, and on what to improve first.

use serde::Serialize;

use super::format::{number, percent};
use crate::results::Summary;
use crate::results::improvement::{Change, Halved, Prospect};
use crate::results::validation::Comparison;

/// Both parts as the template shows them.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Outlook {
    /// A row for every criterion: its name, and the numbers of the comparison.
    comparison: Vec<(String, [String; 7])>,
    /// Which of the uncertainties dominates, and why the numerical one is not known.
    notes: Vec<String>,
    /// The first row tells of the study as it is.
    improvements: Vec<[String; 7]>,
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
            format!(
                "{name}: the {} uncertainty dominates; numerical uncertainty {}",
                found.dominant, found.u_num_note
            )
        };
        let improvements = summary.improvements.as_ref();
        Self {
            comparison: summary.validation.iter().map(row).collect(),
            notes: summary.validation.iter().map(note).collect(),
            improvements: improvements.map_or_else(Vec::new, |found| {
                let now = prospect("as it is", "", String::new(), &found.now);
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
        format!("{low} … {high}"),
        found.dominant.clone(),
    ]
}

fn change(found: &Change) -> [String; 7] {
    let what = match found.halved {
        Halved::Uncertainty => "measured value's uncertainty",
        Halved::Tolerance => "parameter's tolerance",
    };
    let sign = if found.gain > 0.0 { "+" } else { "" };
    prospect(
        &found.name,
        what,
        format!("{sign}{}", number(100.0 * found.gain, 2)),
        &found.prospect,
    )
}

fn prospect(name: &str, what: &str, gain: String, found: &Prospect) -> [String; 7] {
    [
        name.to_owned(),
        what.to_owned(),
        gain,
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

//! The documents on the model's own error, and on what to improve first.

use crate::results::Summary;
use crate::results::answer::improve_first;
use crate::results::improvement::{Change, Halved, Improvements, Prospect, Sign};
use conformity::validation::Comparison;
use result_document::format::{number, percent};
use result_document::{Document, Table, numbers, words};

/// The model's own error, where the study tells it.
pub fn comparison(summary: &Summary) -> Option<Document> {
    let mut told = Document::new("comparison", "Model's error", "The model's own error");
    let row = |(name, comparison): (&String, &Comparison)| {
        let criterion = summary.criteria.get(name);
        let unit = criterion.and_then(|c| c.criterion.unit.as_ref());
        let name = unit.map_or_else(|| name.clone(), |unit| format!("{name} ({unit})"));
        let numbers = compared(comparison).into_iter();
        std::iter::once(name).chain(numbers).collect()
    };
    told.table(Table {
        name: "Validation comparison".into(),
        class: "stack".into(),
        columns: vec![
            words("Criterion"),
            numbers("E"),
            numbers("u_{num}"),
            numbers("u_{input}"),
            numbers("u_{D}"),
            numbers("u_{val}"),
            numbers("k (degrees of freedom)"),
            numbers("E ± k u_{val}"),
            numbers("E_{n}"),
            words("Largest"),
        ],
        rows: summary.validation.iter().map(row).collect(),
    });
    let note = |(name, comparison): (&String, &Comparison)| {
        let bound = match comparison.complete {
            true => "",
            false => "; since not all uncertainties are known, E ± k u_{val} is wider than stated",
        };
        format!(
            " {name}: the {} uncertainty dominates; numerical uncertainty {}{bound}.",
            comparison.dominant, comparison.u_num_note
        )
    };
    let notes: String = summary.validation.iter().map(note).collect();
    let missing = match summary.failed {
        0 => String::new(),
        failed => format!(
            " Mean and spread are those of the {} points that have a result; {failed} failed.",
            summary.points - failed
        ),
    };
    told.hint(format!(
        "After ASME V&V 20: E is the mean of the model's values minus the measured value. Where all uncertainties are known, \
         the model's own error lies in E ± k u_{{val}}; otherwise the interval is at least so wide. E_{{n}} is E over \
         the expanded uncertainty of both values (ISO 13528): above 1 they disagree. u_{{val}} joins the \
         uncertainties of the numerical solution, of the parameters (the spread of the points) and of the measured value. \
         What is called verification here, V&V 10 and V&V 20 call validation: a comparison with measurements.{notes}{missing}"
    ));
    (!summary.validation.is_empty()).then_some(told)
}

fn compared(comparison: &Comparison) -> [String; 9] {
    let known = |u: Option<f64>| u.map_or_else(|| "not known".to_owned(), |u| number(u, 3));
    let least = if comparison.complete { "" } else { "at least " };
    let [low, high] = comparison.model_error.map(|limit| number(limit, 3));
    [
        number(comparison.error, 3),
        known(comparison.u_num),
        number(comparison.u_input, 3),
        known(comparison.u_d),
        format!("{least}{}", number(comparison.u_val, 3)),
        match comparison.freedom {
            Some(freedom) => format!("{} ({})", number(comparison.coverage, 3), number(freedom, 2)),
            None => number(comparison.coverage, 3),
        },
        format!("{least}{low} .. {high}"),
        comparison.e_n.map_or_else(|| "–".to_owned(), |e_n| number(e_n, 2)),
        comparison.dominant.clone(),
    ]
}

/// How the study would come out with half an uncertainty or half a tolerance.
pub fn improvements(summary: &Summary) -> Option<Document> {
    let improvements = summary.improvements.as_ref()?;
    let title = "What to improve first";
    let mut told = Document::new("improvements", "Improve first", title);
    if let Some(first) = improve_first(summary) {
        told.say(first);
    }
    let intervals = summary.verified_interval.is_some();
    told.table(table(improvements, intervals));
    let held = match intervals {
        true => {
            " Its intervals hold all together with 95 %, as if the points were independent; a gain whose interval holds 0 \
             may be chance, and more points tell. Sure gains come first, sure losses last."
        }
        false => "",
    };
    told.hint(format!(
        "How the study would come out if one measured value's uncertainty, or one parameter's tolerance, were half of what it \
         is: by judging or weighting the first {} points anew, without new runs. The gain is that of the {}.{held}",
        improvements.points,
        improvements.now.worth()
    ));
    Some(told)
}

/// The first row tells of the study as it is.
fn table(improvements: &Improvements, intervals: bool) -> Table {
    let nothing = || [String::new(), String::new(), String::new()];
    let now = row("as it is", nothing(), &improvements.now);
    let changes = improvements.changes.iter().map(change);
    let mut table = Table {
        name: "What to improve first".into(),
        class: "stack wrap".into(),
        columns: vec![
            words("If halved"),
            words("Kind"),
            numbers("Gain, %"),
            words("95 % interval"),
            numbers("Accepted, %"),
            numbers("Of these not conforming, %"),
            words("Verdict"),
            numbers("Effective sample size"),
        ],
        rows: std::iter::once(now).chain(changes).collect(),
    };
    if !intervals {
        const INTERVAL: usize = 3;
        table.columns.remove(INTERVAL);
        for row in &mut table.rows {
            row.remove(INTERVAL);
        }
    }
    table
}

fn change(change: &Change) -> Vec<String> {
    let what = match change.halved {
        Halved::Uncertainty => "measured value's uncertainty",
        Halved::Tolerance => "parameter's tolerance",
    };
    let plus = |gain: f64| {
        // Differences of shares that are equal but for rounding.
        let gain = if gain.abs() < 1e-9 { 0.0 } else { gain };
        let sign = if gain > 0.0 { "+" } else { "" };
        format!("{sign}{}", number(100.0 * gain, 2))
    };
    let open = match change.sign() {
        Sign::Open => ": not distinguishable from 0",
        Sign::Gain | Sign::Loss => "",
    };
    let interval = change.gain_interval.map(|ends| ends.map(plus));
    let interval = interval.map_or_else(|| "–".to_owned(), |[low, high]| format!("{low} .. {high}{open}"));
    let gain = [what.to_owned(), plus(change.gain), interval];
    row(&change.name, gain, &change.prospect)
}

/// A change, its gain, and its consequences.
fn row(name: &str, gain: [String; 3], prospect: &Prospect) -> Vec<String> {
    let risk = prospect.not_conforming_given_accepted.map(percent);
    let verdict = prospect.verdict.map(|verdict| verdict.to_string());
    let [risk, verdict] = [risk, verdict].map(|cell| cell.unwrap_or_else(|| "–".to_owned()));
    let follows = [percent(prospect.accepted), risk, verdict, number(prospect.effective_points, 3)];
    std::iter::once(name.to_owned()).chain(gain).chain(follows).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_known_is_not_shown_as_0() {
        let comparison = Comparison {
            model: 81.0,
            error: -1.0,
            u_num: None,
            u_num_note: "not observed".into(),
            u_input: 0.5,
            points: 40,
            u_d: None,
            u_val: 0.5,
            complete: false,
            freedom: None,
            e_n: None,
            coverage: 2.0,
            model_error: [-2.0, 0.0],
            dominant: "input".into(),
        };
        let row = compared(&comparison);
        assert_eq!([&row[1][..], &row[3], &row[4]], ["not known", "not known", "at least 0.5"]);
    }
}

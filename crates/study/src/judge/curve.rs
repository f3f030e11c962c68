//! Criteria on whole curves, as far as they need neither the FMU nor the measured curve.

use super::criterion::Criterion;
use crate::{CriterionText, Name, ReferenceText, Result, Study, first_wrong, limit::limit};
use conformity::measured::Limits;
use curves::{Kind, Metric};
use fmu_import::quantity::Scale;

/// Refuses keys of curves on a criterion that has no `reference`.
pub fn refuse_keys(text: &CriterionText) -> Result<(), String> {
    [
        ("metric", text.metric.is_some()),
        ("normalise", text.normalise.is_some()),
        ("band", text.band.is_some()),
        ("least", text.least.is_some()),
        ("delay", text.delay.is_some()),
        ("lag", text.lag.is_some()),
    ]
    .iter()
    .find(|(_, there)| *there)
    .map_or(Ok(()), |(key, _)| Err(format!("`{key}` belongs to a measured curve; add `reference`, or remove `{key}`")))
}

/// The criterion on a curve: the metric's value has the ideal value 0 or 1, and may be so far away from it.
pub fn criterion(study: &Study, name: &Name, text: &CriterionText, scale: &Scale) -> Result<Criterion> {
    let at = |message| study.error_of(name, message);
    let metric = text.metric.ok_or_else(|| {
        let names: Vec<String> = Metric::ALL.iter().map(|metric| metric.name()).collect();
        at(format!("a curve needs `metric`: {}", names.join(", ")))
    })?;
    check_keys(text, metric).map_err(at)?;
    text.detail().map_err(at)?;
    if let Some(lag) = &text.lag {
        lag.ends().map_err(at)?;
    }
    let (nominal, tolerance, stated) = limit(text, metric, scale).map_err(at)?;
    let reference = text.reference.as_ref();
    Ok(Criterion {
        name: name.as_ref().clone(),
        variable: text.variable.as_ref().clone(),
        statistic: text.statistic.unwrap_or_default(),
        metric: Some(metric),
        unit: scale.unit.clone().filter(|_| metric.kind() == Kind::Error),
        limits: Limits::within(nominal, tolerance),
        stated_tolerance: stated,
        row_correlation: reference.filter(|reference| reference.is_uncertain()).map(ReferenceText::row_correlation),
        group: text.group.clone(),
        ..Criterion::default()
    })
}

fn check_keys(text: &CriterionText, metric: Metric) -> Result<(), String> {
    let is_error = metric.kind() != Kind::Rating;
    first_wrong(&[
        (text.nominal.is_some(), "`nominal` has no place beside `reference`, which is what is measured; remove it"),
        (text.nominal_from.is_some(), "`nominal-from` belongs to `nominal`, and a curve has `reference`; remove it"),
        (
            text.at_most.is_some() || text.at_least.is_some() || text.measured.is_some() || text.derived.is_some(),
            "`at-most`, `at-least`, `measured` and `derived` belong to a measured value; a curve has `tolerance` or `least`",
        ),
        (text.statistic.is_some(), "`statistic` has no place beside `reference`; `metric` compares whole curves"),
        (
            text.uncertainty.is_some()
                || text.coverage.is_some()
                || text.uncertainty_distribution.is_some()
                || text.gain_uncertainty.is_some()
                || text.noise.is_some()
                || text.repeats.is_some(),
            "the uncertainty of a curve stands in its reference: reference = { ..., uncertainty = ... }",
        ),
        (text.normalise.is_some() && metric != Metric::Nrmse, "`normalise` belongs to metric = \"nrmse\"; remove it"),
        (text.band.is_some() && metric != Metric::Corridor, "`band` belongs to metric = \"corridor\"; remove it"),
        (
            text.least.is_some() && is_error,
            "`least` belongs to the metrics corridor and iso18571; remove it, and state the largest error as `tolerance`",
        ),
        (
            text.tolerance.is_some() && !is_error,
            "`tolerance` belongs to errors; give the least share or rating, such as least = 0.9",
        ),
        (text.tolerance.is_none() && is_error, "the largest error is missing: add `tolerance`"),
        (
            text.least.is_none() && !is_error,
            "the least share or rating is missing: add `least`, such as 0.9 or \"90 %\"",
        ),
        (text.column_unit.is_some() && metric.kind() != Kind::Error, "this metric has no unit; remove `column-unit`"),
    ])
}

#[cfg(test)]
mod tests {
    use crate::Study;
    use crate::judge::Judge;
    use std::path::Path;

    const STUDY: &str = r#"
fmu = "a.fmu"
[criteria.M]
variable = "m"
reference = { file = "m.csv", unit = "N.m" }
metric = "rmse"
tolerance = "0.02 N.m"
unit = "N.m"
[criteria.S]
variable = "m"
reference = { file = "m.csv" }
metric = "corridor"
band = "5 %"
least = "90 %"
[criteria.N]
variable = "m"
reference = { file = "m.csv" }
metric = "nrmse"
normalise = "mean"
tolerance = 0.05
"#;

    fn judge(changes: &[(&str, &str)]) -> Result<Judge, String> {
        let mut text = STUDY.to_owned();
        for (from, to) in changes {
            assert!(text.contains(from), "{from}");
            text = text.replacen(from, to, 1);
        }
        let study = Study::parse(Path::new("s.toml"), text).map_err(|error| error.to_string())?;
        Judge::new(&study, None).map_err(|error| error.to_string())
    }

    #[test]
    fn errors_have_a_limit_above_and_ratings_one_below() {
        let judge = judge(&[]).unwrap();
        let accepts = |values: [f64; 3]| judge.verdict(Some(&values)).passed;
        assert_eq!(accepts([0.02, 0.9, 0.05]), [true; 3]);
        assert_eq!(accepts([0.0201, 0.8999, 0.0501]), [false; 3]);
        assert_eq!(accepts([0.0, 1.0, 0.0]), [true; 3]);
        assert_eq!(judge.criteria[0].stated_tolerance, "rmse at most 0.02 N.m");
        assert_eq!(judge.criteria[0].unit.as_deref(), Some("N.m"));
        assert_eq!(judge.criteria[0].accepted(), [0.0, 0.02]);
        let [least, most] = judge.criteria[1].accepted();
        assert!((least - 0.9).abs() < 1e-12 && (most - 1.0).abs() < 1e-8);
        assert_eq!(judge.criteria[1].unit, None);
        assert_eq!(judge.criteria[2].source(), "normalised rmse of m");
    }

    #[test]
    fn all_of_a_corridor_means_all() {
        let judge = judge(&[("\"90 %\"", "1")]).unwrap();
        let accepts = |share: f64| judge.verdict(Some(&[0.0, share, 0.0])).passed[1];
        assert!(accepts(1.0) && !accepts(1.0 - 1e-6));
        // The interval that people see holds what is accepted.
        let [least, most] = judge.criteria[1].accepted();
        assert!(least <= 1.0 && most >= 1.0, "{least} to {most}");
    }

    /// The column of a table of results that `judge` reads is in that unit.
    #[test]
    fn the_column_of_an_error_in_a_unit_may_be_in_another_one() {
        let with = |metric: &str| judge(&[(metric, &format!("{metric}\ncolumn-unit = \"mN.m\""))]);
        assert!(with("metric = \"rmse\"").is_ok());
        for metric in ["metric = \"corridor\"", "metric = \"nrmse\""] {
            let error = with(metric).unwrap_err();
            assert!(error.contains("remove `column-unit`"), "{error}");
        }
    }

    #[test]
    fn mistakes_have_their_place_and_remedy() {
        for (changes, remedy) in [
            (("metric = \"rmse\"\n", ""), "needs `metric`: rmse, nrmse"),
            (("metric = \"rmse\"", "metric = \"rmse\"\nnominal = 3"), "`nominal` has no place"),
            (("metric = \"rmse\"", "metric = \"rmse\"\nstatistic = \"mean\""), "`statistic` has no place"),
            (("metric = \"rmse\"", "metric = \"rmse\"\nuncertainty = 1"), "stands in its reference"),
            (("metric = \"rmse\"", "metric = \"rmse\"\nband = 1"), "belongs to metric = \"corridor\""),
            (("tolerance = \"0.02 N.m\"\n", ""), "add `tolerance`"),
            (("\"0.02 N.m\"", "\"2 %\""), "use metric = \"nrmse\""),
            (("\"0.02 N.m\"", "-1"), "positive, finite"),
            (("least = \"90 %\"\n", ""), "add `least`"),
            (("\"90 %\"", "90"), "at most 1"),
            (("tolerance = 0.05", "tolerance = \"0.05 N.m\""), "positive share"),
            (("reference = { file = \"m.csv\", unit = \"N.m\" }\n", "nominal = 1\n"), "add `reference`"),
            (("reference = { file = \"m.csv\", unit = \"N.m\" }\nmetric = \"rmse\"\n", ""), "add `nominal`"),
        ] {
            let error = judge(&[changes]).unwrap_err();
            let place = ["s.toml:3:11:", "s.toml:8:11:", "s.toml:9:11:", "s.toml:14:11:", "s.toml:15:11:"];
            assert!(place.iter().any(|place| error.starts_with(place)), "{error}");
            assert!(error.contains(remedy), "{error}");
        }
    }
}

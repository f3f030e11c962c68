//! The verdict on the page: its words, and what accepting points risks.

use serde::Serialize;

use super::format::{number, percent};
use crate::analysis::table::PointTable;
use crate::results::{Summary, words};
use conformity::decision::Decision;
use conformity::measured::{Measured, Measurement};
use conformity::risk::Risk;

/// The verdict with its risks.
#[derive(Clone, Debug, Default)]
pub struct Judgement {
    /// The verdict; where there is none, one point that meets all criteria is enough.
    pub decision: Option<Decision>,
    /// Whether a share of the sampled space is required.
    pub by_share: bool,
    /// The verdict in words, a sentence each.
    pub sentences: Vec<String>,
    /// The measured values with their uncertainties, in the order of the criteria.
    pub measurement: Measurement,
    /// The risks of each criterion alone, where its uncertainty is known.
    pub risks: Vec<Option<Risk>>,
    /// The risks of all criteria together, where all uncertainties are known.
    pub all: Option<Risk>,
}

impl Judgement {
    /// The verdict of a finished study.
    ///
    /// # Errors
    /// When the summary contradicts itself.
    pub fn new(summary: &Summary) -> Result<Self, String> {
        let conclusion = summary.conclusion.as_ref();
        let criteria = summary.criteria.values();
        Ok(Self {
            decision: conclusion.map(|found| found.verdict),
            by_share: conclusion.is_some_and(|found| found.required.is_some()),
            sentences: words::sentences(summary),
            measurement: summary.measurement()?,
            risks: criteria.map(|entry| entry.risk.clone()).collect(),
            all: conclusion.and_then(|found| found.risk.clone()),
        })
    }

    /// The conformance probability of every point, 0 of one that failed; none where an uncertainty is not known.
    pub(super) fn conformance(&self, table: &PointTable) -> Option<Vec<f64>> {
        if !self.measurement.complete() {
            return None;
        }
        let of = |point: usize| {
            let values: Vec<f64> = table.criteria.iter().map(|c| c.values[point]).collect();
            if values.iter().any(|value| !value.is_finite()) {
                return Some(0.0);
            }
            self.measurement.assess(&values).all.probability
        };
        (0..table.len()).map(of).collect()
    }

    /// A row for every criterion, and one for all of them; none where no risk is known.
    pub(super) fn rows(&self, table: &PointTable) -> Vec<RiskRow> {
        if self.risks.iter().all(Option::is_none) {
            return Vec::new();
        }
        let measured = self.measurement.criteria();
        let own = table.criteria.iter().zip(measured).zip(&self.risks);
        let own = own.map(|((criterion, measured), risk)| {
            RiskRow::new(
                &criterion.name,
                Some((measured, &criterion.unit)),
                risk.as_ref(),
            )
        });
        let all = RiskRow::new("all criteria", None, self.all.as_ref());
        own.chain(std::iter::once(all)).collect()
    }
}

/// A row of the table of risks.
#[derive(Serialize)]
pub(super) struct RiskRow {
    name: String,
    total: bool,
    tolerance: String,
    uncertainty: String,
    capability: String,
    /// Per cent and interval of the consumer's risk, the producer's, and that of an accepted point.
    risks: Vec<[String; 2]>,
}

impl RiskRow {
    fn new(name: &str, measured: Option<(&Measured, &String)>, risk: Option<&Risk>) -> Self {
        let unit = |unit: &str| match unit {
            "" | "1" => String::new(),
            unit => format!(" {unit}"),
        };
        let stated = measured.and_then(|(m, u)| Some((m.uncertainty?, unit(u))));
        let share = |value: Option<f64>, interval: Option<[f64; 2]>| {
            let range = |[low, high]: [f64; 2]| format!("{} – {}", percent(low), percent(high));
            value.map_or_else(
                || ["–".to_owned(), String::new()],
                |value| [percent(value), interval.map(range).unwrap_or_default()],
            )
        };
        let risks = risk.map(|risk| {
            let intervals = risk.intervals.as_ref();
            let given = risk.not_conforming_given_accepted;
            vec![
                share(Some(risk.consumer), intervals.map(|of| of.consumer)),
                share(Some(risk.producer), intervals.map(|of| of.producer)),
                share(given, intervals.map(|of| of.not_conforming_given_accepted)),
            ]
        });
        let unknown = || vec![["–".to_owned(), String::new()]; 3];
        Self {
            name: name.to_owned(),
            total: measured.is_none(),
            tolerance: measured.map_or_else(String::new, |(m, u)| {
                format!("±{}{}", number(m.tolerance, 4), unit(u))
            }),
            uncertainty: match stated {
                Some((u, unit)) => format!(
                    "{}{unit} (k = {})",
                    number(u.expanded, 4),
                    number(u.coverage, 3)
                ),
                None if measured.is_some() => "not stated".to_owned(),
                None => String::new(),
            },
            capability: measured
                .and_then(|(m, _)| m.capability())
                .map_or_else(String::new, |c| number(c, 3)),
            risks: risks.unwrap_or_else(unknown),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::table::CriterionColumn;
    use conformity::measured::Uncertainty;

    fn table(values: &[f64]) -> PointTable {
        PointTable {
            ids: (1..=values.len() as u64).collect(),
            criteria: vec![CriterionColumn {
                name: "T".into(),
                source: String::new(),
                unit: "degC".into(),
                nominal: 10.0,
                lower: 8.0,
                upper: 12.0,
                group: None,
                ok: values.iter().map(|v| (8.0..=12.0).contains(v)).collect(),
                values: values.to_vec(),
            }],
            ..PointTable::default()
        }
    }

    fn judgement(uncertainty: Option<f64>) -> Judgement {
        let criterion = Measured {
            nominal: 10.0,
            tolerance: 2.0,
            uncertainty: uncertainty.map(|expanded| Uncertainty {
                expanded,
                coverage: 2.0,
            }),
        };
        Judgement {
            measurement: Measurement::new(vec![criterion], &[]).unwrap(),
            risks: vec![None],
            ..Judgement::default()
        }
    }

    #[test]
    fn points_conform_with_the_probability_of_their_uncertainty() {
        let found = judgement(Some(2.0)).conformance(&table(&[10.0, 12.0, 20.0, f64::NAN]));
        let p = found.unwrap();
        assert!((p[0] - 0.954_499_7).abs() < 1e-6 && (p[1] - 0.5).abs() < 1e-4);
        assert!(p[2] < 1e-9 && p[3] == 0.0);
        assert_eq!(judgement(None).conformance(&table(&[10.0])), None);
    }

    #[test]
    fn risks_that_are_not_known_have_no_table() {
        assert!(judgement(None).rows(&table(&[10.0])).is_empty());
    }
}

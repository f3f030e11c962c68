//! The verdict on the page: its words, and what accepting points risks.

use std::borrow::Cow;

use crate::results::Summary;
use conformity::{
    conclusion::{Conclusion, Requirement, in_percent},
    measured::{Assessed, Measurement},
    risk::Guard,
};
use parameter_regions::table::PointTable;
use result_document::format::number;

/// The verdict with its risks.
#[derive(Clone, Debug, Default)]
pub struct Judgement {
    /// The verdict with what it rests on; where there is none, one point that meets all criteria is enough.
    pub conclusion: Option<Conclusion>,
    /// The guard band in expanded uncertainties, where one acts; infinite where nothing is accepted.
    pub guard: Option<f64>,
    /// The measured values with their uncertainties, in the order of the criteria.
    pub measurement: Measurement,
}

impl Judgement {
    /// The verdict of a finished study.
    ///
    /// # Errors
    /// When the summary contradicts itself.
    pub fn new(summary: &Summary) -> Result<Self, String> {
        let conclusion = summary.conclusion.as_ref();
        Ok(Self {
            conclusion: conclusion.cloned(),
            guard: conclusion.and_then(|conclusion| match conclusion.guard_band {
                Some(0.0) => None,
                band => Some(band.unwrap_or(f64::INFINITY)),
            }),
            measurement: summary.measurement()?,
        })
    }

    /// The largest probability not to conform of an accepted point, where each has to keep it.
    fn point_risk(&self) -> Option<f64> {
        self.conclusion.as_ref()?.point_risk
    }

    /// Whether fewer points may be accepted than lie within all tolerances.
    pub(super) fn is_guarded(&self) -> bool {
        self.guard.is_some() || self.point_risk().is_some()
    }

    /// What decides on the acceptance of points within all tolerances, where anything does.
    pub(super) fn rule_of_acceptance(&self) -> Option<String> {
        match (self.point_risk(), self.guard) {
            (Some(risk), _) => Some(format!("each conforms with {} % or more", in_percent(1.0 - risk))),
            (None, Some(band)) if band.is_finite() => {
                Some(format!("each tolerance drawn in by {} expanded uncertainties (guard band)", number(band, 3)))
            }
            (None, Some(_)) => Some("no guard band is shown to keep the risk as low as required".into()),
            (None, None) => None,
        }
    }

    /// The share that decided and how many points are accepted, where a share of the sampled space is required.
    pub(super) fn required(&self) -> Option<(&Requirement, usize)> {
        let conclusion = self.conclusion.as_ref()?;
        Some((conclusion.required.as_ref()?, conclusion.accepted as usize))
    }

    /// The table in which those points count as verified that are accepted: under a guard band these are fewer than those
    /// within all tolerances.
    pub(super) fn as_accepted<'a>(&self, table: &'a PointTable) -> Cow<'a, PointTable> {
        let guard = match (self.point_risk(), self.guard) {
            (Some(risk), _) => Guard::EachPoint { risk },
            (None, Some(band)) => Guard::Given(band),
            (None, None) => return Cow::Borrowed(table),
        };
        let accepted = |point: usize| {
            let values: Vec<f64> = table.criteria.iter().map(|c| c.values[point]).collect();
            let all = || match guard {
                Guard::EachPoint { .. } => self.measurement.assess(&values).all,
                _ => Assessed { margin: self.measurement.margin(&values), probability: None },
            };
            table.verified[point] && guard.accepts(all(), None)
        };
        Cow::Owned(PointTable { verified: (0..table.len()).map(accepted).collect(), ..table.clone() })
    }

    /// The acceptance interval of a criterion, where a guard band draws the tolerance interval in; the lower end lies above
    /// the upper one where nothing is left.
    pub(super) fn drawn_in(&self, criterion: usize, [lower, upper]: [f64; 2]) -> Option<[f64; 2]> {
        let measured = self.measurement.criteria().get(criterion)?;
        let band = self.guard? * measured.error?.expanded;
        Some([lower + band, upper - band])
    }

    /// The conformance probability of every point, 0 of one that failed; none where an uncertainty is not known.
    pub(super) fn conformance(&self, table: &PointTable) -> Option<Vec<f64>> {
        if !self.measurement.complete() {
            return None;
        }
        (0..table.len())
            .map(|point| {
                let values: Vec<f64> = table.criteria.iter().map(|c| c.values[point]).collect();
                if values.iter().any(|value| !value.is_finite()) {
                    return Some(0.0);
                }
                self.measurement.assess(&values).all.probability
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use conformity::measured::Measured;
    use conformity::uncertainty::Uncertainty;
    use parameter_regions::table::CriterionColumn;

    fn table(values: &[f64]) -> PointTable {
        PointTable {
            ids: (1..=values.len() as u64).collect(),
            criteria: vec![CriterionColumn {
                name: "T".into(),
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
        let error = uncertainty.map(|expanded| Uncertainty::normal(expanded, 2.0).law(10.0));
        let criterion = Measured::within(10.0, 2.0, error);
        Judgement { measurement: Measurement::new(vec![criterion], &[]).unwrap(), ..Judgement::default() }
    }

    #[test]
    fn points_conform_with_the_probability_of_their_uncertainty() {
        let p = judgement(Some(2.0)).conformance(&table(&[10.0, 12.0, 20.0, f64::NAN]));
        let p = p.unwrap();
        assert!((p[0] - 0.954_499_7).abs() < 1e-6 && (p[1] - 0.5).abs() < 1e-4);
        assert!(p[2] < 1e-9 && p[3] == 0.0);
        assert_eq!(judgement(None).conformance(&table(&[10.0])), None);
    }

    /// A guard band of 1 draws 8 .. 12 in by U = 0.5.
    #[test]
    fn a_guard_band_leaves_fewer_points_accepted_than_within_tolerance() {
        let mut judgement = judgement(Some(0.5));
        let mut points = table(&[10.0, 11.4, 11.6, 12.5]);
        points.verified = vec![true, true, true, false];
        assert_eq!(judgement.drawn_in(0, [8.0, 12.0]), None);
        assert_eq!(judgement.as_accepted(&points).verified, points.verified);
        judgement.guard = Some(1.0);
        assert_eq!(judgement.drawn_in(0, [8.0, 12.0]), Some([8.5, 11.5]));
        let accepted = judgement.as_accepted(&points).verified.clone();
        assert_eq!(accepted, [true, true, false, false]);
        judgement.guard = Some(f64::INFINITY);
        assert_eq!(judgement.as_accepted(&points).verified, [false; 4]);
    }
}

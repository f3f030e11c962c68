//! Measured values with their uncertainties, and the probability that one point conforms.

use serde::{Deserialize, Serialize};

use super::joint::JointNormal;

/// The uncertainty of a measured value (JCGM 100:2008).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Uncertainty {
    /// The expanded uncertainty U, in the criterion's unit.
    pub expanded: f64,
    /// The coverage factor k: U is k standard uncertainties.
    pub coverage: f64,
}

impl Uncertainty {
    /// The standard uncertainty u.
    pub fn standard(&self) -> f64 {
        self.expanded / self.coverage
    }
}

/// A measured value with its tolerance interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured {
    /// The measured value D.
    pub nominal: f64,
    /// How far the model may be from the true value, to both sides.
    pub tolerance: f64,
    /// How far the measured value may be from the true value, where that is known.
    pub uncertainty: Option<Uncertainty>,
}

impl Measured {
    /// How far a model value is within the tolerance, in expanded uncertainties: a guard band of
    /// that many would just let it pass. Negative outside of the tolerance interval and for a value that is not a
    /// number; infinite where no uncertainty is known, since then there is nothing to guard against.
    pub fn margin(&self, value: f64) -> f64 {
        let rest = self.tolerance - (value - self.nominal).abs();
        match self.uncertainty {
            Some(uncertainty) if !rest.is_nan() => rest / uncertainty.expanded,
            None if rest >= 0.0 => f64::INFINITY,
            _ => f64::NEG_INFINITY,
        }
    }

    /// The measurement capability index C_m (JCGM 106:2012, 7.6.3).
    pub fn capability(&self) -> Option<f64> {
        let uncertainty = self.uncertainty?;
        Some(self.tolerance / (2.0 * uncertainty.standard()))
    }

    /// The largest probability not to conform of values with at least this [margin](Self::margin), which is 0 or more:
    /// that of the one farthest from the measured value. `None` where no uncertainty is known.
    pub fn most_not_conforming(&self, margin: f64) -> Option<f64> {
        let uncertainty = self.uncertainty?;
        let away = (self.tolerance - margin * uncertainty.expanded).max(0.0);
        let [lower, upper] = self.limits(self.nominal + away, uncertainty);
        Some(1.0 - super::normal::between(lower, upper))
    }

    /// The errors of the measured value, in standard uncertainties, with which a model value
    /// conforms.
    fn limits(&self, value: f64, uncertainty: Uncertainty) -> [f64; 2] {
        let deviation = value - self.nominal;
        [-self.tolerance, self.tolerance].map(|side| (deviation + side) / uncertainty.standard())
    }
}

/// The model values of one point, judged against the measurement.
#[derive(Clone, Debug, PartialEq)]
pub struct Conformity {
    /// For each criterion.
    pub criteria: Vec<Assessed>,
    /// For all of them together.
    pub all: Assessed,
}

/// How far within the tolerance, and how probably so.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Assessed {
    /// See [`Measured::margin`]; the least one of all criteria.
    pub margin: f64,
    /// The conformance probability: that the model is within the tolerance of the true value. `None`
    /// where an uncertainty is not known.
    pub probability: Option<f64>,
}

/// Conformance probabilities of one point that come from elsewhere, such as from draws of a measured curve.
#[derive(Clone, Debug, PartialEq)]
pub struct Told {
    /// The criteria's numbers, each with its probability.
    pub each: Vec<(usize, f64)>,
    /// That of all of them together.
    pub all: f64,
}

/// All criteria with the joint distribution of the errors of their measured values.
#[derive(Clone, Debug, Default)]
pub struct Measurement {
    criteria: Vec<Measured>,
    /// The numbers of the criteria whose conformance probabilities are told point by point.
    told: Vec<usize>,
    correlations: Vec<(usize, usize, f64)>,
    errors: JointNormal,
}

impl Measurement {
    /// Criteria whose errors have these correlations, by the criteria's numbers.
    ///
    /// # Errors
    /// When the correlations contradict each other.
    pub fn new(criteria: Vec<Measured>, pairs: &[(usize, usize, f64)]) -> Result<Self, String> {
        let errors = JointNormal::new(criteria.len(), pairs)?;
        let correlations = pairs.to_vec();
        Ok(Self {
            criteria,
            told: Vec::new(),
            correlations,
            errors,
        })
    }

    /// The same, where the conformance probabilities of these criteria are told point by point: see
    /// [`assess_with`](Self::assess_with).
    pub fn with_told(self, told: Vec<usize>) -> Self {
        Self { told, ..self }
    }

    /// Whether the conformance probability of a criterion is known, by its uncertainty or as it is told.
    pub fn knows(&self, criterion: usize) -> bool {
        let by_uncertainty = self
            .criteria
            .get(criterion)
            .is_some_and(|c| c.uncertainty.is_some());
        by_uncertainty || self.told.contains(&criterion)
    }

    /// The same, with joint probabilities of many correlated errors to about 1e-3 only (see [`JointNormal::roughly`]).
    pub fn roughly(self) -> Self {
        Self {
            errors: self.errors.roughly(),
            ..self
        }
    }

    /// The criteria.
    pub fn criteria(&self) -> &[Measured] {
        &self.criteria
    }

    /// The criteria whose errors are correlated, by their numbers, with the coefficients.
    pub fn correlations(&self) -> &[(usize, usize, f64)] {
        &self.correlations
    }

    /// The least [margin](Measured::margin) of a point's model values; minus infinity where one is not a
    /// number.
    pub fn margin(&self, values: &[f64]) -> f64 {
        let pairs = self.criteria.iter().zip(values);
        let margins = pairs.map(|(criterion, &value)| criterion.margin(value));
        margins.fold(f64::INFINITY, f64::min)
    }

    /// Whether every criterion has an uncertainty, so that joint probabilities are known.
    pub fn complete(&self) -> bool {
        let mut criteria = self.criteria.iter();
        !self.criteria.is_empty() && criteria.all(|criterion| criterion.uncertainty.is_some())
    }

    /// Assesses the model values of a point, of which there is one a criterion.
    pub fn assess(&self, values: &[f64]) -> Conformity {
        self.assess_with(values, None)
    }

    /// The same with the conformance probabilities that are told of this point. Their errors are independent of those of the
    /// other criteria's measured values.
    pub fn assess_with(&self, values: &[f64], told: Option<&Told>) -> Conformity {
        /// No normal error is so many standard deviations.
        const ANY: [f64; 2] = [-40.0, 40.0];
        let pairs = || self.criteria.iter().zip(values);
        let told_of = |number: usize| {
            let mut each = told.iter().flat_map(|told| &told.each);
            let entry = each.find(|(criterion, _)| *criterion == number);
            entry.map(|(_, probability)| *probability)
        };
        let limits: Vec<Option<[f64; 2]>> = pairs()
            .enumerate()
            .map(|(number, (c, &value))| {
                let limits = c.uncertainty.map(|u| c.limits(value, u));
                limits.or_else(|| told_of(number).map(|_| ANY))
            })
            .collect();
        let known: Option<Vec<[f64; 2]>> = limits.iter().copied().collect();
        let parts = known.map(|limits| {
            let [lower, upper] = sides(&limits);
            self.errors.parts(&lower, &upper)
        });
        let probability = |number: usize| {
            let [lower, upper] = limits[number]?;
            let single = parts.as_ref().zip(self.errors.single(number));
            Some(match single {
                Some((parts, part)) => parts[part],
                None => super::normal::between(lower, upper),
            })
        };
        let criteria = pairs().enumerate().map(|(number, (c, &value))| Assessed {
            margin: c.margin(value),
            probability: told_of(number).or_else(|| probability(number)),
        });
        let criteria = criteria.collect();
        let joint =
            parts.map(|parts| parts.iter().product::<f64>() * told.map_or(1.0, |told| told.all));
        let all = Assessed {
            margin: self.margin(values),
            probability: joint,
        };
        Conformity { criteria, all }
    }

    /// A point as all criteria together would judge it if one uncertainty were this part of what it is: that of the first
    /// criterion, of the second one, and so on, each with the others as they are.
    pub fn with_other_uncertainty(&self, values: &[f64], part: f64) -> Vec<Assessed> {
        let changed = |c: &Measured| Measured {
            uncertainty: c.uncertainty.map(|uncertainty| Uncertainty {
                expanded: part * uncertainty.expanded,
                ..uncertainty
            }),
            ..*c
        };
        let criteria = || self.criteria.iter().zip(values);
        let margins: Vec<f64> = criteria().map(|(c, &value)| c.margin(value)).collect();
        let other_margins = of_the_others(&margins, f64::INFINITY, f64::min);
        let limits = criteria().map(|(c, &value)| Some(c.limits(value, c.uncertainty?)));
        let limits: Option<Vec<[f64; 2]>> = limits.collect();
        let mut joint = limits.map(|limits| {
            let [lower, upper] = sides(&limits);
            let parts = self.errors.parts(&lower, &upper);
            (of_the_others(&parts, 1.0, |a, b| a * b), lower, upper)
        });
        let mut assess = |k: usize| {
            let (changed, value) = (changed(&self.criteria[k]), values[k]);
            let probability = joint.as_mut().zip(changed.uncertainty);
            Assessed {
                margin: changed.margin(value).min(other_margins[k]),
                probability: probability.map(|((others, lower, upper), uncertainty)| {
                    let before = [lower[k], upper[k]];
                    [lower[k], upper[k]] = changed.limits(value, uncertainty);
                    let (part, probability) = self.errors.part_of(k, lower, upper);
                    [lower[k], upper[k]] = before;
                    others[part] * probability
                }),
            }
        };
        (0..self.criteria.len()).map(&mut assess).collect()
    }
}

/// Lower and upper limits.
fn sides(limits: &[[f64; 2]]) -> [Vec<f64>; 2] {
    [0, 1].map(|side| limits.iter().map(|limit| limit[side]).collect())
}

/// For each number the others, joined by an operation with this neutral number.
fn of_the_others(numbers: &[f64], neutral: f64, join: impl Fn(f64, f64) -> f64) -> Vec<f64> {
    let mut joined = vec![neutral; numbers.len()];
    let (mut before, mut after) = (neutral, neutral);
    for (k, &number) in numbers.iter().enumerate() {
        joined[k] = before;
        before = join(before, number);
    }
    for (k, &number) in numbers.iter().enumerate().rev() {
        joined[k] = join(joined[k], after);
        after = join(number, after);
    }
    joined
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::normal::{between, between_both};

    fn measured(nominal: f64, tolerance: f64, expanded: f64) -> Measured {
        Measured {
            nominal,
            tolerance,
            uncertainty: Some(Uncertainty {
                expanded,
                coverage: 2.0,
            }),
        }
    }

    /// JCGM 106:2012, 7.4: p_c = Phi((T_U - y) / u) - Phi((T_L - y) / u).
    #[test]
    fn one_criterion_has_the_formula_of_jcgm_106() {
        let measurement = Measurement::new(vec![measured(82.0, 0.615, 0.5)], &[]).unwrap();
        for value in [81.0, 81.486, 82.0, 82.615, 83.0] {
            let conformity = measurement.assess(&[value]);
            let expected = between((81.385 - value) / 0.25, (82.615 - value) / 0.25);
            let probability = conformity.criteria[0].probability.unwrap();
            assert!((probability - expected).abs() < 1e-12);
            assert_eq!(conformity.all.probability, Some(probability));
            let margin = (0.615 - (value - 82.0).abs()) / 0.5;
            assert!((conformity.all.margin - margin).abs() < 1e-12);
        }
        // Twice the standard uncertainty, 0.15, fits into the tolerance four times.
        let capability = measured(82.0, 1.2, 0.3).capability().unwrap();
        assert!((capability - 4.0).abs() < 1e-12);
    }

    #[test]
    fn correlated_errors_are_joint() {
        let criteria = vec![measured(10.0, 1.0, 1.0), measured(-3.0, 2.0, 4.0)];
        let measurement = Measurement::new(criteria, &[(0, 1, -0.6)]).unwrap();
        let probability = measurement.assess(&[10.4, -2.0]).all.probability.unwrap();
        // A model above the measured value conforms with errors that lie above it, too.
        let expected = between_both([-1.2, -0.5], [2.8, 1.5], -0.6);
        assert!((probability - expected).abs() < 1e-12);
    }

    #[test]
    fn half_an_uncertainty_is_that_of_a_measurement_with_it() {
        let criteria = vec![
            measured(10.0, 1.0, 1.0),
            measured(-3.0, 2.0, 4.0),
            measured(0.0, 1.0, 2.0),
            measured(1.0, 1.0, 0.5),
        ];
        // The second and the last error are twins.
        let pairs = [(0, 1, -0.6), (1, 3, 1.0), (0, 3, -0.6)];
        let measurement = Measurement::new(criteria.clone(), &pairs).unwrap();
        let values = [10.4, -2.0, 0.3, 1.1];
        let changed = measurement.with_other_uncertainty(&values, 0.5);
        for (k, assessed) in changed.iter().enumerate() {
            let mut criteria = criteria.clone();
            let uncertainty = criteria[k].uncertainty.as_mut().unwrap();
            uncertainty.expanded *= 0.5;
            let expected = Measurement::new(criteria, &pairs)
                .unwrap()
                .assess(&values)
                .all;
            assert_eq!(assessed.margin, expected.margin, "{k}");
            let [probability, expected] = [*assessed, expected].map(|one| one.probability.unwrap());
            assert!(
                (probability - expected).abs() < 1e-15,
                "{k}: {probability} {expected}"
            );
        }
    }

    #[test]
    fn nothing_is_assumed_where_no_uncertainty_is_stated() {
        let unknown = Measured {
            uncertainty: None,
            ..measured(750.0, 52.5, 1.0)
        };
        let measurement = Measurement::new(vec![measured(82.0, 1.0, 0.5), unknown], &[]).unwrap();
        assert!(!measurement.complete());
        let known = vec![measured(82.0, 1.0, 0.5)];
        assert!(Measurement::new(known, &[]).unwrap().complete());
        assert!(!Measurement::default().complete());
        let inside = measurement.assess(&[82.5, 802.5]);
        assert_eq!(
            inside.all,
            Assessed {
                margin: 1.0,
                probability: None
            }
        );
        assert!(inside.criteria[0].probability.is_some());
        assert_eq!(inside.criteria[1].margin, f64::INFINITY);
        assert_eq!(
            measurement.assess(&[82.5, 803.0]).all.margin,
            f64::NEG_INFINITY
        );
        assert_eq!(unknown.capability(), None);
    }

    #[test]
    fn values_that_are_not_numbers_are_never_within() {
        let sure = measured(82.0, 1.0, 0.5);
        let unknown = Measured {
            uncertainty: None,
            ..sure
        };
        let measurement = Measurement::new(vec![sure, unknown], &[]).unwrap();
        for values in [[f64::NAN, 82.0], [82.0, f64::NAN], [f64::INFINITY, 82.0]] {
            assert_eq!(measurement.margin(&values), f64::NEG_INFINITY, "{values:?}");
        }
        assert_eq!(measurement.margin(&[81.5, 82.0]), 1.0);
    }
}

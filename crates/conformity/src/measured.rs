//! Measured values with their uncertainties, and the probability that one point conforms.

use serde::{Deserialize, Serialize};

use super::{joint::JointNormal, uncertainty::Law};

/// The values that a model may have: the ends of an interval as seen from one of its values, either of which may be
/// infinite. So written, a limit that a study states decides without rounding.
///
/// In files they are `nominal` with `tolerance`, or with `minus` and `plus`, or `lower` and `upper`, of which one is null.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(into = "Written", from = "Written")]
pub struct Limits {
    /// The value that the two others count from: the measured one, or a limit that stands alone.
    pub about: f64,
    /// How far down the interval reaches; infinite where there is no lower limit.
    pub minus: f64,
    /// How far up it reaches; infinite where there is no upper limit.
    pub plus: f64,
}

impl Limits {
    /// A tolerance that is the same to both sides.
    pub fn within(nominal: f64, tolerance: f64) -> Self {
        let [minus, plus] = [tolerance; 2];
        Self { about: nominal, minus, plus }
    }

    /// An upper limit alone.
    pub fn at_most(limit: f64) -> Self {
        Self { about: limit, minus: f64::INFINITY, plus: 0.0 }
    }

    /// A lower limit alone.
    pub fn at_least(limit: f64) -> Self {
        Self { about: limit, minus: 0.0, plus: f64::INFINITY }
    }

    /// The lower and the upper limit.
    pub fn ends(&self) -> [f64; 2] {
        [self.about - self.minus, self.about + self.plus]
    }

    /// Whether one of the limits is missing.
    pub fn is_one_sided(&self) -> bool {
        self.width().is_infinite()
    }

    /// The width of the interval.
    pub fn width(&self) -> f64 {
        self.minus + self.plus
    }

    /// Whether a value lies between the limits; the limits themselves do.
    pub fn accepts(&self, value: f64) -> bool {
        self.rest(value) >= 0.0
    }

    /// How far a value is from the limit that is nearest to it; negative outside.
    pub fn rest(&self, value: f64) -> f64 {
        let deviation = value - self.about;
        (self.plus - deviation).min(self.minus + deviation)
    }

    /// The interval drawn in by `by` at each limit; none where nothing is left of it.
    pub fn drawn_in(&self, by: f64) -> Option<[f64; 2]> {
        let half = 0.5 * self.width() - by;
        if half.is_infinite() {
            let [lower, upper] = self.ends();
            return Some([lower + by, upper - by]);
        }
        let middle = self.about + 0.5 * (self.plus - self.minus);
        (half >= 0.0).then_some([middle - half, middle + half])
    }
}

#[derive(Default, Serialize, Deserialize)]
#[serde(default)]
struct Written {
    #[serde(skip_serializing_if = "Option::is_none")]
    nominal: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    tolerance: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    minus: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    plus: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    lower: Option<Option<f64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    upper: Option<Option<f64>>,
}

impl From<Limits> for Written {
    fn from(limits: Limits) -> Self {
        let Limits { about, minus, plus } = limits;
        let has_two = !limits.is_one_sided();
        let is_even = has_two && minus == plus;
        let [minus, plus] = [minus, plus].map(|side| has_two.then_some(side));
        let [lower, upper] =
            limits.ends().map(|end| Some(end).filter(|end| end.is_finite())).map(|end| (!is_even).then_some(end));
        Self {
            nominal: has_two.then_some(about),
            tolerance: plus.filter(|_| is_even),
            minus: minus.filter(|_| !is_even),
            plus: plus.filter(|_| !is_even),
            lower,
            upper,
        }
    }
}

impl From<Written> for Limits {
    fn from(written: Written) -> Self {
        let [minus, plus] = [written.minus, written.plus].map(|side| side.or(written.tolerance).unwrap_or_default());
        match (written.nominal, written.lower.flatten(), written.upper.flatten()) {
            (Some(about), ..) => Self { about, minus, plus },
            (None, _, Some(limit)) => Self::at_most(limit),
            (None, Some(limit), None) => Self::at_least(limit),
            (None, None, None) => Self::default(),
        }
    }
}

/// The limits of a quantity, and what is known of its measured value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured {
    /// Between these the model is near enough to the true value.
    pub limits: Limits,
    /// The measured value D, where there is one: a limit may stand alone.
    pub value: Option<f64>,
    /// The distribution of the measured value's error, where that is known.
    pub error: Option<Law>,
}

impl Measured {
    /// A measured value with a tolerance to both sides.
    pub fn within(nominal: f64, tolerance: f64, error: Option<Law>) -> Self {
        Self { limits: Limits::within(nominal, tolerance), value: Some(nominal), error }
    }

    /// How far a model value is within the limits, in expanded uncertainties: a guard band of
    /// that many would just let it pass. Negative outside of them and for a value that is not a
    /// number; infinite where no uncertainty is known, since then there is nothing to guard against.
    pub fn margin(&self, value: f64) -> f64 {
        self.in_uncertainties(self.limits.rest(value))
    }

    /// The largest [margin](Self::margin) that any value has.
    pub fn largest_margin(&self) -> f64 {
        self.in_uncertainties(0.5 * self.limits.width())
    }

    fn in_uncertainties(&self, rest: f64) -> f64 {
        match self.error {
            Some(error) if !rest.is_nan() => rest / error.expanded,
            None if rest >= 0.0 => f64::INFINITY,
            _ => f64::NEG_INFINITY,
        }
    }

    /// The measurement capability index C_m (JCGM 106:2012, 7.6.3), where there are two limits.
    pub fn capability(&self) -> Option<f64> {
        let width = Some(self.limits.width()).filter(|width| width.is_finite())?;
        Some(width / (4.0 * self.error?.standard()))
    }

    /// The largest probability not to conform of values with at least this [margin](Self::margin), which is 0 or more:
    /// that of one as near to a limit as may be. `None` where no uncertainty is known.
    pub fn most_not_conforming(&self, margin: f64) -> Option<f64> {
        let error = self.error?;
        let by = margin * error.expanded;
        let ends = self.limits.drawn_in(by.min(0.5 * self.limits.width()))?;
        // Errors are symmetric, so that the other end is no worse.
        let value = ends.into_iter().rev().find(|end| end.is_finite())?;
        let [lower, upper] = self.scores(value, error);
        Some(1.0 - super::normal::between(lower, upper))
    }

    /// The errors of the measured value, as [scores](Law::score), with which a model value conforms.
    fn scores(&self, value: f64, error: Law) -> [f64; 2] {
        let deviation = value - self.limits.about;
        [-self.limits.plus, self.limits.minus].map(|side| error.score(deviation + side))
    }
}

/// The model values of one point, judged against the measurement.
#[derive(Clone, Debug)]
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
pub struct DrawnConformity {
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
        Ok(Self { criteria, told: Vec::new(), correlations, errors })
    }

    /// The same, where the conformance probabilities of these criteria are told point by point: see
    /// [`assess_with`](Self::assess_with).
    pub fn with_told(self, told: Vec<usize>) -> Self {
        Self { told, ..self }
    }

    /// Whether the conformance probability of a criterion is known, by its uncertainty or as it is told.
    pub fn knows(&self, criterion: usize) -> bool {
        let by_uncertainty = self.criteria.get(criterion).is_some_and(|c| c.error.is_some());
        by_uncertainty || self.told.contains(&criterion)
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
        self.criteria
            .iter()
            .zip(values)
            .map(|(criterion, &value)| criterion.margin(value))
            .fold(f64::INFINITY, f64::min)
    }

    /// Whether every criterion has an uncertainty, so that joint probabilities are known.
    pub fn complete(&self) -> bool {
        let mut criteria = self.criteria.iter();
        !self.criteria.is_empty() && criteria.all(|criterion| criterion.error.is_some())
    }

    /// Assesses the model values of a point, of which there is one a criterion.
    pub fn assess(&self, values: &[f64]) -> Conformity {
        self.assess_with(values, None)
    }

    /// The same with the conformance probabilities that are told of this point. Their errors are independent of those of the
    /// other criteria's measured values.
    pub fn assess_with(&self, values: &[f64], told: Option<&DrawnConformity>) -> Conformity {
        /// No normal error is so many standard deviations.
        const ANY: [f64; 2] = [-40.0, 40.0];
        let pairs = || self.criteria.iter().zip(values);
        let told_of = |number: usize| {
            let mut each = told.iter().flat_map(|told| &told.each);
            each.find(|(criterion, _)| *criterion == number).map(|(_, probability)| *probability)
        };
        let limits: Vec<Option<[f64; 2]>> = pairs()
            .enumerate()
            .map(|(number, (c, &value))| {
                c.error.map(|error| c.scores(value, error)).or_else(|| told_of(number).map(|_| ANY))
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
        let criteria = pairs()
            .enumerate()
            .map(|(number, (c, &value))| Assessed {
                margin: c.margin(value),
                probability: told_of(number).or_else(|| probability(number)),
            })
            .collect();
        let joint = parts.map(|parts| parts.iter().product::<f64>() * told.map_or(1.0, |told| told.all));
        let all = Assessed { margin: self.margin(values), probability: joint };
        Conformity { criteria, all }
    }
}

/// Lower and upper limits.
fn sides(limits: &[[f64; 2]]) -> [Vec<f64>; 2] {
    [0, 1].map(|side| limits.iter().map(|limit| limit[side]).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::normal::{between, between_both};
    use crate::uncertainty::Uncertainty;

    #[test]
    fn limits_come_back_from_files_as_they_were() {
        let uneven = Limits { about: 82.1, minus: 0.1, plus: 0.3 };
        for (limits, text) in [
            (Limits::within(82.0, 0.6), r#"{"nominal":82.0,"tolerance":0.6}"#),
            (Limits::at_most(85.1), r#"{"lower":null,"upper":85.1}"#),
            (Limits::at_least(-2.0), r#"{"lower":-2.0,"upper":null}"#),
            (uneven, r#"{"nominal":82.1,"minus":0.1,"plus":0.3,"lower":82.0,"upper":82.39999999999999}"#),
        ] {
            assert_eq!(serde_json::to_string(&limits).unwrap(), text);
            assert_eq!(serde_json::from_str::<Limits>(text).unwrap(), limits);
        }
    }

    #[test]
    fn a_side_may_be_open_or_narrower() {
        let uneven = Limits { about: 82.0, minus: 1.0, plus: 2.0 };
        let accepts = |limits: Limits| [80.9, 81.0, 84.0, 84.1].map(|v| limits.accepts(v));
        assert_eq!(accepts(uneven), [false, true, true, false]);
        assert_eq!(accepts(Limits::at_most(84.0)), [true, true, true, false]);
        assert_eq!(accepts(Limits::at_least(81.0)), [false, true, true, true]);
        assert!(!Limits::at_most(84.0).accepts(f64::NAN));
        assert_eq!(uneven.drawn_in(0.5), Some([81.5, 83.5]));
        assert_eq!(uneven.drawn_in(1.6), None);
        assert_eq!(Limits::at_most(84.0).drawn_in(9.0), Some([f64::NEG_INFINITY, 75.0]));
        // The limit itself conforms with one half, values that keep a guard band away with less risk.
        let error = Some(Uncertainty::normal(0.5, 2.0).law(84.0));
        let measured = Measured { limits: Limits::at_most(84.0), value: None, error };
        assert_eq!(measured.most_not_conforming(0.0), Some(0.5));
        let most = measured.most_not_conforming(1.0).unwrap();
        assert!((most - 0.022_750_132).abs() < 1e-9, "{most}");
        assert_eq!((measured.capability(), measured.largest_margin()), (None, f64::INFINITY));
    }

    fn measured(nominal: f64, tolerance: f64, expanded: f64) -> Measured {
        let error = Uncertainty::normal(expanded, 2.0).law(nominal);
        Measured::within(nominal, tolerance, Some(error))
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
    fn nothing_is_assumed_where_no_uncertainty_is_stated() {
        let unknown = Measured { error: None, ..measured(750.0, 52.5, 1.0) };
        let measurement = Measurement::new(vec![measured(82.0, 1.0, 0.5), unknown], &[]).unwrap();
        assert!(!measurement.complete());
        let known = vec![measured(82.0, 1.0, 0.5)];
        assert!(Measurement::new(known, &[]).unwrap().complete());
        assert!(!Measurement::default().complete());
        let inside = measurement.assess(&[82.5, 802.5]);
        assert_eq!(inside.all, Assessed { margin: 1.0, probability: None });
        assert!(inside.criteria[0].probability.is_some());
        assert_eq!(inside.criteria[1].margin, f64::INFINITY);
        assert_eq!(measurement.assess(&[82.5, 803.0]).all.margin, f64::NEG_INFINITY);
        assert_eq!(unknown.capability(), None);
    }

    #[test]
    fn values_that_are_not_numbers_are_never_within() {
        let sure = measured(82.0, 1.0, 0.5);
        let unknown = Measured { error: None, ..sure };
        let measurement = Measurement::new(vec![sure, unknown], &[]).unwrap();
        for values in [[f64::NAN, 82.0], [82.0, f64::NAN], [f64::INFINITY, 82.0]] {
            assert_eq!(measurement.margin(&values), f64::NEG_INFINITY, "{values:?}");
        }
        assert_eq!(measurement.margin(&[81.5, 82.0]), 1.0);
    }
}

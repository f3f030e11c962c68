//! The problem: unknown parameters, and the measurements that determine them.

use std::ops::Range;

use conformity::uncertainty::Law;
use nalgebra::DVector;
use sampling::random::mix;
use serde::{Deserialize, Serialize};

/// How a parameter is measured out between its bounds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Spacing {
    /// Equal differences count equally.
    #[default]
    Linear,
    /// Equal ratios count equally: for quantities known only by their order of magnitude.
    Log,
}

/// Prior of a parameter: knowledge from before the measurement, beyond its bounds.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Prior {
    /// The most probable value; on a logarithmic scale the median.
    pub centre: f64,
    /// The standard deviation; on a logarithmic scale the factor that stands for one.
    pub spread: f64,
}

/// A parameter to be found, the same in all cases.
#[derive(Clone, Debug, Serialize)]
pub struct Free {
    /// Its name.
    pub name: String,
    /// The unit of its numbers.
    pub unit: Option<String>,
    /// How it is measured out.
    pub scale: Spacing,
    /// The smallest value.
    pub min: f64,
    /// The largest value.
    pub max: f64,
    /// Its prior; without one, every value within the bounds is equally probable.
    pub prior: Option<Prior>,
}

impl Free {
    /// One on a linear scale, of which nothing is known but its bounds.
    pub fn linear(name: String, unit: Option<String>, [min, max]: [f64; 2]) -> Self {
        Self { name, unit, scale: Spacing::Linear, min, max, prior: None }
    }

    /// The value at a place between the bounds: 0 is the lower one, 1 the upper one.
    pub fn value(&self, place: f64) -> f64 {
        // The bounds themselves are hit exactly: rounding must not lead out of them.
        if place <= 0.0 {
            return self.min;
        }
        if place >= 1.0 {
            return self.max;
        }
        match self.scale {
            Spacing::Linear => self.min + place * (self.max - self.min),
            Spacing::Log => self.min * (place * self.span()).exp(),
        }
    }

    /// The place of a value between the bounds.
    pub fn place(&self, value: f64) -> f64 {
        match self.scale {
            Spacing::Linear => (value - self.min) / (self.max - self.min),
            Spacing::Log => (value / self.min).ln() / self.span(),
        }
    }

    /// The distance of the bounds: a difference, or the logarithm of a ratio.
    fn span(&self) -> f64 {
        match self.scale {
            Spacing::Linear => self.max - self.min,
            Spacing::Log => (self.max / self.min).ln(),
        }
    }

    /// Centre and standard deviation of the prior as places.
    pub fn prior_place(&self) -> Option<(f64, f64)> {
        let prior = self.prior?;
        let spread = match self.scale {
            Spacing::Linear => prior.spread,
            Spacing::Log => prior.spread.ln(),
        };
        Some((self.place(prior.centre), spread / self.span()))
    }

    /// A standard deviation of the place as one of the value: a difference, or a factor above 1.
    pub fn spread(&self, deviation: f64) -> f64 {
        match self.scale {
            Spacing::Linear => deviation * self.span(),
            Spacing::Log => (deviation * self.span()).exp(),
        }
    }

    /// Whether the numbers make sense.
    ///
    /// # Errors
    /// Says which do not.
    pub fn check(&self) -> Result<(), String> {
        let Self { min, max, .. } = *self;
        if !(min.is_finite() && max.is_finite() && min < max) {
            return Err(format!("the bounds {min} and {max} must be two numbers in rising order"));
        }
        if self.scale == Spacing::Log && min <= 0.0 {
            return Err(format!("a logarithmic scale needs a lower bound above 0, not {min}"));
        }
        let Some(Prior { centre, spread }) = self.prior else { return Ok(()) };
        let above = |limit: f64, number: f64| number.is_finite() && number > limit;
        match self.scale {
            Spacing::Linear if !above(0.0, spread) => Err(format!("the deviation {spread} must be positive")),
            Spacing::Log if !above(1.0, spread) => Err(format!("the factor {spread} must be more than 1")),
            Spacing::Log if !above(0.0, centre) => {
                Err(format!("the median {centre} must be positive on a logarithmic scale"))
            }
            _ => Ok(()),
        }
    }
}

/// Free parameters that are one quantity of several specimens: normal, with a mean and a standard deviation that are unknown,
/// too, on the parameters' scale and between their bounds. The search takes each by itself, as the density is highest where
/// the spread is 0; the posterior's sample has mean and spread.
#[derive(Clone, Debug, Serialize)]
pub struct Population {
    /// The quantity.
    pub name: String,
    /// The free parameters, which all have the same scale, bounds and prior.
    pub members: Vec<usize>,
}

impl Population {
    /// The standard deviation of a single value's place before the measurement.
    pub fn scale(&self, problem: &Problem) -> f64 {
        let uniform = 12.0_f64.sqrt().recip();
        problem.free[self.members[0]].prior_place().map_or(uniform, |(_, deviation)| deviation.min(uniform))
    }
}

/// The interval in which a case's latent parameter lies; within it everything is equally probable.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Interval {
    /// The lower end.
    pub min: f64,
    /// The upper end.
    pub max: f64,
}

impl Interval {
    /// The value at a place between the ends: 0 is the lower one, 1 the upper one.
    pub fn value(&self, place: f64) -> f64 {
        (self.min + place * (self.max - self.min)).clamp(self.min, self.max)
    }
}

/// A measured value with its uncertainty.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct UncertainValue {
    /// The value.
    pub value: f64,
    /// The standard uncertainty of its independent error, in the same unit: one standard deviation, without what it
    /// shares with other values.
    pub accuracy: f64,
}

/// A measured value whose own error is not normal. The search takes a normal one with the value's accuracy; the posterior's
/// sample takes the error as it is, where the value shares none with others.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct NotNormal {
    /// The value's case.
    pub case: usize,
    /// Its quantity.
    pub quantity: usize,
    /// How the error is distributed.
    pub law: Law,
}

/// A measured value whose own error is not all noise.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Mixed {
    /// The value's case.
    pub case: usize,
    /// Its quantity.
    pub quantity: usize,
    /// The parts of the error's square that are the zero's and the gain's.
    pub parts: [f64; 2],
}

/// What is known of the noise of quantities, the rows of a curve, where it is an estimate.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Estimate {
    /// The quantities.
    pub quantities: Range<usize>,
    /// The degrees of freedom of the noise's square; infinite where it is known.
    pub freedom: f64,
    /// The correlation of each row's noise with the next one's.
    pub correlation: f64,
    /// How many rows count as one with an independent noise as large as the accuracies.
    pub rows: f64,
}

/// A quantity's name and unit.
#[derive(Clone, Debug, Serialize)]
pub struct Named {
    /// Its name.
    pub name: String,
    /// The unit of its numbers.
    pub unit: Option<String>,
}

/// A measured quantity.
pub type Quantity = Named;

/// A parameter that no case knows better than an interval.
pub type Latent = Named;

/// A measured case.
#[derive(Clone, Debug, Serialize)]
pub struct Case {
    /// Name, for people.
    pub label: String,
    /// Where its latent parameters lie, in the order of [`Problem::latents`].
    pub latents: Vec<Interval>,
    /// Measured values, in the order of [`Problem::quantities`].
    pub measured: Vec<UncertainValue>,
}

/// An error that several measured values share, such as the zero error of a sensor: a number with mean 0 and standard deviation
/// 1 before the measurement, and independent of all others.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Source {
    /// The values that it touches.
    pub effects: Vec<Effect>,
    /// Whether all errors within limits are equally probable, instead of a normal distribution. The search takes a normal
    /// one, the posterior's sample the limits.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub rectangular: bool,
}

/// The effect of a shared error on a measured value.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Effect {
    /// The value's case.
    pub case: usize,
    /// Its quantity.
    pub quantity: usize,
    /// By how much one standard deviation of the source changes the measured value.
    pub change: f64,
    /// The part of the value that this is, where it is one: then the search takes that part of what the model predicts. Of the
    /// measured value it would be larger where noise has made that larger, and the fit too small (Peelle's puzzle;
    /// D'Agostini 1994, Nucl. Instrum. Methods A 346, 306-311).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub part: Option<f64>,
}

/// What kind of error the values of a channel share.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum SharedKind {
    /// The same in each value, in the channel's unit.
    Offset,
    /// The same part of each value.
    Gain,
    /// The same part of the stated uncertainty of each value.
    Scaled,
}

impl SharedKind {
    /// What of a sensor it is.
    pub(crate) fn of_sensor(self) -> &'static str {
        match self {
            Self::Offset => "zero",
            Self::Gain => "gain",
            Self::Scaled => "zero or gain",
        }
    }

    /// Its name for people.
    pub fn words(self) -> &'static str {
        match self {
            Self::Offset => "a zero error",
            Self::Gain => "a gain error",
            Self::Scaled => "an error that all its values share",
        }
    }
}

/// A shared error of a measured channel, of which people want to know: a sum of sources.
#[derive(Clone, Debug, Serialize)]
pub struct Channel {
    /// The channel.
    pub name: String,
    /// What its values share.
    pub kind: SharedKind,
    /// The unit of an offset.
    pub unit: Option<String>,
    /// How large it may be, as stated: the expanded uncertainty, or the limit of error.
    pub limit: f64,
    /// The sources, each with what one standard deviation of it adds.
    pub sources: Vec<(usize, f64)>,
}

impl Channel {
    /// What one standard deviation of each of so many sources adds.
    pub(crate) fn weights(&self, sources: usize) -> DVector<f64> {
        let mut weights = DVector::zeros(sources);
        for &(source, weight) in &self.sources {
            weights[source] += weight;
        }
        weights
    }

    /// The standard uncertainty before the measurement.
    pub fn standard(&self) -> f64 {
        self.sources.iter().map(|(_, weight)| weight * weight).sum::<f64>().sqrt()
    }
}

/// The problem: unknown parameters, and the measurements that determine them.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Problem {
    /// The parameters that all cases share.
    pub free: Vec<Free>,
    /// Those of them that vary from specimen to specimen.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub populations: Vec<Population>,
    /// The parameters that each case has to itself.
    pub latents: Vec<Latent>,
    /// The measured quantities.
    pub quantities: Vec<Quantity>,
    /// The measured cases.
    pub cases: Vec<Case>,
    /// Errors that measured values share, beside the independent ones that their accuracies state.
    pub sources: Vec<Source>,
    /// What is told of them.
    pub channels: Vec<Channel>,
    /// The values whose own errors are not normal.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub not_normal: Vec<NotNormal>,
    /// The values whose own errors are not all noise.
    #[serde(skip)]
    pub mixed: Vec<Mixed>,
    /// The quantities whose noise is an estimate.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub estimates: Vec<Estimate>,
}

impl Problem {
    /// How many unknowns there are.
    pub fn unknowns(&self) -> usize {
        self.free.len() + self.cases.len() * self.latents.len()
    }

    /// How many measured values there are.
    pub fn values(&self) -> usize {
        self.cases.len() * self.quantities.len()
    }

    /// A digest of the measured values and their units: the same for the same data, whatever the model.
    pub fn digest(&self) -> String {
        let of = |hash: u64, number: u64| mix(hash.wrapping_mul(3) ^ number);
        let letters =
            self.quantities.iter().filter_map(|quantity| quantity.unit.as_deref()).flat_map(str::bytes).map(u64::from);
        let values = self.cases.iter().flat_map(|case| &case.measured).map(|measured| measured.value.to_bits());
        format!("{:016x}", letters.chain(values).fold(self.values() as u64, of))
    }

    /// Where a case's latent parameters stand among the unknowns.
    pub fn latents_of(&self, case: usize) -> Range<usize> {
        let start = self.free.len() + case * self.latents.len();
        start..start + self.latents.len()
    }

    /// The free parameters' values at given places.
    pub fn free_values(&self, places: &[f64]) -> Vec<f64> {
        self.free.iter().zip(places).map(|(free, &place)| free.value(place)).collect()
    }

    /// A case's latent values at given places of all unknowns.
    pub fn latent_values(&self, case: usize, places: &[f64]) -> Vec<f64> {
        let places = &places[self.latents_of(case)];
        self.cases[case].latents.iter().zip(places).map(|(interval, &place)| interval.value(place)).collect()
    }

    /// What shared errors of these sizes, in standard uncertainties, add to the measured values, case by case.
    pub fn shifts(&self, sources: &[f64]) -> Vec<Vec<f64>> {
        let mut shifts: Vec<Vec<f64>> = self.cases.iter().map(|case| vec![0.0; case.measured.len()]).collect();
        for (source, value) in self.sources.iter().zip(sources) {
            for effect in &source.effects {
                shifts[effect.case][effect.quantity] += effect.change * value;
            }
        }
        shifts
    }

    /// The problem whose shared errors in proportion to a value, such as those of a gain, are parts of these predicted values;
    /// without a prediction they are 0. None where no error is in proportion.
    pub(crate) fn with_parts(&self, predicted: Option<&[Vec<f64>]>) -> Option<Self> {
        let mut problem = self.clone();
        let all = problem.sources.iter_mut();
        let parts =
            all.flat_map(|source| &mut source.effects).filter_map(|effect| effect.part.map(|part| (effect, part)));
        let mut any = false;
        for (effect, part) in parts {
            any = true;
            effect.change = predicted.map_or(0.0, |all| part * all[effect.case][effect.quantity]);
        }
        any.then_some(problem)
    }

    /// The problem with further standard uncertainties of the values, by case and quantity.
    pub fn widened(&self, more: impl Fn(usize, usize) -> f64) -> Self {
        let mut problem = self.clone();
        for (case, changed) in problem.cases.iter_mut().enumerate() {
            for (quantity, measured) in changed.measured.iter_mut().enumerate() {
                measured.accuracy = measured.accuracy.hypot(more(case, quantity));
            }
        }
        for value in &mut problem.not_normal {
            value.law.normal = value.law.normal.hypot(more(value.case, value.quantity));
        }
        // What is added is none of the sensor's.
        for value in &mut problem.mixed {
            let [before, now] = [&self.cases, &problem.cases].map(|c| c[value.case].measured[value.quantity].accuracy);
            value.parts = value.parts.map(|part| part * (before / now).powi(2));
        }
        problem
    }
}

/// The values for which an output is to be predicted.
#[derive(Clone, Debug, PartialEq)]
pub struct Query {
    /// The case.
    pub case: usize,
    /// The free parameters' values.
    pub free: Vec<f64>,
    /// The values of the case's latent parameters.
    pub latents: Vec<f64>,
}

/// Predicted measurements in the order of [`Problem::quantities`], or why there are none.
pub type Prediction = Result<Vec<f64>, String>;

/// Why a search cannot go on.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NoPrediction {
    /// There is none here; the search keeps away.
    #[error("{0}")]
    Here(String),
    /// There will be no further ones.
    #[error("the search was stopped")]
    Stopped,
}

/// Predicts what would be measured.
pub trait Simulate {
    /// The predictions of several queries, in their order.
    ///
    /// # Errors
    /// When there will be no further predictions.
    fn simulate(&self, queries: &[Query]) -> Result<Vec<Prediction>, NoPrediction>;
}

impl<F> Simulate for F
where
    F: Fn(usize, &[f64], &[f64]) -> Prediction,
{
    fn simulate(&self, queries: &[Query]) -> Result<Vec<Prediction>, NoPrediction> {
        Ok(queries.iter().map(|query| self(query.case, &query.free, &query.latents)).collect())
    }
}

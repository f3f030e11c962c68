//! The result of an identification: plain data that becomes JSON.

use sampling::statistics::moments::sorted;
use serde::Serialize;

use super::{
    expected::Expected,
    failures::{Edge, Excluded},
    influence::{Farthest, Influence},
    local::{End, Minimum},
    numerical::NumericalError,
    optima::{Approximation, Optimum},
    order::Order,
    posterior::{Direction, UNDETERMINED},
    problem::{Prior, Problem, Spacing},
    sample::{evidence::Evidence, outcome::PosteriorOutcome},
    search::Progress,
    shared::SharedOutcome,
    surrogate::outcome::SurrogateOutcome,
    suspects::Suspect,
};

/// The standard deviations to both sides that hold 95 % of a Gaussian.
const NINETY_FIVE: f64 = 1.959_964;

/// An unknown closer to its bound than this part of their distance counts as at it.
const AT_BOUND: f64 = 1e-6;

/// The result of an identification. Where there are several optima, `free`, `correlations`, `directions`, `cases`,
/// `worst` and the sums are those of the first of them, which has the largest part of the posterior.
#[derive(Serialize)]
pub struct IdentificationOutcome {
    /// What is assumed beyond what is stated, a sentence each.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
    /// Whether several distinct sets of parameters fit, so that none of them is the value.
    pub ambiguous: bool,
    /// All distinct sets, whether they fit or are the best of those that do not.
    pub optima: Vec<OptimumOutcome>,
    /// Why the last search ended.
    pub end: End,
    /// The sum of the weighted squares of all misfits: data and priors.
    pub cost: f64,
    /// The data's part of it.
    pub data_cost: f64,
    /// Measured values and priors, less the unknowns that are not at a bound; rows that share their noise count for fewer.
    pub degrees_of_freedom: usize,
    /// How many more unknowns than these values and priors there are.
    #[serde(skip)]
    pub surplus: usize,
    /// The probability of a larger sum, if model and accuracies were right; none without degrees of freedom.
    pub probability: Option<f64>,
    /// The order of the residuals along each measured curve.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub orders: Vec<Order>,
    /// The measured value that is the farthest off.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub farthest: Option<Farthest>,
    /// What each parameter's variance consists of.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub influence: Vec<Influence>,
    /// The shared errors of the measured channels.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub shared: Vec<SharedOutcome>,
    /// The free parameters.
    pub free: Vec<FreeOutcome>,
    /// The correlations of the free parameters.
    pub correlations: Vec<Vec<f64>>,
    /// Combinations of free parameters, the least determined first.
    pub directions: Vec<DirectionOutcome>,
    /// The cases.
    pub cases: Vec<CaseOutcome>,
    /// The local searches.
    pub search: SearchOutcome,
    /// What would explain the misfit, the likeliest first; none where nobody asked.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub suspects: Option<Vec<Suspect>>,
    /// The region that was avoided because runs failed there.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub excluded: Option<Excluded>,
    /// The model's numerical error at the first optimum, where half the steps were tried.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub numerical_error: Option<NumericalError>,
    /// The surrogates in place of the model, where they were asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub surrogate: Option<SurrogateOutcome>,
    /// A sample of the posterior, where that was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub posterior: Option<PosteriorOutcome>,
    /// The evidence by that sample.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub evidence: Option<Evidence>,
}

/// A set of parameters that could be the right one: a minimum of the sum of squares.
#[derive(Serialize)]
pub struct OptimumOutcome {
    /// Its part of the posterior probability of all optima found, by their Gaussian approximations.
    pub weight: f64,
    /// The sum of squares.
    pub cost: f64,
    /// Why its search ended.
    pub end: End,
    /// How many local searches ended at it.
    pub reached: usize,
    /// Failed runs around it.
    pub edge: Edge,
    /// The free parameters.
    pub free: Vec<FreeOutcome>,
    /// The latent parameters of the cases.
    pub latents: Vec<Vec<LatentOutcome>>,
}

/// A free parameter.
#[derive(Clone, Debug, Serialize)]
pub struct FreeOutcome {
    /// Its name.
    pub name: String,
    /// The unit of its numbers.
    pub unit: Option<String>,
    /// The most probable value.
    pub value: f64,
    /// One standard deviation: a difference, or on a logarithmic scale a factor.
    pub deviation: f64,
    /// How it was measured out.
    pub scale: Spacing,
    /// The interval that holds it with 95 % probability, within the bounds.
    pub interval: [f64; 2],
    /// What the sum of squares at its ends says of the normal approximation.
    pub approximation: Approximation,
    /// The bounds.
    pub bounds: [f64; 2],
    /// What was known of it beyond these.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub prior: Option<Prior>,
    /// The bound at which it ended.
    pub at_bound: Option<&'static str>,
    /// The part of the prior's standard deviation that the data leave.
    pub left: f64,
    /// Whether it is the value of one case.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub of_case: bool,
    /// Whether runs fail on both sides of it: then nothing is known of what it changes, and the interval is the prior's.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub surrounded: bool,
}

impl FreeOutcome {
    /// How many standard deviations of its prior the most probable value is from the prior's centre, upwards; 0 without a prior.
    pub fn strain(&self) -> f64 {
        let off = |Prior { centre, spread }| match self.scale {
            Spacing::Linear => (self.value - centre) / spread,
            Spacing::Log => (self.value / centre).ln() / spread.ln(),
        };
        self.prior.map_or(0.0, off)
    }
}

/// The channels' shared errors by their normal approximations.
fn shared(problem: &Problem, known: &[[f64; 2]]) -> Vec<SharedOutcome> {
    problem
        .channels
        .iter()
        .zip(known)
        .map(|(channel, &[value, deviation])| {
            let interval = [-1.0, 1.0].map(|side| value + side * NINETY_FIVE * deviation);
            SharedOutcome::new(channel, [value, deviation], interval)
        })
        .collect()
}

/// A combination of free parameters.
#[derive(Serialize)]
pub struct DirectionOutcome {
    /// Posterior over prior standard deviation: 1 where the data say nothing.
    pub left: f64,
    /// Whether the data leave more than half of the prior's standard deviation.
    pub undetermined: bool,
    /// The parameters with their weights, in units of their prior standard deviations; the strongest
    /// first, those below a tenth left out.
    pub weights: Vec<(String, f64)>,
}

/// A measured case.
#[derive(Serialize)]
pub struct CaseOutcome {
    /// Name, for people.
    pub label: String,
    /// Its latent parameters.
    pub latents: Vec<LatentOutcome>,
    /// Its measured values.
    pub residuals: Vec<Residual>,
}

/// A latent parameter of a case.
#[derive(Clone, Debug, Serialize)]
pub struct LatentOutcome {
    /// Its name.
    pub name: String,
    /// The most probable value.
    pub value: f64,
    /// One standard deviation.
    pub deviation: f64,
    /// The interval that it was known to lie in.
    pub interval: [f64; 2],
}

/// A measured value and its prediction.
#[derive(Serialize)]
pub struct Residual {
    /// The quantity.
    pub quantity: String,
    /// The measured value.
    pub measured: f64,
    /// The value that the model predicts.
    pub predicted: f64,
    /// The prediction minus the measured value.
    pub difference: f64,
    /// What the shared errors that the data prefer have added to the measured value.
    #[serde(skip_serializing_if = "is_zero")]
    pub shared: f64,
    /// The accuracy of the measurement but for shared errors.
    pub accuracy: f64,
}

impl Residual {
    /// The misfit in standard uncertainties, after the shared errors that the data prefer.
    pub fn missed(&self) -> f64 {
        (self.difference + self.shared) / self.accuracy
    }
}

/// The local searches.
#[derive(Serialize)]
pub struct SearchOutcome {
    /// How many starts were screened.
    pub screened: usize,
    /// How many of them could not be simulated.
    pub failed: usize,
    /// The sums of squares at which the local searches ended, the lowest first.
    pub minima: Vec<f64>,
}

impl SearchOutcome {
    /// How many searches ended as low as the lowest, by sums of squares that the data do not tell apart.
    pub fn lowest(&self) -> usize {
        const SAME: f64 = 1e-3;
        let least = self.minima.first().copied().unwrap_or(0.0);
        self.minima.partition_point(|&cost| cost <= least + 1.0 + SAME * least)
    }
}

impl IdentificationOutcome {
    /// Gathers the results of a search, which has at least one optimum.
    pub fn new(problem: &Problem, optima: &[Optimum], progress: &Progress) -> Self {
        let Optimum { minimum, posterior, .. } = &optima[0];
        let n = problem.free.len();
        let cost = minimum.cost();
        let data_cost = minimum.misfit.data_cost(problem);
        let inside = minimum.places.iter().filter(|&&place| bound(place).is_none()).count();
        // A shared error is an unknown with a prior: one square more, and one unknown more.
        let squares = minimum.misfit.residuals.len() - problem.sources.len();
        let expected = Expected::new(problem, squares, inside);
        let more = beyond_normal(problem, minimum);
        let correlation = |a| (0..n).map(|b| posterior.correlation(a, b)).collect();
        let directions = posterior.directions.iter();
        let outcomes: Vec<_> = optima.iter().map(|each| optimum(problem, each)).collect();
        let OptimumOutcome { free, latents, .. } = &outcomes[0];
        let shifts = problem.shifts(minimum.misfit.sources(problem));
        let cases: Vec<_> = latents
            .iter()
            .enumerate()
            .map(|(index, latents)| case(problem, minimum, (latents, &shifts[index]), index))
            .collect();
        Self {
            notes: Vec::new(),
            ambiguous: optima.len() > 1,
            end: minimum.end,
            cost,
            data_cost,
            degrees_of_freedom: expected.freedom.max(0.0) as usize,
            surplus: inside.saturating_sub(squares),
            probability: expected.chance((cost + more).max(0.0)),
            orders: Vec::new(),
            farthest: None,
            influence: Vec::new(),
            shared: shared(problem, &posterior.shared),
            free: free.clone(),
            correlations: (0..n).map(correlation).collect(),
            directions: directions.map(|d| direction(problem, d)).collect(),
            cases,
            search: searches(progress),
            suspects: None,
            excluded: Excluded::new(problem, &progress.failures, progress.screened.iter().map(Option::is_some)),
            numerical_error: None,
            surrogate: None,
            posterior: None,
            evidence: None,
            optima: outcomes,
        }
    }
}

/// What Student's errors add to the sum of squares by which a fit is judged: the squares of their normal scores, in place of
/// those over the wider accuracies that stand for them in the search.
fn beyond_normal(problem: &Problem, minimum: &Minimum) -> f64 {
    problem
        .not_normal
        .iter()
        .filter(|value| value.law.student > 0.0)
        .map(|value| {
            let place = value.case * problem.quantities.len() + value.quantity;
            let residual = minimum.misfit.residuals[place];
            let accuracy = problem.cases[value.case].measured[value.quantity].accuracy;
            value.law.score(residual * accuracy).powi(2) - residual.powi(2)
        })
        .sum()
}

fn optimum(problem: &Problem, optimum: &Optimum) -> OptimumOutcome {
    OptimumOutcome {
        weight: optimum.weight,
        cost: optimum.minimum.cost(),
        end: optimum.minimum.end,
        reached: optimum.reached,
        edge: optimum.edge,
        free: (0..problem.free.len()).map(|index| free(problem, optimum, index)).collect(),
        latents: (0..problem.cases.len()).map(|case| latents(problem, optimum, case)).collect(),
    }
}

fn bound(place: f64) -> Option<&'static str> {
    if place <= AT_BOUND {
        Some("lower")
    } else if place >= 1.0 - AT_BOUND {
        Some("upper")
    } else {
        None
    }
}

fn free(problem: &Problem, optimum: &Optimum, index: usize) -> FreeOutcome {
    let free = &problem.free[index];
    let place = optimum.minimum.places[index];
    let deviation = optimum.posterior.deviation(index);
    FreeOutcome {
        name: free.name.clone(),
        unit: free.unit.clone(),
        value: free.value(place),
        deviation: free.spread(deviation),
        scale: free.scale,
        interval: optimum.intervals[index].ends.map(|place| free.value(place)),
        approximation: optimum.intervals[index].approximation,
        bounds: [free.min, free.max],
        prior: free.prior,
        at_bound: bound(place),
        left: deviation * optimum.posterior.prior[index].sqrt(),
        of_case: problem.populations.iter().any(|population| population.members.contains(&index)),
        surrounded: optimum.minimum.surrounded.contains(&index),
    }
}

fn direction(problem: &Problem, direction: &Direction) -> DirectionOutcome {
    const SMALL: f64 = 0.1;
    let mut weights: Vec<(String, f64)> = problem
        .free
        .iter()
        .zip(&direction.weights)
        .filter(|(_, weight)| weight.abs() >= SMALL)
        .map(|(free, &weight)| (free.name.clone(), weight))
        .collect();
    weights.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
    DirectionOutcome { left: direction.left, undetermined: direction.left > UNDETERMINED, weights }
}

fn is_zero(number: &f64) -> bool {
    *number == 0.0
}

fn case(
    problem: &Problem,
    minimum: &Minimum,
    (latents, shifts): (&[LatentOutcome], &[f64]),
    index: usize,
) -> CaseOutcome {
    let case = &problem.cases[index];
    let measured = problem.quantities.iter().zip(&case.measured);
    let residuals = measured.zip(minimum.misfit.predicted[index].iter().zip(shifts)).map(
        |((quantity, measured), (&predicted, &shared))| Residual {
            quantity: quantity.name.clone(),
            measured: measured.value,
            predicted,
            difference: predicted - measured.value,
            shared,
            accuracy: measured.accuracy,
        },
    );
    CaseOutcome { label: case.label.clone(), latents: latents.to_vec(), residuals: residuals.collect() }
}

fn latents(problem: &Problem, optimum: &Optimum, index: usize) -> Vec<LatentOutcome> {
    problem
        .latents
        .iter()
        .zip(&problem.cases[index].latents)
        .zip(problem.latents_of(index))
        .map(|((latent, interval), unknown)| LatentOutcome {
            name: latent.name.clone(),
            value: interval.value(optimum.minimum.places[unknown]),
            deviation: optimum.posterior.deviation(unknown) * (interval.max - interval.min),
            interval: [interval.min, interval.max],
        })
        .collect()
}

fn searches(progress: &Progress) -> SearchOutcome {
    let ended = progress.descents.iter().flatten();
    let screened = progress.screened.iter();
    SearchOutcome {
        screened: progress.screened.len(),
        failed: screened.filter(|cost| cost.is_none()).count(),
        minima: sorted(ended.map(|end| end.cost()).collect()),
    }
}

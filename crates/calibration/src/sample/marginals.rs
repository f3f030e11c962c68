//! What a sample of the posterior tells of single unknowns, and of pairs of them.

use sampling::statistics::moments::{deviation, mean, pearson, sorted};
use serde::Serialize;
use statrs::distribution::{ContinuousCDF, Normal};

use super::{
    super::{
        problem::{Problem, Spacing},
        shared::SharedOutcome,
    },
    Sample,
    region::{quantile, regions},
};

/// One parameter's distribution.
#[derive(Clone, Debug, Serialize)]
pub struct Marginal {
    /// Its name.
    pub name: String,
    /// The unit of its numbers.
    pub unit: Option<String>,
    /// The mean.
    pub mean: f64,
    /// The standard deviation.
    pub deviation: f64,
    /// The median.
    pub median: f64,
    /// The intervals that hold it with 95 % probability: several where there is nothing between them.
    pub intervals: Vec<[f64; 2]>,
    /// How it was measured out.
    pub scale: Spacing,
}

/// A parameter that varies from case to case.
#[derive(Clone, Debug, Serialize)]
pub struct PopulationOutcome {
    /// Its name.
    pub name: String,
    /// The mean of all cases there might be; on a logarithmic scale the median.
    pub mean: Marginal,
    /// The standard deviation from case to case; on a logarithmic scale the factor that stands for one.
    pub spread: Marginal,
}

/// The marginal of one unknown with name, unit and scale, given its places' bounds and how a place becomes a value.
fn marginal(
    sample: &Sample,
    unknown: usize,
    bounds: [f64; 2],
    (name, unit, scale): (&str, &Option<String>, Spacing),
    value: &dyn Fn(f64) -> f64,
) -> Marginal {
    let places = sorted(sample.places(unknown).collect());
    let values: Vec<f64> = places.iter().map(|&place| value(place)).collect();
    let intervals = regions(&places, bounds).into_iter();
    Marginal {
        name: name.to_owned(),
        unit: unit.clone(),
        mean: mean(&values),
        deviation: deviation(&values, 1),
        median: value(quantile(&places, 0.5)),
        intervals: intervals.map(|ends| ends.map(value)).collect(),
        scale,
    }
}

/// Mean and spread of each population stand behind all other unknowns.
pub(super) fn populations(problem: &Problem, sample: &Sample) -> Vec<PopulationOutcome> {
    let first = sample.unknowns() - 2 * problem.populations.len();
    problem
        .populations
        .iter()
        .enumerate()
        .map(|(number, population)| {
            let (name, at) = (&population.name, first + 2 * number);
            let free = &problem.free[population.members[0]];
            let named = (&name[..], &free.unit, free.scale);
            let unit = free.unit.clone().filter(|_| free.scale == Spacing::Linear);
            let of_spread = (&name[..], &unit, Spacing::Linear);
            PopulationOutcome {
                name: name.clone(),
                mean: marginal(sample, at, [0.0, 1.0], named, &|place| free.value(place)),
                spread: marginal(sample, at + 1, [0.0, f64::INFINITY], of_spread, &|place| free.spread(place)),
            }
        })
        .collect()
}

pub(super) fn free(problem: &Problem, sample: &Sample) -> Vec<Marginal> {
    problem
        .free
        .iter()
        .enumerate()
        .map(|(unknown, free)| {
            let named = (&free.name[..], &free.unit, free.scale);
            marginal(sample, unknown, [0.0, 1.0], named, &|place| free.value(place))
        })
        .collect()
}

pub(super) fn latents(problem: &Problem, sample: &Sample) -> Vec<Vec<Marginal>> {
    (0..problem.cases.len())
        .map(|case| {
            problem
                .latents_of(case)
                .zip(problem.latents.iter().zip(&problem.cases[case].latents))
                .map(|(unknown, (latent, interval))| {
                    let named = (&latent.name[..], &latent.unit, Spacing::Linear);
                    marginal(sample, unknown, [0.0, 1.0], named, &|place| interval.value(place))
                })
                .collect()
        })
        .collect()
}

/// The shared errors: each particle has a normal distribution of theirs.
pub(super) fn shared(problem: &Problem, sample: &Sample) -> Vec<SharedOutcome> {
    problem
        .channels
        .iter()
        .enumerate()
        .map(|(number, channel)| {
            let parts: Vec<[f64; 2]> = sample.particles.iter().map(|particle| particle.shared[number]).collect();
            let means: Vec<f64> = parts.iter().map(|[mean, _]| *mean).collect();
            let squares: Vec<f64> = parts.iter().map(|[_, deviation]| deviation * deviation).collect();
            let [centre, spread] = [mean(&means), (mean(&squares) + deviation(&means, 1).powi(2)).sqrt()];
            let mut interval = [0.025, 0.975].map(|part| of_mixture(&parts, part, [centre, spread]));
            let mut sources = channel.sources.iter();
            if sources.all(|(source, _)| problem.sources[*source].rectangular) {
                interval = interval.map(|end| end.clamp(-channel.limit, channel.limit));
            }
            SharedOutcome::new(channel, [centre, spread], interval)
        })
        .collect()
}

/// A quantile of a mixture of normal distributions with this mean and standard deviation, by bisection.
fn of_mixture(parts: &[[f64; 2]], part: f64, [centre, spread]: [f64; 2]) -> f64 {
    // Chebyshev's inequality: a 2.5 % tail begins within 6.4 standard deviations.
    const REACH: f64 = 6.4;
    const HALVINGS: usize = 40;
    let normal = Normal::standard();
    let below = |x: f64| -> f64 {
        let each = parts.iter().map(|[mean, deviation]| normal.cdf((x - mean) / deviation));
        each.sum::<f64>() / parts.len() as f64
    };
    let (mut low, mut high) = (centre - REACH * spread, centre + REACH * spread);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if below(middle) < part { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// The correlations of the free parameters' values.
pub(super) fn correlations(problem: &Problem, sample: &Sample) -> Vec<Vec<f64>> {
    let rows: Vec<Vec<f64>> = sample.particles.iter().map(|particle| problem.free_values(&particle.places)).collect();
    let columns: Vec<Vec<f64>> = (0..problem.free.len()).map(|k| rows.iter().map(|row| row[k]).collect()).collect();
    columns.iter().map(|a| columns.iter().map(|b| pearson(a, b)).collect()).collect()
}

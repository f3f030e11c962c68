//! Results of a sample of the posterior, and how far it can be trusted: plain data that becomes JSON.

use sampling::{
    distribution::ln_sum,
    statistics::moments::{deviation, mean, pearson, sorted},
};
use serde::{Deserialize, Serialize};
use statrs::distribution::{ChiSquared, ContinuousCDF, Normal};

use super::{
    super::{
        failures,
        objective::Objective,
        optima::Optimum,
        problem::{Problem, Spacing},
        shared::SharedOutcome,
    },
    FEWEST, GROUPS, Particle, Sample, Stage,
    region::{quantile, regions},
    target::Target,
};

/// Fewer independent particles say too little of a 95 % interval: with 100 it holds 91 to 99 %.
pub(super) const ENOUGH: f64 = 100.0;

/// Standard errors of the evidence's logarithm to each side for 95 %: Student's factor with seven degrees of freedom. The
/// draws are many, but few of them have most of the weight, so their scatter is known about as well as that of so few numbers.
const REACH: f64 = 2.365;

/// A larger standard error of the evidence's logarithm means that the groups differ.
const AGREE: f64 = 0.3;

/// With fewer ancestors the modes' weights are guesses.
const ANCESTORS: usize = 20;

/// More particles than this part that no move has moved are copies.
const STUCK: f64 = 0.1;

/// An optimum with less of the posterior may well have no particle.
const SEEN: f64 = 0.05;

/// A sample of the posterior.
#[derive(Clone, Debug, Serialize)]
pub struct PosteriorOutcome {
    /// Whether nothing speaks against the sample.
    pub trusted: bool,
    /// Reasons to doubt it.
    pub doubts: Vec<String>,
    /// Further remarks.
    pub notes: Vec<String>,
    /// How many particles there are.
    pub particles: usize,
    /// How many of them are different.
    pub distinct: usize,
    /// About how many independent particles they are worth for means and variances, from the groups' scatter.
    pub effective: f64,
    /// At how many places the model was asked.
    pub evaluated: u64,
    /// At how many of them a run failed; they count as impossible.
    pub failed: u64,
    /// The distributions on the way; the last one is the posterior after the groups were joined.
    pub stages: Vec<Stage>,
    /// The free parameters.
    pub free: Vec<Marginal>,
    /// The parameters that vary from case to case: mean and spread (standard deviation) over all cases there might be.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub populations: Vec<PopulationOutcome>,
    /// The latent parameters, case by case.
    pub latents: Vec<Vec<Marginal>>,
    /// The shared errors of the measured channels.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub shared: Vec<SharedOutcome>,
    /// The correlations of the free parameters.
    pub correlations: Vec<Vec<f64>>,
}

/// The evidence of a model with its prior: the mean likelihood of the measured values over the prior.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Evidence {
    /// Its logarithm; the evidence is in the inverse units of the measured values.
    pub log: f64,
    /// The standard error of the logarithm.
    pub error: f64,
    /// The interval that holds the logarithm with 95 % probability.
    pub interval: [f64; 2],
    /// Whether the sample can be relied on.
    pub trusted: bool,
    /// A digest of the measured values: evidences of other data cannot be compared.
    pub data: String,
    /// How much more probable these data are here than in another result, where that was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub against: Option<Ratio>,
}

/// The ratio of two evidences: Bayes' factor.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Ratio {
    /// Its logarithm.
    pub log: f64,
    /// The interval that holds the logarithm with 95 % probability.
    pub interval: [f64; 2],
}

impl Evidence {
    /// That of a problem, by a sample that can be relied on or not.
    pub fn new(problem: &Problem, sample: &Sample, trusted: bool) -> Self {
        let count = sample.weights.len() as f64;
        let log = ln_sum(&sample.weights) - count.ln();
        let error = (effective_draws(&sample.weights).recip() - count.recip()).max(0.0).sqrt();
        Self {
            log,
            error,
            interval: around(log, error),
            // With fewer effective draws their scatter is not known well.
            trusted: trusted && effective_draws(&sample.weights) >= ENOUGH,
            data: problem.digest(),
            against: None,
        }
    }

    /// Whether it is that of the same measured values.
    ///
    /// # Errors
    /// Says that they are others.
    pub fn is_of(&self, problem: &Problem) -> Result<(), String> {
        if self.data == problem.digest() {
            Ok(())
        } else {
            Err(
                "its evidence is that of other measured values, or of the same in another order or unit, and cannot be compared"
                    .to_owned(),
            )
        }
    }

    /// Notes the ratio to the evidence of another result on the same data.
    ///
    /// # Errors
    /// When one of the samples cannot be relied on.
    pub fn compare(&mut self, other: &Self) -> Result<(), String> {
        if !(self.trusted && other.trusted) {
            let which = if self.trusted { "its" } else { "this" };
            return Err(format!("{which} sample of the posterior is not to be relied on; draw more"));
        }
        let log = self.log - other.log;
        self.against = Some(Ratio { log, interval: around(log, self.error.hypot(other.error)) });
        Ok(())
    }
}

/// As many equal weights would tell as much as these, given their logarithms.
pub(super) fn effective_draws(logs: &[f64]) -> f64 {
    let all = ln_sum(logs);
    logs.iter().map(|log| (2.0 * (log - all)).exp()).sum::<f64>().recip()
}

/// The interval that holds a number of this standard error with 95 % probability.
fn around(centre: f64, error: f64) -> [f64; 2] {
    [-1.0, 1.0].map(|side| centre + side * REACH * error)
}

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

/// The groups' estimates of one mean, weighted by their evidence.
struct Estimate {
    mean: f64,
    error: f64,
}

/// The groups with their parts of the evidence.
struct Groups<'a> {
    parts: Vec<f64>,
    groups: Vec<&'a [Particle]>,
}

impl<'a> Groups<'a> {
    fn of(sample: &'a Sample) -> Self {
        let groups = sample.groups.iter().map(|(_, particles)| &particles[..]);
        let logs: Vec<f64> = sample.groups.iter().map(|(log, _)| *log).collect();
        let all = ln_sum(&logs);
        Self { parts: logs.iter().map(|log| (log - all).exp()).collect(), groups: groups.collect() }
    }

    fn estimate(&self, f: &dyn Fn(&Particle) -> f64) -> Estimate {
        let mean = |group: &&[Particle]| group.iter().map(f).sum::<f64>() / group.len() as f64;
        let means: Vec<f64> = self.groups.iter().map(mean).collect();
        let pairs = self.parts.iter().zip(&means).filter(|(part, _)| **part > 0.0);
        let mean: f64 = pairs.clone().map(|(part, of_group)| part * of_group).sum();
        let squares: f64 = pairs.map(|(part, of_group)| (part * (of_group - mean)).powi(2)).sum();
        let count = GROUPS as f64;
        Estimate { mean, error: (squares * count / (count - 1.0)).sqrt() }
    }
}

impl PosteriorOutcome {
    /// Gathers what a sample tells.
    pub fn new(objective: &Objective, optima: &[Optimum], sample: &Sample) -> Self {
        let problem = objective.problem;
        let alone = problem.populations.is_empty();
        let optima = if alone { optima } else { &[] };
        let groups = Groups::of(sample);
        let effective = effective(&groups, sample);
        let mut outcome = Self {
            trusted: true,
            doubts: Vec::new(),
            notes: Vec::new(),
            particles: sample.particles.len(),
            distinct: distinct(&sample.particles),
            effective,
            evaluated: sample.evaluated,
            failed: sample.failed,
            stages: sample.stages.clone(),
            free: free(problem, sample),
            populations: populations(problem, sample),
            latents: latents(problem, sample),
            shared: shared(problem, sample),
            correlations: correlations(problem, sample),
        };
        outcome.doubts = outcome.doubts(sample).into_iter().chain(missed(optima, sample)).collect();
        outcome.trusted = outcome.doubts.is_empty();
        outcome.notes = outcome.notes(objective, optima, sample);
        outcome
    }

    fn doubts(&self, sample: &Sample) -> Vec<String> {
        let dead = sample.groups.iter().filter(|(log, _)| !log.is_finite()).count();
        let (effective, error) = (self.effective, disagreement(sample));
        let last = sample.stages.last();
        let doubts = [
            (dead > 0).then(|| format!("{dead} of {GROUPS} groups found no place that can be simulated")),
            (effective < ENOUGH).then(|| {
                format!("the particles are worth about {effective:.0} independent ones, and {ENOUGH} are needed")
            }),
            (error.is_nan() || error > AGREE).then(|| {
                format!(
                    "the {GROUPS} groups disagree about the evidence: its logarithm has a standard error of {error:.2}"
                )
            }),
            last.filter(|last| last.ancestors < ANCESTORS).map(|last| {
                format!(
                    "all particles come from {} of those at the start, so the parts of separate modes are guesses",
                    last.ancestors
                )
            }),
            last.filter(|last| last.unmoved > STUCK).map(|last| {
                format!(
                    "{:.0} % of the particles could not be moved from where they were copied to",
                    100.0 * last.unmoved
                )
            }),
        ];
        doubts.into_iter().flatten().collect()
    }

    fn notes(&self, objective: &Objective, optima: &[Optimum], sample: &Sample) -> Vec<String> {
        let mut notes = Vec::new();
        let (failed, evaluated) = (self.failed, self.evaluated);
        if failed > 0 {
            let within = failures::words(&sample.failures.ranges(objective.problem));
            notes.push(format!(
                "runs failed at {failed} of {evaluated} places, all within {within}; these count as impossible, though nothing \
                 is known of them: if the truth lies there, the sample does not hold it"
            ));
        }
        let [asked, failed] = sample
            .stages
            .iter()
            .filter(|stage| stage.exponent >= 1.0)
            .fold([0, 0], |[asked, failed], stage| [asked + stage.asked, failed + stage.failed]);
        if failed > 0 {
            notes.push(format!(
                "{failed} of {asked} last steps led there: the sample borders on these places and is cut where they begin"
            ));
        }
        let problem = objective.problem;
        let rectangular = problem.sources.iter().any(|source| source.rectangular);
        if sample.unknowns() > problem.unknowns() || rectangular || !problem.not_normal.is_empty() {
            // The search took each case by itself, and all errors as normal, so its densities are others.
            return notes;
        }
        // A place of so much higher density is no place that the search was at.
        const HIGHER: f64 = 0.5;
        let target = Target::new(objective);
        let known = optima.iter().map(|optimum| target.log_density(&optimum.minimum)).fold(f64::NEG_INFINITY, f64::max);
        let sampled = sample.particles.iter().map(|particle| particle.log_prior + particle.log_likelihood);
        let higher = sampled.fold(f64::NEG_INFINITY, f64::max) - known;
        if known.is_finite() && higher > HIGHER {
            notes.push(format!(
                "the sample holds places that are exp({higher:.1}) times as probable as the best optimum: the search has \
                 missed one, and more `starts` may find it"
            ));
        }
        notes
    }

    /// How many particles are asked for where there are doubts.
    pub fn more(&self) -> u64 {
        (4 * self.particles as u64).max(FEWEST)
    }
}

/// How many independent particles the sample is worth, for the means and variances of all unknowns together. The groups
/// are few, so the estimate for a single one would scatter too much.
fn effective(groups: &Groups, sample: &Sample) -> f64 {
    let mut ratios = Vec::new();
    for k in 0..sample.unknowns() {
        let mean = groups.estimate(&|particle| particle.places[k]);
        let square = |particle: &Particle| (particle.places[k] - mean.mean).powi(2);
        let variance = groups.estimate(&square);
        if variance.mean <= 0.0 {
            continue;
        }
        ratios.push(mean.error.powi(2) / variance.mean);
        let spread = groups.estimate(&|particle| (square(particle) - variance.mean).powi(2));
        if spread.mean > 0.0 {
            ratios.push(variance.error.powi(2) / spread.mean);
        }
    }
    let mean = ratios.iter().sum::<f64>() / ratios.len().max(1) as f64;
    let all = sample.particles.len() as f64;
    (1.0 / mean).min(all)
}

/// The standard error of the logarithm of the evidence by the stages' ratios, from the groups' scatter.
fn disagreement(sample: &Sample) -> f64 {
    let logs: Vec<f64> = sample.groups.iter().map(|(log, _)| *log).collect();
    let count = logs.len() as f64;
    let whole = ln_sum(&logs) - count.ln();
    let squares = logs.iter().map(|log| ((log - whole).exp() - 1.0).powi(2));
    (squares.sum::<f64>() / (count - 1.0) / count).sqrt()
}

fn distinct(particles: &[Particle]) -> usize {
    let bits = |particle: &Particle| -> Vec<u64> { particle.places.iter().map(|p| p.to_bits()).collect() };
    let mut all: Vec<Vec<u64>> = particles.iter().map(bits).collect();
    all.sort_unstable();
    all.dedup();
    all.len()
}

/// The optima with a considerable part of the posterior that no particle is near: none lies where 99 % of the normal
/// approximation do.
fn missed(optima: &[Optimum], sample: &Sample) -> Vec<String> {
    let unknowns = optima.first().map_or(1, |optimum| optimum.minimum.places.len().max(1));
    let limit = ChiSquared::new(unknowns as f64).expect("there is an unknown").inverse_cdf(0.99);
    let alive = || sample.groups.iter().filter(|(log, _)| log.is_finite()).flat_map(|(_, particles)| particles);
    let is_missed = |optimum: &Optimum| {
        let distance = |particle: &Particle| optimum.posterior.distance(&optimum.minimum.places, &particle.places);
        optimum.weight > SEEN && alive().all(|particle| distance(particle) > limit)
    };
    optima
        .iter()
        .enumerate()
        .filter(|(_, optimum)| is_missed(optimum))
        .map(|(number, optimum)| {
            format!(
                "no particle is near optimum {}, which has {:.0} % by the optima's normal approximations",
                number + 1,
                100.0 * optimum.weight
            )
        })
        .collect()
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
fn populations(problem: &Problem, sample: &Sample) -> Vec<PopulationOutcome> {
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

fn free(problem: &Problem, sample: &Sample) -> Vec<Marginal> {
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

fn latents(problem: &Problem, sample: &Sample) -> Vec<Vec<Marginal>> {
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
fn shared(problem: &Problem, sample: &Sample) -> Vec<SharedOutcome> {
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
fn correlations(problem: &Problem, sample: &Sample) -> Vec<Vec<f64>> {
    let rows: Vec<Vec<f64>> = sample.particles.iter().map(|particle| problem.free_values(&particle.places)).collect();
    let columns: Vec<Vec<f64>> = (0..problem.free.len()).map(|k| rows.iter().map(|row| row[k]).collect()).collect();
    columns.iter().map(|a| columns.iter().map(|b| pearson(a, b)).collect()).collect()
}

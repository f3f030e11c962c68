//! Results of a sample of the posterior, and how far it can be trusted: plain data that becomes JSON.

use sampling::distribution::ln_sum;
use serde::Serialize;
use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::{
    super::{failures, objective::Objective, optima::Optimum, shared::SharedOutcome},
    FEWEST, GROUPS, Particle, Sample, Stage,
    evidence::ENOUGH,
    marginals::{self, Marginal, PopulationOutcome},
    target::Target,
};

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
            free: marginals::free(problem, sample),
            populations: marginals::populations(problem, sample),
            latents: marginals::latents(problem, sample),
            shared: marginals::shared(problem, sample),
            correlations: marginals::correlations(problem, sample),
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

//! A sample of the posterior as text and as a table.

use super::{
    super::{problem::Problem, text::digits},
    GROUPS, Sample,
    evidence::{Evidence, Ratio},
    marginals::Marginal,
    outcome::PosteriorOutcome,
};
use result_document::format::{shown, significant};

/// Intervals that are named one by one.
const NAMED: usize = 8;

/// How far the sample is to be relied on, and what it says beside its marginals.
pub fn sentences(outcome: &PosteriorOutcome, of_data: &Evidence) -> Vec<String> {
    let PosteriorOutcome { particles, effective, evaluated, .. } = outcome;
    let judged = if outcome.trusted {
        format!("{GROUPS} independent groups agree; worth about {effective:.0} independent draws")
    } else {
        "NOT to be relied on, see below".to_owned()
    };
    let mut said = vec![format!("posterior sample: {particles} particles ({judged}), from {evaluated} evaluations")];
    said.push(format!(
        "{} % of the particles are different",
        significant(100.0 * outcome.distinct as f64 / *particles as f64, 3),
    ));
    said.push(of_data.words());
    said.extend(outcome.notes.iter().cloned());
    said.extend(outcome.doubts.iter().map(|doubt| format!("do not rely on this sample: {doubt}")));
    if !outcome.trusted {
        said.push(format!("--posterior {} may do", outcome.more()));
    }
    said
}

/// The marginals of the free parameters, and of means and spreads from case to case: name, mean, deviation, median, intervals.
pub fn marginals(outcome: &PosteriorOutcome) -> Vec<Vec<String>> {
    let populations = outcome.populations.iter().flat_map(|population| {
        let named = |what: &str, marginal: &Marginal| Marginal {
            name: format!("{}, {what}", population.name),
            ..marginal.clone()
        };
        [named("mean of all cases", &population.mean), named("spread from case to case", &population.spread)]
    });
    outcome
        .free
        .iter()
        .cloned()
        .chain(populations)
        .map(|marginal| {
            let parts: Vec<String> =
                marginal.intervals.iter().take(NAMED).map(|ends| ends.map(digits).join(" .. ")).collect();
            let more = match marginal.intervals.len().saturating_sub(NAMED) {
                0 => String::new(),
                more => format!(" or {more} more"),
            };
            let intervals = format!("{} {}{more}", parts.join(" or "), shown(&marginal.unit));
            vec![
                marginal.name,
                digits(marginal.mean),
                significant(marginal.deviation, 3),
                digits(marginal.median),
                intervals.trim_end().to_owned(),
            ]
        })
        .collect()
}

impl Evidence {
    /// How probable the measured values are under this model with its prior, and how much more than under another.
    pub fn words(&self) -> String {
        let [low, high] = self.interval.map(digits);
        let own = if self.trusted {
            format!("{} ({low} .. {high}, 95 %)", digits(self.log))
        } else {
            format!("{}, NOT to be relied on", digits(self.log))
        };
        let Some(Ratio { log, interval }) = &self.against else {
            let more = if self.trusted {
                ". To compare with another model on the same data: `identify OTHER --posterior N --against FOLDER`, this result's folder"
            } else {
                ": more particles may do"
            };
            return format!("ln evidence {own}{more}");
        };
        // Factors beyond a million are told by their logarithm.
        let factor = |log: f64| {
            if log.abs() < 14.0 { significant(log.exp(), 3) } else { format!("exp({})", significant(log, 4)) }
        };
        let which = if *log > 0.0 { "this" } else { "the other" };
        let how = match interval {
            [low, high] if low * high > 0.0 => {
                let [least, most] = [low.abs().min(high.abs()), low.abs().max(high.abs())].map(factor);
                format!("favour {which} one by a factor of {} ({least} .. {most}, 95 %)", factor(log.abs()))
            }
            ends => {
                let [least, most] = ends.map(factor);
                format!("do not tell the two apart: their ratio is {} ({least} .. {most}, 95 %)", factor(*log))
            }
        };
        format!("ln evidence {own}: the data {how}, each with its own prior")
    }
}

/// The head of the table of particles: free parameters, latent ones as `CASE/NAME`, means and spreads of populations as `NAME.mean` and `NAME.spread`, and the logarithm of the likelihood.
pub fn head(problem: &Problem) -> Vec<String> {
    let free = problem.free.iter().map(|free| free.name.clone());
    let latents = problem
        .cases
        .iter()
        .flat_map(|case| problem.latents.iter().map(|latent| format!("{}/{}", case.label, latent.name)));
    let populations =
        problem.populations.iter().flat_map(|each| ["mean", "spread"].map(|what| format!("{}.{what}", each.name)));
    ["point".to_owned()]
        .into_iter()
        .chain(free)
        .chain(latents)
        .chain(populations)
        .chain(["log_likelihood".to_owned()])
        .collect()
}

/// The units of the table's columns, as a comment.
pub fn units(problem: &Problem) -> String {
    problem
        .free
        .iter()
        .map(|free| (&free.name, &free.unit))
        .chain(problem.latents.iter().map(|latent| (&latent.name, &latent.unit)))
        .map(|(name, unit)| {
            let unit = unit.as_deref().unwrap_or("1");
            format!("{name} in {unit}")
        })
        .collect::<Vec<_>>()
        .join(", ")
}

/// The rows of the table: all of equal weight.
pub fn rows<'a>(problem: &'a Problem, sample: &'a Sample) -> impl Iterator<Item = Vec<String>> + 'a {
    sample.particles.iter().enumerate().map(move |(index, particle)| {
        let free = problem.free_values(&particle.places).into_iter();
        let latents = (0..problem.cases.len()).flat_map(|case| problem.latent_values(case, &particle.places));
        let first = problem.unknowns();
        let common = problem.populations.iter().enumerate().flat_map(|(number, population)| {
            let free = &problem.free[population.members[0]];
            let at = first + 2 * number;
            [free.value(particle.places[at]), free.spread(particle.places[at + 1])]
        });
        let numbers = free.chain(latents).chain(common).chain([particle.log_likelihood]);
        let label = (index + 1).to_string();
        [label].into_iter().chain(numbers.map(|value| value.to_string())).collect()
    })
}

//! The points that guard bands accept, and what they say of the risks.

use super::{Guard, Risk, RiskIntervals};
use crate::{
    interval::{Moments, of_mean, of_part},
    measured::Assessed,
};

/// The points that are within a tolerance, by the widest guard band that lets them pass, and those
/// that are not; of all, the sums of the probabilities not to conform.
#[derive(Clone, Debug)]
pub struct Acceptance {
    pub samples: usize,
    /// Whether the uncertainty is known.
    pub known: bool,
    /// By step and sample.
    pub within: Vec<Vec<Moments>>,
    outside: Vec<Moments>,
}

impl Acceptance {
    pub fn new(samples: usize, known: bool) -> Self {
        Self { samples, known, within: Vec::new(), outside: vec![Moments::default(); samples] }
    }

    pub fn add(&mut self, guard: Guard, sample: usize, assessed: Assessed) {
        let place = match guard.widest_passed(assessed) {
            Some(step) => {
                if step >= self.within.len() {
                    let none = vec![Moments::default(); self.samples];
                    self.within.resize(step + 1, none);
                }
                &mut self.within[step]
            }
            None => &mut self.outside,
        };
        // Of a point whose probability was to be told, and was not.
        self.known &= assessed.probability.is_some();
        place[sample].add(1.0 - assessed.probability.unwrap_or(0.0));
    }

    /// The least probability of accepted points not to conform that any guard band comes to, over these points.
    pub fn least_risk(&self) -> f64 {
        let (mut sum, mut least) = (Moments::default(), 1.0_f64);
        for moments in self.within.iter().rev() {
            sum.merge(Moments::total(moments));
            if sum.count > 0 {
                least = least.min(sum.mean());
            }
        }
        least
    }

    /// The least step that keeps the probability of accepted points not to conform at or below a limit, over these points.
    #[cfg(test)]
    pub fn least_step(&self, limit: f64) -> Option<usize> {
        let (mut accepted, mut least) = (Moments::default(), None);
        for (step, moments) in self.within.iter().enumerate().rev() {
            moments.iter().for_each(|more| accepted.merge(*more));
            if accepted.count > 0 && accepted.mean() <= limit {
                least = Some(step);
            }
        }
        least
    }

    /// The accepted and the rejected points of each sample, with the guard band of a step.
    pub fn split(&self, from: usize) -> [Vec<Moments>; 2] {
        let mut accepted = vec![Moments::default(); self.samples];
        let mut rejected = self.outside.clone();
        for (step, moments) in self.within.iter().enumerate() {
            let side = if step >= from { &mut accepted } else { &mut rejected };
            side.iter_mut().zip(moments).for_each(|(sum, more)| sum.merge(*more));
        }
        [accepted, rejected]
    }

    /// The probabilities of which the risks are means, with the guard band of a step: of each sample the consumer's, the
    /// producer's, and those to conform over all points, and those not to conform over the accepted ones. None where the
    /// uncertainty is not known or there is no point.
    pub fn parts(&self, from: usize) -> Option<[Vec<Moments>; 4]> {
        let [accepted, rejected] = self.split(from);
        let pairs = || accepted.iter().zip(&rejected);
        if !self.known || pairs().all(|(a, r)| a.count + r.count == 0) {
            return None;
        }
        let of_all = |of: fn(&Moments, &Moments) -> Moments| -> Vec<Moments> {
            // Zeros for the points that do not count.
            pairs().map(|(a, r)| Moments { count: a.count + r.count, ..of(a, r) }).collect()
        };
        let consumer = of_all(|accepted, _| *accepted);
        let producer = of_all(|_, rejected| rejected.complement());
        let conforming = of_all(|accepted, rejected| Moments::total(&[*accepted, *rejected]).complement());
        Some([consumer, producer, conforming, accepted])
    }

    /// The risks with the guard band of a step, with their intervals; none as above.
    pub fn risk(&self, from: usize) -> Option<Risk> {
        const CONFIDENCE: f64 = 0.95;
        let [consumer, producer, conforming, accepted] = self.parts(from)?;
        let mean = |parts: &[Moments]| Moments::total(parts).mean();
        let any = Moments::total(&accepted).count > 0;
        Some(Risk {
            consumer: mean(&consumer),
            producer: mean(&producer),
            conformance_probability: mean(&conforming),
            not_conforming_given_accepted: any.then(|| mean(&accepted)),
            intervals: Some(RiskIntervals {
                consumer: of_mean(&consumer, CONFIDENCE),
                producer: of_mean(&producer, CONFIDENCE),
                conformance_probability: of_mean(&conforming, CONFIDENCE),
                not_conforming_given_accepted: of_part(&accepted, CONFIDENCE),
            }),
        })
    }
}

//! The points that guard bands accept, and what they say of the risks.

use super::{Guard, Risk, RiskIntervals};
use crate::interval::{Moments, of_mean, of_part};
use crate::measured::Assessed;

/// The points that are within a tolerance, by the widest guard band that lets them pass, and those
/// that are not; of all, the sums of the probabilities not to conform.
#[derive(Clone, Debug)]
pub(super) struct Acceptance {
    pub samples: usize,
    /// Whether the uncertainty is known.
    pub known: bool,
    /// By step and sample.
    pub within: Vec<Vec<Moments>>,
    outside: Vec<Moments>,
}

impl Acceptance {
    pub fn new(samples: usize, known: bool) -> Self {
        Self {
            samples,
            known,
            within: Vec::new(),
            outside: vec![Moments::default(); samples],
        }
    }

    pub fn add(&mut self, guard: Guard, sample: usize, assessed: Assessed) {
        let place = match guard.widest_passed(assessed.margin) {
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

    /// The least step that keeps the probability of accepted points not to conform at or below a
    /// limit.
    pub fn least_step(&self, limit: f64) -> Option<usize> {
        let mut accepted = Moments::default();
        let mut least = None;
        for (step, moments) in self.within.iter().enumerate().rev() {
            accepted.merge(Moments::total(moments));
            if accepted.count > 0 && accepted.mean() <= limit {
                least = Some(step);
            }
        }
        least
    }

    /// The least probability of accepted points not to conform that any guard band comes to.
    pub fn least_risk(&self) -> f64 {
        let mut accepted = Moments::default();
        let mut least = 1.0_f64;
        for moments in self.within.iter().rev() {
            accepted.merge(Moments::total(moments));
            if accepted.count > 0 {
                least = least.min(accepted.mean());
            }
        }
        least
    }

    /// The accepted and the rejected points of each sample, with the guard band of a step.
    pub fn split(&self, from: usize) -> [Vec<Moments>; 2] {
        let mut accepted = vec![Moments::default(); self.samples];
        let mut rejected = self.outside.clone();
        for (step, moments) in self.within.iter().enumerate() {
            let side = if step >= from {
                &mut accepted
            } else {
                &mut rejected
            };
            side.iter_mut()
                .zip(moments)
                .for_each(|(sum, more)| sum.merge(*more));
        }
        [accepted, rejected]
    }

    /// The risks with the guard band of a step; none where the uncertainty is not known or there is no point.
    pub fn risk(&self, from: usize) -> Option<Risk> {
        let shares = self.shares(from)?;
        Some(Risk {
            intervals: Some(shares.intervals()),
            ..shares.risk()
        })
    }

    pub fn shares(&self, from: usize) -> Option<Shares> {
        let [accepted, rejected] = self.split(from);
        let pairs = || accepted.iter().zip(&rejected);
        if !self.known || pairs().all(|(a, r)| a.count + r.count == 0) {
            return None;
        }
        let of_all = |of: &dyn Fn(&Moments, &Moments) -> Moments| -> Vec<Moments> {
            pairs()
                .map(|(a, r)| of(a, r).among(a.count + r.count))
                .collect()
        };
        Some(Shares {
            consumer: of_all(&|accepted, _| *accepted),
            producer: of_all(&|_, rejected| rejected.complement()),
            conforming: of_all(&|accepted, rejected| {
                let mut both = *accepted;
                both.merge(*rejected);
                both.complement()
            }),
            accepted,
        })
    }
}

/// What the risks are means of: numbers of each sample, over all of its points or over the accepted ones.
pub(super) struct Shares {
    consumer: Vec<Moments>,
    producer: Vec<Moments>,
    conforming: Vec<Moments>,
    accepted: Vec<Moments>,
}

impl Shares {
    pub fn risk(&self) -> Risk {
        let mean = |parts: &[Moments]| Moments::total(parts).mean();
        let any = Moments::total(&self.accepted).count > 0;
        Risk {
            consumer: mean(&self.consumer),
            producer: mean(&self.producer),
            conformance_probability: mean(&self.conforming),
            not_conforming_given_accepted: any.then(|| mean(&self.accepted)),
            intervals: None,
        }
    }

    fn intervals(&self) -> RiskIntervals {
        const CONFIDENCE: f64 = 0.95;
        RiskIntervals {
            consumer: of_mean(&self.consumer, CONFIDENCE),
            producer: of_mean(&self.producer, CONFIDENCE),
            conformance_probability: of_mean(&self.conforming, CONFIDENCE),
            not_conforming_given_accepted: of_part(&self.accepted, CONFIDENCE),
        }
    }
}

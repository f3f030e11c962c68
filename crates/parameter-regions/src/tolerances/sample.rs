//! Points drawn at several tolerances, and what they tell of others.

use sampling::distribution::{Distribution, ln_sum};

use super::scaled;

/// Points of which each knows how good it is, and how probable it was to be drawn.
#[derive(Clone, Debug)]
pub struct Sample {
    distributions: Vec<Distribution>,
    points: Vec<Vec<f64>>,
    goods: Vec<f64>,
    /// The tolerances at which points were drawn, and how many.
    drawn: Vec<(Vec<f64>, usize)>,
    /// The logarithm of the density at which a point was drawn, over all rounds.
    ln_mixture: Vec<f64>,
    /// The widest tolerance of each parameter at which points were drawn.
    pub(super) reach: Vec<f64>,
}

/// A share at some tolerances.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Estimate {
    /// The share.
    pub share: f64,
    /// The effective sample size (Kish 1965).
    pub effective: f64,
    /// How many yes-or-no trials would tell the share as well.
    pub trials: f64,
}

impl Sample {
    /// Points drawn at the study's own tolerances, and how good each is, from 0 to 1.
    pub fn new(distributions: &[Distribution], points: Vec<Vec<f64>>, goods: Vec<f64>) -> Self {
        let ones = vec![1.0; distributions.len()];
        let mut sample = Self {
            distributions: distributions.to_vec(),
            points: Vec::new(),
            goods: Vec::new(),
            drawn: Vec::new(),
            ln_mixture: Vec::new(),
            reach: vec![0.0; distributions.len()],
        };
        sample.extend(&ones, points, goods);
        sample
    }

    /// Adds points drawn at other tolerances.
    pub fn extend(&mut self, scales: &[f64], points: Vec<Vec<f64>>, goods: Vec<f64>) {
        assert_eq!(points.len(), goods.len(), "each point says how good it is");
        self.drawn.push((scales.to_vec(), points.len()));
        self.points.extend(points);
        self.goods.extend(goods);
        for (reach, scale) in self.reach.iter_mut().zip(scales) {
            *reach = reach.max(*scale);
        }
        let all = self.points.len() as f64;
        let round = |(scales, count): &(Vec<f64>, usize)| {
            let ln_share = (*count as f64 / all).ln();
            (scaled(&self.distributions, scales), ln_share)
        };
        let rounds: Vec<(Vec<Distribution>, f64)> = self.drawn.iter().map(round).collect();
        let mixture = |point: &Vec<f64>| {
            let rounds = rounds.iter();
            let terms = rounds.map(|(scaled, ln_share)| ln_share + ln_density(scaled, point));
            ln_sum(&terms.collect::<Vec<f64>>())
        };
        self.ln_mixture = self.points.iter().map(mixture).collect();
    }

    /// How many points there are.
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// In how many rounds points were added to the first ones.
    pub fn rounds(&self) -> u64 {
        self.drawn.len() as u64 - 1
    }

    /// The share at these tolerances.
    pub fn estimate(&self, scales: &[f64]) -> Estimate {
        let scaled = scaled(&self.distributions, scales);
        let pairs = self.points.iter().zip(&self.ln_mixture);
        let weights: Vec<f64> =
            pairs.map(|(point, ln_mixture)| (ln_density(&scaled, point) - ln_mixture).exp()).collect();
        let sum: f64 = weights.iter().sum();
        if sum.is_nan() || sum <= 0.0 {
            return Estimate::default();
        }
        let goods = || weights.iter().zip(&self.goods);
        let share = goods().map(|(w, good)| w * good).sum::<f64>() / sum;
        let squares: f64 = weights.iter().map(|w| w * w).sum();
        let scatter: f64 = goods().map(|(w, good)| (w * (good - share)).powi(2)).sum();
        let effective = sum * sum / squares;
        let trials = share * (1.0 - share) * sum * sum / scatter;
        Estimate { share, effective, trials: if scatter > 0.0 { trials } else { effective } }
    }
}

fn ln_density(scaled: &[Distribution], point: &[f64]) -> f64 {
    let pairs = scaled.iter().zip(point);
    pairs.map(|(distribution, &x)| distribution.ln_density(x)).sum()
}

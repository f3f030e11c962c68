//! Random numbers of a search: the same ones whenever it is run again with its seed.

use crate::design::random::{Purpose, bits, to_unit};
use crate::distribution::normal_quantile;

/// Random numbers one after the other.
#[derive(Debug)]
pub(super) struct Random {
    seed: u64,
    drawn: u64,
}

impl Random {
    pub(super) fn new(seed: u64) -> Self {
        Self { seed, drawn: 0 }
    }

    /// A number in (0, 1).
    pub(super) fn unit(&mut self) -> f64 {
        self.drawn += 1;
        to_unit(bits(self.seed, Purpose::Search, self.drawn, 0))
    }

    /// A standard normal number.
    pub(super) fn normal(&mut self) -> f64 {
        normal_quantile(self.unit())
    }

    /// A standard normal vector.
    pub(super) fn normals(&mut self, dimensions: usize) -> Vec<f64> {
        (0..dimensions).map(|_| self.normal()).collect()
    }

    /// An index below `count`.
    pub(super) fn below(&mut self, count: usize) -> usize {
        ((self.unit() * count as f64) as usize).min(count.saturating_sub(1))
    }

    /// An index, each with the probability of its weight; the weights may have any sum.
    pub(super) fn pick(&mut self, weights: &[f64]) -> usize {
        let sum: f64 = weights.iter().sum();
        let mut left = self.unit() * sum;
        for (k, weight) in weights.iter().enumerate() {
            left -= weight;
            if left < 0.0 {
                return k;
            }
        }
        weights.iter().rposition(|w| *w > 0.0).unwrap_or(0)
    }

    /// So many different indexes below `of`, in random order; all of them where there are no more.
    pub(super) fn choice(&mut self, count: usize, of: usize) -> Vec<usize> {
        let mut all: Vec<usize> = (0..of).collect();
        for k in 0..count.min(of) {
            let other = k + self.below(of - k);
            all.swap(k, other);
        }
        all.truncate(count);
        all
    }
}

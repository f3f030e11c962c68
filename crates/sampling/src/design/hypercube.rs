//! Latin hypercubes (McKay, Beckman, Conover 1979): of N points, each of the N equally probable
//! slices of every input holds exactly one.
//!
//! The slice of point `i` comes from a permutation that is computed for one index at a time
//! (a Feistel network with cycle walking: Black, Rogaway 2002), so that no table of N is kept.

use super::{
    rule::{Inputs, Registered, Rule},
    sampling::Sampling,
};
use crate::{
    distribution::BELOW_ONE,
    random::{self, Purpose, mix},
};

/// A rule for N points.
#[derive(Clone, Debug)]
pub struct Hypercube {
    seed: u64,
    points: u64,
    /// Half the bits of the network's sampling.
    half: u32,
}

impl Registered for Hypercube {
    // The variance is at most N / (N - 1) of that of independent points, whatever the function (Owen 1997, "Monte Carlo
    // variance of scrambled net quadrature", SIAM J. Numer. Anal. 34). But a count may take even numbers only: of the points in the
    // upper half of either of two inputs, and not of both, the exact intervals of 6 and 12 points hold in 90 and 92 %, of 64 and more in 93.7 %.
    const INDEPENDENT_FROM: u64 = 64;

    fn new(sampling: &Sampling, _: &Inputs) -> Result<Self, String> {
        Ok(Self::of(sampling.seed, sampling.points))
    }
}

impl Rule for Hypercube {
    fn uniform(&self, index: u64, dimension: u32) -> f64 {
        let slice = self.slice(index, dimension);
        let within = random::uniform(self.seed, Purpose::Jitter, index, dimension);
        // Rounding must not reach 1.
        ((slice as f64 + within) / self.points as f64).min(BELOW_ONE)
    }
}

impl Hypercube {
    /// A rule for a number of points.
    pub fn of(seed: u64, points: u64) -> Self {
        let bits = u64::BITS - points.saturating_sub(1).leading_zeros();
        let half = bits.div_ceil(2).max(1);
        Self { seed, points, half }
    }

    /// The slice of a point: a permutation of 0..N.
    pub fn slice(&self, index: u64, dimension: u32) -> u64 {
        let mut slice = index % self.points;
        loop {
            slice = self.shuffle(slice, dimension);
            if slice < self.points {
                return slice;
            }
        }
    }

    /// A bijection of the numbers of `2 * half` bits.
    fn shuffle(&self, x: u64, dimension: u32) -> u64 {
        const ROUNDS: u64 = 6;
        let mask = (1 << self.half) - 1;
        let (mut left, mut right) = (x >> self.half, x & mask);
        for round in 0..ROUNDS {
            let key = random::bits(self.seed, Purpose::Permutation, round, dimension);
            (left, right) = (right, left ^ mix(right ^ key) & mask);
        }
        left << self.half | right
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_slice_holds_one_point() {
        for points in [1, 2, 3, 50, 1000, 4097] {
            let hypercube = Hypercube::of(3, points);
            for dimension in 0..3 {
                let mut seen = vec![false; points as usize];
                for index in 0..points {
                    let u = hypercube.uniform(index, dimension);
                    let slice = (u * points as f64) as usize;
                    assert!(!seen[slice], "slice {slice} of {points} twice");
                    seen[slice] = true;
                }
            }
        }
    }
}

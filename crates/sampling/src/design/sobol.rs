//! Sobol nets (Sobol 1967; direction numbers of Joe, Kuo 2008) with Owen's nested uniform
//! scrambling (Owen 1995): every digit is flipped or not by a random bit that depends on the
//! digits before it. The net's uniformity stays, and every point is uniformly distributed.

use ::sobol::params::JoeKuoD6;

use super::{
    rule::{Inputs, Registered, Rule},
    sampling::Sampling,
};
use crate::random::{self, Purpose, mix};

const BITS: u32 = 32;

/// A net, scrambled several times independently. The points belong to the replicates in turn, so
/// that any first part of them holds an equal part of each.
#[derive(Clone, Debug)]
pub struct Nets {
    seed: u64,
    replicates: u64,
    /// Direction numbers, the first digit in the highest bit.
    directions: Vec<[u32; BITS as usize]>,
}

impl Registered for Nets {
    const EXTENSIBLE: bool = true;
    const REPLICATES: bool = true;

    fn new(sampling: &Sampling, inputs: &Inputs) -> Result<Self, String> {
        Self::in_dimensions(sampling, inputs.dimensions())
    }
}

impl Rule for Nets {
    fn uniform(&self, index: u64, dimension: u32) -> f64 {
        let (replicate, place) = (index % self.replicates, index / self.replicates);
        let digits = scramble(plain(place, &self.directions[dimension as usize]), self.key(replicate, dimension));
        // The digits beyond the net's are random, as scrambling to infinity makes them.
        let rest = random::bits(self.seed, Purpose::Jitter, index, dimension);
        random::to_unit((u64::from(digits) << BITS) | (rest >> BITS))
    }
}

impl Nets {
    /// Nets in the unit cube of so many dimensions, which need not have inputs.
    ///
    /// # Errors
    /// When a net has too many points or dimensions.
    pub fn in_dimensions(sampling: &Sampling, dimensions: usize) -> Result<Self, String> {
        const REMEDY: &str = "or use method = \"monte-carlo\"";
        if sampling.points.div_ceil(sampling.replicates) > 1 << BITS {
            return Err(format!("a Sobol net has at most 2^{BITS} points; draw fewer, {REMEDY}"));
        }
        let parameters = JoeKuoD6::minimal();
        if dimensions > parameters.max_dims {
            let most = parameters.max_dims;
            return Err(format!("a Sobol net has at most {most} inputs, not {dimensions}; vary fewer, {REMEDY}"));
        }
        let others = parameters.dim_params.iter().map(|dimension| directions(dimension.a, &dimension.m));
        let directions = std::iter::once(van_der_corput()).chain(others).take(dimensions).collect();
        Ok(Self { seed: sampling.seed, replicates: sampling.replicates, directions })
    }

    /// Where the scrambling hash of an input starts. The replicates count down from the largest number: the rounds of a
    /// Latin hypercube, which permutes by the same purpose, count up from 0 and must not meet them.
    fn key(&self, replicate: u64, dimension: u32) -> u64 {
        random::bits(self.seed, Purpose::Permutation, u64::MAX - replicate, dimension)
    }
}

/// The first input: digits reversed.
fn van_der_corput() -> [u32; BITS as usize] {
    std::array::from_fn(|bit| 1 << (BITS as usize - 1 - bit))
}

/// Direction numbers from a primitive polynomial with inner coefficients `coefficients`, and as
/// many first numbers as its degree (Joe, Kuo 2008, eq. 2).
fn directions(coefficients: u32, initial: &[u32]) -> [u32; BITS as usize] {
    let degree = initial.len();
    let mut v = [0_u32; BITS as usize];
    for k in 0..v.len() {
        v[k] = if k < degree {
            initial[k] << (v.len() - 1 - k)
        } else {
            let mut next = v[k - degree] ^ (v[k - degree] >> degree);
            for j in 1..degree {
                let coefficient = (coefficients >> (degree - 1 - j)) & 1;
                next ^= coefficient * v[k - j];
            }
            next
        };
    }
    v
}

/// A point of the unscrambled net, in the order of its index (not of the Gray code).
fn plain(index: u64, directions: &[u32; BITS as usize]) -> u32 {
    directions
        .iter()
        .enumerate()
        .filter(|(bit, _)| (index >> bit) & 1 == 1)
        .fold(0, |digits, (_, direction)| digits ^ direction)
}

/// Flips every digit or not, by a hash of the digits before it.
fn scramble(digits: u32, key: u64) -> u32 {
    let flips = (0..BITS).fold(0, |flips, bit| {
        // A leading 1 tells prefixes of different length apart.
        let prefix = (1 << bit) | (u64::from(digits) >> (BITS - bit));
        (flips << 1) | u32::from(mix(prefix ^ key) >> 63 == 1)
    });
    digits ^ flips
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_plain_net_starts_as_published() {
        let parameters = JoeKuoD6::minimal();
        let dimension = &parameters.dim_params[1];
        let third = directions(dimension.a, &dimension.m);
        let unit = |digits: u32| f64::from(digits) / 2.0_f64.powi(32);
        let points: Vec<f64> = (0..8).map(|index| unit(plain(index, &third))).collect();
        // m = 1, 3, and by the recurrence 6 ^ 4 ^ 1 = 3: directions 1/2, 3/4, 3/8.
        assert_eq!(points, [0.0, 0.5, 0.75, 0.25, 0.375, 0.875, 0.625, 0.125]);
    }

    /// The first numbers of an input, and those that follow by the recurrence: by Bratley and Fox (1988), "Algorithm
    /// 659", ACM Trans. Math. Software 14, for the first one, by hand for the others.
    #[test]
    fn direction_numbers_follow_from_the_polynomial() {
        let cases: [(u32, &[u32], &[u32]); 4] = [
            // x^3 + x + 1
            (0b01, &[1, 3, 7], &[5, 7, 43]),
            // x^3 + x^2 + 1
            (0b10, &[1, 1, 1], &[11, 31, 55, 61]),
            // x^5 + x^4 + x^3 + x^2 + 1
            (0b1110, &[1, 1, 5, 5, 17], &[63, 51]),
            // x + 1: Pascal's triangle modulo 2
            (0, &[1], &[3, 5, 15, 17, 51]),
        ];
        for (coefficients, initial, expected) in cases {
            let all = directions(coefficients, initial);
            let whole = (0..).zip(all).map(|(k, direction)| direction >> (BITS - 1 - k));
            let numbers: Vec<u32> = whole.take(initial.len() + expected.len()).collect();
            assert_eq!(numbers, [initial, expected].concat(), "{coefficients:b}");
        }
    }

    fn nets(points: u64, replicates: u64, dimensions: usize) -> Result<Nets, String> {
        let sampling = Sampling { points, seed: 11, replicates, ..Sampling::default() };
        Nets::in_dimensions(&sampling, dimensions)
    }

    #[test]
    fn every_elementary_interval_holds_its_share_in_every_replicate() {
        // The first two inputs are a (0, m, 2)-net in base 2: each of the 2^m boxes of
        // 2^a by 2^(m-a) holds one point, before and after scrambling.
        for (replicates, replicate) in [(1, 0), (3, 0), (3, 2)] {
            let net = nets(replicates << 8, replicates, 2).unwrap();
            for a in 0..=8 {
                let mut seen = [false; 1 << 8];
                for index in (replicate..replicates << 8).step_by(replicates as usize) {
                    let x = (net.uniform(index, 0) * f64::from(1 << a)) as usize;
                    let y = (net.uniform(index, 1) * f64::from(1 << (8 - a))) as usize;
                    let place = (x << (8 - a)) | y;
                    assert!(!seen[place]);
                    seen[place] = true;
                }
            }
        }
    }

    #[test]
    fn replicates_are_scrambled_differently() {
        let net = nets(64, 2, 1).unwrap();
        let same = |index: u64| {
            let digit = |index| (net.uniform(index, 0) * 64.0).floor();
            digit(2 * index) == digit(2 * index + 1)
        };
        assert!((0..32).filter(|index| same(*index)).count() < 8);
    }

    #[test]
    fn too_many_inputs_are_refused() {
        assert!(nets(10, 1, 100).is_ok());
        assert!(nets(10, 1, 101).unwrap_err().contains("at most 100"));
    }

    #[test]
    fn too_many_points_are_refused() {
        assert!(nets(1 << 32, 1, 1).is_ok() && nets(3 << 32, 3, 1).is_ok());
        for (points, replicates) in [((1 << 32) + 1, 1), ((3 << 32) + 1, 3)] {
            let error = nets(points, replicates, 1).unwrap_err();
            assert!(error.contains("2^32 points; draw fewer"), "{error}");
        }
    }
}

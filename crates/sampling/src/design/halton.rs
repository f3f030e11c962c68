//! Halton sequences (Halton 1960): the digits of a point's index, mirrored at the point, in another prime
//! base for every input. Every digit is permuted at random (Owen 2017, "A randomized Halton algorithm in R"):
//! plain sequences are all but useless in large bases, permuted ones are uniformly distributed.

use super::{
    rule::{Inputs, Registered, Rule},
    sampling::Sampling,
};
use crate::{
    distribution::BELOW_ONE,
    random::{self, Purpose},
};

/// Bits of a coordinate that the permuted digits settle: as many as a number holds. What lies beyond them is random.
const BITS: f64 = 53.0;

/// A scrambled sequence.
#[derive(Clone, Debug)]
pub struct Sequence {
    seed: u64,
    inputs: Vec<Radix>,
}

/// The digits of one input.
#[derive(Clone, Debug)]
struct Radix {
    base: u64,
    /// For every place behind the point, the digit that stands for each digit.
    permutations: Vec<Vec<u16>>,
}

impl Registered for Sequence {
    const EXTENSIBLE: bool = true;

    fn new(sampling: &Sampling, inputs: &Inputs) -> Result<Self, String> {
        Self::of(sampling.seed, inputs.dimensions())
    }
}

impl Rule for Sequence {
    fn uniform(&self, index: u64, dimension: u32) -> f64 {
        let Radix { base, permutations } = &self.inputs[dimension as usize];
        let (mut rest, mut value, mut scale) = (index, 0.0, 1.0);
        for permutation in permutations {
            scale /= *base as f64;
            // Below the base, which is an array's length.
            let digit = (rest % base) as usize;
            value += scale * f64::from(permutation[digit]);
            rest /= base;
        }
        // The digits beyond are random; rounding must not reach 1.
        let jitter = random::uniform(self.seed, Purpose::Jitter, index, dimension);
        (value + scale * jitter).min(BELOW_ONE)
    }
}

impl Sequence {
    fn of(seed: u64, dimensions: usize) -> Result<Self, String> {
        let bases: Vec<u64> = primes().take(dimensions).collect();
        if bases.len() < dimensions {
            let most = bases.len();
            return Err(format!("a Halton sequence has at most {most} inputs, not {dimensions}"));
        }
        let inputs = bases.into_iter().zip(0..).map(|(base, dimension)| Radix::new(seed, base, dimension)).collect();
        Ok(Self { seed, inputs })
    }
}

impl Radix {
    fn new(seed: u64, base: u64, dimension: u32) -> Self {
        let places = (BITS / (base as f64).log2()).ceil() as u64;
        let permutation = |place: u64| {
            let mut digits: Vec<u16> = (0..base as u16).collect();
            // Fisher and Yates 1938.
            for last in (1..base).rev() {
                let bits = random::bits(seed, Purpose::Permutation, place << 16 | last, dimension);
                digits.swap(last as usize, (bits % (last + 1)) as usize);
            }
            digits
        };
        Self { base, permutations: (0..places).map(permutation).collect() }
    }
}

/// The bases: primes, up to a size at which every place takes a permutation of thousands of digits.
fn primes() -> impl Iterator<Item = u64> {
    const MOST: u64 = 1 << 13;
    (2..MOST).filter(|&n| (2..).take_while(|d| d * d <= n).all(|d| !n.is_multiple_of(d)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_run_of_points_fills_the_slices() {
        // Of any b^k points in a row that begin at a multiple, each slice of width b^-k holds one.
        let sequence = Sequence::of(5, 4).unwrap();
        for (dimension, base) in [(0, 2_u64), (1, 3), (2, 5), (3, 7)] {
            let count = base.pow(3);
            for start in [0, 4 * count] {
                let mut seen = vec![false; count as usize];
                for index in start..start + count {
                    let slice = (sequence.uniform(index, dimension) * count as f64) as usize;
                    assert!(!seen[slice], "slice {slice} of base {base} twice");
                    seen[slice] = true;
                }
            }
        }
    }

    /// The point whose every digit is permuted to the largest one, and whose random rest would round up to 1.
    #[test]
    fn rounding_never_reaches_one() {
        let mut rounded = 0;
        for seed in 0..20 {
            let sequence = Sequence::of(seed, 1).unwrap();
            let ones = sequence.inputs[0].permutations.iter().map(|digits| u64::from(digits[1] == 1));
            let index = (0..).zip(ones).map(|(place, digit)| digit << place).sum();
            let rest = random::uniform(seed, Purpose::Jitter, index, 0);
            rounded += u32::from(1.0_f64.next_down() + rest * 2.0_f64.powi(-53) == 1.0);
            assert_eq!(sequence.uniform(index, 0), 1.0_f64.next_down());
        }
        assert!(rounded > 0);
    }

    #[test]
    fn high_bases_do_not_run_in_step() {
        // The plain sequence has a correlation of almost 1 between the bases 67 and 71.
        const N: u32 = 60;
        let sequence = Sequence::of(1, 20).unwrap();
        let pairs = (0..N).map(|i| [18, 19].map(|d| sequence.uniform(i.into(), d) - 0.5));
        let [mut xy, mut xx, mut yy] = [0.0; 3];
        for [x, y] in pairs {
            xy += x * y;
            xx += x * x;
            yy += y * y;
        }
        assert!((xy / f64::sqrt(xx * yy)).abs() < 0.5);
    }

    #[test]
    fn too_many_inputs_are_refused() {
        let error = Sequence::of(1, 2000).unwrap_err();
        assert!(error.contains("at most 1028 inputs"), "{error}");
    }
}

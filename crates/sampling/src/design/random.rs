//! Random numbers that depend on where they are used, not on what was drawn before: the
//! counter-based generator Philox4x32-10 (Salmon, Moraes, Dror, Shaw 2011, "Parallel random
//! numbers: as easy as 1, 2, 3").

use super::rule::{Inputs, Numbers, Registered, Rule};

/// Independent points.
#[derive(Debug)]
pub(crate) struct Independent {
    seed: u64,
}

impl Registered for Independent {
    const EXTENSIBLE: bool = true;

    fn new(numbers: &Numbers, _: &Inputs) -> Result<Self, String> {
        let seed = numbers.seed;
        Ok(Self { seed })
    }
}

impl Rule for Independent {
    fn uniform(&self, index: u64, dimension: u32) -> f64 {
        uniform(self.seed, Purpose::Point, index, dimension)
    }
}

/// Purpose of a random number; different purposes never share numbers.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Purpose {
    /// The coordinates of a point.
    Point = 0,
    /// Permutations of a Latin hypercube.
    Permutation = 1,
    /// The place within a slice of a Latin hypercube, or within the last digit of a net.
    Jitter = 2,
    /// Exchanges that spread a Latin hypercube.
    Swap = 3,
    /// The moves of a search.
    Search = 4,
    /// The errors that the rows of a recording share.
    Common = 5,
    /// The errors of single rows of a recording.
    Row = 6,
}

/// A number in the open interval (0, 1).
pub(crate) fn uniform(seed: u64, purpose: Purpose, index: u64, dimension: u32) -> f64 {
    to_unit(bits(seed, purpose, index, dimension))
}

/// The middle of one of 2^52 slices of (0, 1): never 0, never 1.
#[allow(clippy::cast_precision_loss)]
pub(crate) fn to_unit(bits: u64) -> f64 {
    ((bits >> 12) as f64 + 0.5) * 2.0_f64.powi(-52)
}

/// 64 random bits.
pub(crate) fn bits(seed: u64, purpose: Purpose, index: u64, dimension: u32) -> u64 {
    let counter = [low(index), high(index), dimension, purpose as u32];
    let [a, b, ..] = philox(counter, [low(seed), high(seed)]);
    u64::from(b) << 32 | u64::from(a)
}

/// Two numbers in the open interval (0, 1).
pub(crate) fn pair(seed: u64, purpose: Purpose, index: u64, dimension: u32) -> [f64; 2] {
    let counter = [low(index), high(index), dimension, purpose as u32];
    let [a, b, c, d] = philox(counter, [low(seed), high(seed)]);
    [[a, b], [c, d]].map(|[a, b]| to_unit(u64::from(b) << 32 | u64::from(a)))
}

/// A fast bijective mixer of 64 bits (Stafford's variant 13 of the MurmurHash3 finaliser, as in
/// SplitMix64 of Steele, Lea, Flood 2014).
pub(crate) fn mix(mut x: u64) -> u64 {
    x = (x ^ x >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ x >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ x >> 31
}

#[allow(clippy::cast_possible_truncation)]
fn low(x: u64) -> u32 {
    x as u32
}

#[allow(clippy::cast_possible_truncation)]
fn high(x: u64) -> u32 {
    (x >> 32) as u32
}

fn philox(mut counter: [u32; 4], mut key: [u32; 2]) -> [u32; 4] {
    const ROUNDS: u32 = 10;
    const MULTIPLIERS: [u64; 2] = [0xd251_1f53, 0xcd9e_8d57];
    const WEYL: [u32; 2] = [0x9e37_79b9, 0xbb67_ae85];
    for _ in 0..ROUNDS {
        let first = MULTIPLIERS[0] * u64::from(counter[0]);
        let second = MULTIPLIERS[1] * u64::from(counter[2]);
        counter = [
            high(second) ^ counter[1] ^ key[0],
            low(second),
            high(first) ^ counter[3] ^ key[1],
            low(first),
        ];
        key = [key[0].wrapping_add(WEYL[0]), key[1].wrapping_add(WEYL[1])];
    }
    counter
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_answers() {
        // The published test vectors of Philox4x32-10.
        let zero = philox([0; 4], [0; 2]);
        assert_eq!(zero, [0x6627_e8d5, 0xe169_c58d, 0xbc57_ac4c, 0x9b00_dbd8]);
        let ones = philox([u32::MAX; 4], [u32::MAX; 2]);
        assert_eq!(ones, [0x408f_276d, 0x41c8_3b0e, 0xa20b_c7c6, 0x6d54_51fd]);
        let pi = philox(
            [0x243f_6a88, 0x85a3_08d3, 0x1319_8a2e, 0x0370_7344],
            [0xa409_3822, 0x299f_31d0],
        );
        assert_eq!(pi, [0xd16c_fe09, 0x94fd_cceb, 0x5001_e420, 0x2412_6ea1]);
    }

    /// A pair takes all four words of the generator, the first two of them as a single number does.
    #[test]
    fn a_pair_is_two_numbers() {
        let (seed, index, dimension) = (0x1_0000_0007, 0x2_0000_0003, 5);
        let counter = [3, 2, dimension, Purpose::Row as u32];
        let [a, b, c, d] = philox(counter, [7, 1]).map(u64::from);
        assert_eq!(bits(seed, Purpose::Row, index, dimension), (b << 32) + a);
        let numbers = [(b << 32) + a, (d << 32) + c].map(to_unit);
        assert_eq!(pair(seed, Purpose::Row, index, dimension), numbers);
        assert_eq!(to_unit(1 << 63), 0.5 + 2.0_f64.powi(-53));
    }

    #[test]
    fn the_unit_interval_is_open() {
        assert!(to_unit(0) > 0.0);
        assert!(to_unit(u64::MAX) < 1.0);
    }
}

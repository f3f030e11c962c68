//! Random numbers that depend on where they are used, not on what was drawn before: the
//! counter-based generator Philox4x32-10 (Salmon, Moraes, Dror, Shaw 2011, "Parallel random
//! numbers: as easy as 1, 2, 3").
//!
//! [`Random`] draws them one after the other. All that it makes of them (uniform and normal numbers, indexes, orders)
//! is made here, so that a seed gives the same whatever version of another crate is built in.

use crate::distribution::normal_quantile;

/// Purpose of a random number; different purposes never share numbers.
#[derive(Clone, Copy, Debug)]
pub enum Purpose {
    /// The coordinates of a point.
    Point = 0,
    /// Permutations of a Latin hypercube.
    Permutation = 1,
    /// The place within a slice of a Latin hypercube, or within the last digit of a net.
    Jitter = 2,
    /// The moves of a search.
    Search = 4,
    /// The errors that the rows of a recording share.
    Common = 5,
    /// The errors of single rows of a recording.
    Row = 6,
    /// A sample of a posterior.
    Posterior = 7,
    /// Orders of parameters.
    Order = 8,
    /// The coordinates of a net, dealt out to parameters.
    Deal = 9,
    /// Trajectories of a screening.
    Trajectory = 10,
    /// Points between those of a study.
    Between = 13,
    /// Numbers for whatever has no purpose of its own, such as an example.
    Unstated = 14,
    /// Fits and draws of a surrogate.
    Surrogate = 16,
}

/// Random numbers one after the other. Numbers of different purposes or streams are independent, so what a task draws does not depend on the thread that runs it, nor on other tasks.
#[derive(Clone, Debug)]
pub struct Random {
    seed: u64,
    purpose: Purpose,
    stream: u32,
    drawn: u64,
}

impl Random {
    /// The stream of a seed and a purpose, and of a number where one purpose needs several.
    pub fn new(seed: u64, purpose: Purpose, stream: u32) -> Self {
        Self { seed, purpose, stream, drawn: 0 }
    }

    fn bits(&mut self) -> u64 {
        self.drawn += 1;
        bits(self.seed, self.purpose, self.drawn, self.stream)
    }

    /// A number in the open interval (0, 1).
    pub fn unit(&mut self) -> f64 {
        to_unit(self.bits())
    }

    /// A standard normal number.
    pub fn normal(&mut self) -> f64 {
        normal_quantile(self.unit())
    }

    /// A standard normal vector.
    pub fn normals(&mut self, dimensions: usize) -> Vec<f64> {
        (0..dimensions).map(|_| self.normal()).collect()
    }

    /// An index below `count`.
    pub fn below(&mut self, count: usize) -> usize {
        ((self.unit() * count as f64) as usize).min(count.saturating_sub(1))
    }

    /// An index, each with the probability of its weight; the weights may have any sum.
    pub fn pick(&mut self, weights: &[f64]) -> usize {
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
    pub fn choice(&mut self, count: usize, of: usize) -> Vec<usize> {
        let mut all: Vec<usize> = (0..of).collect();
        self.shuffle_first(count.min(of), &mut all);
        all.truncate(count);
        all
    }

    /// Brings items into a random order.
    pub fn shuffle<T>(&mut self, items: &mut [T]) {
        self.shuffle_first(items.len(), items);
    }

    /// Fisher and Yates's shuffle, up to a number of items.
    fn shuffle_first<T>(&mut self, count: usize, items: &mut [T]) {
        for k in 0..count {
            let other = k + self.below(items.len() - k);
            items.swap(k, other);
        }
    }
}

/// A number in the open interval (0, 1).
pub(crate) fn uniform(seed: u64, purpose: Purpose, index: u64, dimension: u32) -> f64 {
    to_unit(bits(seed, purpose, index, dimension))
}

/// The middle of one of 2^52 slices of (0, 1): never 0, never 1.
pub(crate) fn to_unit(bits: u64) -> f64 {
    ((bits >> 12) as f64 + 0.5) * 2.0_f64.powi(-52)
}

/// The 64 random bits of a place: those of a [`Random`] have the number of the draw and the stream.
pub fn bits(seed: u64, purpose: Purpose, index: u64, dimension: u32) -> u64 {
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
pub fn mix(mut x: u64) -> u64 {
    x = (x ^ x >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ x >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ x >> 31
}

fn low(x: u64) -> u32 {
    x as u32
}

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
        counter = [high(second) ^ counter[1] ^ key[0], low(second), high(first) ^ counter[3] ^ key[1], low(first)];
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
        let pi = philox([0x243f_6a88, 0x85a3_08d3, 0x1319_8a2e, 0x0370_7344], [0xa409_3822, 0x299f_31d0]);
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

    /// The numbers of a seed, for all time: by a program of its own in Python, and the standard library's normal quantile.
    #[test]
    fn a_seed_gives_the_same_numbers_for_ever() {
        let mut random = Random::new(0x1_0000_0007, Purpose::Order, 3);
        let units = [0.468755025806772, 0.36103095348029635, 0.008297239899485498];
        assert_eq!([(); 3].map(|()| random.unit()), units);
        assert_eq!(random.bits(), 0xa2be_6ccd_c059_ca78);
        assert!((random.normal() + 0.6916892268190028).abs() < 1e-14);
        let mut order: Vec<usize> = (0..8).collect();
        random.shuffle(&mut order);
        assert_eq!(order, [5, 1, 0, 3, 2, 7, 4, 6]);
    }

    /// Streams share nothing, however much one of them draws: so threads may draw side by side.
    #[test]
    fn streams_do_not_depend_on_each_other() {
        let draw = |purpose, stream| Random::new(1, purpose, stream).normals(100);
        let streams = [
            draw(Purpose::Order, 0),
            draw(Purpose::Order, 1),
            draw(Purpose::Deal, 0),
            draw(Purpose::Unstated, 0),
            Random::new(2, Purpose::Unstated, 0).normals(100),
        ];
        let mut all: Vec<u64> = streams.iter().flatten().map(|v| v.to_bits()).collect();
        all.sort_unstable();
        all.dedup();
        assert_eq!(all.len(), 500);
    }

    /// Chi-squared with 9 and 23 degrees of freedom stays below 27.9 and 49.7 with a probability of 99.9 %.
    #[test]
    fn indexes_and_orders_are_even() {
        let mut random = Random::new(2, Purpose::Unstated, 0);
        let (mut indexes, mut orders) = ([0_u32; 10], [0_u32; 24]);
        for _ in 0..24_000 {
            indexes[random.below(10)] += 1;
            let order = random.choice(4, 4);
            let place = |k: usize| order[k + 1..].iter().filter(|o| **o < order[k]).count();
            orders[6 * place(0) + 2 * place(1) + place(2)] += 1;
        }
        let uneven = |counts: &[u32]| {
            let mean = 24_000.0 / counts.len() as f64;
            let squares = counts.iter().map(|n| (f64::from(*n) - mean).powi(2));
            squares.sum::<f64>() / mean
        };
        assert!(uneven(&indexes) < 27.9 && uneven(&orders) < 49.7);
    }

    #[test]
    fn the_unit_interval_is_open() {
        assert!(to_unit(0) > 0.0);
        assert!(to_unit(u64::MAX) < 1.0);
    }
}

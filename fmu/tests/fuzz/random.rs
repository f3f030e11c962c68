//! Random numbers that are the same on every machine, and hostile ones among them.

/// SplitMix64 (Steele, Lea and Flood 2014, figure 17): small, and good enough to choose calls with.
pub struct Random(pub u64);

impl Random {
    /// Any 64 bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A whole number less than `n`, which is not 0.
    pub fn below(&mut self, n: usize) -> usize {
        (self.bits() % n as u64) as usize
    }

    /// True once in `n` times.
    pub fn once_in(&mut self, n: usize) -> bool {
        self.below(n) == 0
    }

    /// One of several.
    pub fn one<T: Copy>(&mut self, of: &[T]) -> T {
        of[self.below(of.len())]
    }

    /// From 0 to 1.
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// From `least` to `most`, even in the logarithm; both are greater than 0.
    pub fn magnitude(&mut self, least: f64, most: f64) -> f64 {
        least * (most / least).powf(self.unit())
    }

    /// A number that nobody should pass.
    pub fn hostile(&mut self) -> f64 {
        let ends = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX, f64::MIN];
        let small = [0.0, -0.0, f64::MIN_POSITIVE, 5e-324, -5e-324, -1.0];
        match self.below(4) {
            0 => f64::from_bits(self.bits()),
            1 => self.one(&ends),
            2 => self.one(&small),
            _ => {
                let sign = self.one(&[-1.0, 1.0]);
                sign * self.magnitude(1e-30, 1e30)
            }
        }
    }

    /// A whole number, often at an end of what there is.
    pub fn integer(&mut self) -> i32 {
        let any = self.bits() as i32;
        self.one(&[0, 1, 2, 3, 17, -1, i32::MIN, i32::MAX, any])
    }
}

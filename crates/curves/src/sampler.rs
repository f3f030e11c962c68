//! A signal's values at given times, taken while it is computed.

/// Takes a signal's values at given times as it comes along, in memory for these values only. Between the signal's own
/// times it is a straight line.
#[derive(Clone, Debug)]
pub struct Sampler {
    times: Vec<f64>,
    values: Vec<f64>,
    /// The next of the times; infinite when all are done.
    next: f64,
    /// The signal's last time and value.
    last: [f64; 2],
}

impl Sampler {
    /// A sampler at these times, which must grow.
    pub fn new(times: Vec<f64>) -> Self {
        let mut sampler = Self {
            values: Vec::with_capacity(times.len()),
            times,
            next: f64::INFINITY,
            last: [f64::NAN; 2],
        };
        sampler.restart();
        sampler
    }

    /// Forgets the signal.
    pub fn restart(&mut self) {
        self.values.clear();
        self.next = self.times.first().copied().unwrap_or(f64::INFINITY);
        self.last = [f64::NAN; 2];
    }

    /// Takes the signal's values one after another, each with its time.
    #[inline]
    pub fn add_all(&mut self, signal: impl Iterator<Item = (f64, f64)>) {
        for (time, value) in signal {
            if time >= self.next {
                self.reach(time, value);
            }
            self.last = [time, value];
        }
    }

    /// Takes one value.
    #[inline]
    pub fn add(&mut self, time: f64, value: f64) {
        self.add_all(std::iter::once((time, value)));
    }

    /// Samples what lies between the last value and this one.
    #[inline(never)]
    fn reach(&mut self, time: f64, value: f64) {
        let [before, old] = self.last;
        while self.next <= time {
            let sample = if self.next == time || before.is_nan() {
                value
            } else {
                old + (self.next - before) / (time - before) * (value - old)
            };
            self.push(sample);
        }
    }

    fn push(&mut self, sample: f64) {
        self.values.push(sample);
        let next = self.times.get(self.values.len());
        self.next = next.copied().unwrap_or(f64::INFINITY);
    }

    /// The values at all times, when the signal is over. A signal that ends before the last of them by rounding only
    /// (1e-9 of the time) counts as long enough.
    ///
    /// # Errors
    /// The first time that the signal did not reach.
    pub fn finish(&mut self) -> Result<&[f64], f64> {
        let [time, value] = self.last;
        while self.next.is_finite() {
            let slack = 1e-9 * self.next.abs().max(time.abs());
            if time.is_nan() || self.next > time + slack {
                return Err(self.next);
            }
            self.push(value);
        }
        Ok(&self.values)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_are_taken_between_the_steps() {
        let mut sampler = Sampler::new(vec![0.0, 0.5, 1.0, 2.5, 2.75, 4.0]);
        for _ in 0..2 {
            sampler.restart();
            sampler.add_all([(0.0, 1.0), (1.0, 3.0), (2.0, 3.0), (3.0, 7.0)].into_iter());
            assert_eq!(sampler.clone().finish(), Err(4.0));
            sampler.add(4.0 - 1e-10, -1.0);
            assert_eq!(sampler.finish().unwrap(), [1.0, 2.0, 3.0, 5.0, 6.0, -1.0]);
        }
    }

    #[test]
    fn a_jump_counts_with_its_last_value_before_and_after() {
        let mut sampler = Sampler::new(vec![0.5, 1.5]);
        sampler.add_all([(0.0, 0.0), (1.0, 0.0), (1.0, 5.0), (2.0, 5.0)].into_iter());
        assert_eq!(sampler.finish().unwrap(), [0.0, 5.0]);
    }

    #[test]
    fn no_signal_has_no_samples() {
        assert_eq!(Sampler::new(vec![1.0]).finish(), Err(1.0));
    }
}

//! A signal's values at given times, taken while it is computed.

/// How much too late a signal may begin and too early end, as a part of the time: rounding.
const SLACK: f64 = 1e-9;

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
        let mut sampler =
            Self { values: Vec::with_capacity(times.len()), times, next: f64::INFINITY, last: [f64::NAN; 2] };
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

    /// Takes the values at the ends of steps: every `stride`th one of `values`, from the first on, one a step. Steps among
    /// which no sample lies cost next to nothing.
    ///
    /// # Panics
    /// When there are fewer values or sizes than begins.
    pub fn add_steps(&mut self, begins: &[f64], sizes: &[f64], values: &[f64], stride: usize) {
        let Some(last) = begins.len().checked_sub(1) else { return };
        let end = begins[last] + sizes[last];
        if end < self.next {
            self.last = [end, values[last * stride]];
            return;
        }
        let steps = begins.iter().zip(sizes).enumerate();
        self.add_all(steps.map(|(step, (begin, size))| (begin + size, values[step * stride])));
    }

    /// Samples what lies between the last value and this one.
    #[inline(never)]
    fn reach(&mut self, time: f64, value: f64) {
        let [before, old] = self.last;
        while self.next <= time {
            let sample = if self.next == time {
                value
            } else if before.is_nan() {
                // The signal begins too late, but for rounding.
                let slack = SLACK * self.next.abs().max(time.abs());
                if self.next + slack < time { f64::NAN } else { value }
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
    /// (1e-9 of the time) counts as long enough; before its begin the values are not numbers.
    ///
    /// # Errors
    /// The first time that the signal did not reach.
    pub fn finish(&mut self) -> Result<&[f64], f64> {
        let [time, value] = self.last;
        while self.next.is_finite() {
            let slack = SLACK * self.next.abs().max(time.abs());
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
    fn steps_together_are_as_one_by_one() {
        let times: Vec<f64> = vec![0.0, 0.3, 0.35, 2.0, 2.9];
        let begins: Vec<f64> = (0..30).map(|k| 0.1 * f64::from(k)).collect();
        let sizes = vec![0.1; 30];
        let values: Vec<f64> = (0..60).map(|k| f64::from(k * k)).collect();
        let mut one = Sampler::new(times.clone());
        let mut many = Sampler::new(times);
        for sampler in [&mut one, &mut many] {
            sampler.add(0.0, -1.0);
        }
        for step in 0..30 {
            one.add(begins[step] + sizes[step], values[2 * step]);
        }
        for steps in [0..7, 7..7, 7..8, 8..20, 20..30] {
            many.add_steps(&begins[steps.clone()], &sizes[steps.clone()], &values[2 * steps.start..], 2);
        }
        assert_eq!(one.finish(), many.finish());
    }

    /// Also uneven ones, events that take no time, and samples at their ends.
    #[test]
    fn uneven_steps_together_are_as_one_by_one() {
        let sizes: Vec<f64> = (0..60).map(|k| [0.5, 0.25, 0.0, 0.125, 4.0, 0.0, 0.0][k % 7]).collect();
        let begin = |step: usize| sizes[..step].iter().sum::<f64>();
        let begins: Vec<f64> = (0..60).map(begin).collect();
        let values: Vec<f64> = (0..60).map(|k| f64::from(k * k % 23)).collect();
        for spacing in [0.0625, 0.3, 1.0, 9.0] {
            for together in [1, 2, 5, 20, 60] {
                let times = (0..).map(|k| spacing * f64::from(k));
                let times = times.take_while(|time| *time <= begin(60)).collect();
                let mut one = Sampler::new(times);
                let mut many = one.clone();
                for step in 0..60 {
                    one.add(begins[step] + sizes[step], values[step]);
                }
                for first in (0..60).step_by(together) {
                    let steps = first..(first + together).min(60);
                    many.add_steps(&begins[steps.clone()], &sizes[steps.clone()], &values[steps], 1);
                }
                let bits = |sampler: &mut Sampler| -> Vec<u64> {
                    let samples = sampler.finish().unwrap();
                    samples.iter().map(|sample| sample.to_bits()).collect()
                };
                assert_eq!(bits(&mut one), bits(&mut many), "{spacing} {together}");
            }
        }
    }

    #[test]
    fn before_its_begin_a_signal_has_no_value() {
        let mut sampler = Sampler::new(vec![1.0, 2.0]);
        sampler.add_all([(1.5, 3.0), (2.0, 4.0)].into_iter());
        let values = sampler.finish().unwrap();
        assert!(values[0].is_nan() && values[1] == 4.0, "{values:?}");
        let mut sampler = Sampler::new(vec![1.0, 2.0]);
        sampler.add_all([(1.0 + 1e-12, 3.0), (2.0, 4.0)].into_iter());
        assert_eq!(sampler.finish().unwrap(), [3.0, 4.0]);
    }

    #[test]
    fn no_signal_has_no_samples() {
        assert_eq!(Sampler::new(vec![1.0]).finish(), Err(1.0));
    }
}

//! The strongest oscillation of a signal.
//!
//! The spectrum of the signal less its drift, under a window after von Hann, shows where to look (Harris 1978, "On the use
//! of windows for harmonic analysis with the discrete Fourier transform", Proc. IEEE 66). There, a sine and a straight line
//! are fitted by least squares under the same window (IEEE Std 1057-2017, the sine fit of four parameters): what is left of
//! other oscillations by the window does not count, and neither does the place of the window's ends.

use std::f64::consts::{PI, TAU};

use nalgebra::{Matrix4, Vector4};

/// Fewer values show no oscillation.
const FEWEST: usize = 8;

/// The fewest periods, as the window tells fewer of them from a drift no more.
const PERIODS: f64 = 3.0;

/// How much of the values is rounding.
const ROUNDING: f64 = 1e-12;

/// The values of a signal with their times since the first.
#[derive(Clone, Debug, Default)]
pub(super) struct Recording {
    times: Vec<f64>,
    values: Vec<f64>,
}

/// An oscillation that was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Oscillation {
    /// Hz.
    pub frequency: f64,
    /// Half the distance from peak to peak.
    pub amplitude: f64,
}

/// Sums of a fit of a sine, as coefficients of 1, time, cosine and sine.
struct Fit {
    /// The part of the sum of squares that it explains.
    explained: f64,
    coefficients: Vector4<f64>,
}

impl Recording {
    /// Takes values, each with the time since the one before.
    pub fn add_all(&mut self, values: impl Iterator<Item = (f64, f64)>) {
        for (elapsed, value) in values {
            let time = self.times.last().map_or(0.0, |last| last + elapsed);
            self.times.push(time);
            self.values.push(value);
        }
    }

    /// Whether the values lie on a straight line, but for rounding.
    pub fn is_straight(&self) -> bool {
        let Some(largest) = self.largest() else {
            return false;
        };
        let span = self.span();
        let (first, last) = (self.values[0], self.values[self.values.len() - 1]);
        let mut pairs = self.times.iter().zip(&self.values);
        pairs.all(|(time, value)| {
            let line = first + (last - first) * if span > 0.0 { time / span } else { 0.0 };
            (value - line).abs() <= ROUNDING * largest
        })
    }

    /// The largest magnitude of the values; none where there are none, or one is no number.
    fn largest(&self) -> Option<f64> {
        let finite = self.values.iter().all(|value| value.is_finite());
        let largest = self
            .values
            .iter()
            .fold(0.0, |most: f64, v| most.max(v.abs()));
        (finite && !self.values.is_empty()).then_some(largest)
    }

    fn span(&self) -> f64 {
        self.times.last().copied().unwrap_or(0.0)
    }

    /// The strongest oscillation between three periods in the recording and half the rate of the values. None where there
    /// is nothing but a drift and rounding, and where a wide hump of the spectrum is the strongest of all.
    pub fn strongest(&self) -> Option<Oscillation> {
        if self.values.len() < FEWEST || self.largest().is_none() || self.is_straight() {
            return None;
        }
        let weights = self.weights();
        let spectrum = self.spectrum(&weights);
        let spacing = 1.0 / (self.even_step() * 2.0 * (spectrum.len() - 1) as f64);
        let peak = peak(&spectrum, spacing, self.span())?;
        let frequency = self.refine(&weights, peak as f64 * spacing, spacing);
        let fit = self.fit(&weights, frequency)?;
        let amplitude = fit.coefficients[2].hypot(fit.coefficients[3]);
        (amplitude > ROUNDING * self.largest()?).then_some(Oscillation {
            frequency,
            amplitude,
        })
    }

    /// The window at each value, times the time for which the value stands.
    fn weights(&self) -> Vec<f64> {
        let (times, span) = (&self.times, self.span());
        let last = times.len() - 1;
        let weight = |k: usize| {
            let held = 0.5 * (times[(k + 1).min(last)] - times[k.saturating_sub(1)]);
            held * 0.5 * (1.0 - (TAU * times[k] / span).cos())
        };
        (0..=last).map(weight).collect()
    }

    fn even_step(&self) -> f64 {
        self.span() / (self.values.len() - 1) as f64
    }

    /// Magnitudes of the spectrum from frequency zero to half the rate of as many even values, four a period of the
    /// recording or more.
    fn spectrum(&self, weights: &[f64]) -> Vec<f64> {
        let drift = self.drift(weights);
        let (count, step, span) = (self.values.len(), self.even_step(), self.span());
        let mut real = vec![0.0; (4 * count).next_power_of_two()];
        let mut place = 0;
        for (k, slot) in real.iter_mut().take(count).enumerate() {
            let time = (k as f64 * step).min(span);
            while place + 2 < count && self.times[place + 1] < time {
                place += 1;
            }
            let [(before, low), (after, high)] =
                [place, place + 1].map(|k| (self.times[k], self.values[k]));
            let share = if after > before {
                (time - before) / (after - before)
            } else {
                1.0
            };
            let value = low + share * (high - low) - drift[0] - drift[1] * self.centred(time);
            *slot = value * (1.0 - (TAU * time / span).cos());
        }
        let mut imaginary = vec![0.0; real.len()];
        transform(&mut real, &mut imaginary);
        let pairs = real.iter().zip(&imaginary);
        pairs
            .map(|(a, b)| a.hypot(*b))
            .take(real.len() / 2 + 1)
            .collect()
    }

    /// A time as a part of the recording, from -1 to 1.
    fn centred(&self, time: f64) -> f64 {
        2.0 * time / self.span() - 1.0
    }

    /// The straight line of least squares under the window, over the centred time.
    fn drift(&self, weights: &[f64]) -> [f64; 2] {
        let mut sums = [0.0; 5];
        for ((time, value), weight) in self.times.iter().zip(&self.values).zip(weights) {
            let u = self.centred(*time);
            let terms = [1.0, u, u * u, *value, u * value];
            sums.iter_mut()
                .zip(terms)
                .for_each(|(sum, term)| *sum += weight * term);
        }
        let [one, u, uu, y, uy] = sums;
        let slope = (one * uy - u * y) / (one * uu - u * u);
        [(y - slope * u) / one, slope]
    }

    /// A sine of this frequency and a straight line, by least squares under the window.
    fn fit(&self, weights: &[f64], frequency: f64) -> Option<Fit> {
        let middle = 0.5 * self.span();
        let (mut products, mut moments) = (Matrix4::zeros(), Vector4::zeros());
        for ((time, value), weight) in self.times.iter().zip(&self.values).zip(weights) {
            let (sine, cosine) = (TAU * frequency * (time - middle)).sin_cos();
            let basis = Vector4::new(1.0, self.centred(*time), cosine, sine);
            products.syger(*weight, &basis, &basis, 1.0);
            moments.axpy(weight * (value - self.values[0]), &basis, 1.0);
        }
        let coefficients = products.cholesky()?.solve(&moments);
        Some(Fit {
            explained: coefficients.dot(&moments),
            coefficients,
        })
    }

    /// Refines a peak of the spectrum: the frequency near it whose fitted sine explains most of the signal.
    fn refine(&self, weights: &[f64], start: f64, spacing: f64) -> f64 {
        const ROUNDS: usize = 7;
        const CLOSER: f64 = 0.1;
        let explained = |frequency: f64| {
            let fit = self.fit(weights, frequency);
            fit.map_or(f64::NEG_INFINITY, |fit| fit.explained)
        };
        let (mut best, mut reach) = (start, spacing);
        for _ in 0..ROUNDS {
            let [low, here, high] = [best - reach, best, best + reach].map(explained);
            let bend = low - 2.0 * here + high;
            let shift = if bend < 0.0 {
                0.5 * (low - high) / bend
            } else {
                0.0
            };
            best += reach * shift.clamp(-1.0, 1.0);
            reach *= CLOSER;
        }
        best
    }
}

/// The highest peak of a spectrum, if it is as narrow as the window makes that of a sine: two lines of the window beside it
/// there is less than half of it.
fn peak(spectrum: &[f64], spacing: f64, span: f64) -> Option<usize> {
    let last = spectrum.len() - 1;
    let lines = |number: f64| (number / (span * spacing)).round() as usize;
    let is_peak = |&k: &usize| spectrum[k] > spectrum[k - 1] && spectrum[k] >= spectrum[k + 1];
    let peaks = (lines(PERIODS).max(1)..last).filter(is_peak);
    let highest = peaks.max_by(|&a, &b| spectrum[a].total_cmp(&spectrum[b]))?;
    let beside = [highest.abs_diff(lines(2.0)), highest + lines(2.0)];
    let beside = beside.map(|k| spectrum[if k > last { 2 * last - k } else { k }]);
    (beside[0].max(beside[1]) < 0.5 * spectrum[highest]).then_some(highest)
}

/// The discrete Fourier transform in place, of a power of two of values (Cooley & Tukey 1965).
fn transform(real: &mut [f64], imaginary: &mut [f64]) {
    let count = real.len();
    let bits = count.trailing_zeros();
    for k in 0..count {
        let other = k.reverse_bits() >> (usize::BITS - bits);
        if k < other {
            real.swap(k, other);
            imaginary.swap(k, other);
        }
    }
    let mut half = 1;
    while half < count {
        for j in 0..half {
            let (sine, cosine) = (-PI * j as f64 / half as f64).sin_cos();
            for a in (j..count).step_by(2 * half) {
                let b = a + half;
                let product = [
                    cosine * real[b] - sine * imaginary[b],
                    cosine * imaginary[b] + sine * real[b],
                ];
                (real[b], imaginary[b]) = (real[a] - product[0], imaginary[a] - product[1]);
                real[a] += product[0];
                imaginary[a] += product[1];
            }
        }
        half *= 2;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn recording(signal: impl Fn(f64) -> f64, steps: &[f64]) -> Recording {
        let mut recording = Recording::default();
        let mut time = 0.0;
        for step in [0.0].iter().chain(steps) {
            time += step;
            recording.add_all(std::iter::once((*step, signal(time))));
        }
        recording
    }

    /// Of a sine on a drift, the fit is exact, wherever the window ends and however the values lie.
    #[test]
    fn a_sine_on_a_line_is_found_exactly() {
        let uneven: Vec<f64> = (0..700)
            .map(|k| 0.007 + 0.003 * f64::from(k * k % 3))
            .collect();
        for (periods, steps) in [
            (3.4, &vec![0.01; 300]),
            (40.3, &vec![0.01; 300]),
            (17.0, &uneven),
        ] {
            let span: f64 = steps.iter().sum();
            let frequency = periods / span;
            let signal = |t: f64| 1e3 - 5.0 * t + 0.3 * (TAU * frequency * t + 1.1).cos();
            let found = recording(signal, steps).strongest().unwrap();
            assert!(
                (found.frequency / frequency - 1.0).abs() < 1e-6,
                "{periods}: {found:?}"
            );
            assert!(
                (found.amplitude / 0.3 - 1.0).abs() < 1e-6,
                "{periods}: {found:?}"
            );
        }
    }

    #[test]
    fn the_stronger_one_of_two_is_found() {
        let steps = vec![0.01; 1000];
        let signal = |t: f64| 0.5 * (TAU * 3.02 * t).sin() + 0.8 * (TAU * 7.77 * t).cos();
        let found = recording(signal, &steps).strongest().unwrap();
        assert!((found.frequency - 7.77).abs() < 1e-4, "{found:?}");
        assert!((found.amplitude - 0.8).abs() < 1e-3, "{found:?}");
    }

    #[test]
    fn a_drift_is_no_oscillation() {
        let steps = vec![0.01; 1000];
        for signal in [
            |t: f64| (-t / 3.0).exp(),
            |t: f64| 3.0 - t,
            |_: f64| 5.0,
            |t: f64| t * t,
        ] {
            assert_eq!(recording(signal, &steps).strongest(), None);
        }
        let step = recording(|t| if t > 5.0 { 1.0 } else { 0.0 }, &steps);
        assert_eq!(step.strongest(), None);
        assert_eq!(recording(f64::sin, &[1.0; 3]).strongest(), None);
        let broken = recording(|t| if t > 5.0 { f64::NAN } else { (9.0 * t).sin() }, &steps);
        assert_eq!(broken.strongest(), None);
    }

    #[test]
    fn the_transform_is_that_of_its_definition() {
        let mut real: Vec<f64> = (0..16).map(|k| f64::from(k * k % 7)).collect();
        let (mut imaginary, values) = (vec![0.0; 16], real.clone());
        transform(&mut real, &mut imaginary);
        for k in 0..16 {
            let angle = |n: usize| -TAU * (k * n) as f64 / 16.0;
            let sum = |part: fn(f64) -> f64| -> f64 {
                values
                    .iter()
                    .enumerate()
                    .map(|(n, v)| v * part(angle(n)))
                    .sum()
            };
            assert!((real[k] - sum(f64::cos)).abs() < 1e-12);
            assert!((imaginary[k] - sum(f64::sin)).abs() < 1e-12);
        }
    }
}

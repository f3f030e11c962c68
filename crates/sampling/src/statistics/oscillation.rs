//! The strongest oscillation of a signal.
//!
//! The spectrum of the signal less its drift, under a window after von Hann, shows where to look (Harris 1978, "On the use
//! of windows for harmonic analysis with the discrete Fourier transform", Proc. IEEE 66). There, a sine and a straight line
//! are fitted by least squares under the same window (IEEE Std 1057-2017, the sine fit of four parameters): what is left of
//! other oscillations by the window does not count, and neither does the place of the window's ends.

use std::f64::consts::TAU;

use nalgebra::{Matrix4, Vector4};
use realfft::RealFftPlanner;

/// The fewest periods, as the window tells fewer of them from a drift no more.
const PERIODS: f64 = 3.0;

/// How much of the values is rounding.
const ROUNDING: f64 = 1e-12;

/// The values of a signal with their times since the first.
#[derive(Clone, Debug, Default)]
pub struct Recording {
    times: Vec<f64>,
    values: Vec<f64>,
}

/// An oscillation that was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Oscillation {
    /// Hz.
    pub frequency: f64,
    /// Half the distance from peak to peak.
    pub amplitude: f64,
}

/// Sums of a fit of a sine, as coefficients of 1, time, cosine and sine.
struct SineFit {
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
        let Some(largest) = self.largest() else { return false };
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
        let largest = self.values.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
        (finite && !self.values.is_empty()).then_some(largest)
    }

    fn span(&self) -> f64 {
        self.times.last().copied().unwrap_or(0.0)
    }

    /// The strongest oscillation between three periods in the recording and half the rate of the values. None where there
    /// is nothing but a drift and rounding, and where a wide hump of the spectrum is the strongest of all.
    pub fn strongest(&self) -> Option<Oscillation> {
        let largest = self.largest()?;
        if self.is_straight() {
            return None;
        }
        let weights = self.weights();
        let (spectrum, spacing) = self.spectrum(&weights)?;
        let peak = peak(&spectrum, spacing, self.span())?;
        let frequency = self.refine(&weights, peak as f64 * spacing, spacing);
        let fit = self.fit(&weights, frequency)?;
        let amplitude = fit.coefficients[2].hypot(fit.coefficients[3]);
        (amplitude > ROUNDING * largest).then_some(Oscillation { frequency, amplitude })
    }

    /// The window at each value, times the time for which the value stands.
    fn weights(&self) -> Vec<f64> {
        let (times, span) = (&self.times, self.span());
        let last = times.len() - 1;
        (0..=last)
            .map(|k| {
                let held = 0.5 * (times[(k + 1).min(last)] - times[k.saturating_sub(1)]);
                held * 0.5 * (1.0 - (TAU * times[k] / span).cos())
            })
            .collect()
    }

    fn even_step(&self) -> f64 {
        self.span() / (self.values.len() - 1) as f64
    }

    /// Magnitudes of the spectrum from frequency zero to half the rate of as many even values, four a period of the
    /// recording or more.
    fn spectrum(&self, weights: &[f64]) -> Option<(Vec<f64>, f64)> {
        let drift = self.drift(weights);
        let (count, step, span) = (self.values.len(), self.even_step(), self.span());
        let mut padded = vec![0.0; (4 * count).next_power_of_two()];
        let mut place = 0;
        for (k, slot) in padded.iter_mut().take(count).enumerate() {
            let time = (k as f64 * step).min(span);
            while self.times[place + 1] < time {
                place += 1;
            }
            let [(before, low), (after, high)] = [place, place + 1].map(|k| (self.times[k], self.values[k]));
            let share = if after > before { (time - before) / (after - before) } else { 1.0 };
            let value = low + share * (high - low) - drift[0] - drift[1] * self.centred(time);
            *slot = value * (1.0 - (TAU * time / span).cos());
        }
        let transform = RealFftPlanner::new().plan_fft_forward(padded.len());
        let mut lines = transform.make_output_vec();
        transform.process(&mut padded, &mut lines).ok()?;
        let spacing = 1.0 / (step * padded.len() as f64);
        Some((lines.iter().map(|line| line.norm()).collect(), spacing))
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
            sums.iter_mut().zip(terms).for_each(|(sum, term)| *sum += weight * term);
        }
        let [one, u, uu, y, uy] = sums;
        let slope = (one * uy - u * y) / (one * uu - u * u);
        [(y - slope * u) / one, slope]
    }

    /// A sine of this frequency and a straight line, by least squares under the window.
    fn fit(&self, weights: &[f64], frequency: f64) -> Option<SineFit> {
        let middle = 0.5 * self.span();
        let (mut products, mut moments) = (Matrix4::zeros(), Vector4::zeros());
        for ((time, value), weight) in self.times.iter().zip(&self.values).zip(weights) {
            let (sine, cosine) = (TAU * frequency * (time - middle)).sin_cos();
            let basis = Vector4::new(1.0, self.centred(*time), cosine, sine);
            products.syger(*weight, &basis, &basis, 1.0);
            moments.axpy(weight * (value - self.values[0]), &basis, 1.0);
        }
        let coefficients = products.cholesky()?.solve(&moments);
        Some(SineFit { explained: coefficients.dot(&moments), coefficients })
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
            let shift = if bend < 0.0 { 0.5 * (low - high) / bend } else { 0.0 };
            best += reach * shift.clamp(-1.0, 1.0);
            reach *= CLOSER;
        }
        best
    }
}

/// The index of the highest peak of a spectrum, if it is as narrow as that of a sine under the window: less than half as high
/// at a distance of 2 over the span to either side.
fn peak(spectrum: &[f64], spacing: f64, span: f64) -> Option<usize> {
    let last = spectrum.len() - 1;
    let lines = |number: f64| (number / (span * spacing)).round() as usize;
    let highest = (lines(PERIODS).max(1)..last)
        .filter(|&k| spectrum[k] > spectrum[k - 1] && spectrum[k] >= spectrum[k + 1])
        .max_by(|&a, &b| spectrum[a].total_cmp(&spectrum[b]))?;
    let sides = [highest.abs_diff(lines(2.0)), highest + lines(2.0)];
    // Beyond half the rate the spectrum goes on as in a mirror.
    let heights = sides.map(|k| spectrum[k.min(2 * last - k)]);
    (heights[0].max(heights[1]) < 0.5 * spectrum[highest]).then_some(highest)
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

    fn of(values: &[(f64, f64)]) -> Recording {
        let mut recording = Recording::default();
        recording.add_all(values.iter().copied());
        recording
    }

    /// Steps of three lengths.
    fn uneven(count: u32) -> Vec<f64> {
        let step = |k| 0.007 + 0.003 * f64::from(k * k % 3);
        (0..count).map(step).collect()
    }

    /// Of a sine on a drift, the fit is exact, wherever the window ends and however the values lie.
    #[test]
    fn a_sine_on_a_line_is_found_exactly() {
        for (periods, steps) in [(3.4, &vec![0.01; 300]), (40.3, &vec![0.01; 300]), (17.0, &uneven(700))] {
            let span: f64 = steps.iter().sum();
            let frequency = periods / span;
            let signal = |t: f64| 1e3 - 5.0 * t + 0.3 * (TAU * frequency * t + 1.1).cos();
            let strongest = recording(signal, steps).strongest().unwrap();
            assert!((strongest.frequency / frequency - 1.0).abs() < 1e-6, "{periods}: {strongest:?}");
            assert!((strongest.amplitude / 0.3 - 1.0).abs() < 1e-6, "{periods}: {strongest:?}");
        }
    }

    /// The refinement ends where rounding makes the explained parts equal, and stays a number there.
    #[test]
    fn every_frequency_is_found() {
        for k in 0..120 {
            let frequency = 3.25 + 0.25 * f64::from(k);
            let cosine = recording(|t| (TAU * frequency * t).cos(), &[1.0 / 64.0; 128]);
            let strongest = cosine.strongest().map(|oscillation| oscillation.frequency);
            if frequency < 31.0 {
                let strongest = strongest.unwrap();
                assert!((strongest / frequency - 1.0).abs() < 1e-6, "{frequency}: {strongest}");
            }
        }
    }

    #[test]
    fn the_stronger_one_of_two_is_found() {
        let steps = vec![0.01; 1000];
        let signal = |t: f64| 0.5 * (TAU * 3.02 * t).sin() + 0.8 * (TAU * 7.77 * t).cos();
        let strongest = recording(signal, &steps).strongest().unwrap();
        assert!((strongest.frequency - 7.77).abs() < 1e-4, "{strongest:?}");
        assert!((strongest.amplitude - 0.8).abs() < 1e-3, "{strongest:?}");
    }

    #[test]
    fn a_drift_is_no_oscillation() {
        let steps = vec![0.01; 1000];
        for signal in [|t: f64| (-t / 3.0).exp(), |t: f64| 3.0 - t, |_: f64| 5.0, |t: f64| t * t] {
            assert_eq!(recording(signal, &steps).strongest(), None);
        }
        let step = recording(|t| if t > 5.0 { 1.0 } else { 0.0 }, &steps);
        assert_eq!(step.strongest(), None);
        let broken = recording(|t| if t > 5.0 { f64::NAN } else { (9.0 * t).sin() }, &steps);
        assert_eq!(broken.strongest(), None);
    }

    /// Half the rate of seven even values is three periods in their time: there is nothing between.
    #[test]
    fn few_values_show_no_oscillation() {
        let sine = |steps: usize| {
            let frequency = 3.4 / steps as f64;
            recording(|t| (TAU * frequency * t).sin(), &vec![1.0; steps]).strongest()
        };
        for steps in 0..=6 {
            assert_eq!(sine(steps), None, "{steps}");
        }
        let strongest = sine(10).unwrap();
        assert!((strongest.frequency - 0.34).abs() < 1e-6, "{strongest:?}");
        assert!((strongest.amplitude - 1.0).abs() < 1e-6, "{strongest:?}");
    }

    /// A constant but for the last place of its numbers, which swings.
    #[test]
    fn rounding_is_no_oscillation() {
        let nearly = |share: f64| {
            let signal = |t: f64| 3.0 + 3.0 * share * (TAU * 5.0 * t).sin();
            recording(signal, &[0.01; 200]).strongest()
        };
        assert_eq!(nearly(1e-13), None);
        assert!(nearly(1e-8).is_some());
        // A bend of the first value is no rounding; the sine on it is.
        let bent = |share: f64| {
            let signal = |t: f64| {
                let sine = 3e3 * share * (TAU * 5.0 * t).sin();
                if t == 0.0 { 3e3 + 1e-6 } else { 3e3 + sine }
            };
            recording(signal, &[0.01; 200]).strongest()
        };
        assert_eq!(bent(1e-13), None);
        assert!(bent(1e-11).is_some());
    }

    #[test]
    fn straight_is_what_a_line_from_the_first_to_the_last_value_explains() {
        let line = |t: f64| 1e3 - 5.0 * t;
        assert!(recording(line, &uneven(20)).is_straight());
        assert!(recording(|_| 0.0, &uneven(20)).is_straight());
        assert!(of(&[(0.0, 4.0)]).is_straight());
        assert!(of(&[(0.0, 4.0), (0.0, 4.0)]).is_straight());
        assert!(!of(&[(0.0, 4.0), (0.0, 5.0), (0.0, 4.0)]).is_straight());
        assert!(!of(&[]).is_straight());
        assert!(!recording(|_| f64::NAN, &uneven(3)).is_straight());
        for off in [1e-6, -1e-6] {
            let bent = |t: f64| line(t) + if t == 0.007 { off } else { 0.0 };
            assert!(!recording(bent, &uneven(20)).is_straight(), "{off}");
        }
    }

    #[test]
    fn the_largest_is_the_largest_magnitude_of_numbers() {
        assert_eq!(of(&[(0.0, 2.0), (1.0, -3.0)]).largest(), Some(3.0));
        assert_eq!(of(&[]).largest(), None);
        assert_eq!(of(&[(0.0, 2.0), (1.0, f64::NAN)]).largest(), None);
    }

    /// At 0, 1, 3 and 4 s von Hann's window is 0, 1/2, 1/2 and 0, and a value stands for half the time to its neighbours.
    #[test]
    fn weights_are_those_of_the_window() {
        let values = of(&[(0.0, 5.0), (1.0, 5.0), (2.0, 5.0), (1.0, 5.0)]);
        let expected = [0.0, 0.75, 0.75, 0.0];
        let close = |(weight, expected): (&f64, f64)| (weight - expected).abs() < 1e-15;
        let weights = values.weights();
        assert!(weights.iter().zip(expected).all(close), "{weights:?}");
        assert_eq!((values.span(), values.even_step()), (4.0, 4.0 / 3.0));
        assert_eq!([0.0, 1.0, 4.0].map(|t| values.centred(t)), [-1.0, -0.5, 1.0]);
        // The first and the last value of a short recording: the window does not close there when it is left out.
        let third = of(&[(0.0, 5.0), (2.0, 5.0), (4.0, 5.0)]).weights();
        assert!((third[1] - 3.0 * 0.75).abs() < 1e-15, "{third:?}");
    }

    #[test]
    fn the_drift_of_a_line_is_the_line() {
        let line = recording(|t| 3.0 - 5.0 * t, &uneven(50));
        let half = 0.5 * line.span();
        let [middle, slope] = line.drift(&line.weights());
        assert!((middle - (3.0 - 5.0 * half)).abs() < 1e-12, "{middle}");
        assert!((slope + 5.0 * half).abs() < 1e-12, "{slope}");
        // Least squares: the residuals of any signal are orthogonal to a line.
        let bent = recording(|t| (40.0 * t).sin() + t * t, &uneven(50));
        let weights = bent.weights();
        let [middle, slope] = bent.drift(&weights);
        let mut moments = [0.0; 2];
        for ((time, value), weight) in bent.times.iter().zip(&bent.values).zip(&weights) {
            let u = bent.centred(*time);
            let residual = weight * (value - middle - slope * u);
            moments[0] += residual;
            moments[1] += residual * u;
        }
        assert!(moments.iter().all(|m| m.abs() < 1e-15), "{moments:?}");
    }

    #[test]
    fn a_fit_at_its_frequency_is_exact() {
        let frequency = 9.0;
        let values = recording(|t| 2.0 + 3.0 * t + 0.5 * (TAU * frequency * t).cos(), &uneven(100));
        let (weights, middle) = (values.weights(), 0.5 * values.span());
        let fit = values.fit(&weights, frequency).unwrap();
        let phase = TAU * frequency * middle;
        let expected = [2.0 + 3.0 * middle - values.values[0], 3.0 * middle, 0.5 * phase.cos(), -0.5 * phase.sin()];
        for (coefficient, expected) in fit.coefficients.iter().zip(expected) {
            assert!((coefficient - expected).abs() < 1e-9, "{coefficient} {expected}");
        }
        // It explains all of the sum of squares.
        let square = |(value, weight): (&f64, &f64)| weight * (value - values.values[0]).powi(2);
        let total: f64 = values.values.iter().zip(&weights).map(square).sum();
        assert!((fit.explained / total - 1.0).abs() < 1e-12);
    }

    /// By its definition, of a recording with uneven steps and jumps, one at its start and one where an even value lies.
    #[test]
    fn the_spectrum_is_that_of_even_values() {
        let values = of(&[
            (0.0, 9.0),
            (0.0, 1.0),
            (0.25, 3.0),
            (0.25, -2.0),
            (0.0, 4.0),
            (0.75, 0.5),
            (0.25, 1.5),
            (0.5, -1.0),
            (1.5, 2.0),
        ]);
        let weights = values.weights();
        let [middle, slope] = values.drift(&weights);
        // At 0, 0.4375, 0.875 s and so on, on straight lines; before a jump its first value, at the start the second one.
        let line = |t: f64| {
            if t == 0.0 {
                return 1.0;
            }
            let k = values.times.partition_point(|time| *time < t);
            let (from, to) = (values.times[k - 1], values.times[k]);
            let share = (t - from) / (to - from);
            (1.0 - share) * values.values[k - 1] + share * values.values[k]
        };
        let slots: Vec<f64> = (0..9)
            .map(|k| 0.4375 * f64::from(k))
            .map(|t| {
                let rest = line(t) - middle - slope * (2.0 * t / 3.5 - 1.0);
                rest * (1.0 - (TAU * t / 3.5).cos())
            })
            .collect();
        let (spectrum, spacing) = values.spectrum(&weights).unwrap();
        assert_eq!((spectrum.len(), spacing), (33, 1.0 / (0.4375 * 64.0)));
        for (k, amplitude) in spectrum.iter().enumerate() {
            let sum = |part: fn(f64) -> f64| -> f64 {
                let term = |(n, slot): (usize, &f64)| slot * part(TAU * (k * n) as f64 / 64.0);
                slots.iter().enumerate().map(term).sum()
            };
            let expected = sum(f64::cos).hypot(sum(f64::sin));
            assert!((amplitude - expected).abs() < 1e-12, "{k}: {amplitude} {expected}");
        }
    }

    /// A spectrum of twenty lines, a line for each period of the recording, that is zero but for these.
    fn peak_of(lines: &[(usize, f64)]) -> Option<usize> {
        let mut spectrum = [0.0; 21];
        for (k, height) in lines {
            spectrum[*k] = *height;
        }
        peak(&spectrum, 0.5, 2.0)
    }

    #[test]
    fn the_highest_narrow_peak_counts() {
        assert_eq!(peak_of(&[(5, 2.0), (9, 3.0), (12, 1.0)]), Some(9));
        assert_eq!(peak_of(&[]), None);
        // Three periods are enough, two are not.
        assert_eq!(peak_of(&[(3, 2.0)]), Some(3));
        assert_eq!(peak_of(&[(2, 2.0)]), None);
        // Two equal lines are a peak, and so is the last one but one when what lies beyond is as low.
        assert_eq!(peak_of(&[(7, 2.0), (8, 2.0)]), Some(7));
        assert_eq!(peak_of(&[(18, 2.0)]), Some(18));
        assert_eq!(peak_of(&[(20, 2.0)]), None);
    }

    #[test]
    fn a_wide_hump_is_no_peak() {
        for side in [7, 11] {
            assert_eq!(peak_of(&[(9, 2.0), (side, 0.9)]), Some(9));
            assert_eq!(peak_of(&[(9, 2.0), (side, 1.0)]), None);
        }
        // The spectrum goes on beyond half the rate as in a mirror: line 21 is line 19, and so is line 1 beyond 0.
        assert_eq!(peak_of(&[(18, 2.0), (20, 0.9)]), Some(18));
        assert_eq!(peak_of(&[(18, 2.0), (20, 1.0)]), None);
        assert_eq!(peak_of(&[(19, 2.0)]), None);
        assert_eq!(peak_of(&[(3, 2.0), (1, 1.0)]), None);
        // A hump that is the highest of all hides a narrow peak.
        assert_eq!(peak_of(&[(5, 1.5), (9, 2.0), (11, 1.2)]), None);
    }

    /// Four times as many lines: two lines of the window are eight of them.
    #[test]
    fn lines_of_a_padded_spectrum_are_closer() {
        let mut spectrum = [0.0; 81];
        spectrum[40] = 2.0;
        spectrum[42] = 1.9;
        assert_eq!(peak(&spectrum, 0.125, 2.0), Some(40));
        spectrum[48] = 1.5;
        assert_eq!(peak(&spectrum, 0.125, 2.0), None);
        (spectrum[48], spectrum[32]) = (0.0, 1.5);
        assert_eq!(peak(&spectrum, 0.125, 2.0), None);
        // What still rises at half the rate is no peak, and hides none.
        spectrum[32] = 0.0;
        (spectrum[78], spectrum[79], spectrum[80]) = (2.5, 3.0, 3.5);
        assert_eq!(peak(&spectrum, 0.125, 2.0), Some(40));
    }
}

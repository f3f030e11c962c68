//! Smoothing without delay.

use super::signal::SignalError;
use serde::Deserialize;
use std::{f64::consts::PI, fmt};

/// The highest order of a filter.
const MOST_ORDER: usize = 20;

/// How a signal is smoothed.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(tag = "method", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Smoothing {
    /// Not at all.
    None,
    /// A Butterworth low pass run forwards and backwards: no phase, twice the damping.
    Butterworth {
        /// The frequency at which one run damps by 3 dB, Hz.
        cutoff: f64,
        /// Order of one run, from 1 to 20.
        order: usize,
    },
}

impl fmt::Display for Smoothing {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::None => write!(f, "none"),
            Self::Butterworth { cutoff, order } => {
                write!(f, "Butterworth low pass, order {order} at {cutoff} Hz, forwards and backwards")
            }
        }
    }
}

impl Smoothing {
    /// Smooths evenly spaced samples, `step` seconds apart.
    pub fn apply(self, values: &[f64], step: f64) -> Result<Vec<f64>, SignalError> {
        match self {
            Self::None => Ok(values.to_vec()),
            Self::Butterworth { cutoff, order } => butterworth(values, cutoff * step, order),
        }
    }
}

/// A second-order section in direct form: b0 b1 b2 over 1 a1 a2.
struct Section {
    b: [f64; 3],
    a: [f64; 2],
}

/// Runs a Butterworth low pass forwards and backwards. `cutoff` is in cycles a sample.
///
/// Sections by the bilinear transform with prewarping; the ends are extended by their mirror image
/// (odd), and each run starts in the steady state of its first sample, so that no transient stays
/// (Gustafsson 1996, "Determining the initial states in forward-backward filtering").
fn butterworth(values: &[f64], cutoff: f64, order: usize) -> Result<Vec<f64>, SignalError> {
    if !(1..=MOST_ORDER).contains(&order) {
        return Err(SignalError::Setting(format!(
            "a Butterworth filter needs an order from 1 to {MOST_ORDER}; {order} is not"
        )));
    }
    if !(cutoff > 0.0 && cutoff < 0.5) {
        return Err(SignalError::Setting(format!(
            "a Butterworth filter needs a cutoff between 0 and half the sampling frequency; {cutoff} of the sampling frequency is not"
        )));
    }
    let (Some(&first), Some(&last)) = (values.first(), values.last()) else { return Ok(Vec::new()) };
    let sections = sections(cutoff, order);
    let pad = (3 * (order + 1)).max((1.5 / cutoff) as usize).min(values.len() - 1);
    let n = values.len();
    let mut extended: Vec<f64> = (1..=pad).rev().map(|k| 2.0 * first - values[k]).collect();
    extended.extend_from_slice(values);
    extended.extend((1..=pad).map(|k| 2.0 * last - values[n - 1 - k]));
    for _ in 0..2 {
        for section in &sections {
            section.run(&mut extended);
        }
        extended.reverse();
    }
    Ok(extended[pad..pad + n].to_vec())
}

fn sections(cutoff: f64, order: usize) -> Vec<Section> {
    // The cutoff, prewarped.
    let tangent = (PI * cutoff).tan();
    let pair = |k: usize| {
        // A pair of poles at the angle (2k+1)pi/2n from the imaginary axis: s^2 + damping s + 1.
        let damping = 2.0 * (PI * (2 * k + 1) as f64 / (2 * order) as f64).sin();
        let scale = 1.0 + damping * tangent + tangent * tangent;
        let b = tangent * tangent / scale;
        let last = (1.0 - damping * tangent + tangent * tangent) / scale;
        Section { b: [b, 2.0 * b, b], a: [2.0 * (tangent * tangent - 1.0) / scale, last] }
    };
    let mut sections: Vec<Section> = (0..order / 2).map(pair).collect();
    if order % 2 == 1 {
        let b = tangent / (1.0 + tangent);
        sections.push(Section { b: [b, b, 0.0], a: [(tangent - 1.0) / (1.0 + tangent), 0.0] });
    }
    sections
}

impl Section {
    /// Filters in place, from the steady state of the first sample (the gain at rest is 1).
    fn run(&self, x: &mut [f64]) {
        let Some(&rest) = x.first() else { return };
        let mut s1 = rest * (self.b[2] - self.a[1] + self.b[1] - self.a[0]);
        let mut s2 = rest * (self.b[2] - self.a[1]);
        for v in x {
            let input = *v;
            let y = self.b[0] * input + s1;
            s1 = self.b[1] * input - self.a[0] * y + s2;
            s2 = self.b[2] * input - self.a[1] * y;
            *v = y;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Amplitude ratio of [`Smoothing`] at a frequency; `step` in s, frequency in Hz.
    fn gain(smoothing: Smoothing, step: f64, frequency: f64) -> f64 {
        match smoothing {
            Smoothing::None => 1.0,
            Smoothing::Butterworth { cutoff, order } => {
                let ratio = (PI * frequency * step).tan() / (PI * cutoff * step).tan();
                1.0 / (1.0 + ratio.powi(2 * order as i32))
            }
        }
    }

    fn signal() -> Vec<f64> {
        (0..40).map(|k| (f64::from(k) * 0.7).sin() + 0.3 * (f64::from(k) * 2.9).cos() + 0.01 * f64::from(k)).collect()
    }

    fn close(values: &[f64], places: [usize; 4], expected: [f64; 4], tolerance: f64) {
        for (p, e) in places.into_iter().zip(expected) {
            assert!((values[p] - e).abs() < tolerance, "{p}: {} {e}", values[p]);
        }
    }

    /// SciPy 1.x: `sosfiltfilt(butter(N, 0.3, output="sos"), x, padlen=...)` with the same padding.
    #[test]
    fn butterworth_equals_scipy() {
        close(&butterworth(&signal(), 0.15, 4).unwrap(), [0, 2, 20, 39], BUTTER4, 1e-10);
        close(&butterworth(&signal(), 0.15, 3).unwrap(), [0, 2, 20, 39], BUTTER3, 1e-10);
    }
    const BUTTER4: [f64; 4] = [0.2985894878113545, 0.9354826675063309, 1.1271413055083337, 1.5111685752928512];
    const BUTTER3: [f64; 4] = [0.29889007191768063, 0.8832945872967664, 1.0726724893379518, 1.5188581687981568];

    #[test]
    fn smoothing_moves_no_zero_crossing() {
        let step = 1e-3;
        let wave: Vec<f64> = (0..4000).map(|k| (2.0 * PI * 5.0 * f64::from(k) * step + 0.4).sin()).collect();
        let filter = Smoothing::Butterworth { cutoff: 40.0, order: 4 };
        let smooth = filter.apply(&wave, step).unwrap();
        let g = gain(filter, step, 5.0);
        for k in 1000..3000 {
            assert!((smooth[k] - g * wave[k]).abs() < 1e-6, "{k}");
        }
    }

    #[test]
    fn unsuitable_settings_are_refused() {
        let refused = |cutoff, order| butterworth(&signal(), cutoff, order).unwrap_err().to_string();
        assert!(refused(0.5, 4).contains("0.5 of the sampling frequency"));
        for order in [0, MOST_ORDER + 1, usize::MAX] {
            assert!(refused(0.1, order).contains("an order from 1 to 20"));
        }
    }

    #[test]
    fn nothing_is_smoothed_to_nothing() {
        assert!(butterworth(&[], 0.1, 4).unwrap().is_empty());
    }
}

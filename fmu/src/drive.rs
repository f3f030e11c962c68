//! The drive: sets the shaft's speed, with the fluctuation that the paper allows for
//! (Vrublevskyi & Skonieczna 2025, section 3: ±2.5 % of the nominal speed).
//!
//! The speed is an input, so the shaft angle follows in closed form and never drifts with the
//! step size.

use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// The drive's parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Drive {
    /// Amplitude of the speed fluctuation relative to the mean speed, 1.
    pub fluctuation_amplitude: f64,
    /// Frequency of the speed fluctuation, Hz.
    pub fluctuation_frequency: f64,
}

impl Default for Drive {
    fn default() -> Self {
        Self {
            fluctuation_amplitude: 0.0,
            fluctuation_frequency: 0.5,
        }
    }
}

/// The commanded speed over a step: `speed + slope * tau`, tau from the start of the step.
#[derive(Clone, Copy, Debug)]
pub struct Command {
    /// Time at the start of the step, s.
    pub time: f64,
    /// Commanded speed at the start of the step, rad/s.
    pub speed: f64,
    /// Its time derivative, rad/s².
    pub slope: f64,
}

impl Drive {
    /// Shaft speed `tau` seconds into the step, rad/s:
    /// `omega = (speed + slope*tau) * (1 + a*sin(2*pi*f*t))`.
    pub fn speed(&self, command: &Command, tau: f64) -> f64 {
        let mean = command.speed + command.slope * tau;
        if self.fluctuation_amplitude == 0.0 {
            return mean;
        }
        let w = TAU * self.fluctuation_frequency;
        mean * (1.0 + self.fluctuation_amplitude * (w * (command.time + tau)).sin())
    }

    /// Angle that the shaft turns in the first `tau` seconds of the step, rad: the integral of [`Drive::speed`].
    pub fn turned(&self, command: &Command, tau: f64) -> f64 {
        let steady = tau * (command.speed + 0.5 * command.slope * tau);
        let w = TAU * self.fluctuation_frequency;
        if self.fluctuation_amplitude == 0.0 || w == 0.0 {
            return steady;
        }
        // By parts: the integral of (v + s*x)*sin(w*(t + x)) over x from 0 to tau.
        let (sin0, cos0) = (w * command.time).sin_cos();
        let (sin1, cos1) = (w * (command.time + tau)).sin_cos();
        let end_speed = command.speed + command.slope * tau;
        let swing =
            (command.speed * cos0 - end_speed * cos1) / w + command.slope * (sin1 - sin0) / (w * w);
        steady + self.fluctuation_amplitude * swing
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angle_is_the_integral_of_speed() {
        let drive = Drive {
            fluctuation_amplitude: 0.025,
            fluctuation_frequency: 3.7,
        };
        let command = Command {
            time: 1.3,
            speed: 31.4,
            slope: -12.0,
        };
        let (n, tau) = (2000, 0.9);
        let dx = tau / n as f64;
        // Simpson's rule.
        let sum: f64 = (0..=n)
            .map(|i| {
                let weight = match i {
                    0 => 1.0,
                    i if i == n => 1.0,
                    i if i % 2 == 1 => 4.0,
                    _ => 2.0,
                };
                weight * drive.speed(&command, i as f64 * dx)
            })
            .sum();
        let expected = sum * dx / 3.0;
        assert!((drive.turned(&command, tau) - expected).abs() < 1e-9);
    }

    #[test]
    fn a_constant_speed_turns_exactly() {
        let command = Command {
            time: 7.0,
            speed: 10.0 * std::f64::consts::PI,
            slope: 0.0,
        };
        assert_eq!(Drive::default().turned(&command, 0.2), TAU);
    }
}

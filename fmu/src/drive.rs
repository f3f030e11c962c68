//! The drive: shaft speed and angle. The speed may fluctuate, in the paper by ±2.5 % of its nominal value
//! (Vrublevskyi & Skonieczna 2025, section 3).
//!
//! The speed is an input, not a state. The shaft angle is its integral in closed form, which no step size can make drift.

use journal_bearing::contact::direction;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// The drive's parameters.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Drive {
    /// Amplitude of the speed fluctuation relative to the mean speed, 1.
    pub fluctuation_amplitude: f64,
    /// Frequency of the speed fluctuation, Hz.
    pub fluctuation_frequency: f64,
    /// Friction coefficient of the stand's support bearings, relative to the load and the journal's radius, 1.
    pub support_friction: f64,
    /// Viscous torque of the support bearings over the shaft speed, N.m.s/rad.
    pub support_drag: f64,
}

impl Default for Drive {
    fn default() -> Self {
        Self { fluctuation_amplitude: 0.0, fluctuation_frequency: 0.5, support_friction: 0.0, support_drag: 0.0 }
    }
}

/// The commanded speed during a step: `speed + slope * tau`, tau from the start of the step.
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
        if self.fluctuation_amplitude == 0.0 {
            return steady;
        }
        // The integral of (v + s*y)*sin(p + w*y) over y from -h to h, with y = 0 in the middle of the time that has passed.
        // In this form no large terms cancel, even if the fluctuation is very slow.
        let h = 0.5 * tau;
        let (sin, cos) = (w * (command.time + h)).sin_cos();
        let speed = command.speed + command.slope * h;
        let (even, odd) = moments(w * h);
        let swing = tau * (speed * sin * even + command.slope * h * cos * odd);
        steady + self.fluctuation_amplitude * swing
    }

    /// Whether the speed fluctuates.
    pub fn fluctuates(&self) -> bool {
        self.fluctuation_amplitude != 0.0 && self.fluctuation_frequency != 0.0
    }

    /// The fewest turns, at a commanded speed (rad/s) that stays, after which the fluctuation repeats itself, too: it takes them a
    /// whole number of its own periods, and the shaft a whole number of turns. `None` if there are none up to [`MOST_TURNS`].
    pub fn common_turns(&self, speed: f64) -> Option<u32> {
        if !self.fluctuates() {
            return Some(1);
        }
        let periods_per_turn = self.fluctuation_frequency * TAU / speed.abs();
        (1..=MOST_TURNS).find(|turns| {
            let periods = f64::from(*turns) * periods_per_turn;
            (periods - periods.round()).abs() <= WHOLE * periods
        })
    }
}

/// Over more turns than these, temperatures do more than drift.
pub const MOST_TURNS: u32 = 64;
/// A number of periods counts as whole up to this relative rounding.
const WHOLE: f64 = 1e-9;

impl Drive {
    /// Friction torque of the bearings that support the shaft, N.m, at a load (N) and a shaft speed (rad/s); `radius` (m) is
    /// the journal's. The torque sensor stands between drive and shaft, so it reads this torque, too. The heat stays in the
    /// supports.
    ///
    /// Rolling bearings resist with a nearly constant coefficient, `M = mu P d/2` (SKF 2018, Rolling bearings, section
    /// B.3: 0.0015 for deep groove ball bearings, relative to their bore d), plain ones with a torque in proportion to the speed
    /// (Petroff 1883).
    pub fn support_torque(&self, load: f64, radius: f64, speed: f64) -> f64 {
        let rolling = match self.support_friction {
            0.0 => 0.0,
            friction => friction * load * radius * direction(speed * radius),
        };
        rolling + self.support_drag * speed
    }
}

/// The mean over x from -1 to 1 of `cos(q*x)` and of `x*sin(q*x)`.
fn moments(q: f64) -> (f64, f64) {
    /// Below this, the series is more accurate than the closed form, in which nearly equal numbers cancel.
    const SMALL: f64 = 0.03;
    if q.abs() < SMALL {
        let q2 = q * q;
        return (
            1.0 - q2 / 6.0 + q2 * q2 / 120.0 - q2 * q2 * q2 / 5040.0,
            q / 3.0 * (1.0 - q2 / 10.0 + q2 * q2 / 280.0),
        );
    }
    let (sin, cos) = q.sin_cos();
    (sin / q, (sin / q - cos) / q)
}

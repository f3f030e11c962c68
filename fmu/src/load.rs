//! The load mechanism: the shaft's eccentric mounting hole moves a lever, and spring, damper and preload press the lever on
//! the bearing (Vrublevskyi & Skonieczna 2025, Fig. 1 and 3).
//!
//! The force is `F = i*(F0 + C*x + beta*dx/dt)` with the spring travel `x = k*eps*sin(angle + phase) - x0`. The paper does
//! not give the lever ratio `i`, the travel ratio `k`, the offset `x0` and the phase. They are fitted to the twelve forces
//! of its Table 3, which the law reproduces within the printed digits.
//!
//! The lever presses and cannot pull: where the law has a negative force, it has lifted off.

use serde::{Deserialize, Serialize};

/// The load mechanism's parameters.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Load {
    /// Stiffness C of the elastic element, N/m.
    pub stiffness: f64,
    /// Damping coefficient beta of the elastic element, N.s/m.
    pub damping: f64,
    /// Starting force F0, N.
    pub preload: f64,
    /// Eccentricity eps of the shaft's mounting hole, m. At zero the load is constant.
    pub eccentricity: f64,
    /// Ratio i of the force on the bearing to the force of the elastic element, 1.
    pub lever_ratio: f64,
    /// Ratio k of the elastic element's travel to the eccentric's, 1.
    pub travel_ratio: f64,
    /// Travel x0 by which the elastic element is released at rest, m.
    pub spring_offset: f64,
    /// Angle of the eccentric at shaft angle zero, rad.
    pub phase: f64,
}

impl Default for Load {
    fn default() -> Self {
        Self {
            stiffness: 100.0,
            damping: 14.0,
            preload: 48.0,
            eccentricity: 4.1e-4,
            lever_ratio: 16.621,
            travel_ratio: 15.74,
            spring_offset: 0.03267,
            phase: 88.9_f64.to_radians(),
        }
    }
}

impl Load {
    /// Force on the bearing, N, at a shaft angle (rad) and shaft speed (rad/s); zero while the lever has lifted off.
    pub fn force(&self, angle: f64, speed: f64) -> f64 {
        let (sin, cos) = (angle + self.phase).sin_cos();
        let reach = self.travel_ratio * self.eccentricity;
        let travel = reach * sin - self.spring_offset;
        let travel_rate = reach * cos * speed;
        let force = self.preload + self.stiffness * travel + self.damping * travel_rate;
        (self.lever_ratio * force).max(0.0)
    }

    /// The smallest force of the law in a turn, N, at a shaft speed (rad/s); negative where the lever lifts off.
    pub fn least_force(&self, speed: f64) -> f64 {
        let reach = self.travel_ratio * self.eccentricity;
        // Every step asks: a root takes far fewer instructions than `hypot`, and nothing here overflows.
        let swing = reach * (self.stiffness.powi(2) + (self.damping * speed).powi(2)).sqrt();
        self.lever_ratio * (self.preload - self.stiffness * self.spring_offset - swing.abs())
    }
}

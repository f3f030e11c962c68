//! The result of an interval: forces, torques, flows, and how well the balances close.

use nalgebra::Vector2;

use super::warmth::HeatGiven;

/// The film at the end of an interval, and its means over the interval.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Diagnostics {
    /// External load that the film's pressure carries, N.
    pub film_load: Vector2<f64>,
    /// Rate of the eccentricity ratio, 1/s.
    pub velocity: Vector2<f64>,
    /// Torque with which the film brakes a journal that turns ahead of the bush, N.m.
    pub journal_torque: f64,
    /// Torque with which the film drags the bush along, N.m.
    pub bush_torque: f64,
    /// Largest pressure above that of the bath, Pa.
    pub max_pressure: f64,
    /// Smallest gap, m.
    pub smallest_gap: f64,
    /// How far the mean planes of rough surfaces cross, over the roughness that the film sees, 1; zero where they do not.
    pub crossing: f64,
    /// Contact pressure of [`FilmSettings::asperities`](crate::reynolds::FilmSettings::asperities), integrated over the
    /// surface, N; zero without them.
    pub contact_normal: f64,
    /// Oil that leaves at both ends, m3/s, as volume at ambient pressure.
    pub outflow: f64,
    /// Oil that enters at both ends, m3/s, as volume at ambient pressure.
    pub inflow: f64,
    /// Oil that enters through feeds, m3/s, as volume at ambient pressure; negative where it leaves through them.
    pub feed_flow: f64,
    /// Heat that the film dissipates, W.
    pub heat: f64,
    /// Mean of the journal's torque over the interval, N.m.
    pub mean_journal_torque: f64,
    /// Mean of the heat over the interval, W.
    pub mean_heat: f64,
    /// Mean of the outflow over the interval, m3/s.
    pub mean_outflow: f64,
    /// Mean of the flow through feeds over the interval, m3/s.
    pub mean_feed_flow: f64,
    /// Heat that a film with a temperature of its own gives away, means over the interval.
    pub given: HeatGiven,
    /// Number of internal steps.
    pub steps: usize,
    /// Largest error of an internal step's mass balance over the flow through the film, 1. Zero by definition where mass is
    /// not conserved.
    pub mass_error: f64,
    /// Largest error of an internal step's energy balance over the power through the film, 1.
    pub energy_error: f64,
}

impl Diagnostics {
    /// Adds an internal step of a duration, s. Until [`over`](Self::over), the means are sums over time.
    pub(super) fn add(&mut self, step: Self, duration: f64) {
        let before = *self;
        *self = step;
        self.mean_journal_torque = before.mean_journal_torque + step.journal_torque * duration;
        self.mean_heat = before.mean_heat + step.heat * duration;
        self.mean_outflow = before.mean_outflow + step.outflow * duration;
        self.mean_feed_flow = before.mean_feed_flow + step.feed_flow * duration;
        self.given = before.given.plus(&step.given, duration);
        self.steps = before.steps + 1;
        self.mass_error = before.mass_error.max(step.mass_error);
        self.energy_error = before.energy_error.max(step.energy_error);
    }

    /// Turns the sums over time into means over the interval, s.
    pub(super) fn over(mut self, interval: f64) -> Self {
        if interval > 0.0 {
            self.mean_journal_torque /= interval;
            self.mean_heat /= interval;
            self.mean_outflow /= interval;
            self.mean_feed_flow /= interval;
            self.given = HeatGiven::default().plus(&self.given, 1.0 / interval);
        }
        self
    }
}

//! Means of the sensors over the last whole turn of the load.
//!
//! Turns are counted from the start of the simulation, and anew from the landing of a leap, after which at least one turn is
//! resolved. So the means cost no turns of their own. Until the first turn is complete, the means are those since the start
//! of the count.

use super::{SENSORS, Sensed};
use crate::solver::Passage;
use nalgebra::SVector;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// A turn that lacks no more than this, rad, is complete: sums of times and angles are rounded.
const ROUNDING: f64 = 1e-6;

/// A number for each sensor.
type Each = SVector<f64, SENSORS>;

/// The worst of some time.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Worst {
    /// The largest load, N.
    pub load: f64,
    /// The smallest gap, m.
    pub gap: f64,
    /// The highest temperature of film and bush, K.
    pub temperature: f64,
}

/// Integrals and the worst over the present turn, and the means and the worst over the last one.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct TurnMeans {
    /// The angle by which the shaft has turned since the present turn began, rad.
    turned: f64,
    /// The present turn's duration so far, s.
    duration: f64,
    /// The sensors' integrals over it.
    sums: Each,
    last: Option<Each>,
    /// The worst of the present turn so far, and of the last one.
    worst: [Option<Worst>; 2],
}

impl TurnMeans {
    /// At the beginning of a turn, with known means over the one before.
    pub fn after(last: Sensed) -> Self {
        Self { last: Some(last.into()), ..Self::default() }
    }

    /// The means over the last whole turn, or since the count began. `None` when no time has passed since then.
    pub fn means(&self) -> Option<Sensed> {
        let so_far = || (self.duration > 0.0).then(|| self.sums / self.duration);
        self.last.or_else(so_far).map(Each::into)
    }

    /// The worst of the last whole turn, or since the count began; `None` where nothing was noticed.
    pub fn worst(&self) -> Option<Worst> {
        let [now, last] = self.worst;
        last.or(now)
    }

    /// Takes an instant over into the worst of the present turn.
    pub fn notice(&mut self, at: Worst) {
        let now = self.worst[0].get_or_insert(at);
        now.load = now.load.max(at.load);
        now.gap = now.gap.min(at.gap);
        now.temperature = now.temperature.max(at.temperature);
    }

    /// The same at the beginning of a turn.
    #[must_use]
    pub fn begin_turn(&self) -> Self {
        self.means().map_or_else(Self::default, Self::after)
    }

    /// Counts turns anew.
    pub fn restart(&mut self) {
        *self = Self::default();
    }

    /// Takes over a part of the way, during which the shaft turned by `angle` rad.
    pub fn add(&mut self, passage: &Passage<SENSORS>, angle: f64) {
        let total = self.turned + angle;
        let whole = ((total.abs() + ROUNDING) / TAU).floor();
        let duration = passage.to - passage.from;
        if whole < 1.0 || angle == 0.0 {
            self.turned = total;
            self.duration += duration;
            self.sums += Each::from(passage.integrals);
            return;
        }
        // The speed counts as constant along the part, so that its angle tells the place on it.
        let place = |turns: f64| (((turns * TAU).copysign(total) - self.turned) / angle).clamp(0.0, 1.0);
        let until = |share: f64| Each::from(passage.until(share));
        let end = place(whole);
        let (sums, span) = if whole > 1.0 {
            let begin = place(whole - 1.0);
            (until(end) - until(begin), (end - begin) * duration)
        } else {
            (self.sums + until(end), self.duration + end * duration)
        };
        self.last = Some(sums / span);
        self.worst = [None, self.worst[0]];
        self.turned = total - (whole * TAU).copysign(total);
        self.duration = (1.0 - end) * duration;
        self.sums = until(1.0) - until(end);
    }
}

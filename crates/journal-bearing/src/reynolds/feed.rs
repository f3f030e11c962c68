//! Feeds: grooves and holes in the bush through which oil comes in under pressure.
//!
//! A feed is far deeper than the film, so that the pressure in it is that of the supply, it is always full, and hardly any shear
//! acts in it. Where it ends, the film begins.

use std::f64::consts::{PI, TAU};

use serde::{Deserialize, Serialize};

use super::error::{FilmError, finite, within};

/// The shape of a feed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum FeedShape {
    /// Grooves along the axis, which end within the width.
    #[default]
    Axial,
    /// Round holes, or elliptical ones.
    Hole,
    /// One groove around the whole bush, in the middle of its width.
    Circumferential,
}

/// Feeds of one shape at equal angles, all in the middle of the bush's width.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Feed {
    /// The shape.
    pub shape: FeedShape,
    /// Where the middle of the first one stands, rad, from `x` in the direction of positive rotation.
    pub angle: f64,
    /// Extent around the bush, rad; a circumferential groove has none of its own.
    pub extent: f64,
    /// Length along the axis, m.
    pub length: f64,
    /// How many: one circumferential groove.
    pub count: u32,
    /// Pressure above that of the bath, Pa.
    pub pressure: f64,
}

impl Feed {
    /// Refuses numbers that are out of range in a bearing of this width, m, whose bath has this pressure above the cavities', Pa.
    pub(super) fn check(&self, width: f64, bath: f64) -> Result<(), FilmError> {
        finite("feed angle", self.angle)?;
        let usable = self.length > 0.0 && self.length < width;
        let must = "shorter than the bearing is wide";
        within("feed length", self.length, usable, must)?;
        let (extent, count) = (self.extent, f64::from(self.count));
        if self.shape == FeedShape::Circumferential {
            let must = "1: a circumferential groove goes all around";
            within("number of feeds", count, self.count <= 1, must)?;
        } else {
            let usable = extent > 0.0 && extent < TAU;
            within("feed extent", extent, usable, "between 0 and a turn")?;
            let usable = self.count > 0 && count * extent < TAU;
            let must = "at least 1, and leave room between them";
            within("number of feeds", count, usable, must)?;
        }
        let above = bath + self.pressure;
        let must = "no lower than that of the cavities";
        within("feed pressure", self.pressure, above >= 0.0, must)
    }

    /// The angle from the middle of the nearest feed, rad.
    fn away(&self, theta: f64) -> f64 {
        let pitch = TAU / f64::from(self.count.max(1));
        let angle = theta - self.angle;
        angle - pitch * (angle / pitch).round()
    }

    /// Half its extent, rad, at a distance from the middle of the width, m; negative beyond its length.
    fn reach_around(&self, z: f64) -> f64 {
        let apart = 2.0 * z.abs() / self.length;
        match self.shape {
            _ if apart >= 1.0 => -1.0,
            FeedShape::Axial => 0.5 * self.extent,
            FeedShape::Hole => 0.5 * self.extent * (1.0 - apart * apart).sqrt(),
            FeedShape::Circumferential => PI + 1.0,
        }
    }

    /// Half its length, m, at an angle, rad; negative beyond its extent.
    fn reach_along(&self, theta: f64) -> f64 {
        let apart = 2.0 * self.away(theta).abs() / self.extent;
        match self.shape {
            FeedShape::Circumferential => 0.5 * self.length,
            _ if apart >= 1.0 => -1.0,
            FeedShape::Axial => 0.5 * self.length,
            FeedShape::Hole => 0.5 * self.length * (1.0 - apart * apart).sqrt(),
        }
    }

    /// Whether a place lies in a feed: at an angle, rad, and a distance from the middle of the width, m.
    pub(super) fn covers(&self, theta: f64, z: f64) -> bool {
        self.away(theta).abs() < self.reach_around(z)
    }

    /// The distance around, rad, from a feed's edge to a place beyond it.
    pub(super) fn gap_around(&self, theta: f64, z: f64) -> f64 {
        self.away(theta).abs() - self.reach_around(z)
    }

    /// The distance along the axis, m, from a feed's end to a place beyond it.
    pub(super) fn gap_along(&self, theta: f64, z: f64) -> f64 {
        z.abs() - self.reach_along(theta)
    }
}

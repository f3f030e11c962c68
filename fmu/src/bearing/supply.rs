//! The oil that is fed to the film through grooves or holes in the bush.

use fmu_export::model::Fault;
use journal_bearing::reynolds::{Feed, FeedShape};
use serde::{Deserialize, Serialize};

/// How oil is fed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Feeding {
    /// Not at all: it comes from the bath, at the bearing's ends.
    #[default]
    None,
    /// Through grooves along the axis.
    AxialGrooves,
    /// Through holes.
    Hole,
    /// Through a groove around the bush.
    CircumferentialGroove,
}

/// The feeds in the bush and the oil in them.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Supply {
    /// How oil is fed.
    pub feed: Feeding,
    /// Where the middle of the first feed stands, rad, from the load line in the direction of positive rotation.
    pub angle: f64,
    /// Extent around the bush, rad.
    pub extent: f64,
    /// Length along the axis, m.
    pub length: f64,
    /// How many feeds there are, at equal angles.
    pub count: i32,
    /// Pressure above the bath's, Pa.
    pub pressure: f64,
    /// Temperature of the oil that is fed, K.
    pub temperature: f64,
}

impl Default for Supply {
    /// A groove of 20 degrees opposite the load.
    fn default() -> Self {
        Self {
            feed: Feeding::None,
            angle: std::f64::consts::PI,
            extent: 20f64.to_radians(),
            length: 0.012,
            count: 1,
            pressure: 1e5,
            temperature: 313.15,
        }
    }
}

impl Supply {
    /// Whether oil is fed at all.
    pub fn feeds(&self) -> bool {
        self.feed != Feeding::None
    }

    /// The feeds as the film sees them; none without.
    pub fn in_film(&self) -> Option<Feed> {
        let shape = match self.feed {
            Feeding::None => return None,
            Feeding::AxialGrooves => FeedShape::Axial,
            Feeding::Hole => FeedShape::Hole,
            Feeding::CircumferentialGroove => FeedShape::Circumferential,
        };
        Some(Feed {
            shape,
            angle: self.angle,
            extent: self.extent,
            length: self.length,
            count: self.count.unsigned_abs(),
            pressure: self.pressure,
        })
    }

    /// Refuses feeds to a film that knows none.
    pub fn refuse(&self) -> Result<(), Fault> {
        if !self.feeds() {
            return Ok(());
        }
        Err(Fault::Invalid(format!(
            "bearing.feed = {:?}: the mobility map is that of a plain bush, which no oil is fed to; set bearing.film = Reynolds, or \
             bearing.feed = None",
            self.feed
        )))
    }
}

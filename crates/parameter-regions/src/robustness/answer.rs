//! Whether there is a region that holds the level: found, not found, or none seen anywhere. These are three answers: a
//! search that fails has shown nothing.

use serde::{Deserialize, Serialize};

use super::{Robustness, Stand, TRUSTED, boxes::SEARCHES, region::Region};
use conformity::interval::clopper_pearson;

/// No box is seen where the surrogates give no place as high a probability as this.
const CEILING: f64 = 0.01;

/// Whether there is a box that holds the level.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "answer")]
pub enum BoxAnswer {
    /// A box was found; nothing has been run in it yet.
    #[default]
    Found,
    /// A box was found, and fresh runs of the model inside do not contradict what is stated of it.
    Confirmed,
    /// A box was found, and fresh runs of the model contradict what is stated of it.
    Refuted,
    /// The search found none. That does not show that there is none.
    NotFound {
        /// Places from which it searched.
        searches: usize,
        /// Of the study's own points so many are verified.
        verified: usize,
        /// The highest probability of verification at any sampled place, by the surrogates.
        highest: f64,
    },
    /// The surrogates see none, and none of the study's points is verified.
    NoneSeen {
        /// Places at which the surrogates were asked.
        places: usize,
        /// The highest probability of verification at any of them.
        highest: f64,
        /// The criterion that is met least.
        criterion: String,
        /// The study's points.
        points: usize,
        /// So large a part of the space may be verified, at a confidence of 95 %.
        at_most: f64,
    },
}

impl BoxAnswer {
    /// The answer to a search. None is seen where surrogates that can be trusted leave no place a chance, and none of
    /// the study's points is verified.
    pub(super) fn new(
        result: &Robustness,
        stand: &Stand,
        cloud: &[Vec<f64>],
        verdicts: &[f64],
        verified: &[bool],
    ) -> Self {
        if result.region.is_some() {
            return Self::Found;
        }
        let highest = verdicts.iter().copied().fold(0.0, f64::max);
        let points = verified.len();
        let verified = verified.iter().filter(|ok| **ok).count();
        let mut criteria = result.criteria.iter();
        let trusted = criteria.all(|(_, quality)| quality.predicted >= TRUSTED);
        if trusted && verified == 0 && highest < CEILING {
            return Self::NoneSeen {
                places: cloud.len(),
                highest,
                criterion: stand.least_met(cloud),
                points,
                at_most: clopper_pearson(0.0, points as f64, 0.9)[1],
            };
        }
        Self::NotFound { searches: SEARCHES, verified, highest }
    }

    /// The answer in a line, given whether the statement of the box shows the level.
    pub fn words(&self, shown: bool) -> String {
        let words = match self {
            Self::Found if shown => "a box was found by the surrogates and the study's own points",
            Self::Found => "a box was found that may hold the level, which the study's points cannot show",
            Self::Confirmed => "a box was found, and fresh runs confirm it",
            Self::Refuted => "a box was found, but fresh runs contradict it: verify more points",
            Self::NotFound { .. } => "no box was found by this search; that does not show that there is none",
            Self::NoneSeen { points, at_most, .. } => {
                return format!(
                    "the surrogates see no box; 0 of {points} points met all criteria, up to {:.2} % of the space may",
                    100.0 * at_most
                );
            }
        };
        words.to_owned()
    }

    /// The answer once fresh runs have been made.
    pub fn after(self, region: &Region, level: f64) -> Self {
        match (self, region.fresh) {
            (Self::Found, Some(fresh)) if fresh.interval[1] < level.max(region.interval[0]) => Self::Refuted,
            (Self::Found, Some(fresh)) if fresh.points > 0 => Self::Confirmed,
            (answer, _) => answer,
        }
    }

    /// The remark that the reader needs where there is no box.
    pub(super) fn warning(&self, level: f64) -> Option<String> {
        match self {
            Self::NotFound { searches, verified, highest } => Some(format!(
                "no box with a verification probability of {level} was found from {searches} places; that does not show \
                 that there is none: {verified} of the study's points are verified, and the surrogates give up to \
                 {highest:.3} at a place; verify more points, or ask for a lower level"
            )),
            Self::NoneSeen { places, highest, criterion, .. } => Some(format!(
                "no box with a verification probability of {level} is seen: at none of {places} sampled places do the \
                 surrogates give more than {highest:.3}, and {criterion} is met least; what lies between the points, they \
                 cannot see"
            )),
            _ => None,
        }
    }
}

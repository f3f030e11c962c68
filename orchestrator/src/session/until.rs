//! `--until "ci 0.01"`: as many points as the verified share needs to be known well enough.

use std::str::FromStr;

use crate::results::Tally;
use crate::statistics::wilson;

/// When a study may end before its last point.
#[derive(Clone, Copy, Debug)]
pub struct Until {
    /// The width of the 95 % interval of the verified share.
    width: f64,
}

/// The condition is checked only at multiples of this number of points, so that a chance excursion seldom ends the run.
const ROUND: u64 = 100;

impl Until {
    /// Whether the points so far are enough.
    pub fn holds(self, verified: u64, points: u64) -> bool {
        let [low, high] = wilson(verified, points);
        points > 0 && points.is_multiple_of(ROUND) && high - low <= self.width
    }

    /// Whether the points counted so far are enough.
    pub fn is_met(self, tally: &Tally<'_>) -> bool {
        self.holds(tally.verified(), tally.points())
    }
}

impl FromStr for Until {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let width = text
            .trim()
            .strip_prefix("ci")
            .and_then(|width| width.trim().parse().ok());
        match width {
            Some(width) if width > 0.0 && width < 1.0 => Ok(Self { width }),
            _ => Err(format!(
                "`{text}` is not a width of the interval such as \"ci 0.01\""
            )),
        }
    }
}

/// Follows the points in their order, although they finish in another one.
#[derive(Debug, Default)]
pub struct Front {
    /// Whether each point is verified; `None` while it is not finished.
    seen: Vec<Option<bool>>,
    verified: u64,
    /// The points before this one are finished and counted.
    front: usize,
}

impl Front {
    /// Notes a finished point; says whether the points up to some index are enough.
    pub fn add(&mut self, index: u64, verified: bool, until: Until) -> bool {
        let Ok(index) = usize::try_from(index) else {
            return false;
        };
        if index >= self.seen.len() {
            self.seen.resize(index + 1, None);
        }
        self.seen[index] = Some(verified);
        while let Some(Some(verified)) = self.seen.get(self.front) {
            self.verified += u64::from(*verified);
            self.front += 1;
            if until.holds(self.verified, self.front as u64) {
                return true;
            }
        }
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_order_in_which_points_finish_does_not_matter() {
        let until: Until = "ci 0.2".parse().unwrap();
        let ends = |order: &mut dyn Iterator<Item = u64>| {
            let mut front = Front::default();
            for index in order {
                if front.add(index, index % 3 == 0, until) {
                    break;
                }
            }
            front.front
        };
        let forward = ends(&mut (0..10_000));
        let swapped = ends(&mut (0..10_000).map(|index| index ^ 7));
        assert_eq!(forward, swapped);
        assert_eq!(forward % 100, 0);
        let [low, high] = wilson(forward.div_ceil(3) as u64, forward as u64);
        assert!(high - low <= 0.2);
    }

    #[test]
    fn wrong_widths_are_refused() {
        for wrong in ["0.01", "ci", "ci 0", "ci 2", "ci x"] {
            assert!(wrong.parse::<Until>().is_err());
        }
    }
}

//! Points that are computed twice.
//!
//! Whether an FMU gives the same for the same point is known only of points that were computed twice. Which ones
//! these are depends on the study's seed alone: if chance chose them, two runs of one study could judge the same FMU
//! differently.

use std::collections::BTreeSet;

use serde::{Deserialize, Serialize};

use sampling::random::{self, Purpose, Random};

/// So many points are computed twice where that takes little time: they find 95 % of the FMUs that differ in 5 % of
/// their points.
pub const ENOUGH: usize = 60;

/// The points of a run that are computed twice in any case.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Repeats {
    seed: u64,
    /// The chosen ones, where the number of points is known beforehand.
    chosen: Option<BTreeSet<u64>>,
}

impl Repeats {
    /// Chooses among `count` points of these indexes, which ascend.
    pub fn among(seed: u64, count: u64, mut indexes: impl Iterator<Item = u64>) -> Self {
        let count = usize::try_from(count).unwrap_or(usize::MAX);
        let mut random = Random::new(seed, Purpose::Audit, 0);
        let mut places = BTreeSet::new();
        // Floyd's algorithm (Bentley & Floyd 1987): all sets are equally probable, and no list of all points is needed.
        for last in count.saturating_sub(ENOUGH)..count {
            if !places.insert(random.below(last + 1)) {
                places.insert(last);
            }
        }
        let mut passed = 0;
        let chosen = places.into_iter().map(|place| {
            let index = indexes.nth(place - passed);
            passed = place + 1;
            index.expect("there are as many indexes as the caller says")
        });
        Self { seed, chosen: Some(chosen.collect()) }
    }

    /// Chooses among points whose number is not known: all of the first ones, and fewer and fewer of those that follow.
    pub fn endless(seed: u64) -> Self {
        Self { seed, chosen: None }
    }

    /// Whether a point is chosen.
    pub fn has(&self, index: u64) -> bool {
        match &self.chosen {
            Some(chosen) => chosen.contains(&index),
            // The chance is the share that the first ones have of all points so far.
            None => {
                let share = ENOUGH as f64 / (index as f64 + 1.0);
                (self.rank(index) as f64) < share * u64::MAX as f64
            }
        }
    }

    /// The place of a point in an order that depends on the seed alone.
    pub fn rank(&self, index: u64) -> u64 {
        random::bits(self.seed, Purpose::Audit, index, 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chosen(repeats: &Repeats, points: u64) -> Vec<u64> {
        (0..points).filter(|&index| repeats.has(index)).collect()
    }

    #[test]
    fn sixty_points_of_a_part_are_chosen_by_the_seed() {
        let part = |seed| chosen(&Repeats::among(seed, 1000, (2..).step_by(4)), 5000);
        assert_eq!(part(1).len(), ENOUGH);
        assert!(part(1).iter().all(|index| index % 4 == 2 && *index < 4002));
        assert_eq!(part(1), part(1));
        assert_ne!(part(1), part(2));
        // Of few points all.
        let few = Repeats::among(1, 7, 0..7);
        assert_eq!(chosen(&few, 100), (0..7).collect::<Vec<_>>());
    }

    #[test]
    fn the_first_points_of_many_are_chosen_and_some_of_the_others() {
        let endless = Repeats::endless(1);
        let first = chosen(&endless, 60);
        assert_eq!(first.len(), ENOUGH);
        // Expected: 60 ln(60,000 / 60), give or take 20.
        let others = chosen(&endless, 60_000).len() - first.len();
        assert!((330..500).contains(&others), "{others}");
    }
}

//! Parts of a set of points.

use std::{fmt, str::FromStr};

use serde::{Deserialize, Serialize};

use crate::Header;
use sampling::random::mix;

/// One of several equal parts of the points, as its number among them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Shard {
    /// Number of the part, counted from 1.
    pub number: u64,
    /// How many parts there are.
    pub of: u64,
}

/// The points of a part.
///
/// They are dealt out in rounds, in which each part has a run of neighbours, in an order that the seed shifts in every
/// round. Neighbours spread over the whole space in designs such as Sobol', so that a part has its share of the dear points,
/// wherever these are; and every `of`th point would be a stratum of a parameter there. The shift keeps grids, in which
/// neighbours are alike, from falling into step. What is left after whole rounds is dealt out point by point: the parts
/// differ by one point at most.
#[derive(Clone, Copy, Debug)]
pub struct ShardPart {
    shard: Shard,
    seed: u64,
    points: Option<u64>,
}

/// Points of a run.
const RUN: u64 = 32;

impl ShardPart {
    /// The points of a run that a shard has of it; all of them where it has no shards.
    pub fn of(shard: Option<Shard>, header: &Header) -> Self {
        Self { shard: shard.unwrap_or(Shard { number: 1, of: 1 }), seed: header.seed, points: header.points }
    }

    /// Whether the point of this index belongs to the part.
    pub fn has(&self, index: u64) -> bool {
        let Shard { number, of } = self.shard;
        let (round, place) = match index.checked_sub(self.dealt_in_runs()) {
            None => (index / RUN / of, index / RUN % of),
            Some(rest) => (!(rest / of), rest % of),
        };
        place == self.place(round) && number <= of
    }

    /// How many points belong to the part, where it is known how many there are.
    pub fn count(&self) -> Option<u64> {
        let of = self.shard.of;
        let dealt = self.dealt_in_runs();
        let rest = self.points? - dealt;
        let last = self.place(!(rest / of)) < rest % of;
        Some(dealt / of + rest / of + u64::from(last))
    }

    /// Points in whole rounds of runs.
    fn dealt_in_runs(&self) -> u64 {
        let round = RUN.saturating_mul(self.shard.of);
        self.points.map_or(0, |points| points / round * round)
    }

    /// The part's place in a round.
    fn place(&self, round: u64) -> u64 {
        let Shard { number, of } = self.shard;
        let shift = mix(self.seed ^ mix(round)) % of;
        ((u128::from(number) + u128::from(shift)) % u128::from(of)) as u64
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers = text.split_once('/').and_then(|(a, b)| Some((a.parse().ok()?, b.parse().ok()?)));
        match numbers {
            Some((number, of)) if (1..=of).contains(&number) => Ok(Self { number, of }),
            _ => Err(format!("`{text}` is not a part such as 2/8")),
        }
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{}/{}", self.number, self.of)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards() {
        assert_eq!("2/8".parse(), Ok(Shard { number: 2, of: 8 }));
        for wrong in ["0/8", "9/8", "2", "a/b", "1/0"] {
            assert!(wrong.parse::<Shard>().is_err(), "{wrong}");
        }
    }

    fn part(number: u64, of: u64, points: Option<u64>) -> ShardPart {
        ShardPart { shard: Shard { number, of }, seed: 3, points }
    }

    #[test]
    fn parts_are_disjoint_and_differ_by_one_point_at_most() {
        for (points, of) in (0..200).map(|points| (points, 3)).chain([(1000, 7), (5, 8)]) {
            let parts = (1..=of).map(|number| part(number, of, Some(points)));
            let counted: Vec<u64> = parts.clone().filter_map(|part| part.count()).collect();
            let held = |part: ShardPart| (0..points).filter(|&index| part.has(index)).count() as u64;
            assert_eq!(counted, parts.map(held).collect::<Vec<_>>());
            assert_eq!(counted.iter().sum::<u64>(), points);
            assert!(counted.iter().max() <= counted.iter().min().map(|least| least + 1).as_ref());
        }
        // Where nobody knows how many there will be, too.
        let parts: Vec<ShardPart> = (1..=3).map(|number| part(number, 3, None)).collect();
        let holders = |index| parts.iter().filter(|part| part.has(index)).count();
        assert!((0..1000).all(|index| holders(index) == 1));
        assert!(part(1, 1, None).has(7));
        assert!(!part(1, u64::MAX, Some(7)).has(7) || !part(2, u64::MAX, Some(7)).has(7));
    }

    /// How much longer the slowest of eight parts takes than their mean, where some points are 100 times dearer.
    fn unevenness(is_dear: impl Fn(u64) -> bool) -> f64 {
        const POINTS: u64 = 4096;
        let mut costs = [0.0; 8];
        let parts: Vec<ShardPart> = (1..=8).map(|number| part(number, 8, Some(POINTS))).collect();
        for index in 0..POINTS {
            let holder = parts.iter().position(|part| part.has(index)).unwrap();
            costs[holder] += if is_dear(index) { 100.0 } else { 1.0 };
        }
        costs.iter().copied().fold(0.0, f64::max) * 8.0 / costs.iter().sum::<f64>()
    }

    #[test]
    fn every_part_has_its_share_of_the_points_that_are_dear() {
        for (seed, replicates) in (1..=10).map(|seed| (seed, 1)).chain([(1, 8), (2, 8)]) {
            let points = sampling::design::cube(3, 4096, seed, replicates).unwrap();
            for parameter in [0, 1, 2] {
                let value = |index: u64| points[index as usize][parameter];
                let most = unevenness(|index| value(index) < 0.1).max(unevenness(|index| value(index) > 0.9));
                assert!(most < 1.3, "seed {seed}, parameter {parameter}: {most}");
            }
        }
        // In a grid, one level of the slowest parameter is a block of points, and one of the fastest is every tenth point.
        assert!(unevenness(|index| index < 410) < 1.3);
        assert!(unevenness(|index| index % 10 == 0) < 1.3);
    }
}

//! Parts of a set of points.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

/// One of several equal parts of the points: those with index `number - 1`, `number - 1 + of`, ...
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Shard {
    /// Number of the part, counted from 1.
    pub number: u64,
    /// How many parts there are.
    pub of: u64,
}

impl Shard {
    /// All points as one part.
    pub const WHOLE: Self = Self { number: 1, of: 1 };

    /// Whether the point of this index belongs to the part.
    pub fn has(self, index: u64) -> bool {
        index % self.of == self.number - 1
    }

    /// How many of the first `points` points belong to the part.
    pub fn count(self, points: u64) -> u64 {
        (points + self.of - self.number) / self.of
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parts = text.split_once('/');
        let numbers = parts.and_then(|(a, b)| Some((a.parse().ok()?, b.parse().ok()?)));
        match numbers {
            Some((number, of)) if (1..=of).contains(&number) => Ok(Self { number, of }),
            _ => Err(format!("`{text}` is not a part such as 2/8")),
        }
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
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

    #[test]
    fn parts_are_disjoint_and_counted() {
        for points in 0..20 {
            let parts = (1..=3).map(|number| Shard { number, of: 3 });
            let counted: Vec<u64> = parts.clone().map(|part| part.count(points)).collect();
            let held = |part: Shard| (0..points).filter(|&index| part.has(index)).count() as u64;
            assert_eq!(counted, parts.map(held).collect::<Vec<_>>());
            assert_eq!(counted.iter().sum::<u64>(), points);
        }
    }
}

//! Points that went beyond what the model says it is valid for: how many, and what it says.

use std::{cmp::Reverse, path::Path};

use serde::{Deserialize, Serialize};

use crate::error::Result;
use conformity::conclusion::grouped;
use fmu_import::{
    Description,
    validity::{CATEGORY, alike},
};
use fmu_points::notices::Limit;
use point_journal::Finished;

/// Points that went beyond what the model says it is valid for.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Validity {
    /// How many points.
    pub points: u64,
    /// How many of them meet all criteria.
    pub verified: u64,
    /// The limits that they passed: those that most points passed come first.
    pub limits: Vec<Passed>,
}

/// A limit that points passed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Passed {
    /// How many points.
    pub points: u64,
    /// How many of them meet all criteria.
    pub verified: u64,
    /// The first of them.
    pub first: First,
}

/// The first point that passed a limit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct First {
    /// Name, for people.
    pub point: u64,
    /// The limit, as the FMU says it of this point.
    #[serde(flatten)]
    pub limit: Limit,
}

impl Validity {
    /// No points yet; none where the FMU has no such log category, and nothing is known.
    pub fn of(fmu: &Description) -> Option<Self> {
        let mut categories = fmu.log_categories.iter();
        categories.any(|name| name == CATEGORY).then(Self::default)
    }

    /// A sentence on those of a journal.
    ///
    /// # Errors
    /// When the journal cannot be read.
    pub fn of_journal(fmu: &Description, folder: &Path) -> Result<Option<String>> {
        let Some(mut validity) = Self::of(fmu) else { return Ok(None) };
        let finished = Finished::read(folder)?;
        let mut outcomes = finished.outcomes()?;
        for index in finished.points() {
            let noted = outcomes.get_noted(index)?.and_then(|(_, notices)| notices);
            if let Some(notices) = noted {
                validity.add(index + 1, false, &notices.beyond);
            }
        }
        Ok(validity.told(finished.count, ""))
    }

    /// Counts a point; points come in their order.
    pub fn add(&mut self, point: u64, verified: bool, limits: &[Limit]) {
        const MOST: usize = 32;
        if limits.is_empty() {
            return;
        }
        self.points += 1;
        self.verified += u64::from(verified);
        for limit in limits {
            let message = &limit.message;
            let place =
                self.limits.iter().position(|known| alike(&known.first.limit.message, message)).unwrap_or_else(|| {
                    self.limits.push(Passed { points: 0, verified: 0, first: First { point, limit: limit.clone() } });
                    self.limits.len() - 1
                });
            self.limits[place].points += 1;
            self.limits[place].verified += u64::from(verified);
            self.limits.truncate(MOST);
        }
        self.limits.sort_by_key(|limit| Reverse(limit.points));
    }

    /// A sentence on these points of `all`, where there are any; `which` says which of them stand out.
    pub fn told(&self, all: u64, which: &str) -> Option<String> {
        const NAMED: usize = 3;
        let named: Vec<String> = self
            .limits
            .iter()
            .take(NAMED)
            .map(|limit| {
                let First { point, limit: said } = &limit.first;
                let (said, points) = (said.to_string(), grouped(limit.points));
                let said = said.trim_end_matches('.');
                format!("{said} ({points} of them, the first is point {point})")
            })
            .collect();
        (self.points > 0).then(|| {
            format!(
                "{} of {} points{which} went beyond what the model says it is valid for: {}{}",
                grouped(self.points),
                grouped(all),
                named.join("; "),
                if self.limits.len() > NAMED { "; and more" } else { "" }
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn limit(message: &str) -> Limit {
        Limit { case: None, message: message.to_owned() }
    }

    #[test]
    fn limits_are_counted_by_kind_and_the_most_frequent_come_first() {
        let mut validity = Validity::default();
        assert_eq!(validity.told(3, ""), None);
        validity.add(4, true, &[]);
        validity.add(7, true, &[limit("fast at 1 s"), limit("hot at 2 s.")]);
        validity.add(9, false, &[limit("hot at 3.5 s.")]);
        let told = validity.told(1000, ", one,").unwrap();
        assert_eq!(
            told,
            "2 of 1,000 points, one, went beyond what the model says it is valid for: hot at 2 s (2 of them, the first \
             is point 7); fast at 1 s (1 of them, the first is point 7)"
        );
        assert_eq!((validity.points, validity.verified), (2, 1));
        assert_eq!(validity.limits[0].verified, 1);
        for k in 0..100 {
            validity.add(k, false, &[limit(&format!("limit{k}"))]);
        }
        assert_eq!((validity.points, validity.limits.len()), (102, 32));
        let text = serde_json::to_string(&validity).unwrap();
        assert_eq!(serde_json::from_str::<Validity>(&text).unwrap(), validity);
    }
}

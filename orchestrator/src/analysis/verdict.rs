//! The verdict with its uncertainty: how many points are verified, how sure that fraction is,
//! and which criterion decides.

use super::table::PointTable;

/// The two-sided 95 % point of the standard normal distribution.
pub const Z95: f64 = 1.959_963_984_540_054;

/// A counted fraction with its 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fraction {
    /// How many.
    pub count: usize,
    /// Of how many.
    pub of: usize,
    /// Lower end of the 95 % interval, 0 to 1.
    pub low: f64,
    /// Upper end of the 95 % interval, 0 to 1.
    pub high: f64,
}

impl Fraction {
    /// A fraction of independent trials, with the score interval of Wilson (1927),
    /// "Probable inference, the law of succession, and statistical inference", J. Am. Stat. Assoc. 22.
    /// Of no trials at all the interval is 0 to 1.
    pub fn wilson(count: usize, of: usize) -> Self {
        if of == 0 {
            return Self {
                count,
                of,
                low: 0.0,
                high: 1.0,
            };
        }
        let (n, p, z2) = (of as f64, count as f64 / of as f64, Z95 * Z95);
        let centre = (p + z2 / (2.0 * n)) / (1.0 + z2 / n);
        let half = Z95 / (1.0 + z2 / n) * (p * (1.0 - p) / n + z2 / (4.0 * n * n)).sqrt();
        Self {
            count,
            of,
            low: if count == 0 {
                0.0
            } else {
                (centre - half).max(0.0)
            },
            high: if count == of {
                1.0
            } else {
                (centre + half).min(1.0)
            },
        }
    }

    /// The fraction itself; 0 of no trials.
    pub fn value(&self) -> f64 {
        if self.of == 0 {
            0.0
        } else {
            self.count as f64 / self.of as f64
        }
    }
}

/// What one criterion did to the points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CriterionVerdict {
    /// Points that meet it.
    pub passes: Fraction,
    /// Points at which it deviates most of all criteria, in units of the tolerances.
    pub binds: usize,
    /// Points that fail this criterion and no other: verified, were it not for this one.
    pub only_failure: usize,
    /// Median deviation, in units of the tolerance, of the points that fail it.
    pub median_miss: Option<f64>,
}

/// What happened to the points as a whole.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// Points that meet all criteria.
    pub verified: Fraction,
    /// Points that were not simulated to their end; they count as not verified.
    pub failed: usize,
    /// One a criterion.
    pub criteria: Vec<CriterionVerdict>,
    /// Passes of all criteria of a group, by group name.
    pub groups: Vec<(String, Fraction)>,
}

/// Counts a table of points.
pub fn verdict(table: &PointTable) -> Verdict {
    let n = table.len();
    let count =
        |passes: &dyn Fn(usize) -> bool| Fraction::wilson((0..n).filter(|&i| passes(i)).count(), n);
    let groups = table
        .groups()
        .into_iter()
        .map(|group| {
            let members: Vec<_> = table
                .criteria
                .iter()
                .filter(|c| c.group.as_deref() == Some(group))
                .collect();
            (
                group.to_owned(),
                count(&|i| members.iter().all(|c| c.ok[i])),
            )
        })
        .collect();
    let bindings: Vec<_> = (0..n).map(|i| table.binding(i)).collect();
    let criteria = (0..table.criteria.len())
        .map(|k| criterion_verdict(table, k, &bindings, count(&|i| table.criteria[k].ok[i])))
        .collect();
    Verdict {
        verified: count(&|i| table.verified[i]),
        failed: (0..n).filter(|&i| !table.completed(i)).count(),
        criteria,
        groups,
    }
}

fn criterion_verdict(
    table: &PointTable,
    k: usize,
    bindings: &[Option<super::table::Binding>],
    passes: Fraction,
) -> CriterionVerdict {
    let c = &table.criteria[k];
    let mut misses: Vec<f64> = (0..table.len())
        .filter(|&i| !c.ok[i])
        .map(|i| c.deviation(c.values[i]))
        .filter(|d| !d.is_nan())
        .collect();
    misses.sort_by(f64::total_cmp);
    let only_failure = (0..table.len())
        .filter(|&i| table.completed(i) && !c.ok[i])
        .filter(|&i| {
            table
                .criteria
                .iter()
                .enumerate()
                .all(|(j, other)| j == k || other.ok[i])
        })
        .count();
    CriterionVerdict {
        passes,
        binds: bindings
            .iter()
            .flatten()
            .filter(|b| b.criterion == k)
            .count(),
        only_failure,
        median_miss: misses.get(misses.len() / 2).copied(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Newcombe (1998), "Two-sided confidence intervals for the single proportion", table I.
    #[test]
    fn wilson_matches_published_values() {
        for (count, of, low, high) in [
            (81, 263, 0.2553, 0.3662),
            (15, 148, 0.0624, 0.1605),
            (0, 20, 0.0, 0.1611),
            (1, 29, 0.0061, 0.1718),
        ] {
            let f = Fraction::wilson(count, of);
            assert!((f.low - low).abs() < 5e-5, "{f:?}");
            assert!((f.high - high).abs() < 5e-5, "{f:?}");
        }
    }

    #[test]
    fn wilson_at_the_ends() {
        assert_eq!(Fraction::wilson(7, 7).high, 1.0);
        assert_eq!(
            Fraction::wilson(0, 0),
            Fraction {
                count: 0,
                of: 0,
                low: 0.0,
                high: 1.0
            }
        );
    }
}

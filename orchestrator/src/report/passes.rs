//! The verdict with its uncertainty: how many points are verified, how sure that fraction is,
//! and which criterion decides.

use parameter_regions::table::PointTable;
use sampling::statistics::share::Fraction;

/// How many points one criterion accepts and rejects.
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

/// Counts over all points.
#[derive(Clone, Debug, PartialEq)]
pub struct PassCounts {
    /// Points that meet all criteria.
    pub verified: Fraction,
    /// Points that were not simulated to their end; they count as not verified.
    pub failed: usize,
    /// One interval per criterion.
    pub criteria: Vec<CriterionVerdict>,
    /// Passes of all criteria of a group, by group name.
    pub groups: Vec<(String, Fraction)>,
}

/// Counts a table of points.
pub fn verdict(table: &PointTable) -> PassCounts {
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
    PassCounts {
        verified: count(&|i| table.verified[i]),
        failed: (0..n).filter(|&i| !table.completed(i)).count(),
        criteria,
        groups,
    }
}

fn criterion_verdict(
    table: &PointTable,
    k: usize,
    bindings: &[Option<parameter_regions::table::Binding>],
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
    use parameter_regions::table::CriterionColumn;

    /// A criterion of 10 ± 2, in a group or in none.
    fn ten(name: &str, group: Option<&str>, values: [f64; 6]) -> CriterionColumn {
        CriterionColumn {
            name: name.into(),
            source: String::new(),
            unit: String::new(),
            nominal: 10.0,
            lower: 8.0,
            upper: 12.0,
            group: group.map(String::from),
            ok: values.map(|v| (8.0..=12.0).contains(&v)).to_vec(),
            values: values.to_vec(),
        }
    }

    #[test]
    fn points_are_counted_by_what_they_meet_and_what_fails_them() {
        const LOST: f64 = f64::NAN;
        let table = PointTable {
            ids: (1..=6).collect(),
            criteria: vec![
                ten("a", Some("both"), [10.0, 13.0, 14.0, LOST, 10.0, 15.0]),
                ten("b", Some("both"), [10.0, 10.0, 16.0, LOST, 10.0, 10.0]),
                ten("c", None, [10.0, 10.0, 10.0, LOST, 5.0, 10.0]),
            ],
            verified: vec![true, false, false, false, false, false],
            status: ["ok", "ok", "ok", "crash", "ok", "ok"]
                .map(Into::into)
                .to_vec(),
            ..PointTable::default()
        };
        let of_six = |count| Fraction::wilson(count, 6);
        let criterion = |passes, binds, only_failure, median_miss| CriterionVerdict {
            passes: of_six(passes),
            binds,
            only_failure,
            median_miss: Some(median_miss),
        };
        let expected = PassCounts {
            verified: of_six(1),
            failed: 1,
            // Where all deviations are equal, the first criterion binds.
            criteria: vec![
                criterion(2, 3, 2, 2.0),
                criterion(4, 1, 0, 3.0),
                criterion(4, 1, 1, 2.5),
            ],
            groups: vec![("both".to_owned(), of_six(2))],
        };
        assert_eq!(verdict(&table), expected);
    }
}

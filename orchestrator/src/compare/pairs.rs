//! The points of two tables, paired by their numbers.

use std::collections::{HashMap, HashSet};

use parameter_regions::table::PointTable;

/// The points of two tables.
#[derive(Default)]
pub struct Pairs {
    /// The rows of points with the same number and the same parameters, in the order of the old table.
    pub both: Vec<[usize; 2]>,
    /// The numbers of points of the old table alone.
    pub only_old: Vec<u64>,
    /// The numbers of points of the new table alone.
    pub only_new: Vec<u64>,
    /// The numbers of points with other parameters.
    pub other_parameters: Vec<u64>,
}

impl Pairs {
    pub fn new(old: &PointTable, new: &PointTable) -> Self {
        let named = |table: &PointTable| -> HashMap<(String, String), usize> {
            table
                .parameters
                .iter()
                .enumerate()
                .map(|(k, column)| ((column.name.clone(), column.unit.clone()), k))
                .collect()
        };
        let (theirs, ours) = (named(old), named(new));
        // What `judge` has read says nothing of parameters: there the number alone tells a point.
        let is_judged = theirs.is_empty() || ours.is_empty();
        let same_columns = is_judged || theirs.len() == ours.len() && theirs.keys().all(|name| ours.contains_key(name));
        let columns: Vec<[usize; 2]> = theirs.iter().filter_map(|(name, k)| Some([*k, *ours.get(name)?])).collect();
        let rows: HashMap<u64, usize> = new.ids.iter().copied().zip(0..).collect();
        let mut pairs = Self::default();
        for (i, id) in old.ids.iter().copied().enumerate() {
            let Some(&j) = rows.get(&id) else {
                pairs.only_old.push(id);
                continue;
            };
            if same_columns
                && columns.iter().all(|[k, l]| {
                    let [a, b] = [old.parameters[*k].values[i], new.parameters[*l].values[j]];
                    super::is_rounding(a, b, 0.0)
                })
            {
                pairs.both.push([i, j])
            } else {
                pairs.other_parameters.push(id)
            }
        }
        let known: HashSet<&u64> = old.ids.iter().collect();
        pairs.only_new = new.ids.iter().filter(|id| !known.contains(id)).copied().collect();
        pairs
    }
}

//! Value references. Tools store them, so a variable keeps its own for good: `references.txt` names the variables in the
//! order of their references, and may only grow at its end.

use super::declare::V;

/// The file with the names, a line each.
pub const FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/src/variables/references.txt");

const NAMES: &str = include_str!("references.txt");

/// The variables by reference, and the order in which they are listed.
pub(super) struct Table {
    pub(super) variables: Vec<V>,
    pub(super) listing: Vec<usize>,
}

impl Table {
    /// Orders variables, which come in the order of their listing, by their references. One that the file does not name
    /// yet comes after those that it names.
    pub(super) fn new(listed: Vec<V>) -> Self {
        let named: Vec<&str> = NAMES.lines().collect();
        let key = |name: &str| {
            named
                .iter()
                .position(|known| *known == name)
                .unwrap_or(named.len())
        };
        let mut order: Vec<(usize, V)> = listed.into_iter().enumerate().collect();
        // Stable: variables that the file does not name stay in the order of the listing.
        order.sort_by_key(|(_, variable)| key(variable.name));
        let mut listing = vec![0; order.len()];
        for (reference, (place, _)) in order.iter().enumerate() {
            listing[*place] = reference;
        }
        let variables = order.into_iter().map(|(_, variable)| variable).collect();
        Self { variables, listing }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{listing, table};
    use super::*;

    /// The number of references of version 0.1.0, and the checksum of their names.
    const RELEASED: (usize, u32) = (82, 3_726_519_035);

    #[test]
    fn every_variable_has_a_reference_of_its_own() {
        let names: Vec<_> = table().iter().map(|variable| variable.name).collect();
        let committed: Vec<_> = NAMES.lines().collect();
        assert_eq!(
            names, committed,
            "run `cargo run -p plain-bearing-stand --bin model-description`; a variable that was released must stay"
        );
    }

    #[test]
    fn released_references_have_not_changed() {
        let (count, checksum) = RELEASED;
        let released: Vec<_> = NAMES.lines().take(count).collect();
        assert_eq!(released.len(), count);
        assert_eq!(crc32fast::hash(released.join("\n").as_bytes()), checksum);
    }

    #[test]
    fn variables_are_listed_in_their_groups() {
        let names = listing().iter().map(|reference| table()[*reference].name);
        let groups = names.map(|name| name.split('.').next().unwrap_or(name));
        let mut runs: Vec<_> = groups.collect();
        runs.dedup();
        // Inputs, then the parameters of each block, then outputs.
        assert_eq!(
            runs[3..9],
            ["drive", "load", "bearing", "oil", "thermal", "solver"],
            "{runs:?}"
        );
    }
}

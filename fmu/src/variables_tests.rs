use fmu_export::model::{Access, Kind};
use plain_bearing_stand::{
    stand::Stand,
    variables::{listing, table},
};

#[test]
fn what_is_set_is_read_back() {
    let mut stand = Stand::default();
    for variable in table() {
        let Kind::Real(real) = &variable.kind else {
            continue;
        };
        if let Access { get, set: Some(set) } = real.access {
            let other = get(&stand) * 1.5 + 1e-3;
            set(&mut stand, &other);
            assert_eq!(get(&stand), other, "{}", variable.name);
        }
    }
}

/// The number of references of version 0.1.0, and the checksum of their names.
const RELEASED: (usize, u32) = (82, 3_726_519_035);

#[test]
fn every_variable_has_a_reference_of_its_own() {
    let mut references = listing().to_vec();
    references.sort_unstable();
    assert!(references.into_iter().eq(0..table().len()));
}

#[test]
fn released_references_have_not_changed() {
    let (count, checksum) = RELEASED;
    let names = table().iter().map(|variable| variable.name);
    let released: Vec<_> = names.take(count).collect();
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
    assert_eq!(runs[4..10], ["drive", "load", "bearing", "oil", "thermal", "solver"], "{runs:?}");
}

//! Saved states.

use crate::host::{Error, Host, Ok};

#[test]
fn saved_states_continue_bit_for_bit() {
    let host = Host::started();
    let run = |host: &Host| {
        for i in 2..20 {
            assert_eq!(host.step(f64::from(i) / 10.0, 0.1), Ok);
        }
        host.get("output").to_bits()
    };
    assert_eq!([host.set("input", 0.3), host.step(0.0, 0.2)], [Ok; 2]);
    let state = host.save();
    let bytes = host.bytes(state);
    let end = run(&host);
    assert_eq!(host.restore(state), Ok);
    assert_eq!(run(&host), end);
    let other = Host::new();
    let copy = other.state_of(&bytes).unwrap();
    assert_eq!(other.restore(copy), Ok);
    assert_eq!(run(&other), end);
    assert_eq!([host.free(state), other.free(copy)], [Ok; 2]);
}

#[test]
fn states_of_the_initialization_are_whole() {
    let host = Host::new();
    assert_eq!([host.enter(), host.set("initialState", 5.0)], [Ok; 2]);
    let state = host.save();
    let bytes = host.bytes(state);
    assert_eq!([host.free(state), host.reset()], [Ok; 2]);
    let state = host.state_of(&bytes).unwrap();
    assert_eq!([host.restore(state), host.set("gain", 1.0), host.exit(), host.free(state)], [Ok; 4]);
    assert_eq!(host.get("output"), 5.0);
}

#[test]
fn damaged_states_are_refused() {
    let host = Host::started();
    let state = host.save();
    let bytes = host.bytes(state);
    assert_eq!(host.free(state), Ok);
    for length in 0..bytes.len() {
        assert_eq!(host.state_of(&bytes[..length]), Err(Error), "cut at {length}");
    }
    for place in 0..bytes.len() {
        let mut damaged = bytes.clone();
        damaged[place] ^= 0x10;
        assert_eq!(host.state_of(&damaged), Err(Error), "damaged at {place}");
    }
    let longer = [bytes.as_slice(), &[0]].concat();
    assert_eq!(host.state_of(&longer), Err(Error));
    assert_eq!(host.step(0.0, 0.1), Ok, "still usable");
}

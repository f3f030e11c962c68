//! Random sequences of calls of the C functions of FMI 3.0, with random and hostile arguments: NULL, what is not a
//! number, counts of 0 and beyond all memory, counts that contradict each other, foreign handles, functions out of turn,
//! functions for what the FMU does not offer, damaged and forged states, calls from within the logger.
//!
//! Required: no crash; no panic (it would end in `fmi3Fatal`); values that are read are finite; a call that is refused
//! changes nothing; a state that is restored or read again is the same, byte for byte.
//!
//! The long run, with a report: `cargo test -p plain-bearing-stand --test fuzz3 -- --ignored --nocapture` (optimised, with all
//! checks of the arithmetic on). `FUZZ_CALLS` and `FUZZ_SEED` set its length and its seed; `scripts/test --long` draws a
//! seed.

mod absent;
mod acts;
mod host;
#[path = "../fuzz/random.rs"]
mod random;
#[path = "../fuzz/states.rs"]
mod states;
mod values;

use host::Host;

fn run(calls: u64, seed: u64) {
    let mut host = Host::new(seed);
    while host.calls < calls {
        acts::act(&mut host);
    }
    host.finish();
}

/// Seeds of the ordinary run, which is the same every time. A seed that fails in a long run joins them.
const SEEDS: [u64; 1] = [1];

#[test]
fn random_calls_are_answered_as_the_standard_says() {
    for seed in SEEDS {
        run(30_000, seed);
    }
}

fn from_environment(name: &str, otherwise: u64) -> u64 {
    std::env::var(name).map_or(otherwise, |text| text.parse().expect(name))
}

#[test]
#[ignore = "ten million calls take many minutes: scripts/test --long"]
fn ten_million_random_calls() {
    let seed = from_environment("FUZZ_SEED", 2);
    println!("calls chosen by FUZZ_SEED={seed}");
    run(from_environment("FUZZ_CALLS", 10_000_000), seed);
}

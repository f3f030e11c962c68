//! Random sequences of calls of the C functions of FMI 2.0 and 3.0, for Co-Simulation and Model Exchange, with random and
//! hostile arguments: NULL, what is not a number, counts of 0 and beyond all memory, counts that contradict each other, foreign
//! handles, functions out of turn or of the other interface, functions for what the FMU does not offer, damaged and forged
//! states, calls from within the logger.
//!
//! Required: no crash; no panic (it would end in a fatal status); values that are read are finite; a call that is refused
//! changes nothing; a state that is restored or read again is the same, byte for byte.
//!
//! The long runs, with a report: `cargo test -p plain-bearing-stand --test fuzz -- --ignored --nocapture` (optimised, with all
//! checks of the arithmetic on). `FUZZ_CALLS` and `FUZZ_SEED` set their length and their seed; `scripts/test --long` draws a
//! seed.

mod absent;
mod exchange;
mod host;
mod random;
mod states;
mod three;
mod two;
mod values;

use std::time::Duration;

use host::{Host, Interface, Kinds};

fn run(interface: &'static Interface, kinds: Kinds, calls: u64, seed: u64, patience: Duration) {
    let mut host = Host::new(interface, kinds, seed, patience);
    while host.calls < calls {
        host.act();
    }
    host.finish();
}

/// Seeds of the ordinary run, which is the same every time, whatever the machine's load: it waits for every call. A seed that
/// fails in a long run joins them.
const SEEDS: [u64; 1] = [1];

#[test]
fn random_calls_of_fmi_2_are_answered_as_the_standard_says() {
    for seed in SEEDS {
        run(&two::INTERFACE, Kinds::Both, 30_000, seed, Duration::MAX);
    }
}

#[test]
fn random_calls_of_fmi_3_are_answered_as_the_standard_says() {
    for seed in SEEDS {
        run(&three::INTERFACE, Kinds::Both, 30_000, seed, Duration::MAX);
    }
}

fn from_environment(name: &str, otherwise: u64) -> u64 {
    std::env::var(name).map_or(otherwise, |text| text.parse().expect(name))
}

fn ten_million(interface: &'static Interface, kinds: Kinds) {
    let seed = from_environment("FUZZ_SEED", 2);
    println!("calls chosen by FUZZ_SEED={seed}");
    run(interface, kinds, from_environment("FUZZ_CALLS", 10_000_000), seed, Duration::from_secs(1));
}

#[test]
#[ignore = "ten million calls take many minutes: scripts/test --long"]
fn ten_million_calls_of_fmi_2_co_simulation() {
    ten_million(&two::INTERFACE, Kinds::CoSimulation);
}

#[test]
#[ignore = "ten million calls take many minutes: scripts/test --long"]
fn ten_million_calls_of_fmi_2_model_exchange() {
    ten_million(&two::INTERFACE, Kinds::ModelExchange);
}

#[test]
#[ignore = "ten million calls take many minutes: scripts/test --long"]
fn ten_million_calls_of_fmi_3_co_simulation() {
    ten_million(&three::INTERFACE, Kinds::CoSimulation);
}

#[test]
#[ignore = "ten million calls take many minutes: scripts/test --long"]
fn ten_million_calls_of_fmi_3_model_exchange() {
    ten_million(&three::INTERFACE, Kinds::ModelExchange);
}

//! Links the program to a fixed address, where the system lets it: a fork of a worker copies whatever a loader had to relocate.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    let target = ["OS", "ENV"].map(|part| std::env::var(format!("CARGO_CFG_TARGET_{part}")).unwrap_or_default());
    if target == ["linux", "gnu"] {
        println!("cargo::rustc-link-arg-bins=-no-pie");
    }
}

//! Linker settings of the FMU's binary.

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    let target = std::env::var("CARGO_CFG_TARGET_OS").unwrap_or_default();
    if target == "linux" {
        // A host may unload an FMU while its threads still hold Rust's thread-local destructors:
        // keep the code in place (rust-lang/rust issues 91979 and 134820).
        println!("cargo:rustc-cdylib-link-arg=-Wl,-z,nodelete");
    }
}

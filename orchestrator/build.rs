//! Compiles the one function that Rust cannot define: the C-variadic logger callback.

fn main() {
    println!("cargo::rerun-if-changed=src/fmu/logger.c");
    cc::Build::new()
        .file("src/fmu/logger.c")
        .compile("orchestrator_logger");
}

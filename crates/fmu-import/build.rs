//! Compiles the one function that Rust cannot define: the C-variadic logger callback.

fn main() {
    println!("cargo::rerun-if-changed=src/logger.c");
    cc::Build::new().file("src/logger.c").compile("fmu_import_logger");
}

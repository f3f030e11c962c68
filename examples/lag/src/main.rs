//! Packs the lag into an FMU: `cargo run -p lag`.

fmu_export::package!(lag::Lag);

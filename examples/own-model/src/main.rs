//! Packs the tank into an FMU: `cargo run -p own-model`.

fmu_export::package!(own_model::Tank);

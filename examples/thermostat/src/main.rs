//! Packs the thermostat into an FMU: `cargo run -p thermostat -- --fmi 3 --exchange`.

fmu_export::package!(thermostat::House);

//! Writes `modelDescription/modelDescription.xml` from the stand's variable table.

use std::path::Path;
use std::process::ExitCode;

use plain_bearing_stand::fmi2::description;
use plain_bearing_stand::stand::Stand;

fn main() -> ExitCode {
    let path =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../modelDescription/modelDescription.xml");
    match std::fs::write(&path, description::xml::<Stand>()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{}: {error}", path.display());
            ExitCode::FAILURE
        }
    }
}

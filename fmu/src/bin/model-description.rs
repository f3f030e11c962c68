//! Writes what of `modelDescription/` follows from the stand's variable table: `modelDescription.xml`
//! and the documentation page.

use std::path::Path;
use std::process::ExitCode;

use fmu_export::fmi2::description;
use plain_bearing_stand::documentation;
use plain_bearing_stand::stand::Stand;

fn main() -> ExitCode {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../modelDescription");
    for (name, text) in [
        ("modelDescription.xml", description::xml::<Stand>()),
        ("documentation/index.html", documentation::page()),
    ] {
        let path = folder.join(name);
        if let Err(error) = std::fs::write(&path, text) {
            eprintln!("{}: {error}", path.display());
            return ExitCode::FAILURE;
        }
    }
    ExitCode::SUCCESS
}

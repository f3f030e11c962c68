//! Writes the files that follow from the stand's variable table: the value references of new variables,
//! the model descriptions and the documentation page.

use std::path::Path;
use std::process::ExitCode;

use fmu_export::{fmi2, fmi3};
use plain_bearing_stand::stand::Stand;
use plain_bearing_stand::{documentation, variables};

fn main() -> ExitCode {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../modelDescription");
    let names = variables::table().iter().map(|variable| variable.name);
    for (path, text) in [
        (
            variables::REFERENCES.into(),
            names.fold(String::new(), |text, name| text + name + "\n"),
        ),
        (
            folder.join("modelDescription.xml"),
            fmi2::description::xml::<Stand>(),
        ),
        (
            Path::new(env!("CARGO_MANIFEST_DIR")).join("descriptions/fmi3.xml"),
            fmi3::description::xml::<Stand>(),
        ),
        (
            Path::new(env!("CARGO_MANIFEST_DIR")).join("descriptions/me.xml"),
            fmi2::description::exchange_xml::<Stand>(),
        ),
        (
            Path::new(env!("CARGO_MANIFEST_DIR")).join("descriptions/me-fmi3.xml"),
            fmi3::description::exchange_xml::<Stand>(),
        ),
        (
            folder.join("documentation/index.html"),
            documentation::page(),
        ),
    ] {
        if let Err(error) = std::fs::write(&path, text) {
            eprintln!("{}: {error}", path.display());
            return ExitCode::FAILURE;
        }
    }
    ExitCode::SUCCESS
}

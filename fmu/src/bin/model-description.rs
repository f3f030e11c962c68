//! Writes the files that follow from the stand's variable table: the value references of new variables,
//! the model descriptions and the documentation page.

use std::path::Path;
use std::process::ExitCode;

use fmu_export::{fmi2, fmi3};
use plain_bearing_stand::stand::Stand;
use plain_bearing_stand::{documentation, variables};

fn main() -> ExitCode {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let names = variables::table().iter().map(|variable| variable.name);
    let references = names.fold(String::new(), |text, name| text + name + "\n");
    let packed = "../modelDescription";
    for (path, text) in [
        (variables::REFERENCES.to_owned(), references),
        (
            format!("{packed}/modelDescription.xml"),
            fmi2::description::xml::<Stand>(),
        ),
        (
            "descriptions/fmi3.xml".to_owned(),
            fmi3::description::xml::<Stand>(),
        ),
        (
            "descriptions/me.xml".to_owned(),
            fmi2::description::exchange_xml::<Stand>(),
        ),
        (
            "descriptions/me-fmi3.xml".to_owned(),
            fmi3::description::exchange_xml::<Stand>(),
        ),
        (
            format!("{packed}/documentation/index.html"),
            documentation::page(),
        ),
    ] {
        let path = here.join(path);
        if let Err(error) = std::fs::write(&path, text) {
            eprintln!("{}: {error}", path.display());
            return ExitCode::FAILURE;
        }
    }
    ExitCode::SUCCESS
}

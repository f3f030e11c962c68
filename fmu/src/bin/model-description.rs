//! Writes the files that follow from the stand's variable table: the model descriptions and the documentation page.

use std::{path::Path, process::ExitCode};

use fmu_export::description::{self, Interface, Version};
use plain_bearing_stand::{documentation, stand::Stand};

fn main() -> ExitCode {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let packed = "../modelDescription";
    for (path, text) in [
        (format!("{packed}/modelDescription.xml"), description::xml::<Stand>(Version::Two, Interface::CoSimulation)),
        ("descriptions/fmi3.xml".to_owned(), description::xml::<Stand>(Version::Three, Interface::CoSimulation)),
        ("descriptions/me.xml".to_owned(), description::xml::<Stand>(Version::Two, Interface::ModelExchange)),
        ("descriptions/me-fmi3.xml".to_owned(), description::xml::<Stand>(Version::Three, Interface::ModelExchange)),
        (format!("{packed}/documentation/index.html"), documentation::page()),
    ] {
        let path = here.join(path);
        if let Err(error) = std::fs::write(&path, text) {
            eprintln!("{}: {error}", path.display());
            return ExitCode::FAILURE;
        }
    }
    ExitCode::SUCCESS
}

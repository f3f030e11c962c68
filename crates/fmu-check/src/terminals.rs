//! The version in `terminalsAndIcons.xml`, which must be that of the description.

use std::str;

use crate::hit::{Breach, Hit};
use fmu_import::{FmuError, Package, xml};

const TERMINALS: &str = "terminalsAndIcons/terminalsAndIcons.xml";
/// The file is short; a tree of elements takes many times its text's memory.
const LARGEST: usize = 1_000_000;

/// The breach in the file, if it is there.
pub(crate) fn broken(package: &mut Package) -> Result<Option<Breach>, FmuError> {
    if !package.entries().iter().any(|entry| entry == TERMINALS) {
        return Ok(None);
    }
    let version = package.description().fmi_version.clone();
    let text = match package.bytes_of(TERMINALS) {
        Ok(bytes) if bytes.len() > LARGEST => Some(format!("longer than {LARGEST} bytes, and not looked at")),
        Ok(bytes) => match str::from_utf8(&bytes).map(xml::parse) {
            Ok(Ok(document)) => {
                let theirs = document.root_element().attribute("fmiVersion").unwrap_or_default();
                (theirs != version).then(|| {
                    format!("fmiVersion is \"{theirs}\" here and \"{version}\" in modelDescription.xml: write the same")
                })
            }
            Ok(Err(error)) => Some(error.to_string()),
            Err(error) => Some(error.to_string()),
        },
        Err(FmuError { fault, .. }) if fault.is_in_fmu() => Some(fault.to_string()),
        Err(error) => return Err(error),
    };
    Ok(text.map(|text| ("terminals-version", Hit::of(TERMINALS, text))))
}

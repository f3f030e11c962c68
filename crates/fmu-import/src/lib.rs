#![doc = include_str!("../README.md")]

pub mod archive;
mod call;
mod caller;
mod component;
mod decode;
pub mod description;
mod exchange;
mod floating_point;
mod fmi2;
mod fmi3;
mod instance;
pub mod isolation;
mod library;
mod logger;
pub mod needed;
mod package;
mod parse;
pub mod quantity;
mod simulation;
mod symbols;
pub mod units;
pub mod validity;
mod value;
mod version;
pub mod xml;

pub use archive::ArchiveError;
pub use call::{Call, Called, EarlyEnd, Status, Warnings};
pub use description::{Causality, Description, Interface, Kind, Remark, StoragePlace, Variability, Variable};
pub use instance::Instance;
pub use library::{Library, LibraryError, percent_encoded};
pub use logger::locked;
pub use package::{FmuError, FmuFault, Package, digest, sha256};
pub use parse::DescriptionError;
pub use value::{Content, Handle, Value, bytes_of, hexadecimal};
pub use version::Version;
pub use xml::XmlError;

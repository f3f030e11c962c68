#![doc = include_str!("../README.md")]

pub mod archive;
pub mod call;
mod decode;
pub mod description;
mod directory;
mod floating_point;
pub mod instance;
pub mod isolation;
pub mod library;
mod logger;
pub mod needed;
pub mod package;
mod parse;
pub mod state;
pub mod steps;
pub mod units;
pub mod value;

pub use archive::ArchiveError;
pub use call::{Call, End, Status, Warnings};
pub use description::{Causality, Description, Kind, Remark, Variability, Variable};
pub use instance::Instance;
pub use library::{Library, LibraryError};
pub use package::{FmuError, Package, digest};
pub use parse::DescriptionError;
pub use state::{State, StateError};
pub use value::{Content, Handle, Value};

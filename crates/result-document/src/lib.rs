#![doc = include_str!("../README.md")]

pub mod bins;
mod document;
pub mod format;
mod html;
pub mod svg;
mod text;

pub use document::{Block, Column, Document, Figure, Key, Table, numbers, words};
pub use html::{html, marked};
pub use text::{text, wrapped};

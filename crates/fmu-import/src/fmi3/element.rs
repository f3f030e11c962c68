//! Where the elements of variables of FMI 3.0 are in a binary.

use std::sync::Arc;

use crate::{
    call::{Call, Called},
    description::{Description, Storage},
    value::Value,
};

/// An element of a variable: its place in the binary, and its start value where the description has one.
#[derive(Clone, Debug)]
pub struct Element {
    /// The value reference of the variable.
    pub reference: u32,
    pub storage: Storage,
    /// Its index in the array.
    pub index: usize,
    /// How many elements the array has.
    pub of: usize,
    pub start: Option<Value>,
}

impl Element {
    /// The elements of all variables, by their numbers.
    pub fn all(description: &Description) -> Arc<[Self]> {
        let mut all: Vec<Self> = Vec::new();
        for variable in description.variables.values() {
            let Some(place) = variable.place else { continue };
            let element = Self {
                reference: variable.value_reference,
                storage: place.storage,
                index: place.index,
                of: place.of,
                start: variable.kind.start_value(),
            };
            let number = place.number as usize;
            // Variables that could not be used leave gaps, which nobody reaches.
            if all.len() <= number {
                all.resize(number + 1, element.clone());
            }
            all[number] = element;
        }
        all.into()
    }

    /// The element of a number.
    pub fn of(elements: &[Self], number: u32) -> Called<&Self> {
        elements
            .get(number as usize)
            .ok_or_else(|| Call::impossible("fmi3Get", format!("there is no element {number}")))
    }

    /// Whether it is a number of 64 bits by itself, of which one call reads several.
    pub fn is_plain(&self) -> bool {
        self.of == 1 && self.storage == Storage::Float64
    }
}

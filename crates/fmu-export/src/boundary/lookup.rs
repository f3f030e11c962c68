//! Variables by their value references.

use std::borrow::Cow;

use super::{
    refusal::{Outcome, Refusal},
    types::ValueReference,
};
use crate::model::{Model, Variable};

/// The variable of a value reference.
pub fn variable_of<M: Model>(reference: ValueReference) -> Outcome<&'static Variable<M>> {
    usize::try_from(reference)
        .ok()
        .and_then(|index| M::variables().get(index))
        .ok_or(Refusal::UnknownReference(reference))
}

/// How many elements FMI 3.0 refers to by a value reference, that of an array's first one.
pub fn size<M: Model>(reference: ValueReference) -> usize {
    variable_of::<M>(reference).map_or(1, |variable| variable.elements)
}

/// The value references of all elements.
pub fn all_elements<M: Model>(references: &[ValueReference]) -> Cow<'_, [ValueReference]> {
    if references.iter().all(|first| size::<M>(*first) == 1) {
        return Cow::Borrowed(references);
    }
    Cow::Owned(references.iter().flat_map(|first| (*first..).take(size::<M>(*first))).collect())
}

//! The versions of the standard, as far as the shared part of the boundary has to tell them apart.

use crate::model::{Kind, Variable};

/// A version of the standard.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Version {
    /// FMI 2.0.
    #[default]
    Two,
    /// FMI 3.0.
    Three,
}

impl Version {
    /// The name that this version gives the type of real numbers.
    pub fn real(self) -> &'static str {
        match self {
            Self::Two => "Real",
            Self::Three => "Float64",
        }
    }

    /// The name that this version gives a variable's type.
    pub fn type_name<M>(self, variable: &Variable<M>) -> &'static str {
        match (self, &variable.kind) {
            (_, Kind::Real(_)) => self.real(),
            (Self::Three, Kind::Integer { .. }) => "Int32",
            _ => variable.type_name(),
        }
    }

    /// The name that this version gives the argument with the description's token.
    pub fn token(self) -> &'static str {
        match self {
            Self::Two => "fmuGUID",
            Self::Three => "instantiationToken",
        }
    }

    /// The name that this version gives the argument with a saved state.
    pub fn state(self) -> &'static str {
        match self {
            Self::Two => "FMUstate",
            Self::Three => "FMUState",
        }
    }
}

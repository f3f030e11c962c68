//! Values of variables, and how the binary stores them.

use serde::{Deserialize, Serialize};

/// A value of a variable.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Value {
    /// A real number, in the variable's unit.
    Real(f64),
    /// A whole number of any type of FMI, or an item of an enumeration.
    Integer(i128),
    /// Yes or no.
    Boolean(bool),
    /// A text; the bytes of a binary variable as hexadecimal digits, as FMI 3.0 writes its start value.
    String(String),
}

/// How the binary stores a variable's values. An enumeration's items are stored as integers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Content {
    /// A real number.
    Real,
    /// A whole number or an item of an enumeration.
    Integer,
    /// Yes or no.
    Boolean,
    /// A text.
    Text,
}

/// The handle by which calls reach a variable: a reference, and what is stored there.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Handle {
    /// The value reference in FMI 2.0. In FMI 3.0, where one value reference may be that of a whole array, the number
    /// of the element among those of all variables.
    pub reference: u32,
    /// How its values are stored.
    pub content: Content,
}

impl Content {
    /// A number as a value of this content: a whole number is rounded, 0.5 and more is yes.
    ///
    /// # Panics
    /// When NaN shall be a whole number, yes or no.
    pub fn value(self, number: f64) -> Value {
        let is_any = matches!(self, Self::Real | Self::Text);
        assert!(is_any || !number.is_nan(), "NaN is no {self:?}");
        match self {
            Self::Real => Value::Real(number),
            // A cast of a float saturates.
            Self::Integer => Value::Integer(number.round() as i128),
            Self::Boolean => Value::Boolean(number >= 0.5),
            Self::Text => Value::String(number.to_string()),
        }
    }
}

impl Value {
    /// How the binary stores it.
    pub fn content(&self) -> Content {
        match self {
            Self::Real(_) => Content::Real,
            Self::Integer(_) => Content::Integer,
            Self::Boolean(_) => Content::Boolean,
            Self::String(_) => Content::Text,
        }
    }

    /// The value as a number, yes as 1. A text is not a number; whole numbers beyond 2^53 are rounded.
    pub fn number(&self) -> f64 {
        match self {
            Self::Real(value) => *value,
            Self::Integer(value) => *value as f64,
            Self::Boolean(yes) => f64::from(u8::from(*yes)),
            Self::String(_) => f64::NAN,
        }
    }
}

/// Bytes as lower-case hexadecimal digits.
pub fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// The bytes that hexadecimal digits stand for, two each; `None` where the text is something else.
pub fn bytes_of(digits: &str) -> Option<Vec<u8>> {
    digits
        .as_bytes()
        .chunks(2)
        .map(|pair| {
            let pair = std::str::from_utf8(pair).ok()?;
            let is_pair = pair.len() == 2 && pair.bytes().all(|digit| digit.is_ascii_hexdigit());
            is_pair.then(|| u8::from_str_radix(pair, 16).ok())?
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_become_values_and_back() {
        for (content, number, back) in [
            (Content::Real, 0.3, 0.3),
            (Content::Integer, 2.5, 3.0),
            (Content::Integer, 1e300, i128::MAX as f64),
            (Content::Boolean, 0.5, 1.0),
            (Content::Boolean, 0.49, 0.0),
        ] {
            assert_eq!(content.value(number).number(), back, "{content:?} {number}");
        }
        assert_eq!(Content::Text.value(0.5), Value::String("0.5".to_owned()));
        assert!(Content::Text.value(0.5).number().is_nan());
    }

    #[test]
    fn digits_become_bytes() {
        assert_eq!(bytes_of("00fFa0"), Some(vec![0, 255, 160]));
        assert_eq!(bytes_of(""), Some(Vec::new()));
        for wrong in ["0", "0g", "+1", "äö", " 0"] {
            assert_eq!(bytes_of(wrong), None, "{wrong}");
        }
    }
}

//! A name with its place in the file, and pairs of names.

use serde::{Deserialize, Deserializer, de::Error as _};
use toml::Spanned;

/// A name with its place in the file.
pub type Name = Spanned<String>;

/// Two correlated parameters, or criteria with correlated errors of the measured values.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Pair {
    /// Their names.
    #[serde(deserialize_with = "exactly_two")]
    pub between: [Name; 2],
    /// The correlation coefficient of their normal scores, from -1 to 1: for normal parameters the usual one.
    pub coefficient: f64,
    /// A remark for people.
    pub about: Option<String>,
}

/// Reads a list of two. Without this, further entries would be lost without a word.
///
/// # Errors
/// When there are fewer or more.
pub fn exactly_two<'de, D: Deserializer<'de>, T: Deserialize<'de>>(text: D) -> Result<[T; 2], D::Error> {
    let entries = Vec::deserialize(text)?;
    entries.try_into().map_err(|entries: Vec<T>| {
        let count = entries.len();
        D::Error::custom(format!("a list of two is needed here, and this one has {count}"))
    })
}

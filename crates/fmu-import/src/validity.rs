//! What an FMU says of the limits of its model: its messages in the log category `validity`.

/// The log category.
pub const CATEGORY: &str = "validity";

/// Kinds of messages kept of a simulation: a model has few limits, and an FMU may log at every step.
const KINDS: usize = 16;

/// Whether two messages speak of the same limit: they differ in their numbers alone.
pub fn alike(one: &str, other: &str) -> bool {
    without_numbers(one).eq(without_numbers(other))
}

/// What a message has in common with those that differ in their numbers alone.
pub fn kind(message: &str) -> String {
    without_numbers(message).collect()
}

/// Whether a message is to be kept beside these: it is the first of its kind, and there are not too many kinds.
pub fn is_further<'a>(message: &str, mut kept: impl ExactSizeIterator<Item = &'a str>) -> bool {
    kept.len() < KINDS && !kept.any(|other| alike(message, other))
}

/// The characters of a message, one alone for each number. Digits within a name are none.
fn without_numbers(message: &str) -> impl Iterator<Item = char> {
    let (mut rest, mut before) = (message, ' ');
    std::iter::from_fn(move || {
        let in_name = before.is_alphanumeric() || before == '_';
        let number = if in_name { 0 } else { number(rest) };
        let length;
        (before, length) = match number {
            0 => rest.chars().next().map(|c| (c, c.len_utf8()))?,
            length => ('#', length),
        };
        rest = &rest[length..];
        Some(before)
    })
}

/// How long the number is with which a text begins; 0 where it begins with none.
fn number(text: &str) -> usize {
    let digits = text.strip_prefix(['+', '-']).unwrap_or(text);
    if !digits.starts_with(|c: char| c.is_ascii_digit()) {
        return 0;
    }
    text.find(|c: char| !c.is_ascii_digit() && !"+-.eE".contains(c)).unwrap_or(text.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_are_alike_that_differ_in_numbers_alone() {
        let at = |time: &str, value: &str| format!("at {time} s: T2 = {value}: too hot, \u{b5}");
        for (time, value) in [("0.5", "512.3"), ("12", "-1.5e+03"), ("1e-3", "7")] {
            assert!(alike(&at("3", "400"), &at(time, value)), "{time} {value}");
        }
        for other in ["at 3 s: T1 = 400: too hot, \u{b5}", "at 3 s", "", "-"] {
            assert!(!alike(&at("3", "400"), other), "{other}");
        }
    }

    #[test]
    fn few_of_many_kinds_are_kept() {
        let mut kept: Vec<String> = Vec::new();
        for k in 0..1000 {
            let message = format!("limit{} at {k}", k % 500);
            if is_further(&message, kept.iter().map(String::as_str)) {
                kept.push(message);
            }
        }
        assert_eq!(kept.len(), KINDS);
        assert_eq!(kept[1], "limit1 at 1");
    }
}

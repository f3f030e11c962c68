//! Who answers for a verdict, and on which test it rests.

use chrono::NaiveDate;
use serde::{Deserialize, Deserializer, Serialize, de::Error as _};
use toml::value::Datetime;

/// Who tested what and when: text for the reader of a verdict.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Dossier {
    /// Who answers for the verdict.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub responsible: Option<String>,
    /// For whom.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub organisation: Option<String>,
    /// The machine on which the measured values were taken.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rig: Option<String>,
    /// The part that was tested on it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub specimen: Option<String>,
    /// The test run.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub test: Option<String>,
    /// When the test was run: a date of TOML, or a text.
    #[serde(default, deserialize_with = "date_or_text", skip_serializing_if = "Option::is_none")]
    pub tested: Option<String>,
    /// Where the test is written down.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub document: Option<String>,
}

impl Dossier {
    /// The statements, by their keys.
    pub fn stated(&self) -> impl Iterator<Item = (&'static str, &str)> {
        [
            ("responsible", &self.responsible),
            ("organisation", &self.organisation),
            ("rig", &self.rig),
            ("specimen", &self.specimen),
            ("test", &self.test),
            ("tested", &self.tested),
            ("document", &self.document),
        ]
        .into_iter()
        .filter_map(|(key, text)| Some((key, text.as_deref()?)))
    }
}

/// A date as TOML has it, or a text. A text that begins as a date must be one.
fn date_or_text<'de, D: Deserializer<'de>>(from: D) -> Result<Option<String>, D::Error> {
    #[derive(Deserialize)]
    #[serde(untagged, expecting = "expected a date such as 2025-05-12, or a text in quotes")]
    enum Form {
        Date(Datetime),
        Text(String),
    }
    match Form::deserialize(from)? {
        Form::Date(date) => Ok(Some(date.to_string())),
        Form::Text(text) => {
            check_date(&text).map_err(D::Error::custom)?;
            Ok(Some(text))
        }
    }
}

fn check_date(text: &str) -> Result<(), String> {
    let digits = |(k, byte): (usize, u8)| match k {
        4 | 7 => byte == b'-',
        _ => byte.is_ascii_digit(),
    };
    let Some(date) = text.get(..10) else { return Ok(()) };
    if date.bytes().enumerate().all(digits) && NaiveDate::parse_from_str(date, "%Y-%m-%d").is_err() {
        return Err(format!("`{date}` is no date of the calendar"));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tested(value: &str) -> Result<Option<String>, String> {
        let dossier = toml::from_str::<Dossier>(&format!("tested = {value}"));
        dossier.map(|dossier| dossier.tested).map_err(|error| error.message().to_owned())
    }

    #[test]
    fn a_date_may_stand_without_quotes() {
        for (value, date) in [
            ("2025-05-12", "2025-05-12"),
            ("\"2025-05-12\"", "2025-05-12"),
            ("2025-05-12T08:30:00Z", "2025-05-12T08:30:00Z"),
            ("\"2025-05-12 to 2025-05-14\"", "2025-05-12 to 2025-05-14"),
            ("\"spring 2025\"", "spring 2025"),
            ("\"May 2025 in Graz\"", "May 2025 in Graz"),
        ] {
            assert_eq!(tested(value), Ok(Some(date.to_owned())), "{value}");
        }
        let text = serde_json::to_string(&Dossier { tested: Some("2025-05-12".to_owned()), ..Dossier::default() });
        let again: Dossier = serde_json::from_str(&text.unwrap()).unwrap();
        assert_eq!(again.tested.as_deref(), Some("2025-05-12"));
        assert_eq!(toml::from_str::<Dossier>("").unwrap().tested, None);
    }

    #[test]
    fn a_day_that_no_calendar_has_is_refused() {
        let refused = tested("\"2025-13-45\"").unwrap_err();
        assert!(refused.contains("`2025-13-45` is no date"), "{refused}");
        let refused = tested("12").unwrap_err();
        assert!(refused.contains("a date such as 2025-05-12"), "{refused}");
    }
}

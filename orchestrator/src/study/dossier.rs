//! Who answers for a verdict, and on which test it rests.

use serde::{Deserialize, Serialize};

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
    /// When the test was run.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tested: Option<String>,
    /// Where the test is written down.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub document: Option<String>,
}

impl Dossier {
    /// The statements, by their keys.
    pub fn stated(&self) -> impl Iterator<Item = (&'static str, &str)> {
        let all = [
            ("responsible", &self.responsible),
            ("organisation", &self.organisation),
            ("rig", &self.rig),
            ("specimen", &self.specimen),
            ("test", &self.test),
            ("tested", &self.tested),
            ("document", &self.document),
        ];
        all.into_iter()
            .filter_map(|(key, text)| Some((key, text.as_deref()?)))
    }
}

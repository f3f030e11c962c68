//! How an answer by a surrogate was found, and how good that is.

use conformity::conclusion::grouped;
use indexmap::IndexMap;
use result_document::format::number;
use serde::{Deserialize, Serialize};

/// The answer by a surrogate, or by counting plain points where that does not hold.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct BySurrogate {
    /// All runs of the FMU: points, and those beside them.
    pub runs: u64,
    /// Points that are a plain sample of the parameters.
    pub plain: u64,
    /// Points that were chosen near the limits.
    pub chosen: u64,
    /// The share of the space that meets all criteria.
    pub share: f64,
    /// Its 95 % interval.
    pub interval: [f64; 2],
    /// By criterion.
    pub criteria: IndexMap<String, SurrogateFit>,
    /// Whether the surrogate does not hold, so that plain points were counted.
    pub refuted: bool,
    /// Why it does not.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
}

/// How well a criterion's surrogate predicts points that are left out.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct SurrogateFit {
    /// The root mean square error, in tolerances.
    pub error: f64,
    /// The part of the points that lies in the 95 % band of the others.
    pub held: f64,
}

impl BySurrogate {
    /// How the share was found, in a few words.
    pub fn way(&self) -> &'static str {
        if self.refuted { "counted" } else { "by surrogate" }
    }

    /// How good the surrogate is.
    pub fn sentence(&self) -> String {
        let runs = grouped(self.runs);
        if let Some(reason) = &self.reason {
            return format!(
                "Counted instead, from {} plain points of {runs} runs: the surrogate does not hold here, as {reason}.",
                self.plain
            );
        }
        let worst = self
            .criteria
            .iter()
            .max_by(|a, b| a.1.error.total_cmp(&b.1.error))
            .map(|(name, fit)| {
                format!(
                    " Points that are left out are missed by {} tolerances (rms) or less ({name}).",
                    number(fit.error, 2)
                )
            })
            .unwrap_or_default();
        format!(
            "By surrogate from {runs} runs: {} points are plain, {} chosen near the limits.{worst}",
            self.plain, self.chosen
        )
    }
}

//! Which study, FMU and points a result came from, so that it is never shown beside other ones.

use serde::{Deserialize, Serialize};

use super::Summary;

/// Which study, FMU and points a result came from.
#[derive(Clone, Serialize, Deserialize)]
pub struct Origin {
    /// The SHA-256 digest of the study.
    pub study_sha256: String,
    /// The SHA-256 digest of the FMU, where there is one.
    pub fmu_sha256: Option<String>,
    /// The points that it was found from; none where it comes from runs of its own.
    pub points: Option<SampledPoints>,
}

/// The points of a finished study.
#[derive(Clone, PartialEq, Serialize, Deserialize)]
pub struct SampledPoints {
    method: String,
    seed: Option<u64>,
    points: u64,
    verified: u64,
}

impl Origin {
    /// Origin of a finding that was computed from a study's points.
    pub fn of_points(summary: &Summary) -> Self {
        let from = &summary.provenance;
        Self {
            study_sha256: from.study_sha256.clone(),
            fmu_sha256: from.fmu_sha256.clone(),
            points: Some(SampledPoints {
                method: from.method.clone(),
                seed: from.seed,
                points: summary.points,
                verified: summary.verified,
            }),
        }
    }

    /// Whether a finding came from these results.
    pub fn fits(&self, summary: &Summary) -> bool {
        let current = Self::of_points(summary);
        let same_points = self.points.is_none() || self.points == current.points;
        self.study_sha256 == current.study_sha256 && self.fmu_sha256 == current.fmu_sha256 && same_points
    }
}

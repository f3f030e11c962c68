//! How points are kept apart.

use serde::{Deserialize, Serialize};

/// In which processes points run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Isolation {
    /// Every point alone in a process that has loaded the FMU and never instantiated it.
    #[default]
    Fresh,
    /// Points share processes: whoever trusts the FMU wants it so.
    Shared,
    /// All points in the process of the supervisor.
    None,
}

impl std::str::FromStr for Isolation {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        Ok(match text {
            "fresh" => Self::Fresh,
            "shared" => Self::Shared,
            "none" => Self::None,
            "audited" => {
                return Err("version 0.3 has no audits; leave the option out: each point runs alone".to_owned());
            }
            "reuse" => return Err("it is called `shared` now".to_owned()),
            _ => return Err("it is one of fresh, shared, none".to_owned()),
        })
    }
}

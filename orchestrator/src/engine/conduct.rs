//! How points share processes, and what comparisons of them showed: for summary, terminal and page.

use serde::{Deserialize, Serialize};

/// How points share processes, as the user wishes it and as it turned out.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, clap::ValueEnum,
)]
#[serde(rename_all = "kebab-case")]
pub enum Isolation {
    /// Every point alone in a process of its own
    Fresh,
    /// Processes are used for many points once that is proven, and under audit
    Audited,
    /// Processes are used for many points, and not audited
    Reuse,
    /// All points in the process of the supervisor.
    #[value(skip)]
    InProcess,
}

/// In what process a point was computed, from the strictest on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Separation {
    /// In a new one, with an unpacked FMU of its own.
    Apart,
    /// In a new one.
    New,
    /// In a fork of one that had loaded the FMU and never instantiated it.
    Forked,
    /// In one that had computed other points before.
    Used,
}

impl Separation {
    /// Number of kinds.
    pub const COUNT: usize = 4;
}

/// How the points of a run were computed, and what their audits found.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Conduct {
    /// How points shared processes.
    pub isolation: Isolation,
    /// How many points were computed twice, the second time in a new process with other bytes in unwritten memory.
    pub audits: u64,
    /// How many of these had shared a process the first time.
    #[serde(default)]
    pub audits_of_shared: u64,
    /// How many of them differed.
    pub audit_mismatches: u64,
    /// Whether points that are computed twice, alone, give the same; `None` where that is not known.
    #[serde(default)]
    pub reproducible: Option<bool>,
    /// The first file that the FMU changed in its own folder: then each point had a folder of its own.
    #[serde(default)]
    pub changed_file: Option<String>,
}

impl Conduct {
    /// Where an audit puts other bytes: only the C library of Linux (glibc) can fill what it hands out.
    const REFILLED: &str = if cfg!(all(target_os = "linux", target_env = "gnu")) {
        "unwritten memory"
    } else {
        "the unwritten stack"
    };

    /// Nothing was computed yet.
    pub const NONE: Self = Self {
        isolation: Isolation::Fresh,
        audits: 0,
        audits_of_shared: 0,
        audit_mismatches: 0,
        reproducible: None,
        changed_file: None,
    };

    /// How all points were computed, of which some were computed so and others otherwise.
    pub fn and(self, other: Self) -> Self {
        Self {
            isolation: self.isolation.max(other.isolation),
            audits: self.audits + other.audits,
            audits_of_shared: self.audits_of_shared + other.audits_of_shared,
            audit_mismatches: self.audit_mismatches + other.audit_mismatches,
            reproducible: match (self.reproducible, other.reproducible) {
                (Some(false), _) | (_, Some(false)) => Some(false),
                (one, other) => one.or(other),
            },
            changed_file: self.changed_file.or(other.changed_file),
        }
    }

    /// The findings since `before`. Where the FMU was found to change its folder meanwhile, they begin anew.
    pub fn since(self, before: Option<&Self>) -> Self {
        let before = before.unwrap_or(&Self::NONE);
        Self {
            audits: self.audits.saturating_sub(before.audits),
            audits_of_shared: self
                .audits_of_shared
                .saturating_sub(before.audits_of_shared),
            audit_mismatches: self
                .audit_mismatches
                .saturating_sub(before.audit_mismatches),
            ..self
        }
    }

    /// Remarks for a reader of the results, one sentence each.
    pub fn remarks(&self) -> Vec<String> {
        let mut remarks = Vec::new();
        if let Some(file) = &self.changed_file {
            remarks.push(format!(
                "the FMU changes files in its own folder (the first: {file}), which later points would read; every \
                 point ran alone in a new process, with a folder of its own"
            ));
        }
        let differs = self.reproducible == Some(false);
        if !differs && self.audit_mismatches > 0 {
            remarks.push(format!(
                "{} of {} points had other results when they were computed again alone in a new process; all points \
                 were computed again, each alone",
                self.audit_mismatches, self.audits
            ));
        }
        if self.isolation == Isolation::Audited {
            remarks.push(self.proof());
        }
        // What casts doubt on all results comes first, what confirms them last.
        let place = if differs { 0 } else { remarks.len() };
        remarks.insert(place, self.reproducibility());
        remarks
    }

    /// Whether the FMU gives the same for the same point, and how many points say so.
    pub fn reproducibility(&self) -> String {
        if self.reproducible == Some(false) {
            let count = match (self.audit_mismatches, self.audits) {
                (0, _) | (_, 0) => String::new(),
                (differing, all) => {
                    format!(", found in {differing} of {all} points computed twice")
                }
            };
            return format!(
                "not reproducible: the FMU gives other results for the same point in another new process{count} \
                 (memory that it never wrote, the clock, random numbers, files outside its own folder); every point \
                 ran alone in a new process"
            );
        }
        match (self.reproducible, self.audits) {
            (None, _) | (_, 0) => {
                let reason = match self.isolation {
                    Isolation::Reuse => {
                        "points shared processes without audits (--isolation reuse)"
                    }
                    _ => "no point was computed twice",
                };
                format!("whether the FMU is reproducible is not known: {reason}")
            }
            (_, count) => format!(
                "reproducible: {count} {} computed twice, the second time alone in a new process with other bytes in \
                 {}, and came out the same to the last bit ({})",
                if count == 1 {
                    "point was"
                } else {
                    "points were"
                },
                Self::REFILLED,
                power(count)
            ),
        }
    }

    /// How far the audits prove that sharing processes changes nothing.
    fn proof(&self) -> String {
        match self.audits_of_shared {
            0 => "points shared processes; there was no time for an audit".to_owned(),
            count => format!(
                "points shared processes; {count} of them {} computed again alone, and agreed to the last bit ({})",
                was(count),
                power(count)
            ),
        }
    }
}

fn was(count: u64) -> &'static str {
    if count == 1 { "was" } else { "were" }
}

/// What the comparison of so many points finds.
#[allow(clippy::cast_precision_loss)]
fn power(audits: u64) -> String {
    let share = 100.0 * (1.0 - 0.05_f64.powf(1.0 / audits as f64));
    format!(
        "had {share:.2} % of all points differed, this would have been found with a probability of 95 %; a share f is \
         found with 1-(1-f)^{audits}"
    )
}

//! How points share processes, and what comparisons of them showed: for summary, terminal and page.

use serde::{Deserialize, Serialize};

/// How points share processes, as the user wishes it and as it turned out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[serde(rename_all = "kebab-case")]
pub enum Isolation {
    /// Every point alone in a process of its own
    #[default]
    Fresh,
    /// Points share processes once tests show that the FMU allows it; some points are run again, alone
    Audited,
    /// Points share processes, without checks
    Reuse,
    /// All points in the process of the supervisor.
    #[cfg_attr(feature = "clap", value(skip))]
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

/// Why points that could have shared processes did not.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Reason {
    /// The user wanted it so.
    Asked,
    /// Too few points to find out.
    FewPoints,
    /// Next to points that take so long, a process each costs nothing.
    LongPoints,
    /// Many points ended with a warning, or failed.
    Complaints,
    /// Many points left a thread running.
    Threads,
    /// Many points changed how signals are handled.
    Signals,
    /// The licences are fewer than the workers: none may be kept between points.
    ScarceLicences,
    /// Used processes gave other results.
    OtherResults,
    /// New processes differ among themselves.
    NotReproducible,
    /// The FMU changes its own folder.
    ChangedFolder,
}

impl Reason {
    /// Traces that many points left behind, so that no other point could use their process.
    fn odd(self) -> Option<&'static str> {
        match self {
            Self::Complaints => Some("ended with a warning or failed"),
            Self::Threads => Some("left a thread running"),
            Self::Signals => Some("changed how signals are handled"),
            _ => None,
        }
    }
}

/// How the points of a run were computed, and what their audits found.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Conduct {
    /// How points shared processes.
    pub isolation: Isolation,
    /// Why they did not, or not all of them.
    pub isolation_reason: Option<Reason>,
    /// How many points were computed twice, the second time in a new process with other bytes in unwritten memory.
    pub audits: u64,
    /// How many of these had followed another point in its process the first time.
    #[serde(default)]
    pub audits_of_shared: u64,
    /// How many of them differed.
    pub audit_mismatches: u64,
    /// Whether points that are computed twice, alone, give the same; `None` where that is not known.
    pub reproducible: Option<bool>,
    /// How many points that failed while others ran were run again alone at the end.
    #[serde(default, skip_serializing_if = "crate::notices::is_zero")]
    pub repeated_alone: u64,
    /// How many of these passed.
    #[serde(default, skip_serializing_if = "crate::notices::is_zero")]
    pub passed_alone: u64,
    /// The first file that the FMU changed in its own folder: then each point had a folder of its own.
    pub changed_file: Option<String>,
}

impl Conduct {
    /// How all points were computed, of which some were computed so and others otherwise.
    pub fn and(self, other: Self) -> Self {
        Self {
            isolation: self.isolation.max(other.isolation),
            // The later one knows more.
            isolation_reason: other.isolation_reason,
            audits: self.audits + other.audits,
            audits_of_shared: self.audits_of_shared + other.audits_of_shared,
            audit_mismatches: self.audit_mismatches + other.audit_mismatches,
            reproducible: match (self.reproducible, other.reproducible) {
                (Some(false), _) | (_, Some(false)) => Some(false),
                (one, other) => one.or(other),
            },
            repeated_alone: self.repeated_alone + other.repeated_alone,
            passed_alone: self.passed_alone + other.passed_alone,
            changed_file: self.changed_file.or(other.changed_file),
        }
    }

    /// The findings since `before`. Where the FMU was found to change its folder meanwhile, they begin anew.
    pub fn since(self, before: Option<&Self>) -> Self {
        let none = Self::default();
        let before = before.unwrap_or(&none);
        Self {
            audits: self.audits.saturating_sub(before.audits),
            audits_of_shared: self.audits_of_shared.saturating_sub(before.audits_of_shared),
            audit_mismatches: self.audit_mismatches.saturating_sub(before.audit_mismatches),
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
        if self.passed_alone > 0 {
            remarks.push(format!(
                "of {} run again at the end, since they had failed while others ran, {} passed alone and count as passed: \
                 the FMU needs something that one process can have at a time, such as a port or a file (--jobs 1)",
                points(self.repeated_alone),
                self.passed_alone
            ));
        }
        if self.isolation == Isolation::Audited {
            remarks.push(self.proof());
        }
        if let Some(odd) = self.isolation_reason.and_then(Reason::odd) {
            remarks
                .push(format!("many points {odd}, so they ran in fresh processes: whatever is odd is followed by one"));
        }
        // What casts doubt on all results comes first, what confirms them last.
        let place = if differs { 0 } else { remarks.len() };
        remarks.insert(place, self.reproducibility());
        remarks
    }

    /// Why all points ran in fresh processes, where that is no matter of the FMU.
    pub fn usual_reason(&self) -> Option<String> {
        let reason = match self.isolation_reason? {
            _ if self.isolation != Isolation::Fresh => return None,
            Reason::Asked => "--isolation fresh",
            Reason::FewPoints => "too few points for anything else to pay",
            Reason::LongPoints => "that costs next to nothing where points take so long",
            Reason::ScarceLicences => "there are fewer licences than workers",
            Reason::OtherResults => "in used processes results differ",
            _ => return None,
        };
        Some(format!("each point ran in a process of its own: {reason}"))
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
                    Isolation::Reuse => "points shared processes without audits (--isolation reuse)",
                    _ => "no point was computed twice",
                };
                format!("whether the FMU is reproducible is not known: {reason}")
            }
            (_, count) => format!("reproducible: {} run twice gave identical results", points(count)),
        }
    }

    /// Findings of the audits on shared processes, and effects that they cannot see.
    fn proof(&self) -> String {
        let count = self.audits_of_shared;
        if count == 0 {
            return "points shared processes; there was no time for an audit".to_owned();
        }
        let chance = 100.0 * (1.0 - 0.99_f64.powf(count as f64));
        format!(
            "points shared processes; {} run again alone gave identical results; only so it shows what a point that ends \
             plainly spoils for the next ones: were 1 % of the points wrong, with a probability of {chance:.0} % \
             (1-(1-f)^{count}); --isolation fresh excludes it",
            points(count)
        )
    }
}

fn points(count: u64) -> String {
    format!("{count} point{}", if count == 1 { "" } else { "s" })
}

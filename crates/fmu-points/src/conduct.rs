//! How the points of a run were computed: for summary, terminal and page.

use serde::{Deserialize, Serialize};

use crate::isolation::Isolation;

/// How the points of a run were computed, and whether the FMU gives the same for the same point.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Conduct {
    /// How points were kept apart.
    pub isolation: Isolation,
    /// Whether points that ran again at the end gave what is recorded, to the last bit; `None` where none did.
    pub reproducible: Option<bool>,
    /// The same in words: which points were compared with what, and how much later.
    pub reproducibility: String,
    /// The first file that the FMU changed in its own folder: from then on each point had a folder of its own.
    pub changed_file: Option<String>,
}

impl Conduct {
    /// How all points were computed, of which some were computed so and others otherwise.
    pub fn and(self, other: Self) -> Self {
        let differs = |conduct: &Self| conduct.reproducible == Some(false);
        // What differed stays so; else the later one knows more.
        let told = if differs(&self) || other.reproducible.is_none() { &self } else { &other };
        let (reproducible, reproducibility) = (told.reproducible, told.reproducibility.clone());
        Self {
            isolation: self.isolation.max(other.isolation),
            reproducible,
            reproducibility,
            changed_file: self.changed_file.or(other.changed_file),
        }
    }

    /// How points ran, where they did not run alone.
    pub fn company(&self) -> Option<&'static str> {
        match self.isolation {
            Isolation::Fresh => None,
            Isolation::Shared => Some("points share processes, as you asked"),
            Isolation::None => Some("all points ran in one process, as you asked"),
        }
    }

    /// Remarks for a reader of the results, one sentence each: what casts doubt on all results comes first.
    pub fn remarks(&self) -> Vec<String> {
        let mut remarks: Vec<String> = self.company().map(str::to_owned).into_iter().collect();
        if let Some(file) = &self.changed_file {
            remarks.push(format!(
                "the FMU changes files in its own folder (the first: {file}), so each point had a folder of its own from then on"
            ));
        }
        let place = if self.reproducible == Some(false) { 0 } else { remarks.len() };
        remarks.insert(place, self.told_reproducibility());
        remarks
    }

    /// Whether the FMU gives the same for the same point, in words.
    pub fn told_reproducibility(&self) -> String {
        match self.reproducible {
            None => "no point ran a second time: whether the FMU gives the same again is not known".to_owned(),
            Some(_) => self.reproducibility.clone(),
        }
    }
}

//! Points that went beyond what the model says it is valid for: how many, what it says, and which they are.

use std::{
    cmp::Reverse,
    collections::BTreeSet,
    fs::{self, File},
    io,
    path::Path,
};

use serde::{Deserialize, Serialize};
use tempfile::NamedTempFile;

use crate::error::{Error, Result};
use conformity::conclusion::grouped;
use fmu_import::{
    Description,
    validity::{CATEGORY, alike},
};
use fmu_points::notices::Limit;
use number_tables::csv_file;
use point_journal::{
    Finished,
    files::{draft, keep},
};

/// The file with the points.
const FILE: &str = "validity.csv";

/// Points that went beyond what the model says it is valid for.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Validity {
    /// How many points.
    pub points: u64,
    /// How many of them meet all criteria.
    pub verified: u64,
    /// The limits that they passed: those that most points passed come first.
    pub limits: Vec<Passed>,
}

/// A limit that points passed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Passed {
    /// How many points.
    pub points: u64,
    /// How many of them meet all criteria.
    pub verified: u64,
    /// The first of them.
    pub first: First,
}

/// The first point that passed a limit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct First {
    /// Name, for people.
    pub point: u64,
    /// The limit, as the FMU says it of this point.
    #[serde(flatten)]
    pub limit: Limit,
}

impl Validity {
    /// No points yet; none where the FMU has no such log category, and nothing is known.
    pub fn of(fmu: &Description) -> Option<Self> {
        let mut categories = fmu.log_categories.iter();
        categories.any(|name| name == CATEGORY).then(Self::default)
    }

    /// A sentence on those of a journal.
    ///
    /// # Errors
    /// When the journal cannot be read.
    pub fn of_journal(fmu: &Description, folder: &Path) -> Result<Option<String>> {
        let Some(mut validity) = Self::of(fmu) else { return Ok(None) };
        let finished = Finished::read(folder)?;
        let mut outcomes = finished.outcomes()?;
        for index in finished.points() {
            let noted = outcomes.get_noted(index)?.and_then(|(_, notices)| notices);
            if let Some(notices) = noted {
                validity.add(index + 1, false, &notices.beyond);
            }
        }
        Ok(validity.told(finished.count, ""))
    }

    /// Counts a point; points come in their order.
    pub fn add(&mut self, point: u64, verified: bool, limits: &[Limit]) {
        const MOST: usize = 32;
        if limits.is_empty() {
            return;
        }
        self.points += 1;
        self.verified += u64::from(verified);
        for limit in limits {
            let message = &limit.message;
            let place =
                self.limits.iter().position(|known| alike(&known.first.limit.message, message)).unwrap_or_else(|| {
                    self.limits.push(Passed { points: 0, verified: 0, first: First { point, limit: limit.clone() } });
                    self.limits.len() - 1
                });
            self.limits[place].points += 1;
            self.limits[place].verified += u64::from(verified);
            self.limits.truncate(MOST);
        }
        self.limits.sort_by_key(|limit| Reverse(limit.points));
    }

    /// A sentence on these points of `all`, where there are any; `which` says which of them stand out.
    pub fn told(&self, all: u64, which: &str) -> Option<String> {
        const NAMED: usize = 3;
        let named: Vec<String> = self
            .limits
            .iter()
            .take(NAMED)
            .map(|limit| {
                let First { point, limit: said } = &limit.first;
                let (said, points) = (said.to_string(), grouped(limit.points));
                let said = said.trim_end_matches('.');
                format!("{said} ({points} of them, the first is point {point})")
            })
            .collect();
        (self.points > 0).then(|| {
            format!(
                "{} of {} points{which} went beyond what the model says it is valid for: {}{}",
                grouped(self.points),
                grouped(all),
                named.join("; "),
                if self.limits.len() > NAMED { "; and more" } else { "" }
            )
        })
    }
}

/// Writes `FILE`, where any point goes into it.
#[derive(Debug, Default)]
pub struct Writer(Option<(csv::Writer<File>, NamedTempFile)>);

impl Writer {
    /// Adds the limits that a point passed.
    ///
    /// # Errors
    /// When the system says no.
    pub fn write(&mut self, folder: &Path, point: u64, limits: &[Limit]) -> io::Result<()> {
        for Limit { case, message } in limits {
            if self.0.is_none() {
                let file = draft(folder)?;
                let mut csv = csv::Writer::from_writer(file.reopen()?);
                csv.write_record(["point", "case", "message"])?;
                self.0 = Some((csv, file));
            }
            if let Some((csv, _)) = &mut self.0 {
                let case = csv_file::cell(case.as_deref().unwrap_or_default());
                let message = csv_file::cell(message);
                csv.write_record([&*point.to_string(), &*case, &*message])?;
            }
        }
        Ok(())
    }

    /// Puts the file in place, or removes that of an earlier run.
    ///
    /// # Errors
    /// When the system says no.
    pub fn finish(self, folder: &Path) -> Result {
        let path = folder.join(FILE);
        match self.0 {
            Some((mut csv, file)) => {
                csv.flush().map_err(Error::io(&path))?;
                Ok(keep(file, &path)?)
            }
            None => match fs::remove_file(&path) {
                Err(error) if error.kind() != io::ErrorKind::NotFound => Err(Error::io(&path)(error)),
                _ => Ok(()),
            },
        }
    }
}

/// The points in the file, as far as it is there and sound: they are marked, nothing rests on them.
pub fn points(folder: &Path) -> BTreeSet<u64> {
    csv::Reader::from_path(folder.join(FILE))
        .into_iter()
        .flat_map(csv::Reader::into_records)
        .flatten()
        .filter_map(|row| row.get(0)?.parse().ok())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn limit(message: &str) -> Limit {
        Limit { case: None, message: message.to_owned() }
    }

    #[test]
    fn limits_are_counted_by_kind_and_the_most_frequent_come_first() {
        let mut validity = Validity::default();
        assert_eq!(validity.told(3, ""), None);
        validity.add(4, true, &[]);
        validity.add(7, true, &[limit("fast at 1 s"), limit("hot at 2 s.")]);
        validity.add(9, false, &[limit("hot at 3.5 s.")]);
        let told = validity.told(1000, ", one,").unwrap();
        assert_eq!(
            told,
            "2 of 1,000 points, one, went beyond what the model says it is valid for: hot at 2 s (2 of them, the first \
             is point 7); fast at 1 s (1 of them, the first is point 7)"
        );
        assert_eq!((validity.points, validity.verified), (2, 1));
        assert_eq!(validity.limits[0].verified, 1);
        for k in 0..100 {
            validity.add(k, false, &[limit(&format!("limit{k}"))]);
        }
        assert_eq!((validity.points, validity.limits.len()), (102, 32));
        let text = serde_json::to_string(&validity).unwrap();
        assert_eq!(serde_json::from_str::<Validity>(&text).unwrap(), validity);
    }

    #[test]
    fn points_are_read_as_they_were_written_and_no_file_stays_without_any() {
        let folder = tempfile::tempdir().unwrap();
        let mut writer = Writer::default();
        let limits = [limit("hot, \"very\"\n"), limit("=fast")];
        writer.write(folder.path(), 3, &limits).unwrap();
        writer.write(folder.path(), 12, &limits[..1]).unwrap();
        writer.finish(folder.path()).unwrap();
        assert_eq!(points(folder.path()), BTreeSet::from([3, 12]));
        let text = fs::read_to_string(folder.path().join(FILE)).unwrap();
        assert!(text.contains("3,,'=fast\n"), "{text}");
        Writer::default().finish(folder.path()).unwrap();
        assert!(!folder.path().join(FILE).exists());
        assert!(points(folder.path()).is_empty());
    }
}

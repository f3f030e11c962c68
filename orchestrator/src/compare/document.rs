//! The document of a comparison, its page, and its file.

use std::path::Path;

use super::{Change, Comparison, said};
use crate::error::Error;
use crate::plain;
use point_journal::files::{make_folder, write_json};
use result_document::format::{count, number, with_unit};
use result_document::{Block, Document, Table, numbers, words};

impl Comparison {
    /// The document for terminal and page.
    pub fn document(&self) -> Document {
        let mut told = Document::new("changes", "Changes", "What changed");
        told.blocks.push(Block::List(self.differences.clone()));
        told.warn(&self.warnings);
        told.table(self.counts());
        told.heading(format!("Changes at {} points", count(self.pairs as usize)));
        told.table(self.changes());
        for (name, change) in self.criteria.iter().filter(|(_, change)| !change.regions.is_empty()) {
            told.say(format!("Where {name} changed most:"));
            told.table(regions(name, change));
        }
        told.hint(self.rule);
        told
    }

    /// The answer in one sentence.
    pub fn headline(&self) -> String {
        let explained = self.criteria.values().any(|change| change.changed > change.beyond);
        match (self.same, self.warnings.is_empty()) {
            (true, true) if explained => "No difference beyond the numerical uncertainty".to_owned(),
            (true, true) => "No difference".to_owned(),
            (true, false) => "The same verdict, and a change".to_owned(),
            (false, _) => "The results differ".to_owned(),
        }
    }

    fn counts(&self) -> Table {
        let sides = [&self.old, &self.new];
        let row = |name: &str, cells: [String; 2]| [[name.to_owned()].to_vec(), cells.to_vec()].concat();
        let number = |value: u64| count(value as usize);
        let text = |value: &Option<String>| value.clone().unwrap_or_else(|| "–".to_owned());
        let short = |digest: &Option<String>| text(digest).chars().take(12).collect::<String>();
        let new_fmu = match self.as_packed {
            true => "as packed".to_owned(),
            false => short(&self.new.fmu_sha256),
        };
        Table {
            name: "Both results".into(),
            columns: vec![words(""), numbers("Old"), numbers("New")],
            rows: vec![
                row("verdict", sides.map(|side| said(side.verdict))),
                row("points", sides.map(|side| number(side.points))),
                row("without a result", sides.map(|side| number(side.failed))),
                row("within all tolerances", sides.map(|side| number(side.verified))),
                row("accepted", sides.map(|side| side.accepted.map_or_else(|| "–".to_owned(), number))),
                row("model version", sides.map(|side| text(&side.fmu_version))),
                row("FMU, SHA-256", [short(&self.old.fmu_sha256), new_fmu]),
                row("study, SHA-256", sides.map(|side| short(&Some(side.study_sha256.clone())))),
                row("program", sides.map(|side| side.orchestrator.clone())),
            ],
            ..Table::default()
        }
    }

    fn changes(&self) -> Table {
        let row = |(name, change): (&String, &Change)| {
            let share = |of: Option<f64>| of.map_or_else(|| "–".to_owned(), |of| number(100.0 * of, 3));
            let largest = change.largest;
            vec![
                with_unit(name, change.unit.as_deref().unwrap_or_default()),
                count(change.changed as usize),
                count(change.beyond as usize),
                change.numerical_uncertainty.map_or_else(|| "not stated".to_owned(), |u| number(u, 3)),
                number(change.mean, 3),
                largest.map_or_else(|| "–".to_owned(), |largest| number(largest.new - largest.old, 3)),
                share(largest.map(|largest| largest.of_tolerance)),
                largest.map_or_else(|| "–".to_owned(), |largest| largest.point.to_string()),
                count(change.flipped.count as usize),
                count(change.flipped_within.count as usize),
            ]
        };
        Table {
            name: "Changes by criterion".into(),
            class: "stack".into(),
            columns: vec![
                words("Criterion"),
                numbers("Changed"),
                numbers("Beyond"),
                numbers("Uncertainty"),
                numbers("Mean"),
                numbers("Largest"),
                numbers("% of tolerance"),
                numbers("At point"),
                numbers("Flipped"),
                numbers("Within"),
            ],
            rows: self.criteria.iter().map(row).collect(),
        }
    }
}

fn regions(name: &str, change: &Change) -> Table {
    let rows = change.regions.iter().map(|region| {
        let range = |[low, high]: [f64; 2]| format!("{} .. {}", number(low, 4), number(high, 4));
        vec![
            with_unit(&region.parameter, &region.unit),
            range(region.most_changed),
            range(region.others),
            number(region.distance, 2),
        ]
    });
    Table {
        name: format!("Where {name} changed most"),
        columns: vec![words("Parameter"), numbers("Most changed"), numbers("Others"), numbers("Distance")],
        rows: rows.collect(),
        ..Table::default()
    }
}

/// Writes `compare.json` and `compare.html` into a folder.
///
/// # Errors
/// When the system says no.
pub fn write(comparison: &Comparison, folder: &Path) -> Result<(), Error> {
    make_folder(folder)?;
    write_json(&folder.join("compare.json"), comparison)?;
    let title = comparison.headline();
    let sides = [&comparison.old, &comparison.new].map(|side| side.folder.display().to_string());
    let page = plain::Page {
        kicker: "Comparison of two results",
        title: &sides.join(" → "),
        headline: &title,
        is_good: comparison.same,
        documents: &[comparison.document()],
    };
    page.write(&folder.join("compare.html"))
}

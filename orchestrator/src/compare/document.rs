//! The document of a comparison, its page, and its file.

use std::{iter, path::Path};

use super::{Change, Comparison, Largest, said};
use crate::{error::Result, plain};
use conformity::conclusion::grouped;
use point_journal::files::{make_output, write_json};
use result_document::{
    Document, Figure, Key, Table,
    bins::axis_range,
    format::{DASH, number, with_unit},
    numbers,
    svg::{Frame, area, circle, path},
    words,
};
use study::judge::Criterion;

impl Comparison {
    /// The document for terminal and page.
    pub fn document(&self) -> Document {
        let mut told = Document::new("changes", "Changes", "What changed");
        told.list(self.differences.clone());
        told.warn(&self.warnings);
        told.heading(format!("Changes at {} points", grouped(self.pairs)));
        let figures: Vec<Figure> =
            self.criteria.values().filter(|change| change.changed > 0).map(|change| change.figure.clone()).collect();
        if !figures.is_empty() {
            told.legend(legend());
            told.show("thirds", figures);
        }
        told.table(self.changes());
        for (name, change) in &self.criteria {
            if let Some(place) = &change.place {
                told.say(format!("{name} changed most, or changed sides, where {place}."));
            }
        }
        told.hint(self.rule);
        told.heading("Both results");
        told.table(self.counts());
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
        let row = |name: &str, [old, new]: [String; 2]| vec![name.to_owned(), old, new];
        let text = |value: &Option<String>| value.clone().unwrap_or(DASH.into());
        let short = |digest: &str| digest.chars().take(12).collect::<String>();
        let new_fmu = if self.as_packed { "as packed".to_owned() } else { short(&text(&self.new.from.fmu_sha256)) };
        let rows = vec![
            row("verdict", sides.map(|side| said(side.verdict))),
            row("points", sides.map(|side| grouped(side.points))),
            row("without a result", sides.map(|side| grouped(side.failed))),
            row("within all tolerances", sides.map(|side| grouped(side.verified))),
            row("accepted", sides.map(|side| side.accepted.map_or(DASH.into(), grouped))),
            row("model version", sides.map(|side| text(&side.from.fmu_version))),
            row("FMU, SHA-256", [short(&text(&self.old.from.fmu_sha256)), new_fmu]),
            row("study, SHA-256", sides.map(|side| short(&side.from.study_sha256))),
            row("program", sides.map(|side| side.from.orchestrator.clone())),
        ];
        Table::new("Both results", [words(""), numbers("Old"), numbers("New")], rows)
    }

    fn changes(&self) -> Table {
        let row = |(name, change): (&String, &Change)| {
            let largest = |said: fn(Largest) -> String| change.largest.map_or(DASH.into(), said);
            vec![
                with_unit(name, change.unit.as_deref().unwrap_or_default()),
                grouped(change.changed),
                grouped(change.beyond),
                change.numerical_uncertainty.map_or("not stated".into(), |u| number(u, 3)),
                number(change.mean, 3),
                largest(|at| number(at.new - at.old, 3)),
                largest(|at| number(100.0 * at.of_tolerance, 3)),
                largest(|at| at.point.to_string()),
                grouped(change.flipped.count),
                grouped(change.flipped_within.count),
            ]
        };
        Table {
            name: "Changes by criterion".into(),
            class: "stack".into(),
            columns: iter::once(words("Criterion"))
                .chain(
                    [
                        "Changed",
                        "Beyond",
                        "Uncertainty",
                        "Mean",
                        "Largest",
                        "% of tolerance",
                        "At point",
                        "Flipped",
                        "Within",
                    ]
                    .map(numbers),
                )
                .collect(),
            rows: self.criteria.iter().map(row).collect(),
        }
    }
}

fn legend() -> [Key; 4] {
    let key = |class, radius, words: &str| Key::new(class, &circle([7.0, 7.0], radius), words);
    [
        key("pt in", 3.0, "within the tolerance in both"),
        key("pt out", 3.0, "outside in both"),
        key("pt part", 4.5, "changed sides"),
        Key::new("nominal", "M1,13L13,1", "no change"),
    ]
}

/// The new values over the old ones, with the tolerances of both; of very many an even part, and all that changed sides.
pub fn scatter(
    name: &str,
    criteria: [&Criterion; 2],
    points: impl ExactSizeIterator<Item = ([f64; 2], [bool; 2])> + Clone,
) -> Figure {
    const MOST: usize = 2000;
    let [was, is] = criteria.map(|criterion| criterion.limits.ends());
    let values = points.clone().flat_map(|(values, _)| values);
    let range = axis_range(values, was[0].min(is[0]), was[1].max(is[1])).unwrap_or([0.0, 1.0]);
    let frame = Frame::new(360.0, 340.0, range, range);
    let unit = criteria[0].unit.as_deref().unwrap_or_default();
    let mut out = frame.axes(&with_unit("old", unit), Some(&with_unit("new", unit)));
    let (x, y) = (frame.x, frame.y);
    out += &area("accept", was.map(|end| x.clamped(end)), [y.from, y.to]);
    out += &area("accept", [x.from, x.to], is.map(|end| y.clamped(end)));
    out += &path("nominal", format_args!("M{:.1},{:.1}L{:.1},{:.1}", x.from, y.from, x.to, y.to));
    let every = points.len().div_ceil(MOST).max(1);
    let mut outside = 0;
    for (class, radius, sides) in
        [("out", 3.0, [[false; 2]; 2]), ("in", 3.0, [[true; 2]; 2]), ("part", 4.5, [[true, false], [false, true]])]
    {
        let (shown, hidden): (Vec<[f64; 2]>, Vec<[f64; 2]>) = points
            .clone()
            .enumerate()
            .filter(|(k, (_, ok))| sides.contains(ok) && (ok[0] != ok[1] || k % every == 0))
            .map(|(_, (values, _))| values)
            .partition(|[old, new]| x.contains(*old) && y.contains(*new));
        outside += hidden.len();
        let marks = shown.into_iter().map(|[old, new]| circle([x.at(old), y.at(new)], radius));
        out += &path(&format!("pt {class}"), marks.collect::<String>());
    }
    let mut note = match every {
        1 => String::new(),
        _ => format!("One point of {every} is drawn, and all that changed sides. "),
    };
    if outside > 0 {
        note += &format!("{} points lie outside the picture.", grouped(outside));
    }
    Figure {
        caption: name.to_owned(),
        svg: frame.wrap(&format!("{name}: new value over old value"), &out),
        note,
        ..Figure::default()
    }
}

/// Writes `compare.json` and `compare.html` into a folder.
///
/// # Errors
/// When the system says no.
pub fn write(comparison: &Comparison, folder: &Path) -> Result {
    make_output(folder)?;
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

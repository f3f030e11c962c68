//! A report from the folder that `verify` leaves behind.

use super::{Report, history, judgement::Judgement, outlook::comparison, whatif::WhatIf};
use crate::{
    error::{Error, Result},
    methods::{self, known::Finished},
    results::{
        Summary,
        answer::{self, Answer},
        choice, table,
        words::capitalised,
    },
};
use conformity::conclusion::grouped;
use conformity::decision::Decision;
use result_document::{Block, Document};
use std::path::Path;
use study::Study;

impl Report {
    /// Reads `summary.json` and `points.csv`, and `study.toml` where it is kept beside them.
    ///
    /// # Errors
    /// When there is no finished study in the folder, or one of the files is damaged.
    pub fn from_folder(folder: &Path) -> Result<Self> {
        let (summary, table) = table::read_some(folder, choice::MOST)?;
        let study_text = std::fs::read_to_string(folder.join("study.toml")).unwrap_or_default();
        let study = Study::parse(&folder.join("study.toml"), study_text.clone()).ok();
        let finished = Finished { folder, summary: &summary };
        let shown = methods::shown(&finished);
        let place = "Found as well (below)";
        let mut report = Self {
            command: command(&summary),
            judgement: Judgement::new(&summary)
                .map_err(|message| Error::content(&folder.join("summary.json"), message))?,
            history: history::read(folder, (&summary, &table), study.as_ref()),
            answer: Answer::new(&summary).beside(&summary, (&finished.names(), &shown), place),
            documents: documents(&summary, shown),
            study_text,
            table,
            summary,
            ..Self::default()
        };
        // Judging needs all criteria.
        if report.pictured().is_none() {
            report.whatif = WhatIf::new(&report.summary, study.as_ref(), report.table.len());
        }
        Ok(report)
    }
}

/// The study's documents beside its verdict.
fn documents(summary: &Summary, shown: Vec<Document>) -> Vec<Document> {
    let mut documents: Vec<Document> = comparison(summary).into_iter().chain(shown).collect();
    // What fits best does not change the verdict.
    let decision = summary.decision();
    let is_of_best = |document: &&mut Document| ["identification", "robustness"].contains(&&*document.id);
    for document in documents.iter_mut().filter(is_of_best).filter(|_| decision != Decision::Verified) {
        let looks = match &*document.id {
            "robustness" => "for the part of the space that may be accepted",
            _ => "for the best alone",
        };
        let told = format!("The verdict stays \"{decision}\": it counts all points, this section looks {looks}.");
        document.blocks.insert(0, Block::Sentence(told));
    }
    documents
}

/// The command that computes the result again, in the folder of the study.
fn command(summary: &Summary) -> String {
    let p = &summary.provenance;
    let study = &p.study;
    match (&p.fmu, p.method.as_str()) {
        (None, _) => format!("orchestrator judge {study} TABLE.csv"),
        (_, "table") => format!("orchestrator verify {study} --points-from TABLE.csv"),
        _ => {
            let seed = p.seed.map(|seed| format!(" --seed {seed}")).unwrap_or_default();
            format!("orchestrator verify {study} --points {}{seed}", summary.points)
        }
    }
}

/// How the points were computed, as far as a reader has to know it, and doubts about the verdict.
pub fn remarks(summary: &Summary, shown: usize) -> Vec<String> {
    let thinned = (summary.points > shown as u64).then(|| {
        format!(
            "all counts, shares and best points are those of all {} points; distributions, planes and median misses \
             are drawn from {} of them: one of every {} by chance, and the best",
            grouped(summary.points),
            grouped(shown),
            summary.points.div_ceil(choice::MOST)
        )
    });
    let (pictured, criteria) = (summary.pictured().len(), summary.criteria.len());
    let pictured = (pictured < criteria).then(|| {
        format!(
            "pictures and the table of best points show the {pictured} criteria that the fewest points meet, of {}; points.csv \
             has them all, and What if is left out",
            grouped(criteria)
        )
    });
    thinned
        .into_iter()
        .chain(pictured)
        .chain(answer::remarks(summary))
        .map(|remark| format!("{}.", capitalised(remark.trim_end_matches('.'))))
        .collect()
}

/// Versions, seed and hashes: all that is needed to compute the same again.
pub fn provenance(summary: &Summary) -> Vec<(String, String)> {
    let p = &summary.provenance;
    let rows = [
        ("Program", Some(format!("orchestrator {}", p.orchestrator))),
        ("Study", Some(p.study.clone())),
        ("Study SHA-256", Some(p.study_sha256.clone())),
        ("Model", p.fmu.clone()),
        ("Model version", p.fmu_version.clone()),
        ("FMU GUID", p.fmu_guid.clone()),
        ("FMU SHA-256", p.fmu_sha256.clone()),
        (
            "Design",
            Some(match p.replicates {
                Some(n) => format!("{}, {n} nets scrambled independently", p.method),
                None => p.method.clone(),
            }),
        ),
        ("Seed", p.seed.map(|seed| seed.to_string())),
        ("Points", Some(summary.points.to_string())),
        (
            "Wall time",
            summary
                .run
                .as_ref()
                .filter(|run| run.computed > 0)
                .map(|run| format!("{:.1} s with {} at a time", run.wall_seconds, run.jobs)),
        ),
    ]
    .into_iter()
    .filter_map(|(name, value)| Some((name.to_owned(), value?)));
    summary.dossier.iter().flatten().map(|(key, text)| (capitalised(key), text.clone())).chain(rows).collect()
}

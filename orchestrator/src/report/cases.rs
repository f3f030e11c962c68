//! The page's table of cases: how many points meet which criterion in which case.

use crate::document::format::{count, percent};
use crate::results::Summary;
use crate::study::cases::SEPARATOR;
use serde::Serialize;

/// Cases against criteria.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Cases {
    /// The criteria's names, each once.
    pub criteria: Vec<String>,
    /// A row per case.
    pub rows: Vec<CaseRow>,
}

/// A case.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct CaseRow {
    /// Its name.
    pub name: String,
    /// Whether it is held out.
    pub held_out: bool,
    /// Share of the points that meet each criterion; empty where the case has no such criterion.
    pub cells: Vec<String>,
    /// Points that hold in the case.
    pub count: String,
    /// Their share.
    pub percent: String,
    /// The interval of the share; none of a grid.
    pub interval: Option<[String; 2]>,
    /// Points without a result in this case.
    pub failed: String,
}

impl Cases {
    /// The cases of a study; none where it has none.
    pub fn new(summary: &Summary) -> Option<Self> {
        if summary.cases.is_empty() {
            return None;
        }
        let mut criteria: Vec<String> = Vec::new();
        for own in summary.criteria.keys().map(|name| short(name)) {
            if !criteria.iter().any(|known| known == own) {
                criteria.push(own.to_owned());
            }
        }
        let row = |(name, case): (&String, &crate::results::summary::CaseCount)| CaseRow {
            name: name.clone(),
            held_out: case.held_out,
            cells: criteria
                .iter()
                .map(|criterion| {
                    let full = format!("{name}{SEPARATOR}{criterion}");
                    let found = summary.criteria.get(&full);
                    found.map_or_else(String::new, |found| percent(found.count.fraction))
                })
                .collect(),
            count: count(case.count.passed as usize),
            percent: percent(case.count.fraction),
            interval: case.count.interval.map(|ends| ends.map(percent)),
            failed: count(case.failed as usize),
        };
        Some(Self {
            rows: summary.cases.iter().map(row).collect(),
            criteria,
        })
    }
}

/// A criterion's name without that of its case.
fn short(name: &str) -> &str {
    name.split_once(SEPARATOR).map_or(name, |(_, own)| own)
}

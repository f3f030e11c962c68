//! The first screen of a result, for terminal, page and notebook: what was asked, the answer, what decides it, and what to do
//! next.

use std::collections::BTreeSet;

use serde::{Deserialize, Serialize};

use super::{
    Summary,
    asides::Asides,
    by_surrogate::BySurrogate,
    resampled::presumed,
    settled::Settled,
    summary::{CriterionCount, FailureKind},
    surrogate,
    words::{accepted, beyond_validity, capitalised, few, guard, looked, unknown},
};
use conformity::{
    conclusion::{Conclusion, Requirement, grouped, in_percent},
    decision::Decision,
};
use fmu_points::Conduct;
use result_document::{Block, Document, format::number};
use study::concern::Concern;

/// What a reader has to know who reads no further.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Answer {
    /// How it is to be taken.
    pub sign: Sign,
    /// The verdict in a word or two.
    pub title: String,
    /// What was asked.
    pub asked: String,
    /// The answer in a sentence.
    pub answer: String,
    /// What decides it, the most important first. Doubts begin with their severity.
    pub decides: Vec<String>,
    /// What to do next, the most important first.
    pub next: Vec<String>,
}

/// How an answer is to be taken.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Sign {
    /// Verified.
    Yes,
    /// Verified, but with a warning, or most of the accepted points are expected not to conform.
    Doubt,
    /// Not verified.
    No,
    /// Inconclusive, or nothing was measured.
    #[default]
    Open,
}

impl Sign {
    /// The sign as a character.
    pub fn mark(self) -> char {
        match self {
            Self::Yes => '\u{2713}',
            Self::Doubt => '!',
            Self::No => '\u{2717}',
            Self::Open => '?',
        }
    }
}

impl Answer {
    /// The answer of a finished study.
    pub fn new(summary: &Summary) -> Self {
        let decision = summary.decision();
        let warned = odd(summary).is_some() || summary.warnings().next().is_some();
        let sign = match decision {
            _ if summary.has_own_values() => Sign::Open,
            Decision::Verified if warned || is_mostly_wrong(summary) => Sign::Doubt,
            Decision::Verified => Sign::Yes,
            Decision::NotVerified => Sign::No,
            Decision::Inconclusive => Sign::Open,
        };
        Self {
            sign,
            title: match sign {
                _ if summary.has_own_values() => "No measured value yet".to_owned(),
                Sign::Doubt => "Verified, with doubts".to_owned(),
                Sign::No if warned => "Not verified, with doubts".to_owned(),
                _ => capitalised(&decision.to_string()),
            },
            asked: asked(summary),
            answer: answer(summary, decision),
            decides: decides(summary),
            next: next(summary, decision),
        }
    }

    /// The same beside what the methods found in the same folder, with the names of study and folder in its commands; `place`
    /// says where that stands.
    #[must_use]
    pub fn beside(mut self, summary: &Summary, (names, documents): (&Names, &[Document]), place: &str) -> Self {
        if documents.iter().any(|document| document.id == "sensitivity") {
            self.next.retain(|sentence| sentence != SENSITIVE);
        }
        if let Some(found) = found(documents, summary) {
            // What doubts the verdict, and what explains it, stand before it.
            let explained = usize::from(summary.surrogate.is_some()) + summary.causes.len();
            let doubted = self.decides.iter().rposition(|sentence| sentence.starts_with("Warning: "));
            let behind = explained.min(self.decides.len()).max(doubted.map_or(0, |last| last + 1));
            self.decides.insert(behind, format!("{place}: {found}."));
        }
        let placed = |sentence: &mut String| {
            let Names { study, output, folder } = names;
            for (mark, name) in [("{study}", study), ("{output}", output), ("{folder}", folder)] {
                *sentence = sentence.replace(mark, name);
            }
        };
        self.next.iter_mut().for_each(placed);
        self
    }
}

/// Study and folder as one names them in a command.
#[derive(Default)]
pub struct Names {
    /// The study.
    pub study: String,
    /// The option for the folder, with a blank before it, where that is another one than the study has by itself.
    pub output: String,
    /// The folder.
    pub folder: String,
}

impl Names {
    /// Of results without a folder.
    pub fn of(summary: &Summary) -> Self {
        Self { study: summary.provenance.study.clone(), ..Self::default() }
    }
}

/// What the methods found, each in a few words. What explains the verdict stands there anyway.
fn found(documents: &[Document], summary: &Summary) -> Option<String> {
    const SHOWN: usize = 3;
    let told: Vec<String> = documents
        .iter()
        .filter(|document| document.id != "identification" || summary.causes.is_empty())
        .filter_map(|document| {
            let mut sentences = document.blocks.iter().filter_map(|block| match block {
                Block::Sentence(text) => Some(text.as_str()),
                _ => None,
            });
            let said = match &*document.id {
                "sensitivity" => document
                    .figures()
                    .into_iter()
                    .filter(|figure| !figure.note.is_empty())
                    .take(SHOWN)
                    .map(|figure| format!("{}: {}", figure.caption, figure.note.trim_end_matches('.')))
                    .collect::<Vec<_>>()
                    .join("; "),
                "tolerances" => sentences.next_back()?.to_owned(),
                "identification" => {
                    let all: Vec<&str> = sentences.collect();
                    let cause = all.iter().find(|said| said.contains("ikeliest cause"));
                    (*cause.or(all.first())?).to_owned()
                }
                _ => sentences.next()?.to_owned(),
            };
            Some(format!("{} ({})", document.link, said.trim_end_matches('.')))
        })
        .collect();
    (!told.is_empty()).then(|| told.join(", "))
}

/// Where to read which parameter decides.
const SENSITIVE: &str =
    "`orchestrator sensitivity {study} --from {folder}` tells which parameter decides, without a further run.";

fn is_mostly_wrong(summary: &Summary) -> bool {
    const MOST: f64 = 0.5;
    let risk = summary.conclusion.as_ref().and_then(|c| c.risk.as_ref());
    risk.and_then(|risk| risk.not_conforming_given_accepted).is_some_and(|share| share > MOST)
}

/// How points ran, where they did not run alone.
fn company(summary: &Summary) -> Option<String> {
    let conduct = summary.conduct.as_ref()?;
    conduct.company().map(|text| format!("{}.", capitalised(text)))
}

/// What the points' own runs say against all results.
fn odd(summary: &Summary) -> Option<String> {
    let conduct = summary.conduct.as_ref()?;
    conduct.remarks().into_iter().next().filter(|_| conduct.reproducible == Some(false))
}

fn criteria(summary: &Summary) -> String {
    match (summary.criteria.len(), summary.cases.len()) {
        (1, _) => "the criterion".to_owned(),
        (2, 0 | 1) => "both criteria".to_owned(),
        (n, 0 | 1) => format!("all {n} criteria"),
        (n, cases) => format!("all {n} criteria of {cases} cases"),
    }
}

fn asked(summary: &Summary) -> String {
    if summary.has_own_values() {
        return "How far do the outputs move with the parameters, from the values of one run of the model?".to_owned();
    }
    let criteria = criteria(summary);
    let guarded = match &summary.conclusion {
        Some(Conclusion { point_risk: Some(risk), .. }) => {
            format!(", with a conformance probability of {} % or more,", in_percent(1.0 - risk))
        }
        Some(Conclusion { guard_band: Some(0.0), .. }) | None => String::new(),
        Some(_) => ", less the guard bands,".to_owned(),
    };
    match summary.required() {
        Some(Requirement { rule, .. }) => format!(
            "Does the model meet {criteria}{guarded} in {} % of the sampled space or more?",
            in_percent(rule.share)
        ),
        None => format!("Does the model meet {criteria} at one sampled point or more?"),
    }
}

fn answer(summary: &Summary, decision: Decision) -> String {
    let words = summary.conclusion.as_ref().map(|c| &*c.verdict_words);
    let own = || {
        let reason = words.and_then(|words| words.split_once(": "));
        format!("{}.", capitalised(reason.map_or("", |(_, reason)| reason)))
    };
    let points = match summary.points {
        1 => "1 point".to_owned(),
        n => format!("{} points", grouped(n)),
    };
    if summary.failed == summary.points {
        return own();
    }
    if summary.has_own_values() {
        return format!("{} {}", moves(summary), own());
    }
    let by = surrogate::way(summary);
    let Some(requirement) = summary.required() else {
        let interval =
            summary.verified_interval.map_or_else(String::new, |ends| format!(", 95 % interval {}", range(ends)));
        let of = if by.is_empty() { "" } else { " of the space" };
        let share = format!("{:.1} %{of}{interval}{by}", 100.0 * summary.verified_fraction);
        return match summary.verified {
            0 => format!("No: it does at none of {points} ({share})."),
            n => format!(
                "The model can be right: it meets {} at {} of {points} ({share}).",
                criteria(summary),
                grouped(n)
            ),
        };
    };
    let Some(interval) = requirement.interval else {
        return own();
    };
    let space =
        format!("{} of the space at a confidence of {} %", range(interval), in_percent(requirement.rule.confidence));
    let accepted = summary.conclusion.as_ref().map_or(0, |c| c.accepted);
    let (open, found) = match &summary.surrogate {
        Some(_) => {
            let way = by.trim_matches([' ', '(', ')']);
            ("The runs do not tell:", format!("{way}, it does in {space}"))
        }
        None => ("The points do not tell: it does", format!("at {} of {points}, which is {space}", grouped(accepted))),
    };
    match decision {
        Decision::Verified => format!("Yes: {found}."),
        Decision::NotVerified => format!("No: {found}."),
        Decision::Inconclusive => format!("{open} {found}."),
    }
}

/// How far the criteria's values go within the parameters' ranges.
fn moves(summary: &Summary) -> String {
    const NAMED: usize = 3;
    let range = |(name, entry): (&String, &CriterionCount)| {
        let [low, high] = entry.reached?.map(|end| number(end, 4));
        Some(format!("{name} {low} .. {high}{}", entry.criterion.unit_behind()))
    };
    let all: Vec<String> = summary.criteria.iter().filter_map(range).collect();
    let more = match all.len().saturating_sub(NAMED) {
        0 => String::new(),
        n => format!(", and {n} more"),
    };
    format!("{}{more}.", all[..all.len().min(NAMED)].join(", "))
}

fn decides(summary: &Summary) -> Vec<String> {
    let conclusion = summary.conclusion.as_ref().filter(|_| summary.is_compared());
    // Points near the limits miss criteria more often than others.
    let mut decisive = conclusion.filter(|_| summary.surrogate.is_none()).and_then(|_| decisive(summary));
    let surrogate = summary.surrogate.iter().map(BySurrogate::sentence);
    let first = [
        conclusion.filter(|c| c.verdict == Decision::Inconclusive).and_then(|c| undecided(c, summary)),
        decisive.take_if(|_| summary.decision() == Decision::NotVerified),
        conclusion.map(|conclusion| match &conclusion.risk {
            Some(risk) => accepted(conclusion.accepted, risk, summary),
            None => unknown(summary),
        }),
        conclusion.and_then(|conclusion| few(conclusion, summary)),
        odd(summary).map(|odd| format!("Warning: {odd}.")),
        company(summary),
    ];
    let last = [conclusion.and_then(|_| beyond_validity(summary)), conclusion.and_then(guard), decisive];
    let sentences = surrogate.chain(summary.causes.iter().cloned()).chain(first.into_iter().flatten());
    sentences.chain(doubts(summary)).chain(last.into_iter().flatten()).collect()
}

/// How the points were computed, and doubts as a whole.
pub fn remarks(summary: &Summary) -> Vec<String> {
    let conduct = summary.conduct.iter().flat_map(Conduct::remarks);
    let asides = summary.asides.iter().flat_map(Asides::remarks);
    let watched = summary.settled.iter().filter_map(Settled::remark);
    let left_out = summary.left_out.iter().map(|text| format!("left out: {text}"));
    // The first of each kind stands on the first screen.
    let all = &summary.concerns;
    let further_of_kind = |(k, concern): &(usize, &Concern)| all[..*k].iter().any(|first| first.code == concern.code);
    let doubts = all.iter().enumerate().filter(further_of_kind);
    let doubts = doubts.map(|(_, concern)| format!("{}: {concern}", concern.severity.name()));
    let computed = conduct.chain(asides).chain(left_out).chain(watched);
    computed.chain(doubts).chain(further(summary)).collect()
}

/// How often one has looked, and what the risks presume.
fn further(summary: &Summary) -> Vec<String> {
    let Some(conclusion) = summary.conclusion.as_ref().filter(|_| summary.is_compared()) else {
        return Vec::new();
    };
    looked(conclusion).into_iter().chain(presumed(summary)).collect()
}

/// Doubts; those of one kind are told of the first criterion, with the names of the others.
fn doubts(summary: &Summary) -> Vec<String> {
    let mut told: Vec<(&Concern, Vec<&str>)> = Vec::new();
    for concern in &summary.concerns {
        let name = concern.text.split_once(": ").map(|(name, _)| name);
        let name = name.filter(|name| summary.criteria.contains_key(*name));
        let same = told.iter_mut().find(|(first, _)| first.code == concern.code);
        match (same, name) {
            (Some((_, names)), Some(name)) => names.push(name),
            _ => told.push((concern, Vec::new())),
        }
    }
    let sentence = |(concern, names): (&Concern, Vec<&str>)| {
        let others = match &names[..] {
            [] => String::new(),
            [named @ .., _, _] if named.len() > 1 => {
                format!(" (as well: {}, and {} more)", named[..2].join(", "), names.len() - 2)
            }
            names => format!(" (as well: {})", names.join(", ")),
        };
        // The title says it.
        let title = "no measured value yet: ";
        let doubt = concern.text.strip_prefix(title).unwrap_or(&concern.text);
        capitalised(&format!("{}: {doubt}{others}.", concern.severity.name()))
    };
    told.into_iter().map(sentence).collect()
}

/// The criterion that the fewest points meet.
fn decisive(summary: &Summary) -> Option<String> {
    let (name, count) = summary.criteria.iter().min_by_key(|(_, entry)| entry.count.passed)?;
    let missed = summary.points - summary.failed - count.count.passed;
    let only = match count.only_failure {
        0 => String::new(),
        n => format!(", {} of them miss nothing else", grouped(n)),
    };
    (missed > 0 && summary.criteria.len() > 1).then(|| {
        format!("{name} decides most often: {} of {} points miss it{only}.", grouped(missed), grouped(summary.points))
    })
}

fn next(summary: &Summary, decision: Decision) -> Vec<String> {
    let mut list = Vec::new();
    let mut seen = BTreeSet::new();
    let remedies = summary.concerns.iter().flat_map(|c| &c.remedy);
    list.extend(remedies.filter(|remedy| seen.insert(*remedy)).cloned());
    if let Some(FailureKind { first: failed, .. }) = summary.failure_kinds.first() {
        list.push(format!("The first failure is point {}: {}.", failed.point, failed.status.trim_end_matches('.')));
    }
    if summary.failed == summary.points || summary.has_own_values() {
        return list;
    }
    let conclusion = summary.conclusion.as_ref();
    match decision {
        Decision::Verified => {
            if conclusion.is_some_and(|conclusion| conclusion.risk.is_none()) {
                list.push("State every measured value's `uncertainty`: then the risk is known.".to_owned());
            }
            list.extend((!summary.parameters.is_empty()).then(|| SENSITIVE.to_owned()));
        }
        Decision::NotVerified => {
            let told = if summary.causes.is_empty() {
                "finds the parameters that fit best, and what would explain that none does"
            } else {
                "tells the evidence, as Identification on the page does: correct what is wrong, and verify again"
            };
            // Runs that were dear still are.
            let by_surrogate = summary.surrogate.as_ref();
            let budget = by_surrogate.map(|by| format!(" --budget {}", by.runs + 30)).unwrap_or_default();
            list.push(format!("`orchestrator identify {{study}}{{output}}{budget}` {told}."));
            list.extend(nearest(summary));
        }
        Decision::Inconclusive => list.extend(match &summary.surrogate {
            None => conclusion.and_then(|conclusion| needed(conclusion, summary)),
            Some(by) => Some(format!(
                "`orchestrator verify {{study}}{{output}} --resume --budget {}` goes on from these runs.",
                2 * by.runs
            )),
        }),
    }
    list
}

/// How far the nearest point is from being accepted.
fn nearest(summary: &Summary) -> Option<String> {
    let best = summary.best_point.as_ref()?;
    let off = best.values.iter().filter_map(|(name, &value)| {
        let criterion = &summary.criteria.get(name)?.criterion;
        Some((criterion.deviation(value), name, criterion, value))
    });
    let only = off.clone().filter(|(off, ..)| *off > 1.0).count() == 1;
    let (off, name, criterion, value) = off.max_by(|a, b| a.0.total_cmp(&b.0))?;
    (off > 1.0).then(|| {
        format!(
            "The nearest point, {}, misses {}: {value:.5}{}, accepted {}.",
            best.point,
            if only { format!("only {name}") } else { format!("{name} most") },
            criterion.unit_behind(),
            criterion.wanted()
        )
    })
}

/// What keeps the verdict open.
fn undecided(conclusion: &Conclusion, summary: &Summary) -> Option<String> {
    let Requirement { rule, interval, .. } = conclusion.required.as_ref()?;
    let more = if summary.surrogate.is_some() { "runs" } else { "points" };
    interval.as_ref()?;
    Some(format!("The required {} % lie inside that range: more {more} narrow it.", in_percent(rule.share)))
}

/// How many points decide. Those of a table come from elsewhere: no command adds to them.
fn needed(conclusion: &Conclusion, summary: &Summary) -> Option<String> {
    let required = conclusion.required.as_ref()?;
    let (once, going_on) = (required.points_needed?, required.points_needed_going_on?);
    let more = match summary.provenance.method.as_str() {
        "table" => String::new(),
        _ => format!(
            ", or {} if this run goes on: `orchestrator verify {{study}}{{output}} --resume --points {going_on}`",
            grouped(going_on)
        ),
    };
    Some(format!("If the share stays what it is, about {} points decide, computed anew{more}.", grouped(once)))
}

fn range(ends: [f64; 2]) -> String {
    let [low, high] = ends.map(|end| 100.0 * end);
    format!("{low:.1} .. {high:.1} %")
}

#[cfg(test)]
mod tests;

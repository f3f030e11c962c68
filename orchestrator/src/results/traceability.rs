//! Where results come from, as SSP Traceability 1.0 writes it: meta data of a file (SRMD) and of the whole task (STMD).

use super::Summary;
use super::summary::{CriterionCount, ParameterSummary};
use conformity::conclusion::Conclusion;
use conformity::measured::Limits;
use fmu_import::digest;
use minijinja::{context, value::Serde};
use study::ssv::filled;

/// A keyword and what is known under it.
pub type Entry = (String, String);

/// The origin of the points: study, FMU, design, versions and hashes.
pub fn origin(summary: &Summary) -> Vec<Entry> {
    let from = &summary.provenance;
    known([
        ("orchestrator.version", Some(from.orchestrator.clone())),
        ("study", Some(from.study.clone())),
        ("study.sha256", Some(from.study_sha256.clone())),
        ("fmu", from.fmu.clone()),
        ("fmu.version", from.fmu_version.clone()),
        ("fmu.guid", from.fmu_guid.clone()),
        ("fmu.sha256", from.fmu_sha256.clone()),
        ("design", Some(from.method.clone())),
        ("replicates", from.replicates.map(|n| n.to_string())),
        ("seed", from.seed.map(|seed| seed.to_string())),
        ("points", Some(summary.points.to_string())),
    ])
}

fn known<const N: usize>(entries: [(&str, Option<String>); N]) -> Vec<Entry> {
    let entries = entries.into_iter();
    entries.filter_map(|(keyword, value)| Some((keyword.to_owned(), value?))).collect()
}

/// The verdict with its rule and its risks.
pub fn verdict(summary: &Summary) -> Vec<Entry> {
    let Some(conclusion) = &summary.conclusion else {
        return Vec::new();
    };
    let Conclusion { required, risk, .. } = conclusion;
    let number = |value: f64| value.to_string();
    let required = required.as_ref();
    let mut entries = known([
        ("verdict", Some(conclusion.verdict.to_string())),
        ("verdict.words", Some(conclusion.verdict_words.clone())),
        ("required.share", required.map(|r| number(r.rule.share))),
        ("required.confidence", required.map(|r| number(r.rule.confidence))),
        ("failed", Some(summary.failed.to_string())),
        ("verified", Some(summary.verified.to_string())),
        ("accepted", Some(conclusion.accepted.to_string())),
        ("guard-band", conclusion.guard_band.map(number)),
        ("point-risk", conclusion.point_risk.map(number)),
    ]);
    if let Some(risk) = risk {
        let given = risk.not_conforming_given_accepted;
        entries.extend(known([
            ("risk.consumer", Some(number(risk.consumer))),
            ("risk.producer", Some(number(risk.producer))),
            ("risk.conformance-probability", Some(number(risk.conformance_probability))),
            ("risk.not-conforming-given-accepted", given.map(number)),
        ]));
    }
    entries
}

/// The sampled distributions.
pub fn parameters(summary: &Summary) -> Vec<Entry> {
    let entry = |p: &ParameterSummary| (format!("parameter.{}", p.name), p.words());
    summary.parameters.iter().map(entry).collect()
}

/// The measured values with their tolerances and uncertainties.
pub fn criteria(summary: &Summary) -> Vec<Entry> {
    let entry = |(name, entry): (&String, &CriterionCount)| {
        let c = &entry.criterion;
        let unit = c.unit_behind();
        let uncertainty = c.uncertainty.map_or_else(|| "uncertainty not stated".to_owned(), |u| u.words(&unit));
        let Limits { about, minus, plus } = c.limits;
        let wanted = match (minus == plus, c.limits.is_one_sided(), c.reading) {
            (true, ..) => format!("{about}{unit}, tolerance {plus}{unit}"),
            (_, false, _) => format!("{about}{unit}, tolerance -{minus}/+{plus}{unit}"),
            (_, _, None) => c.stated_tolerance.clone(),
            (_, _, Some(reading)) => format!("{}, measured {reading}{unit}", c.stated_tolerance),
        };
        let words = format!("{}: {wanted}, {uncertainty}", c.source());
        (format!("criterion.{name}"), words)
    };
    let pair = |entry: &super::summary::Correlated| {
        let [a, b] = &entry.between;
        (format!("uncertainty-correlation.{a}.{b}"), entry.coefficient.to_string())
    };
    let pairs = summary.uncertainty_correlations.iter().map(pair);
    summary.criteria.iter().map(entry).chain(pairs).collect()
}

/// Who answers for the verdict and on which test it rests, as far as the study says it, and when it was found.
pub fn dossier(summary: &Summary) -> Vec<Entry> {
    let stated = summary.dossier.iter().flat_map(|dossier| dossier.stated());
    let stated = stated.map(|(key, text)| (format!("dossier.{key}"), text.to_owned()));
    let run = summary.run.iter();
    let date = run.map(|run| ("date".to_owned(), run.date.clone()));
    stated.chain(date).collect()
}

/// Meta data of a file.
pub fn resource(name: &str, data: &str, entries: &[Entry]) -> String {
    let values = context! { name, data, entries => Serde(entries) };
    filled(include_str!("resource.xml"), values)
}

/// Meta data of the whole task, from the requirements to the verdict.
pub fn task(summary: &Summary) -> String {
    let parts = [dossier, criteria, parameters, origin, verdict].map(|part| part(summary));
    let all = parts.iter().flatten();
    let text: Vec<String> = all.map(|(keyword, value)| format!("{keyword}={value}")).collect();
    let [dossier, criteria, parameters, origin, verdict] = &parts;
    let stated = summary.dossier.clone().unwrap_or_default();
    let values = context! {
        name => summary.title.as_deref().unwrap_or(&summary.provenance.study),
        id => identifier(&digest(text.join("\n").as_bytes())),
        tool => format!("orchestrator {}", summary.provenance.orchestrator),
        responsible => stated.responsible,
        organisation => stated.organisation,
        date => summary.run.as_ref().map(|run| &*run.date),
        dossier => Serde(dossier),
        criteria => Serde(criteria),
        parameters => Serde(parameters),
        origin => Serde(origin),
        verdict => Serde(verdict),
    };
    filled(include_str!("task.xml"), values)
}

/// An identifier in the usual form of one, from the content's digest: other content has another one.
fn identifier(digest: &str) -> String {
    let parts = [0..8, 8..12, 12..16, 16..20, 20..32];
    parts.map(|part| &digest[part]).join("-")
}

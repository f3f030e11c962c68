//! Where results come from, as SSP Traceability 1.0 writes it: meta data of a file (SRMD) and of the whole task (STMD).

use super::Summary;
use super::summary::{CriterionCount, ParameterSummary};
use crate::study::ssv::Element;
use conformity::conclusion::Conclusion;
use fmu_import::digest;

const RESOURCE: &str = "http://ssp-standard.org/SSPTraceability1/SimulationResourceMetaData";
const TASK: &str = "http://ssp-standard.org/SSPTraceability1/SimulationTaskMetaData";
const COMMON: &str = "http://ssp-standard.org/SSPTraceability1/SSPTraceabilityCommon";
const CLASSIFICATION: &str = "orchestrator.verification";

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
    entries
        .filter_map(|(keyword, value)| Some((keyword.to_owned(), value?)))
        .collect()
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
        (
            "required.confidence",
            required.map(|r| number(r.rule.confidence)),
        ),
        ("failed", Some(summary.failed.to_string())),
        ("verified", Some(summary.verified.to_string())),
        ("accepted", Some(conclusion.accepted.to_string())),
        ("guard-band", conclusion.guard_band.map(number)),
    ]);
    if let Some(risk) = risk {
        let given = risk.not_conforming_given_accepted;
        entries.extend(known([
            ("risk.consumer", Some(number(risk.consumer))),
            ("risk.producer", Some(number(risk.producer))),
            (
                "risk.conformance-probability",
                Some(number(risk.conformance_probability)),
            ),
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
        let uncertainty = c.uncertainty.map_or_else(
            || "uncertainty not stated".to_owned(),
            |u| format!("uncertainty {}{unit} (k = {})", u.expanded, u.coverage),
        );
        let words = format!(
            "{}: {}{unit}, tolerance {}{unit}, {uncertainty}",
            c.source(),
            c.nominal,
            c.tolerance
        );
        (format!("criterion.{name}"), words)
    };
    let pair = |entry: &super::summary::Correlated| {
        let [a, b] = &entry.between;
        (
            format!("uncertainty-correlation.{a}.{b}"),
            entry.coefficient.to_string(),
        )
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
    let root = Element::new("srmd:SimulationResourceMetaData").attributes([
        ("xmlns:srmd", RESOURCE),
        ("xmlns:stc", COMMON),
        ("version", "1.0.0"),
        ("name", name),
        ("data", data),
    ]);
    root.with(classification(entries)).document()
}

fn classification(entries: &[Entry]) -> Option<Element> {
    let entry = |(keyword, value): &Entry| {
        Element::new("stc:ClassificationEntry")
            .attributes([("keyword", keyword.as_str())])
            .text(value)
    };
    (!entries.is_empty()).then(|| {
        Element::new("stc:Classification")
            .attributes([("type", CLASSIFICATION)])
            .with(entries.iter().map(entry))
    })
}

/// A file of the task: its kind in the words of the standard, its type, its name.
type File = (&'static str, &'static str, &'static str);

const STUDY: File = ("requirement", "application/toml", "study.toml");
const POINTS: File = ("result", "text/csv", "points.csv");
const SUMMARY: File = ("result", "application/json", "summary.json");
const PAGE: File = ("report", "text/html", "report.html");

/// A step of the task: its phase and name, what went in, how it was done, what came out.
#[derive(Default)]
struct Step {
    phase: &'static str,
    name: &'static str,
    input: &'static [File],
    procedure: Vec<Entry>,
    output: &'static [File],
    result: Vec<Entry>,
}

/// Meta data of the whole task, from the requirements to the verdict.
pub fn task(summary: &Summary) -> String {
    let steps = steps(summary);
    let all = steps.iter();
    let all = all.flat_map(|step| step.procedure.iter().chain(&step.result));
    let text: Vec<String> = all
        .map(|(keyword, value)| format!("{keyword}={value}"))
        .collect();
    let id = identifier(&digest(text.join("\n").as_bytes()));
    let tool = format!("orchestrator {}", summary.provenance.orchestrator);
    let name = summary.title.as_ref().unwrap_or(&summary.provenance.study);
    let dossier = summary.dossier.as_ref();
    let author = dossier.and_then(|dossier| dossier.responsible.as_ref());
    let date = summary.run.as_ref().map(|run| &run.date);
    let root = Element::new("stmd:SimulationTaskMetaData").attributes([
        ("xmlns:stmd", TASK),
        ("xmlns:stc", COMMON),
        ("version", "1.0.0"),
        ("name", name),
        ("GUID", &id),
        ("generationTool", &tool),
    ]);
    root.attributes(author.map(|author| ("author", author)))
        .attributes(date.map(|date| ("generationDateAndTime", date)))
        .with(steps.iter().map(|step| phase(step, summary)))
        .document()
}

/// Every phase has one step here, in the order of the standard.
fn steps(summary: &Summary) -> [Step; 6] {
    [
        Step {
            phase: "stmd:AnalysisPhase",
            name: "stmd:AnalyzeSimulationTaskAndObjectives",
            input: &[STUDY],
            result: dossier(summary),
            ..Step::default()
        },
        Step {
            phase: "stmd:RequirementsPhase",
            name: "stmd:DefineTestCaseRequirements",
            input: &[STUDY],
            result: criteria(summary),
            ..Step::default()
        },
        Step {
            phase: "stmd:DesignPhase",
            name: "stmd:DefineParameterDesignSpecification",
            input: &[STUDY],
            result: parameters(summary),
            ..Step::default()
        },
        Step {
            phase: "stmd:ExecutionPhase",
            name: "stmd:ExecuteSimulation",
            input: &[STUDY],
            procedure: origin(summary),
            output: &[POINTS],
            ..Step::default()
        },
        Step {
            phase: "stmd:EvaluationPhase",
            name: "stmd:EvaluateSimulationResults",
            input: &[POINTS],
            output: &[SUMMARY, PAGE],
            ..Step::default()
        },
        Step {
            phase: "stmd:FulfillmentPhase",
            name: "stmd:DecideSimulationObjectiveFulfillment",
            input: &[SUMMARY],
            output: &[PAGE],
            result: verdict(summary),
            ..Step::default()
        },
    ]
}

fn phase(step: &Step, summary: &Summary) -> Element {
    let inner = Element::new(step.name)
        .with(particle("stc:Input", step.input, &[]))
        .with(particle("stc:Procedure", &[], &step.procedure))
        .with(particle("stc:Output", step.output, &[]));
    let decided = step.phase == "stmd:FulfillmentPhase";
    let inner = inner.with(decided.then(|| draft(summary)).flatten());
    Element::new(step.phase).with([inner.with(classification(&step.result))])
}

fn particle(name: &'static str, files: &[File], entries: &[Entry]) -> Option<Element> {
    let resource = |&(kind, of_text, source): &File| {
        let attributes = [("kind", kind), ("type", of_text), ("source", source)];
        Element::new("stc:Resource").attributes(attributes)
    };
    (!files.is_empty() || !entries.is_empty()).then(|| {
        Element::new(name)
            .with(files.iter().map(resource))
            .with(classification(entries))
    })
}

/// The verdict is a draft of the one who answers for it, until it is signed.
fn draft(summary: &Summary) -> Option<Element> {
    let (dossier, run) = (summary.dossier.as_ref()?, summary.run.as_ref()?);
    let organisation = dossier.organisation.as_ref();
    let responsible = Element::new("stc:Responsible")
        .attributes(organisation.map(|text| ("organization", text)))
        .attributes([("name", dossier.responsible.as_ref()?)]);
    let drafted = Element::new("stc:Drafted")
        .attributes([("date", &run.date)])
        .with([responsible]);
    Some(Element::new("stc:LifeCycleInformation").with([drafted]))
}

/// An identifier in the usual form of one, from the content's digest: other content has another one.
fn identifier(digest: &str) -> String {
    let parts = [0..8, 8..12, 12..16, 16..20, 20..32];
    parts.map(|part| &digest[part]).join("-")
}

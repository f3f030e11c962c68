//! Where results come from, as SSP Traceability 1.0 writes it: meta data of a file (SRMD) and of the whole task (STMD).

use std::io;

use quick_xml::events::BytesText;

use super::Summary;
use super::conclusion::Conclusion;
use super::summary::{CriterionCount, ParameterSummary};
use crate::study::ssv::{Xml, document, printable};
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
        let unit = c
            .unit
            .as_deref()
            .map_or_else(String::new, |u| format!(" {u}"));
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
    let date = summary
        .run
        .iter()
        .map(|run| ("date".to_owned(), run.date.clone()));
    stated.chain(date).collect()
}

/// Meta data of a file.
///
/// # Errors
/// Never: memory takes whatever is written.
pub fn resource(name: &str, data: &str, entries: &[Entry]) -> io::Result<String> {
    document(|xml| {
        let (name, data) = (printable(name), printable(data));
        let root = xml.create_element("srmd:SimulationResourceMetaData");
        let root = root.with_attributes([
            ("xmlns:srmd", RESOURCE),
            ("xmlns:stc", COMMON),
            ("version", "1.0.0"),
            ("name", &name),
            ("data", &data),
        ]);
        root.write_inner_content(|xml| classification(xml, entries))?;
        Ok(())
    })
}

fn classification(xml: &mut Xml, entries: &[Entry]) -> io::Result<()> {
    if entries.is_empty() {
        return Ok(());
    }
    let classification = xml.create_element("stc:Classification");
    let classification = classification.with_attribute(("type", CLASSIFICATION));
    classification.write_inner_content(|xml| {
        entries.iter().try_for_each(|(keyword, value)| {
            let entry = xml.create_element("stc:ClassificationEntry");
            let entry = entry.with_attribute(("keyword", &*printable(keyword)));
            let value = printable(value);
            entry.write_text_content(BytesText::new(&value)).map(drop)
        })
    })?;
    Ok(())
}

/// A file of the task: its kind in the words of the standard, its type, its name.
type File = (&'static str, &'static str, &'static str);

const STUDY: File = ("requirement", "application/toml", "study.toml");
const POINTS: File = ("result", "text/csv", "points.csv");
const SUMMARY: File = ("result", "application/json", "summary.json");
const PAGE: File = ("report", "text/html", "report.html");

/// A step of the task: its phase and name, what went in, how it was done, what came out.
struct Step {
    phase: &'static str,
    name: &'static str,
    input: &'static [File],
    procedure: Vec<Entry>,
    output: &'static [File],
    found: Vec<Entry>,
}

/// Meta data of the whole task, from the requirements to the verdict.
///
/// # Errors
/// Never: memory takes whatever is written.
pub fn task(summary: &Summary) -> io::Result<String> {
    let steps = steps(summary);
    let all = steps
        .iter()
        .flat_map(|s| s.procedure.iter().chain(&s.found));
    let text: Vec<String> = all
        .map(|(keyword, value)| format!("{keyword}={value}"))
        .collect();
    let id = identifier(&digest(text.join("\n").as_bytes()));
    let tool = format!("orchestrator {}", summary.provenance.orchestrator);
    let name = summary.title.as_deref();
    let name = printable(name.unwrap_or(&summary.provenance.study));
    let author = summary
        .dossier
        .as_ref()
        .and_then(|d| d.responsible.as_deref());
    let date = summary.run.as_ref().map(|run| run.date.as_str());
    document(|xml| {
        let root = xml.create_element("stmd:SimulationTaskMetaData");
        let root = root.with_attributes([
            ("xmlns:stmd", TASK),
            ("xmlns:stc", COMMON),
            ("version", "1.0.0"),
            ("name", &name),
            ("GUID", &id),
            ("generationTool", &tool),
        ]);
        let root = root.with_attributes(author.map(|author| ("author", printable(author))));
        let root = root.with_attributes(date.map(|date| ("generationDateAndTime", date)));
        root.write_inner_content(|xml| steps.iter().try_for_each(|s| step(xml, s, summary)))?;
        Ok(())
    })
}

/// Every phase has one step here, in the order of the standard.
fn steps(summary: &Summary) -> Vec<Step> {
    let entry = |phase, name| Step {
        phase,
        name,
        input: &[],
        procedure: Vec::new(),
        output: &[],
        found: Vec::new(),
    };
    vec![
        Step {
            input: &[STUDY],
            found: dossier(summary),
            ..entry(
                "stmd:AnalysisPhase",
                "stmd:AnalyzeSimulationTaskAndObjectives",
            )
        },
        Step {
            input: &[STUDY],
            found: criteria(summary),
            ..entry("stmd:RequirementsPhase", "stmd:DefineTestCaseRequirements")
        },
        Step {
            input: &[STUDY],
            found: parameters(summary),
            ..entry(
                "stmd:DesignPhase",
                "stmd:DefineParameterDesignSpecification",
            )
        },
        Step {
            input: &[STUDY],
            procedure: origin(summary),
            output: &[POINTS],
            ..entry("stmd:ExecutionPhase", "stmd:ExecuteSimulation")
        },
        Step {
            input: &[POINTS],
            output: &[SUMMARY, PAGE],
            ..entry("stmd:EvaluationPhase", "stmd:EvaluateSimulationResults")
        },
        Step {
            input: &[SUMMARY],
            output: &[PAGE],
            found: verdict(summary),
            ..entry(
                "stmd:FulfillmentPhase",
                "stmd:DecideSimulationObjectiveFulfillment",
            )
        },
    ]
}

fn step(xml: &mut Xml, step: &Step, summary: &Summary) -> io::Result<()> {
    let phase = xml.create_element(step.phase);
    phase.write_inner_content(|xml| {
        let inner = xml.create_element(step.name);
        inner.write_inner_content(|xml| {
            particle(xml, "stc:Input", step.input, &[])?;
            particle(xml, "stc:Procedure", &[], &step.procedure)?;
            particle(xml, "stc:Output", step.output, &[])?;
            if step.phase == "stmd:FulfillmentPhase" {
                draft(xml, summary)?;
            }
            classification(xml, &step.found)
        })?;
        Ok(())
    })?;
    Ok(())
}

fn particle(xml: &mut Xml, name: &str, files: &[File], entries: &[Entry]) -> io::Result<()> {
    if files.is_empty() && entries.is_empty() {
        return Ok(());
    }
    let particle = xml.create_element(name);
    particle.write_inner_content(|xml| {
        for (kind, kind_of_text, source) in files {
            let resource = xml.create_element("stc:Resource");
            resource
                .with_attributes([("kind", *kind), ("type", kind_of_text), ("source", source)])
                .write_empty()?;
        }
        classification(xml, entries)
    })?;
    Ok(())
}

/// The verdict is a draft of the one who answers for it, until it is signed.
fn draft(xml: &mut Xml, summary: &Summary) -> io::Result<()> {
    let dossier = summary.dossier.as_ref();
    let name = dossier.and_then(|dossier| dossier.responsible.as_deref());
    let (Some(name), Some(run)) = (name, &summary.run) else {
        return Ok(());
    };
    let organisation = dossier.and_then(|dossier| dossier.organisation.as_deref());
    let life = xml.create_element("stc:LifeCycleInformation");
    life.write_inner_content(|xml| {
        let drafted = xml.create_element("stc:Drafted");
        let drafted = drafted.with_attribute(("date", run.date.as_str()));
        drafted.write_inner_content(|xml| {
            let responsible = xml.create_element("stc:Responsible");
            let organisation = organisation.map(|text| ("organization", printable(text)));
            let responsible = responsible.with_attributes(organisation);
            responsible
                .with_attribute(("name", &*printable(name)))
                .write_empty()
                .map(drop)
        })?;
        Ok(())
    })?;
    Ok(())
}

/// An identifier in the usual form of one, from the content's digest: other content has another one.
fn identifier(digest: &str) -> String {
    let parts = [0..8, 8..12, 12..16, 16..20, 20..32];
    let parts = parts.map(|part| digest.get(part).unwrap_or_default());
    parts.join("-")
}

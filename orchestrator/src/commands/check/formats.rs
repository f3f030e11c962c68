//! Findings as lines, as JSON, and as SARIF 2.1.0 (the OASIS format that editors and build servers read).

use std::collections::HashMap;
use std::path::Path;

use serde_json::{Value, json};

use super::finding::{Finding, Rule, Severity};
use super::rules::RULES;

/// Of one rule, people read no more findings than this.
const MANY: usize = 20;

/// A line per finding, the worst first. What is one rule's over and over is counted at the end.
pub(super) fn text(fmu: &Path, findings: &[Finding]) -> String {
    let counts = [Severity::Error, Severity::Warning, Severity::Note].map(|severity| {
        let count = count(findings, severity);
        let plural = if count == 1 { "" } else { "s" };
        (count > 0).then(|| format!("{count} {}{plural}", severity.word()))
    });
    let counts: Vec<String> = counts.into_iter().flatten().collect();
    let verdict = match &counts[..] {
        [] => "nothing found".to_owned(),
        some => some.join(", "),
    };
    let mut text = format!("{}: {verdict}\n", fmu.display());
    let mut told: HashMap<&str, usize> = HashMap::new();
    for Finding { rule, hit } in findings {
        let before = told.entry(rule.id).or_insert(0);
        *before += 1;
        if *before > MANY {
            continue;
        }
        let line = hit.full().split_whitespace().collect::<Vec<_>>().join(" ");
        text += &format!("  {}: {line} [{}]\n", rule.severity.word(), rule.source);
    }
    for rule in RULES {
        let more = told
            .get(rule.id)
            .map_or(0, |count| count.saturating_sub(MANY));
        if more > 0 {
            let (severity, source) = (rule.severity.word(), rule.source);
            text += &format!(
                "  {severity}: {more} more of this kind: {} (--format json lists them) [{source}]\n",
                rule.wants
            );
        }
    }
    text
}

fn count(findings: &[Finding], severity: Severity) -> usize {
    let of_it = findings.iter().filter(|f| f.rule.severity == severity);
    of_it.count()
}

/// One object with all findings.
pub(super) fn json(fmu: &Path, findings: &[Finding]) -> String {
    let of = |finding: &Finding| {
        let Finding { rule, hit } = finding;
        json!({
            "severity": rule.severity,
            "rule": rule.id,
            "source": rule.source,
            "file": hit.file,
            "line": hit.line,
            "message": hit.text,
        })
    };
    pretty(&json!({
        "fmu": fmu.display().to_string(),
        "errors": count(findings, Severity::Error),
        "warnings": count(findings, Severity::Warning),
        "notes": count(findings, Severity::Note),
        "findings": findings.iter().map(of).collect::<Vec<_>>(),
    }))
}

/// A log of one run of this program.
pub(super) fn sarif(fmu: &Path, findings: &[Finding]) -> String {
    let rules: Vec<Value> = RULES.iter().map(described).collect();
    let results: Vec<Value> = findings
        .iter()
        .map(|finding| result(fmu, finding))
        .collect();
    pretty(&json!({
        "$schema": "https://json.schemastore.org/sarif-2.1.0.json",
        "version": "2.1.0",
        "runs": [{
            "tool": {"driver": {
                "name": "orchestrator check",
                "version": env!("CARGO_PKG_VERSION"),
                "rules": rules,
            }},
            "columnKind": "unicodeCodePoints",
            "results": results,
        }],
    }))
}

fn described(rule: &Rule) -> Value {
    json!({
        "id": rule.id,
        "shortDescription": {"text": rule.wants},
        "help": {"text": rule.source},
        "defaultConfiguration": {"level": rule.severity},
    })
}

fn result(fmu: &Path, Finding { rule, hit }: &Finding) -> Value {
    let index = RULES.iter().position(|other| other.id == rule.id);
    // A file is named as in the archive.
    let mut uri = encoded(&fmu.to_string_lossy().replace('\\', "/"));
    if let Some(file) = &hit.file {
        uri += "/";
        uri += &encoded(file);
    }
    let mut place = json!({"artifactLocation": {"uri": uri}});
    if let Some(line) = hit.line {
        place["region"] = json!({"startLine": line});
    }
    json!({
        "ruleId": rule.id,
        "ruleIndex": index,
        "level": rule.severity,
        "message": {"text": hit.text},
        "locations": [{"physicalLocation": place}],
    })
}

/// A path as part of a URI.
fn encoded(path: &str) -> String {
    let mut uri = String::new();
    for byte in path.bytes() {
        match byte {
            b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'/' | b'-' | b'.' | b'_' | b'~' => {
                uri.push(char::from(byte));
            }
            _ => uri += &format!("%{byte:02X}"),
        }
    }
    uri
}

fn pretty(value: &Value) -> String {
    format!("{value:#}\n")
}

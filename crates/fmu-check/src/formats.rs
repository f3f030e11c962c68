//! Findings as lines, as JSON, and as SARIF 2.1.0 (the OASIS format that editors and build servers read).

use std::{collections::HashMap, path::Path};

use fmu_import::{Version, percent_encoded};
use serde_json::{Value, json};

use crate::{
    Findings,
    finding::{Finding, Rule, Severity},
    rules::RULES,
};

/// Of one rule, people read no more findings than this.
const MANY: usize = 20;

impl Findings {
    /// A line per finding, the worst first. What is one rule's over and over is counted at the end.
    pub fn text(&self) -> String {
        let counts: Vec<String> = [Severity::Error, Severity::Warning, Severity::Note]
            .map(|severity| {
                let count = self.count(severity);
                let plural = if count == 1 { "" } else { "s" };
                (count > 0).then(|| format!("{count} {}{plural}", severity.word()))
            })
            .into_iter()
            .flatten()
            .collect();
        let verdict = match &counts[..] {
            [] => "nothing found".to_owned(),
            some => some.join(", "),
        };
        let ignored = match self.ignored.len() {
            0 => String::new(),
            known => format!(", {known} known and ignored"),
        };
        let mut text = format!("{}: {verdict}{ignored}\n", self.fmu.display());
        let mut told: HashMap<&str, usize> = HashMap::new();
        for Finding { rule, hit } in &self.all {
            let before = told.entry(rule.id).or_insert(0);
            *before += 1;
            if *before > MANY {
                continue;
            }
            let line = hit.full().split_whitespace().collect::<Vec<_>>().join(" ");
            let source = rule.source_in(self.version);
            text += &format!("  {}: {line} [{source}]\n", rule.severity.word());
        }
        for rule in RULES.iter() {
            let count = told.get(rule.id).copied().unwrap_or(0);
            if count > MANY {
                let (severity, more) = (rule.severity.word(), count - MANY);
                let source = rule.source_in(self.version);
                text += &format!(
                    "  {severity}: {more} more of this kind: {} (the format `json` lists them) [{source}]\n",
                    rule.wants
                );
            }
        }
        text
    }

    /// One JSON object with all findings.
    pub fn json(&self) -> String {
        let of = |Finding { rule, hit }: &Finding| {
            json!({
                "severity": rule.severity,
                "rule": rule.id,
                "source": rule.source_in(self.version),
                "file": hit.file,
                "line": hit.line,
                "message": hit.text,
            })
        };
        let known = |(finding, reason): &(Finding, String)| {
            let mut known = of(finding);
            known["reason"] = json!(reason);
            known
        };
        pretty(&json!({
            "fmu": self.fmu.display().to_string(),
            "errors": self.count(Severity::Error),
            "warnings": self.count(Severity::Warning),
            "notes": self.count(Severity::Note),
            "findings": self.all.iter().map(of).collect::<Vec<_>>(),
            "ignored": self.ignored.iter().map(known).collect::<Vec<_>>(),
        }))
    }

    /// A SARIF log of one run of `program`.
    pub fn sarif(&self, program: &str) -> String {
        let rules: Vec<Value> = RULES.iter().map(|rule| described(rule, self.version)).collect();
        let known = self.ignored.iter().map(|(finding, reason)| {
            let mut known = result(&self.fmu, finding);
            known["suppressions"] = json!([{"kind": "external", "justification": reason}]);
            known
        });
        let results: Vec<Value> = self.all.iter().map(|finding| result(&self.fmu, finding)).chain(known).collect();
        pretty(&json!({
            "$schema": "https://json.schemastore.org/sarif-2.1.0.json",
            "version": "2.1.0",
            "runs": [{
                "tool": {"driver": {
                    "name": program,
                    "version": env!("CARGO_PKG_VERSION"),
                    "rules": rules,
                }},
                "columnKind": "unicodeCodePoints",
                "results": results,
            }],
        }))
    }
}

fn described(rule: &Rule, version: Version) -> Value {
    json!({
        "id": rule.id,
        "shortDescription": {"text": rule.wants},
        "help": {"text": rule.source_in(version)},
        "defaultConfiguration": {"level": rule.severity},
    })
}

fn result(fmu: &Path, Finding { rule, hit }: &Finding) -> Value {
    let index = RULES.iter().position(|other| other.id == rule.id);
    // A file is named as in the archive.
    let mut uri = percent_encoded(&fmu.to_string_lossy().replace('\\', "/"), "");
    if let Some(file) = &hit.file {
        uri += "/";
        uri += &percent_encoded(file, "");
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

fn pretty(value: &Value) -> String {
    format!("{value:#}\n")
}

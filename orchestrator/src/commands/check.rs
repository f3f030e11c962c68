//! `check`: looks at an FMU before it is used.
//!
//! First the model description and the archive, by the [`rules`]; then short simulations, each in a process of
//! its own ([`probes`]).

mod aliases;
mod child;
mod compare;
mod definitions;
mod dependencies;
mod document;
mod experiment;
mod exported;
mod files;
mod finding;
mod formats;
mod hit;
mod names;
mod probe;
mod probes;
mod references;
mod rules;
mod schema;
mod shown;
mod structure;
mod three;
mod values;
mod variables;

use std::path::Path;
use std::process::ExitCode;
use std::time::Duration;

use super::{CommandError, output};
use crate::cli::{Check, Format};
use crate::results::ResultsError;
use document::Document;
use finding::{Find, Finding, Severity};
use fmu_import::{ArchiveError, FmuError, FmuFault, Package, Version, needed};
use fmu_points::stop;
use hit::Hit;
use probes::Probes;

pub(super) fn run(options: &Check) -> Result<ExitCode, CommandError> {
    let mut findings = Findings::default();
    match Package::open(&options.fmu) {
        Ok(package) => findings.look(package, options.patience)?,
        // An archive that is no FMU of this version, or damaged, is a finding; what is no archive, a mistake.
        Err(FmuError { fault, .. }) if fault.is_in_fmu() => match fault {
            FmuFault::Description(fault) => {
                let hit = Hit::of(document::NAME, fault.to_string());
                findings.add("description-readable", hit);
            }
            FmuFault::Archive(ArchiveError::NoDescription) => {
                let text = "modelDescription.xml is not there: it belongs to the top of the archive (pack the files, \
                            not the folder around them)";
                findings.add("archive-readable", Hit::plain(text.to_owned()));
            }
            fault => findings.add("archive-readable", Hit::plain(fault.to_string())),
        },
        Err(error) => return Err(error.into()),
    }
    let mut found = findings.0;
    found.sort_by_key(|finding| std::cmp::Reverse(finding.rule.severity));
    let write = match options.format {
        Format::Text => formats::text,
        Format::Json => formats::json,
        Format::Sarif => formats::sarif,
    };
    output::print(&write(&options.fmu, &found));
    let worst = found.first().map(|finding| finding.rule.severity);
    let enough = if options.strict {
        Severity::Warning
    } else {
        Severity::Error
    };
    Ok(match worst {
        Some(severity) if severity >= enough => ExitCode::FAILURE,
        _ => ExitCode::SUCCESS,
    })
}

/// Runs a probe for another process of this program.
pub(super) fn serve(setup: &Path) -> std::io::Result<()> {
    probe::serve(setup)
}

#[derive(Default)]
struct Findings(Vec<Finding>);

impl Findings {
    fn add(&mut self, rule: &'static str, hit: Hit) {
        let rule = rules::named(rule);
        self.0.extend(rule.map(|rule| Finding { rule, hit }));
    }

    fn errors(&self) -> usize {
        let error = |finding: &&Finding| finding.rule.severity == Severity::Error;
        self.0.iter().filter(error).count()
    }

    fn look(&mut self, mut package: Package, patience: f64) -> Result<(), CommandError> {
        self.described(&mut package)?;
        // Probes of the binary would only repeat the description's errors.
        let described_well = self.errors() == 0;
        let files = files::broken(&mut package)?;
        let others = references::broken(&mut package)?;
        for (rule, hit) in files.findings.into_iter().chain(others) {
            self.add(rule, hit);
        }
        let folder = stop::scratch().map_err(ResultsError::from)?;
        let unpacked = match package.unpack(folder.path()) {
            Ok(unpacked) => unpacked,
            Err(FmuError {
                fault: FmuFault::Archive(fault),
                ..
            }) => {
                // Where something is wrong with this machine's binary, it has been said.
                if !files.fatal {
                    let rule = match fault {
                        ArchiveError::NoBinary { .. } => "binary-there",
                        ArchiveError::Unsafe(_) => "archive-path",
                        _ => "archive-readable",
                    };
                    self.add(rule, Hit::plain(fault.to_string()));
                }
                return Ok(());
            }
            Err(error) => return Err(error.into()),
        };
        if self.lacks_libraries(&package, &unpacked) || files.fatal {
            return Ok(());
        }
        // Without a GUID or a token it would be refused.
        if package.description().guid.is_empty() {
            return Ok(());
        }
        let patience = Duration::try_from_secs_f64(patience).unwrap_or(Duration::MAX);
        let failed = |error| ResultsError::io(folder.path())(error);
        let mut probes =
            Probes::new(&package, &unpacked, folder.path(), patience).map_err(failed)?;
        for (rule, hit) in probes.findings(described_well).map_err(failed)? {
            self.add(rule, hit);
        }
        if let Some(file) = probes.changed_file() {
            let text = format!(
                "a simulation changes {} in the unpacked FMU: in a study, every point then needs a new process and a \
                 folder of its own",
                file.display()
            );
            self.add("files-kept", Hit::plain(text));
        }
        Ok(())
    }

    /// The findings in the model description.
    fn described(&mut self, package: &mut Package) -> Result<(), CommandError> {
        let read = package.description().clone();
        let found = package.with_document(|root| {
            let document = Document::new(root, &read);
            let mut found = Vec::new();
            let is_three = read.standard == Version::Three;
            for rule in rules::RULES {
                let find = match rule.find {
                    Find::Document(find) if !is_three => find,
                    Find::Three(find) if is_three => find,
                    Find::Either(find) => find,
                    _ => continue,
                };
                let hits = find(&document).into_iter();
                let located = hits.map(|hit| document.located(hit));
                found.extend(located.map(|hit| Finding { rule, hit }));
            }
            for scalar in document.known() {
                let first = rules::RULES.iter().find_map(|rule| match rule.find {
                    Find::Variable(find) => {
                        let hit = document.located(scalar.finding(&find(scalar, &document)?));
                        Some(Finding { rule, hit })
                    }
                    _ => None,
                });
                found.extend(first);
            }
            found
        })?;
        self.0.extend(found);
        Ok(())
    }

    /// Libraries that this machine's binary needs and that are not there.
    fn lacks_libraries(&mut self, package: &Package, unpacked: &Path) -> bool {
        let Some(binary) = package.binary(unpacked) else {
            return false;
        };
        let missing = needed::missing(&binary);
        if let [first, rest @ ..] = &missing[..] {
            let more: String = rest.iter().map(|name| format!(", {name}")).collect();
            let name = binary.strip_prefix(unpacked).unwrap_or(&binary);
            let text = format!(
                "it needs {first}{more}, not found on this machine: install what is missing"
            );
            self.add("binary-libraries", Hit::of(&name.to_string_lossy(), text));
        }
        !missing.is_empty()
    }
}

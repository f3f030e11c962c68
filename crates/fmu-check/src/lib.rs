#![doc = include_str!("../README.md")]

mod aliases;
mod child;
mod combinations;
mod compare;
mod conditions;
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
mod simulated;
mod structure;
mod three;
mod values;
mod variables;

use std::{
    io,
    path::{Path, PathBuf},
};

use fmu_import::{ArchiveError, FmuError, FmuFault, Package, Version, needed};
use fmu_points::{scratch::ScratchError, stop};
use thiserror::Error;

pub use conditions::Conditions;
use document::Document;
use finding::Find;
pub use finding::{Finding, Rule, Severity};
pub use hit::Hit;
use probes::Probes;
pub use rules::RULES;

/// Why an FMU cannot be checked. Whatever is wrong within it is a [`Finding`].
#[derive(Debug, Error)]
pub enum CheckError {
    /// There is no such file, or it is no archive.
    #[error(transparent)]
    Fmu(#[from] FmuError),
    /// There is no room for its unpacked files.
    #[error(transparent)]
    Scratch(#[from] ScratchError),
    /// A file or a process of the check failed.
    #[error("{path}: {source}")]
    Io {
        /// The folder of the check's files.
        path: PathBuf,
        /// The operating system's message.
        source: io::Error,
    },
}

/// The outcome of a check.
#[derive(Debug)]
pub struct Findings {
    /// The FMU, as it was named.
    pub fmu: PathBuf,
    /// All that was found, the worst first.
    pub all: Vec<Finding>,
    /// The findings that are [ignored](Findings::ignore), each with the reason.
    pub ignored: Vec<(Finding, String)>,
    /// The standard of its description; FMI 2.0 where that cannot be read.
    version: Version,
}

/// Looks at an FMU before it is used: first at the model description and the archive, then at short simulations, each in
/// a process of its own. The processes are this program once more: see [`serve_if_probe`].
///
/// # Errors
/// When there is no such file, when it is no archive, and when the system says no.
pub fn check(fmu: &Path, conditions: &Conditions) -> Result<Findings, CheckError> {
    let mut findings = Findings { fmu: fmu.to_owned(), all: Vec::new(), ignored: Vec::new(), version: Version::Two };
    match Package::open(fmu) {
        Ok(package) => findings.look(package, conditions)?,
        // An archive that is no FMU of this version, or damaged, is a finding; what is no archive, a mistake.
        Err(error @ FmuError { fault: FmuFault::Archive(ArchiveError::System), .. }) => return Err(error.into()),
        Err(FmuError { fault, .. }) if fault.is_in_fmu() => match fault {
            FmuFault::Description(fault) => {
                findings.add("description-readable", Hit::of(document::NAME, fault.to_string()));
            }
            FmuFault::Archive(ArchiveError::NoDescription) => {
                findings.add(
                    "archive-readable",
                    Hit::plain(
                        "modelDescription.xml is not there: it belongs to the top of the archive (pack the files, \
                            not the folder around them)",
                    ),
                );
            }
            fault => findings.add("archive-readable", Hit::plain(fault.to_string())),
        },
        Err(error) => return Err(error.into()),
    }
    findings.all.sort_by_key(|finding| std::cmp::Reverse(finding.rule.severity));
    Ok(findings)
}

/// Runs a simulation where [`check`] has started this process for that, and does not return then. A program that checks
/// FMUs calls this first in `main`; where it runs points, too, it need not call [`fmu_points::serve_if_worker`].
pub fn serve_if_probe() {
    fmu_points::serve_if_worker_with(probe::serve);
}

impl Findings {
    /// The gravest severity; none where nothing was found.
    pub fn worst(&self) -> Option<Severity> {
        self.all.first().map(|finding| finding.rule.severity)
    }

    /// The number of findings of this severity, without those that are ignored.
    pub fn count(&self, severity: Severity) -> usize {
        self.all.iter().filter(|finding| finding.rule.severity == severity).count()
    }

    /// Ignores the findings of a rule, which are known, and returns how many there are: those that name the variable, or
    /// all of them.
    pub fn ignore(&mut self, rule: &str, variable: Option<&str>, reason: &str) -> usize {
        let known = self
            .all
            .extract_if(.., |finding| finding.rule.id == rule && variable.is_none_or(|name| finding.hit.names(name)));
        let before = self.ignored.len();
        self.ignored.extend(known.map(|finding| (finding, reason.to_owned())));
        self.ignored.len() - before
    }

    fn add(&mut self, rule: &'static str, hit: Hit) {
        let rule = rules::named(rule);
        self.all.push(Finding { rule, hit });
    }

    fn look(&mut self, mut package: Package, conditions: &Conditions) -> Result<(), CheckError> {
        self.version = package.description().standard;
        self.described(&mut package)?;
        // Start values are compared with the binary's only if the description has no error: else the same error would be said
        // twice.
        let described_well = self.count(Severity::Error) == 0;
        let files = files::broken(&mut package)?;
        let others = references::broken(&mut package)?;
        for (rule, hit) in files.findings.into_iter().chain(others) {
            self.add(rule, hit);
        }
        let folder = stop::scratch()?;
        let unpacked = match package.unpack(folder.path()) {
            Ok(unpacked) => unpacked,
            Err(FmuError { fault: FmuFault::Archive(fault), .. }) if fault.is_a_fault() => {
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
        let lacks_libraries = self.lacks_libraries(&package, &unpacked);
        // Without a GUID or a token it would be refused.
        if lacks_libraries || files.fatal || package.description().guid.is_empty() {
            return Ok(());
        }
        let failed = |source| CheckError::Io { path: folder.path().to_owned(), source };
        let mut probes = Probes::new(&package, &unpacked, folder.path(), conditions).map_err(failed)?;
        for (rule, hit) in probes.findings(described_well).map_err(failed)? {
            self.add(rule, hit);
        }
        if let Some(file) = probes.changed_file() {
            self.add("files-kept", Hit::plain(format!(
                "a simulation changes {} in the unpacked FMU: in a study, every point then needs a new process and a \
                 folder of its own",
                file.display()
            )));
        }
        Ok(())
    }

    /// The findings in the model description.
    fn described(&mut self, package: &mut Package) -> Result<(), CheckError> {
        let read = package.description().clone();
        let findings = package.with_document(|root| {
            let document = Document::new(root, &read);
            let mut findings = Vec::new();
            let is_three = read.standard == Version::Three;
            for rule in RULES.iter() {
                let hits = match rule.find {
                    Find::Document(find) if !is_three => find(&document),
                    Find::Three(find) if is_three => find(&document),
                    Find::Each(find) if is_three => document.of_each(find),
                    Find::Either(find) => find(&document),
                    Find::Remark(about) => document.remarks(about),
                    _ => continue,
                };
                findings.extend(hits.into_iter().map(|hit| Finding { rule, hit }));
            }
            for scalar in document.known().filter(|_| !is_three) {
                findings.extend(RULES.iter().find_map(|rule| match rule.find {
                    Find::Variable(find) => {
                        let hit = scalar.finding(&find(document.variable(scalar))?);
                        Some(Finding { rule, hit })
                    }
                    _ => None,
                }));
            }
            for finding in &mut findings {
                document.locate(&mut finding.hit);
            }
            findings
        })?;
        self.all.extend(findings);
        Ok(())
    }

    /// Libraries that this machine's binary needs and that are not there.
    fn lacks_libraries(&mut self, package: &Package, unpacked: &Path) -> bool {
        let Some(binary) = package.binary(unpacked) else { return false };
        let missing = needed::missing(&binary);
        if let Some(text) = &missing {
            let name = binary.strip_prefix(unpacked).unwrap_or(&binary);
            self.add("binary-libraries", Hit::of(&name.to_string_lossy(), text.clone()));
        }
        missing.is_some()
    }
}

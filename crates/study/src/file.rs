//! A study's file as a whole.

use std::{
    fmt::Display,
    path::{Path, PathBuf},
};

use fmu_import::{Package, digest, sha256};
use indexmap::IndexMap;
use number_tables::files::{self, FileError, Result};
use sampling::design::Sampling;
use serde::{Deserialize, Deserializer, de::Error as _};
use sha2::{Digest, Sha256};
use toml::Spanned;

use crate::{
    error::SourceText,
    identification::Identification,
    name::{Name, Pair},
    opening::{OpenError, unusable},
    sections::{RobustnessText, SensitivityText, TolerancesText},
    text::{CaseText, CriterionText, ParameterText, RecordingText, Required, Setting, Simulation},
    values::size_of,
};

/// The content of a study file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Study {
    /// The title of the report.
    pub title: Option<String>,
    /// Purpose of the study, for people.
    pub about: Option<String>,
    /// The FMU, relative to the study file. `judge` needs none, where it is empty.
    #[serde(default = "no_fmu")]
    pub fmu: Spanned<PathBuf>,
    /// How long and in which steps.
    #[serde(default)]
    pub simulation: Simulation,
    /// The design: method, number and seed of the points.
    #[serde(default)]
    pub design: Sampling,
    /// The uncertain parameters by the names of FMU variables.
    #[serde(default)]
    pub parameters: IndexMap<Name, ParameterText>,
    /// Correlations between parameters.
    #[serde(default)]
    pub correlations: Vec<Spanned<Pair>>,
    /// Start values that stay as they are, by the names of FMU variables.
    #[serde(default)]
    pub fixed: IndexMap<Name, Spanned<Setting>>,
    /// An SSP parameter set with further start values; those of the study itself count more.
    pub fixed_from: Option<Spanned<PathBuf>>,
    /// Inputs that follow a recording, by the names of FMU variables.
    #[serde(default)]
    pub inputs: IndexMap<Name, RecordingText>,
    /// The criteria: measured values with their tolerances.
    #[serde(default)]
    pub criteria: IndexMap<Name, CriterionText>,
    /// Operating points or tests of the model, each with inputs, fixed values and criteria of its own. Where there are
    /// any, the criteria stand in [`criteria`](Self::criteria), case by case, with names such as `CASE/NAME`.
    #[serde(default)]
    pub cases: Vec<CaseText>,
    /// Which measured values' errors are correlated, and how.
    #[serde(default)]
    pub uncertainty_correlations: Vec<Spanned<Pair>>,
    /// The section `[verdict]`: the share that is required of the model; without it, one point that meets all criteria.
    pub verdict: Option<Spanned<Required>>,
    /// Who answers for the verdict, and on which test it rests: texts by names of the user's own.
    #[serde(default, deserialize_with = "texts")]
    pub dossier: Option<IndexMap<String, String>>,
    /// The section `[identify]`: unknowns, measurements, effort of the search.
    pub identify: Option<Identification>,
    /// The section `[sensitivity]`: defaults for the options of that command.
    #[serde(default)]
    pub sensitivity: SensitivityText,
    /// The section `[robustness]`: defaults for the options of that command.
    #[serde(default)]
    pub robustness: RobustnessText,
    /// The goal of `tolerances`.
    #[serde(default)]
    pub tolerances: TolerancesText,
    /// File from which the study was read.
    #[serde(skip)]
    pub(crate) path: PathBuf,
    /// The text of the file.
    #[serde(skip)]
    pub(crate) text: String,
    /// The folder of the files that it names, where that is not its own.
    #[serde(skip)]
    pub(crate) base: Option<PathBuf>,
}

fn no_fmu() -> Spanned<PathBuf> {
    Spanned::new(0..0, PathBuf::new())
}

/// Texts by names; a date stands without quotes, too.
fn texts<'de, D: Deserializer<'de>>(from: D) -> Result<Option<IndexMap<String, String>>, D::Error> {
    IndexMap::<String, toml::Value>::deserialize(from)?
        .into_iter()
        .map(|(name, value)| match value {
            toml::Value::String(text) => Ok((name, text)),
            toml::Value::Datetime(date) => Ok((name, date.to_string())),
            _ => Err(D::Error::custom(format!("expected a text in quotes, or a date, as {name}"))),
        })
        .collect::<Result<_, _>>()
        .map(Some)
}

impl Study {
    /// Reads a study file.
    ///
    /// # Errors
    /// When it cannot be read, with line and column when it is not understood.
    pub fn read(path: &Path) -> Result<Self> {
        let ends = |name: &str| path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case(name));
        let message = if ends("ssp") {
            "is a system of FMUs (SSP), where a study (a TOML file) is needed: make one FMU of it by \
             `python -m fmu_orchestrator system`, and write a study of that by `init`"
                .to_owned()
        } else if ends("fmu") {
            let path = path.display();
            format!("is an FMU, where a study is needed: `orchestrator init {path}` writes one")
        } else if number_tables::is_table(path) {
            "is a table, where a study (a TOML file) is needed".to_owned()
        } else {
            return Self::parse(path, files::text(path)?);
        };
        Err(FileError::new(path, message))
    }

    /// Reads the text of a study that stands, or would stand, at `path`.
    ///
    /// # Errors
    /// With line and column when the text is not understood.
    pub fn parse(path: &Path, text: String) -> Result<Self> {
        let source = SourceText { path, text: &text };
        let mut study: Self = toml::from_str(&text).map_err(|error| source.toml(&error))?;
        study.path = path.to_owned();
        study.text = text;
        study.spread_criteria()?;
        Ok(study)
    }

    /// Reads the text once more for what another command wants of it: a type with the sections that it
    /// knows, with places for its errors.
    ///
    /// # Errors
    /// With line and column when the text is not understood.
    pub fn section<T: serde::de::DeserializeOwned>(&self) -> Result<T> {
        toml::from_str(&self.text).map_err(|error| self.source().toml(&error))
    }

    /// File from which the study was read.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The FMU's path, as seen from here.
    pub fn fmu_path(&self) -> PathBuf {
        self.path.parent().unwrap_or(Path::new("")).join(self.fmu.as_ref())
    }

    /// Opens its FMU, or another one instead, with the sizes of arrays that it fixes.
    ///
    /// # Errors
    /// When it cannot be used; with the place in the study that names it.
    pub fn open_fmu(&self, instead: Option<&Path>) -> Result<Package, OpenError> {
        if instead.is_none() && self.fmu.as_ref().as_os_str().is_empty() {
            let message = "names no FMU: add fmu = \"my.fmu\" above all sections";
            return Err(if self.fmu.span().is_empty() {
                FileError::new(&self.path, message)
            } else {
                self.error_at(&self.fmu, "it is empty: name the FMU, such as fmu = \"my.fmu\"")
            }
            .into());
        }
        let named = self.fmu_path();
        let mut package = Package::open(instead.unwrap_or(&named)).map_err(|error| match instead {
            None => self.error_at(&self.fmu, unusable(&error)).into(),
            Some(_) => OpenError::from(error),
        })?;
        let mut sizes = Vec::new();
        for (name, setting) in &self.fixed {
            let fmu = package.description();
            if let Some(variable) = fmu.variables.get(name.as_ref().as_str()) {
                let size = size_of(fmu, variable, setting.as_ref());
                sizes.extend(size.map_err(|message| self.error_at(setting, message))?);
            }
        }
        package.resize(&sizes)?;
        Ok(package)
    }

    /// Finds the files that the study names as if it still stood in this folder.
    pub fn rebase(&mut self, folder: PathBuf) {
        self.base = Some(folder);
    }

    /// The path of a file that the study names, as seen from here.
    pub fn path_of(&self, file: &Path) -> PathBuf {
        let folder = self.path.parent().unwrap_or(Path::new(""));
        self.base.as_deref().unwrap_or(folder).join(file)
    }

    /// The same, in one spelling: two names of one file, such as `a.csv` and `./a.csv`, have one path.
    pub fn one_path(&self, file: &Path) -> PathBuf {
        let path = self.path_of(file);
        path.canonicalize().unwrap_or(path)
    }

    /// Whether a sample gives several parameters, which are drawn together.
    pub fn binds_by_samples(&self) -> bool {
        let mut files: Vec<PathBuf> =
            self.parameters.values().filter_map(|p| p.file.as_ref()).map(|file| self.one_path(file.as_ref())).collect();
        files.sort_unstable();
        files.windows(2).any(|pair| pair[0] == pair[1])
    }

    /// The SHA-256 digest of the study's text, and of the inputs, samples and parameter sets that it names, as
    /// hexadecimal digits.
    pub fn digest(&self) -> String {
        let mut bytes = self.text.clone().into_bytes();
        for file in self.named() {
            // An unreadable file is reported where it is used.
            let hash = files::open(&self.path_of(file)).and_then(sha256);
            bytes.extend(hash.unwrap_or_else(|_| Sha256::digest([]).into()));
        }
        digest(&bytes)
    }

    /// All files that the study names, but the FMU.
    pub fn files(&self) -> Vec<&Path> {
        let identify = self.identify.as_ref();
        let cases = identify.and_then(|identify| identify.cases.as_ref());
        self.named().chain(cases.map(|file| file.as_ref().as_path())).collect()
    }

    /// The files that a verdict depends on.
    fn named(&self) -> impl Iterator<Item = &Path> {
        let of_cases = self.cases.iter().flat_map(|case| case.inputs.values());
        let inputs = self.inputs.values().chain(of_cases).map(|input| &input.file);
        let curves = self.criteria.values().filter_map(|text| Some(&text.reference.as_ref()?.file));
        let samples = self.parameters.values().filter_map(|parameter| parameter.file.as_ref());
        inputs.chain(curves).chain(samples).chain(&self.fixed_from).map(|file| file.as_ref().as_path())
    }

    /// The study's text.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// An error at a place in the file.
    pub fn error_at<T>(&self, at: &Spanned<T>, message: impl Display) -> FileError {
        self.source().error_at(at.span().start, message.to_string())
    }

    fn source(&self) -> SourceText<'_> {
        SourceText { path: &self.path, text: &self.text }
    }

    /// An error of what a name in the file stands for.
    pub fn error_of(&self, name: &Name, message: impl Display) -> FileError {
        self.error_at(name, format!("{}: {message}", name.as_ref()))
    }

    /// An error of the study as a whole.
    pub fn error(&self, message: impl Into<String>) -> FileError {
        FileError::new(&self.path, message)
    }

    /// An error of a section, whose name begins the message: at the first of these keys that the section has, or at the section.
    pub fn error_in(&self, section: &str, keys: &[&str], message: impl Display) -> FileError {
        self.source().error_under(section, keys, format!("[{section}] {message}"))
    }

    /// An error at a section, where the study has it; the message says what the section has to do with it.
    pub fn error_near(&self, section: &str, message: impl Into<String>) -> FileError {
        self.source().error_under(section, &[], message.into())
    }
}

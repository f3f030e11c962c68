//! Why a point has no result.

use std::fmt;

use serde::{Deserialize, Serialize};

use fmu_import::{Call, Status};

/// Why a point has no result. Its text is the `status` column of `points.csv`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Failure {
    /// A parameter's value is not allowed by the FMU's description.
    OutOfRange(String),
    /// The FMU returned `fmi2Discard`, with its message.
    Discard(String),
    /// The FMU returned `fmi2Error`, with its message.
    Error(String),
    /// The FMU returned `fmi2Fatal`, with its message.
    Fatal(String),
    /// A result is not a finite number.
    NotFinite(Partial),
    /// The worker process died of a signal; its name, and the last words of the FMU.
    Crashed(String),
    /// The FMU ended its process; the exit code, and its last words.
    Exited(i32, String),
    /// The FMU cannot be loaded, and why.
    Unloadable(String),
    /// The point took too long.
    Timeout,
    /// The worker process took too much memory.
    OutOfMemory,
    /// The simulation of one case has no result.
    InCase(Box<OfCase>),
}

/// The failure of a point of several cases.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct OfCase {
    /// The first case without a result.
    pub case: String,
    /// Why it has none.
    pub failure: Failure,
    /// The results of all cases; `None` where there is none.
    pub values: Vec<Option<f64>>,
}

/// Results of which some are no finite numbers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Partial {
    /// The first variable without a finite value.
    pub variable: String,
    /// All results; `None` where there is no finite number.
    pub values: Vec<Option<f64>>,
}

impl Partial {
    /// Results of which some are no finite numbers; the first of these belongs to `variable`.
    pub fn new(variable: &str, values: &[f64]) -> Self {
        Self {
            variable: variable.to_owned(),
            values: values.iter().map(|&value| Some(value).filter(|value| value.is_finite())).collect(),
        }
    }
}

impl std::error::Error for Failure {}

impl Failure {
    /// The failure of a call of the FMU.
    pub fn from_call(call: &Call) -> Self {
        let text = match &call.message {
            Some(message) => format!("{message} ({})", call.function),
            None => call.function.to_owned(),
        };
        match call.status {
            Status::Discard => Self::Discard(text),
            Status::Fatal => Self::Fatal(text),
            Status::Pending => Self::Error(format!("fmi2Pending: {text}")),
            Status::Unknown(number) => Self::Error(format!("unknown status {number}: {text}")),
            _ => Self::Error(text),
        }
    }

    /// The result at this place, if it is finite although others are not.
    pub fn value(&self, number: usize) -> Option<f64> {
        let values = match self {
            Self::NotFinite(partial) => &partial.values,
            Self::InCase(of) => &of.values,
            _ => return None,
        };
        values.get(number).copied().flatten()
    }

    /// The failure of the simulation, whatever its case.
    pub fn cause(&self) -> &Self {
        match self {
            Self::InCase(of) => of.failure.cause(),
            failure => failure,
        }
    }

    /// The failure with its results in other units.
    pub fn converted(mut self, convert: impl FnOnce(&mut [f64])) -> Self {
        let known = match &mut self {
            Self::NotFinite(partial) => &mut partial.values,
            Self::InCase(of) => &mut of.values,
            _ => return self,
        };
        let mut values: Vec<f64> = known.iter().map(|value| value.unwrap_or(f64::NAN)).collect();
        convert(&mut values);
        *known = Partial::new("", &values).values;
        self
    }

    /// The FMI function that the FMU refused, if it is one.
    pub fn refused(&self) -> Option<&str> {
        match self.cause() {
            Self::Discard(text) | Self::Error(text) | Self::Fatal(text) => Some(function(text)),
            _ => None,
        }
    }

    /// The class under which `summary.json` counts it.
    pub fn class(&self) -> &'static str {
        match self {
            Self::OutOfRange(_) => "out of range",
            Self::Discard(text) => by_version(text, ["fmi2Discard", "fmi3Discard"]),
            Self::Error(text) => by_version(text, ["fmi2Error", "fmi3Error"]),
            Self::Fatal(text) => by_version(text, ["fmi2Fatal", "fmi3Fatal"]),
            Self::NotFinite(_) => "not finite",
            Self::Crashed(_) => "crashed",
            Self::Exited(..) => "exited",
            Self::Unloadable(_) => "not loadable",
            Self::Timeout => "timeout",
            Self::OutOfMemory => "out of memory",
            Self::InCase(of) => of.failure.class(),
        }
    }
}

/// The function with which the text of a failed call ends.
fn function(text: &str) -> &str {
    text.rsplit('(').next().unwrap_or(text).trim_end_matches(')')
}

/// The status as the version of FMI names it whose function the text ends with.
fn by_version(text: &str, [two, three]: [&'static str; 2]) -> &'static str {
    if function(text).starts_with("fmi3") { three } else { two }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let class = self.class();
        match self {
            Self::OutOfRange(text)
            | Self::Discard(text)
            | Self::Error(text)
            | Self::Fatal(text)
            | Self::Crashed(text) => write!(f, "{class}: {text}"),
            Self::NotFinite(partial) => write!(f, "{class}: {}", partial.variable),
            Self::Exited(code, words) => {
                let words = if words.is_empty() { String::new() } else { format!(": {words}") };
                write!(f, "{class}: the FMU ended its process with code {code}{words}")
            }
            Self::Unloadable(text) => f.write_str(text),
            Self::Timeout | Self::OutOfMemory => f.write_str(class),
            Self::InCase(of) => write!(f, "case {}: {}", of.case, of.failure),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_that_a_run_has_come_back_from_a_journal() {
        let failure = Failure::NotFinite(Partial::new("b", &[0.1, f64::NAN, f64::INFINITY]));
        let text = serde_json::to_string(&failure).unwrap();
        assert_eq!(serde_json::from_str::<Failure>(&text).unwrap(), failure);
        assert_eq!([0, 1, 2, 3].map(|k| failure.value(k)), [Some(0.1), None, None, None]);
        let doubled = failure.converted(|values| values.iter_mut().for_each(|v| *v *= 2.0));
        assert_eq!(doubled.value(0), Some(0.2));
    }

    #[test]
    fn the_failure_of_a_case_names_it() {
        let failure = Failure::InCase(Box::new(OfCase {
            case: "fast".to_owned(),
            failure: Failure::Discard("no film".to_owned()),
            values: vec![Some(0.1), None],
        }));
        assert_eq!(failure.to_string(), "case fast: fmi2Discard: no film");
        assert_eq!(failure.class(), "fmi2Discard");
        assert_eq!(failure.cause(), &Failure::Discard("no film".to_owned()));
        let text = serde_json::to_string(&failure).unwrap();
        assert_eq!(serde_json::from_str::<Failure>(&text).unwrap(), failure);
        let doubled = failure.converted(|values| values.iter_mut().for_each(|v| *v *= 2.0));
        assert_eq!([0, 1].map(|k| doubled.value(k)), [Some(0.2), None]);
    }

    #[test]
    fn a_failure_is_one_of_its_version_of_fmi() {
        let class = |text: &str| Failure::Discard(text.to_owned()).class();
        assert_eq!(class("too long (fmi2DoStep)"), "fmi2Discard");
        assert_eq!(class("too long (fmi3DoStep)"), "fmi3Discard");
        assert_eq!(
            [class("fmi3DoStep"), class("fmi2DoStep"), class("")],
            ["fmi3Discard", "fmi2Discard", "fmi2Discard"]
        );
    }
}

//! Tests as JUnit XML, the format that build servers read.

use std::path::Path;

use crate::error::Result;
use fmu_points::tell::visible;
use number_tables::files::in_a_line;
use point_journal::files::{make_folder, write_text};
use result_document::format::escape;

/// A test as a build server lists it.
#[derive(Clone)]
pub struct Test {
    /// Its group: the study, with the case.
    pub class: String,
    /// Its name within the group.
    pub name: String,
    /// What came out.
    pub outcome: TestOutcome,
}

/// What came out of a test.
#[derive(Clone)]
pub enum TestOutcome {
    /// It passed.
    Passed,
    /// It failed: why.
    Failed(String),
    /// It could not be run: why.
    Broken(String),
    /// It does not tell: why. Build servers count it as not passed.
    Undecided(String),
    /// It does not count: why.
    Skipped(String),
}

impl Test {
    /// A test of a group.
    pub fn new(class: &str, name: &str, outcome: TestOutcome) -> Self {
        Self { class: class.to_owned(), name: name.to_owned(), outcome }
    }

    fn xml(&self) -> String {
        let element = |name: &str, kind: &str, why: &str| {
            let why = written(why);
            format!("<{name} message=\"{why}\" type=\"{kind}\">{why}</{name}>")
        };
        let inner = match &self.outcome {
            TestOutcome::Passed => String::new(),
            TestOutcome::Failed(why) => element("failure", "failed", why),
            TestOutcome::Undecided(why) => element("error", "inconclusive", why),
            TestOutcome::Broken(why) => element("error", "mistake", why),
            TestOutcome::Skipped(why) => format!("<skipped message=\"{}\"/>", written(why)),
        };
        let [class, name] = [&self.class, &self.name].map(|text| written(text));
        format!("    <testcase classname=\"{class}\" name=\"{name}\" time=\"0\">{inner}</testcase>\n")
    }
}

impl TestOutcome {
    /// Passed, or failed for a reason.
    pub fn of(passed: bool, why: impl FnOnce() -> String) -> Self {
        if passed { Self::Passed } else { Self::Failed(why()) }
    }

    /// A doubt, which fails where it is strict and is told else.
    pub fn doubt(strict: bool, why: String) -> Self {
        if strict { Self::Failed(why) } else { Self::Skipped(why) }
    }
}

/// Writes the tests of a command as a file, and makes its folder; `seconds` is how long they took together.
///
/// # Errors
/// When the system says no.
pub fn write(file: &Path, suite: &str, tests: &[Test], seconds: f64) -> Result {
    if let Some(folder) = file.parent().filter(|folder| !folder.as_os_str().is_empty()) {
        make_folder(folder)?;
    }
    Ok(write_text(file, xml(suite, tests, seconds))?)
}

fn xml(suite: &str, tests: &[Test], seconds: f64) -> String {
    let count = |is: fn(&TestOutcome) -> bool| tests.iter().filter(|test| is(&test.outcome)).count();
    let counts = format!(
        "name=\"{}\" tests=\"{}\" failures=\"{}\" errors=\"{}\" skipped=\"{}\" time=\"{seconds:.3}\"",
        written(suite),
        tests.len(),
        count(|outcome| matches!(outcome, TestOutcome::Failed(_))),
        count(|outcome| matches!(outcome, TestOutcome::Undecided(_) | TestOutcome::Broken(_))),
        count(|outcome| matches!(outcome, TestOutcome::Skipped(_))),
    );
    let cases: String = tests.iter().map(Test::xml).collect();
    format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites {counts}>\n  <testsuite {counts}>\n{cases}  </testsuite>\n\
         </testsuites>\n"
    )
}

/// A text on one line, with nothing in it that XML does not take.
fn written(text: &str) -> String {
    escape(&visible(&in_a_line(text))).replace(['\u{fffe}', '\u{ffff}'], "?")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_text_makes_xml_that_counts_its_tests() {
        let why = "a < b & \"c\"\n\u{1b}[31m\u{ffff}".to_owned();
        let tests = [
            Test::new("study", "verdict", TestOutcome::Failed(why.clone())),
            Test::new("study.300 rpm", "T<1", TestOutcome::Passed),
            Test::new("study", "share", TestOutcome::Undecided(why.clone())),
            Test::new("study", "still-moves", TestOutcome::Skipped(why)),
        ];
        let text = xml("study", &tests, 1.25);
        let document = roxmltree::Document::parse(&text).unwrap();
        let suites = document.root_element();
        let suite = suites.first_element_child().unwrap();
        for (name, value) in [("tests", "4"), ("failures", "1"), ("errors", "1"), ("skipped", "1")] {
            assert_eq!(suites.attribute(name), Some(value));
            assert_eq!(suite.attribute(name), Some(value));
        }
        let cases: Vec<_> = suite.children().filter(|node| node.is_element()).collect();
        let inner = |case: usize| cases[case].first_element_child().map(|node| node.tag_name().name());
        let inner = [0, 1, 2, 3].map(inner);
        assert_eq!(inner, [Some("failure"), None, Some("error"), Some("skipped")]);
        let failure = cases[0].first_element_child().unwrap();
        assert_eq!(failure.attribute("message"), Some("a < b & \"c\" \\u001b[31m?"));
        assert_eq!(cases[1].attribute("classname"), Some("study.300 rpm"));
    }
}

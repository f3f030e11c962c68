//! Tests of the reader of studies.

use std::path::Path;

use super::*;

fn error(text: &str) -> String {
    let study = Study::parse(Path::new("s.toml"), text.to_owned());
    study.unwrap_err().to_string()
}

#[test]
fn typing_errors_are_answered_with_line_column_and_the_nearest_key() {
    let text = "fmu = \"a.fmu\"\n[design]\npionts = 3\n";
    assert_eq!(error(text), "s.toml:3:1: unknown field `pionts`; did you mean `points`?");
    let text = "fmu = \"a.fmu\"\n[design]\nmethod = \"sobel\"\n";
    assert_eq!(error(text), "s.toml:3:10: unknown variant `sobel`; did you mean `sobol`?");
    let text = "fmu = \"a.fmu\"\n[criteria.T]\nvariable = \"t\"\nmax = 90\n";
    assert!(error(text).starts_with("s.toml:4:1: unknown field `max`; a single limit is `at-most`"), "{}", error(text));
    assert!(error("fmu = \n").starts_with("s.toml:1:"), "{}", error("fmu = \n"));
}

#[test]
fn the_order_of_the_file_is_kept() {
    let text = "fmu = \"a.fmu\"\n[parameters.z]\ndistribution = \"fixed\"\nvalue = 1\n\
                [parameters.a]\ndistribution = \"fixed\"\nvalue = \"2 mm\"\n";
    let study = Study::parse(Path::new("s.toml"), text.to_owned()).unwrap();
    let names: Vec<&str> = study.parameters.keys().map(|name| name.as_ref().as_str()).collect();
    assert_eq!(names, ["z", "a"]);
}

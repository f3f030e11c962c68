//! Messages of `identify` for mistaken studies: file, line, column, and the remedy.

use orchestrator::identify::bind::Bound;
use stand_tests::{file, package};
use study::Study;

const STUDY: &str = r#"fmu = "stand.fmu"
[simulation]
stop = 1
step = 1
[fixed]
"bearing.roughness" = 0
[identify.free."oil.viscosityScale"]
min = 1
max = 100
scale = "log"
[identify.measured.P]
variable = "sensor.frictionPower"
value = "14 W"
accuracy = "1 %"
"#;

fn bind(text: &str) -> Result<Bound, String> {
    let path = file("studies/s.toml");
    let shorten = |error: String| error.replace(&path.display().to_string(), "s.toml");
    let study = Study::parse(&path, text.to_owned()).map_err(|error| shorten(error.to_string()))?;
    let settings = study.identify.clone().ok_or("no section")?;
    Bound::new(&study, &settings, package().description()).map_err(|e| shorten(e.to_string()))
}

#[test]
fn a_study_without_a_table_is_one_case() {
    let bound = bind(STUDY).unwrap();
    assert_eq!(bound.problem.cases.len(), 1);
    assert_eq!(bound.problem.cases[0].measured[0].accuracy, 0.14);
    assert_eq!(bound.problem.unknowns(), 1);
}

#[test]
fn mistakes_have_a_place_and_a_remedy() {
    let cases = [
        (
            ("oil.viscosityScale", "oil.viscosityScael"),
            "s.toml:7:16: the FMU has no variable `oil.viscosityScael`; did you mean `oil.viscosityScale`?",
        ),
        (("scale = \"log\"", "scale = \"lgo\""), "s.toml:10:9: unknown variant `lgo`, expected `linear` or `log`"),
        (("max = 100", "max = 100\nmena = 3"), "s.toml:10:1: unknown field `mena`; did you mean `mean`?"),
        (
            ("max = 100", "max = 1"),
            "s.toml:7:16: oil.viscosityScale: the bounds 1 and 1 must be two numbers in rising order",
        ),
        (
            ("max = 100", "max = 1e6"),
            "s.toml:7:16: oil.viscosityScale: oil.viscosityScale = 1000000 is more than the largest value 10000 that the FMU allows",
        ),
        (
            ("scale = \"log\"", "scale = \"log\"\nmean = 3"),
            "s.toml:7:16: oil.viscosityScale: a prior on a logarithmic scale has `median` and `factor`",
        ),
        (
            ("\"bearing.roughness\" = 0", "\"oil.viscosityScale\" = 2"),
            "s.toml:7:16: oil.viscosityScale is under [fixed] and [identify.free]; keep one",
        ),
        (
            ("value = \"14 W\"", "column = \"P_W\""),
            "s.toml:11:20: column `P_W` of which table? `cases` is missing under [identify]",
        ),
        (("accuracy = \"1 %\"", "accuracy = \"0 W\""), "s.toml:11:20: P: the accuracy 0 W of 14 must be positive"),
        (
            ("accuracy = \"1 %\"", "accuracy = \"1 degC\""),
            "s.toml:11:20: P: unit `degC` does not fit: the value is in W; use W",
        ),
    ];
    for ((from, to), expected) in cases {
        assert!(STUDY.contains(from), "{from}");
        assert_eq!(bind(&STUDY.replacen(from, to, 1)).unwrap_err(), expected);
    }
}

#[test]
fn a_column_that_is_missing_is_answered_with_the_nearest() {
    let text = format!(
        "{}[identify]\ncases = \"paper/table3_solutions.csv\"\n",
        STUDY.replace("value = \"14 W\"", "column = \"P_fr\"")
    );
    let error = bind(&text).unwrap_err();
    assert!(error.contains("no column `P_fr` for P; did you mean `P_fr_W`?"), "{error}");
}

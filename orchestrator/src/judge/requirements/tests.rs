use super::*;
use std::path::Path;

const STUDY: &str = r#"
fmu = "a.fmu"
[parameters.p]
distribution = "uniform"
min = 0
max = 1
[fixed]
q = 1
[criteria.T]
variable = "t"
nominal = 82
tolerance = "0.75 %"
uncertainty = "0.3 degC"
unit = "degC"
[criteria.F]
variable = "f"
nominal = 750
tolerance = "7 %"
uncertainty = "2 %"
coverage = 3
unit = "N"
[verdict]
share = "5 %"
"#;

/// Changes of the study, and the place and the remedy in the message.
type Case<'a> = (Vec<(&'a str, String)>, &'a str, &'a str);

fn judge(changes: &[(&str, &str)]) -> Result<Judge, String> {
    let mut text = STUDY.to_owned();
    for (from, to) in changes {
        assert!(text.contains(from), "{from}");
        text = text.replacen(from, to, 1);
    }
    let study = Study::parse(Path::new("s.toml"), text).map_err(|error| error.to_string())?;
    Judge::new(&study, None).map_err(|error| error.to_string())
}

#[test]
fn uncertainties_are_read_like_tolerances() {
    let judge = judge(&[]).unwrap();
    let of = |k: usize| judge.criteria[k].uncertainty.unwrap();
    assert!((of(0).standard() - 0.15).abs() < 1e-12);
    assert!((of(1).standard() - 5.0).abs() < 1e-12);
    let rule = judge.rule.unwrap();
    assert_eq!((rule.share, rule.confidence), (0.05, 0.95));
    assert_eq!(judge.guard, Guard::Given(0.0));
    assert_eq!(judge.warnings, [""; 0]);
}

#[test]
fn guard_bands_are_given_or_found() {
    let with = |key: &str| judge(&[("share = \"5 %\"", &format!("share = 0.05\n{key}"))]);
    assert_eq!(
        with("risk = \"5 %\"").unwrap().guard,
        Guard::Limiting { risk: 0.05 }
    );
    assert_eq!(with("guard-band = 0.5").unwrap().guard, Guard::Given(0.5));
    assert!(
        with("guard-band = 0.5\nrisk = 0.1")
            .unwrap_err()
            .contains("keep")
    );
}

#[test]
fn correlated_errors_make_joint_probabilities() {
    let text = "[[uncertainty-correlations]]\nbetween = [\"T\", \"F\"]\ncoefficient = 1\n[verdict]";
    let (one, two) = (judge(&[]).unwrap(), judge(&[("[verdict]", text)]).unwrap());
    let p = |judge: &Judge| {
        judge
            .measurement
            .assess(&[82.3, 795.0])
            .all
            .probability
            .unwrap()
    };
    assert!(p(&two) > p(&one) + 1e-4);
}

#[test]
fn an_uncertainty_above_the_tolerance_is_warned_of_where_nothing_guards() {
    let wide = ("\"0.3 degC\"", "\"0.7 degC\"");
    let warnings = judge(&[wide]).unwrap().warnings;
    assert_eq!(warnings.len(), 1);
    assert!(
        warnings[0].starts_with("s.toml:13:15: T: the uncertainty 0.7 degC"),
        "{warnings:?}"
    );
    let guarded = ("share = \"5 %\"", "share = 0.05\nrisk = 0.1");
    assert_eq!(judge(&[wide, guarded]).unwrap().warnings, [""; 0]);
}

#[test]
fn mistakes_have_their_place_and_remedy() {
    let pair = |a: &str, b: &str, r: &str| {
        format!("[[uncertainty-correlations]]\nbetween = [{a:?}, {b:?}]\ncoefficient = {r}\n")
    };
    let correlated = |text: String| vec![("[verdict]", text + "[verdict]")];
    let twice = pair("T", "F", "0.5") + &pair("F", "T", "0.5");
    let cases: Vec<Case<'_>> = vec![
        (
            vec![("\"t\"", "\"p\"".into())],
            "s.toml:10:12:",
            "name an output",
        ),
        (
            vec![("\"t\"", "\"q\"".into())],
            "s.toml:10:12:",
            "a parameter",
        ),
        (
            vec![("\"0.3 degC\"", "\"-1 degC\"".into())],
            "s.toml:13:15:",
            "the uncertainty -1",
        ),
        (
            vec![("\"0.3 degC\"", "\"1 K\"".into())],
            "s.toml:13:15:",
            "without the FMU",
        ),
        (
            vec![("uncertainty = \"2 %\"\n", String::new())],
            "s.toml:19:12:",
            "add",
        ),
        (
            vec![("coverage = 3", "coverage = 0".into())],
            "s.toml:15:11:",
            "positive",
        ),
        (vec![("\"5 %\"", "\"5 N\"".into())], "s.toml:23:9:", "0.05"),
        (vec![("\"5 %\"", "1".into())], "s.toml:23:9:", "0.05"),
        (
            vec![("\"5 %\"", "0.1\nconfidence = 95".into())],
            "s.toml:24:14:",
            "below 1",
        ),
        (
            vec![("\"5 %\"", "0.1\nrisk = 2".into())],
            "s.toml:24:8:",
            "5 %",
        ),
        (
            vec![("\"5 %\"", "0.1\nguard-band = -1".into())],
            "s.toml:24:14:",
            "0 or more",
        ),
        (
            vec![
                ("uncertainty = \"0.3 degC\"\n", String::new()),
                ("\"5 %\"", "0.1\nrisk = 0.1".into()),
            ],
            "s.toml:23:8:",
            "[criteria.T]",
        ),
        (
            correlated(pair("T", "f", "0.5")),
            "s.toml:23:17:",
            "no criterion `f`",
        ),
        (correlated(pair("T", "T", "0.5")), "s.toml:2", "name two"),
        (
            correlated(pair("T", "F", "1.5")),
            "s.toml:2",
            "from -1 to 1",
        ),
        (correlated(twice), "s.toml:2", "keep one"),
    ];
    for (changes, place, remedy) in cases {
        let changes: Vec<(&str, &str)> = changes
            .iter()
            .map(|(from, to)| (*from, to.as_str()))
            .collect();
        let error = judge(&changes).unwrap_err();
        assert!(
            error.starts_with(place) && error.contains(remedy),
            "{changes:?}: {error}"
        );
    }
}

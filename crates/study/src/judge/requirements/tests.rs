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
    assert!((of(0).standard(82.0) - 0.15).abs() < 1e-12);
    assert!((of(1).standard(0.0) - 5.0).abs() < 1e-12);
    let rule = judge.rule.unwrap();
    assert_eq!((rule.share, rule.confidence), (0.05, 0.95));
    assert_eq!(judge.guard, Guard::Given(0.0));
    assert_eq!(judge.warnings, []);
}

#[test]
fn guard_bands_are_given_or_found() {
    let with = |key: &str| judge(&[("share = \"5 %\"", &format!("share = 0.05\n{key}"))]);
    assert_eq!(with("risk = \"5 %\"").unwrap().guard, Guard::Limiting { risk: 0.05 });
    assert_eq!(with("guard-band = 0.5").unwrap().guard, Guard::Given(0.5));
    assert_eq!(with("point-risk = \"5 %\"").unwrap().guard, Guard::EachPoint { risk: 0.05 });
    for two in ["guard-band = 0.5\nrisk = 0.1", "point-risk = 0.1\nrisk = 0.1", "point-risk = 0.1\nguard-band = 1"] {
        assert!(with(two).unwrap_err().contains("keep one"), "{two}");
    }
}

/// An interval of 2 * 52.5 N is used up by bands of 3.5 times 15 N at both of its ends.
#[test]
fn a_guard_band_that_leaves_nothing_is_warned_of() {
    let with = |band: &str| {
        let text = format!("share = 0.05\nguard-band = {band}");
        let widths = [("\"7 %\"", "\"52.5 N\""), ("\"2 %\"", "\"15 N\"")];
        let changes = [&widths[..], &[("share = \"5 %\"", &text)]].concat();
        let warnings = judge(&changes).unwrap().warnings.into_iter();
        warnings.map(|warning| warning.to_string()).collect::<Vec<_>>()
    };
    // T has 2.05 expanded uncertainties of 0.3 degC in its tolerance of 0.615 degC.
    for band in ["0", "0.5", "2.04"] {
        assert_eq!(with(band), [""; 0], "{band}");
    }
    let [of_t] = &with("2.06")[..] else { panic!("one warning") };
    assert!(
        of_t.starts_with(
            "s.toml:24:14: the guard band of 2.06 expanded uncertainties leaves nothing of T's tolerance 0.75 %"
        ) && of_t.ends_with(". Give a guard band below 2.050, measure T better or widen its tolerance."),
        "{of_t}"
    );
    assert_eq!(with("3.49").len(), 1);
    assert_eq!(with("3.5").len(), 2);
}

#[test]
fn criteria_that_exclude_each_other_are_warned_of() {
    let beside = |more: &str| {
        let text = format!("[criteria.U]\nvariable = \"t\"\nnominal = 84\n{more}\n[verdict]");
        judge(&[("[verdict]", &text)]).unwrap().warnings
    };
    let apart = &beside("tolerance = 1\nunit = \"degC\"")[..];
    let [warning] = apart else { panic!("{apart:?}") };
    assert_eq!(warning.code, Code::Contradictory);
    assert!(warning.text.starts_with("s.toml:22:11: no point can meet both T and U"), "{warning}");
    for elsewhere in [
        "tolerance = 1.5\nunit = \"degC\"",
        "tolerance = 1\nunit = \"K\"",
        "tolerance = 1\nunit = \"degC\"\nwindow = \"1 s\"",
        "tolerance = 1\nunit = \"degC\"\nstatistic = \"max\"",
    ] {
        assert_eq!(beside(elsewhere), [], "{elsewhere}");
    }
}

/// A confidence is a probability, and below one half the contrary would be the surer claim. The share must leave open
/// whether it is met.
#[test]
fn shares_and_confidences_are_probabilities() {
    let with = |share: &str, confidence: &str| {
        let text = format!("share = {share}\nconfidence = {confidence}");
        let rule = judge(&[("share = \"5 %\"", &text)])?.rule.unwrap();
        Ok::<_, String>((rule.share, rule.confidence))
    };
    assert_eq!(with("\"5 %\"", "0.5"), Ok((0.05, 0.5)));
    assert_eq!(with("0.9", "0.99"), Ok((0.9, 0.99)));
    for confidence in ["0.49", "1", "0", "-0.9"] {
        let error = with("0.9", confidence).unwrap_err();
        assert!(error.starts_with("s.toml:24:14:") && error.contains("at least 0.5 and below 1"), "{error}");
    }
    for share in ["0", "\"0 %\"", "1", "\"100 %\"", "-0.1"] {
        let error = with(share, "0.95").unwrap_err();
        assert!(error.starts_with("s.toml:23:9:") && error.contains("more than 0 % and less than 100 %"), "{error}");
    }
}

#[test]
fn correlated_errors_make_joint_probabilities() {
    let text = "[[uncertainty-correlations]]\nbetween = [\"T\", \"F\"]\ncoefficient = 1\n[verdict]";
    let (one, two) = (judge(&[]).unwrap(), judge(&[("[verdict]", text)]).unwrap());
    let p = |judge: &Judge| judge.measurement.assess(&[82.3, 795.0]).all.probability.unwrap();
    assert!(p(&two) > p(&one) + 1e-4);
}

/// Four values T, F, G and H, and correlations of the errors of pairs of them.
fn of_four(pairs: &[(&str, &str, f64)]) -> Result<Judge, String> {
    let mut text = String::new();
    for name in ["G", "H"] {
        let values = "nominal = 10\ntolerance = 1\nuncertainty = 0.5";
        text += &format!("[criteria.{name}]\nvariable = \"v\"\n{values}\n");
    }
    for (a, b, coefficient) in pairs {
        let pair = format!("between = [{a:?}, {b:?}]\ncoefficient = {coefficient}");
        text += &format!("[[uncertainty-correlations]]\n{pair}\n");
    }
    judge(&[("[verdict]", &format!("{text}[verdict]"))])
}

#[test]
fn every_pair_of_values_has_one_correlation() {
    let judge = of_four(&[("T", "F", 0.5), ("T", "G", 0.4), ("H", "F", 0.3)]).unwrap();
    let correlations = judge.measurement.correlations();
    assert_eq!(correlations, [(0, 1, 0.5), (0, 2, 0.4), (3, 1, 0.3)]);
    for (a, b) in [("T", "F"), ("F", "T")] {
        let error = of_four(&[("T", "F", 0.5), (a, b, 0.4)]).unwrap_err();
        assert!(error.contains("keep one"), "{error}");
    }
}

/// The sum of three standard errors with a correlation of r has a variance of 3 + 6 r, which would be negative at -0.6.
/// Any two of the three correlations could be: the determinant of their matrix is 1 - 2 * 0.36.
#[test]
fn correlations_that_cannot_be_name_the_first_value_with_which_they_cannot() {
    for pairs in [[("T", "F"), ("F", "G"), ("T", "G")], [("F", "T"), ("G", "F"), ("G", "T")]] {
        let pairs = pairs.map(|(a, b)| (a, b, -0.6));
        let error = of_four(&pairs).unwrap_err();
        assert!(error.contains("contradict each other") && error.contains("(with the criteria up to `G`)"), "{error}");
        assert!(of_four(&pairs[..2]).is_ok());
    }
}

#[test]
fn an_uncertainty_above_the_tolerance_is_warned_of_where_nothing_guards() {
    let wide = ("\"0.3 degC\"", "\"0.7 degC\"");
    let warnings = judge(&[wide]).unwrap().warnings;
    assert_eq!(warnings.len(), 1);
    assert!(warnings[0].text.starts_with("s.toml:13:15: T: the uncertainty 0.7 degC"), "{warnings:?}");
    let equal = ("\"0.3 degC\"", "\"0.75 %\"");
    assert_eq!(judge(&[equal]).unwrap().warnings, []);
    let guarded = ("share = \"5 %\"", "share = 0.05\nrisk = 0.1");
    assert_eq!(judge(&[wide, guarded]).unwrap().warnings, []);
}

#[test]
fn mistakes_have_their_place_and_remedy() {
    let pair = |a: &str, b: &str, r: &str| {
        format!("[[uncertainty-correlations]]\nbetween = [{a:?}, {b:?}]\ncoefficient = {r}\n")
    };
    let correlated = |text: String| vec![("[verdict]", text + "[verdict]")];
    let twice = pair("T", "F", "0.5") + &pair("F", "T", "0.5");
    let cases: Vec<Case<'_>> = vec![
        (vec![("\"t\"", "\"p\"".into())], "s.toml:10:12:", "name an output"),
        (vec![("\"t\"", "\"q\"".into())], "s.toml:10:12:", "a parameter"),
        (
            vec![("[criteria.T]", "[inputs.t]\nfile = \"t.csv\"\n[criteria.T]".into())],
            "s.toml:12:12:",
            "t is an input of the model",
        ),
        (vec![("\"0.3 degC\"", "\"-1 degC\"".into())], "s.toml:13:15:", "the uncertainty -1"),
        (vec![("\"0.3 degC\"", "\"1 K\"".into())], "s.toml:13:15:", "without the FMU"),
        (vec![("uncertainty = \"2 %\"\n", String::new())], "s.toml:19:12:", "add"),
        (vec![("coverage = 3", "coverage = 0".into())], "s.toml:15:11:", "positive"),
        (vec![("\"5 %\"", "\"5 N\"".into())], "s.toml:23:9:", "0.05"),
        (vec![("\"5 %\"", "1".into())], "s.toml:23:9:", "0.05"),
        (vec![("\"5 %\"", "0.1\nconfidence = 95".into())], "s.toml:24:14:", "below 1"),
        (vec![("\"5 %\"", "0.1\nrisk = 2".into())], "s.toml:24:8:", "5 %"),
        (vec![("\"5 %\"", "0.1\nguard-band = -1".into())], "s.toml:24:14:", "0 or more"),
        (
            vec![("uncertainty = \"0.3 degC\"\n", String::new()), ("\"5 %\"", "0.1\nrisk = 0.1".into())],
            "s.toml:23:8:",
            "[criteria.T]",
        ),
        (correlated(pair("T", "f", "0.5")), "s.toml:23:17:", "no criterion `f`"),
        (correlated(pair("T", "T", "0.5")), "s.toml:2", "name two"),
        (correlated(pair("T", "F", "1.5")), "s.toml:2", "from -1 to 1"),
        (correlated(twice), "s.toml:2", "keep one"),
    ];
    for (changes, place, remedy) in cases {
        let changes: Vec<(&str, &str)> = changes.iter().map(|(from, to)| (*from, to.as_str())).collect();
        let error = judge(&changes).unwrap_err();
        assert!(error.starts_with(place) && error.contains(remedy), "{changes:?}: {error}");
    }
}

/// Offset 0.15 degC, gain 0.25 % of 82 degC, of five repeats 0.1 / sqrt(5) degC: by hand.
#[test]
fn an_uncertainty_has_parts() {
    let with = |keys: &str| judge(&[("uncertainty = \"0.3 degC\"", keys)]);
    let of = |keys: &str| with(keys).unwrap().criteria[0].measured().error.unwrap();
    let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-9, "{a}, not {b}");
    let law = of("uncertainty = \"0.3 degC\"\ngain-uncertainty = \"0.5 %\"\nnoise = \"0.1 degC\"\nrepeats = 5");
    let squares = [0.0225, 0.205 * 0.205, 0.002];
    let combined = squares.iter().sum::<f64>();
    close(law.standard(), combined.sqrt());
    assert_eq!(law.freedom, 4.0);
    close(law.student, 0.002_f64.sqrt());
    // One reading with known noise; limits of error of 0.3 degC.
    close(of("noise = 0.1").expanded, 0.2);
    let law = of("uncertainty = 0.3\nuncertainty-distribution = \"rectangular\"");
    close(law.standard(), 0.3 / 3.0_f64.sqrt());
    // What holds as much as k = 2 of a normal one, erf(sqrt(2)).
    close(law.expanded, 0.3 * 0.954_499_736_103_642);
    for (keys, remedy) in [
        ("repeats = 5", "add their standard deviation as `noise`"),
        ("noise = 0.1\nrepeats = 1", "a whole number, 2 or more"),
        ("noise = 0.1\nrepeats = -3", "a whole number, 2 or more"),
        ("noise = 0.1\nrepeats = 2.5", "a whole number, 2 or more"),
        ("gain-uncertainty = 0.5", "write \"0.5 %\" or \"50 %\""),
        ("noise = -0.1", "the noise -0.1 must be a positive, finite number"),
        ("uncertainty-distribution = \"rectangular\"", "add `uncertainty`"),
        ("uncertainty = 0.3\nuncertainty-distribution = \"rectangular\"\ncoverage = 2", "remove `coverage`"),
        ("noise = 0.1\ncoverage = 2", "add `uncertainty` or remove it"),
        ("gain-uncertainty = \"0.1 degC\"", "the gain uncertainty 0.1 degC must be a positive part of the value"),
    ] {
        let error = with(keys).unwrap_err();
        assert!(error.starts_with("s.toml:") && error.contains(remedy), "{keys}: {error}");
    }
}

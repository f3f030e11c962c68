use std::path::Path;

use super::*;
use crate::results::{
    summary::Provenance,
    tally::{Sample, Tally},
};
use fmu_points::failure::Failure;
use study::{Study, concern::Code, judge::Judge};

const STUDY: &str = r#"
fmu = "a.fmu"
[parameters.p]
distribution = "uniform"
min = 0
max = 1
[criteria.T]
variable = "t"
nominal = 0
tolerance = 1
uncertainty = 1
[criteria.F]
variable = "f"
nominal = 0
tolerance = 1
uncertainty = 1
"#;

/// The sentences on so many points in the middle of all tolerances, and so many that are far outside.
fn said(study: &str, inside: u64, outside: u64) -> String {
    said_of("monte-carlo", study, inside, outside)
}

fn said_of(method: &str, study: &str, inside: u64, outside: u64) -> String {
    let study = Study::parse(Path::new("s.toml"), study.to_owned()).unwrap();
    let judge = Judge::new(&study, None).unwrap();
    let mut tally = Tally::new(&judge, Sample::Independent);
    for label in 0..inside + outside {
        let value = if label < inside { 0.0 } else { 100.0 };
        tally.add(label, &[], &Ok(vec![value, value]), None);
    }
    let provenance = Provenance { method: method.to_owned(), ..Provenance::default() };
    let summary = tally.summary(None, provenance, Vec::new());
    let answer = Answer::new(&summary);
    let first = format!("{} {}\n{}", answer.sign.mark(), answer.title, answer.answer);
    let all = [vec![first], answer.decides, answer.next, further(&summary)].concat();
    all.join("\n")
}

/// In the middle a value conforms with 95.45 %, two of them with 91.11 %.
#[test]
fn the_accepted_points_that_do_not_conform_are_counted() {
    let text = said(STUDY, 1000, 9000);
    assert_eq!(
        text,
        "\u{2713} Verified\n\
         The model can be right: it meets both criteria at 1,000 of 10,000 points (10.0 %, 95 % interval 9.4 .. 10.6 %).\n\
         Of the 1,000 accepted points 88.9 (8.9 %; 95 % interval 8.9 .. 9.2 %) are expected to be outside of a tolerance of the \
         true values, since the measured values are uncertain.\n\
         T decides most often: 9,000 of 10,000 points miss it."
    );
    let one = said(STUDY, 1, 9);
    assert!(one.contains("The verdict rests on 1 of 10 points: of others, with another seed, none may"), "{one}");
    assert!(!said(STUDY, 8, 2).contains("rests on"));
    assert!(
        one.contains("With a probability of 8.9 % (95 % interval 0 .. 98 %) the accepted point is outside"),
        "{one}"
    );
    let none = said(STUDY, 0, 10);
    assert!(none.contains("No point is likely to agree with the true values."), "{none}");
}

#[test]
fn without_an_uncertainty_nothing_is_stated() {
    let text = said(&STUDY.replacen("uncertainty = 1\n", "", 1), 5, 5);
    assert!(
        text.contains("conform is not known: the study states no uncertainty of T, and nothing is assumed.\n"),
        "{text}"
    );
    let text = said(&STUDY.replace("uncertainty = 1\n", ""), 5, 5);
    assert!(text.contains("no uncertainty of T, F,"), "{text}");
}

#[test]
fn a_verdict_that_is_open_tells_how_many_points_decide() {
    let rule = format!("{STUDY}[verdict]\nshare = \"10 %\"\n");
    let text = said(&rule, 12, 88);
    assert!(
        text.starts_with("? Inconclusive\nThe points do not tell: it does at 12 of 100 points, which is "),
        "{text}"
    );
    assert!(text.contains(" points decide, computed anew, or "), "{text}");
    let why = text.lines().nth(2).unwrap();
    assert!(why.starts_with("The required 10 % lie inside that range: more points"), "{text}");
    assert!(!text.contains("were repeated"));
    assert!(!said(&rule, 50, 50).contains("points decide"));
    // No command adds points to a table.
    let text = said_of("table", &rule, 12, 88);
    assert!(text.contains(" points decide, computed anew.") && !text.contains("--resume"), "{text}");
}

#[test]
fn guard_bands_are_named() {
    let with = |key: &str| said(&format!("{STUDY}[verdict]\nshare = \"1 %\"\n{key}\n"), 50, 50);
    let text = with("guard-band = 0.5");
    assert!(text.contains("a guard band of 0.5 expanded uncertainties; 50 points"), "{text}");
    assert!(!with("guard-band = 0").contains("guard band"));
    let text = with("risk = \"1 %\"");
    assert!(text.contains("nothing is accepted: measure better"), "{text}");
}

/// Every value is at a limit, so that half of the errors are beyond it: at most a quarter of the accepted points conform.
#[test]
fn a_verdict_whose_points_are_mostly_wrong_has_a_sign_of_its_own() {
    let study = Study::parse(Path::new("s.toml"), STUDY.to_owned()).unwrap();
    let judge = Judge::new(&study, None).unwrap();
    let mut tally = Tally::new(&judge, Sample::Independent);
    for label in 0..10 {
        tally.add(label, &[], &Ok(vec![1.0, 1.0]), None);
    }
    let mut summary = tally.summary(None, Provenance::default(), Vec::new());
    let answer = Answer::new(&summary);
    assert_eq!((answer.sign, &*answer.title), (Sign::Doubt, "Verified, with doubts"));
    assert!(answer.decides[0].contains("accepted points 7.5 (75 %"), "{answer:?}");
    // A warning is a doubt, too; a note is none.
    summary.conclusion.as_mut().unwrap().risk = None;
    assert_eq!(Answer::new(&summary).sign, Sign::Yes);
    let note = Concern::new(Code::NotReRun, "no point was re-run");
    summary.concerns.push(note);
    assert_eq!(Answer::new(&summary).sign, Sign::Yes);
    let moves = |name: &str| {
        let text = format!("{name}: its value still moves; but slowly");
        Concern::new(Code::StillMoves, text).remedied("Simulate longer.")
    };
    summary.concerns.extend(["T", "F"].map(moves));
    let answer = Answer::new(&summary);
    assert_eq!(answer.sign, Sign::Doubt);
    let told = "Warning: T: its value still moves; but slowly (as well: F).".to_owned();
    assert!(answer.decides.contains(&told), "{answer:?}");
    let simulate = answer.next.iter().filter(|next| *next == "Simulate longer.");
    assert_eq!(simulate.count(), 1, "{answer:?}");
}

#[test]
fn failures_are_told_by_their_kinds() {
    let study = Study::parse(Path::new("s.toml"), STUDY.to_owned()).unwrap();
    let judge = Judge::new(&study, None).unwrap();
    let mut tally = Tally::new(&judge, Sample::Independent);
    for label in 1..=200 {
        let failure = match label % 4 {
            0 => Failure::Timeout,
            1 => Failure::Error(format!("singular at t = {label} (fmi2DoStep)")),
            _ => Failure::Error(format!("no film at h2 = {} um", -0.5 * label as f64)),
        };
        tally.add(label, &[], &Err(failure), None);
    }
    let summary = tally.summary(None, Provenance::default(), Vec::new());
    let kinds = summary.failure_kinds.iter();
    let kinds: Vec<String> =
        kinds.map(|kind| format!("{} {} {}", kind.points, kind.first.point, kind.first.status)).collect();
    assert_eq!(
        kinds,
        ["100 2 fmi2Error: no film at h2 = -1 um", "50 1 fmi2Error: singular at t = 1 (fmi2DoStep)", "50 4 timeout"]
    );
    assert_eq!(summary.failures["fmi2Error"], 150);
    assert_eq!(summary.failed, 200);
    // Texts of which no two are alike are counted by their class in the end.
    let mut tally = Tally::new(&judge, Sample::Independent);
    for label in 0..1000 {
        let failure = Failure::Error("x".repeat(label + 1));
        tally.add(label as u64, &[], &Err(failure), None);
    }
    let summary = tally.summary(None, Provenance::default(), Vec::new());
    let kinds = &summary.failure_kinds;
    assert_eq!((kinds.len(), kinds[0].points, kinds[0].first.point), (21, 980, 20));
}

use std::path::Path;

use super::*;
use conformity::interval::clopper_pearson;
use study::Study;

pub(super) const STUDY: &str = r#"
fmu = "a.fmu"
[parameters.p]
distribution = "uniform"
min = 0
max = 1
[criteria.T]
variable = "t"
nominal = 0
tolerance = 0.5
uncertainty = 0.2
[verdict]
share = 0.2
guard-band = 0.5
"#;

pub(super) fn judge(text: &str) -> Judge {
    let study = Study::parse(Path::new("s.toml"), text.to_owned()).unwrap();
    Judge::new(&study, None).unwrap()
}

fn ending(until: &str, design: Option<Method>) -> Result<Ending, String> {
    Ending::new(until.parse().unwrap(), &judge(STUDY), design, &History::default())
}

pub(super) fn seen(counts: bool) -> Seen {
    if counts { Seen::Counts } else { Seen::Misses }
}

/// The number of points at which the study ends.
fn end(ending: &Ending, order: impl Iterator<Item = u64>, counts: impl Fn(u64) -> bool) -> usize {
    let mut front = Front::new(ending);
    for index in order {
        if front.add(index, seen(counts(index))) {
            break;
        }
    }
    front.front
}

#[test]
fn the_order_in_which_points_finish_does_not_matter() {
    for until in ["ci 0.2", "verdict"] {
        let ending = ending(until, Some(Method::MonteCarlo)).unwrap();
        let counts = |index| index % 3 == 0;
        let forward = end(&ending, 0..10_000, counts);
        assert_eq!(forward, end(&ending, (0..10_000).map(|i| i ^ 7), counts));
        assert!(forward > 50 && forward < 9_000, "{until}: {forward}");
    }
}

#[test]
fn a_width_is_looked_at_every_hundred_points() {
    let ending = ending("ci 0.2", Some(Method::MonteCarlo)).unwrap();
    let points = end(&ending, 0..10_000, |index| index % 3 == 0);
    assert_eq!(points % 100, 0);
    let [low, high] = clopper_pearson(points.div_ceil(3) as f64, points as f64, 0.95);
    assert!(high - low <= 0.2);
    assert_eq!(ending.looks(), None);
}

#[test]
fn a_verdict_ends_a_study_at_the_first_look_that_decides() {
    let chance = ending("verdict", Some(Method::MonteCarlo)).unwrap();
    assert_eq!(chance.looks().unwrap().way, Way::EveryPoint);
    // Of n points without a hit the share 0.2 has the likelihood 0.8^n, the mixture B(1/2, n + 1/2) / pi, which is about
    // 1 / sqrt(pi n): twenty times as much from 24 points on.
    assert_eq!(end(&chance, 0..100, |_| false), 24);
}

#[test]
fn guarded_points_count_for_the_verdict_and_others_for_the_width() {
    let judge = judge(STUDY);
    let design = Some(Method::MonteCarlo);
    let counts = |until, value: f64| ending(until, design).unwrap().counts(&judge, &Ok(vec![value])) == Seen::Counts;
    assert!(counts("verdict", 0.39) && !counts("verdict", 0.41));
    assert!(counts("ci 0.1", 0.5) && !counts("ci 0.1", 0.51));
    let failed = Err(fmu_points::failure::Failure::Timeout);
    let failed = ending("verdict", design).unwrap().counts(&judge, &failed);
    assert_eq!(failed, Seen::Failed);
}

/// Without any result there is no verdict: so the first failures do not end the study, and a hundred do.
#[test]
fn failures_alone_end_a_study_late() {
    let ending = ending("verdict", Some(Method::MonteCarlo)).unwrap();
    for (failed, end) in [(20, 24), (40, 41), (1000, 100)] {
        let mut front = Front::new(&ending);
        let seen = |index| {
            if index < failed { Seen::Failed } else { Seen::Misses }
        };
        assert!((0..1000).any(|index| front.add(index, seen(index))));
        assert_eq!(front.front, end);
    }
}

#[test]
fn points_that_allow_no_early_verdict_are_refused_with_a_remedy() {
    for (design, remedy) in [
        (Some(Method::LatinHypercube), "needs all its points"),
        (Some(Method::Sobol), "monte-carlo"),
        (None, "sample them"),
    ] {
        let message = ending("verdict", design).unwrap_err();
        assert!(message.contains(remedy), "{message}");
    }
    let chance = Some(Method::MonteCarlo);
    let without = judge(STUDY.split("[verdict]").next().unwrap());
    let message = Ending::new(Until::Verdict, &without, chance, &History::default()).unwrap_err();
    assert!(message.contains("add [verdict]"), "{message}");
    let limited = judge(&STUDY.replace("guard-band = 0.5", "risk = 0.1"));
    let message = Ending::new(Until::Verdict, &limited, chance, &History::default()).unwrap_err();
    assert!(message.contains("give `guard-band`"), "{message}");
    let nothing = judge(&STUDY.replace("guard-band = 0.5", "guard-band = 1e9"));
    let message = Ending::new(Until::Verdict, &nothing, chance, &History::default()).unwrap_err();
    assert!(message.contains("as wide as a tolerance"), "{message}");
    assert!(Ending::new(Until::Width(0.1), &without, None, &History::default()).is_ok());
}

#[test]
fn wrong_conditions_are_refused() {
    for wrong in ["0.01", "ci", "ci 0", "ci 2", "ci x", "verdicts"] {
        assert!(wrong.parse::<Until>().is_err());
    }
}

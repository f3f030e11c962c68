use super::*;
use rand::{RngExt, SeedableRng, rngs::StdRng};
use statrs::distribution::{Binomial, DiscreteCDF};

fn history(looks: &[Look]) -> History {
    History { looks: looks.to_vec() }
}

fn once(points: u64) -> Look {
    Look { points, way: Way::Once, awaited: false }
}

fn every_point(points: u64, awaited: bool) -> Look {
    Look { points, way: Way::EveryPoint, awaited }
}

#[test]
fn looks_spend_no_more_than_there_is() {
    let total: f64 = (0..1000).map(spent).sum();
    assert!(total < 1.0 && total > 0.998, "{total}");
}

#[test]
fn looks_at_randomised_designs_are_doublings() {
    let due = (1..=5000).filter(|&points| history(&[]).awaiting(Way::Doublings).is_due(8, points));
    assert_eq!(due.collect::<Vec<_>>(), [128, 256, 512, 1024, 2048, 4096]);
    assert_eq!([1, 128, 129, 256, 257].map(|n| doublings(8, n)), [0, 0, 1, 1, 2]);
    assert!(!Looks::default().is_due(1, 100) && history(&[]).awaiting(Way::EveryPoint).is_due(1, 7));
}

#[test]
fn nets_whose_number_is_no_power_of_two_double_as_well() {
    let doublings = history(&[]).awaiting(Way::Doublings);
    let due = (1..=200).filter(|&points| doublings.is_due(3, points));
    assert_eq!(due.collect::<Vec<_>>(), [48, 96, 192]);
}

/// A single look is decided by the interval for its number of points, a doubling by its part of the confidence.
#[test]
fn looks_at_fixed_numbers_are_decided_by_the_interval() {
    let rule = Rule { share: 0.2, confidence: 0.95 };
    for hits in 0..=100 {
        let expected = rule.decide(randomised(&[hits], 100, 0.95));
        assert_eq!(Looks::default().decide(rule, &[hits], 100), expected, "{hits}");
    }
    let doublings = history(&[]).awaiting(Way::Doublings);
    // The first look is at 16 points; three doublings later a look has a twentieth of the doubt.
    for hits in 0..=128 {
        let expected = rule.decide(randomised(&[hits], 128, 1.0 - 0.05 / 20.0));
        assert_eq!(doublings.decide(rule, &[hits], 128), expected, "{hits}");
    }
}

#[test]
fn going_on_after_a_fixed_number_leaves_half_of_the_doubt() {
    let rule = Rule { share: 0.2, confidence: 0.95 };
    let left = |looks: Looks| {
        let rule = looks.going_on(rule);
        assert_eq!(rule.share, 0.2);
        rule.confidence
    };
    let [none, fixed] = [history(&[]), history(&[once(100)])];
    for looks in [Looks::default(), fixed.awaiting(Way::EveryPoint)] {
        assert!((left(looks) - 0.975).abs() < 1e-15, "{looks:?}");
    }
    assert_eq!(left(none.awaiting(Way::EveryPoint)), 0.95);
    // Half of the doubt is a confidence of its own in the interval, too.
    let interval = fixed.awaiting(Way::EveryPoint).interval(&[87], 400, 0.95);
    let sequence = ConfidenceSequence { confidence: 0.975 };
    let expected = sequence.interval(87, 400);
    for k in 0..2 {
        assert!((interval[k] - expected[k]).abs() < 1e-12, "{interval:?} {expected:?}");
    }
}

#[test]
fn intervals_of_several_looks_are_wider() {
    let accepted: Vec<u64> = (0..16).map(|k| 20 + k % 5).collect();
    let width = |way: Way| {
        let [low, high] = history(&[]).awaiting(way).interval(&accepted, 16 * 64, 0.95);
        high - low
    };
    assert!(width(Way::Doublings) > width(Way::Once));
    // The third look has a twelfth of 5 %.
    let alone = randomised(&accepted, 16 * 64, 1.0 - 0.05 / 12.0);
    let doublings = history(&[]).awaiting(Way::Doublings);
    assert_eq!(doublings.interval(&accepted, 16 * 64, 0.95), alone);
}

#[test]
fn decisions_are_those_of_the_interval() {
    let rule = Rule { share: 0.2, confidence: 0.95 };
    for looks in [history(&[]), history(&[once(100)])].map(|h| h.awaiting(Way::EveryPoint)) {
        for points in [0, 1, 5, 40, 300] {
            for hits in 0..=points {
                let interval = looks.interval(&[hits], points, rule.confidence);
                let decision = looks.decide(rule, &[hits], points);
                assert_eq!(decision, rule.decide(interval), "{hits} of {points}");
            }
        }
    }
}

#[test]
fn only_the_first_look_has_the_interval_for_a_fixed_number() {
    let mut history = History::default();
    assert_eq!(history.at(100, 1), Looks::default());
    assert_eq!(history.note(once(100)), 1);
    // The same points again are the same look.
    assert_eq!(history.at(100, 1), Looks::default());
    assert_eq!(history.note(once(100)), 1);
    let second = history.at(200, 1);
    assert_eq!((second.way, second.after_fixed), (Way::EveryPoint, true));
    assert_eq!(history.note(every_point(200, false)), 2);
    assert_eq!(history.at(200, 1), second);
    assert_eq!(history.at(100, 1), Looks::default());
    assert_eq!(history.note(every_point(300, false)), 3);
    assert_eq!(history.at(400, 16).way, Way::Doublings);
    // Waiting for a verdict after it is a look of its own, and stays the same one.
    let awaiting = history.awaiting(Way::EveryPoint);
    assert!(awaiting.after_fixed);
    assert_eq!(history.note(every_point(300, true)), 4);
    assert_eq!(history.note(every_point(300, true)), 4);
    assert_eq!(history.awaiting(Way::EveryPoint), awaiting);
}

/// Points that were looked at after every one of them are not looked at for the first time.
#[test]
fn a_study_that_waited_keeps_its_sequence() {
    let waited = history(&[every_point(400, true)]);
    for points in [400, 800] {
        let looks = waited.at(points, 1);
        assert_eq!((looks.way, looks.after_fixed), (Way::EveryPoint, false));
        let [low, high] = looks.interval(&[87], points, 0.95);
        let sequence = ConfidenceSequence { confidence: 0.95 };
        assert_eq!([low, high], sequence.interval(87, points));
    }
}

#[test]
fn every_look_at_replicates_spends_a_part_of_its_own() {
    let doubled = |points, awaited| Look { points, way: Way::Doublings, awaited };
    let accepted = |points: u64| -> Vec<u64> { (0..16).map(|k| points / 64 + k % 5).collect() };
    let used = |history: &History, points: u64| {
        let interval = history.at(points, 16).interval(&accepted(points), points, 0.95);
        let look = |look: &u32| {
            let confidence = 1.0 - 0.05 * spent(*look);
            randomised(&accepted(points), points, confidence) == interval
        };
        (0..20).find(look)
    };
    let mut history = History::default();
    history.note(once(1024));
    let mut before = 0;
    for points in [1040, 1056, 2048, 4096, 4112] {
        let look = used(&history, points).unwrap();
        assert!(look > before, "{points}: {look}, {before}");
        before = look;
        history.note(doubled(points, false));
    }
}

/// Studies at the required share, or just below it, that are looked at again and again; how many are decided wrongly at
/// any look, if each is drawn as `looks` says.
fn wrong(studies: u32, numbers: &[u64], nets: usize, looks: impl Fn(&History, u64) -> Looks) -> [u32; 2] {
    let rule = |share| Rule { share, confidence: 0.95 };
    let (mut random, share) = (StdRng::seed_from_u64(20), 0.2);
    // At the required share only `not verified` is wrong, just below it only `verified`.
    let mut wrong = [0; 2];
    for _ in 0..studies {
        let mut history = History::default();
        let (mut accepted, mut points) = (vec![0; nets], 0);
        let mut ever = [false; 2];
        for &number in numbers {
            while points < number {
                let net = (points % nets as u64) as usize;
                accepted[net] += u64::from(random.random::<f64>() < share);
                points += 1;
            }
            let looks = looks(&history, points);
            ever[0] |= looks.decide(rule(share), &accepted, points) == Decision::NotVerified;
            ever[1] |= looks.decide(rule(share + 1e-9), &accepted, points) == Decision::Verified;
            history.note(Look { points, way: looks.way, awaited: false });
        }
        (0..2).for_each(|k| wrong[k] += u32::from(ever[k]));
    }
    wrong
}

fn resumed(studies: u32, samples: &[usize], doublings: u32) {
    let twenty: Vec<u64> = (1..=20).map(|k| 100 * k).collect();
    let doubled: Vec<u64> = (0..doublings).map(|k| 64 << k).collect();
    let most = Binomial::new(0.05, u64::from(studies)).unwrap().inverse_cdf(0.95);
    for numbers in [&twenty, &doubled] {
        for &nets in samples {
            let counts = wrong(studies, numbers, nets, |history, points| history.at(points, nets));
            println!("{} looks, {nets} samples: {counts:?} of {studies}", numbers.len());
            for wrong in counts {
                assert!(u64::from(wrong) <= most, "{nets}: {wrong} of {studies}");
            }
        }
    }
    // The test would notice studies that forget their looks.
    let forgetful = wrong(studies, &twenty, 1, |_, _| Looks::default());
    assert!(forgetful.iter().all(|&wrong| u64::from(wrong) > most), "{forgetful:?}");
}

#[test]
fn studies_that_are_resumed_again_and_again_hardly_ever_decide_wrongly() {
    resumed(300, &[4], 6);
}

#[test]
#[ignore = "takes a minute; run by scripts/test --long"]
fn of_10_000_studies_that_are_resumed_few_decide_wrongly() {
    resumed(10_000, &[1, 4, 16], 8);
}

use super::*;
use crate::looks::History;

fn statement(accepted: u64) -> RiskStatement {
    RiskStatement {
        guard: Some(0.0),
        accepted,
        accepted_by_sample: vec![accepted],
        bands: Bands { factors: [0.0; 2], accepted_at_least: vec![accepted], accepted_at_most: vec![accepted] },
        unfit: None,
        within_by_sample: vec![accepted],
        expected_conforming: None,
        criteria: Vec::new(),
        all: None,
    }
}

/// A rule for points that are looked at once.
fn once(rule: Rule) -> Ruling {
    Ruling { rule, looks: Looks::default(), count: 1 }
}

#[test]
fn one_point_is_enough_without_a_rule() {
    let conclusion = Conclusion::new(None, &statement(1), 10_000);
    assert_eq!(conclusion.verdict, Decision::Verified);
    assert_eq!(conclusion.verdict_words, "verified by the one-point rule: 1 of 10,000 points");
    let conclusion = Conclusion::new(None, &statement(0), 50);
    assert_eq!(conclusion.verdict, Decision::NotVerified);
    assert_eq!(conclusion.verdict_words, "not verified by the one-point rule: 0 of 50 points");
}

/// Who ends a study when it suits needs a wider interval.
#[test]
fn a_verdict_that_was_waited_for_has_an_interval_of_its_own() {
    let rule = Rule { share: 0.05, confidence: 0.95 };
    let concluded = |way| {
        let ruling = Ruling { looks: History::default().awaiting(way), ..once(rule) };
        Conclusion::new(Some(ruling), &statement(11), 100)
    };
    assert_eq!(concluded(Way::Once).verdict, Decision::Verified);
    let waited = concluded(Way::EveryPoint);
    assert_eq!(waited.verdict, Decision::Inconclusive);
    let required = waited.required.unwrap();
    assert!(required.interval.unwrap()[0] < 0.05 && required.method.contains("sequence"));
}

#[test]
fn a_share_is_decided_by_its_interval() {
    let rule = Some(once(Rule { share: 0.05, confidence: 0.95 }));
    for (accepted, verdict) in [(20, Decision::Verified), (6, Decision::Inconclusive), (0, Decision::NotVerified)] {
        let conclusion = Conclusion::new(rule, &statement(accepted), 100);
        assert_eq!(conclusion.verdict, verdict);
        assert!(conclusion.verdict_words.starts_with(&format!("{verdict}: required are 5 %")));
    }
    let open = Conclusion::new(rule, &statement(6), 100);
    let required = open.required.unwrap();
    let needed = required.points_needed.unwrap();
    assert!((1_000..3_000).contains(&needed), "{needed}");
    let going_on = required.points_needed_going_on.unwrap();
    assert!((2 * needed..8 * needed).contains(&going_on), "{going_on}");
    let text = serde_json::to_value(Conclusion::new(rule, &statement(0), 100)).unwrap();
    assert_eq!(text["verdict"], "not verified");
    assert_eq!(text["rule"], "share");
    assert_eq!(text["required"]["share"], 0.05);
    assert!(text["risk"].is_null());
}

/// The interval is that of all guard bands that may be the right one, and so are the points that it takes.
#[test]
fn a_share_is_decided_for_all_guard_bands_that_may_be_right() {
    let rule = once(Rule { share: 0.2, confidence: 0.95 });
    let given = Conclusion::new(Some(rule), &statement(30), 100);
    let statement = RiskStatement {
        bands: Bands { factors: [0.4, f64::INFINITY], accepted_at_least: vec![0], accepted_at_most: vec![45] },
        ..statement(30)
    };
    let banded = Conclusion::new(Some(rule), &statement, 100);
    assert_eq!(given.verdict, Decision::Verified);
    assert_eq!(banded.verdict, Decision::Inconclusive);
    let [given, banded] = [given, banded].map(|conclusion| conclusion.required.unwrap());
    let [low, high] = banded.interval.unwrap();
    assert!(low == 0.0 && (0.55..0.56).contains(&high), "{low} {high}");
    assert_eq!(banded.guard_bands, Some([Some(0.4), None]));
    assert_eq!(given.guard_bands, None);
    assert_eq!(given.points_needed, None);
    let open = |required: Requirement| required.points_needed.unwrap();
    let alone = points_needed_once(rule.rule, 0.3).unwrap();
    assert!(open(banded) > 8 * alone);
}

/// Of 100 points within all tolerances none can be accepted: that tells nothing of a required share of 5 %, and
/// all of one of which there are too few.
#[test]
fn a_measurement_that_cannot_decide_contradicts_no_model() {
    let unfit = |within, unfit| RiskStatement {
        accepted: 0,
        accepted_by_sample: vec![0],
        unfit: Some(unfit),
        within_by_sample: vec![within],
        ..statement(0)
    };
    let rule = Some(once(Rule { share: 0.05, confidence: 0.95 }));
    let risk = Unfit::Risk { limit: 0.05, least: 0.32 };
    let conclusion = Conclusion::new(rule, &unfit(92, risk), 100);
    assert_eq!(conclusion.verdict, Decision::Inconclusive);
    assert_eq!(
        conclusion.verdict_words,
        "inconclusive: the measurement cannot decide: whatever the guard band, at best 68.0 % of the accepted \
         points would conform, 95 % are required"
    );
    let required = conclusion.required.unwrap();
    assert_eq!((required.interval, required.points_needed), (None, None));
    let guard = Conclusion::new(rule, &unfit(92, Unfit::Guard), 100);
    assert!(guard.verdict_words.contains("as wide as a tolerance"));
    let few = Conclusion::new(rule, &unfit(1, risk), 1000);
    assert_eq!(few.verdict, Decision::NotVerified);
    let interval = few.required.unwrap().interval.unwrap();
    assert!(interval[0] == 0.0 && interval[1] < 0.01, "{interval:?}");
    assert!(few.verdict_words.contains("within all tolerances"));
}

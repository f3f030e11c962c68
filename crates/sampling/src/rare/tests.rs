use std::convert::Infallible;

use super::*;

fn search(dimensions: usize, runs: u64, seed: u64) -> Search {
    Search { dimensions, runs, seed, confidence: 0.95, is_binary: false }
}

/// The answer for an event whose level falls to 0, and the sets of points that it asked for.
fn asked(search: &Search, level: impl Fn(&[f64]) -> f64) -> (Answer, Vec<Vec<Vec<f64>>>) {
    let mut sets = Vec::new();
    let mut ask = |points: &[Vec<f64>]| {
        sets.push(points.to_vec());
        let judged = points.iter().map(|point| {
            let level = level(point);
            Judged { level: if search.is_binary { 0.0 } else { level }, met: level <= 0.0, failed: level.is_nan() }
        });
        Ok::<_, Infallible>(judged.collect())
    };
    let answer = match share(search, &mut ask) {
        Ok(answer) => answer,
        Err(error) => match error {},
    };
    (answer, sets)
}

/// 5.997807 is exceeded with a probability of 1e-9.
const LIMIT: f64 = 5.997_807_015_007_686;

#[test]
fn the_tail_of_a_normal_number_is_told_with_its_interval() {
    for seed in 1..=3 {
        let (answer, _) = asked(&search(7, 30_000, seed), |u| LIMIT - u[3]);
        let share = answer.share.unwrap();
        assert_eq!(share.method, Method::Weighted);
        let [low, high] = share.interval.unwrap();
        // Twice the interval of 95 %: 1 of 10,000 right estimates is outside.
        let wide = [low * low / share.value, high * high / share.value];
        assert!(wide[0] < 1e-9 && 1e-9 < wide[1], "{share:?}");
        assert!(share.error < 0.05, "{share:?}");
        assert!(answer.runs <= 30_000);
        let sum: f64 = answer.sample.iter().map(|point| point.weight).sum();
        assert!((sum / share.value - 1.0).abs() < 1e-9);
        assert_eq!(answer.regions.len(), 1);
        // The mean of what lies beyond the limit is a little beyond it; the others stay at 0. The nearest point is a
        // random one, here of some thousand in seven dimensions.
        let centre = &answer.regions[0].centre;
        assert!((6.0..6.6).contains(&centre[3]), "{centre:?}");
        assert!(centre.iter().enumerate().all(|(k, x)| k == 3 || x.abs() < 0.6));
    }
}

#[test]
fn both_of_two_regions_are_found_and_told_apart() {
    for seed in 1..=3 {
        let (answer, _) = asked(&search(2, 60_000, seed), |u| LIMIT - u[0].abs());
        assert_eq!(answer.regions.len(), 2);
        let share = answer.share.unwrap();
        assert!((share.value / 2e-9 - 1.0).abs() < 0.2, "{share:?}");
        for region in &answer.regions {
            assert!((region.share / 1e-9 - 1.0).abs() < 0.3, "{region:?}");
        }
    }
}

/// 0.25 is exceeded in 40 % of the cases, 3.5 in 2.3e-4.
#[test]
fn what_is_frequent_is_counted() {
    let (answer, _) = asked(&search(2, 20_000, 1), |u| 0.25 - u[0]);
    let share = answer.share.unwrap();
    assert_eq!((share.method, share.interval), (Method::Counted, None));
    assert!((share.value - 0.4013).abs() < 0.1);
    let rare = asked(&search(2, 20_000, 1), |u| 3.5 - u[0]).0.share.unwrap();
    assert_eq!(rare.method, Method::Weighted);
    assert!((rare.value / 2.326e-4 - 1.0).abs() < 0.25, "{rare:?}");
}

#[test]
fn an_event_that_runs_only_say_yes_or_no_to_is_found_by_wider_draws() {
    for seed in 1..=2 {
        let binary = Search { is_binary: true, ..search(4, 60_000, seed) };
        let (answer, _) = asked(&binary, |u| LIMIT - u[1]);
        let share = answer.share.clone().unwrap();
        assert!((share.value / 1e-9 - 1.0).abs() < 0.25, "{share:?}");
        assert!(answer.wider.met > 0 && answer.plain.met == 0);
    }
}

#[test]
fn what_never_happens_is_not_told() {
    // No level leads anywhere.
    let (flat, _) = asked(&search(3, 5000, 1), |_| 1.0);
    assert_eq!((flat.share, flat.rough), (None, None));
    assert_eq!(flat.levels, [(1.0, 1.0)]);
    assert_eq!(flat.plain.met, 0);
    // All runs that were asked for are made, most of them at plain points.
    assert_eq!(flat.runs, 5000);
    assert!(flat.plain.runs > 4000, "{:?}", flat.plain);
    // The runs do not go so deep.
    let (deep, _) = asked(&search(3, 5000, 1), |u| 30.0 - u[0]);
    assert_eq!(deep.share, None);
    let (level, share) = deep.levels.last().copied().unwrap();
    assert!(level > 0.0 && share > 0.0 && share < 1e-2, "{level} {share}");
    assert_eq!(deep.runs, 5000);
    // Wider draws do not find it, and all that is left is counted.
    let binary = Search { is_binary: true, ..search(3, 5000, 1) };
    let (none, _) = asked(&binary, |u| 30.0 - u[0]);
    assert_eq!((none.share, none.wider.met), (None, 0));
    assert_eq!(none.runs, 5000);
    assert!(none.plain.runs > 1000 && none.plain.met == 0);
}

/// Failed runs are no part of the event, and the way to it leads around them.
#[test]
fn failed_runs_are_counted_apart() {
    let (answer, _) = asked(&search(2, 30_000, 1), |u| if u[1] > 1.0 { f64::NAN } else { LIMIT - u[0] });
    let share = answer.share.unwrap();
    // The other parameter is below 1 in 84.13 %.
    assert!((share.value / 0.8413e-9 - 1.0).abs() < 0.2, "{share:?}");
    let failed = answer.plain.failed as f64 / answer.plain.runs as f64;
    assert!((failed - 0.1587).abs() < 0.06, "{failed}");
}

#[test]
fn a_search_is_the_same_whenever_it_is_run() {
    let again = |seed| asked(&search(3, 8000, seed), |u| 4.0 - u[0] - 0.1 * u[1]).1;
    assert_eq!(again(5), again(5));
    assert_ne!(again(5), again(6));
}

/// A thin ring: what lies within 4e-6 of the distance 1.5 has a share of about 3.9e-6. No mixture follows it.
#[test]
fn a_shape_that_no_mixture_follows_is_not_told() {
    let half = 4e-6;
    let (answer, _) = asked(&search(2, 20_000, 3), |u| (u[0].hypot(u[1]) - 1.5).abs() / half - 1.0);
    assert_eq!((answer.share, answer.sample.len()), (None, 0));
}

/// 5.612001 is exceeded with a probability of 1e-8.
const FAR: f64 = 5.612_001_244_174_789;

#[test]
fn all_of_many_equal_regions_are_found() {
    let (answer, _) = asked(&search(5, 100_000, 1), |u| FAR - u.iter().copied().fold(f64::MIN, f64::max));
    let share = answer.share.unwrap();
    assert!((share.value / 5e-8 - 1.0).abs() < 0.1, "{share:?}");
}

/// A ball near the centre and another one further away, which is larger: on the way to both, nearly all points are at the
/// first one.
#[test]
fn a_part_that_all_searches_lose_is_found() {
    const PLACES: [([f64; 2], f64); 2] = [([2.5, 0.0], 0.002), ([-3.0, 3.0], 0.02)];
    // The density hardly changes within them.
    let share = |([x, y], r): ([f64; 2], f64)| 0.5 * r * r * (-0.5 * (x * x + y * y)).exp();
    let exact: f64 = PLACES.into_iter().map(share).sum();
    for seed in 1..=3 {
        let (answer, _) = asked(&search(2, 60_000, seed), |u| {
            let away = |([x, y], r): ([f64; 2], f64)| (u[0] - x).hypot(u[1] - y) - r;
            PLACES.into_iter().map(away).fold(f64::MAX, f64::min)
        });
        let share = answer.share.unwrap();
        assert!((share.value / exact - 1.0).abs() < 0.1, "{share:?}, {exact}");
        assert_eq!(answer.regions.len(), 2);
    }
}

#[test]
fn the_way_leads_down_steps_and_through_plains() {
    let (steps, _) = asked(&search(3, 60_000, 1), |u| (FAR - u[0] - 1e-9).ceil());
    let share = steps.share.unwrap();
    assert!((share.value / 1e-8 - 1.0).abs() < 0.2, "{share:?}");
    let (plain, _) = asked(&search(3, 60_000, 1), |u| f64::from(u8::from(u[0] < FAR)));
    let share = plain.share.unwrap();
    assert!((share.value / 1e-8 - 1.0).abs() < 0.2, "{share:?}");
}

/// Takes minutes: `cargo test --release -p sampling --lib -- --ignored intervals_of_many_regions`. The example `rare` tries
/// more events.
#[test]
#[ignore = "takes minutes"]
fn intervals_of_many_regions_hold() {
    const SEEDS: u64 = 20;
    let (mut all_told, mut all_held) = (0, 0);
    for regions in [1, 2, 5, 7, 10, 20] {
        let exact = -(f64::from(regions) * (-1e-8_f64).ln_1p()).exp_m1();
        let (mut told, mut held) = (0, 0);
        for seed in 1..=SEEDS {
            let (answer, _) =
                asked(&search(regions as usize, 100_000, seed), |u| FAR - u.iter().copied().fold(f64::MIN, f64::max));
            if let Some([low, high]) = answer.share.and_then(|share| share.interval) {
                told += 1;
                held += u32::from(low <= exact && exact <= high);
            }
        }
        assert!(20 * held >= 17 * told, "{regions} regions: {held} of {told}");
        (all_told, all_held) = (all_told + told, all_held + held);
    }
    assert!(100 * all_held >= 93 * all_told, "{all_held} of {all_told}");
}

use std::{cell::RefCell, collections::HashMap};

use super::*;
use crate::{interval::clopper_pearson, sequence::ConfidenceSequence};
use rand::{RngExt, SeedableRng, rngs::StdRng};
use statrs::distribution::{Binomial, DiscreteCDF};

#[test]
fn decisions_follow_the_interval() {
    let rule = Rule { share: 0.05, confidence: 0.95 };
    assert_eq!(rule.decide([0.05, 0.2]), Decision::Verified);
    assert_eq!(rule.decide([0.01, 0.05]), Decision::Inconclusive);
    assert_eq!(rule.decide([0.01, 0.0499]), Decision::NotVerified);
}

#[test]
fn decisions_are_written_as_in_a_verdict() {
    let words = [Decision::Verified, Decision::NotVerified, Decision::Inconclusive];
    let words = words.map(|decision| decision.to_string());
    assert_eq!(words, ["verified", "not verified", "inconclusive"]);
}

/// However equal or unequal the counts: each net is one trial.
#[test]
fn each_net_of_a_share_is_one_trial() {
    let exact = |hits: u32, points: u32| clopper_pearson(hits.into(), points.into(), 0.95);
    let close = |a: [f64; 2], b: [f64; 2]| assert!((0..2).all(|k| (a[k] - b[k]).abs() < 1e-8), "{a:?} {b:?}");
    close(randomised(&[8; 16], 512, 0.95), exact(4, 16));
    close(randomised(&[30], 100, 0.95), exact(30, 100));
    let uneven: Vec<u64> = (0..16).map(|k| if k % 2 == 0 { 4 } else { 28 }).collect();
    close(randomised(&uneven, 512, 0.95), exact(8, 16));
}

/// All points of a net lie in one of sixteen cells: a share that 16 nets, of 32 points each, see in 64 % of the studies only.
#[test]
fn clumps_that_all_nets_missed_are_allowed_for() {
    let mut random = StdRng::seed_from_u64(31);
    let held = (0..1000).filter(|_| {
        let counts: Vec<u64> = (0..16).map(|_| if random.random::<f64>() < 0.0625 { 8 } else { 0 }).collect();
        let [low, high] = randomised(&counts, 512, 0.95);
        let exact = 0.0625 / 4.0;
        low <= exact && exact <= high
    });
    let held = held.count();
    assert!(held >= 930, "{held}");
}

/// The most wrong decisions in a number of studies at which a binomial test at 5 % does not yet say that their
/// probability is above 5 %.
fn most_wrong(studies: u64) -> u64 {
    Binomial::new(0.05, studies).unwrap().inverse_cdf(0.95)
}

const RULE: Rule = Rule { share: 0.2, confidence: 0.95 };
/// Just below, at and just above the required share, and further away.
const SHARES: [f64; 5] = [0.16, 0.198, 0.2, 0.202, 0.25];
/// Studies of the ordinary run, and of the long one.
const STUDIES: [u64; 2] = [400, 1000];

/// Counts the wrong decisions and those that decide at all.
fn repeat(studies: u64, seed: u64, share: f64, rule: Rule, study: impl Fn(&mut StdRng) -> Decision) -> [u64; 2] {
    let mut random = StdRng::seed_from_u64(seed);
    let (mut wrong, mut decided) = (0, 0);
    for _ in 0..studies {
        let decision = study(&mut random);
        let right = match decision {
            Decision::Verified => share >= rule.share,
            Decision::NotVerified => share < rule.share,
            Decision::Inconclusive => true,
        };
        wrong += u64::from(!right);
        decided += u64::from(decision != Decision::Inconclusive);
    }
    assert!(wrong <= most_wrong(studies), "{share}: {wrong} wrong");
    [wrong, decided]
}

fn hits(random: &mut StdRng, share: f64, points: u64) -> u64 {
    (0..points).map(|_| u64::from(random.random::<f64>() < share)).sum()
}

#[test]
fn independent_points_hardly_ever_decide_wrongly() {
    independent_points(STUDIES[0]);
}

fn independent_points(studies: u64) {
    for share in SHARES {
        let [_, decided] = repeat(studies, 5, share, RULE, |random| {
            RULE.decide(clopper_pearson(hits(random, share, 1000) as f64, 1000.0, RULE.confidence))
        });
        if (share - RULE.share).abs() > 0.03 {
            assert!(decided > studies * 85 / 100, "{share}: {decided}");
        }
    }
}

/// At such a share Wilson's interval would decide wrongly in 16 % of the studies.
#[test]
fn rare_points_hardly_ever_decide_wrongly() {
    rare_points(STUDIES[0]);
}

fn rare_points(studies: u64) {
    let share = 0.0017;
    let rule = Rule { share: 0.0018, ..RULE };
    repeat(studies, 6, share, rule, |random| {
        rule.decide(clopper_pearson(hits(random, share, 100) as f64, 100.0, rule.confidence))
    });
}

#[test]
fn studies_that_end_when_it_is_decided_hardly_ever_decide_wrongly() {
    studies_that_end(STUDIES[0]);
}

fn studies_that_end(studies: u64) {
    const MOST: u64 = 5000;
    let sequence = ConfidenceSequence { confidence: RULE.confidence };
    // Many studies come by the same counts.
    let known = RefCell::new(HashMap::new());
    let decide = |hits, points| {
        let compute = || RULE.decide(sequence.interval(hits, points));
        *known.borrow_mut().entry((hits, points)).or_insert_with(compute)
    };
    for share in SHARES {
        let [_, decided] = repeat(studies, 7, share, RULE, |random| {
            let mut hits = 0;
            for points in 1..=MOST {
                hits += u64::from(random.random::<f64>() < share);
                // Every tenth point keeps the test short; all points are looked at elsewhere.
                if points % 10 != 0 {
                    continue;
                }
                let decision = decide(hits, points);
                if decision != Decision::Inconclusive {
                    return decision;
                }
            }
            Decision::Inconclusive
        });
        if (share - RULE.share).abs() > 0.03 {
            assert!(decided > studies * 99 / 100, "{share}: {decided}");
        }
    }
}

/// Randomisations as even as those of a net: stratified in one or in two directions.
#[test]
fn randomised_designs_hardly_ever_decide_wrongly() {
    randomised_designs(STUDIES[0]);
}

fn randomised_designs(studies: u64) {
    const SIDE: u32 = 6;
    let designs = [2, 4, 16].map(|nets| [(nets, false), (nets, true)]);
    for share in SHARES {
        for (nets, plane) in designs.into_iter().flatten() {
            repeat(studies, 8, share, RULE, |random| {
                let counts: Vec<u64> = (0..nets)
                    .map(|_| {
                        let cells = (0..SIDE).flat_map(|i| (0..SIDE).map(move |j| (i, j)));
                        let inside = cells.filter(|&(i, j)| {
                            let mut place = |k| (f64::from(k) + random.random::<f64>()) / f64::from(SIDE);
                            let (x, y) = (place(i), place(j));
                            // Either half a plane or a corner that the diagonal cuts off.
                            if plane { x < share } else { x + y < (2.0 * share).sqrt() }
                        });
                        inside.count() as u64
                    })
                    .collect();
                let points = nets as u64 * u64::from(SIDE * SIDE);
                RULE.decide(randomised(&counts, points, RULE.confidence))
            });
        }
    }
}

#[test]
#[ignore = "takes a while; run by scripts/test --long"]
fn of_a_thousand_studies_few_decide_wrongly() {
    independent_points(STUDIES[1]);
    rare_points(STUDIES[1]);
    studies_that_end(STUDIES[1]);
    randomised_designs(STUDIES[1]);
}

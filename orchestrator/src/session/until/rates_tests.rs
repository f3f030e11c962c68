//! How often verdicts are wrong: many studies of a region whose share of the space is known.

use statrs::distribution::{Binomial, DiscreteCDF};

use super::{
    tests::{STUDY, judge, seen},
    *,
};
use sampling::{
    design::{Design, Sampling},
    distribution::Distribution,
};

/// The share of the region u0 + u1 < 2/sqrt(10) of the unit cube.
const SHARE: f64 = 0.2;

/// Required shares far below and just below the true one, at it, just above and far above.
const REQUIRED: [f64; 5] = [0.15, 0.197, 0.2, 0.203, 0.25];

/// How studies take their points and look at them.
#[derive(Clone, Copy, Debug)]
struct Way {
    method: Method,
    replicates: u64,
    points: u64,
    waits: bool,
}

impl Way {
    /// The verdict of the study with this seed.
    fn verdict(self, seed: u64, share: f64) -> Decision {
        let text = STUDY.replace("share = 0.2", &format!("share = {share}"));
        let judge = judge(&text);
        let sampling = Sampling { method: self.method, points: self.points, seed, replicates: self.replicates };
        let unit = Distribution::Uniform { min: 0.0, max: 1.0 };
        let design = Design::new(&sampling, vec![unit.clone(); 3]).unwrap();
        let is_inside = |index: u64| {
            let u = design.point(index);
            u[0] + u[1] < 0.4_f64.sqrt()
        };
        let rule = judge.rule.unwrap();
        if !self.waits {
            let mut counts = vec![0; self.replicates as usize];
            (0..self.points)
                .for_each(|index| counts[(index % self.replicates) as usize] += u64::from(is_inside(index)));
            return Looks::default().decide(rule, &counts, self.points);
        }
        let ending = Ending::new(Until::Verdict, &judge, Some(self.method), &History::default()).unwrap();
        let mut front = Front::new(&ending);
        for index in 0..self.points {
            if front.add(index, seen(is_inside(index))) {
                break;
            }
        }
        ending.looks().unwrap().decide(rule, &[front.count], front.front as u64)
    }
}

/// Counts wrong verdicts; a binomial test at 5 % must not say that more than 5 % of them are wrong.
fn check(way: Way, studies: u64, decided_far_away: u64) {
    let most_wrong = Binomial::new(0.05, studies).unwrap().inverse_cdf(0.95);
    for required in REQUIRED {
        let (mut wrong, mut decided) = (0, 0);
        for seed in 0..studies {
            let verdict = way.verdict(seed, required);
            wrong += u64::from(match verdict {
                Decision::Verified => SHARE < required,
                Decision::NotVerified => SHARE >= required,
                Decision::Inconclusive => false,
            });
            decided += u64::from(verdict != Decision::Inconclusive);
        }
        println!("{way:?}, {required}: {wrong} wrong, {decided} decided of {studies}");
        assert!(wrong <= most_wrong, "{way:?}, {required}: {wrong} of {studies}");
        if (required - SHARE).abs() > 0.04 {
            assert!(100 * decided >= decided_far_away * studies, "{way:?}, {required}: {decided}");
        }
    }
}

const CHANCE: Way = Way { method: Method::MonteCarlo, replicates: 1, points: 2000, waits: true };

const NETS: Way = Way { method: Method::Sobol, replicates: 16, points: 1024, waits: false };

#[test]
fn verdicts_that_were_waited_for_are_hardly_ever_wrong() {
    check(CHANCE, 120, 95);
}

#[test]
fn verdicts_of_replicates_are_hardly_ever_wrong() {
    check(NETS, 120, 0);
}

#[test]
#[ignore = "takes minutes; run by scripts/test --long"]
fn of_a_thousand_studies_hardly_any_verdict_is_wrong() {
    for waits in [true, false] {
        for points in [500, 20_000] {
            check(Way { waits, points, ..CHANCE }, 1000, 0);
        }
    }
    for (replicates, points) in [(16, 256), (16, 4096), (32, 8192)] {
        check(Way { replicates, points, ..NETS }, 1000, 0);
    }
}

/// The short form of `cargo run --release --example coverage`: intervals of a share.
#[test]
fn intervals_of_replicates_hold_the_share_in_95_per_cent_of_repetitions() {
    const POINTS: u64 = 512;
    const REPETITIONS: u64 = 400;
    let unit = Distribution::Uniform { min: 0.0, max: 1.0 };
    let mut held = 0;
    for seed in 0..REPETITIONS {
        let sampling = Sampling { method: Method::Sobol, points: POINTS, seed, replicates: 16 };
        let design = Design::new(&sampling, vec![unit.clone(); 3]).unwrap();
        let mut counts = [0; 16];
        for index in 0..POINTS {
            let u = design.point(index);
            counts[index as usize % 16] += u64::from(u[0] + u[1] < 1.0 && u[2] < 0.4);
        }
        let [low, high] = randomised(&counts, POINTS, 0.95);
        held += u64::from(low <= 0.2 && 0.2 <= high);
    }
    assert!(100 * held >= 95 * REPETITIONS, "{held} of {REPETITIONS}");
}

/// The worst pair of coordinates that was looked for in 60 dimensions: the points of a net lie in few of the boxes.
/// Of one net counted as independent points the interval holds in 1 of 60 studies.
#[test]
fn intervals_of_nets_with_a_bad_pair_hold() {
    const STUDIES: u64 = 60;
    let unit = Distribution::Uniform { min: 0.0, max: 1.0 };
    for (points, replicates) in [(64, 16), (512, 16), (512, 32)] {
        let held = (0..STUDIES).filter(|&seed| {
            let sampling = Sampling { method: Method::Sobol, points, seed, replicates };
            let design = Design::new(&sampling, vec![unit.clone(); 24]).unwrap();
            let mut counts = vec![0; replicates as usize];
            for index in 0..points {
                let u = design.point(index);
                counts[(index % replicates) as usize] += u64::from((u[13] + u[23] - 1.0).abs() <= 0.1);
            }
            let [low, high] = randomised(&counts, points, 0.95);
            low <= 0.19 && 0.19 <= high
        });
        let held = held.count();
        assert!(held >= 53, "{points} {replicates}: {held}");
    }
}

//! Studies of populations of which the right guard band is known: how often is the verdict wrong, if the band is found
//! from the same points?

use super::*;
use crate::{
    decision::{Decision, Rule},
    looks::{History, Look, Looks},
    measured::Measured,
    uncertainty::Uncertainty,
};
use rand::{RngExt, SeedableRng, rngs::StdRng};
use rand_distr::{Distribution, StandardNormal};

/// Where the model values of a population lie; each criterion has the tolerance 1.
#[derive(Clone, Copy, Debug)]
enum Shape {
    /// Normal about 0.
    Normal(f64),
    /// This share in a narrow peak near the limit, the others about 0.
    Peaks(f64),
    /// Even from the limit down to this much less.
    Edge(f64),
}

#[derive(Debug)]
struct Population {
    shape: Shape,
    criteria: usize,
    /// Of the errors of the measured values.
    correlation: f64,
    standard: f64,
    risk: f64,
    points: usize,
}

impl Population {
    fn measurement(&self) -> Measurement {
        let criterion = Measured::within(0.0, 1.0, Some(Uncertainty::normal(self.standard, 1.0).law(0.0)));
        let pairs = match self.criteria {
            2 => vec![(0, 1, self.correlation)],
            _ => Vec::new(),
        };
        Measurement::new(vec![criterion; self.criteria], &pairs).unwrap()
    }

    fn tally<'a>(&self, measurement: &'a Measurement, samples: u64) -> Tally<'a> {
        Tally { measurement, sum: RiskTally::new(measurement, Guard::Limiting { risk: self.risk }, samples) }
    }

    /// A point; those of a net have their places in it.
    fn draw(&self, random: &mut StdRng, place: Option<f64>) -> Vec<f64> {
        let mut one = |place: Option<f64>| {
            let normal: f64 = StandardNormal.sample(random);
            let share = place.unwrap_or_else(|| random.random());
            match self.shape {
                Shape::Normal(deviation) => deviation * normal,
                Shape::Peaks(near) if share < near => 0.8 + 0.05 * normal,
                Shape::Peaks(_) => 0.1 * normal,
                Shape::Edge(width) => 1.0 - width * share,
            }
        };
        (0..self.criteria).map(|k| one(place.filter(|_| k == 0))).collect()
    }

    /// The share that the right guard band accepts, by so many points that its error is far below that of a study.
    fn right_share(&self) -> f64 {
        const POINTS: usize = 400_000;
        let measurement = self.measurement();
        let mut tally = self.tally(&measurement, 1);
        let mut random = StdRng::seed_from_u64(99);
        for i in 0..POINTS {
            let place = (i as f64 + 0.5) / POINTS as f64;
            tally.add(&self.draw(&mut random, Some(place)));
        }
        // Both ends are near the right band.
        let Bands { accepted_at_least, accepted_at_most, .. } = tally.sum.statement().bands;
        (accepted_at_least[0] + accepted_at_most[0]) as f64 / (2 * POINTS) as f64
    }
}

struct Tally<'a> {
    measurement: &'a Measurement,
    sum: RiskTally,
}

impl Tally<'_> {
    fn add(&mut self, values: &[f64]) {
        self.sum.add(Some(&self.measurement.assess(values)));
    }
}

/// The share that a guard band accepts is known, or a hair more is required: how many of so many studies decide wrongly
/// either way at any look, first with the interval for all bands that may be right, then with that for the one that was
/// found, as if it had been given.
fn wrong(population: &Population, studies: u32, nets: usize, numbers: &[usize]) -> [[u32; 2]; 2] {
    let share = population.right_share();
    let rule = |share| Rule { share, confidence: 0.95 };
    let measurement = population.measurement();
    let mut random = StdRng::seed_from_u64(5);
    let mut wrong = [[0; 2]; 2];
    for _ in 0..studies {
        let mut ever = [[false; 2]; 2];
        let mut history = History::default();
        let mut tally = population.tally(&measurement, nets as u64);
        let shifts: Vec<f64> = (0..nets).map(|_| random.random()).collect();
        let mut drawn = 0;
        for &points in numbers {
            for i in drawn..points {
                let place = (nets > 1).then(|| (in_net(i / nets) + shifts[i % nets]).fract());
                tally.add(&population.draw(&mut random, place));
            }
            drawn = points;
            let looks = history.at(points as u64, nets);
            let statement = tally.sum.statement_at(looks.band_confidence(0.95));
            for (k, share) in [share, share + 1e-9].into_iter().enumerate() {
                let wrong = [Decision::NotVerified, Decision::Verified][k];
                let points = points as u64;
                let by_bands = looks.decide_by_bands(rule(share), &statement.bands, points);
                let least = tally.sum.all.least_step(population.risk).unwrap_or(usize::MAX);
                let accepted: Vec<u64> = tally.sum.all.split(least)[0].iter().map(|part| part.count).collect();
                let as_given = looks.decide(rule(share), &accepted, points);
                ever[0][k] |= by_bands == wrong;
                ever[1][k] |= as_given == wrong;
            }
            history.note(Look { points: points as u64, way: looks.way, awaited: false });
        }
        for (sum, ever) in wrong.iter_mut().flatten().zip(ever.as_flattened()) {
            *sum += u32::from(*ever);
        }
    }
    wrong
}

/// The place of a point in a net that fills up evenly (van der Corput 1935).
fn in_net(k: usize) -> f64 {
    (k as u32).reverse_bits() as f64 / 2.0_f64.powi(32)
}

const fn population(shape: Shape, standard: f64, risk: f64, points: usize) -> Population {
    Population { shape, criteria: 1, correlation: 0.0, standard, risk, points }
}

/// Half of the points lie where the guard band ends, so that the share follows the band that is found. The interval for
/// that band decides wrongly too often: the test can tell.
#[test]
fn a_guard_band_from_the_same_points_decides_rightly() {
    bands_of_the_same_points(150);
}

fn bands_of_the_same_points(studies: u32) {
    let peaks = population(Shape::Peaks(0.5), 0.2, 0.05, 100);
    let [by_bands, as_given] = wrong(&peaks, studies, 1, &[peaks.points]);
    assert!(by_bands.iter().all(|&n| n <= studies / 20), "{by_bands:?}");
    assert!(as_given.iter().any(|&n| n > studies / 12), "{as_given:?}");
}

#[test]
#[ignore = "takes ten minutes; run by scripts/test --long"]
fn guard_bands_from_the_same_points_decide_rightly_whatever_the_population() {
    const STUDIES: u32 = 1000;
    let several = |criteria, population| Population { criteria, ..population };
    for population in [
        population(Shape::Peaks(0.5), 0.2, 0.05, 100),
        population(Shape::Peaks(0.5), 0.2, 0.05, 1000),
        population(Shape::Peaks(0.3), 0.2, 0.03, 100),
        population(Shape::Normal(0.5), 0.4, 0.05, 50),
        population(Shape::Normal(0.5), 0.4, 0.05, 100),
        population(Shape::Normal(1.0), 0.3, 0.1, 400),
        population(Shape::Edge(1.0), 0.2, 0.1, 400),
        Population { correlation: 0.9, ..several(2, population(Shape::Normal(0.5), 0.2, 0.05, 300)) },
        several(3, population(Shape::Normal(0.6), 0.2, 0.1, 300)),
        several(3, population(Shape::Edge(0.6), 0.2, 0.2, 1024)),
    ] {
        let points = population.points;
        let looks: Vec<usize> = (0..4).map(|k| points.next_multiple_of(16) << k).collect();
        let mut ways = vec![(1, vec![points]), (16, vec![1024])];
        if points <= 100 {
            ways.extend([(1, looks.clone()), (16, looks)]);
        }
        for (nets, numbers) in ways {
            let [by_bands, as_given] = wrong(&population, STUDIES, nets, &numbers);
            println!("{population:?} {nets} {numbers:?}: {by_bands:?}, as given {as_given:?}");
            assert!(by_bands.iter().all(|&n| n <= STUDIES / 20), "{by_bands:?}");
        }
    }
}

/// The probability that a point does not conform that a band of a study accepts, over the whole population, is above the limit
/// in so many studies: of the band that the study finds, and of the least one that its own points allow.
fn exceeded(population: &Population, studies: u32, nets: usize) -> [u32; 2] {
    let measurement = population.measurement();
    let mut random = StdRng::seed_from_u64(7);
    let all: Vec<Assessed> = (0..20_000)
        .map(|i| measurement.assess(&population.draw(&mut random, Some((f64::from(i) + 0.5) / 20_000.0))).all)
        .collect();
    let risk_of = |factor: f64| {
        let accepted = all.iter().filter(|point| point.margin >= factor);
        let [count, wrong] = accepted.fold([0.0, 0.0], |[n, sum], p| [n + 1.0, sum + 1.0 - p.probability.unwrap()]);
        if count > 0.0 { wrong / count } else { 0.0 }
    };
    let mut exceeded = [0; 2];
    for _ in 0..studies {
        let mut tally = population.tally(&measurement, nets as u64);
        let shifts: Vec<f64> = (0..nets).map(|_| random.random()).collect();
        for i in 0..population.points {
            let place = (nets > 1).then(|| (in_net(i / nets) + shifts[i % nets]).fract());
            tally.add(&population.draw(&mut random, place));
        }
        let least = tally.sum.all.least_step(population.risk).map(|step| step as f64 * Guard::STEP);
        for (sum, band) in exceeded.iter_mut().zip([tally.sum.statement().guard, least]) {
            // What 20,000 points do not tell apart is no excess.
            *sum += u32::from(band.is_some_and(|factor| risk_of(factor) > 1.01 * population.risk));
        }
    }
    exceeded
}

/// The least band of the same points exceeds its limit in every other study.
#[test]
fn the_band_of_a_study_keeps_its_limit() {
    bands_keep_their_limit(100);
}

#[test]
#[ignore = "takes a while; run by scripts/test --long"]
fn bands_of_more_studies_decide_rightly_and_keep_their_limit() {
    bands_of_the_same_points(300);
    bands_keep_their_limit(200);
}

fn bands_keep_their_limit(studies: u32) {
    for (population, nets) in
        [(population(Shape::Normal(0.5), 0.3, 0.04, 200), 1), (population(Shape::Peaks(0.5), 0.2, 0.05, 128), 8)]
    {
        let [found, least] = exceeded(&population, studies, nets);
        assert!(found <= studies / 20, "{population:?} {nets}: {found}");
        assert!(least > studies / 5, "{population:?} {nets}: {least}");
    }
}

/// Where the points show it, the interval is that of the band that was found: no band is needed in any case, or the one
/// that is enough for any population accepts as many.
#[test]
fn bands_that_are_certain_cost_nothing() {
    let looks = Looks::default();
    let of = |standard, values: &[f64]| {
        let certain = population(Shape::Normal(1.0), standard, 0.05, values.len());
        let measurement = certain.measurement();
        let mut tally = certain.tally(&measurement, 1);
        values.iter().for_each(|&value| tally.add(&[value]));
        let statement = tally.sum.statement();
        let points = values.len() as u64;
        let plain = looks.interval(&statement.accepted_by_sample, points, 0.95);
        (plain, looks.interval_of_bands(&statement.bands, points, 0.95))
    };
    // At 0.6 the probability not to conform is 2.3 %, at 1.5 nobody asks.
    let values: Vec<f64> = (0..50).map(|i| if i < 20 { 0.6 } else { 1.5 }).collect();
    let (plain, bands) = of(0.2, &values);
    assert_eq!(plain, bands);
    // At 0.9 it is 31 %: some of the points there could be accepted.
    let values: Vec<f64> = (0..50).map(|i| if i < 20 { 0.6 } else { 0.9 }).collect();
    let (plain, bands) = of(0.2, &values);
    assert_eq!(plain[0], bands[0]);
    assert_eq!(plain[1], bands[1]);
    let close: Vec<f64> = (0..50).map(|i| if i < 45 { 0.6 } else { 0.9 }).collect();
    let (plain, bands) = of(0.2, &close);
    assert_eq!((plain[0], bands[1]), (bands[0], 1.0));
}

/// By hand: the limit of 5 % is 1.645 standard uncertainties away, but one more point in twenty may be as near as 0.
#[test]
fn the_worst_point_of_a_band_is_the_one_at_its_limit() {
    let criterion = population(Shape::Normal(1.0), 0.2, 0.05, 1).measurement().criteria()[0];
    for (margin, expected) in [(0.0, 0.5), (1.644_853_6, 0.05), (5.0, 5.733e-7), (9.0, 5.733e-7)] {
        let most = criterion.most_not_conforming(margin).unwrap();
        assert!((most - expected).abs() < 1e-4 * expected, "{margin}: {most}");
    }
    let unknown = Measured { error: None, ..criterion };
    assert_eq!(unknown.most_not_conforming(0.0), None);
}

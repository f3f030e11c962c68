use super::*;
use crate::{
    joint::JointNormal,
    measured::{Limits, Measured},
    normal::between,
    uncertainty::Uncertainty,
};
use statrs::distribution::{ContinuousCDF, Normal};

/// A normal population of model values, a criterion for them, and the published risks.
struct Case {
    mean: f64,
    deviation: f64,
    nominal: f64,
    tolerance: f64,
    capability: f64,
    consumer: f64,
    producer: f64,
}

impl Case {
    fn standard_uncertainty(&self) -> f64 {
        self.tolerance / (2.0 * self.capability)
    }

    fn measured(&self) -> Measured {
        Measured::within(
            self.nominal,
            self.tolerance,
            Some(Uncertainty::normal(2.0 * self.standard_uncertainty(), 2.0).law(0.0)),
        )
    }

    /// R_C and R_P with a guard band: the model value and its distance to the true value are jointly
    /// normal, so that all is known from one bivariate probability.
    fn exact(&self, guard: f64) -> [f64; 2] {
        let (s, u) = (self.deviation, self.standard_uncertainty());
        let away = s.hypot(u);
        let joint = JointNormal::new(2, &[(0, 1, s / away)]).unwrap();
        let centre = (self.mean - self.nominal, self.tolerance - guard * 2.0 * u);
        let lower = [(-centre.1 - centre.0) / s, (-self.tolerance - centre.0) / away];
        let upper = [(centre.1 - centre.0) / s, (self.tolerance - centre.0) / away];
        let both = joint.probability(&lower, &upper);
        let accepted = between(lower[0], upper[0]);
        let conforming = between(lower[1], upper[1]);
        [accepted - both, conforming - both]
    }
}

/// The points of `studies/paper-table3.toml`, as normal populations.
const CASES: [Case; 4] =
    [bearing(1.0, 0.1338, 0.0984), bearing(4.0, 0.0351, 0.0322), load(1.0, 0.0837, 0.0685), load(4.0, 0.0199, 0.0188)];

const fn bearing(capability: f64, consumer: f64, producer: f64) -> Case {
    Case { mean: 81.486_108, deviation: 0.345_215, nominal: 82.0, tolerance: 0.615, capability, consumer, producer }
}

const fn load(capability: f64, consumer: f64, producer: f64) -> Case {
    Case { mean: 769.503_815, deviation: 89.266_864, nominal: 750.0, tolerance: 52.5, capability, consumer, producer }
}

/// Integrates the formulas of JCGM 106 over the population, by Simpson's rule on both sides of each
/// limit.
fn integrated(case: &Case, guard: f64) -> [f64; 2] {
    let measurement = Measurement::new(vec![case.measured()], &[]).unwrap();
    let half = case.tolerance - guard * 2.0 * case.standard_uncertainty();
    let limits = [case.nominal - half, case.nominal + half];
    let far = [-9.0, 9.0].map(|z| case.mean + z * case.deviation);
    let part = |from: f64, to: f64, conforming: bool| {
        const STEPS: i32 = 20_000;
        let h = (to - from) / f64::from(STEPS);
        let term = |i: i32| {
            let value = from + f64::from(i) * h;
            let z = (value - case.mean) / case.deviation;
            let density = (-0.5 * z * z).exp() / (case.deviation * std::f64::consts::TAU.sqrt());
            let p = measurement.assess(&[value]).all.probability.unwrap();
            let weight = [2.0, 4.0, 1.0][if i == 0 || i == STEPS { 2 } else { i as usize % 2 }];
            weight * density * if conforming { p } else { 1.0 - p }
        };
        (0..=STEPS).map(term).sum::<f64>() * h / 3.0
    };
    let consumer = part(limits[0], limits[1], false);
    [consumer, part(far[0], limits[0], true) + part(limits[1], far[1], true)]
}

#[test]
fn numbers_of_normal_populations() {
    for case in &CASES {
        for guard in [0.0, 0.2, 0.6] {
            let (exact, integrated) = (case.exact(guard), integrated(case, guard));
            for k in 0..2 {
                assert!((exact[k] - integrated[k]).abs() < 1e-6, "{exact:?} {integrated:?}");
            }
        }
        let [consumer, producer] = case.exact(0.0);
        assert!((consumer - case.consumer).abs() < 1e-4, "{consumer}");
        assert!((producer - case.producer).abs() < 1e-4, "{producer}");
    }
}

#[test]
fn many_points_have_the_numbers_of_their_population() {
    for case in &CASES {
        for guard in [0.0, 0.6] {
            let risk = quantiles(case, Guard::Given(guard), 100_000).all.unwrap();
            let [consumer, producer] = case.exact(guard);
            assert!((risk.consumer - consumer).abs() < 1e-4, "{risk:?}");
            assert!((risk.producer - producer).abs() < 1e-4, "{risk:?}");
        }
    }
}

/// Points at the quantiles of the population.
fn quantiles(case: &Case, guard: Guard, points: u32) -> RiskStatement {
    let measurement = Measurement::new(vec![case.measured()], &[]).unwrap();
    let mut tally = RiskTally::new(&measurement, guard, 1);
    let population = Normal::new(case.mean, case.deviation).unwrap();
    for i in 0..points {
        let value = population.inverse_cdf((f64::from(i) + 0.5) / f64::from(points));
        tally.add(Some(&measurement.assess(&[value])));
    }
    tally.statement()
}

#[test]
fn of_one_criterion_the_joint_risk_is_its_own() {
    let statement = quantiles(&CASES[0], Guard::Given(0.1), 1000);
    assert_eq!(statement.criteria.len(), 1);
    assert_eq!(statement.criteria[0], statement.all);
    let risk = statement.all.unwrap();
    let expected = statement.expected_conforming.unwrap();
    assert!((risk.conformance_probability * 1000.0 - expected).abs() < 1e-9);
    let given = risk.not_conforming_given_accepted.unwrap();
    assert!((given * statement.accepted as f64 / 1000.0 - risk.consumer).abs() < 1e-12);
}

/// The risk is 0.1338 of 0.645 without a guard band: about a fifth.
#[test]
fn the_least_guard_band_that_limits_the_risk_is_found() {
    let case = &CASES[0];
    for limit in [0.15, 0.1, 0.06] {
        let statement = quantiles(case, Guard::Limiting { risk: limit }, 20_000);
        let guard = statement.guard.unwrap();
        let share = |guard: f64| {
            let (s, half) = (case.deviation, case.tolerance * (1.0 - guard));
            let offset = case.mean - case.nominal;
            let accepted = between((-half - offset) / s, (half - offset) / s);
            case.exact(guard)[0] / accepted
        };
        // Of so many points the band that is shown to be enough is hardly wider than the right one.
        assert!(share(guard) < limit + 1e-3, "{guard}");
        assert!(share(guard - 0.03) > limit, "{guard}");
        let risk = statement.all.unwrap();
        let [_, high] = risk.intervals.unwrap().not_conforming_given_accepted;
        assert!((high - limit).abs() < 2e-3, "{high}");
    }
    let wide = quantiles(case, Guard::Limiting { risk: 0.5 }, 1000);
    assert_eq!(wide.guard, Some(0.0));
    let simple = quantiles(case, Guard::Given(0.0), 1000);
    assert_eq!(wide.accepted, simple.accepted);
    assert!((wide.all.unwrap().consumer - simple.all.unwrap().consumer).abs() < 1e-12);
}

#[test]
fn where_no_guard_band_is_enough_nothing_is_accepted() {
    // Even at the measured value itself the probability not to conform is 4.55 %.
    let statement = quantiles(&CASES[0], Guard::Limiting { risk: 0.045 }, 1000);
    assert_eq!((statement.guard, statement.accepted), (None, 0));
    let risk = statement.all.unwrap();
    assert_eq!(risk.consumer, 0.0);
    assert_eq!(risk.producer, risk.conformance_probability);
    assert_eq!(risk.not_conforming_given_accepted, None);
    let intervals = risk.intervals.unwrap();
    assert_eq!(intervals.not_conforming_given_accepted, [0.0, 1.0]);
    let Some(Unfit::Risk { limit, least }) = statement.unfit else {
        panic!("{:?}", statement.unfit);
    };
    assert_eq!(limit, 0.045);
    assert!((least - 0.0455).abs() < 1e-4, "{least}");
    let within: u64 = statement.within_by_sample.iter().sum();
    assert!(within > 100, "{within}");
}

/// Two points within the tolerance and one outside; the tolerance is two expanded uncertainties.
fn three_points(guard: Guard, values: &[f64]) -> RiskStatement {
    let measured = Measured::within(0.0, 1.0, Some(Uncertainty::normal(0.5, 2.0).law(0.0)));
    let measurement = Measurement::new(vec![measured], &[]).unwrap();
    let mut tally = RiskTally::new(&measurement, guard, 1);
    for &value in values {
        tally.add(Some(&measurement.assess(&[value])));
    }
    tally.statement()
}

#[test]
fn a_guard_band_as_wide_as_the_tolerance_decides_nothing() {
    for (band, unfit) in [(1.5, None), (2.0, Some(Unfit::Guard)), (2.5, Some(Unfit::Guard))] {
        let statement = three_points(Guard::Given(band), &[0.1, 0.2, 1.5]);
        assert_eq!((statement.unfit, statement.accepted), (unfit, if band < 2.0 { 2 } else { 0 }));
        assert_eq!(statement.within_by_sample, [2]);
    }
    // Where no point is within the tolerance, the guard band changes nothing.
    assert_eq!(three_points(Guard::Given(2.5), &[1.5]).unfit, None);
    let none = three_points(Guard::Limiting { risk: 1e-9 }, &[1.5]);
    assert_eq!((none.guard, none.unfit), (Some(0.0), None));
}

#[test]
fn points_that_are_no_sample_have_no_intervals() {
    let points = |guard: Guard| {
        let measured = Measured::within(0.0, 1.0, Some(Uncertainty::normal(0.5, 2.0).law(0.0)));
        let measurement = Measurement::new(vec![measured], &[]).unwrap();
        let mut tally = RiskTally::new(&measurement, guard, 1);
        [0.1, 0.3, 0.8, 1.5].iter().for_each(|value| tally.add(Some(&measurement.assess(&[*value]))));
        [tally.statement(), tally.statement_of_no_sample()]
    };
    // 5 % fail at 1.645 standard uncertainties of 0.25 within the limit, at 0.589; a wider band accepts the same points.
    let [_, sure] = points(Guard::Limiting { risk: 0.05 });
    assert!(sure.guard.unwrap() >= 1.644_853_6 / 2.0 && sure.accepted == 2, "{sure:?}");
    let [statement, grid] = points(Guard::Given(0.0));
    assert!(statement.all.clone().unwrap().intervals.is_some());
    assert!(grid.all.unwrap().intervals.is_none());
    assert!(grid.criteria[0].clone().unwrap().intervals.is_none());
    assert_eq!(grid.accepted, statement.accepted);
}

/// ISO 14253-1 asks for 95 % at each point: one standard uncertainty of 0.25 within a limit conform 84 %, two 97.7 %.
#[test]
fn each_point_has_to_conform_with_the_required_probability() {
    let statement = three_points(Guard::EachPoint { risk: 0.05 }, &[0.0, 0.5, 0.75, 0.58, 0.6, 1.5]);
    assert_eq!((statement.accepted, statement.unfit, statement.guard), (3, None, Some(0.0)));
    assert!(statement.all.unwrap().not_conforming_given_accepted.unwrap() < 0.05);
    // At the measured value itself 0.0063 % fail.
    let none = three_points(Guard::EachPoint { risk: 5e-5 }, &[0.0, 0.5]);
    assert_eq!((none.accepted, none.unfit), (0, Some(Unfit::Point { limit: 5e-5 })));
}

/// Model values of two criteria, independent; their measured values' errors correlated. All four
/// quantities (model values, distances to the true values) are jointly normal.
#[test]
fn joint_risks_of_correlated_errors() {
    const POINTS: u32 = 500;
    let (deviations, uncertainties, r) = ([0.8, 1.1], [0.5, 0.7], -0.7);
    let criterion = |k: usize| {
        Measured::within(0.0, [1.0, 1.5][k], Some(Uncertainty::normal(2.0 * uncertainties[k], 2.0).law(0.0)))
    };
    let measurement = Measurement::new(vec![criterion(0), criterion(1)], &[(0, 1, r)]).unwrap();
    let mut tally = RiskTally::new(&measurement, Guard::Given(0.0), 1);
    let normal = Normal::standard();
    let value = |k: usize, i| {
        let z = normal.inverse_cdf((f64::from(i) + 0.5) / f64::from(POINTS));
        0.3 + deviations[k] * z
    };
    for i in 0..POINTS {
        for j in 0..POINTS {
            tally.add(Some(&measurement.assess(&[value(0, i), value(1, j)])));
        }
    }
    let away = [0, 1].map(|k| f64::hypot(deviations[k], uncertainties[k]));
    let pairs = [
        (0, 2, deviations[0] / away[0]),
        (1, 3, deviations[1] / away[1]),
        (2, 3, r * uncertainties[0] * uncertainties[1] / (away[0] * away[1])),
    ];
    let joint = JointNormal::new(4, &pairs).unwrap();
    let spreads = [deviations[0], deviations[1], away[0], away[1]];
    let limit = |side: f64| {
        let tolerances = [1.0, 1.5, 1.0, 1.5];
        std::array::from_fn::<f64, 4, _>(|k| (side * tolerances[k] - 0.3) / spreads[k])
    };
    let (lower, upper) = (limit(-1.0), limit(1.0));
    let both = joint.probability(&lower, &upper);
    let free = [f64::NEG_INFINITY, f64::INFINITY];
    let only = |k: [usize; 2]| {
        let pick = |limits: [f64; 4], free| {
            std::array::from_fn::<f64, 4, _>(|i| if k.contains(&i) { limits[i] } else { free })
        };
        joint.probability(&pick(lower, free[0]), &pick(upper, free[1]))
    };
    let risk = tally.statement().all.unwrap();
    let (consumer, producer) = (only([0, 1]) - both, only([2, 3]) - both);
    assert!((risk.consumer - consumer).abs() < 1e-3, "{risk:?} {consumer}");
    assert!((risk.producer - producer).abs() < 1e-3, "{risk:?} {producer}");
    assert!((risk.conformance_probability - only([2, 3])).abs() < 2e-4, "{risk:?}");
}

#[test]
fn failed_points_count_as_not_conforming() {
    let measurement = Measurement::new(vec![CASES[0].measured()], &[]).unwrap();
    let mut tally = RiskTally::new(&measurement, Guard::Given(0.0), 1);
    assert_eq!(tally.statement().all, None);
    let good = measurement.assess(&[82.0]);
    for point in [None, Some(&good), None, None] {
        tally.add(point);
    }
    let statement = tally.statement();
    let expected = good.all.probability.unwrap();
    assert!((statement.expected_conforming.unwrap() - expected).abs() < 1e-12);
    let risk = statement.all.unwrap();
    assert!((risk.conformance_probability - expected / 4.0).abs() < 1e-12);
    assert!((risk.consumer - (1.0 - expected) / 4.0).abs() < 1e-12);
    assert!(risk.producer.abs() < 1e-12);
}

#[test]
fn an_unknown_uncertainty_leaves_the_joint_risk_unknown() {
    let unknown = Measured { error: None, ..CASES[2].measured() };
    let criteria = vec![CASES[0].measured(), unknown];
    let measurement = Measurement::new(criteria, &[]).unwrap();
    let mut tally = RiskTally::new(&measurement, Guard::Given(0.5), 1);
    for value in [750.0, 800.0, 900.0] {
        tally.add(Some(&measurement.assess(&[82.0, value])));
    }
    let statement = tally.statement();
    assert_eq!((statement.all, statement.expected_conforming), (None, None));
    assert!(statement.criteria[0].is_some() && statement.criteria[1].is_none());
    assert_eq!(statement.accepted, 2);
    let mut tally = RiskTally::new(&measurement, Guard::Limiting { risk: 0.9 }, 1);
    tally.add(Some(&measurement.assess(&[82.0, 750.0])));
    assert_eq!(tally.statement().accepted, 0);
}

#[test]
fn samples_of_a_design_are_told_apart() {
    let measurement = Measurement::new(vec![CASES[0].measured()], &[]).unwrap();
    let tally = |samples| {
        let mut tally = RiskTally::new(&measurement, Guard::Given(0.0), samples);
        for i in 0..64_000_u32 {
            // Every sample has the same values, up to a little.
            let value = 81.0 + f64::from(i / 16) / 3200.0 + f64::from(i % 16) * 1e-5;
            tally.add(Some(&measurement.assess(&[value])));
        }
        tally.statement().all.unwrap()
    };
    let (one, many) = (tally(1), tally(16));
    assert!((one.consumer - many.consumer).abs() < 1e-12);
    // Nets that agree are no worse than their points as independent ones; their scatter alone would promise too much.
    let [narrow, wide] = [&one, &many].map(|risk| {
        let intervals = risk.intervals.unwrap();
        [intervals.consumer, intervals.not_conforming_given_accepted].map(|[low, high]| high - low)
    });
    assert!((0..2).all(|k| wide[k] > narrow[k]), "{one:?} {many:?}");
}

/// The global risks over a normal population N(84, 0.6) with simple acceptance.
fn risks_of(limits: Limits, uncertainty: Uncertainty) -> [f64; 2] {
    const POINTS: u32 = 20_000;
    let error = Some(uncertainty.law(0.0));
    let measured = Measured { limits, value: None, error };
    let measurement = Measurement::new(vec![measured], &[]).unwrap();
    let mut tally = RiskTally::new(&measurement, Guard::Given(0.0), 1);
    for i in 0..POINTS {
        let score = Normal::standard().inverse_cdf((f64::from(i) + 0.5) / f64::from(POINTS));
        tally.add(Some(&measurement.assess(&[84.0 + 0.6 * score])));
    }
    let risk = tally.statement().all.unwrap();
    [risk.consumer, risk.producer]
}

/// All were integrated with scipy
/// (Gauss and Legendre's rule on both sides of each limit; `norm.cdf`, `t.cdf`, convolutions with a rectangle by 200 nodes).
#[test]
fn risks_of_one_sided_and_uneven_limits_and_of_errors_that_are_not_normal() {
    let normal = Uncertainty::normal(0.25, 1.0);
    let repeated = |mean: f64, repeats: u32, offset: Uncertainty| Uncertainty {
        noise: mean * f64::from(repeats).sqrt(),
        repeats: Some(repeats),
        ..offset
    };
    let none = Uncertainty::normal(0.0, 2.0);
    let uneven = Limits { about: 84.0, minus: 0.5, plus: 1.0 };
    let once = Uncertainty { noise: 0.15, ..Uncertainty::rectangular(0.3) };
    for (limits, uncertainty, expected) in [
        (Limits::at_most(85.0), normal, [0.025_141, 0.010_963]),
        (Limits::at_most(85.0), Uncertainty::rectangular(0.433), [0.026_399, 0.012_111]),
        (Limits::at_most(85.0), repeated(0.25, 5, none), [0.036_609, 0.011_884]),
        (Limits::at_most(85.0), once, [0.022_634, 0.010_663]),
        (Limits::at_least(83.2), repeated(0.25, 3, none), [0.069_752, 0.022_843]),
        (uneven, normal, [0.080_402, 0.047_675]),
        (uneven, repeated(0.2, 5, Uncertainty::rectangular(0.3)), [0.105_481, 0.054_394]),
    ] {
        let risks = risks_of(limits, uncertainty);
        for (risk, expected) in risks.into_iter().zip(expected) {
            assert!((risk - expected).abs() < 2e-5, "{limits:?} {uncertainty:?}: {risks:?}");
        }
    }
}

/// An upper limit with a normal error and an uneven tolerance with a rectangle and a normal part, correlated by a Gaussian
/// copula with -0.7; the populations are N(0.3, 0.8) and N(0.3, 1.1). The expected values are sums over 240 times 360 nodes
/// in numpy, with the joint probability as an integral over the first score.
#[test]
fn joint_risks_of_correlated_errors_of_any_distribution() {
    let rule = crate::normal::GaussLegendre::new(40);
    let nodes = |deviation: f64, ends: &[f64]| {
        let density =
            |x: f64| (-0.5 * ((x - 0.3) / deviation).powi(2)).exp() / deviation / std::f64::consts::TAU.sqrt();
        let mut nodes = Vec::new();
        for piece in ends.windows(2) {
            let width = piece[1] - piece[0];
            nodes.extend(rule.on_unit_interval().map(|[at, weight]| {
                let x = piece[0] + at * width;
                (x, weight * width * density(x))
            }));
        }
        nodes
    };
    let measured =
        |limits, uncertainty: Uncertainty| Measured { limits, value: None, error: Some(uncertainty.law(0.0)) };
    let uneven = Limits { about: 0.0, minus: 1.0, plus: 1.5 };
    let mixed = Uncertainty { noise: 0.3, ..Uncertainty::rectangular(0.9) };
    let criteria = vec![measured(Limits::at_most(1.0), Uncertainty::normal(0.5, 1.0)), measured(uneven, mixed)];
    let measurement = Measurement::new(criteria, &[(0, 1, -0.7)]).unwrap();
    let (mut consumer, mut producer) = (0.0, 0.0);
    for (x, of_x) in nodes(0.8, &[-5.0, -1.5, 1.0, 5.6]) {
        for (y, of_y) in nodes(1.1, &[-6.3, -1.0, 1.5, 6.9]) {
            let all = measurement.assess(&[x, y]).all;
            let probability = all.probability.unwrap();
            if all.margin >= 0.0 {
                consumer += of_x * of_y * (1.0 - probability)
            } else {
                producer += of_x * of_y * probability
            }
        }
    }
    assert!((consumer - 0.153_381_5).abs() < 2e-5, "{consumer}");
    assert!((producer - 0.075_892_4).abs() < 2e-5, "{producer}");
}

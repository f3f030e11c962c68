//! The validation comparison after ASME V&V 20-2009: what the difference of model and measurement says of the model's
//! own error.

use serde::{Deserialize, Serialize};

use crate::{
    measured::Measured,
    uncertainty::{COVERED, Law},
};

/// The comparison for one criterion, in its unit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Comparison {
    /// The model's value S: the mean over the points.
    pub model: f64,
    /// The comparison error E = S - D.
    pub error: f64,
    /// u_num, the standard uncertainty of the numerical solution; none where it was not observed, which does not mean
    /// that it is 0.
    pub u_num: Option<f64>,
    /// Why u_num is not known, or how it was found.
    pub u_num_note: String,
    /// u_input, that of the parameters: the standard deviation over the points.
    pub u_input: f64,
    /// From how many points S and u_input are; 0 in files that do not tell.
    #[serde(default)]
    pub points: u64,
    /// u_D, that of the measured value; none where the study does not state it.
    pub u_d: Option<f64>,
    /// u_val, the root of the sum of the squares of those that are known.
    pub u_val: f64,
    /// Whether all three are known; otherwise u_val is a lower bound.
    pub complete: bool,
    /// The effective degrees of freedom of u_val (Welch and Satterthwaite); none where they are as good as infinite. `coverage` is
    /// larger than Student's factor of these.
    pub freedom: Option<f64>,
    /// E_n = E / sqrt(U_S^2 + U_D^2), with the expanded uncertainties of model and measured value (ISO 13528, 9.7), whose intervals
    /// hold 95.45 % each, whatever k the study states; none where the latter is not stated, or both are 0.
    pub e_n: Option<f64>,
    /// The coverage factor k of the interval: with it 95.45 % of the sum's distribution lie within, as 2 does of a normal number.
    pub coverage: f64,
    /// E - k u_val and E + k u_val, between which the model's error lies.
    pub model_error: [f64; 2],
    /// The largest of the uncertainties: `numerical`, `input` or `measurement`.
    pub dominant: String,
}

/// The numerical uncertainty of one criterion's value, as far as it is known.
#[derive(Clone, Debug)]
pub struct Numerical {
    /// The standard uncertainty, where a refinement showed an order.
    pub standard: Option<f64>,
    /// How it was found, or why it is not known.
    pub note: String,
}

impl Default for Numerical {
    fn default() -> Self {
        Self { standard: None, note: "not observed".to_owned() }
    }
}

impl Comparison {
    /// The comparison with a measured value, given the model's values. None where nothing is measured, or one of its numbers
    /// would be beyond all numbers.
    pub fn new(measured: &Measured, values: Scatter, numerical: Numerical) -> Option<Self> {
        let Scatter { mean, deviation, points } = values;
        let u_d = measured.error.map(|error| error.standard());
        let known = [("numerical", numerical.standard), ("input", Some(deviation)), ("measurement", u_d)];
        // Squares of large numbers would be beyond all numbers.
        let u_val = known.iter().filter_map(|(_, u)| *u).fold(0.0, f64::hypot);
        // Student's factor of the effective degrees of freedom would hold 88 % with two repeats beside a known part; the
        // distribution of the sum itself holds 95 % or more.
        let [scatter, input] = values.laws();
        let of_measured = measured.error.unwrap_or_default();
        let of_solution = numerical.standard.unwrap_or(0.0);
        let rest = of_measured.with_normal(of_solution);
        let freedom = [of_measured, scatter]
            .into_iter()
            .filter_map(|law| law.freedom_within(u_val))
            .map(f64::recip)
            .reduce(|a, b| a + b)
            .map(f64::recip);
        let coverage = match freedom {
            Some(_) => input.half_interval_with(rest, COVERED) / u_val,
            None => 2.0,
        };
        let error = mean - measured.value?;
        let of_model = input.with_normal(of_solution).half_interval(COVERED);
        let e_n = measured
            .error
            .map(|law| error / of_model.hypot(law.half_interval(COVERED)))
            .filter(|ratio| ratio.is_finite());
        let largest = known.iter().max_by(|a, b| {
            let [a, b] = [a.1, b.1].map(|u| u.unwrap_or(0.0));
            a.total_cmp(&b)
        });
        let model_error = [-1.0, 1.0].map(|side| error + side * coverage * u_val);
        [mean, error, deviation, u_val].into_iter().chain(model_error).all(f64::is_finite).then(|| Self {
            model: mean,
            error,
            u_num: numerical.standard,
            u_num_note: numerical.note,
            u_input: deviation,
            points,
            u_d,
            u_val,
            complete: known.iter().all(|(_, u)| u.is_some()),
            freedom,
            e_n,
            coverage,
            model_error,
            dominant: largest.map_or("", |(name, _)| name).to_owned(),
        })
    }
}

/// Settings that are made finer to see the numerical error.
#[derive(Clone, Copy, Debug)]
pub enum Refined {
    /// The communication step, to a half and a quarter.
    Step,
    /// The tolerance of the FMU's solver, to a tenth and a hundredth.
    Tolerance,
}

impl Refined {
    /// The factor from one refinement to the next.
    pub fn ratio(self) -> f64 {
        match self {
            Self::Step => 2.0,
            Self::Tolerance => 10.0,
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Step => "step",
            Self::Tolerance => "tolerance",
        }
    }

    /// The orders that a sound solver may show: with the tolerance the error goes down in proportion, or a little
    /// slower or faster.
    fn orders(self) -> std::ops::RangeInclusive<f64> {
        match self {
            Self::Step => 0.5..=8.0,
            Self::Tolerance => 0.3..=2.0,
        }
    }
}

/// The numerical uncertainty of a value, given the values with a coarse, a middle and a fine setting.
///
/// Where the differences shrink as an order wants it, Richardson's extrapolation tells the error of the coarse setting, and
/// the grid convergence index (Roache 1998) with its factor of safety 1.25 is taken as an expanded uncertainty with
/// k = 1.15 (V&V 20, 2-4.1). Otherwise no order shows, and nothing is stated: a mere difference of two runs is no
/// uncertainty.
pub fn refined([coarse, middle, fine]: [f64; 3], by: Refined) -> Numerical {
    const SAFETY: f64 = 1.25;
    const COVERAGE: f64 = 1.15;
    let (first, second) = (middle - coarse, fine - middle);
    let name = by.name();
    if first == 0.0 && second == 0.0 {
        return Numerical::unknown(&format!("the results do not depend on the {name}"));
    }
    let order = (first / second).ln() / by.ratio().ln();
    if !by.orders().contains(&order) {
        return Numerical::unknown(&format!("no order shows when the {name} is refined"));
    }
    let error = first.abs() / (1.0 - by.ratio().powf(-order));
    Numerical {
        standard: Some(SAFETY * error / COVERAGE),
        note: format!("by refining the {name}, observed order {order:.1}"),
    }
}

impl Numerical {
    fn unknown(why: &str) -> Self {
        Self { standard: None, note: format!("not observable: {why}") }
    }

    /// Two independent parts of it; of one that is not known only the note is kept.
    pub fn and(self, other: Self) -> Self {
        let parts = [self.standard, other.standard];
        let squares: f64 = parts.iter().flatten().map(|u| u * u).sum();
        Self {
            standard: parts.iter().any(Option::is_some).then(|| squares.sqrt()),
            note: format!("{}; {}", self.note, other.note),
        }
    }
}

/// Mean and variance of numbers that come one by one (Welford 1962, Technometrics 4).
#[derive(Clone, Copy, Debug, Default)]
pub struct Spread {
    count: f64,
    mean: f64,
    squares: f64,
    /// Whether all are taken in [`UNIT`]s: their squares would be beyond all numbers otherwise.
    large: bool,
}

/// Larger numbers are taken in [`UNIT`]s.
const LARGE: f64 = 1e150;
/// A power of two, so that no digit changes.
const UNIT: f64 = f64::from_bits((1023 + 600) << 52);

impl Spread {
    /// Takes one more number.
    pub fn add(&mut self, value: f64) {
        if !self.large && value.abs() > LARGE {
            self.large = true;
            self.mean /= UNIT;
            self.squares = self.squares / UNIT / UNIT;
        }
        let value = if self.large { value / UNIT } else { value };
        self.count += 1.0;
        let step = value - self.mean;
        self.mean += step / self.count;
        self.squares += step * (value - self.mean);
    }

    /// Mean and standard deviation, of two numbers or more.
    pub fn result(&self) -> Option<Scatter> {
        let deviation = (self.squares / (self.count - 1.0)).sqrt();
        let unit = if self.large { UNIT } else { 1.0 };
        let [mean, deviation] = [self.mean, deviation].map(|number| unit * number);
        (self.count > 1.0).then_some(Scatter { mean, deviation, points: self.count as u64 })
    }
}

/// The model's values over the points.
#[derive(Clone, Copy, Debug)]
pub struct Scatter {
    /// Their mean.
    pub mean: f64,
    /// Their standard deviation.
    pub deviation: f64,
    /// How many they are, two or more.
    pub points: u64,
}

impl Scatter {
    /// The distribution of the values about their true mean, as far as independent normal ones tell it: Student's with n - 1
    /// degrees of freedom; and that of the value with the true parameters about the mean of the points, which errs, too.
    fn laws(&self) -> [Law; 2] {
        let points = self.points.max(2) as f64;
        let scatter = Law { student: self.deviation, freedom: points - 1.0, ..Law::default() };
        [scatter, scatter.times((1.0 + points.recip()).sqrt())]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::uncertainty::Uncertainty;
    use rand::{RngExt, SeedableRng, rngs::StdRng};
    use rand_distr::StandardNormal;

    fn measured(uncertainty: Option<f64>) -> Measured {
        Measured::within(82.0, 0.6, uncertainty.map(|expanded| Uncertainty::normal(expanded, 2.0).law(82.0)))
    }

    /// So many points that their standard deviation is as good as known.
    fn many(mean: f64, deviation: f64) -> Scatter {
        Scatter { mean, deviation, points: 1_000_000_000 }
    }

    #[test]
    fn the_model_error_lies_about_the_comparison_error() {
        let numerical = Numerical { standard: Some(0.4), note: String::new() };
        let told = Comparison::new(&measured(Some(0.6)), many(81.0, 1.2), numerical).unwrap();
        // 0.4, 1.2 and 0.3 make 1.3.
        assert!((told.u_val - 1.3).abs() < 1e-12 && told.complete);
        assert!((told.model_error[0] + 3.6).abs() < 1e-7 && (told.model_error[1] - 1.6).abs() < 1e-7);
        assert_eq!(told.dominant, "input");
        // U_S is twice the root of 0.16 + 1.44, U_D is 0.6: together 2.6.
        assert!((told.e_n.unwrap() + 1.0 / 2.6).abs() < 1e-7);
        // Nothing but what is known.
        let told = Comparison::new(&measured(Some(0.6)), many(81.0, 0.0), Numerical::default()).unwrap();
        assert_eq!((told.freedom, told.coverage), (None, 2.0));
    }

    /// GUM, G.4.1 and table G.2: three repeats alone have 2 degrees of freedom and k = 4.53; beside an equal normal part 8. The
    /// sum of a normal number and one of Student's with 2 degrees of freedom has 95.45 % within 4.84 (scipy, convolution).
    #[test]
    fn few_repeats_have_few_degrees_of_freedom() {
        let repeated = Uncertainty { noise: 3.0_f64.sqrt(), repeats: Some(3), ..Uncertainty::normal(0.0, 2.0) };
        let measured = Measured::within(82.0, 0.6, Some(repeated.law(82.0)));
        for (input, freedom, half) in [(0.0, 2.0, 4.5266), (1.0, 8.0, SUM_OF_BOTH)] {
            let told = Comparison::new(&measured, many(81.0, input), Numerical::default()).unwrap();
            assert!((told.freedom.unwrap() - freedom).abs() < 1e-6, "{told:?}");
            assert!((told.coverage * told.u_val / half - 1.0).abs() < 1e-4, "{told:?}");
            assert!((told.model_error[1] + 1.0 - told.coverage * told.u_val).abs() < 1e-12);
        }
    }
    const SUM_OF_BOTH: f64 = 4.842_708;

    /// Of 50 intervals that hold with 95 %, 41 or more hold with a probability of 99.9 %.
    #[test]
    fn the_interval_of_few_repeats_holds_in_some_studies() {
        intervals_of_few_repeats_hold(50, 41, &[2]);
    }

    #[test]
    #[ignore = "long: run by scripts/test --long"]
    fn the_interval_of_few_repeats_holds() {
        intervals_of_few_repeats_hold(1000, 930, &[2, 3, 5, 10]);
    }

    /// E +- U of so many repeats, beside a known part of up to the same size, of so many measurements each.
    fn intervals_of_few_repeats_hold(studies: u32, least: usize, repeats: &[u32]) {
        let mut random = StdRng::seed_from_u64(17);
        let mut normal = || random.sample::<f64, _>(StandardNormal);
        for &repeats in repeats {
            for known in [0.0, 0.4, 1.0] {
                let held = (0..studies).filter(|_| {
                    let root = f64::from(repeats).sqrt();
                    let readings: Vec<f64> = (0..repeats).map(|_| root * normal()).collect();
                    let mean = readings.iter().sum::<f64>() / f64::from(repeats);
                    let squares: f64 = readings.iter().map(|x| (x - mean).powi(2)).sum();
                    let noise = (squares / f64::from(repeats - 1)).sqrt();
                    let stated = Uncertainty { noise, repeats: Some(repeats), ..Uncertainty::normal(2.0 * known, 2.0) };
                    let measured = Measured::within(mean + known * normal(), 0.6, Some(stated.law(0.0)));
                    let told = Comparison::new(&measured, many(0.0, 0.0), Numerical::default()).unwrap();
                    told.model_error[0] <= 0.0 && 0.0 <= told.model_error[1]
                });
                let held = held.count();
                println!("mean of {repeats} beside a known part of {known}: {held} of {studies} hold");
                assert!(held >= least, "{repeats} {known}: {held}");
            }
        }
    }

    /// Of n points alone Student's factor with n - 1 degrees of freedom, wider by the error of the mean: `stats.t.ppf` of scipy.
    /// Beside the mean of as few repeats Behrens and Fisher's interval: `optimize.brentq` of the mean of `stats.t.cdf`
    /// over Student's numbers.
    #[test]
    fn few_points_have_few_degrees_of_freedom() {
        for (points, repeats, freedom, half) in FEW {
            let measured = match repeats {
                0 => measured(None),
                _ => {
                    let noise = f64::from(repeats).sqrt();
                    let repeated = Uncertainty { noise, repeats: Some(repeats), ..Uncertainty::normal(0.0, 2.0) };
                    Measured::within(82.0, 0.6, Some(repeated.law(82.0)))
                }
            };
            let values = Scatter { mean: 81.0, deviation: 1.0, points };
            let told = Comparison::new(&measured, values, Numerical::default()).unwrap();
            assert!((told.freedom.unwrap() - freedom).abs() < 1e-9, "{told:?}");
            assert!((told.coverage * told.u_val / half - 1.0).abs() < 1e-4, "{told:?}");
        }
    }
    /// Points, repeats of the measured value, effective degrees of freedom, half of the interval.
    const FEW: [(u64, u32, f64, f64); 6] = [
        (2, 0, 1.0, 17.106906),
        (5, 0, 4.0, 3.143171),
        (16, 0, 15.0, 2.248291),
        (5, 2, 3.2, 14.207293),
        (10, 3, 6.545454545454545, 5.037070),
        (64, 3, 7.753846153846155, 4.861884),
    ];

    /// Of 50 intervals that hold with 95 %, 41 or more hold with a probability of 99.9 %.
    #[test]
    fn the_interval_of_few_points_holds_in_some_studies() {
        intervals_of_few_points_hold(50, 41, &[5]);
    }

    #[test]
    #[ignore = "long: run by scripts/test --long"]
    fn the_interval_of_few_points_holds() {
        intervals_of_few_points_hold(1000, 930, &[5, 10, 16, 64]);
    }

    /// E +- k u_val of few points, of which each is as probable as the true parameters, of so many studies each: alone,
    /// beside a known uncertainty as large, and beside the mean of three repeats as uncertain.
    fn intervals_of_few_points_hold(studies: u32, least: usize, points: &[u32]) {
        let mut random = StdRng::seed_from_u64(20);
        let mut normal = || random.sample::<f64, _>(StandardNormal);
        let mut scatter = |count: u32, size: f64| {
            let mut spread = Spread::default();
            (0..count).for_each(|_| spread.add(size * normal()));
            (spread.result(), normal())
        };
        for &points in points {
            for (known, repeats) in [(0.0, None), (1.0, None), (0.0, Some(3))] {
                let held = (0..studies).filter(|_| {
                    let (values, true_value) = scatter(points, 1.0);
                    let (mean, noise) = match repeats {
                        Some(repeats) => {
                            let readings = scatter(repeats, f64::from(repeats).sqrt()).0.unwrap();
                            (readings.mean, readings.deviation)
                        }
                        None => (known * scatter(2, 1.0).1, 0.0),
                    };
                    let stated = Uncertainty { noise, repeats, ..Uncertainty::normal(2.0 * known, 2.0) };
                    let measured = Measured::within(true_value + mean, 0.6, Some(stated.law(0.0)));
                    let told = Comparison::new(&measured, values.unwrap(), Numerical::default()).unwrap();
                    told.model_error[0] <= 0.0 && 0.0 <= told.model_error[1]
                });
                let held = held.count();
                println!(
                    "{points} points beside a known part of {known}, {repeats:?} repeats: {held} of {studies} hold"
                );
                assert!(held >= least, "{points} {known} {repeats:?}: {held}");
            }
        }
    }

    #[test]
    fn what_is_not_known_is_not_0() {
        let told = Comparison::new(&measured(None), many(81.0, 1.2), Numerical::default());
        let told = told.unwrap();
        assert_eq!((told.u_num, told.u_d, told.complete), (None, None, false));
        assert_eq!((told.u_num_note.as_str(), told.e_n), ("not observed", None));
        assert_eq!(told.u_val, 1.2);
    }

    /// Euler's explicit method on y' = -y has the order 1.
    #[test]
    fn the_error_of_a_known_order_is_found() {
        let euler = |steps: i32| (1.0 - 1.0 / f64::from(steps)).powi(steps);
        let told = refined([euler(20), euler(40), euler(80)], Refined::Step);
        let error = (euler(20) - (-1.0_f64).exp()).abs();
        let stated = told.standard.unwrap() * 1.15 / 1.25;
        assert!((stated / error - 1.0).abs() < 0.03, "{stated} {error}");
        assert!(told.note.contains("order 1.0"), "{}", told.note);
    }

    #[test]
    fn without_an_order_nothing_is_stated() {
        for (values, why) in [
            ([1.0, 1.0, 1.0], "do not depend"),
            ([1.0, 1.1, 1.0], "no order"),
            ([1.0, 1.1, 1.3], "no order"),
            ([1.0, 1.0, 1.1], "no order"),
        ] {
            let told = refined(values, Refined::Step);
            assert_eq!(told.standard, None);
            assert!(told.note.contains(why), "{}", told.note);
        }
    }

    #[test]
    fn step_and_tolerance_come_together() {
        let of_tolerance = |tol: f64| 5.0 + 3.0 * tol;
        let told = refined([1e-3, 1e-4, 1e-5].map(of_tolerance), Refined::Tolerance);
        let stated = told.standard.unwrap();
        assert!((stated / (3e-3 * 1.25 / 1.15) - 1.0).abs() < 1e-6, "{told:?}");
        let step = Numerical { standard: Some(stated), note: "a".to_owned() };
        let both = told.clone().and(step).standard.unwrap();
        assert!((both / stated - 2.0_f64.sqrt()).abs() < 1e-12);
        let ignored = refined([1.0; 3], Refined::Step).and(told);
        assert_eq!(ignored.standard, Some(stated));
        assert!(
            ignored.note.starts_with("not observable: the results do not depend on the step; by"),
            "{}",
            ignored.note
        );
        // A tolerance that changes the results by chance shows no order.
        let chance = refined([1.0, 1.1, 1.05], Refined::Tolerance);
        assert_eq!(chance.standard, None);
    }

    #[test]
    fn large_numbers_have_a_mean_and_a_spread() {
        let of = |values: &[f64]| {
            let mut spread = Spread::default();
            values.iter().for_each(|value| spread.add(*value));
            spread.result().unwrap()
        };
        for unit in [1.0, 1e-300, 1e160, 1e300] {
            let Scatter { mean, deviation, .. } = of(&[unit, 2.0 * unit, 6.0 * unit]);
            assert!((mean / unit - 3.0).abs() < 1e-12, "{unit}: {mean}");
            let expected = 7.0_f64.sqrt();
            assert!(unit < 1.0 || (deviation / unit / expected - 1.0).abs() < 1e-12, "{unit}: {deviation}");
        }
        let Scatter { mean, deviation, points } = of(&[0.86, 1e160]);
        assert!((mean / 5e159 - 1.0).abs() < 1e-12 && (deviation / 5e159 - 2.0_f64.sqrt()).abs() < 1e148);
        assert_eq!(points, 2);
        // Beyond all numbers, there is no comparison.
        let spread = of(&[f64::MAX, -f64::MAX]);
        assert_eq!(Comparison::new(&measured(None), spread, Numerical::default()), None);
    }
}

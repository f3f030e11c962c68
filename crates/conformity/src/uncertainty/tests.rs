use super::*;

fn close(got: f64, expected: f64, within: f64) {
    assert!((got - expected).abs() < within, "{got}, not {expected}");
}

fn law(normal: f64, student: f64, freedom: f64, half_width: f64) -> Law {
    Law { normal, student, freedom, half_width, expanded: 0.0 }
}

/// Against scipy: `norm.cdf` and `t.cdf`, or their convolution by `integrate.quad`, over the rectangle by Gauss and
/// Legendre's rule with 80 nodes.
#[test]
fn normal_student_and_rectangular_parts_are_convolved() {
    const PLACES: [f64; 5] = [-1.3, -0.4, 0.1, 0.45, 0.9];
    #[rustfmt::skip]
    let cases = [
        (law(0.2, 0.0, 0.0, 0.433), [3.550_037_643_719e-7, 0.112_438_152_198_51, 0.611_150_507_416_45, 0.917_348_373_332_36, 0.999_237_151_705_30]),
        (law(0.0, 0.2, 4.0, 0.433), [0.001_995_015_317_325, 0.133_111_619_063_56, 0.603_688_954_029_62, 0.896_251_011_288_94, 0.990_446_944_424_16]),
        (law(0.0, 0.2, 1.0, 0.433), [0.050_433_406_187_937, 0.199_138_120_622_54, 0.583_247_320_158_27, 0.826_251_302_062_17, 0.924_754_965_843_57]),
        (law(0.3, 0.4, 1.0, 0.0), [0.099_995_401_744_313, 0.287_368_915_014_787, 0.558_595_369_652_358, 0.733_260_697_276_446, 0.853_776_184_616_711]),
        (law(1.0, 0.1, 9.0, 0.0), [0.098_224_228_460_916, 0.345_513_407_101_271, 0.539_576_006_231_372, 0.672_614_666_856_757, 0.814_415_301_389_303]),
        (law(0.3, 0.4, 2.0, 0.5), [0.054_273_683_948_760, 0.282_073_472_258_720, 0.558_010_707_952_719, 0.740_996_513_172_799, 0.888_515_361_235_918]),
        (law(0.5, 0.1, 2.0, 0.1), [0.011_050_046_227_173, 0.228_740_645_419_238, 0.573_879_561_626_799, 0.798_192_082_837_879, 0.950_033_022_038_171]),
        (law(0.01, 0.0, 0.0, 0.433), [0.0, 0.038_107_705_187_866, 0.615_473_441_108_55, 0.999_788_824_587_91, 1.0]),
    ];
    for (law, expected) in cases {
        for (place, expected) in PLACES.into_iter().zip(expected) {
            close(law.cdf(place), expected, 1e-11);
        }
    }
    // Nearly a rectangle alone, and nearly none.
    close(law(1e-9, 0.0, 0.0, 1.0).cdf(0.3), 0.65, 1e-12);
    close(law(1.0, 0.0, 0.0, 1e-9).cdf(0.3), normal::cdf(0.3), 1e-12);
    assert_eq!(law(0.0, 0.0, 0.0, 1.0).cdf(-1.5), 0.0);
    for law in [law(1.0, 0.0, 0.0, 1.0), law(0.0, 0.0, 0.0, 1.0), law(0.0, 1.0, 3.0, 0.0)] {
        assert_eq!([law.cdf(f64::NEG_INFINITY), law.cdf(f64::INFINITY)], [0.0, 1.0]);
    }
}

/// Student's distribution alone, with any number of degrees of freedom and far out, against that of statrs.
#[test]
fn a_mixture_of_normal_errors_is_students() {
    use statrs::distribution::StudentsT;
    for freedom in [1.0, 2.0, 3.0, 6.0, 10.0, 17.0, 40.0, 200.0, 3000.0] {
        let student = StudentsT::new(0.0, 1.0, freedom).unwrap();
        let law = law(0.0, 0.5, freedom, 0.0);
        for place in [0.0, 0.3, 1.0, 2.5, 6.0, 40.0, 1e6] {
            close(law.cdf(-0.5 * place), student.cdf(-place), 2e-12);
        }
    }
}

/// Half of the central 95 %: `t.ppf(0.975, 4)`, and roots of the convolutions by `optimize.brentq`.
#[test]
fn intervals_hold_95_percent_of_the_stated_distribution() {
    for (law, expected) in [
        (law(0.0, 1.0, 4.0, 0.0), 2.776_445_105_2),
        (law(0.0, 0.2, 4.0, 0.433), 0.709_644_557_27),
        (law(0.2, 0.0, 0.0, 0.433), 0.604_752_840_98),
        (law(0.3, 0.4, 1.0, 0.0), 5.100_141_408_4),
        (law(0.3, 0.4, 2.0, 0.5), 1.861_500_270_4),
    ] {
        close(law.half_interval(0.95), expected, 1e-9);
    }
    close(Uncertainty::rectangular(2.0).law(5.0).expanded, 2.0 * COVERED, 1e-11);
}

#[test]
fn an_expanded_uncertainty_alone_is_what_is_stated() {
    for (expanded, coverage) in [(0.3, 2.0), (0.1, 3.0), (0.7, 1.96)] {
        let law = Uncertainty::normal(expanded, coverage).law(82.0);
        assert_eq!((law.expanded, law.standard()), (expanded, expanded / coverage));
        assert_eq!(law.score(0.11), 0.11 / (expanded / coverage));
    }
}

/// Parts that can be added by hand; the factor is that of a table of Student's distribution.
#[test]
fn the_mean_of_repeats_has_students_distribution() {
    let with =
        |expanded: f64| Uncertainty { gain: 0.001, noise: 3.0, repeats: Some(9), ..Uncertainty::normal(expanded, 2.0) };
    // Of the mean 3 / sqrt(9) = 1; offset 1.5 and gain 2: combined sqrt(1 + 2.25 + 4).
    let uncertainty = with(3.0);
    close(uncertainty.shared(2000.0), 2.5, 1e-12);
    close(uncertainty.independent(), 1.0, 1e-12);
    close(uncertainty.standard(2000.0), 7.25_f64.sqrt(), 1e-12);
    let law = uncertainty.law(2000.0);
    assert_eq!((law.normal, law.student, law.freedom), (2.5, 1.0, 8.0));
    close(law.standard(), 7.25_f64.sqrt(), 1e-12);
    // The repeats alone: Student's factor for 8 degrees of freedom, `t.ppf(norm.cdf(2), 8)` of scipy.
    close(with(0.0).law(0.0).expanded, 2.366_415_784, 1e-8);
    // One reading with known noise is normal.
    let once = Uncertainty { repeats: None, ..with(3.0) };
    close(once.law(0.0).expanded, 2.0 * 11.25_f64.sqrt(), 1e-12);
    assert!(once.law(0.0).is_normal());
}

/// Of 30 intervals that hold with 95 %, 23 or more hold with a probability of 99.99 %.
#[test]
fn some_stated_intervals_hold_the_true_value() {
    stated_intervals_hold(30, 0.76);
}

#[test]
#[ignore = "long: run by scripts/test --long"]
fn stated_intervals_hold_the_true_value() {
    stated_intervals_hold(1000, 0.93);
}

/// Simulated measurements, so many a case, whose standard deviation is estimated from their own repeats: the measured value
/// with its expanded uncertainty holds the true value in this share of them or more.
fn stated_intervals_hold(studies: u32, least: f64) {
    use rand::{RngExt, SeedableRng, rngs::StdRng};
    use rand_distr::{Distribution as _, StandardNormal};
    let mut random = StdRng::seed_from_u64(38);
    let (truth, noise) = (50.0, 0.3);
    for repeats in [None, Some(2), Some(3), Some(5), Some(10)] {
        for (offset, gain) in [(0.0, 0.0), (0.1, 0.0), (0.1, 0.004), (0.6, 0.004)] {
            for rectangular in [false, true] {
                let held = (0..studies).filter(|_| {
                    let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
                    let own_gain = gain * normal();
                    let own_offset = 0.5 * offset * normal();
                    let readings: Vec<f64> = (0..repeats.unwrap_or(1)).map(|_| noise * normal()).collect();
                    let own_offset = if rectangular { random.random_range(-1.0..1.0) * offset } else { own_offset };
                    let n = readings.len() as f64;
                    let mean = readings.iter().sum::<f64>() / n;
                    let squares: f64 = readings.iter().map(|x| (x - mean).powi(2)).sum();
                    let value = truth + own_offset + own_gain * truth + mean;
                    let uncertainty = Uncertainty {
                        gain,
                        noise: match repeats {
                            Some(_) => (squares / (n - 1.0)).sqrt(),
                            None => noise,
                        },
                        repeats,
                        ..if rectangular { Uncertainty::rectangular(offset) } else { Uncertainty::normal(offset, 2.0) }
                    };
                    (value - truth).abs() <= uncertainty.law(value).expanded
                });
                let held = f64::from(u32::try_from(held.count()).unwrap()) / f64::from(studies);
                assert!(held >= least, "{repeats:?} {offset} {rectangular} {gain}: {held}");
            }
        }
    }
}

#[test]
fn the_density_is_the_derivative_of_the_distribution_function() {
    let all = [
        law(0.2, 0.0, 0.0, 0.433),
        law(0.0, 0.2, 4.0, 0.433),
        law(0.3, 0.4, 2.0, 0.5),
        law(0.0, 0.4, 2.0, 0.0),
        law(0.3, 0.0, 0.0, 0.0),
        law(0.3, 0.0, 0.0, 1e-8),
    ];
    for law in all {
        for place in [-1.3, -0.4, 0.1, 0.9] {
            let slope = (law.cdf(place + 1e-4) - law.cdf(place - 1e-4)) / 2e-4;
            close(law.ln_density(place).exp() / slope, 1.0, 1e-5);
        }
    }
    close(law(0.0, 0.0, 0.0, 2.0).ln_density(1.9), -(4.0_f64.ln()), 1e-12);
    // Where the density is no number any more: the tail of a normal error beyond the end of the rectangle.
    let far = law(0.01, 0.0, 0.0, 0.433).ln_density(10.433);
    let expected = -0.5e6 - 1e3_f64.ln() - 0.5 * TAU.ln() - 0.866_f64.ln();
    close(far, expected, 1e-5);
}

/// `t.ppf(0.975, 2) / norm.ppf(0.975)` of scipy.
#[test]
fn a_normal_error_in_place_of_students_has_an_interval_as_wide() {
    let uncertainty = Uncertainty { noise: 0.1, repeats: Some(3), ..Uncertainty::normal(0.0, 2.0) };
    let law = uncertainty.law(5.0);
    close(law.as_normal() / law.standard(), 2.195_271, 1e-6);
    let known = Uncertainty::rectangular(0.3).law(5.0);
    assert_eq!(known.as_normal(), known.standard());
}

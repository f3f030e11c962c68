//! Doubts about a verdict of a study that can be judged all the same: a sentence each, with the remedy.

use std::f64::consts::{PI, TAU};

use fmu_import::units::{Conversion, known};
use result_document::format::significant;
use study::{
    concern::{Code, Concern},
    judge::Criterion,
};

/// Fewer points may miss a measured value by chance.
pub const FEWEST: u64 = 10;

/// Factors between units that are often mistaken for each other, and offsets, for values whose unit nobody states, with the
/// words for this way and for the way back.
const UNITS: [(f64, f64, [&str; 2]); 9] = [
    (1.0, 273.15, ["degC and K", "K and degC"]),
    (1e6, 0.0, ["MPa and Pa, or um and m", "Pa and MPa, or m and um"]),
    (1e5, 0.0, ["bar and Pa", "Pa and bar"]),
    (
        1e3,
        0.0,
        [
            "a unit and a thousandth of it, such as m and mm, or kW and W",
            "a unit and a thousand of it, such as mm and m, or W and kW",
        ],
    ),
    (1e2, 0.0, ["a share and per cent, or m and cm", "per cent and a share, or cm and m"]),
    (TAU / 60.0, 0.0, ["rpm and rad/s", "rad/s and rpm"]),
    (60.0, 0.0, ["Hz and rpm", "rpm and Hz"]),
    (3.6, 0.0, ["m/s and km/h", "km/h and m/s"]),
    (PI / 180.0, 0.0, ["deg and rad", "rad and deg"]),
];

/// Warns of a measured value that lies beyond the values of all points, given the least and the greatest of these. Values
/// within the expanded uncertainty do not contradict it. A few points may miss it by chance, but not by a unit.
pub fn out_of_reach(criterion: &Criterion, [low, high]: [f64; 2], points: u64) -> Option<Concern> {
    // Equal curves are rare, and no unit explains that.
    if criterion.metric.is_some() {
        return None;
    }
    let measured = criterion.measured();
    let nominal = measured.value?;
    // Less than a hundredth of the tolerance is rounding, and no reason to doubt.
    let uncertainty = measured.error.map_or(0.0, |error| error.expanded);
    let room = uncertainty.max(0.01 * criterion.room());
    if low > high || (low - room..=high + room).contains(&nominal) {
        return None;
    }
    let unit = criterion.unit_behind();
    let mistaken = mistaken_unit(criterion.unit.as_deref(), nominal, criterion.room(), [low, high]);
    let (hint, remedy) = match mistaken {
        Some(units) => (
            format!("; the values would fit if {units} were mixed up"),
            "Check the `unit` of each criterion that no point reaches.",
        ),
        None if points < FEWEST => return None,
        None => (String::new(), "Find out what the model misses, or whether the distributions leave something out."),
    };
    let text = format!(
        "{}: no point reaches the measured value {nominal}{unit}; the points lie between {} and {}{unit}{hint}",
        criterion.name,
        significant(low, 5),
        significant(high, 5)
    );
    Some(Concern::new(Code::OutOfReach, text).remedied(remedy))
}

/// Whether equal values can hardly come from two points. Rounded or discrete ones can: one of them has six digits at least.
pub fn is_telling(values: &[f64]) -> bool {
    const DIGITS: usize = 6;
    let digits = |value: &f64| {
        let text = format!("{value:e}");
        let mantissa = text.split('e').next().unwrap_or_default();
        mantissa.chars().filter(char::is_ascii_digit).count()
    };
    values.iter().any(|value| digits(value) >= DIGITS)
}

/// Warns of rows of a table that repeat earlier ones: each counts as an independent point. A few rows may be equal by
/// chance.
pub fn repeated(repeated: u64, points: u64) -> Option<Concern> {
    const FEW: u64 = 10;
    (repeated > 0 && repeated >= points / FEW).then(|| {
        let text = format!(
            "{repeated} of {points} rows have the same values of all criteria as an earlier one, to the last digit, and each \
             of them counts as an independent point"
        );
        let remedy = "Remove the copies of rows that were written more than once.";
        Concern::new(Code::RepeatedRows, text).remedied(remedy)
    })
}

/// Warns of a criterion whose value is the same at all points, given the least and the greatest, or nearly so for its tolerance:
/// it only says again what one run says.
pub fn unmoved(criterion: &Criterion, [low, high]: [f64; 2], points: u64) -> Option<Concern> {
    const ROUNDING: f64 = 1e-12;
    /// A smaller part of the tolerance is as good as nothing.
    const LITTLE: f64 = 0.01;
    let same = high - low <= ROUNDING * low.abs().max(high.abs());
    /// A tolerance of a smaller part of the measured value is none that nobody means.
    const MUCH: f64 = 0.1;
    let measured =
        criterion.measured().value.filter(|_| criterion.metric.is_none() && !criterion.limits.is_one_sided());
    let is_coarse = measured.is_some_and(|value| criterion.room() > MUCH * value.abs());
    let accepts_all = criterion.accepts(low) && criterion.accepts(high);
    let is_wide = is_coarse && accepts_all && high - low <= LITTLE * criterion.room();
    if points < FEWEST || low > high || !(same || is_wide) {
        return None;
    }
    let unit = criterion.unit_behind();
    if !same {
        let text = format!(
            "{}: the values of all {points} points lie within {}{unit}, less than a hundredth of the tolerance, which can refuse none",
            criterion.name,
            significant(high - low, 5)
        );
        let remedy = "Check each `tolerance` that is so wide, and the ranges of the parameters.";
        return Some(Concern::new(Code::WideTolerance, text).remedied(remedy));
    }
    let text = format!(
        "{}: the value is {}{unit} at all {points} points, so it does not depend on the parameters that vary",
        criterion.name,
        significant(low, 5)
    );
    let remedy =
        "Check the `variable` of each criterion that does not move, vary a parameter that it depends on, or remove it.";
    Some(Concern::new(Code::Unmoved, text).remedied(remedy))
}

/// What a unit may be mistaken for: another one of its kind, or of an unknown kind a thousandth or a thousand of it.
pub fn confusions(unit: Option<&str>) -> Vec<(Conversion, String)> {
    let alike = unit.map(known::alike).unwrap_or_default();
    let of_kind = alike.iter().filter_map(|other| {
        let unit = unit.unwrap_or_default();
        let words = |a, b| format!("{} and {}", in_words(a), in_words(b));
        let way = known::between(other, unit)?;
        Some((way, [words(other, unit), words(unit, other)]))
    });
    let listed = UNITS.iter().filter(|(factor, ..)| match unit {
        None => true,
        Some(_) => alike.is_empty() && *factor == 1e3,
    });
    let listed = listed.map(|&(factor, offset, words)| {
        let way = Conversion { factor, offset };
        (way, words.map(str::to_owned))
    });
    let both = |(way, [there, back]): (Conversion, [String; 2])| [(way, there), (way.inverse(), back)];
    of_kind.chain(listed).flat_map(both).collect()
}

fn in_words(unit: &str) -> &str {
    match unit {
        "1" | "-" => "a share",
        "%" => "per cent",
        other => other,
    }
}

/// The units whose confusion would explain the distance, if any do.
fn mistaken_unit(unit: Option<&str>, nominal: f64, tolerance: f64, [low, high]: [f64; 2]) -> Option<String> {
    let outside = |value: f64| (low - value).max(value - high).max(0.0);
    // The model need not be right to tell by its order of magnitude which unit its numbers have.
    let room = |value: f64, factor: f64, offset: f64| {
        let width = (factor * tolerance).max(high - low);
        if offset == 0.0 { width.max(0.3 * value.abs()) } else { 3.0 * width.max(10.0) }
    };
    let far = outside(nominal);
    let rest = |(way, units): (Conversion, String)| {
        let value = way.value(nominal);
        let rest = outside(value);
        let room = room(value, way.factor, way.offset);
        let fits = rest <= room && rest < 0.2 * far;
        fits.then(|| (rest / room, units))
    };
    let all = confusions(unit).into_iter().filter_map(rest);
    let best = all.min_by(|a, b| a.0.total_cmp(&b.0));
    best.map(|(_, units)| units)
}

#[cfg(test)]
mod tests {
    use super::*;
    use sampling::statistics::Statistic;

    fn criterion(nominal: f64, tolerance: f64) -> Criterion {
        Criterion {
            name: "T".into(),
            variable: "t".into(),
            statistic: Statistic::Final,
            limits: conformity::measured::Limits::within(nominal, tolerance),
            stated_tolerance: tolerance.to_string(),
            ..Criterion::default()
        }
    }

    #[test]
    fn a_measured_value_beyond_all_points_is_warned_of() {
        let t = criterion(82.0, 0.6);
        assert_eq!(out_of_reach(&t, [81.0, 83.0], 100), None);
        assert_eq!(out_of_reach(&t, [80.0, 81.5], 9), None);
        let far = out_of_reach(&t, [80.0, 81.5], 10).unwrap().to_string();
        assert!(far.starts_with("T: no point reaches the measured value 82; the points lie between 80 and 81.5"));
        assert!(far.contains(". Find out"), "{far}");
        assert_eq!(out_of_reach(&t, [f64::INFINITY, f64::NEG_INFINITY], 10), None);
    }

    /// VIM 2.47: values within the expanded uncertainty are compatible.
    #[test]
    fn values_within_the_uncertainty_contradict_nothing() {
        let sure = criterion(0.0, 1.0);
        let t = Criterion { uncertainty: Some(conformity::uncertainty::Uncertainty::normal(0.5, 2.0)), ..sure.clone() };
        assert_eq!(out_of_reach(&t, [0.017, 0.084], 200), None);
        assert!(out_of_reach(&sure, [0.017, 0.084], 200).is_some());
        assert!(out_of_reach(&t, [0.51, 0.7], 200).is_some());
    }

    #[test]
    fn rounded_and_discrete_values_may_repeat() {
        for values in [&[0.25, 1.0][..], &[-373.15], &[1e-9, 0.0], &[]] {
            assert!(!is_telling(values), "{values:?}");
        }
        assert!(is_telling(&[1.0, 0.250_001]));
        assert!(is_telling(&[-1.234_56e-7]));
    }

    #[test]
    fn rows_that_repeat_others_are_named() {
        assert_eq!(repeated(0, 5), None);
        assert_eq!(repeated(9, 100), None);
        let warning = repeated(999, 1000).unwrap().text;
        assert!(warning.starts_with("999 of 1000 rows have the same values"));
        assert!(repeated(1, 3).is_some());
    }

    #[test]
    fn a_value_that_is_the_same_at_all_points_is_warned_of() {
        let t = criterion(82.0, 0.6);
        let warning = unmoved(&t, [81.8, 81.8], 10).unwrap().text;
        assert!(warning.starts_with("T: the value is 81.8 at all 10 points"));
        assert!(unmoved(&t, [0.0, 0.0], 10).is_some());
        assert_eq!(unmoved(&t, [81.8, 81.8], 9), None);
        // Of a tolerance of half the value the points try less than a hundredth; a steady value with a sound one is none of these.
        let wide = unmoved(&criterion(82.0, 40.0), [81.8, 82.1], 10).unwrap();
        assert_eq!(wide.code, Code::WideTolerance);
        for (tolerance, reached) in [(40.0, [81.8, 82.3]), (40.0, [30.0, 30.1]), (0.6, [81.8, 81.801])] {
            assert_eq!(unmoved(&criterion(82.0, tolerance), reached, 10), None);
        }
        assert_eq!(unmoved(&t, [81.8, 81.8 + 1e-9], 10), None);
        assert_eq!(unmoved(&t, [f64::INFINITY, f64::NEG_INFINITY], 10), None);
    }

    /// Every small factor leads near zero.
    #[test]
    fn zero_has_no_mistaken_unit() {
        for reached in [[0.0, 0.0], [2e-16, 5e-16]] {
            let warning = out_of_reach(&criterion(1.0, 0.5), reached, 50).unwrap();
            let remedy = warning.remedy.unwrap();
            assert!(remedy.starts_with("Find out what the model"), "{remedy}");
        }
    }

    #[test]
    fn a_mistaken_unit_is_named() {
        for (nominal, tolerance, reached, units) in [
            (82.0, 0.6, [354.0, 356.0], "degC and K"),
            (355.15, 0.6, [81.0, 83.0], "K and degC"),
            (12.0, 1.0, [1.1e7, 1.3e7], "MPa and Pa"),
            (300.0, 5.0, [31.0, 32.0], "rpm and rad/s"),
            (0.02, 0.001, [19.0, 20.5], "such as m and mm"),
            (36.0, 0.4, [9.9, 10.1], "km/h and m/s"),
        ] {
            for points in [3, 50] {
                let warning = out_of_reach(&criterion(nominal, tolerance), reached, points).unwrap().text;
                assert!(warning.contains(units), "{nominal}: {warning}");
            }
        }
    }

    /// A length is no angular velocity, and a share no length.
    #[test]
    fn units_of_another_kind_are_not_named() {
        for (unit, nominal, reached, units) in [
            ("mm", 52.0, [490.0, 550.0], "if cm and mm were"),
            ("bar", 12.0, [115.0, 125.0], "if MPa and bar were"),
            ("K", 355.15, [81.0, 83.0], "if K and degC were"),
            ("-", 5.0, [0.049, 0.052], "if per cent and a share were"),
            ("N", 5.0, [48.0, 52.0], "Find out"),
            ("J", 300.0, [31.0, 32.0], "Find out"),
            ("J", 300.0, [0.29, 0.31], "if N.mm and J were"),
        ] {
            let criterion = Criterion { unit: Some(unit.into()), ..criterion(nominal, 0.02 * nominal) };
            let warning = out_of_reach(&criterion, reached, 50).unwrap().to_string();
            assert!(warning.contains(units), "{unit}: {warning}");
        }
    }
}

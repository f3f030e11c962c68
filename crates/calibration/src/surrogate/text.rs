//! The surrogates in words.

use std::fmt::Write;

use super::super::digits::Digits;
use super::super::failures::words;
use super::outcome::SurrogateOutcome;

/// An error counted that is larger than this part of the accuracy widens intervals by 12 %.
const LARGE: f64 = 0.5;

/// Sums of squares of surrogates and model that differ by more leave the optimum's place in doubt.
const DIFFERENT: f64 = 1.0;

/// A summary for people.
pub fn summary(told: &SurrogateOutcome) -> String {
    let mut text = format!(
        "\nsurrogate: polynomials from {} runs a case ({} failed) in {} rounds stand in for the model; the last ones are of {}\n",
        told.runs,
        told.failed,
        told.rounds,
        words(&told.within)
    );
    let all = told.errors.iter().flatten();
    if let Some(worst) = all.max_by(|a, b| a.part().total_cmp(&b.part())) {
        let held_out = worst.held_out.map_or_else(String::new, |own| {
            format!(
                ", at {} fresh runs in the posterior {}",
                told.checked,
                Digits(own, 2)
            )
        });
        let _ = writeln!(
            text,
            "  its error is largest in {}: leave-one-out {}{held_out}; counted as {} beside the accuracy of {} ({:.0} %)",
            worst.quantity,
            Digits(worst.leave_one_out, 2),
            Digits(worst.counted, 2),
            Digits(worst.accuracy, 2),
            100.0 * worst.part()
        );
    }
    if told.largest > LARGE {
        let _ = writeln!(
            text,
            "  so intervals are wider than the data's own, and optima close to each other may look like one: more runs \
             (--surrogate {}) tell more",
            2 * told.runs
        );
    }
    if told.checked == 0 {
        text += "  no fresh run could be compared, so only the leave-one-out error is known\n";
    }
    if told.check_failed > 0 {
        let _ = writeln!(
            text,
            "  at {} of {} fresh places in the posterior the model's run failed: the surrogate does not know where runs fail, so \
             the intervals of the sample do not hold; sample the model itself, or give more runs (--surrogate {})",
            told.check_failed,
            told.check_failed + told.checked,
            2 * told.runs
        );
    }
    for (place, own) in told.optima.iter().enumerate() {
        let name = match told.optima.len() {
            1 => "the optimum".to_owned(),
            _ => format!("optimum {}", place + 1),
        };
        let _ = match own.model {
            Some(model) => writeln!(
                text,
                "  {name} run again in the model: sum of squares {}, by the surrogate {}{}",
                Digits(model, 4),
                Digits(own.surrogate, 4),
                match (model - own.surrogate).abs() > DIFFERENT {
                    true => "; the surrogate is too rough to tell its place",
                    false => "",
                }
            ),
            None => writeln!(
                text,
                "  the model's run fails at {name}: it is no optimum of the model, and its values and sum of squares are the surrogate's"
            ),
        };
    }
    text
}

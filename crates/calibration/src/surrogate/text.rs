//! The surrogates in words.

use super::super::digits::rounded;
use super::super::failures::words;
use super::outcome::SurrogateOutcome;

/// An error counted that is larger than this part of the accuracy widens intervals by 12 %.
const LARGE: f64 = 0.5;

/// Sums of squares of surrogates and model that differ by more leave the optimum's place in doubt.
const DIFFERENT: f64 = 1.0;

/// What stands in for the model, and how well.
pub fn sentences(told: &SurrogateOutcome) -> Vec<String> {
    let mut said = vec![format!(
        "Surrogate: polynomials from {} runs a case ({} failed) in {} rounds stand in for the model; the last ones are of {}",
        told.runs,
        told.failed,
        told.rounds,
        words(&told.within)
    )];
    let (checked, more) = (told.checked, 2 * told.runs);
    let all = told.errors.iter().flatten();
    if let Some(worst) = all.max_by(|a, b| a.part().total_cmp(&b.part())) {
        let held_out = worst.held_out.map_or_else(String::new, |error| {
            let error = rounded(error, 2);
            format!(", at {checked} fresh runs in the posterior {error}")
        });
        let [leave_one_out, counted, accuracy] =
            [worst.leave_one_out, worst.counted, worst.accuracy].map(|error| rounded(error, 2));
        said.push(format!(
            "its error is largest in {}: leave-one-out {leave_one_out}{held_out}; counted as {counted} beside the accuracy of \
             {accuracy} ({:.0} %)",
            worst.quantity,
            100.0 * worst.part()
        ));
    }
    if told.largest > LARGE {
        said.push(format!(
            "so intervals are wider than the data's own, and optima close to each other may look like one: more runs \
             (--surrogate {more}) tell more"
        ));
    }
    if checked == 0 {
        said.push("no fresh run could be compared, so only the leave-one-out error is known".to_owned());
    }
    if told.check_failed > 0 {
        said.push(format!(
            "at {} of {} fresh places in the posterior the model's run failed: the surrogate does not know where runs fail, so \
             the intervals of the sample do not hold; sample the model itself, or give more runs (--surrogate {more})",
            told.check_failed,
            told.check_failed + checked
        ));
    }
    for (place, optimum) in told.optima.iter().enumerate() {
        let name = match told.optima.len() {
            1 => "the optimum".to_owned(),
            _ => format!("optimum {}", place + 1),
        };
        said.push(match optimum.model {
            Some(model) => format!(
                "{name} run again in the model: sum of squares {}, by the surrogate {}{}",
                rounded(model, 4),
                rounded(optimum.surrogate, 4),
                match (model - optimum.surrogate).abs() > DIFFERENT {
                    true => "; the surrogate is too rough to tell its place",
                    false => "",
                }
            ),
            None => format!(
                "the model's run fails at {name}: it is no optimum of the model, and its values and sum of squares are the surrogate's"
            ),
        });
    }
    said
}

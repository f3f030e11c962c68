//! The surrogates in words.

use super::super::failures::words;
use super::outcome::SurrogateOutcome;
use result_document::format::significant;

/// An error counted that is larger than this part of the accuracy widens intervals by 12 %.
const LARGE: f64 = 0.5;

/// Sums of squares of surrogates and model that differ by more leave the optimum's place in doubt.
const DIFFERENT: f64 = 1.0;

/// What stands in for the model, and how well.
pub fn sentences(told: &SurrogateOutcome) -> Vec<String> {
    let known = match told.known {
        0 => String::new(),
        known => format!(", {known} of them the study's points, which were not run again"),
    };
    let runs = format!("{} places ({} failed{known})", told.runs, told.failed);
    let [counted, accuracy] = [told.worst.counted, told.worst.accuracy].map(|error| significant(error, 2));
    let worst = format!(
        "its error is largest in {}: {counted} beside the accuracy of {accuracy} ({:.0} %)",
        told.worst.quantity,
        100.0 * told.worst.part()
    );
    if !told.holds {
        return vec![format!(
            "The surrogate does not hold here, after {runs}: {worst}; the model itself was searched from the best of them with the \
             runs that were left"
        )];
    }
    let mut said =
        vec![format!("By surrogate from {runs} in {} rounds; the last one is of {}", told.rounds, words(&told.within))];
    said.push(format!("{worst}, and counts in intervals"));
    if let Some(apart) = told.apart {
        said.push(format!(
            "at the last {} runs, which it did not know, its sum of squares was off by {} in the middle",
            told.checked,
            significant(apart, 2)
        ));
    }
    if told.worst.part() > LARGE {
        said.push("intervals are wider than the data's own: a larger budget narrows them".to_owned());
    }
    if told.check_failed > 0 {
        said.push(format!(
            "{} of the last {} runs failed where the surrogate expected none: the edge of where runs fail is rough in the sample",
            told.check_failed,
            told.check_failed + told.checked
        ));
    }
    for (place, optimum) in told.optima.iter().enumerate() {
        let name = match told.optima.len() {
            1 => "the optimum".to_owned(),
            _ => format!("optimum {}", place + 1),
        };
        said.push(match optimum.model {
            Some(model) => format!(
                "{name} run in the model: sum of squares {}, by the surrogate {}{}",
                significant(model, 4),
                significant(optimum.surrogate, 4),
                if (model - optimum.surrogate).abs() > DIFFERENT {
                    "; the surrogate is too rough to tell its place"
                } else {
                    ""
                }
            ),
            None => format!("the model's run fails at {name}: it is no optimum of the model"),
        });
    }
    said
}

//! Why no tolerances would do.

use parameter_regions::tolerances::Problem;
use result_document::format::number;

/// What is left with all tolerances at nothing: one point, or one for each of some rows of the samples.
pub(super) fn at_nothing(share: f64, points: usize) -> String {
    format!(
        "with all tolerances at nothing, {} % of {points} point{} conform as wanted, and narrower tolerances only bring the others \
         nearer to that: shift a parameter's nominal value, or measure better",
        number(100.0 * share, 3),
        if points == 1 { "" } else { "s" }
    )
}

/// That the wanted share is too near the largest one to be shown.
pub(super) fn not_shown(problem: &Problem) -> String {
    format!(
        "{} % may be reached, but no tolerances are expected to show it at a confidence of {} % in {} fresh runs: want \
         less, or confirm with more runs (`--confirm N`)",
        number(100.0 * problem.target, 4),
        number(100.0 * problem.confidence, 4),
        problem.confirm
    )
}

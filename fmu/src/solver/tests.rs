use plain_bearing_stand::solver::{Budget, Failure, Work, worst};

/// Ten steps at once, two more a second, a thousand in all.
const BUDGET: Budget = Budget { at_once: 10, per_second: 2.0, most: 1000.0 };

fn after(accepted: usize, rejected: usize, passed: f64, span: f64) -> Result<(), Failure> {
    BUDGET.check(Work { accepted, rejected }, passed, span)
}

#[test]
fn every_failure_tells_how_far_it_came() {
    let (passed, step, steps, span, needed) = (3.0, 1.0, 7, 9.0, 1e9);
    assert_eq!(Failure::StepTooSmall { step, passed }.passed(), passed);
    let slow = Failure::TooManySteps { steps, passed, span };
    assert_eq!(slow.passed(), passed);
    assert_eq!(Failure::SpanTooLong { needed, passed }.passed(), passed);
}

#[test]
fn all_of_a_budget_may_be_used_and_no_step_more() {
    assert_eq!(after(13, 1, 2.0, 10.0), Ok(()));
    let (steps, passed, span) = (15, 2.0, 10.0);
    let failure = Failure::TooManySteps { steps, passed, span };
    assert_eq!(after(13, 2, passed, span), Err(failure));
}

/// The first four of a thousand steps are the sample from which the others are foreseen.
#[test]
fn a_span_that_is_too_long_is_foreseen_after_the_sample() {
    assert_eq!(after(4, 0, 1.0, 1e6), Ok(()));
    assert_eq!(after(5, 0, 1.0, 200.0), Ok(()));
    let failure = Failure::SpanTooLong { needed: 1005.0, passed: 1.0 };
    assert_eq!(after(5, 0, 1.0, 201.0), Err(failure));
}

#[test]
fn the_worst_error_is_the_largest_or_no_number() {
    assert_eq!(worst([0.5, -2.0, 1.0].into_iter()), 2.0);
    assert!(worst([0.5, f64::NAN, 1.0].into_iter()).is_nan());
}

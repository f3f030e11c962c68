//! How runs of a study are made finer or longer: for a picture, to see swing and drift, and for the numerical uncertainty.

use conformity::validation::Refined;
use fmu_points::task::{Case, Schedule};

/// The fewest communication steps of the study's part of a run that is to show swing and drift.
const FEWEST: u64 = 2500;

/// The study's own communication points where they are enough for a plot, else closer ones: what happens
/// between them is to be seen.
pub fn for_a_plot(schedule: Schedule) -> Schedule {
    const ENOUGH: u64 = 1000;
    const PLENTY: f64 = 10_000.0;
    if schedule.steps() >= ENOUGH {
        return schedule;
    }
    Schedule { step: schedule.step.min((schedule.stop - schedule.start) / PLENTY), ..schedule }
}

/// Finer steps than those of a study: shorter by the golden ratio at least. A period of which the study's step is a
/// multiple is then met at all its phases, as no ratio is worse approximated by a fraction (Hurwitz 1891).
pub fn golden(schedule: &Schedule) -> Option<Schedule> {
    let mut schedule = *schedule;
    // Where only the final value counts, a leap may leave nothing to look at.
    schedule.leap &= schedule.window_start < schedule.stop;
    let begin = schedule.points().at(schedule.first_even());
    let even = schedule.stop - begin;
    let steps = (schedule.steps() - schedule.first_even()) as f64;
    let golden = 0.5 * (1.0 + 5.0_f64.sqrt());
    // The least power of the golden ratio that makes the steps many enough.
    let mut ratio = golden;
    while steps * ratio < FEWEST as f64 {
        ratio *= golden;
    }
    let count = (steps * ratio).round() as u64;
    let valid = even > 0.0;
    // All steps are equal up to the study's end, as some FMUs want it.
    valid.then(|| Schedule { step: even / count as f64, ..schedule })
}

/// The same steps up to a later end: twice as late, or so that the steps are three times as many.
pub fn longer(schedule: &Schedule) -> Schedule {
    const LONGER: f64 = 3.0;
    let begin = schedule.points().at(schedule.first_even());
    let further = (schedule.stop - schedule.start).min(LONGER * (schedule.stop - begin));
    let further = (further / schedule.step).round() * schedule.step;
    Schedule { stop: schedule.stop + further, ..*schedule }
}

/// The case with a finer setting, so many times.
pub fn refined_case(case: &Case, by: Refined, times: u32) -> Case {
    let mut case = case.clone();
    let tolerance = &mut case.task.schedule.tolerance;
    match by {
        Refined::Step => case.task.halve_steps(times),
        Refined::Tolerance => *tolerance = tolerance.map(|given| given / by.ratio().powf(f64::from(times))),
    }
    case
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finer_steps_are_no_fraction_of_the_study_s() {
        for (stop, step) in [(1000.0, 1.0), (150.0, 150.0), (15_000.0, 1.0), (2.0, 0.01)] {
            let study = Schedule { start: 0.0, stop, step, window_start: 0.0, leap: false, tolerance: None };
            let fine = golden(&study).unwrap();
            assert!(fine.steps() >= FEWEST && fine.step < step / 1.6, "{fine:?}");
            // Of the phases that a period has which is a fraction of the study's step, none is far from those seen.
            for part in [1.0, 2.0, 7.0] {
                let phases = (0..200).map(|k| (f64::from(k) * fine.step * part / step).fract());
                let mut phases: Vec<f64> = phases.collect();
                if fine.step * part * 200.0 < step {
                    continue;
                }
                phases.sort_by(f64::total_cmp);
                let gap = phases.windows(2).map(|pair| pair[1] - pair[0]);
                assert!(gap.fold(0.0, f64::max) < 0.1, "{stop} {step} {part}");
            }
            let on = longer(&fine);
            assert!((on.stop / stop - 2.0).abs() < 1e-9);
            assert_eq!(on.steps(), 2 * fine.steps());
        }
        let leap = Schedule { start: 0.0, stop: 1000.0, step: 0.1, window_start: 999.0, leap: true, tolerance: None };
        let fine = golden(&leap).unwrap();
        assert_eq!(longer(&fine).stop, 1003.0);
    }
}

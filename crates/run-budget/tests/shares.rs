//! Shares of published functions: do the stated intervals hold?

mod functions;

use functions::Model;
use run_budget::{Basis, Campaign, Limit, Share};

/// A campaign of so many runs: twenty plain ones, then batches of ten or a fifth of what there is, as a study has them. `fails`
/// says where a run fails.
fn campaign(model: &Model, runs: usize, seed: u64, fails: fn(&[f64]) -> bool) -> Share {
    let sample = model.points(4096, seed);
    let limits = vec![Limit { output: 0, range: [model.limit, f64::INFINITY] }];
    let mut campaign = Campaign::new(limits.clone(), sample.clone(), 20, seed);
    let mut done = 0;
    while done < runs {
        let batch = campaign.next((runs - done).min((done / 5).max(10)));
        let numbers = done..done + batch.len();
        done += batch.len();
        for (number, place) in numbers.zip(batch).rev() {
            let point = &sample[place];
            campaign.tell(number, (!fails(point)).then(|| vec![(model.of)(point)]));
        }
    }
    campaign.answers().share(&limits)
}

fn truth(model: &Model, fails: fn(&[f64]) -> bool) -> f64 {
    let points = model.points(1 << 17, 77);
    let good = points.iter().filter(|point| !fails(point) && (model.of)(point) >= model.limit).count();
    good as f64 / points.len() as f64
}

fn never(_: &[f64]) -> bool {
    false
}

/// A fifth of the points, in a region of its own.
fn in_a_corner(u: &[f64]) -> bool {
    u[0] * u[1] < 0.054
}

#[test]
fn fifty_runs_of_a_circuit_tell_the_share_to_two_points() {
    let model = &functions::ALL[0];
    let share = campaign(model, 50, 3, never);
    let truth = truth(model, never);
    assert_eq!(share.basis, Basis::Surrogate);
    assert!((share.estimate - truth).abs() < 0.02, "{share:?} {truth}");
    let [low, high] = share.interval(0.95);
    assert!(low < truth && truth < high, "{share:?} {truth}");
}

#[test]
fn batches_do_not_depend_on_the_order_in_which_runs_come_back() {
    let model = &functions::ALL[0];
    let points = |turned: bool| {
        let limits = vec![Limit { output: 0, range: [model.limit, f64::INFINITY] }];
        let sample = model.points(512, 1);
        let mut campaign = Campaign::new(limits, sample.clone(), 20, 1);
        for start in [0, 10, 20, 30] {
            let mut batch: Vec<(usize, usize)> = (start..).zip(campaign.next(10)).collect();
            assert!(campaign.next(10).is_empty(), "the batch is not back");
            if turned {
                batch.reverse();
            }
            batch.into_iter().for_each(|(number, place)| campaign.tell(number, Some(vec![(model.of)(&sample[place])])));
        }
        campaign.runs()
    };
    let runs = points(false);
    assert_eq!(runs.len(), 40);
    assert_eq!(runs, points(true));
}

#[test]
fn noise_that_no_surrogate_follows_is_counted_or_left_open() {
    let model = functions::ALL.iter().find(|m| m.name == "noise").expect("it is listed");
    let share = campaign(model, 50, 1, never);
    let truth = truth(model, never);
    let [low, high] = share.interval(0.95);
    assert!(low < truth && truth < high, "{share:?} {truth}");
}

/// A process smooths a jump, so that all its functions take the lower side of the limit for the upper one next to it.
#[test]
fn a_jump_at_the_limit_is_counted_or_left_open() {
    let model = functions::ALL.iter().find(|m| m.name == "jump").expect("it is listed");
    let share = campaign(model, 100, 1004, never);
    let truth = truth(model, never);
    let [low, high] = share.interval(0.95);
    assert!(low < truth && truth < high, "{share:?} {truth}");
}

/// Prints how often intervals hold: `cargo test -p run-budget --release --test shares -- --ignored --nocapture`.
#[test]
#[ignore = "takes many minutes of CPU"]
fn intervals_of_shares_hold() {
    let seeds = functions::number("SEEDS", 40);
    println!("function     failing runs  share   error  width  held    counted, of {seeds} seeds");
    let regions: [fn(&[f64]) -> bool; 2] = [never, in_a_corner];
    for (model, runs) in functions::trials() {
        let failing = if ["circuit", "jump"].contains(&model.name) { 2 } else { 1 };
        for &fails in &regions[..failing] {
            let truth = truth(model, fails);
            let lost = if fails(&[0.0, 0.0]) { 20 } else { 0 };
            let shares: Vec<Share> = (1..=seeds).map(|seed| campaign(model, runs as usize, seed, fails)).collect();
            let of = |f: fn(&Share, f64) -> f64| shares.iter().map(|s| f(s, truth)).sum::<f64>() / seeds as f64;
            let error = of(|s, truth| (s.estimate - truth).powi(2)).sqrt();
            let width = of(|s, _| s.interval(0.95)[1] - s.interval(0.95)[0]);
            let held = of(|s, truth| f64::from(s.interval(0.95)[0] <= truth && truth <= s.interval(0.95)[1]));
            let counted = of(|s, _| f64::from(s.basis != Basis::Surrogate));
            println!(
                "{:12} {lost:4} % {runs:4} {:6.2} % {:5.2} % {:5.2} % {:5.1} % {:5.0} %",
                model.name,
                100.0 * truth,
                100.0 * error,
                100.0 * width,
                100.0 * held,
                100.0 * counted
            );
            assert!(held >= 0.93, "{} {runs}", model.name);
        }
    }
}

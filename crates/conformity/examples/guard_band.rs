//! The guard band that keeps the risk of an accepted model at 1 %, for models that spread evenly over the tolerance and
//! beyond: `cargo run --example guard_band`.

use conformity::measured::{Measured, Measurement};
use conformity::risk::{Guard, RiskTally};
use conformity::uncertainty::Uncertainty;

fn main() -> Result<(), String> {
    let temperature = Measured::within(48.0, 2.0, Some(Uncertainty::normal(1.0, 2.0).law(0.0)));
    let measurement = Measurement::new(vec![temperature], &[])?;
    for guard in [Guard::Given(0.0), Guard::Limiting { risk: 0.01 }] {
        let mut tally = RiskTally::new(&measurement, guard, 1);
        for i in 0..10_000 {
            let model = 45.0 + 6.0 * (f64::from(i) + 0.5) / 10_000.0;
            tally.add(Some(&measurement.assess(&[model])));
        }
        let statement = tally.statement();
        let risk = statement.all.and_then(|all| all.not_conforming_given_accepted);
        println!(
            "guard band {:.3} K: {} of 10,000 models accepted, P(not conforming | accepted) = {:.3} %",
            statement.guard.unwrap_or(f64::NAN),
            statement.accepted,
            100.0 * risk.unwrap_or(f64::NAN),
        );
    }
    Ok(())
}

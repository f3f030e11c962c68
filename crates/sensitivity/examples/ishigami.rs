//! Ten designs of 1,024 base points (5,120 runs) against the known indices of the Ishigami function.

mod functions;

use functions::{ishigami, ishigami_indices};
use sensitivity::method::{FirstOrder, FromRuns, Settled};
use sensitivity::sobol::{Sobol, indices};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (first, total) = ishigami_indices();
    let mut held = 0;
    for seed in 1..=10 {
        let settled = Settled { size: 1024, seed };

        // Points in the unit cube: map them to the distributions of your parameters, run the model, keep the order.
        let design = Sobol.design(3, &settled)?;
        let values: Vec<f64> = design.iter().map(|point| ishigami(point)).collect();

        let found = indices(&values, 3, FirstOrder::default()).ok_or("too few runs")?;
        for parameter in 0..3 {
            let (s, t) = (found.first[parameter], found.total[parameter]);
            println!(
                "S {:.3} ({:.3} .. {:.3})   T {:.3} ({:.3} .. {:.3})",
                s.value, s.low, s.high, t.value, t.low, t.high
            );
            held += u32::from(s.contains(first[parameter])) + u32::from(t.contains(total[parameter]));
        }
    }
    // Of 60 intervals that hold with 95 %, 51 to 60 hold with a probability of 99.9 %.
    assert!(held >= 51, "{held}");
    Ok(())
}

//! The box of two parameters that a manufacturer may promise.

use parameter_regions::robustness::robustness;
use parameter_regions::table::{CriterionColumn, ParameterColumn, PointTable};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // Any sample does: here a lattice.
    let points: Vec<[f64; 2]> = (0..400).map(|k| [k % 20, k / 20].map(|i| -1.9 + 0.2 * f64::from(i))).collect();
    let parameter = |k: usize| ParameterColumn {
        name: format!("p{k}"),
        unit: "mm".into(),
        values: points.iter().map(|x| x[k]).collect(),
    };
    let criterion = |name: &str, value: &dyn Fn(&[f64; 2]) -> f64| {
        let values: Vec<f64> = points.iter().map(value).collect();
        let ok = values.iter().map(|v| v.abs() <= 1.0).collect();
        CriterionColumn {
            name: name.into(),
            unit: String::new(),
            nominal: 0.0,
            lower: -1.0,
            upper: 1.0,
            group: None,
            values,
            ok,
        }
    };
    let criteria = vec![criterion("sum", &|x| x[0] + 0.5 * x[1]), criterion("difference", &|x| x[1] - 0.2 * x[0])];
    let table = PointTable {
        ids: (1..=400).collect(),
        parameters: vec![parameter(0), parameter(1)],
        verified: (0..400).map(|i| criteria.iter().all(|c| c.ok[i])).collect(),
        criteria,
        status: vec!["ok".into(); 400],
    };
    // Probabilities refer to this sample of the parameters; a real one has some 20,000 points.
    let cloud: Vec<Vec<f64>> = (0..4_000)
        .map(|k| {
            let k = f64::from(k);
            vec![4.0 * (k * 0.754_877_666).fract() - 2.0, 4.0 * (k * 0.569_840_29).fract() - 2.0]
        })
        .collect();
    let answer = robustness(&table, &table, &cloud, 0.9).ok_or("too few points")?;
    let safe = answer.region.ok_or("no box conforms with 90 %")?;
    for (name, [low, high]) in ["p0", "p1"].iter().zip(&safe.limits) {
        println!("{name} from {low:.2} to {high:.2} mm");
    }
    assert!(safe.contains(&[0.0, 0.0]) && !safe.contains(&[1.5, 1.5]));
    Ok(())
}

//! Writes the report of an invented study, to look at: `cargo run --example report_demo -- 50 target/demo`.

use conformity::uncertainty::Uncertainty;
use orchestrator::methods::{pareto, robustness as robust};
use orchestrator::report::{Report, figures::Series, judgement::Judgement};
use orchestrator::results::summary::{Count, CriterionCount, Provenance};
use orchestrator::results::{Summary, answer::Answer};
use parameter_regions::pareto::study::trade_off;
use parameter_regions::robustness::{region, robustness, rows};
use parameter_regions::table::{CriterionColumn, ParameterColumn, PointTable};
use rand::{RngExt, SeedableRng, rngs::StdRng};
use rand_distr::StandardNormal;
use result_document::Document;
use sampling::statistics::share::Fraction;
use std::path::Path;
use study::judge::Criterion;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let n: usize = arguments.next().unwrap_or("50".into()).parse()?;
    let folder = arguments.next().unwrap_or("target/demo".into());
    let table = cloud(n);
    let summary = summary(&table);
    let report = Report {
        documents: documents(&table),
        answer: Answer::new(&summary),
        judgement: Judgement::new(&summary)?,
        summary,
        table,
        history: history(),
        command: "orchestrator verify studies/paper-table3.toml --output results/paper".into(),
        study_text: "[design]\nmethod = \"monte-carlo\"\n".into(),
        ..Report::default()
    };
    println!("{}", report.write(Path::new(&folder))?.display());
    Ok(())
}

/// What a study's summary would say of the points.
fn summary(table: &PointTable) -> Summary {
    let share = |passes: &dyn Fn(usize) -> bool| {
        let count = (0..table.len()).filter(|&i| passes(i)).count();
        let share = Fraction::wilson(count, table.len());
        Count { passed: count as u64, fraction: share.value(), interval: Some([share.low, share.high]) }
    };
    let bindings: Vec<_> = (0..table.len()).map(|i| table.binding(i)).collect();
    let criterion = |(k, c): (usize, &CriterionColumn)| {
        let all = || table.criteria.iter().enumerate();
        let others = |i: usize| all().all(|(j, other)| j == k || other.ok[i]);
        let bindings = bindings.iter().flatten();
        let tolerance = c.upper - c.nominal;
        let count = CriterionCount {
            count: share(&|i| c.ok[i]),
            binds: bindings.filter(|b| b.criterion == k).count() as u64,
            only_failure: share(&|i| table.completed(i) && !c.ok[i] && others(i)).passed,
            reached: None,
            risk: None,
            risk_not_stated: None,
            criterion: Criterion {
                name: c.name.clone(),
                limits: conformity::measured::Limits::within(c.nominal, tolerance),
                // Half the tolerance.
                uncertainty: Some(Uncertainty::normal(0.5 * tolerance, 2.0)),
                ..Criterion::default()
            },
        };
        (c.name.clone(), count)
    };
    let group = |name: &str| {
        let members: Vec<_> = table.criteria.iter().filter(|c| c.group.as_deref() == Some(name)).collect();
        (name.to_owned(), share(&|i| members.iter().all(|c| c.ok[i])))
    };
    let verified = share(&|i| table.verified[i]);
    Summary {
        title: Some("Plain bearing, parameter distribution of Table 3".into()),
        provenance: Provenance {
            fmu: Some("PlainBearingStand".into()),
            fmu_sha256: Some("0f".repeat(32)),
            seed: Some(1),
            ..Provenance::default()
        },
        points: table.len() as u64,
        failed: (0..table.len()).filter(|&i| !table.completed(i)).count() as u64,
        verified: verified.passed,
        verified_fraction: verified.fraction,
        verified_interval: verified.interval,
        criteria: table.criteria.iter().enumerate().map(criterion).collect(),
        groups: table.groups().into_iter().map(group).collect(),
        ..Summary::default()
    }
}

/// The methods' documents on the points; of many points they would take long.
fn documents(table: &PointTable) -> Vec<Document> {
    let few = table.len() <= 5000;
    let cloud = || region::cloud(&rows(table), 1);
    let room = if few { robustness(table, table, &cloud(), 0.8) } else { None };
    let costs = trade_off(table);
    let told = [room.map(|result| robust::document(&result)), costs.map(|result| pareto::document(&result))];
    told.into_iter().flatten().collect()
}

fn cloud(n: usize) -> PointTable {
    let mut random = StdRng::seed_from_u64(1);
    let laws = [
        ("bearing.radialClearance", "mm", 0.020, 0.005),
        ("load.stiffness", "N/m", 100.0, 10.0),
        ("load.damping", "N.s/m", 14.0, 1.4),
        ("load.preload", "N", 48.0, 5.5),
        ("load.eccentricity", "mm", 0.41, 0.07),
        ("bearing.width", "mm", 19.0, 0.19),
        ("bearing.diameter", "mm", 25.0, 0.25),
    ];
    let columns: Vec<Vec<f64>> = laws
        .iter()
        .map(|&(_, _, mean, sd)| {
            (0..n).map(|_| (mean + sd * random.sample::<f64, _>(StandardNormal)).max(0.25 * mean)).collect()
        })
        .collect();
    let failed = |i: usize| i % 41 == 40;
    let value = |i: usize, x: f64| if failed(i) { f64::NAN } else { x };
    let column = |k: usize, i: usize| columns[k][i];
    let force = |i: usize| {
        16.621 * column(3, i) + 0.2616 * column(1, i) * column(4, i) - 0.5429 * column(1, i)
            + 0.1612 * column(2, i) * column(4, i)
    };
    let power =
        |i: usize| 14.0 * (column(6, i) / 25.0).powi(3) * (column(5, i) / 19.0) * (column(0, i) / 0.02).powf(-0.75);
    let criterion = |name: &str, unit: &str, group: &str, nominal: f64, tolerance: f64, law: &dyn Fn(usize) -> f64| {
        let values: Vec<f64> = (0..n).map(|i| value(i, law(i))).collect();
        let ok = values.iter().map(|v| (v - nominal).abs() <= tolerance).collect();
        CriterionColumn {
            name: name.into(),
            unit: unit.into(),
            nominal,
            lower: nominal - tolerance,
            upper: nominal + tolerance,
            group: Some(group.into()),
            values,
            ok,
        }
    };
    let criteria = vec![
        criterion("T_oil", "degC", "temperature", 48.0, 0.5, &|i| 47.82 + 0.0143 * power(i)),
        criterion("T_bearing", "degC", "temperature", 82.0, 0.615, &|i| {
            80.9 + 0.037 * power(i) + 0.0014 * power(i).powi(2)
        }),
        criterion("P_fr", "W", "power and load", 14.0, 3.0, &power),
        criterion("F_N", "N", "power and load", 750.0, 52.5, &force),
    ];
    PointTable {
        ids: (1..=n as u64).collect(),
        verified: (0..n).map(|i| criteria.iter().all(|c| c.ok[i])).collect(),
        status: (0..n)
            .map(|i| {
                if failed(i) {
                    "fmi2DoStep failed at 12.4 s: the film solution did not converge".into()
                } else {
                    "ok".into()
                }
            })
            .collect(),
        parameters: laws
            .iter()
            .zip(&columns)
            .map(|((name, unit, ..), values)| ParameterColumn {
                name: (*name).into(),
                unit: (*unit).into(),
                values: values.clone(),
            })
            .collect(),
        criteria,
    }
}

fn history() -> Vec<Series> {
    let time: Vec<f64> = (0..15_001).map(|i| f64::from(i) * 0.01).collect();
    let force = time.iter().map(|t| 750.0 + 45.0 * (31.416 * t).sin()).collect();
    let temperature = time.iter().map(|t| 82.0 - 0.4 * (1.0 - (-t / 60.0).exp())).collect();
    vec![
        Series {
            measured: None,
            name: "sensor.loadForce".into(),
            unit: "N".into(),
            time: time.clone(),
            values: force,
            accepted: Some([697.5, 802.5]),
            judged: None,
        },
        Series {
            measured: None,
            name: "sensor.bearingTemperature".into(),
            unit: "degC".into(),
            time,
            values: temperature,
            accepted: Some([81.385, 82.615]),
            judged: None,
        },
    ]
}

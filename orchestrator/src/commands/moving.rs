//! Whether the values that were compared had come to rest: seen on the best point's trajectory.

use std::path::Path;

use super::CommandError;
use crate::analysis::motion::{Motion, motion};
use crate::judge::Criterion;
use crate::report::format::number;
use crate::report::history::{self, Signal};
use crate::results::{Summary, write_atomically};
use sampling::statistics::Statistic;

/// The summary with what the best point's trajectory tells of swing and drift; writes it again where that is anything.
pub(super) fn observed(folder: &Path, summary: &Summary) -> Result<Summary, CommandError> {
    let mut summary = summary.clone();
    let found = match history::signals(folder) {
        Some((time, signals)) => concerns(&summary, &time, &signals),
        // Where every point failed, that is told already.
        None if summary.best_point.is_none() => Vec::new(),
        None => vec![
            "whether the values still move at the end of the run was not observed: there is no trajectory of the best \
             point"
                .to_owned(),
        ],
    };
    if !found.is_empty() {
        summary.concerns.extend(found);
        write_atomically(&folder.join("summary.json"), |out| {
            serde_json::to_writer_pretty(&mut *out, &summary)?;
            writeln!(out)
        })?;
    }
    Ok(summary)
}

fn concerns(summary: &Summary, time: &[f64], signals: &[Signal]) -> Vec<String> {
    let of = |(name, values): &Signal| {
        let criterion = &summary.criteria.get(name)?.criterion;
        Some(judged(criterion, motion(time, values)?))
    };
    signals.iter().filter_map(of).flatten().collect()
}

/// The effect of a motion on the number that is compared with the measured value.
fn judged(criterion: &Criterion, motion: Motion) -> Vec<String> {
    let Criterion {
        name,
        statistic,
        tolerance,
        stated_tolerance,
        ..
    } = criterion;
    let unit = criterion
        .unit
        .as_deref()
        .map_or_else(String::new, |unit| format!(" {unit}"));
    let mut found = Vec::new();
    if *statistic == Statistic::Final && motion.swing > 0.1 * tolerance {
        found.push(format!(
            "{name}: its signal swings by {}{unit} in its last period, and the final value is only one instant of it \
             (tolerance {stated_tolerance}): use `statistic = \"mean\"` with a `window`, or make sure that the \
             measured value was taken at the same phase",
            number(motion.swing, 3)
        ));
    }
    let follows = matches!(
        statistic,
        Statistic::Final | Statistic::Mean | Statistic::Rms
    );
    if follows && motion.drift.abs() > 0.5 * tolerance {
        found.push(format!(
            "{name}: its value still moves when the run ends, by {}{unit} in a time as long as the run (tolerance \
             {stated_tolerance}), so the verdict depends on `stop`: simulate longer, or up to the moment of the \
             measurement",
            number(motion.drift, 3)
        ));
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn criterion(statistic: Statistic) -> Criterion {
        Criterion {
            name: "T".into(),
            variable: "t".into(),
            statistic,
            unit: Some("degC".into()),
            nominal: 82.0,
            tolerance: 0.6,
            stated_tolerance: "0.6 degC".into(),
            uncertainty: None,
            group: None,
        }
    }

    #[test]
    fn swing_and_drift_count_against_the_tolerance() {
        let of = |statistic, swing, drift| judged(&criterion(statistic), Motion { swing, drift });
        assert!(of(Statistic::Final, 0.05, 0.2).is_empty());
        let found = of(Statistic::Final, 0.07, -0.4);
        assert!(
            found[0].starts_with("T: its signal swings by 0.07"),
            "{found:?}"
        );
        assert!(found[1].contains("0.4 degC in a time as long"), "{found:?}");
        assert_eq!(of(Statistic::Mean, 0.07, -0.4).len(), 1);
        assert!(of(Statistic::Amplitude, 0.07, -0.4).is_empty());
    }
}

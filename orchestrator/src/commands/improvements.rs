//! What to improve first, on the terminal.

use crate::results::Summary;
use crate::results::improvement::{Change, Halved, Sign};

/// The surest gain, or that there is none among the changes that were looked at.
pub(super) fn text(summary: &Summary) -> String {
    let Some(found) = &summary.improvements else {
        return String::new();
    };
    // Those of a grid have no intervals that would tell a gain from chance.
    if summary.verified_interval.is_none() {
        return String::new();
    }
    let gains = || found.changes.iter().filter(|c| c.sign() == Sign::Gain);
    let open = found.changes.iter().filter(|c| c.sign() == Sign::Open);
    let open = match open.count() {
        0 => String::new(),
        1 => "; 1 change may gain or not".to_owned(),
        n => format!("; {n} changes may gain or not"),
    };
    let Some(first) = gains().next() else {
        return format!(
            "to improve first: not known: {} points show no gain from half an uncertainty or tolerance{open}\n",
            found.points
        );
    };
    format!("to improve first: {}{open}\n", sentence(first))
}

fn sentence(change: &Change) -> String {
    let what = match change.halved {
        Halved::Uncertainty => "uncertainty of the measured value",
        Halved::Tolerance => "tolerance of",
    };
    let interval = change.gain_interval.map_or_else(String::new, |ends| {
        let [low, high] = ends.map(|end| 100.0 * end);
        format!(" (95 % interval {low:.1} .. {high:.1})")
    });
    format!(
        "half the {what} {} gains {:.1} points of the share{interval}",
        change.name,
        100.0 * change.gain
    )
}

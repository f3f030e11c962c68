//! Curves that are late by an unknown time: the model is read at even times, and predictions lie between.

use std::sync::Arc;

use fmu_points::task::{MeasuredCurve, Probe, Schedule};

/// How the model's readings of a simulation become a predicted value.
#[derive(Debug)]
pub enum Reading {
    /// The reading of this number.
    Value(usize),
    /// The value at a time, less lags, on a smooth curve through readings at even times.
    Late(Late),
}

/// A value of a late curve.
#[derive(Debug)]
pub struct Late {
    /// The number of the first reading.
    first: usize,
    /// When it was read, s.
    start: f64,
    /// The distance of readings, s.
    step: f64,
    /// How many there are.
    count: usize,
    /// When the value was measured, on the model's clock but for the lags, s.
    time: f64,
    /// The lags' numbers among the free parameters.
    lags: Arc<Vec<usize>>,
}

impl Reading {
    /// The predicted value, given the readings and the free parameters.
    pub fn value(&self, readings: &[f64], free: &[f64]) -> f64 {
        let late = match self {
            Self::Value(number) => return readings[*number],
            Self::Late(late) => late,
        };
        let lag: f64 = late.lags.iter().map(|lag| free[*lag]).sum();
        let last = late.count - 1;
        let place = ((late.time - lag - late.start) / late.step).clamp(0.0, last as f64);
        let before = (place.floor() as usize).min(last - 1);
        let [a, b, c, d] = [before.saturating_sub(1), before, before + 1, before + 2]
            .map(|number| readings[late.first + number.min(last)]);
        // Catmull & Rom 1974: a cubic with the slopes of the neighbours' secants.
        let x = place - before as f64;
        let bend = 2.0 * a - 5.0 * b + 4.0 * c - d + x * (3.0 * (b - c) + d - a);
        b + 0.5 * x * (c - a + x * bend)
    }
}

/// What reads the model, and how that becomes predictions.
pub(super) type Read = (Vec<Probe>, Vec<Reading>);

/// The readings that a late curve needs, and how they become predictions of its rows; the first reading has the number
/// `first`.
///
/// # Errors
/// When the run does not reach as far as the lags.
pub(super) fn late(
    probe: &Probe,
    curve: &MeasuredCurve,
    schedule: &Schedule,
    (lags, range): (Vec<usize>, [f64; 2]),
    first: usize,
) -> Result<Read, String> {
    /// More readings a curve take more time than they are worth.
    const MOST: f64 = 4000.0;
    let times: Vec<f64> = curve.shown_times().collect();
    let least = times.windows(2).map(|pair| pair[1] - pair[0]).fold(f64::INFINITY, f64::min);
    let (Some(begin), Some(end)) = (times.first(), times.last()) else {
        return Err("the curve has no rows".to_owned());
    };
    let [from, to] = [begin - range[1], end - range[0]];
    let rounding = 1e-9 * (schedule.start.abs() + schedule.stop.abs());
    if from < schedule.start - rounding || to > schedule.stop + rounding {
        return Err(format!(
            "with its lags the measurement needs the model from {from} s to {to} s, and the run goes from {} s to {} s; set `window` to \
             the part that it covers",
            schedule.start, schedule.stop
        ));
    }
    let span = to - from;
    let step = least.min(schedule.step).max(span / MOST);
    let count = (span / step).ceil() as usize + 1;
    let step = span / (count - 1) as f64;
    let lags = Arc::new(lags);
    let probes = (0..count).map(|number| {
        let time = (from + number as f64 * step).clamp(schedule.start, schedule.stop);
        probe.at_row(curve, time)
    });
    let readings = times
        .iter()
        .map(|&time| Reading::Late(Late { first, start: from, step, count, time, lags: Arc::clone(&lags) }));
    Ok((probes.collect(), readings.collect()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_late_value_lies_on_the_curve_between_the_readings() {
        let readings: Vec<f64> = (0..200).map(|k| (0.1 * f64::from(k)).sin()).collect();
        let reading =
            Reading::Late(Late { first: 0, start: 1.0, step: 0.01, count: 200, time: 2.0, lags: Arc::new(vec![1]) });
        for lag in [0.0_f64, 0.0123, -0.207, 0.61] {
            let exact = (10.0 * (1.0 - lag)).sin();
            let value = reading.value(&readings, &[7.0, lag]);
            assert!((value - exact).abs() < 3e-5, "{lag}: {value} {exact}");
        }
        assert_eq!(Reading::Value(3).value(&readings, &[]), readings[3]);
    }
}

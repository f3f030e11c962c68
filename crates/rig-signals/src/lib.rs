#![doc = include_str!("../README.md")]

mod aligned;
pub mod case;
mod clean;
pub mod criteria;
pub mod delay;
mod holes;
mod kernel;
pub mod motion;
mod recording;
pub mod scatter;
pub mod signal;
pub mod smooth;
mod spectrum;
pub mod stationarity;
pub mod uncertainty;

use aligned::Aligned;
use clean::{Cleaned, clean};
use delay::Pair;
use holes::Holes;
pub use recording::{Accuracy, Channel, Derived, DerivedCriterion, RigRecording, Synchronised};
use signal::{Even, SignalError, Spline};
use spectrum::Comb;
pub use spectrum::Noise;

/// A gap in the record may be this many times as long as a step.
const LONGEST_GAP: f64 = 10.0;

/// Aligns a recording and derives the criteria.
pub fn synchronise(recording: &RigRecording) -> Result<Synchronised, SignalError> {
    check(recording)?;
    let [from, to] = recording.window();
    let kept: Vec<usize> = (0..recording.time.len())
        .filter(|&k| recording.time[k] >= from && recording.time[k] <= to)
        .collect();
    let kept = |values: &[f64]| kept.iter().map(|&k| values[k]).collect::<Vec<_>>();
    let time = kept(&recording.time);
    let cleaned = |channel: &Channel| clean(&kept(&channel.values));
    let spline = |name: &str, values: &[f64]| Spline::new(name, &time, values, LONGEST_GAP);
    let [clean_load, clean_torque] = [&recording.load, &recording.torque].map(cleaned);
    let load = spline(&recording.load.name, &clean_load.values)?;
    let torque = spline(&recording.torque.name, &clean_torque.values)?;
    let speed = spline(&recording.speed.name, &kept(&recording.speed.values))?;
    let start = load.span().0.max(torque.span().0);
    let end = load.span().1.min(torque.span().1);
    let step = load.step();
    let even = |spline: &Spline| Even::from_spline(spline, start, end, step);
    let smooth = |raw: &Even| {
        let values = recording.smoothing.apply(&raw.values, step)?;
        Ok::<_, SignalError>(Even { values, ..*raw })
    };
    let raw = (even(&load), even(&torque));
    let (load, torque) = (smooth(&raw.0)?, smooth(&raw.1)?);
    if load.values.contains(&0.0) {
        return Err(SignalError::Setting(
            "the load passes through zero: M/F_N has no meaning there".into(),
        ));
    }
    let pair = Pair {
        load: &load,
        torque: &torque,
        load_good: &good(&clean_load, &time, &load),
        torque_good: &good(&clean_torque, &time, &load),
    };
    let turn = recording.turn().filter(|turn| *turn < (end - start) / 20.0);
    let delay = delay::find(pair, recording.longest_delay, turn)?;
    let name = &recording.torque.name;
    let late = Spline::new(name, &torque.times(), &torque.values, LONGEST_GAP)?;
    let mut notes = concerns(&recording.load, &clean_load);
    notes.extend(concerns(&recording.torque, &clean_torque));
    for channel in &recording.others {
        notes.extend(concerns(channel, &cleaned(channel)));
    }
    let holes = [&clean_load, &clean_torque].map(|signal| Holes::of(&time, signal));
    let comb = Comb::new(&raw.0, recording.turn(), recording.speed_spread());
    // Load at random is in both channels and no noise; a disturbance is in both, too, and one.
    let shift = delay.shift();
    let shared = delay.disturbance.is_none();
    let [of_load, of_torque] = [(&raw.0, &raw.1, shift), (&raw.1, &raw.0, -shift)]
        .map(|(signal, other, late)| comb.noise(signal, shared.then_some((other, late))));
    let aligned = Aligned::new(recording, raw, &load, &late, even(&speed), (delay, holes));
    let mut result = aligned.finish([of_load, of_torque], |c| {
        let signal = cleaned(c);
        let values = even(&spline(&c.name, &signal.values)?);
        let noise = comb.noise(&values, None);
        Ok((values.values, Holes::of(&time, &signal), noise))
    })?;
    result.warnings.extend(notes);
    Ok(result)
}

/// Which samples of an even signal lie next to none that is clipped.
fn good(cleaned: &Cleaned, time: &[f64], even: &Even) -> Vec<bool> {
    let near = |t: f64| {
        let next = time.partition_point(|&known| known < t - even.step / 2.0);
        let around = next.saturating_sub(1)..(next + 2).min(time.len());
        !cleaned.clipped[around].contains(&true)
    };
    even.times().into_iter().map(near).collect()
}

/// Concerns about a signal that its reader must know.
fn concerns(channel: &Channel, cleaned: &Cleaned) -> Vec<String> {
    let (name, spikes) = (&channel.name, cleaned.spikes);
    let mut concerns = Vec::new();
    if spikes > 0 {
        concerns.push(format!(
            "{spikes} of {} samples of {name} are spikes and were left out (more than 6 robust standard deviations, and \
             a tenth of the range, from the median of the 7 samples around)",
            cleaned.values.len()
        ));
    }
    if cleaned.clipped_count() > 0 {
        let part = 100.0 * cleaned.clipped_count() as f64 / cleaned.values.len() as f64;
        concerns.push(format!(
            "{name} is clipped: {part:.2} % of its samples stand at an end of the range; they do not count for the \
             delay, but mean and amplitude of {name} lack what was cut off: measure with a wider range"
        ));
    }
    concerns
}

fn check(recording: &RigRecording) -> Result<(), SignalError> {
    let wrong = |text: String| Err(SignalError::Setting(text));
    let (rows, confidence) = (recording.time.len(), recording.confidence);
    for (name, value, unit) in [
        ("bearing's diameter", recording.diameter, "m"),
        ("longest delay", recording.longest_delay, "s"),
    ] {
        if !(value.is_finite() && value > 0.0) {
            return wrong(format!("the {name} must be positive, not {value} {unit}"));
        }
    }
    if !(confidence > 0.5 && confidence < 1.0) {
        return wrong(format!(
            "the confidence must lie between 0.5 and 1, not at {confidence}"
        ));
    }
    let channels = [&recording.load, &recording.torque, &recording.speed];
    let mut channels = channels.into_iter().chain(&recording.others);
    match channels.find(|channel| channel.values.len() != rows) {
        Some(Channel { name, values, .. }) => wrong(format!(
            "signal '{name}' has {} rows, the time has {rows}",
            values.len()
        )),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests;

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
pub mod thin;
pub mod uncertainty;

use aligned::{Aligned, Grid, unsteady};
use clean::Cleaned;
pub use clean::Drop;
use delay::Pair;
use holes::Holes;
pub use recording::{Account, Accuracy, Bearing, Channel, DerivedCriterion, RigRecording, Synchronised};
use signal::{Even, SignalError, Spline};
use spectrum::Comb;
pub use spectrum::Noise;

/// A gap in the record may be this many times as long as a step.
const LONGEST_GAP: f64 = 10.0;

/// A signal that nothing is correlated with may have any gaps, as what lies in them does not count; but with them it has no more
/// samples than memory has room for.
const MOST_SAMPLES: f64 = 1e7;

/// Aligns a recording and derives the criteria.
///
/// # Errors
/// When a setting or a signal does not suit.
pub fn synchronise(recording: &RigRecording) -> Result<Synchronised, SignalError> {
    check(recording)?;
    let mut result = match &recording.bearing {
        Some(bearing) => aligned(recording, bearing)?,
        None => {
            let (findings, concerns): (Vec<_>, Vec<_>) = recording
                .others
                .iter()
                .map(|channel| other(recording, channel, None))
                .collect::<Result<Vec<_>, _>>()?
                .into_iter()
                .unzip();
            let warnings = findings.iter().filter_map(unsteady).collect();
            let doubts = concerns.into_iter().flatten().collect();
            Synchronised { findings, warnings, doubts, ..Synchronised::default() }
        }
    };
    for channel in recording.signals() {
        let (time, values) = channel.within(recording.window());
        let cleaned = channel.clean(&values);
        let told = concerns(channel, &cleaned);
        // What stays and may be none of the signal touches the verdict.
        if channel.drop.is_stated {
            result.warnings.extend(told)
        } else {
            result.doubts.extend(told)
        }
        result.doubts.extend(frozen(channel, &time, &cleaned));
        let early = channel.before(recording.begin());
        let outside = channel.time.len() - time.len() - early;
        let [spikes, clipped] = channel.dropped(&cleaned);
        let lost = [spikes, clipped, (early, recording::EARLY), (outside, "outside of the window")];
        result.accounts.push(channel.account(&lost));
    }
    result.warnings.extend(result.doubts.clone());
    Ok(result)
}

/// The criterion on a signal that nothing else is needed for, at its own rate.
fn other(
    recording: &RigRecording,
    channel: &Channel,
    comb: Option<(&Comb, &Even)>,
) -> Result<(DerivedCriterion, Option<String>), SignalError> {
    let (time, values) = channel.within(recording.window());
    let cleaned = channel.clean(&values);
    let spline = Spline::new(&channel.name, &time, &cleaned.values, f64::INFINITY)?;
    let ((start, end), step) = (spline.span(), spline.step());
    let holes = Holes::of(&time, &cleaned);
    if let Some([from, to]) = holes.longest().filter(|_| (end - start) / step > MOST_SAMPLES) {
        return Err(SignalError::Gap { name: channel.name.clone(), from, to });
    }
    let even = Even::from_spline(&spline, start, end, step);
    let samples = even.values.len();
    let comb = comb.filter(|(_, load)| load.values.len() == samples && (load.step / step - 1.0).abs() < 1e-3);
    let noise = match comb {
        Some((comb, _)) => comb.noise(&even, None),
        None => Noise::by_rows(&cleaned.values),
    };
    Ok(Grid::new(recording, [start, step], samples).mean_of(channel, &even.values, &holes, noise))
}

/// Load and torque, aligned, and all criteria.
fn aligned(recording: &RigRecording, bearing: &Bearing) -> Result<Synchronised, SignalError> {
    let cleaned = |channel: &Channel| {
        let (time, values) = channel.within(recording.window());
        (time, channel.clean(&values))
    };
    let spline = |name: &str, time: &[f64], values: &[f64]| Spline::new(name, time, values, LONGEST_GAP);
    let [(load_time, clean_load), (torque_time, clean_torque)] = [&bearing.load, &bearing.torque].map(cleaned);
    let load = spline(&bearing.load.name, &load_time, &clean_load.values)?;
    let torque = spline(&bearing.torque.name, &torque_time, &clean_torque.values)?;
    let start = load.span().0.max(torque.span().0);
    let end = load.span().1.min(torque.span().1);
    let step = load.step();
    if end - start < 8.0 * step {
        return Err(SignalError::Setting(
            "load and torque have no time in common: correct the `offset` of a file's time".into(),
        ));
    }
    let even = |spline: &Spline| Even::from_spline(spline, start, end, step);
    let smooth = |raw: &Even| {
        let values = bearing.smoothing.apply(&raw.values, step)?;
        Ok::<_, SignalError>(Even { values, ..*raw })
    };
    let raw = (even(&load), even(&torque));
    let (load, torque) = (smooth(&raw.0)?, smooth(&raw.1)?);
    if load.values.contains(&0.0) {
        return Err(SignalError::Setting("the load passes through zero: M/F_N has no meaning there".into()));
    }
    let pair = Pair {
        load: &load,
        torque: &torque,
        load_good: &good(&clean_load, &load_time, &load),
        torque_good: &good(&clean_torque, &torque_time, &load),
    };
    let turn = recording.turn().filter(|turn| *turn < (end - start) / 20.0);
    let delay = delay::find(pair, bearing.longest_delay, turn)?;
    let late = Spline::new(&bearing.torque.name, &torque.times(), &torque.values, LONGEST_GAP)?;
    let holes = [Holes::of(&load_time, &clean_load), Holes::of(&torque_time, &clean_torque)];
    let comb = Comb::new(&raw.0, recording.turn(), recording.speed_spread());
    // Load at random is in both channels and no noise; a disturbance is in both, too, and one.
    let shift = delay.shift();
    let shared = delay.disturbance.is_none();
    let [of_load, of_torque] = [(&raw.0, &raw.1, shift), (&raw.1, &raw.0, -shift)]
        .map(|(signal, other, late)| comb.noise(signal, shared.then_some((other, late))));
    let grid = raw.0.clone();
    Aligned::new((recording, bearing), raw, &load, &late, (delay, holes))
        .finish([of_load, of_torque], |channel| other(recording, channel, Some((&comb, &grid))))
}

/// Which samples of an even signal lie next to none that is clipped.
fn good(cleaned: &Cleaned, time: &[f64], even: &Even) -> Vec<bool> {
    even.times()
        .into_iter()
        .map(|t| {
            let next = time.partition_point(|&known| known < t - even.step / 2.0);
            let around = next.saturating_sub(1)..(next + 2).min(time.len());
            !cleaned.clipped[around].contains(&true)
        })
        .collect()
}

/// Concerns about a signal that its reader must know.
fn concerns(channel: &Channel, cleaned: &Cleaned) -> Vec<String> {
    let Channel { name, drop, .. } = channel;
    let all = cleaned.values.len();
    let fate = |word: &str, dropped: bool| match (drop.is_stated, dropped) {
        (_, true) => "they were left out, as the settings say".to_owned(),
        (true, false) => "they count, as the settings say".to_owned(),
        (false, false) => {
            format!("they count: `drop = [\"{word}\"]` leaves them out, `drop = []` says that they are right")
        }
    };
    let mut concerns: Vec<String> = cleaned.marks.iter().map(|(mark, count)| format!(
        "{count} of {all} samples of {name} stand at {mark}, far from all others, and count: where that marks missing values, write \
         `missing = [{mark}]`"
    )).collect();
    if cleaned.spikes > 0 {
        concerns.push(format!(
            "{} of {all} samples of {name} look like spikes (more than 6 robust standard deviations, and a tenth of the range, from \
             the median of the 7 samples around); {}",
            cleaned.spikes,
            fate("spikes", drop.spikes)
        ));
    }
    let clipped = cleaned.clipped_count();
    if clipped > 0 {
        concerns.push(format!(
            "{clipped} of {all} samples of {name} stand at an end of its range, as where a sensor is clipped (or the signal rests); \
             they do not count for the delay; {}",
            fate("clipped", drop.clipped)
        ));
    }
    concerns
}

/// Warns of samples in a row at one value, where the signal changes from sample to sample elsewhere.
fn frozen(channel: &Channel, time: &[f64], cleaned: &Cleaned) -> Option<String> {
    const FEWEST: usize = 20;
    const TIMES: usize = 20;
    let values = &cleaned.values;
    let places: Vec<usize> = (0..values.len()).collect();
    let runs = || places.chunk_by(|a, b| values[*a] == values[*b]);
    let longest = runs().max_by_key(|run| run.len())?;
    let elsewhere = (values.len() - longest.len()) / (runs().count() - 1).max(1);
    let [from, to] = [longest[0], longest[longest.len() - 1]];
    let is_frozen = longest.len() >= FEWEST.max(TIMES * elsewhere) && from + values.len() > to + 1;
    (is_frozen && elsewhere > 0 && !cleaned.clipped[from]).then(|| {
        format!(
            "{} stands at {}{} for {} samples, from {:.3} s to {:.3} s, and changes all the time elsewhere: where the sensor or the \
             logger hung, leave these cells empty, or give a `window`",
            channel.name,
            values[from],
            recording::behind(&channel.unit),
            longest.len(),
            time[from],
            time[to]
        )
    })
}

fn check(recording: &RigRecording) -> Result<(), SignalError> {
    let wrong = |text| Err(SignalError::Setting(text));
    let confidence = recording.confidence;
    let lengths = recording.bearing.iter().flat_map(|bearing| {
        [("bearing's diameter", bearing.diameter, "m"), ("longest delay", bearing.longest_delay, "s")]
    });
    for (name, value, unit) in lengths {
        if !(value.is_finite() && value > 0.0) {
            return wrong(format!("the {name} must be positive, not {value} {unit}"));
        }
    }
    if !(confidence > 0.5 && confidence < 1.0) {
        return wrong(format!("the confidence must lie between 0.5 and 1, not at {confidence}"));
    }
    if let Some([from, to]) = recording.window.filter(|[from, to]| from >= to) {
        return wrong(format!("window: it ends at {to} s and begins at {from} s; write the begin first"));
    }
    for channel in recording.signals() {
        let Channel { name, time, values, .. } = channel;
        if time.len() != values.len() {
            return wrong(format!("signal '{name}' has {} rows, its time has {}", values.len(), time.len()));
        }
        in_order(name, time)?;
        let [Some(first), Some(last)] = [time.first(), time.last()] else {
            let lost = channel.account(&[]);
            return wrong(format!("no row of the column has a number ({lost}); name another column"));
        };
        let [from, to] = recording.window();
        if from > *last || to < *first {
            return wrong(format!(
                "window: it is from {from} s to {to} s, and signal '{name}' from {first:.3} s to {last:.3} s; correct the window"
            ));
        }
    }
    Ok(())
}

/// Refuses times that do not grow. Whoever read the recording has said what may be done about that.
fn in_order(name: &str, time: &[f64]) -> Result<(), SignalError> {
    match time.windows(2).find(|pair| pair[1] <= pair[0]) {
        Some(pair) => Err(SignalError::Unsorted { name: name.to_owned(), time: pair[1] }),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests;

use super::*;
use rand::{RngExt, SeedableRng, rngs::StdRng};
use rand_distr::StandardNormal;
use std::f64::consts::TAU;

const ALL: Drop = Drop { is_stated: true, spikes: true, clipped: false };

fn signal(noise: f64) -> Vec<f64> {
    let mut random = StdRng::seed_from_u64(3);
    let wave = |k: u32| 1.0 + 0.6 * (TAU * f64::from(k) / 40.0).sin();
    (0..4000).map(|k| wave(k) + noise * random.sample::<f64, _>(StandardNormal)).collect()
}

#[test]
fn a_clean_signal_stays() {
    for noise in [0.0, 0.001, 0.05, 0.2] {
        let values = signal(noise);
        let cleaned = clean(&values, ALL);
        assert_eq!((cleaned.spikes, cleaned.clipped_count()), (0, 0), "{noise}");
        assert_eq!(cleaned.values, values);
    }
    // Steps are no spikes, and a constant has neither spikes nor a range.
    let steps: Vec<f64> = (0..400).map(|k| f64::from(k / 20 % 2) + 0.01 * f64::from(k % 7)).collect();
    assert_eq!(clean(&steps, ALL).spikes, 0);
    assert_eq!(clean(&[3.0; 50], ALL).clipped_count(), 0);
    // A turn of whole samples repeats its peaks exactly.
    let coarse: Vec<f64> = signal(0.0).iter().map(|v| (v * 50.0).round() / 50.0).collect();
    assert_eq!(clean(&coarse, ALL).clipped_count(), 0);
}

#[test]
fn spikes_are_left_out() {
    let mut values = signal(0.05);
    for place in [1, 100, 101, 102, 1500, 3998] {
        values[place] += 4.0;
    }
    values[700] = -5.0;
    values[800] = f64::NAN;
    let cleaned = clean(&values, ALL);
    assert_eq!(cleaned.spikes, 7);
    let missing = cleaned.values.iter().filter(|v| v.is_nan()).count();
    assert_eq!(missing, 8);
    assert!(cleaned.values[101].is_nan() && cleaned.values[700].is_nan());
}

/// A mark in the first rows is no spike for want of neighbours; standstill and plateau stay, too.
#[test]
fn nothing_goes_that_was_not_asked_for() {
    let mut values = signal(0.05);
    values[0] = -9999.0;
    values[3999] = -9999.0;
    values[700] = 9.0;
    values[2000..2400].fill(2.0);
    let cleaned = clean(&values, Drop::default());
    assert_eq!(cleaned.values, values);
    assert_eq!((cleaned.spikes, cleaned.clipped_count()), (1, 400));
    assert_eq!(cleaned.marks, [(-9999.0, 2)]);
    let dropped = clean(&values, Drop { is_stated: true, spikes: true, clipped: true });
    assert_eq!(dropped.values.iter().filter(|value| value.is_nan()).count(), 401);
}

/// The fastest of these tones has eight samples a turn: its peaks are far from the median around them.
#[test]
fn peaks_of_a_quick_signal_are_no_spikes() {
    for seed in 0..10 {
        let mut random = StdRng::seed_from_u64(seed);
        let tones: Vec<[f64; 2]> =
            (0..40).map(|_| [random.random_range(0.5..30.0), random.random_range(0.0..TAU)]).collect();
        let at = |k: u32| {
            let time = f64::from(k) / 250.0;
            tones.iter().map(|[frequency, phase]| (TAU * frequency * time + phase).sin()).sum::<f64>()
        };
        let mut values: Vec<f64> = (0..3000).map(at).collect();
        assert_eq!(clean(&values, ALL).spikes, 0, "seed {seed}");
        for place in [500, 1200, 1201, 2500] {
            values[place] += 60.0;
        }
        let cleaned = clean(&values, ALL);
        assert_eq!(cleaned.spikes, 4, "seed {seed}");
        assert!(cleaned.values[1201].is_nan());
    }
}

#[test]
fn a_run_of_marks_is_told() {
    let mut values = signal(0.05);
    values[2000..2040].fill(-9999.0);
    let cleaned = clean(&values, ALL);
    assert_eq!((&cleaned.marks[..], cleaned.spikes, cleaned.clipped_count()), (&[(-9999.0, 40)][..], 0, 0));
    // It is told, and stays: `missing` says that it is none.
    assert_eq!(cleaned.values, values);
    // Two loggers, and an overflow.
    values[100..120].fill(-7999.0);
    values[3000..3010].fill(9.9e37);
    assert_eq!(clean(&values, ALL).marks, [(9.9e37, 10), (-9999.0, 40), (-7999.0, 20)]);
    // What rests for long is a level of its own; a value that cannot be meant is none.
    let rests = |level| {
        let mut values = signal(0.05);
        values[2000..2900].fill(level);
        clean(&values, ALL).marks
    };
    assert!(rests(-8.0).is_empty() && rests(0.0).is_empty());
    assert_eq!(rests(-9999.0), [(-9999.0, 900)]);
    // In a few rows, too.
    let few = [20.1, 20.3, -127.0, 20.2, 20.4, 20.1, -127.0, 20.0, 20.2, 20.3, 20.1, 20.2];
    assert_eq!(clean(&few, ALL).marks, [(-127.0, 2)]);
}

#[test]
fn clipped_samples_are_known_at_either_end() {
    for sign in [1.0, -1.0] {
        let values: Vec<f64> = signal(0.05).iter().map(|v| sign * v.min(1.45)).collect();
        let cleaned = clean(&values, ALL);
        let expected = values.iter().filter(|&&v| v == sign * 1.45).count();
        assert!(expected > 400);
        assert_eq!((cleaned.clipped_count(), cleaned.spikes), (expected, 0));
    }
}

/// A kind of signal without spikes, by a generator: 2,000 samples with a range of about 1 or 2.
type Kind = fn(&mut StdRng) -> Vec<f64>;

const ROWS: usize = 2000;

fn noise(random: &mut StdRng) -> f64 {
    random.sample(StandardNormal)
}

/// With noise of one of these shares of its size.
fn with_noise(values: impl Iterator<Item = f64>, random: &mut StdRng) -> Vec<f64> {
    let size = [0.0, 0.001, 0.005, 0.02][random.random_range(0..4)];
    let values: Vec<f64> = values.collect();
    values.iter().map(|value| value + size * noise(random)).collect()
}

fn decaying(random: &mut StdRng) -> Vec<f64> {
    let (period, decay) = (random.random_range(8.0..60.0), 10.0_f64.powf(random.random_range(1.0..3.0)));
    let phase = random.random_range(0.0..TAU);
    let swing = |k: usize| (-(k as f64) / decay).exp() * (TAU * k as f64 / period + phase).sin();
    with_noise((0..ROWS).map(swing), random)
}

fn chirp(random: &mut StdRng) -> Vec<f64> {
    let ends = [random.random_range(60.0..400.0), random.random_range(8.0..20.0)];
    let phase = random.random_range(0.0..TAU);
    let angle = |k: usize| {
        let (k, rows) = (k as f64, ROWS as f64);
        k / ends[0] + 0.5 * (1.0 / ends[1] - 1.0 / ends[0]) * k * k / rows
    };
    with_noise((0..ROWS).map(|k| (TAU * angle(k) + phase).sin()), random)
}

/// Levels of random heights or of two, each taken with a swing that decays.
fn ringing(random: &mut StdRng) -> Vec<f64> {
    let (period, damping) = (random.random_range(8.0..40.0), random.random_range(0.05..0.6));
    let hold = random.random_range(60..400);
    let two = random.random::<bool>();
    let [speed, decay] = [TAU / period, damping * TAU / period];
    let (mut before, mut level, mut values) = (0.0, 0.0, Vec::new());
    for k in 0..ROWS {
        if k % hold == hold / 2 {
            before = level;
            level = if two { 1.0 - level } else { random.random_range(-1.0..1.0) };
        }
        let since = ((k + hold - hold / 2) % hold) as f64 + random.random_range(0.0..1e-9);
        let swing = (-decay * since).exp() * ((speed * since).cos() + decay / speed * (speed * since).sin());
        values.push(level + (before - level) * swing);
    }
    with_noise(values.into_iter(), random)
}

fn triangles(random: &mut StdRng) -> Vec<f64> {
    let period = random.random_range(16.0..200.0);
    let values = (0..ROWS).map(|k| 4.0 * ((k as f64 / period).fract() - 0.5).abs() - 1.0);
    with_noise(values, random)
}

/// Levels that are held for random times, two of them (as of pulses) or any.
fn levels(random: &mut StdRng) -> Vec<f64> {
    let two = random.random::<bool>();
    let mut values: Vec<f64> = Vec::new();
    while values.len() < ROWS {
        let level = if two { 1.0 - values.last().map_or(0.0, |last| *last) } else { random.random_range(-1.0..1.0) };
        let held = random.random_range(4..40);
        values.extend(vec![level; held]);
    }
    values.truncate(ROWS);
    with_noise(values.into_iter(), random)
}

fn quantised(random: &mut StdRng) -> Vec<f64> {
    let (period, size) = (random.random_range(300.0..5000.0), random.random_range(1.0..30.0));
    let flicker = random.random_range(0.0..0.5);
    let phase = random.random_range(0.0..TAU);
    let at = |k: usize| size * (TAU * k as f64 / period + phase).sin() + flicker * noise(random);
    (0..ROWS).map(at).map(|value| 0.05 * value.round()).collect()
}

/// Slow rises with quick slips of a few samples.
fn stick_slip(random: &mut StdRng) -> Vec<f64> {
    let mut values = Vec::new();
    while values.len() < ROWS {
        let (stick, slip) = (random.random_range(20..100), random.random_range(1..5));
        values.extend((0..stick).map(|k| k as f64 / stick as f64));
        values.extend((1..slip).map(|k| 1.0 - k as f64 / slip as f64));
    }
    values.truncate(ROWS);
    with_noise(values.into_iter(), random)
}

/// A pulse of at least four samples at half its height every so often, with slow waves.
fn heart(random: &mut StdRng) -> Vec<f64> {
    let (width, every) = (random.random_range(4.0..8.0), random.random_range(40.0..100.0));
    let at = |k: usize| {
        let since = ((k as f64 / every).fract() - 0.5) * every;
        let pulse = |place: f64, width: f64| (-4.0 * 2.0_f64.ln() * ((since - place) / width).powi(2)).exp();
        pulse(0.0, width) + 0.15 * pulse(-0.25 * every, 0.15 * every) - 0.1 * pulse(1.1 * width, width)
    };
    with_noise((0..ROWS).map(at), random)
}

const KINDS: [(&str, Kind); 8] = [
    ("decaying", decaying),
    ("chirp", chirp),
    ("ringing", ringing),
    ("triangles", triangles),
    ("levels", levels),
    ("quantised", quantised),
    ("stick-slip", stick_slip),
    ("heart", heart),
];

/// One signal in a hundred may have spikes where a quick edge stands in noise of 2 % of the range. Without a look at neighbours
/// it would be a quarter to all of them.
#[test]
fn signals_of_many_kinds_have_no_spikes() {
    without_spikes(30);
}

#[test]
#[ignore = "takes a while: scripts/test --long"]
fn a_hundred_signals_of_each_kind_have_no_spikes() {
    without_spikes(100);
}

fn without_spikes(seeds: u64) {
    for (name, kind) in KINDS {
        let spikes = |seed: &u64| clean(&kind(&mut StdRng::seed_from_u64(*seed)), ALL).spikes > 0;
        let wrong: Vec<u64> = (0..seeds).filter(spikes).collect();
        let most = match name {
            "decaying" | "stick-slip" | "heart" => seeds.div_ceil(50) as usize,
            _ => 0,
        };
        assert!(wrong.len() <= most, "{name}: {wrong:?}");
    }
}

/// Single samples and two or three side by side, of 12 to 50 standard deviations of the noise and at least a fifth of the range:
/// 99 of 100 are found, and next to nothing else.
#[test]
fn spikes_are_found_in_noise_sines_and_ramps() {
    for (name, range) in [("noise", 3.3), ("sine", 1.97), ("ramp", 0.9)] {
        let (mut all, mut found, mut others) = (0, 0, 0);
        for seed in 0..60 {
            let mut random = StdRng::seed_from_u64(seed);
            let period = random.random_range(120.0..400.0);
            let deviation = match name {
                "noise" => 1.0,
                _ => [0.0, 0.002, 0.01, 0.05][seed as usize % 4],
            };
            let smooth = |k: usize| match name {
                "noise" => 0.0,
                "sine" => (TAU * k as f64 / period).sin(),
                _ => k as f64 / ROWS as f64,
            };
            let mut values: Vec<f64> = (0..ROWS).map(|k| smooth(k) + deviation * noise(&mut random)).collect();
            let mut spikes = vec![false; ROWS];
            for place in (50..ROWS - 50).step_by(150) {
                let height = (deviation * random.random_range(12.0..50.0)).max(0.2 * range);
                let sign = [1.0, -1.0][random.random_range(0..2)];
                for k in place..place + random.random_range(1..4) {
                    values[k] += sign * height;
                    spikes[k] = true;
                }
            }
            for (value, spike) in clean(&values, ALL).values.iter().zip(spikes) {
                all += usize::from(spike);
                found += usize::from(spike && value.is_nan());
                others += usize::from(!spike && value.is_nan());
            }
        }
        assert!(all > 1500 && 100 * found >= 99 * all, "{name}: {found} of {all}");
        assert!(500 * others <= all, "{name}: {others} others");
    }
}

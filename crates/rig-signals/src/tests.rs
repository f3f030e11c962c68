use super::{smooth::Smoothing, *};
use rand::{RngExt, SeedableRng, rngs::StdRng};
use rand_distr::StandardNormal;
use std::f64::consts::TAU;

fn channel(name: &str, variable: &str, unit: &str, accuracy: Accuracy, values: Vec<f64>) -> Channel {
    Channel {
        name: name.into(),
        variable: variable.into(),
        unit: unit.into(),
        time: (0..values.len()).map(|k| k as f64 * 1e-3).collect(),
        values,
        clock: 0,
        lost: Vec::new(),
        drop: Drop { is_stated: true, spikes: true, clipped: false },
        accuracy,
        group: None,
    }
}

fn bearing(recording: &mut RigRecording) -> &mut Bearing {
    recording.bearing.as_mut().unwrap()
}

/// 30 s at 300 rpm with the torque 16 ms late and a friction coefficient of 0.0472; `creep` K of
/// the oil over the record.
fn recording(creep: f64) -> RigRecording {
    let mut random = StdRng::seed_from_u64(11);
    let mut noise = || random.sample::<f64, _>(StandardNormal);
    let time: Vec<f64> = (0..30_000).map(|k| f64::from(k) * 1e-3).collect();
    let force = |t: f64| 750.0 * (1.0 + 0.5 * (TAU * 5.0 * t).sin());
    let load = time.iter().map(|t| force(*t) + 10.0 * noise()).collect();
    let torque = time.iter().map(|t| 0.0472 * 0.0125 * force(t - 0.016) + 0.005 * noise()).collect();
    let oil = time.iter().map(|t| 48.0 + creep * (t / 30.0 - 0.5) + 0.1 * noise()).collect();
    RigRecording {
        bearing: Some(Bearing {
            load: channel("F_N", "sensor.loadForce", "N", Accuracy::Relative(0.01), load),
            torque: channel("M", "sensor.frictionTorque", "N.m", Accuracy::Relative(0.02), torque),
            speed: channel("speed", "drive.speed", "rad/s", Accuracy::Relative(0.005), vec![TAU * 5.0; 30_000]),
            diameter: 0.025,
            smoothing: Smoothing::Butterworth { cutoff: 60.0, order: 4 },
            longest_delay: 0.05,
        }),
        others: vec![channel("T_oil", "sensor.oilTemperature", "degC", Accuracy::Absolute(0.5), oil)],
        window: None,
        start: None,
        confidence: 0.99,
    }
}

#[test]
fn a_record_becomes_criteria() {
    let s = synchronise(&recording(0.0)).unwrap();
    assert!((s.delay.shift() - 0.016).abs() < 1e-4, "{:?}", s.delay);
    assert!(s.warnings.is_empty(), "{:?}", s.warnings);
    let [load, torque, oil] = s.findings.as_slice() else { panic!("{:?}", s.findings) };
    assert!((load.measured.value - 750.0).abs() < 1.0);
    assert!((torque.measured.value - 0.4425).abs() < 1e-3);
    assert!((oil.measured.value - 48.0).abs() < 0.01);
    assert!((s.mean_friction.value - 0.0472).abs() < 1e-4);
    // 2 % bound of torque and 1 % of load, rectangular.
    let relative = (0.02f64.hypot(0.01)) / 3f64.sqrt();
    assert!((s.mean_friction.sensor / s.mean_friction.value - relative).abs() < 1e-9);
    assert!((oil.measured.expanded() - 2.0 * 0.5 / 3f64.sqrt()).abs() < 0.01);
}

#[test]
fn a_creeping_temperature_is_reported() {
    let s = synchronise(&recording(0.2)).unwrap();
    assert_eq!(s.warnings.len(), 1, "{:?}", s.warnings);
    assert!(s.warnings[0].starts_with("T_oil is drifting"), "{:?}", s.warnings);
    let oil = s.findings.iter().find(|f| f.name == "T_oil").unwrap();
    assert!(oil.stationarity.as_ref().unwrap().change.contains(0.2));
}

#[test]
fn the_window_is_used_and_wrong_settings_are_named() {
    let mut r = recording(0.0);
    r.window = Some([5.0, 20.0]);
    let s = synchronise(&r).unwrap();
    assert!(s.time[0] >= 5.0 && *s.time.last().unwrap() <= 20.0);
    bearing(&mut r).diameter = -0.025;
    assert!(synchronise(&r).unwrap_err().to_string().contains("diameter"));
    let mut r = recording(0.0);
    bearing(&mut r).torque.values.pop();
    assert!(synchronise(&r).unwrap_err().to_string().contains("'M' has 29999 rows, its time has 30000"));
}

#[test]
fn the_text_is_a_table_of_criteria() {
    let text = criteria::to_toml(&synchronise(&recording(0.0)).unwrap());
    let lines: Vec<&str> = text.lines().filter(|l| l.starts_with('[')).collect();
    assert_eq!(lines, ["[criteria.F_N]", "[criteria.M]", "[criteria.T_oil]"]);
    assert!(text.contains("torque shifted by 1"), "{text}");
}

/// 0.5 % of the samples far off, and the load cut off at the top: the delay stays, and both are said.
#[test]
fn spikes_and_clipping_are_said_and_do_not_move_the_delay() {
    let mut r = recording(0.0);
    let mut random = StdRng::seed_from_u64(5);
    for k in 0..30_000 {
        let b = bearing(&mut r);
        b.load.values[k] = b.load.values[k].min(1050.0);
        if random.random::<f64>() < 0.005 {
            b.torque.values[k] += 4.0;
        }
    }
    let s = synchronise(&r).unwrap();
    assert!((s.delay.shift() - 0.016).abs() < 2e-4, "{:?}", s.delay.delay);
    let said = s.warnings.join("\n");
    assert!(said.contains("samples of M look like spikes"), "{said}");
    assert!(said.contains("samples of F_N stand at an end of its range"), "{said}");
}

/// Nine samples are lost around the peak of every tenth turn. A curve through the rest is no measurement: these turns do
/// not count, so the means are those of the whole turns that are left, by the record's own closed form.
#[test]
fn turns_with_a_gap_do_not_count_in_the_mean() {
    let mut r = recording(0.0);
    for k in (0..30_000).step_by(2000) {
        bearing(&mut r).load.values[k + 46..k + 55].fill(f64::NAN);
        // The oil is told to be hot where the samples are missing: a curve through its gap would be, too.
        // (The spike is cut out, which makes the gap longer.)
        r.others[0].values[k + 45] = 48.6;
        r.others[0].values[k + 46..k + 53].fill(f64::NAN);
    }
    let s = synchronise(&r).unwrap();
    let said = s.warnings.join("\n");
    assert!(said.contains("15 of 149 turns of F_N lie in gaps"), "{said}");
    assert!(said.contains("turns of T_oil lie in gaps"), "{said}");
    let [load, _, oil, ..] = s.findings.as_slice() else { panic!("{:?}", s.findings) };
    // Noise of 10 N in 26,800 samples leaves 0.06 N, noise of 0.1 K 0.0006 K.
    assert!((load.measured.value - 750.0).abs() < 0.25, "{load:?}");
    assert!((oil.measured.value - 48.0).abs() < 0.003, "{oil:?}");
}

#[test]
fn signals_that_are_not_related_are_not_shifted() {
    let mut r = recording(0.0);
    let mut random = StdRng::seed_from_u64(6);
    let noise = bearing(&mut r).torque.values.iter_mut();
    noise.for_each(|m| *m = 0.44 + 0.02 * random.sample::<f64, _>(StandardNormal));
    let s = synchronise(&r).unwrap();
    assert_eq!(s.delay.delay, None);
    assert!(s.warnings[0].contains("not related"), "{:?}", s.warnings);
    assert!(criteria::to_toml(&s).contains("torque not shifted"));
}

/// Noise of a known size: white, and of the first order with a memory of 0.6 from row to row. A fit of the load's line from
/// rows with the second one knows as much as from rows with an independent noise of the density at the line.
#[test]
fn the_noise_of_a_row_is_what_was_put_in() {
    let turn = TAU * 5.0 * 0.01;
    for memory in [0.0, 0.6_f64] {
        let density = (1.0 - memory * memory) / (1.0 - 2.0 * memory * turn.cos() + memory * memory);
        let (mut ratios, mut correlations, mut whites) = (Vec::new(), Vec::new(), Vec::new());
        for seed in 0..20 {
            let mut r = recording(0.0);
            let mut random = StdRng::seed_from_u64(seed);
            let mut next = || random.sample::<f64, _>(StandardNormal);
            let fresh = (1.0 - memory * memory).sqrt();
            let mut noise = |size: f64| {
                let mut last = next();
                move |next: f64| {
                    last = memory * last + fresh * next;
                    size * last
                }
            };
            let (mut of_load, mut of_torque) = (noise(4.0), noise(0.004));
            let time: Vec<f64> = (0..600).map(|k| f64::from(k) * 0.01).collect();
            r.others[0].time.clone_from(&time);
            let b = bearing(&mut r);
            b.speed.values.truncate(600);
            for channel in [&mut b.load, &mut b.torque, &mut b.speed] {
                channel.time.clone_from(&time);
            }
            // The shaft slows down by 1 %.
            let at = |t: f64| 750.0 * (1.0 + 0.5 * (TAU * 5.0 * t * (1.0 - t / 1200.0)).sin());
            let signal = |of: &dyn Fn(f64) -> f64| time.iter().map(|t| of(*t)).collect::<Vec<_>>();
            let (load, torque) = (signal(&at), signal(&|t| 0.00059 * at(t - 0.017)));
            b.load.values = load.iter().map(|f| f + of_load(next())).collect();
            b.torque.values = torque.iter().map(|m| m + of_torque(next())).collect();
            b.load.values[250] = f64::NAN;
            b.torque.values[401] = f64::NAN;
            b.smoothing = Smoothing::Butterworth { cutoff: 30.0, order: 4 };
            r.others[0].values = (0..600).map(|k| 48.0 + 1e-3 * f64::from(k) + 0.05 * next()).collect();
            r.others[0].values[120] = f64::NAN;
            let s = synchronise(&r).unwrap();
            let of = |name: &str| s.findings.iter().find(|f| f.name == name).unwrap().noise.unwrap();
            for (name, size) in [("F_N", 4.0), ("M", 0.004)] {
                let noise = of(name);
                assert!((noise.row / size - 1.0).abs() < 0.25, "{name} {seed} {memory}: {noise:?}");
                // Noise of each row's own is told by many more bins than those around a line.
                if memory == 0.0 {
                    let ratio = noise.stated() / size;
                    assert!(!noise.is_shared() && (0.85..1.15).contains(&ratio), "{name} {seed}: {noise:?}");
                }
                ratios.push(noise.stated() / (size * density.sqrt()));
            }
            if memory == 0.0 {
                let sizes = [("F_N", 4.0), ("M", 0.004), ("T_oil", 0.05)];
                whites.extend(sizes.map(|(name, size)| of(name).row / size));
            }
            correlations.push(of("F_N").correlation);
            let ratio = of("T_oil").stated() / 0.05;
            assert!((0.8..1.25).contains(&ratio), "T_oil {seed}: {ratio}");
        }
        let mean = sampling::statistics::moments::mean;
        let (correlation, middle) = (mean(&correlations), mean(&ratios));
        assert!((correlation - memory).abs() < 0.06, "{memory}: {correlation}");
        // A sample is missing in each channel. No bias: 60 estimates of 6 % have a mean of 1 %.
        let bias = if whites.is_empty() { 0.0 } else { mean(&whites) - 1.0 };
        assert!(bias.abs() < 0.025, "{bias}");
        assert!((0.95..1.15).contains(&middle), "{memory}: {middle} {ratios:?}");
        // The dozen independent bins around a line of 30 turns tell its noise to 20 %.
        assert!(ratios.iter().all(|ratio| (0.4..1.8).contains(ratio)), "{memory}: {ratios:?}");
    }
}

/// Twenty combinations of rates and gaps, of signals without load and torque: what goes in is used or told, in criteria and
/// case, and the slow channels' means are right.
#[test]
fn every_row_is_used_or_told() {
    let mut random = StdRng::seed_from_u64(9);
    for combination in 0..20_usize {
        let rates = [250.0, [10.0, 100.0, 7.3, 250.0, 1.0][combination % 5]];
        let gap = [0, 1, 50, 5000][combination / 5];
        let mut signal = |name: &str, rate: f64, clock: usize, start: f64| {
            let count = (20.0 * rate) as usize;
            let time: Vec<f64> = (0..count).map(|k| start + k as f64 / rate).collect();
            let value = |time: &f64| 80.0 + time.sin() + 0.01 * random.sample::<f64, _>(StandardNormal);
            let mut values: Vec<f64> = time.iter().map(value).collect();
            values[count / 2] += 50.0;
            let gone = count / 4..(count / 4 + gap).min(count / 3);
            let kept: Vec<usize> = (0..count).filter(|k| !gone.contains(k)).collect();
            let mut channel = channel(name, name, "degC", Accuracy::Absolute(0.1), values);
            channel.values = kept.iter().map(|&k| channel.values[k]).collect();
            channel.time = kept.iter().map(|&k| time[k]).collect();
            channel.lost = vec![(count - kept.len(), "empty")];
            channel.clock = clock;
            (channel, count)
        };
        let (fast, slow) = (signal("fast", rates[0], 0, 0.0), signal("slow", rates[1], combination % 2, 0.5));
        let (drive, _) = signal("n", 250.0, 0, 0.0);
        let counts = [fast.1, slow.1];
        let recording = RigRecording {
            bearing: None,
            others: vec![fast.0, slow.0],
            window: (combination % 3 == 0).then_some([2.0, 18.0]),
            start: None,
            confidence: 0.99,
        };
        let result = synchronise(&recording).unwrap();
        let drives = [case::Drive {
            variable: "drive".into(),
            unit: "degC".into(),
            tolerance: None,
            values: case::Driven::Recorded(drive),
        }];
        let case = case::Case::new(&recording, &result, &drives);
        let files = case.tables();
        for (accounts, of_case) in [(&result.accounts, false), (&case.accounts(), true)] {
            for (account, count) in accounts.iter().zip(counts) {
                let told: usize = account.lost.iter().map(|(count, _)| count).sum();
                assert_eq!((account.rows, account.used + told), (count, count), "{combination} {account}");
                if of_case {
                    let is_its = |(_, text): &&(String, String)| text.lines().next().unwrap().contains(&account.name);
                    let rows = files.iter().find(is_its).unwrap().1.lines().count() - 1;
                    assert_eq!(rows, account.used, "{combination} {account}");
                    // A spike and the gap, and what lies beside them, and no more.
                    assert!(told <= 2 * (gap + 3), "{combination} {account}");
                }
            }
        }
        for finding in &result.findings {
            assert!((finding.measured.value - 80.0).abs() < 0.15, "{combination} {finding:?}");
        }
        assert!(files.last().unwrap().1.lines().count() < 600, "{combination}");
    }
}

/// A recording of one noisy temperature of 60 s, and a drive with these samples.
fn with_drive(time: Vec<f64>, values: Vec<f64>) -> (RigRecording, [case::Drive; 1]) {
    let mut random = StdRng::seed_from_u64(4);
    let oil = (0..6000).map(|k| 50.0 + (f64::from(k) / 900.0).sin() + random.sample::<f64, _>(StandardNormal));
    let mut signal = channel("T", "T", "degC", Accuracy::Absolute(0.5), oil.collect());
    signal.time.iter_mut().for_each(|time| *time *= 10.0);
    let drive = channel("n", "n", "rpm", Accuracy::Absolute(2.0), values);
    let recording = RigRecording { bearing: None, others: vec![signal], window: None, start: None, confidence: 0.99 };
    let drive = case::Drive {
        variable: "n".into(),
        unit: "rpm".into(),
        tolerance: None,
        values: case::Driven::Recorded(Channel { time, ..drive }),
    };
    (recording, [drive])
}

fn frame() -> case::Frame<'static> {
    case::Frame { name: "c", held_out: false, folder: "f", tolerances: &[], lag: 0.0 }
}

#[test]
fn the_accuracy_of_an_input_becomes_its_uncertainty() {
    for (accuracy, key) in [
        (Accuracy::Absolute(2.0), "unit = \"rpm\", uncertainty = \"2.3094e0 rpm\""),
        (Accuracy::Relative(0.01), "unit = \"rpm\", gain-uncertainty = \"1.1547 %\""),
    ] {
        let time: Vec<f64> = (0..6000).map(|k| f64::from(k) / 100.0).collect();
        let speed = time.iter().map(|time| 1500.0 + 50.0 * time.sin()).collect();
        let (recording, mut drives) = with_drive(time, speed);
        if let case::Driven::Recorded(channel) = &mut drives[0].values {
            channel.accuracy = accuracy;
        }
        let text = case::Case::new(&recording, &synchronise(&recording).unwrap(), &drives).to_toml(&frame());
        assert!(text.contains(key), "{text}");
    }
}

#[test]
fn spikes_and_holes_of_inputs_are_told() {
    let time = |from: usize| (from..6000).map(|k| k as f64 / 100.0).collect::<Vec<_>>();
    let speed = |time: &f64| 1500.0 + 50.0 * time.sin();
    for spike in [1e6, 5000.0] {
        let mut values: Vec<f64> = time(0).iter().map(speed).collect();
        values[3001] = spike;
        let (recording, drives) = with_drive(time(0), values);
        let result = synchronise(&recording).unwrap();
        let case = case::Case::new(&recording, &result, &drives);
        let text = case.to_toml(&frame());
        assert!(text.contains("n: 6000 rows, 5999 used, 1 spikes"), "{text}");
        assert!(!text.contains("# Note: input"), "{text}");
        let (_, table) = case.tables().pop().unwrap();
        let cells = table.lines().skip(1).map(|line| line.rsplit_once(',').unwrap().1.parse::<f64>().unwrap());
        assert!(cells.fold(0.0, f64::max) < 1560.0);
    }
    let holed: Vec<f64> = time(500).into_iter().filter(|time| !(20.0..23.0).contains(time)).collect();
    let (recording, drives) = with_drive(holed.clone(), holed.iter().map(speed).collect());
    let result = synchronise(&recording).unwrap();
    let case = case::Case::new(&recording, &result, &drives);
    assert!(case.check().is_ok());
    let text = case.to_toml(&frame());
    assert!(text.contains("# Note: input n begins at 5.000000 s, and before that has its first value.\n"), "{text}");
    assert!(text.contains("# Note: input n has no samples from 19.990000 s to 23.000000 s"), "{text}");
    let later: Vec<f64> = time(0).iter().map(|time| time + 1000.0).collect();
    let (recording, drives) = with_drive(later.clone(), later.iter().map(speed).collect());
    let result = synchronise(&recording).unwrap();
    let error = case::Case::new(&recording, &result, &drives).check().unwrap_err().to_string();
    assert!(error.contains("from 1000.000 s to 1059.990 s and the signals from 0.000 s"), "{error}");
}

/// The speed climbs by 1 rpm in each second, so it has 14.305 rpm when the model starts, between two rows.
#[test]
fn rows_before_the_models_start_are_left_out_and_told() {
    let time: Vec<f64> = (0..6000).map(|k| f64::from(k) / 100.0).collect();
    let (mut recording, drives) = with_drive(time.clone(), time);
    recording.start = Some(14.305);
    let result = synchronise(&recording).unwrap();
    assert_eq!(result.accounts[0].to_string(), "T: 6000 rows, 4569 used, 1431 before the model's start");
    let case = case::Case::new(&recording, &result, &drives);
    assert_eq!(case.accounts()[0].to_string(), result.accounts[0].to_string());
    let text = case.to_toml(&frame());
    for line in [
        "# The model starts at 14.305 s of the recording.\n",
        "n: 6000 rows, 4570 used, 1430 before the model's start for a line with",
        "simulation = { stop = 45.685 }\n",
    ] {
        assert!(text.contains(line), "{line}: {text}");
    }
    let tables = case.tables();
    let second = |place: usize| tables[place].1.lines().nth(1).unwrap();
    assert!(second(0).starts_with("0.005000000,"), "{}", second(0));
    assert_eq!(second(1), "0.000000000,1.43050000e1");
    // Where nothing was recorded yet, the first value holds.
    recording.start = Some(-2.0);
    let result = synchronise(&recording).unwrap();
    let text = case::Case::new(&recording, &result, &drives).to_toml(&frame());
    assert!(text.contains("extrapolate = \"hold\"") && text.contains("window = { from = 2, "), "{text}");
}

/// Of a minute the model starts at 14.305 s and is judged until 30 s.
#[test]
fn the_model_runs_until_the_window_ends() {
    let time: Vec<f64> = (0..6000).map(|k| f64::from(k) / 100.0).collect();
    let (mut recording, drives) = with_drive(time.clone(), time);
    (recording.start, recording.window) = (Some(14.305), Some([2.0, 30.0]));
    let result = synchronise(&recording).unwrap();
    let text = case::Case::new(&recording, &result, &drives).to_toml(&frame());
    let study: toml::Table = text.parse().unwrap();
    assert_eq!(study["cases"][0]["simulation"]["stop"].as_float(), Some(15.695), "{text}");
    let window = &study["cases"][0]["criteria"]["T"]["window"];
    assert_eq!([&window["from"], &window["to"]].map(|end| end.as_float()), [Some(0.005), Some(15.695)], "{text}");
    // A window may end later than the recording, and one from its start on begins at 0.
    (recording.start, recording.window) = (Some(0.0), Some([0.0, 90.0]));
    let result = synchronise(&recording).unwrap();
    let text = case::Case::new(&recording, &result, &drives).to_toml(&frame());
    assert!(text.contains("stop = 59.99 "), "{text}");
    recording.window = Some([0.0, 30.0]);
    let result = synchronise(&recording).unwrap();
    let text = case::Case::new(&recording, &result, &drives).to_toml(&frame());
    assert!(text.contains("stop = 30 ") && text.contains("window = { from = 0, to = 30 }"), "{text}");
}

/// Criteria and case leave out the same rows.
#[test]
fn marks_of_missing_values_count_and_are_told() {
    let (mut recording, _) = with_drive(Vec::new(), Vec::new());
    recording.others[0].values[2000..2040].fill(-9999.0);
    let result = synchronise(&recording).unwrap();
    assert!(result.findings[0].measured.value < 0.0, "{:?}", result.findings[0]);
    let said = result.warnings.join("\n");
    assert!(said.contains("40 of 6000 samples of T stand at -9999") && said.contains("missing = [-9999]"), "{said}");
    assert_eq!(result.accounts[0].lost, []);
}

#[test]
fn a_sensor_that_hangs_is_told() {
    let (mut recording, _) = with_drive(Vec::new(), Vec::new());
    let told = |recording: &RigRecording| synchronise(recording).unwrap().warnings.join("\n");
    assert!(!told(&recording).contains("stands at"));
    recording.others[0].values[3000..3200].fill(50.3);
    recording.others[0].values[100..102].fill(50.0);
    let text = told(&recording);
    assert!(text.contains("T stands at 50.3 degC for 200 samples, from 30.000 s to 31.990 s"), "{text}");
    let result = synchronise(&recording).unwrap();
    let case = case::Case::new(&recording, &result, &[]).to_toml(&frame());
    let study: toml::Table = case.parse().unwrap();
    let said = study["cases"][0]["concerns"][0].as_str().unwrap();
    assert!(said.starts_with("T stands at 50.3 degC"), "{said}");
    // Steps stand everywhere.
    recording.others[0].values = (0..6000).map(|k| f64::from(k / 100 % 7)).collect();
    assert!(!told(&recording).contains("stands at"));
}

#[test]
fn times_that_do_not_grow_have_their_own_remedies() {
    let refused = |change: &dyn Fn(&mut RigRecording)| {
        let (mut recording, _) = with_drive(Vec::new(), Vec::new());
        change(&mut recording);
        synchronise(&recording).unwrap_err().to_string()
    };
    let back = |r: &mut RigRecording| r.others[0].time[3000..].iter_mut().for_each(|time| *time -= 5.0);
    let twice = |r: &mut RigRecording| r.others[0].time[100] = r.others[0].time[99];
    let none = |r: &mut RigRecording| {
        r.others[0].time.clear();
        r.others[0].values.clear();
    };
    type Told<'a> = (&'a dyn Fn(&mut RigRecording), &'a str);
    let cases: [Told<'_>; 5] = [
        (&back, "does not increase at 25 s"),
        (&twice, "remove the row that repeats a time"),
        (&none, "no row of the column has a number"),
        (&|r| r.window = Some([20.0, 10.0]), "write the begin first"),
        (&|r| r.window = Some([100.0, 200.0]), "signal 'T' from 0.000 s to 59.990 s; correct the window"),
    ];
    for (change, expected) in cases {
        let error = refused(change);
        assert!(error.contains(expected), "{error}");
    }
}

#[test]
fn a_name_is_one_cell_of_csv_whatever_it_holds() {
    let time: Vec<f64> = (0..6000).map(|k| 0.01 * f64::from(k)).collect();
    for name in ["a,b", "a\"b", "a\nb", "a\rb"] {
        let (mut recording, drives) = with_drive(time.clone(), time.clone());
        recording.others[0].name = name.into();
        let result = synchronise(&recording).unwrap();
        let (_, table) = &case::Case::new(&recording, &result, &drives).tables()[0];
        let mut reader = csv::Reader::from_reader(table.as_bytes());
        assert_eq!(reader.headers().unwrap(), vec!["time", name]);
    }
}

//! A rig's recording and what drove it, from the columns of the files.

use super::{
    Signal,
    columns::{RecordedFiles, accuracy, of_zero},
    conversion,
};
use fmu_points::names::behind;
use number_tables::files::Result;
use result_document::format::number;
use rig_signals::{
    Bearing, Channel, RigRecording, Synchronised,
    case::{Drive, Driven},
};

impl RecordedFiles<'_> {
    /// How far the noise of a row alone is beyond the tolerance of a curve.
    pub fn too_tight(&self, recorded: &RigRecording, result: &Synchronised) -> Vec<String> {
        let settings = self.settings;
        let both = [("F_N", &settings.load), ("M", &settings.torque)]
            .into_iter()
            .filter_map(|(name, signal)| Some((name, signal.as_ref()?)));
        let signals = settings.signals.iter().map(|(name, signal)| (name.as_str(), signal));
        both.chain(signals).filter_map(|(name, signal)| {
            let name = signal.name.as_deref().unwrap_or(name);
            let channel = recorded.signals().find(|channel| channel.name == name)?;
            let mut means = result.findings.iter().filter(|f| f.name == name);
            let row = means.next()?.noise?.row;
            let tolerance = of_zero(signal.tolerance.as_ref()?, &channel.unit).ok()??;
            (row > tolerance).then(|| format!(
                "{name}: the rows' noise alone ({}{unit}) is more than the tolerance ({tolerance}{unit}), so a right model \
                 fails; use a larger one, or the mean in criteria.toml",
                number(row, 3),
                unit = behind(Some(channel.unit.as_str()).filter(|unit| *unit != "1"))
            ))
        }).collect()
    }

    /// The signals that drive the model in a case: the speed, where its variable is named, and the further inputs.
    ///
    /// # Errors
    /// When there are none, or a column or a unit does not fit.
    pub fn drives(&self) -> Result<Vec<Drive>> {
        let settings = self.settings;
        let speed = settings.speed.iter().filter_map(|speed| Some(("speed", speed.variable.clone()?, speed)));
        let inputs = settings.inputs.iter().map(|(variable, input)| ("inputs", variable.clone(), input));
        let mut drives = Vec::new();
        for (key, variable, input) in speed.chain(inputs) {
            let key = format!("{key}: {variable}");
            let (unit, values) = match (input.value, &input.column) {
                (Some(value), None) => (input.unit.clone().unwrap_or_default(), Driven::Constant(value)),
                _ => {
                    let channel = self.channel(&key, input, &variable, None)?;
                    (channel.unit.clone(), Driven::Recorded(channel))
                }
            };
            let wrong = |message| settings.wrong(format!("{key}: {message}"));
            let tolerance = match (&values, &input.tolerance) {
                (Driven::Recorded(_), Some(stated)) => of_zero(stated, &unit).map_err(wrong)?,
                _ => None,
            };
            drives.push(Drive { tolerance, variable, unit, values });
        }
        Ok(drives)
    }

    /// The recording's signals; load, torque and speed in SI units.
    ///
    /// # Errors
    /// When something is missing, or a column or a unit does not fit.
    pub fn recording(&self) -> Result<RigRecording> {
        let settings = self.settings;
        let mut others = Vec::new();
        for (name, signal) in &settings.signals {
            let key = format!("signals.{name}");
            settings.needed(&signal.variable, &key, "variable")?;
            settings.needed(&signal.accuracy, &key, "accuracy")?;
            others.push(self.channel(&key, signal, name, None)?);
        }
        let bearing = match (&settings.load, &settings.torque) {
            (None, None) => None,
            (Some(load), Some(torque)) => Some(self.bearing(load, torque)?),
            _ => {
                return Err(settings.wrong("load and torque go together; a single one is one of the `signals`"));
            }
        };
        if bearing.is_none() && others.is_empty() {
            return Err(settings
                .wrong("no signal is named; add signals.NAME = { column = ..., variable = ..., accuracy = ... }"));
        }
        let start = self.start()?;
        let recording = RigRecording {
            bearing,
            others,
            window: settings.window,
            start,
            confidence: settings.confidence.unwrap_or(0.99),
        };
        let end = recording
            .signals()
            .filter_map(|signal| signal.time.last())
            .copied()
            .chain(settings.window.map(|[_, to]| to))
            .fold(f64::INFINITY, f64::min);
        match start.filter(|start| start.is_nan() || *start >= end) {
            Some(start) => Err(settings.wrong(format!(
                "line {}: start: {start} s is not before {} s, where a signal or the window ends; give an earlier time",
                settings.start_line,
                number(end, 6)
            ))),
            None => Ok(recording),
        }
    }

    fn bearing(&self, load: &Signal, torque: &Signal) -> Result<Bearing> {
        let settings = self.settings;
        let speed = settings.needed(&settings.speed, "load and torque", "speed")?;
        for (key, signal) in [("load", load), ("torque", torque)] {
            settings.needed(&signal.variable, key, "variable")?;
        }
        for (key, signal) in [("load", load), ("torque", torque), ("speed", speed)] {
            settings.needed(&signal.accuracy, key, "accuracy")?;
        }
        let load = self.channel("load", load, "F_N", Some("N"))?;
        let speed = match (&speed.column, speed.value) {
            (Some(_), None) => self.channel("speed", speed, "speed", Some("rad/s"))?,
            (None, Some(value)) => {
                let unit = settings.needed(&speed.unit, "speed", "unit")?;
                let wrong = |message| settings.wrong(format!("speed: {message}"));
                let way = conversion(unit, "rad/s").map_err(wrong)?;
                let limit = settings.needed(&speed.accuracy, "speed", "accuracy")?;
                Channel {
                    name: "speed".to_owned(),
                    variable: speed.variable.clone().unwrap_or_default(),
                    unit: "rad/s".to_owned(),
                    values: vec![way.value(value); load.time.len()],
                    accuracy: accuracy(limit, unit, way.factor).map_err(wrong)?,
                    group: None,
                    lost: Vec::new(),
                    ..load.clone()
                }
            }
            _ => return Err(settings.wrong("speed: it needs either a column or a value")),
        };
        let diameter = settings.needed(&settings.diameter, "load and torque", "diameter")?;
        Ok(Bearing {
            torque: self.channel("torque", torque, "M", Some("N.m"))?,
            load,
            speed,
            diameter: settings.si("diameter", diameter, "m")?,
            smoothing: settings.smoothing,
            longest_delay: match &settings.longest_delay {
                Some(delay) => settings.si("longest-delay", delay, "s")?,
                None => 0.05,
            },
        })
    }

    /// When the model starts, s.
    fn start(&self) -> Result<Option<f64>> {
        let settings = self.settings;
        let key = format!("line {}: start", settings.start_line);
        settings.start.as_ref().map(|start| settings.si(&key, start.get_ref(), "s")).transpose()
    }
}

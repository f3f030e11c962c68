//! The page of a recording: the delay with its uncertainty, the signals before and after, what
//! the tests of stationarity say, and the criteria.

use super::plain::Page;
use super::write_file;
use crate::error::Error;
use result_document::bins::axis_range;
use result_document::format::number;
use result_document::svg::{Frame, area, envelope, path};
use result_document::{Block, Document, Figure, Key, Table, numbers, words};
use rig_signals::stationarity::Stationarity;
use rig_signals::{Channel, DerivedCriterion, RigRecording, Synchronised};
use sampling::statistics::moments::mean;
use std::path::Path;

/// Length of the record's end that is drawn, s.
const SHOWN: f64 = 1.0;

/// One line of a plot.
struct Trace<'a> {
    class: &'static str,
    time: &'a [f64],
    values: &'a [f64],
}

impl<'a> Trace<'a> {
    /// The last values, as many as there are times.
    fn new(class: &'static str, time: &'a [f64], values: &'a [f64]) -> Self {
        let values = &values[values.len() - time.len()..];
        Self { class, time, values }
    }
}

/// Writes `report.html` and `plots/*.svg` into a folder.
///
/// # Errors
/// When a file cannot be written.
pub fn write(
    recording: &RigRecording,
    result: &Synchronised,
    title: &str,
    amplitudes: bool,
    folder: &Path,
) -> Result<(), Error> {
    let documents = [signals(recording, result), measured(result, amplitudes), steadiness(recording, result)];
    let plots = folder.join("plots");
    std::fs::create_dir_all(&plots).map_err(Error::io(&plots))?;
    for figure in documents.iter().flat_map(Document::figures) {
        let path = plots.join(format!("{}.svg", figure.file));
        write_file(&path, &result_document::svg::standalone(&figure.svg))?;
    }
    let headline = match (&recording.bearing, &result.delay.delay) {
        (None, _) => "Measured values of the signals".to_owned(),
        (Some(_), Some(delay)) => format!("Torque {} ms later than the load", milliseconds(delay.value)),
        (Some(_), None) => "Load and torque are not related".to_owned(),
    };
    let page = Page {
        kicker: "From measured signals to criteria",
        title,
        headline: &headline,
        is_good: result.warnings.is_empty(),
        documents: &documents,
    };
    page.write(&folder.join("report.html"))
}

fn milliseconds(seconds: f64) -> String {
    number(1e3 * seconds, 4)
}

/// The signals, and of a bearing the delay between load and torque.
fn signals(recording: &RigRecording, result: &Synchronised) -> Document {
    let mut told = Document::new("signals", "Signals", "Signals");
    told.warn(&result.warnings);
    let samples: usize = result.accounts.iter().map(|account| account.rows).sum();
    let origin = format!("{samples} samples; orchestrator {}.", env!("CARGO_PKG_VERSION"));
    let Some(bearing) = &recording.bearing else {
        told.blocks.push(grid(recording.others.iter().filter_map(recorded)));
        told.hint(origin);
        return told;
    };
    let (delay, friction) = (&result.delay, &result.mean_friction);
    told.say(match (&delay.delay, &delay.disturbance) {
        (None, _) => "There is no delay, and the torque is not shifted.".to_owned(),
        (Some(_), Some(_)) => "The delay has no interval: see the warnings.".to_owned(),
        (Some(delay), None) => {
            format!("95 % interval of the delay: {} .. {} ms.", milliseconds(delay.low), milliseconds(delay.high))
        }
    });
    let [before, after] = result.friction_scatter.map(|part| number(100.0 * part, 3));
    let [start, end] = [result.time.first(), result.time.last()].map(|t| number(t.copied().unwrap_or(0.0), 5));
    told.say(format!(
        "Friction coefficient {} ± {}. That of a steady state hardly varies; the delay is the shift of the torque at which it \
         follows the load most closely. The coefficient's relative standard deviation is {before} % before the shift and {after} % \
         after it. The interval comes from {} blocks of the record. Smoothing of load and torque: {}. Window: {start} .. {end} s.",
        number(friction.value, 4),
        number(friction.expanded(), 2),
        delay.blocks,
        bearing.smoothing
    ));
    told.blocks.push(Block::Legend(vec![
        Key::new("line raw", "M0,9l3,-5l3,6l3,-6l5,4", "recorded"),
        Key::new("line before", "M0,7h14", "smoothed, before the shift"),
        Key::new("line", "M0,7h14", "smoothed, aligned; the last second of the window"),
    ]));
    told.blocks.push(grid(figures(result).into_iter()));
    told.hint(format!(
        "In the last plot: the band is the interval of the delay, the dashed line the delay itself. Bearing diameter {} mm, longest \
         delay looked for {} ms; {origin}",
        number(1e3 * bearing.diameter, 6),
        number(1e3 * bearing.longest_delay, 6)
    ));
    told
}

fn grid(figures: impl Iterator<Item = Figure>) -> Block {
    Block::Figures("planes", figures.collect())
}

/// The measured values with their uncertainties.
fn measured(result: &Synchronised, amplitudes: bool) -> Document {
    let mut told = Document::new("measured", "Measured values", "Measured values");
    let shown = |f: &&DerivedCriterion| amplitudes || f.statistic != "amplitude";
    told.table(Table {
        name: "Measured values".into(),
        columns: vec![
            words("Criterion"),
            words("Of"),
            numbers("Value"),
            numbers("Expanded (k = 2)"),
            numbers("Scatter"),
            numbers("Sensor"),
            numbers("Noise of a row"),
            numbers("Change over the window"),
            words("Stationarity"),
        ],
        rows: result.findings.iter().filter(shown).map(row).collect(),
        ..Table::default()
    });
    told.hint(
        "Means over whole turns. Expanded uncertainty, and the standard uncertainties from scatter and sensor, combined after the \
         GUM; a sensor's accuracy is the half-width of a rectangular distribution. The noise of a row is the standard deviation \
         between the shaft's harmonics, as recorded.",
    );
    told
}

fn row(finding: &DerivedCriterion) -> Vec<String> {
    let m = &finding.measured;
    let unit = &finding.unit;
    let dash = || "–".to_owned();
    let change = |s: &Stationarity| {
        let [value, low, high] = [s.change.value, s.change.low, s.change.high].map(|v| number(v, 2));
        format!("{value} ({low} .. {high})")
    };
    vec![
        finding.name.clone(),
        format!("{} of {}", finding.statistic, finding.variable),
        format!("{} {unit}", number(m.value, 6)),
        format!("± {} {unit}", number(m.expanded(), 2)),
        number(m.scatter, 2),
        number(m.sensor, 2),
        finding.noise.as_ref().map_or_else(dash, |noise| number(noise.stated(), 2)),
        finding.stationarity.as_ref().map_or_else(dash, change),
        match &finding.stationarity {
            None if finding.statistic == "amplitude" => dash(),
            None => "window too short".to_owned(),
            Some(s) if s.trend => format!("drifting, chance {:.0e}", s.trend_chance),
            Some(s) if s.drift => format!("wandering, chance {:.0e}", s.wander_chance),
            Some(_) => "steady".to_owned(),
        },
    ]
}

/// Whether the signals were steady.
fn steadiness(recording: &RigRecording, result: &Synchronised) -> Document {
    let mut told = Document::new("steady", "Stationarity", "Was it steady?");
    told.blocks.push(Block::Legend(vec![
        Key::new("blocks", "M0,9l4,-4l4,5l6,-4", "means of blocks"),
        Key::new("limit", "M0,7h14", "their trend"),
    ]));
    let steady = result.findings.iter().filter(|f| !f.blocks.is_empty());
    told.blocks.push(grid(steady.filter_map(wander)));
    told.hint(format!(
        "Tested with {} % confidence: whether the straight line rises or falls, and whether the means wander about it (von \
         Neumann's ratio).",
        number(100.0 * recording.confidence, 4)
    ));
    told
}

/// A signal as it was recorded.
fn recorded(channel: &Channel) -> Option<Figure> {
    let trace = Trace::new("line", &channel.time, &channel.values);
    let name = format!("{}: as recorded", channel.name);
    let file = format!("signal-{}", channel.name);
    of_time(&name, &file, &channel.unit, &[trace])
}

/// Signals before and after (the paper's Fig. 5), and how the delay was found.
fn figures(result: &Synchronised) -> Vec<Figure> {
    let end = result.time.last().copied().unwrap_or(0.0);
    let from = result.time.partition_point(|t| *t < end - SHOWN);
    let time = &result.time[from..];
    let trace = |class, values| Trace::new(class, time, values);
    let signals = [
        of_time(
            "Load: recorded and smoothed",
            "load",
            "N",
            &[trace("line raw", &result.load_raw), trace("line", &result.load)],
        ),
        of_time(
            "Torque: recorded, smoothed, and shifted",
            "torque",
            "N.m",
            &[
                trace("line raw", &result.torque_raw),
                trace("line before", &result.torque_before),
                trace("line", &result.torque),
            ],
        ),
        of_time(
            "Friction coefficient before and after the shift",
            "friction",
            "friction coefficient",
            &[trace("line before", &result.friction_before), trace("line", &result.friction)],
        ),
        of_time("Friction power after the shift", "power", "W", &[trace("line", &result.power)]),
        search(result),
    ];
    signals.into_iter().flatten().collect()
}

/// How much of the torque the load does not explain by the delay, with the least and its interval.
fn search(result: &Synchronised) -> Option<Figure> {
    let (delays, scatter): (Vec<f64>, Vec<f64>) =
        result.delay.scan.iter().map(|(delay, scatter)| (1e3 * delay, 100.0 * scatter)).unzip();
    let name = "What the load does not explain of the torque, by the delay";
    let trace = Trace::new("line", &delays, &scatter);
    let marks = |frame: &Frame| {
        let Some(interval) = &result.delay.delay else {
            return String::new();
        };
        let at = |s: f64| frame.x.clamped(1e3 * s);
        let (low, high) = (at(interval.low), at(interval.high));
        let (top, bottom, delay) = (frame.y.to, frame.y.from, at(interval.value));
        let band = match result.delay.disturbance {
            None => area("accept", [low, high], [top, bottom]),
            Some(_) => String::new(),
        };
        band + &path("nominal", format_args!("M{delay:.2},{top:.1}V{bottom:.1}"))
    };
    let up = "unexplained part of the standard deviation (%)";
    let across = "torque later than load (ms)";
    figure(name, "delay", [across, up], &[trace], marks)
}

/// The means of blocks with the straight line through them.
fn wander(finding: &DerivedCriterion) -> Option<Figure> {
    let [start, block] = finding.block;
    let middle = |k: usize| start + (k as f64 + 0.5) * block;
    let time: Vec<f64> = (0..finding.blocks.len()).map(middle).collect();
    let trace = Trace::new("blocks", &time, &finding.blocks);
    let line = |frame: &Frame| {
        let Some(s) = &finding.stationarity else {
            return String::new();
        };
        let (centre, half) = (mean(&finding.blocks), s.change.value / 2.0);
        let ends = [time.first(), time.last()].map(|t| frame.x.at(t.copied().unwrap_or(0.0)));
        let [from, to] = [-half, half].map(|step| frame.y.clamped(centre + step));
        let line = format_args!("M{:.1},{from:.1}L{:.1},{to:.1}", ends[0], ends[1]);
        path("limit", line)
    };
    let name = format!("{}: means of blocks of {} s and their trend", finding.name, number(block, 3));
    let file = format!("blocks-{}", finding.name);
    figure(&name, &file, [TIME, &finding.unit], &[trace], line)
}

const TIME: &str = "time (s)";

fn of_time(name: &str, file: &str, unit: &str, traces: &[Trace<'_>]) -> Option<Figure> {
    figure(name, file, [TIME, unit], traces, |_| String::new())
}

/// Lines over a common axis, and marks under them; nothing without any value.
fn figure(
    caption: &str,
    file: &str,
    [across, up]: [&str; 2],
    traces: &[Trace<'_>],
    marks: impl Fn(&Frame) -> String,
) -> Option<Figure> {
    let all = traces.iter().flat_map(|t| t.values).copied();
    let range = axis_range(all, f64::NEG_INFINITY, f64::INFINITY)?;
    let time = traces.first()?.time;
    let (start, end) = (*time.first()?, *time.last()?);
    if end <= start {
        return None;
    }
    let frame = Frame::new(560.0, 250.0, [start, end], range);
    let mut out = frame.axes(across, Some(up));
    out.push_str(&marks(&frame));
    for trace in traces {
        out += &path(trace.class, envelope(trace.time.iter().zip(trace.values), &frame));
    }
    let is_plain = |c: char| c.is_alphanumeric() || c == '_';
    Some(Figure {
        file: file.replace(|c| !is_plain(c), "-"),
        caption: caption.to_owned(),
        svg: frame.wrap(caption, &out),
        ..Figure::default()
    })
}

//! The page of a recording: the delay with its uncertainty, the signals before and after, what
//! the tests of stationarity say, and the criteria.

use crate::{error::Result, plain::Page};
use point_journal::files::{make_folder, write_text};
use result_document::{
    Document, Figure, Key, Table,
    bins::axis_range,
    format::{DASH, number},
    numbers,
    svg::{Frame, area, path},
};
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
pub fn write(recording: &RigRecording, result: &Synchronised, title: &str, folder: &Path) -> Result {
    let bearing = recording.bearing.as_ref();
    let [start, end] = [result.time.first(), result.time.last()].map(|t| number(t.copied().unwrap_or(0.0), 5));
    let mut measured = Document::new("measured", "Measured values", "Measured values");
    let mut signals = Document::new("signals", "Signals", "Signals");
    if let Some(bearing) = bearing {
        let [before, after] = result.friction_scatter.map(|part| number(100.0 * part, 3));
        let friction = &result.mean_friction;
        measured.say(format!(
            "Friction coefficient: {} ± {}, with a relative standard deviation of {after} % (before the shift {before} %). Smoothing: {}. \
             Window: {start} .. {end} s.",
            number(friction.value, 4),
            number(friction.expanded(), 2),
            bearing.smoothing
        ));
        signals.legend([
            Key::new("line raw", "M0,9l3,-5l3,6l3,-6l5,4", "recorded"),
            Key::new("line before", "M0,7h14", "smoothed, before the shift"),
            Key::new("line", "M0,7h14", "smoothed, aligned; the last second of the window"),
        ]);
    }
    let columns = [
        "Criterion",
        "Value",
        "Expanded (k = 2)",
        "Scatter",
        "Sensor",
        "Noise of a row",
        "Change over the window",
        "Stationarity",
    ];
    let rows = result.findings.iter().map(row).collect();
    measured.table(Table::new("Measured values", columns.map(numbers), rows));
    measured.hint(
        "Means over whole turns; uncertainties after the GUM, where a sensor's accuracy is the half-width of a rectangular distribution. \
         `criteria.toml` has the lines for a study.",
    );
    measured.warn(&result.warnings);
    measured.list(result.accounts.iter().map(ToString::to_string).collect());
    let plots = match bearing {
        Some(_) => figures(result),
        None => recording.others.iter().filter_map(recorded).collect(),
    };
    signals.show("planes", plots);
    let mut steady = Document::new(
        "steady",
        "Stationarity",
        format!("Was it steady? Tested with {} % confidence", number(100.0 * recording.confidence, 4)),
    );
    steady.show("planes", result.findings.iter().filter_map(wander));
    let documents = [measured, signals, steady];
    let plots = folder.join("plots");
    make_folder(&plots)?;
    for figure in documents.iter().flat_map(Document::figures) {
        write_text(&plots.join(format!("{}.svg", figure.file)), result_document::svg::standalone(&figure.svg))?;
    }
    let headline = match (bearing, result.delay.words()) {
        (None, _) => "Criteria from signals".to_owned(),
        (_, Some(delay)) => format!("Torque later than the load by {delay}"),
        (_, None) => "Load and torque are not related: the torque is not shifted".to_owned(),
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

fn row(finding: &DerivedCriterion) -> Vec<String> {
    let (m, unit) = (&finding.measured, &finding.unit);
    let change = |s: &rig_signals::stationarity::Stationarity| {
        let [value, low, high] = [s.change.value, s.change.low, s.change.high].map(|v| number(v, 2));
        format!("{value} ({low} .. {high})")
    };
    let steady = match &finding.stationarity {
        None => "window too short".to_owned(),
        Some(s) if s.trend => format!("drifting, chance {:.0e}", s.trend_chance),
        Some(s) if s.drift => format!("wandering, chance {:.0e}", s.wander_chance),
        Some(_) => "steady".to_owned(),
    };
    vec![
        format!("{}: mean of {}", finding.name, finding.variable),
        format!("{} {unit}", number(m.value, 6)),
        format!("± {} {unit}", number(m.expanded(), 2)),
        number(m.scatter, 2),
        number(m.sensor, 2),
        finding.noise.as_ref().map_or(DASH.into(), |noise| number(noise.stated(), 2)),
        finding.stationarity.as_ref().map_or(DASH.into(), change),
        steady,
    ]
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
    [
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
        search(result),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// How much of the torque the load does not explain by the delay, with the least and its interval.
fn search(result: &Synchronised) -> Option<Figure> {
    let (delays, scatter): (Vec<f64>, Vec<f64>) =
        result.delay.scan.iter().map(|(delay, scatter)| (1e3 * delay, 100.0 * scatter)).unzip();
    let name = "What the load does not explain of the torque, by the delay (dashed, with its interval)";
    let trace = Trace::new("line", &delays, &scatter);
    let marks = |frame: &Frame| {
        let Some(interval) = &result.delay.delay else { return String::new() };
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
    let time: Vec<f64> = (0..finding.blocks.len()).map(|k| start + (k as f64 + 0.5) * block).collect();
    let trace = Trace::new("blocks", &time, &finding.blocks);
    let line = |frame: &Frame| {
        let Some(s) = &finding.stationarity else { return String::new() };
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

fn of_time(name: &str, file: &str, unit: &str, traces: &[Trace]) -> Option<Figure> {
    figure(name, file, [TIME, unit], traces, |_| String::new())
}

/// Lines over a common axis, and marks under them; nothing without any value.
fn figure(
    caption: &str,
    file: &str,
    [across, up]: [&str; 2],
    traces: &[Trace],
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
    out += &marks(&frame);
    for trace in traces {
        out += &frame.line(trace.class, trace.time, trace.values);
    }
    let is_plain = |c: char| c.is_alphanumeric() || c == '_';
    Some(Figure {
        file: file.replace(|c| !is_plain(c), "-"),
        caption: caption.to_owned(),
        svg: frame.wrap(caption, &out),
        ..Figure::default()
    })
}

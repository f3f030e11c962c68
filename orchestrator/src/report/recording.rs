//! The page of a recording: the delay with its uncertainty, the signals before and after, what
//! the tests of stationarity say, and the criteria.

use super::write_file;
use crate::error::Error;
use minijinja::value::{Serde, Value};
use minijinja::{Environment, context};
use result_document::Figure;
use result_document::bins::axis_range;
use result_document::format::number;
use result_document::marked;
use result_document::svg::{Frame, area, envelope, path};
use rig_signals::{Channel, DerivedCriterion, RigRecording, Synchronised, criteria};
use sampling::statistics::moments::mean;
use std::path::{Path, PathBuf};

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

/// Writes `report.html` and `plots/*.svg` into a folder, and returns the page's path.
///
/// # Errors
/// When a file cannot be written.
pub fn write(
    recording: &RigRecording,
    result: &Synchronised,
    title: &str,
    amplitudes: bool,
    folder: &Path,
) -> Result<PathBuf, Error> {
    let delay = &result.delay;
    let milliseconds = |s: f64| number(1e3 * s, 4);
    let per_cent = |part: f64| number(100.0 * part, 3);
    let shown = |f: &&DerivedCriterion| amplitudes || f.statistic != "amplitude";
    let rows: Vec<Value> = result.findings.iter().filter(shown).map(row).collect();
    let [start, end] = [result.time.first(), result.time.last()].map(|t| number(t.copied().unwrap_or(0.0), 5));
    let steady = result.findings.iter().filter(|f| !f.blocks.is_empty());
    let steady: Vec<Figure> = steady.filter_map(wander).collect();
    let figures = match &recording.bearing {
        Some(_) => figures(result),
        None => recording.others.iter().filter_map(recorded).collect(),
    };
    let plots = folder.join("plots");
    std::fs::create_dir_all(&plots).map_err(Error::io(&plots))?;
    for figure in figures.iter().chain(&steady) {
        let path = plots.join(format!("{}.svg", figure.file));
        write_file(&path, &result_document::svg::standalone(&figure.svg))?;
    }
    let interval = delay.delay.filter(|_| delay.disturbance.is_none());
    let friction = &result.mean_friction;
    let bearing = recording.bearing.as_ref();
    let rows_in: usize = result.accounts.iter().map(|account| account.rows).sum();
    let mut facts = vec![
        ("Program", concat!("orchestrator ", env!("CARGO_PKG_VERSION")).to_owned()),
        ("Samples", rows_in.to_string()),
    ];
    if let Some(bearing) = bearing {
        let [diameter, longest] = [bearing.diameter, bearing.longest_delay].map(|v| number(1e3 * v, 6));
        facts.push(("Bearing diameter", format!("{diameter} mm")));
        facts.push(("Longest delay looked for", format!("{longest} ms")));
    }
    let page = context! {
        title,
        style => [
            result_document::svg::STYLE,
            include_str!("assets/report.css")
        ].concat(),
        delay => delay.delay.map(|d| milliseconds(d.value)),
        interval => interval.map(|d| [d.low, d.high].map(milliseconds).to_vec()),
        before => per_cent(result.friction_scatter[0]),
        after => per_cent(result.friction_scatter[1]),
        friction => vec![number(friction.value, 4), number(friction.expanded(), 2)],
        bearing => bearing.is_some(),
        smoothing => bearing.map(|bearing| bearing.smoothing.to_string()),
        window => format!("{start} .. {end} s"),
        blocks => delay.blocks,
        warnings => result.warnings.iter().map(|text| Value::from_safe_string(marked(text))).collect::<Vec<_>>(),
        figures => Serde(&figures),
        rows,
        confidence => number(100.0 * recording.confidence, 4),
        steady => Serde(&steady),
        criteria => criteria::to_toml(result, amplitudes),
        facts => Serde(facts),
    };
    let template = include_str!("assets/recording.html");
    let html = Environment::new().render_named_str("recording.html", template, page)?;
    let path = folder.join("report.html");
    write_file(&path, &html)?;
    Ok(path)
}

fn row(finding: &DerivedCriterion) -> Value {
    let m = &finding.measured;
    let unit = &finding.unit;
    let change = |s: &rig_signals::stationarity::Stationarity| {
        let [value, low, high] = [s.change.value, s.change.low, s.change.high].map(|v| number(v, 2));
        format!("{value} ({low} .. {high})")
    };
    let (steady, alarm) = match &finding.stationarity {
        None if finding.statistic == "amplitude" => ("–".to_owned(), false),
        None => ("window too short".to_owned(), true),
        Some(s) if s.trend => (format!("drifting, chance {:.0e}", s.trend_chance), true),
        Some(s) if s.drift => (format!("wandering, chance {:.0e}", s.wander_chance), true),
        Some(_) => ("steady".to_owned(), false),
    };
    let noise = finding.noise.as_ref();
    context! {
        name => &finding.name,
        about => format!("{} of {}", finding.statistic, finding.variable),
        value => format!("{} {unit}", number(m.value, 6)),
        expanded => format!("± {} {unit}", number(m.expanded(), 2)),
        scatter => number(m.scatter, 2),
        sensor => number(m.sensor, 2),
        noise => noise.map_or("–".into(), |noise| number(noise.stated(), 2)),
        change => finding.stationarity.as_ref().map_or("–".into(), change),
        steady,
        alarm,
    }
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

//! The plots that need no script: the page shows them until its script takes over, and they are
//! written beside it as files.

use super::{overlay::ReferenceCurve, payload::PlotColumn};
use conformity::conclusion::grouped;
use parameter_regions::table::PointTable;
use result_document::{
    bins::{axis_range, bins_for, histogram},
    format::{number, with_unit},
    svg::{Axis, Frame, area, circle, path, text, ticks},
};
use sampling::statistics::moments::mean;
use std::fmt::Write as _;

/// `points` of one column against another, with the accepted box; of very many an even part.
pub fn plane(
    table: &PointTable,
    x: &PlotColumn,
    y: &PlotColumn,
    points: &[usize],
    [total, accepted]: [usize; 2],
) -> String {
    let mut frame = Frame::new(560.0, 420.0, x.range, y.range);
    frame.y.to = CAPTION;
    let mut out = frame.axes(&with_unit(x.name, x.unit), Some(&with_unit(y.name, y.unit)));
    out += &acceptance(&frame, x, y);
    let points: Vec<usize> = points.iter().copied().step_by(points.len().div_ceil(MOST_MARKS).max(1)).collect();
    out += &marks(table, &frame, x, y, &points);
    let inside = (0..table.len()).filter(|&i| within(x, i) && within(y, i)).count();
    let in_box = match x.is_criterion || y.is_criterion {
        true if table.len() == total => format!(", {} in the box", grouped(inside)),
        _ => String::new(),
    };
    let drawn = if points.len() < total { format!(", {} drawn", grouped(points.len())) } else { String::new() };
    out += &frame.caption(&format!("{} points{in_box}, {} accepted{drawn}", grouped(total), grouped(accepted)));
    let title =
        format!("{} against {}: {inside} of {} points lie in the box of the tolerances", y.name, x.name, table.len());
    frame.wrap(&title, &out)
}

/// Most points that a picture has marks of; the page's script draws more of them.
const MOST_MARKS: usize = 5000;

/// Where the plot begins below its line of words.
const CAPTION: f64 = 30.0;

fn within(c: &PlotColumn, i: usize) -> bool {
    c.values[i] >= c.accepted[0] && c.values[i] <= c.accepted[1]
}

/// The accepted box and the measured value; under a guard band the box of the tolerances around it.
fn acceptance(frame: &Frame, x: &PlotColumn, y: &PlotColumn) -> String {
    let mut out = String::new();
    if !x.is_criterion && !y.is_criterion {
        return out;
    }
    let across = |[low, high]: [f64; 2]| (frame.x.clamped(low), frame.x.clamped(high));
    let along = |[low, high]: [f64; 2]| (frame.y.clamped(high), frame.y.clamped(low));
    let ((x0, x1), (y0, y1)) = (across(x.accepted), along(y.accepted));
    let guarded = x.drawn_in.is_some() || y.drawn_in.is_some();
    out += &area(if guarded { "tolerance" } else { "accept" }, [x0, x1], [y0, y1]);
    let inner = [x, y].map(|c| c.drawn_in.unwrap_or(c.accepted));
    if guarded && inner.iter().all(|[low, high]| low <= high) {
        let ((x0, x1), (y0, y1)) = (across(inner[0]), along(inner[1]));
        out += &area("accept", [x0, x1], [y0, y1]);
    }
    if let Some(v) = x.nominal.map(|v| frame.x.clamped(v)) {
        out += &path("nominal", format_args!("M{v:.1},{y0:.1}V{y1:.1}"));
    }
    if let Some(v) = y.nominal.map(|v| frame.y.clamped(v)) {
        out += &path("nominal", format_args!("M{x0:.1},{v:.1}H{x1:.1}"));
    }
    out
}

fn marks(table: &PointTable, frame: &Frame, x: &PlotColumn, y: &PlotColumn, points: &[usize]) -> String {
    let r = mark_radius(points.len());
    let mut paths = [const { String::new() }; 3];
    for &i in points {
        let (vx, vy) = (x.values[i], y.values[i]);
        if !frame.x.contains(vx) || !frame.y.contains(vy) {
            continue;
        }
        let (px, py) = (frame.x.at(vx), frame.y.at(vy));
        if table.verified[i] {
            paths[2] += &circle([px, py], r);
        } else if within(x, i) && within(y, i) {
            let top = py - r;
            let _ = write!(paths[1], "M{px:.1},{top:.1}l{r},{r}l-{r},{r}l-{r},-{r}z");
        } else {
            let half = 0.75 * r;
            let side = 2.0 * half;
            let (left, top) = (px - half, py - half);
            let _ = write!(paths[0], "M{left:.1},{top:.1}l{side},{side}m0,-{side}l-{side},{side}");
        }
    }
    ["pt out", "pt part", "pt in"].iter().zip(paths).map(|(class, d)| path(class, d)).collect()
}

/// The size of a mark, so that a crowd stays readable.
fn mark_radius(points: usize) -> f64 {
    match points {
        0..=150 => 4.5,
        151..=1000 => 3.5,
        1001..=5000 => 2.5,
        _ => 1.8,
    }
}

/// The distribution of a column: all points, and the accepted ones, which the table has as verified, each with its own
/// scale so that the shapes compare.
pub fn distribution(table: &PointTable, c: &PlotColumn, [total, accepted]: [usize; 2]) -> String {
    let verified: Vec<f64> = (0..table.len()).filter(|&i| table.verified[i]).map(|i| c.values[i]).collect();
    let bins = bins_for(table.len());
    let frame =
        Frame { width: 300.0, height: 190.0, x: Axis::new(c.range, SIDES), y: Axis::new([0.0, 1.08], [142.0, 24.0]) };
    let mut out = frame.axes(&with_unit(c.name, c.unit), None);
    if c.is_criterion {
        let across = |[low, high]: [f64; 2]| [frame.x.clamped(low), frame.x.clamped(high)];
        let down = [frame.y.to, frame.y.from];
        let outer = if c.drawn_in.is_some() { "tolerance" } else { "accept" };
        out += &area(outer, across(c.accepted), down);
        if let Some(inner) = c.drawn_in.filter(|[low, high]| low <= high) {
            out += &area("accept", across(inner), down);
        }
    }
    let counts = histogram(c.values.iter(), c.range, bins);
    out += &path("bar all", bars(&counts, &frame, c.range, true));
    out += &heights(&counts, &frame, false);
    if !verified.is_empty() {
        // Few verified points: fewer bins, else the outline is all spikes.
        let coarse = bins_for(verified.len()).min(bins);
        // They all lie in the accepted range, so no bar reaches over its limits.
        let [low, high] = c.drawn_in.unwrap_or(c.accepted);
        let range = [low.max(c.range[0]), high.min(c.range[1])];
        let counts = histogram(verified.iter(), range, coarse);
        out += &path("bar in", bars(&counts, &frame, range, false));
        out += &heights(&counts, &frame, true);
    }
    out += &frame.caption(&format!("{} points, {} accepted", grouped(total), grouped(accepted)));
    let title = format!(
        "Distribution of {} over all {} points and over the {} accepted points",
        c.name,
        table.len(),
        verified.len()
    );
    frame.wrap(&title, &out)
}

/// Both ends of a small plot's axis: the page's script draws on the same.
const SIDES: [f64; 2] = [42.0, 258.0];

/// The highest bar.
fn highest(counts: &[usize]) -> f64 {
    counts.iter().copied().max().unwrap_or(0).max(1) as f64
}

/// The numbers of points in a bar, at the left side of all points, at the right one of the accepted points.
fn heights(counts: &[usize], frame: &Frame, accepted: bool) -> String {
    let most = highest(counts);
    let (x, anchor, class) =
        if accepted { (frame.x.to + 4.0, "start", "tick in") } else { (frame.x.from - 4.0, "end", "tick") };
    let whole = |t: &f64| t.fract() == 0.0;
    let mut out = String::new();
    for t in ticks(0.0, most, 3).into_iter().filter(whole) {
        let place = [x, frame.y.at(t / most) + 4.0];
        out += &text(class, place, anchor, &number(t, 4));
    }
    out
}

/// Bars over a range, or their outline, scaled to the highest.
fn bars(counts: &[usize], frame: &Frame, range: [f64; 2], filled: bool) -> String {
    let most = highest(counts);
    let [from, to] = range.map(|end| frame.x.clamped(end));
    let w = (to - from) / counts.len() as f64;
    let mut d = String::new();
    if !filled {
        let _ = write!(d, "M{from:.1},{:.1}", frame.y.from);
    }
    for (k, &n) in counts.iter().enumerate() {
        let (left, top) = (from + k as f64 * w, frame.y.at(n as f64 / most));
        if filled && n > 0 {
            let _ = write!(d, "M{:.1},{:.1}V{top:.1}h{:.1}V{:.1}z", left + 0.5, frame.y.from, w - 1.0, frame.y.from);
        } else if !filled {
            let _ = write!(d, "V{top:.1}H{:.1}", left + w);
        }
    }
    if !filled {
        let _ = write!(d, "V{:.1}", frame.y.from);
    }
    d
}

/// A quantity over time.
#[derive(Clone, Debug)]
pub struct Series {
    /// The variable's name.
    pub name: String,
    /// The unit of `values`.
    pub unit: String,
    /// Times, s, ascending.
    pub time: Vec<f64>,
    /// One value per time.
    pub values: Vec<f64>,
    /// The accepted interval of a criterion computed from it, in the same unit, if there is one.
    pub accepted: Option<[f64; 2]>,
    /// The times between which it is judged, s: the whole run if not known.
    pub judged: Option<[f64; 2]>,
    /// The measured curve that it is compared with, if there is one.
    pub measured: Option<ReferenceCurve>,
}

impl Series {
    /// The last few periods of a series that oscillates too fast to be seen as a whole.
    pub fn last_periods(&self) -> Option<Series> {
        const PERIODS: usize = 6;
        const TOO_MANY: usize = 60;
        if self.measured.is_some() {
            return None;
        }
        let mean = mean(&self.values);
        let rises: Vec<usize> =
            (1..self.values.len()).filter(|&i| self.values[i - 1] < mean && self.values[i] >= mean).collect();
        if rises.len() < TOO_MANY {
            return None;
        }
        let from = rises[rises.len() - PERIODS];
        Some(Series { time: self.time[from..].to_vec(), values: self.values[from..].to_vec(), ..self.clone() })
    }
}

/// A quantity over time with the accepted band; long series keep their extremes in every pixel column.
pub fn history(series: &Series) -> Option<String> {
    let [low, high] = series.accepted.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
    let mut all = series.values.clone();
    all.extend(series.measured.iter().flat_map(ReferenceCurve::extremes));
    let y = axis_range(all, low, high)?;
    let (start, end) = (*series.time.first()?, *series.time.last()?);
    let frame = Frame::new(560.0, 220.0, [start, if end > start { end } else { start + 1.0 }], y);
    let mut out = frame.axes("time (s)", Some(&series.unit));
    if series.accepted.is_some() {
        let (top, bottom) = (frame.y.clamped(high), frame.y.clamped(low));
        let [from, to] = series.judged.unwrap_or([start, end]);
        // A single sample still has a band that can be seen.
        let [from, to] = [frame.x.clamped(from) - 4.0, frame.x.clamped(to) + 4.0];
        out += &area("accept", [from, to], [bottom, top]);
    }
    if let Some(measured) = &series.measured {
        out += &measured.draw(&frame);
    }
    let class = if series.last_periods().is_some() { "line fast" } else { "line" };
    out += &frame.line(class, &series.time, &series.values);
    Some(frame.wrap(&format!("{} over time", series.name), &out))
}

/// The deviations from the measured curve, where there is one.
pub fn residuals(series: &Series) -> Option<String> {
    series.measured.as_ref()?.residuals(&series.name, &series.unit, &series.time, &series.values)
}

//! A small drawing kit: scales, ticks, a framed plot. Text and lines are styled by classes of
//! `plot.css`, so that a plot looks the same in the page and as a file of its own.

use super::format::{escape, number};
use std::fmt::{Display, Write};

/// The style sheet of all plots.
pub const STYLE: &str = include_str!("plot.css");

/// A path of a class of the style sheet.
pub fn path(class: &str, d: impl Display) -> String {
    format!("<path class=\"{class}\" d=\"{d}\"/>")
}

/// A bar or area between two ends across, and two along.
pub fn area(class: &str, [x0, x1]: [f64; 2], [y0, y1]: [f64; 2]) -> String {
    path(class, format_args!("M{x0:.1},{y0:.1}H{x1:.1}V{y1:.1}H{x0:.1}z"))
}

/// Words whose `anchor` (start, middle or end) is at a place.
pub fn text(class: &str, [x, y]: [f64; 2], anchor: &str, words: &str) -> String {
    format!("<text class=\"{class}\" x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\">{}</text>", escape(words))
}

/// The title of a vertical axis, which is read from below.
pub fn upright([x, y]: [f64; 2], words: &str) -> String {
    format!(
        "<text class=\"title\" transform=\"translate({x:.1},{y:.1}) rotate(-90)\" text-anchor=\"middle\">{}</text>",
        escape(words)
    )
}

/// A circle as a part of a path.
pub fn circle([x, y]: [f64; 2], r: f64) -> String {
    let d = 2.0 * r;
    format!("M{:.1},{y:.1}a{r},{r} 0 1,0 {d},0a{r},{r} 0 1,0 -{d},0", x - r)
}

/// The picture around some content. `title` is read by screen readers and shown on hover.
pub fn picture(class: &str, [width, height]: [f64; 2], title: &str, content: &str) -> String {
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"{class}\" viewBox=\"0 0 {width} {height}\" role=\"img\" aria-label=\"{}\">{content}</svg>",
        escape(title)
    )
}

/// A linear map from values to pixels.
#[derive(Clone, Copy, Debug)]
pub struct Axis {
    /// The value at `from`.
    pub low: f64,
    /// The value at `to`.
    pub high: f64,
    /// The pixel of `low`.
    pub from: f64,
    /// The pixel of `high`.
    pub to: f64,
}

impl Axis {
    /// From the least and the greatest value to the pixels of these.
    pub fn new([low, high]: [f64; 2], [from, to]: [f64; 2]) -> Self {
        Self { low, high, from, to }
    }

    /// The pixel of a value.
    pub fn at(&self, value: f64) -> f64 {
        self.from + (value - self.low) / (self.high - self.low) * (self.to - self.from)
    }

    /// Whether a value lies on the scale.
    pub fn contains(&self, value: f64) -> bool {
        value >= self.low && value <= self.high
    }

    /// The pixel of a value, moved onto the scale when outside; for infinite limits.
    pub fn clamped(&self, value: f64) -> f64 {
        self.at(value.clamp(self.low, self.high))
    }
}

/// Round values that divide a range into about `count` parts.
pub fn ticks(low: f64, high: f64, count: usize) -> Vec<f64> {
    let raw = (high - low) / count.max(1) as f64;
    if !(raw.is_finite() && raw > 0.0) {
        return vec![low];
    }
    let power = 10f64.powf(raw.log10().floor());
    let step =
        [1.0, 2.0, 2.5, 5.0, 10.0].into_iter().map(|m| m * power).find(|s| *s >= raw * 0.999).unwrap_or(10.0 * power);
    let first = (low / step - 1e-9).ceil() as i64;
    let last = (high / step + 1e-9).floor() as i64;
    (first..=last).map(|k| k as f64 * step).collect()
}

/// A rectangular plot with two axes.
pub struct Frame {
    /// Width of the whole picture.
    pub width: f64,
    /// Height of the whole picture.
    pub height: f64,
    /// The horizontal axis.
    pub x: Axis,
    /// The vertical axis.
    pub y: Axis,
}

impl Frame {
    /// A plot of the given size over the given ranges, with room for ticks and titles.
    pub fn new(width: f64, height: f64, x: [f64; 2], y: [f64; 2]) -> Self {
        Self { width, height, x: Axis::new(x, [64.0, width - 14.0]), y: Axis::new(y, [height - 48.0, 12.0]) }
    }

    /// A line of words above the plot, at its left end.
    pub fn caption(&self, words: &str) -> String {
        text("tick key", [self.x.from, self.y.to - 8.0], "start", words)
    }

    /// The picture around some content. `title` is read by screen readers and shown on hover.
    pub fn wrap(&self, title: &str, content: &str) -> String {
        picture("plot", [self.width, self.height], title, content)
    }

    /// Grid, ticks, tick labels and axis titles. Without a vertical title there are no vertical ticks.
    pub fn axes(&self, x_title: &str, y_title: Option<&str>) -> String {
        let mut out = String::new();
        let (x, y) = (self.x, self.y);
        for t in ticks(x.low, x.high, (((x.to - x.from) / 85.0) as usize).max(4)) {
            let p = x.at(t);
            out += &path("grid", format_args!("M{p:.1},{:.1}V{:.1}", y.from, y.to));
            out += &text("tick", [p, y.from + 16.0], "middle", &number(t, 6));
        }
        if let Some(title) = y_title {
            for t in ticks(y.low, y.high, (((y.from - y.to) / 55.0) as usize).max(4)) {
                let p = y.at(t);
                out += &path("grid", format_args!("M{:.1},{p:.1}H{:.1}", x.from, x.to));
                out += &text("tick", [x.from - 7.0, p + 4.0], "end", &number(t, 6));
            }
            out += &upright([13.0, (y.from + y.to) / 2.0], title);
        }
        out += &path("axis", format_args!("M{:.1},{:.1}H{:.1}", x.from, y.from, x.to));
        let middle = [(x.from + x.to) / 2.0, self.height - 8.0];
        out + &text("title", middle, "middle", x_title)
    }

    /// A curve.
    pub fn line(&self, class: &str, times: &[f64], values: &[f64]) -> String {
        path(class, envelope(times.iter().zip(values), self))
    }

    /// The band between two curves.
    pub fn band(&self, times: &[f64], [low, high]: [&[f64]; 2]) -> String {
        let back = times.iter().zip(high).rev();
        path("band", envelope(times.iter().zip(low).chain(back), self) + "z")
    }
}

/// Turns a picture of the page into a file of its own, in light or dark as the reader's screen is.
pub fn standalone(svg: &str) -> String {
    let style = format!("{}@media (prefers-color-scheme: dark) {{ {} }}", rules(LIGHT), rules(DARK));
    with_style(svg, &style)
}

const LIGHT: usize = 0;
const DARK: usize = 1;

/// The style sheet's rules with its colours of light (or dark) written out: few programs but
/// browsers know variables.
fn rules(scheme: usize) -> String {
    const BEGIN: &str = ":root {";
    let colours = STYLE.split(BEGIN).nth(1 + scheme).unwrap_or_default().split('}').next().unwrap_or_default();
    // The rules after the last block of colours and the bracket of its media query.
    let rules = STYLE.rsplit(BEGIN).next().unwrap_or_default().splitn(3, '}').nth(2).unwrap_or_default().to_owned();
    colours
        .split(';')
        .filter_map(|c| c.trim().split_once(": "))
        .fold(rules, |rules, (name, colour)| rules.replace(&format!("var({name})"), colour))
}

fn with_style(svg: &str, style: &str) -> String {
    match svg.find('>') {
        Some(end) => format!(
            "{}<style>{style}</style><rect class=\"paper\" width=\"100%\" height=\"100%\"/>{}",
            &svg[..=end],
            &svg[end + 1..]
        ),
        None => svg.to_owned(),
    }
}

/// A polyline through the first, least, greatest and last value of every pixel column, in tenths of a pixel. Points that
/// follow each other in the same column are taken together.
fn envelope<'a>(points: impl Iterator<Item = (&'a f64, &'a f64)>, frame: &Frame) -> String {
    let mut d = String::new();
    let mut pen: Option<[i64; 2]> = None;
    let mut points =
        points.filter(|(_, v)| v.is_finite()).map(|(t, v)| (frame.x.at(*t), frame.y.clamped(*v))).peekable();
    let mut column = Vec::new();
    while let Some(first) = points.next() {
        column.clear();
        column.push(first);
        let in_column = |point: &(f64, f64)| point.0.floor() == first.0.floor();
        column.extend(std::iter::from_fn(|| points.next_if(in_column)));
        let least = column.iter().copied().min_by(|a, b| a.1.total_cmp(&b.1));
        let most = column.iter().copied().max_by(|a, b| a.1.total_cmp(&b.1));
        let mut kept: Vec<(f64, f64)> =
            [column.first().copied(), least, most, column.last().copied()].into_iter().flatten().collect();
        kept.sort_by(|a, b| a.0.total_cmp(&b.0));
        kept.dedup();
        for (px, py) in kept {
            let place = [px, py].map(|p| (10.0 * p).round() as i64);
            let [dx, dy] = match pen {
                Some([x, y]) => [place[0] - x, place[1] - y].map(tenths),
                None => place.map(tenths),
            };
            let mark = match pen {
                None => 'M',
                Some(before) if before == place => continue,
                Some(_) => 'l',
            };
            let _ = write!(d, "{mark}{dx},{dy}");
            pen = Some(place);
        }
    }
    d
}

/// A number of tenths, as short as can be.
fn tenths(number: i64) -> String {
    let sign = if number < 0 { "-" } else { "" };
    match [number.abs() / 10, number.abs() % 10] {
        [whole, 0] => format!("{sign}{whole}"),
        [0, part] => format!("{sign}.{part}"),
        [whole, part] => format!("{sign}{whole}.{part}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_have_their_colours_written_out() {
        let file = standalone("<svg class=\"plot\"><path class=\"axis\"/></svg>");
        assert!(!file.contains("var("), "{file}");
        assert!(file.contains(".plot .axis { stroke: #5a6672; }"), "{file}");
        assert!(file.contains(".plot .axis { stroke: #a2aeb9; }"), "{file}");
        assert_eq!(file.matches('{').count(), file.matches('}').count());
    }

    /// Both schemes: text on each background it stands on has a contrast of 4.5 or more (WCAG 2.2, 1.4.3).
    #[test]
    fn text_stands_out_from_its_background() {
        let schemes: Vec<&str> = STYLE.split(":root {").skip(1).collect();
        assert_eq!(schemes.len(), 2);
        for scheme in schemes {
            let colour = |name: &str| {
                let (_, rest) = scheme.split_once(&format!("--{name}: #")).unwrap();
                [0, 2, 4].map(|k| u8::from_str_radix(&rest[k..k + 2], 16).unwrap())
            };
            for text in ["ink", "soft", "in", "part", "mark", "good", "bad"] {
                for ground in ["paper", "card", "faint"] {
                    let ratio = contrast(colour(text), colour(ground));
                    assert!(ratio >= 4.5, "{text} on {ground}: {ratio:.2}");
                }
            }
        }
        assert!((contrast([0; 3], [255; 3]) - 21.0).abs() < 1e-9);
    }

    /// The contrast ratio of WCAG 2.2.
    fn contrast(a: [u8; 3], b: [u8; 3]) -> f64 {
        let linear = |part: u8| match f64::from(part) / 255.0 {
            small if small <= 0.04045 => small / 12.92,
            part => ((part + 0.055) / 1.055).powf(2.4),
        };
        let luminance = |colour: [u8; 3]| {
            let [red, green, blue] = colour.map(linear);
            0.2126 * red + 0.7152 * green + 0.0722 * blue
        };
        let [a, b] = [a, b].map(|colour| luminance(colour) + 0.05);
        a.max(b) / a.min(b)
    }

    #[test]
    fn ticks_are_round_and_inside() {
        assert_eq!(ticks(0.0, 1.0, 5), [0.0, 0.2, 0.4, 0.6000000000000001, 0.8, 1.0]);
        let t = ticks(81.27, 81.93, 5);
        assert!(t.len() >= 3 && t.iter().all(|v| (81.27..=81.93).contains(v)), "{t:?}");
        assert_eq!(ticks(3.0, 3.0, 5), [3.0]);
    }
}

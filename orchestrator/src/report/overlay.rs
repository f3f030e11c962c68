//! A measured curve in the picture of a signal, and the model's deviations from it.

use curves::Curve;
use result_document::{
    bins::axis_range,
    svg::{Frame, path},
};

/// A measured curve on the model's time, in the criterion's unit.
#[derive(Clone, Debug, Default)]
pub struct ReferenceCurve {
    /// Times, s, ascending.
    pub time: Vec<f64>,
    /// One value per time.
    pub values: Vec<f64>,
    /// The expanded uncertainty of each value; empty where it is not stated.
    pub uncertainty: Vec<f64>,
}

impl ReferenceCurve {
    /// The edges of the band of the measurement's uncertainty, below and above.
    fn edges(&self) -> Option<[Vec<f64>; 2]> {
        (self.uncertainty.len() == self.values.len()).then(|| {
            [-1.0, 1.0].map(|side| {
                self.values.iter().zip(&self.uncertainty).map(|(value, width)| value + side * width).collect()
            })
        })
    }

    /// All values that a picture must have room for.
    pub fn extremes(&self) -> Vec<f64> {
        self.values.iter().copied().chain(self.edges().into_iter().flatten().flatten()).collect()
    }

    /// The band, the curve, and its first and last time, between which the model is judged.
    pub fn draw(&self, frame: &Frame) -> String {
        let mut out = String::new();
        if let Some([low, high]) = self.edges() {
            out += &frame.band(&self.time, [&low, &high]);
        }
        for time in [self.time.first(), self.time.last()].into_iter().flatten() {
            let (x, y) = (frame.x.at(*time), frame.y);
            out += &path("judged", format_args!("M{x:.1},{:.1}V{:.1}", y.from, y.to));
        }
        out += &frame.line("line measured", &self.time, &self.values);
        out
    }

    /// The model's deviations from the measurement over the time of the run, with the band around zero.
    pub fn residuals(&self, name: &str, unit: &str, time: &[f64], model: &[f64]) -> Option<String> {
        let curve = Curve::new(time.to_vec(), model.to_vec()).ok()?;
        let [start, end] = curve.span();
        let deviations: Vec<f64> = self
            .time
            .iter()
            .zip(&self.values)
            .map(|(t, value)| Some(curve.at(t.clamp(start, end))? - value))
            .collect::<Option<_>>()?;
        let around = Self {
            time: self.time.clone(),
            values: vec![0.0; self.values.len()],
            uncertainty: self.uncertainty.clone(),
        };
        let mut all = around.extremes();
        all.extend(&deviations);
        let y = axis_range(all, f64::NAN, f64::NAN)?;
        let frame = Frame::new(560.0, 150.0, [start, end], y);
        let mut out = frame.axes("time (s)", Some(unit));
        out += &around.draw(&frame);
        out += &frame.line("line", &self.time, &deviations);
        Some(frame.wrap(&format!("{name}: model less measurement over time"), &out))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn residuals_are_the_models_deviations() {
        let measured =
            ReferenceCurve { time: vec![0.0, 1.0, 2.0], values: vec![0.0, 1.0, 2.0], uncertainty: vec![0.5; 3] };
        assert_eq!(measured.extremes().len(), 9);
        let of = |model: &[f64]| measured.residuals("y", "m", &[0.0, 2.0], model).unwrap();
        // A line in the middle of the picture, or one that leaves it.
        let path = |svg: String| svg.split("class=\"line\" d=\"").nth(1).unwrap().split('"').next().unwrap().to_owned();
        // An SVG path has steps after its first point: the second number of each leads down.
        let steps = |svg: String| {
            let down = |step: &str| step.split_once(',').unwrap().1.parse::<f64>().unwrap();
            path(svg).split('l').skip(1).map(down).collect::<Vec<_>>()
        };
        let equal = steps(of(&[0.0, 2.0]));
        assert_eq!(equal, [0.0, 0.0]);
        let steeper = steps(of(&[0.0, 4.0]));
        assert!(steeper[0] < 0.0, "{steeper:?}");
        assert!(measured.residuals("y", "m", &[0.0], &[1.0]).is_none());
    }

    #[test]
    fn a_long_recording_takes_no_more_room_than_the_picture_shows() {
        let count = 1_000_000;
        let time: Vec<f64> = (0..count).map(f64::from).collect();
        let values: Vec<f64> = (0..count).map(|k| f64::from(k % 7)).collect();
        let measured = ReferenceCurve { uncertainty: vec![0.5; values.len()], time, values };
        let frame = Frame::new(560.0, 150.0, [0.0, 1e6], [0.0, 7.0]);
        assert!(measured.draw(&frame).len() < 100_000);
    }
}

//! Values over time.

/// Values over growing times, with straight lines between them.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    times: Vec<f64>,
    values: Vec<f64>,
}

/// Why numbers are no curve. Rows count from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Fault {
    /// There are not as many times as values.
    #[error("there are {0} times and {1} values")]
    Lengths(usize, usize),
    /// There are fewer than two rows.
    #[error("a curve needs at least two rows, and there are {0}")]
    Few(usize),
    /// A time is not a finite number; its row.
    #[error("the time is not a finite number")]
    Time(usize),
    /// A value is not a finite number; its row.
    #[error("the value is not a finite number")]
    Value(usize),
    /// A time is not later than the one before; its row.
    #[error("the time is not later than the one before")]
    Order(usize),
}

impl Fault {
    /// The row at fault, where it is a single one.
    pub fn row(self) -> Option<usize> {
        match self {
            Self::Lengths(..) | Self::Few(_) => None,
            Self::Time(row) | Self::Value(row) | Self::Order(row) => Some(row),
        }
    }
}

impl Curve {
    /// A curve of these values at these times.
    ///
    /// # Errors
    /// When the numbers are not as many, not finite, or the times do not grow.
    pub fn new(times: Vec<f64>, values: Vec<f64>) -> Result<Self, Fault> {
        if times.len() != values.len() {
            return Err(Fault::Lengths(times.len(), values.len()));
        }
        if times.len() < 2 {
            return Err(Fault::Few(times.len()));
        }
        for (row, (time, value)) in times.iter().zip(&values).enumerate() {
            if !time.is_finite() {
                return Err(Fault::Time(row));
            }
            if !value.is_finite() {
                return Err(Fault::Value(row));
            }
            if row > 0 && *time <= times[row - 1] {
                return Err(Fault::Order(row));
            }
        }
        Ok(Self { times, values })
    }

    /// The times, growing.
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// The values at these times.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// The first and the last time.
    pub fn span(&self) -> [f64; 2] {
        [self.times[0], self.times[self.times.len() - 1]]
    }

    /// The value at a time; none before the first and after the last one.
    pub fn at(&self, time: f64) -> Option<f64> {
        let [first, last] = self.span();
        if !(first <= time && time <= last) {
            return None;
        }
        Some(self.between(self.times.partition_point(|&other| other < time), time))
    }

    /// The value at a time that is after row `after - 1` and not after row `after`.
    pub(crate) fn between(&self, after: usize, time: f64) -> f64 {
        if after == 0 || self.times[after] == time {
            return self.values[after];
        }
        let [t, u] = [self.times[after - 1], self.times[after]];
        let [v, w] = [self.values[after - 1], self.values[after]];
        v + (time - t) / (u - t) * (w - v)
    }

    /// The part with times between two others.
    ///
    /// # Errors
    /// When fewer than two rows are left.
    pub fn cut(&self, [from, to]: [f64; 2]) -> Result<Self, Fault> {
        let rows = self.rows([from, to]);
        Self::new(self.times[rows.clone()].to_vec(), self.values[rows].to_vec())
    }

    /// The rows with times between two others, these included.
    pub fn rows(&self, [from, to]: [f64; 2]) -> std::ops::Range<usize> {
        let first = self.times.partition_point(|&time| time < from);
        let end = self.times.partition_point(|&time| time <= to);
        first..end.max(first)
    }

    /// The usual distance of its times: the median. A gap does not change it.
    pub fn step(&self) -> f64 {
        let mut steps: Vec<f64> = self.times.windows(2).map(|w| w[1] - w[0]).collect();
        let middle = steps.len() / 2;
        *steps.select_nth_unstable_by(middle, f64::total_cmp).1
    }

    /// Whether the times are evenly spaced, but for rounding.
    pub fn is_even(&self) -> bool {
        let [first, last] = self.span();
        let step = (last - first) / (self.times.len() - 1) as f64;
        let mut places = self.times.iter().enumerate();
        places.all(|(row, time)| (time - (first + row as f64 * step)).abs() <= 1e-6 * step)
    }

    /// How many evenly spaced times [`Self::evenly`] gives.
    pub fn even_count(&self) -> f64 {
        let [first, last] = self.span();
        (((last - first) / self.step()).round()).max(1.0) + 1.0
    }

    /// The same curve on evenly spaced times from the first to the last one, as close to its usual step as that allows.
    /// A curve that is even already stays as it is.
    pub fn evenly(&self) -> Self {
        if self.is_even() {
            return self.clone();
        }
        let [first, last] = self.span();
        let parts = self.even_count() as usize - 1;
        let times: Vec<f64> = (0..=parts)
            .map(|part| match part {
                part if part == parts => last,
                part => first + (last - first) * (part as f64 / parts as f64),
            })
            .collect();
        Self {
            values: times.iter().map(|&time| self.at(time).expect("the times are those of the span")).collect(),
            times,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve(rows: &[(f64, f64)]) -> Curve {
        let (times, values) = rows.iter().copied().unzip();
        Curve::new(times, values).unwrap()
    }

    #[test]
    fn straight_lines_connect_the_rows() {
        let bend = curve(&[(0.0, 1.0), (2.0, 5.0), (3.0, -1.0)]);
        let at = |time| bend.at(time);
        assert_eq!(at(0.0), Some(1.0));
        assert_eq!(at(0.5), Some(2.0));
        assert_eq!(at(2.0), Some(5.0));
        assert_eq!(at(2.5), Some(2.0));
        assert_eq!(at(3.0), Some(-1.0));
        assert_eq!([at(-0.1), at(3.1), at(f64::NAN)], [None; 3]);
    }

    #[test]
    fn faults_name_their_row() {
        let of = |times: &[f64], values: &[f64]| {
            let fault = Curve::new(times.to_vec(), values.to_vec()).unwrap_err();
            (fault, fault.row())
        };
        assert_eq!(of(&[0.0, 1.0], &[1.0]).0, Fault::Lengths(2, 1));
        assert_eq!(of(&[0.0], &[1.0]).0, Fault::Few(1));
        assert_eq!(of(&[0.0, 1.0], &[1.0, f64::NAN]), (Fault::Value(1), Some(1)));
        assert_eq!(of(&[0.0, f64::INFINITY], &[1.0; 2]), (Fault::Time(1), Some(1)));
        assert_eq!(of(&[0.0, 1.0, 1.0], &[1.0; 3]), (Fault::Order(2), Some(2)));
    }

    #[test]
    fn a_gap_is_filled_with_a_straight_line() {
        let gap = curve(&[(0.0, 0.0), (1.0, 1.0), (2.0, 2.0), (5.0, 8.0), (6.0, 8.0)]);
        assert!(!gap.is_even());
        assert_eq!(gap.step(), 1.0);
        let even = gap.evenly();
        assert!(even.is_even());
        assert_eq!(even.times(), [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
        assert_eq!(even.values(), [0.0, 1.0, 2.0, 4.0, 6.0, 8.0, 8.0]);
        assert_eq!(even.evenly(), even);
    }

    #[test]
    fn a_window_keeps_its_ends() {
        let line = curve(&[(0.0, 0.0), (1.0, 1.0), (2.0, 2.0), (3.0, 3.0)]);
        assert_eq!(line.cut([1.0, 2.5]).unwrap().times(), [1.0, 2.0]);
        assert_eq!(line.cut([1.5, 2.5]), Err(Fault::Few(1)));
        assert_eq!(line.cut([5.0, 4.0]), Err(Fault::Few(0)));
    }
}

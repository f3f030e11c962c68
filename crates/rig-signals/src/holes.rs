//! Times without samples, over which a signal is drawn as a curve that nobody measured.

use super::clean::Cleaned;

/// A hole is longer than so many steps. What a spike of three samples leaves is none: the curve through its neighbours is
/// as good as what was cut out.
const LEAST: f64 = 4.5;

/// Begins and ends of the holes of a signal, s.
#[derive(Debug, Default, PartialEq)]
pub struct Holes(Vec<[f64; 2]>);

impl Holes {
    /// Those of a signal at growing times.
    pub fn of(time: &[f64], signal: &Cleaned) -> Self {
        let known: Vec<f64> = time
            .iter()
            .zip(&signal.values)
            .filter(|(time, value)| time.is_finite() && value.is_finite())
            .map(|(time, _)| *time)
            .collect();
        let mut steps: Vec<f64> = known.windows(2).map(|w| w[1] - w[0]).collect();
        if steps.is_empty() {
            return Self::default();
        }
        let middle = steps.len() / 2;
        let longest = LEAST * *steps.select_nth_unstable_by(middle, f64::total_cmp).1;
        let ends = known.windows(2).map(|w| [w[0], w[1]]);
        Self(ends.filter(|[from, to]| to - from > longest).collect())
    }

    /// Those of either of two signals, of which the other one is late by `shift`.
    pub fn and(&self, other: &Self, shift: f64) -> Self {
        let earlier = other.0.iter().map(|ends| ends.map(|end| end - shift));
        let mut all: Vec<[f64; 2]> = self.0.iter().copied().chain(earlier).collect();
        all.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let mut joined: Vec<[f64; 2]> = Vec::new();
        for [from, to] in all {
            match joined.last_mut() {
                Some([_, end]) if from <= *end => *end = end.max(to),
                _ => joined.push([from, to]),
            }
        }
        Self(joined)
    }

    /// The longest one.
    pub fn longest(&self) -> Option<[f64; 2]> {
        let length = |[from, to]: &[f64; 2]| to - from;
        self.0.iter().max_by(|a, b| length(a).total_cmp(&length(b))).copied()
    }

    /// Whether a time lies in one of them.
    fn has(&self, time: f64) -> bool {
        let next = self.0.partition_point(|[_, to]| *to <= time);
        self.0.get(next).is_some_and(|[from, _]| *from < time)
    }

    /// Turns of a signal without those that have a hole, and how many these are. The signal has even times from `start` on.
    pub fn whole_turns(&self, values: &[f64], turn: usize, [start, step]: [f64; 2]) -> Turns {
        let is_whole = |number: &usize| {
            let mut places = number * turn..(number + 1) * turn;
            !places.any(|place| self.has(start + place as f64 * step))
        };
        let all = values.len() / turn;
        let kept: Vec<usize> = (0..all).filter(is_whole).collect();
        let chosen = |number: usize| values[number * turn..(number + 1) * turn].iter().copied();
        Turns {
            // Where no turn is whole, a curve through the holes is all there is.
            values: if kept.is_empty() {
                values[..all * turn].to_vec()
            } else {
                kept.iter().flat_map(|&number| chosen(number)).collect()
            },
            lost: all - kept.len(),
            all,
        }
    }
}

/// A signal's turns.
pub struct Turns {
    /// The samples of those that count.
    pub values: Vec<f64>,
    /// How many have a hole.
    pub lost: usize,
    /// How many there are.
    pub all: usize,
}

impl Turns {
    /// The concern about those with a hole, for the reader; `what` is a turn or a sample.
    pub fn concern(&self, name: &str, what: &str) -> Option<String> {
        let (lost, all) = (self.lost, self.all);
        match lost {
            0 => None,
            lost if lost == all => Some(format!(
                "each {what} of {name} has a gap of more than 4 samples, so its mean counts curves through them as if they were \
                 measured: record without gaps"
            )),
            _ => Some(format!(
                "{lost} of {all} {what}s of {name} lie in gaps of more than 4 samples, and do not count in its mean"
            )),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clean::{Drop, clean};

    /// Steps of 1 s with one value missing at 20 s, and none from 40 s to 45 s.
    #[test]
    fn only_long_gaps_are_holes() {
        let time: Vec<f64> = (0..100).map(f64::from).collect();
        let missing = |t: f64| t == 20.0 || (41.0..45.0).contains(&t);
        let values: Vec<f64> = time.iter().map(|t| if missing(*t) { f64::NAN } else { *t }).collect();
        let holes = Holes::of(&time, &clean(&values, Drop::default()));
        assert_eq!(holes, Holes(vec![[40.0, 45.0]]));
        assert_eq!([40.0, 40.1, 44.9, 45.0].map(|t| holes.has(t)), [false, true, true, false]);
        let both = holes.and(&Holes(vec![[43.0, 48.0], [70.0, 75.0]]), 1.0);
        assert_eq!(both, Holes(vec![[40.0, 47.0], [69.0, 74.0]]));
        let turns = holes.whole_turns(&time, 10, [0.0, 1.0]);
        assert_eq!((turns.lost, turns.all, turns.values.len()), (1, 10, 90));
        assert_eq!(turns.values[39..41], [39.0, 50.0]);
        let all = holes.whole_turns(&time, 100, [0.0, 1.0]);
        assert_eq!((all.lost, all.values.len()), (1, 100));
        assert_eq!(Holes::default().whole_turns(&time, 7, [0.0, 1.0]).values.len(), 98);
    }
}

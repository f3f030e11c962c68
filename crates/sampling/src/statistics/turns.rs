//! The mean over whole turns of an angle.

/// A signal and an angle on straight lines, until the last turn that is complete. An angle may grow or shrink, but must not
/// jump back after a turn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeanOverTurns {
    /// How much the angle changes in a turn.
    turn: f64,
    first: Option<f64>,
    /// The last value, and the turns until then.
    last: [f64; 2],
    /// Time and the signal's integral since the first value.
    all: [f64; 2],
    /// The same at the end of the last complete turn.
    whole: [f64; 2],
    turns: f64,
}

impl MeanOverTurns {
    /// Without values; `turn` is the angle of a turn, more than zero.
    pub fn new(turn: f64) -> Self {
        Self {
            turn,
            first: None,
            last: [0.0; 2],
            all: [0.0; 2],
            whole: [0.0; 2],
            turns: 0.0,
        }
    }

    /// Takes a value and the angle at it, `elapsed` after the one before; the first one after zero.
    pub fn add(&mut self, elapsed: f64, value: f64, angle: f64) {
        const ROUNDING: f64 = 1e-9;
        let turned = (angle - *self.first.get_or_insert(angle)).abs() / self.turn;
        let [before, then] = self.last;
        let complete = (turned + ROUNDING).floor();
        if complete > self.turns {
            let share = ((complete - then) / (turned - then)).min(1.0);
            let mean = before + 0.5 * share * (value - before);
            let part = share * elapsed;
            self.whole = [self.all[0] + part, self.all[1] + part * mean];
            self.turns = complete;
        }
        self.all[0] += elapsed;
        self.all[1] += 0.5 * elapsed * (before + value);
        self.last = [value, turned];
    }

    /// The mean; not a number where no turn was completed, or a value before its end was none.
    pub fn result(&self) -> f64 {
        self.whole[1] / self.whole[0]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// Over whole turns the mean of a signal of the angle is known, although the run ends within a turn.
    #[test]
    fn the_part_of_a_turn_does_not_count() {
        for direction in [1.0, -1.0] {
            let mut mean = MeanOverTurns::new(TAU);
            for k in 0..=3600_u32 {
                let turned = 1e-3 * f64::from(k);
                let value = 5.0 + (TAU * turned).cos() + 0.5 * (2.0 * TAU * turned).sin();
                mean.add(
                    if k == 0 { 0.0 } else { 0.01 },
                    value,
                    7.0 + direction * TAU * turned,
                );
            }
            assert!((mean.result() - 5.0).abs() < 1e-12, "{}", mean.result());
        }
    }

    /// The signal is the time; the angle goes on, back a little, and on again.
    #[test]
    fn turns_end_between_values() {
        let mut mean = MeanOverTurns::new(360.0);
        mean.add(0.0, 0.0, 10.0);
        assert!(mean.result().is_nan());
        mean.add(0.5, 0.5, 190.0);
        assert!(mean.result().is_nan());
        mean.add(1.0, 1.5, 730.0);
        assert_eq!(mean.result(), 0.75);
        mean.add(0.5, 2.0, 1000.0);
        assert_eq!(mean.result(), 0.75);
        mean.add(0.5, f64::NAN, 900.0);
        assert_eq!(mean.result(), 0.75);
        mean.add(0.5, 3.0, 1090.0);
        assert!(mean.result().is_nan());
        // One and a half turns in a second: the first one takes two thirds of it.
        let mut within = MeanOverTurns::new(1.0);
        within.add(0.0, 0.0, 0.0);
        within.add(1.0, 1.0, 1.5);
        assert!((within.result() - 1.0 / 3.0).abs() < 1e-15);
    }
}

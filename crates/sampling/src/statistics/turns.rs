//! The mean over whole turns of an angle.

/// Values are added up by so much smaller, so that no sum of finite ones is infinite. A power of two rounds nothing.
const SCALE: f64 = 1.0 / (1_u64 << 40) as f64;

/// A signal and an angle on straight lines, until the last turn that is complete. An angle may grow or shrink, but must not
/// jump back after a turn: a way back of more than half a turn between two values is taken for such a jump.
#[derive(Clone, Copy, Debug, Default)]
pub struct MeanOverTurns {
    /// How much the angle changes in a turn.
    turn: f64,
    first: Option<f64>,
    /// The last value, and the turns until then, with their sign.
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
        Self { turn, ..Self::default() }
    }

    /// Takes a value and the angle at it, `elapsed` after the one before; the first one after zero.
    pub fn add(&mut self, elapsed: f64, value: f64, angle: f64) {
        let value = SCALE * value;
        const ROUNDING: f64 = 1e-9;
        const JUMP: f64 = 0.5;
        let signed = (angle - *self.first.get_or_insert(angle)) / self.turn;
        let [before, last] = self.last;
        let (turned, then) = (signed.abs(), last.abs());
        let jumps = (signed - last) * last.signum() < -JUMP;
        let complete = (turned + ROUNDING).floor();
        // Without all angles nobody knows how many turns there were, nor when they ended.
        if !signed.is_finite() || jumps && then > 0.0 {
            (self.whole, self.turns) = ([f64::NAN; 2], f64::INFINITY);
        } else if complete > self.turns {
            let share = ((complete - then) / (turned - then)).min(1.0);
            let mean = before + 0.5 * share * (value - before);
            let part = share * elapsed;
            self.whole = [self.all[0] + part, self.all[1] + part * mean];
            self.turns = complete;
        }
        self.all[0] += elapsed;
        self.all[1] += 0.5 * elapsed * (before + value);
        self.last = [value, signed];
    }

    /// The mean; not a number where no turn was completed, a value before its end or any angle was none, or the angle
    /// jumped back.
    pub fn result(&self) -> f64 {
        self.whole[1] / self.whole[0] / SCALE
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
                mean.add(if k == 0 { 0.0 } else { 0.01 }, value, 7.0 + direction * TAU * turned);
            }
            assert!((mean.result() - 5.0).abs() < 1e-12, "{}", mean.result());
        }
    }

    #[test]
    fn the_largest_numbers_have_a_mean() {
        let mut mean = MeanOverTurns::new(1.0);
        for (elapsed, value, angle) in [(0.0, 1e308, 0.0), (50.0, -1e308, 0.5), (50.0, 1.7e308, 1.0)] {
            mean.add(elapsed, value, angle);
        }
        assert!((mean.result() / 0.175e308 - 1.0).abs() < 1e-12, "{}", mean.result());
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
        // From half a turn to one and a half: the turn ends half way between.
        let mut between = MeanOverTurns::new(1.0);
        for (elapsed, value, angle) in [(0.0, 0.0, 0.0), (1.0, 1.0, 0.5), (1.0, 3.0, 1.5)] {
            between.add(elapsed, value, angle);
        }
        assert_eq!(between.result(), (0.5 + 0.75) / 1.5);
        // The first step may go back by more than half a turn.
        let mut at_once = MeanOverTurns::new(1.0);
        for (elapsed, angle) in [(0.0, 0.0), (1.0, -0.75), (1.0, -1.5)] {
            at_once.add(elapsed, 2.0, angle);
        }
        assert_eq!(at_once.result(), 2.0);
        // Half a turn back is still a way back.
        let mut back = MeanOverTurns::new(1.0);
        for (elapsed, angle) in [(0.0, 0.0), (1.0, 1.5), (1.0, 1.0), (1.0, 1.75)] {
            back.add(elapsed, 2.0, angle);
        }
        assert_eq!(back.result(), 2.0);
        // One and a half turns in a second: the first one takes two thirds of it.
        let mut within = MeanOverTurns::new(1.0);
        within.add(0.0, 0.0, 0.0);
        within.add(1.0, 1.0, 1.5);
        assert!((within.result() - 1.0 / 3.0).abs() < 1e-15);
    }

    /// A crank angle of a four-stroke engine is often written from 0 to 720 degrees: a turn is complete before it jumps back.
    #[test]
    fn angles_that_jump_back_or_are_none_give_no_mean() {
        let of = |angle: fn(f64) -> f64| {
            let mut mean = MeanOverTurns::new(360.0);
            for k in 0..=400_u32 {
                let time = 0.01 * f64::from(k);
                mean.add(if k == 0 { 0.0 } else { 0.01 }, time, angle(time));
            }
            mean.result()
        };
        assert!((of(|time| 360.0 * time) - 2.0).abs() < 1e-12);
        assert!((of(|time| 100.0 - 360.0 * time) - 2.0).abs() < 1e-12);
        for angle in [
            |time: f64| (360.0 * time) % 720.0,
            |time: f64| (-360.0 * time) % 720.0,
            |time: f64| (200.0 + 360.0 * time) % 720.0,
            |time: f64| (360.0 * time).rem_euclid(360.0),
            |time: f64| (360.0 * time + 180.0).rem_euclid(360.0) - 180.0,
            // The value before the end of a turn: when it ended is not known.
            |time: f64| if (time - 1.99).abs() < 1e-6 { f64::NAN } else { 360.0 * time },
            |time: f64| if time > 2.5 { f64::INFINITY } else { 360.0 * time },
        ] {
            assert!(of(angle).is_nan(), "{}", of(angle));
        }
    }
}

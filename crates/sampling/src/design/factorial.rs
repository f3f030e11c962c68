//! Full factorial designs: every combination of the levels of all inputs. The levels of an input are the
//! middles of equally probable slices, so that every point stands for the same probability.

use super::rule::{Inputs, Numbers, Registered, Rule};

/// A grid.
#[derive(Clone, Debug)]
pub(super) struct Grid {
    levels: Vec<u64>,
}

impl Registered for Grid {
    const BY_LEVELS: bool = true;

    fn new(_: &Numbers, inputs: &Inputs) -> Result<Self, String> {
        if inputs.correlation.is_some() {
            return Err("a full factorial combines all levels and knows no correlations".to_owned());
        }
        let levels = inputs.distributions.iter().zip(&inputs.levels);
        let levels = levels.filter(|(input, _)| input.varies()).map(|(_, levels)| {
            levels.filter(|&levels| levels > 0).ok_or("a full factorial needs `levels` for every parameter that varies")
        });
        Self::of(levels.collect::<Result<_, _>>()?)
    }
}

impl Rule for Grid {
    /// The last input changes fastest.
    fn uniform(&self, index: u64, dimension: u32) -> f64 {
        let place = dimension as usize;
        let faster: u64 = self.levels[place + 1..].iter().product();
        let level = index / faster % self.levels[place];
        (level as f64 + 0.5) / self.levels[place] as f64
    }

    fn points(&self) -> Option<u64> {
        let mut levels = self.levels.iter();
        levels.try_fold(1_u64, |size, &levels| size.checked_mul(levels))
    }
}

impl Grid {
    /// A grid with this many levels for each input.
    fn of(levels: Vec<u64>) -> Result<Self, String> {
        let grid = Self { levels };
        match grid.points() {
            Some(_) => Ok(grid),
            None => Err("the levels make more points than can be counted".to_owned()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_combination_comes_once_and_in_order() {
        let grid = Grid::of(vec![2, 1, 3]).unwrap();
        let points: Vec<[f64; 3]> = (0..grid.points().unwrap())
            .map(|index| [0, 1, 2].map(|dimension| grid.uniform(index, dimension)))
            .collect();
        let [low, middle, high] = [1.0, 3.0, 5.0].map(|sixth| sixth / 6.0);
        let row = |a| [low, middle, high].map(|c| [a, 0.5, c]);
        assert_eq!(points, [row(0.25), row(0.75)].concat());
    }

    #[test]
    fn absurd_grids_are_refused() {
        assert!(Grid::of(vec![1000; 10]).is_err());
    }
}

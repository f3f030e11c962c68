//! Correlations of a Gaussian process between two points.
//!
//! The correlation is the product over the coordinates of (1 + t m(r)) / (1 + t): m is Matern's correlation of the distance r
//! in that coordinate. Multiplied out it is a sum of functions of one coordinate, of two, of three and so on (Durrande et al.
//! 2013, "ANOVA kernels and RKHS of zero mean functions", without the centring). A small t makes the process nearly a sum of
//! functions of single coordinates, which few runs determine; a large one lets all coordinates interact.

use crate::arithmetic::power_of_2;
use nalgebra::DMatrix;
use sampling::random::Random;
use std::f64::consts::LOG2_E;

/// The smallest nugget, for the condition of the matrices.
pub const LEAST_NUGGET: f64 = 1e-9;

/// Farther from the centre than this many scaled distances, points are as good as infinitely far from the runs.
pub const FARTHEST: f64 = 700.0;

/// How smooth the process is. Which one fits is inferred from the runs, and several may share the weight.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Smoothness {
    /// Matern 3/2: differentiable once.
    Once,
    /// Matern 5/2: differentiable twice.
    Twice,
    /// Gaussian correlation: differentiable as often as one likes.
    Always,
}

impl Smoothness {
    /// All there are, the roughest first.
    pub const ALL: [Self; 3] = [Self::Once, Self::Twice, Self::Always];

    /// By a distance a, which is that over the length scale times the first number, and e = exp(-a) or exp(-a^2 / 2), Matern's correlation
    /// is (1 + f a + g a^2) e with the next two, and its derivative by the logarithm of the length scale a^2 (h + g a) e with the last.
    fn factors(self) -> [f64; 4] {
        match self {
            Self::Once => [3_f64.sqrt(), 1.0, 0.0, 1.0],
            Self::Twice => [5_f64.sqrt(), 1.0, 1.0 / 3.0, 1.0 / 3.0],
            Self::Always => [1.0, 0.0, 0.0, 1.0],
        }
    }

    /// A random frequency in one scaled coordinate, from the spectral density (Rahimi & Recht 2007, "Random features for
    /// large-scale kernel machines"; for Matern's correlations it is Student's t distribution with twice their order).
    fn frequency(self, random: &mut Random) -> f64 {
        let freedom = match self {
            Self::Once => 3,
            Self::Twice => 5,
            Self::Always => return random.normal(),
        };
        let squares: f64 = random.normals(freedom).iter().map(|z| z * z).sum();
        random.normal() * (freedom as f64 / squares).sqrt()
    }
}

/// Points by coordinate: their distances from the centre, over the length scale, and the exponentials of these and of their opposites.
/// The exponential of the distance of two points is a product of these, so that pairs need none.
pub type Places = Vec<[Vec<f64>; 3]>;

/// The correlation.
#[derive(Clone, Debug)]
pub struct Kernel {
    smoothness: Smoothness,
    lengths: Vec<f64>,
    /// t / (1 + t).
    varies: f64,
    /// The variance of the independent errors, over that of the process.
    pub nugget: f64,
}

impl Kernel {
    /// By the logarithms of the length scales, of t and of the nugget.
    pub fn new(smoothness: Smoothness, unknowns: &[f64]) -> Self {
        let d = unknowns.len() - 2;
        Self {
            smoothness,
            lengths: unknowns[..d].iter().map(|u| u.exp()).collect(),
            varies: 1.0 / (1.0 + (-unknowns[d]).exp()),
            nugget: unknowns[d + 1].exp().max(LEAST_NUGGET),
        }
    }

    /// Prepares points, one a column.
    pub fn places(&self, points: &DMatrix<f64>) -> Places {
        let [root, ..] = self.smoothness.factors();
        let one = |(k, length): (usize, &f64)| {
            let at: Vec<f64> = points.row(k).iter().map(|x| x * root / length).collect();
            let raised = |sign: f64| at.iter().map(|a| (sign * a).clamp(-FARTHEST, FARTHEST).exp()).collect();
            let (up, down) = (raised(1.0), raised(-1.0));
            [at, up, down]
        };
        self.lengths.iter().enumerate().map(one).collect()
    }

    /// Multiplies values by the factor that a coordinate has in the correlations of places with another one. Where asked for, `slopes` are
    /// the derivatives of the logarithm of the correlation by those of the length scale and, added to what is there already, of t.
    pub fn multiply<const SLOPED: bool>(
        &self,
        places: [&[f64]; 3],
        other: [f64; 3],
        values: &mut [f64],
        slopes: [&mut [f64]; 2],
    ) {
        // Compilers do several places at once where a loop calls nothing.
        match self.smoothness == Smoothness::Always {
            true => self.multiplied::<SLOPED, true>(places, other, values, slopes),
            false => self.multiplied::<SLOPED, false>(places, other, values, slopes),
        }
    }

    fn multiplied<const SLOPED: bool, const ALWAYS: bool>(
        &self,
        [at, up, down]: [&[f64]; 3],
        [x, u, d]: [f64; 3],
        values: &mut [f64],
        [by_length, by_interaction]: [&mut [f64]; 2],
    ) {
        let ([_, f, g, h], varies) = (self.smoothness.factors(), self.varies);
        let slopes = by_length.iter_mut().zip(by_interaction);
        let places = at.iter().zip(up.iter().zip(down));
        for ((value, (at, (up, down))), (by_length, by_interaction)) in values.iter_mut().zip(places).zip(slopes) {
            let a = (at - x).abs();
            // One of the products is exp(-a), and the other its inverse.
            let (above, below) = (up * d, down * u);
            let nearest = if above < below { above } else { below };
            // The power is exact to 1e-14 of it; nuggets, which are 1e-9 or more, hide that.
            let e = if ALWAYS { power_of_2((-0.5 * LOG2_E * (a * a)).max(-FARTHEST)) } else { nearest };
            let m = (1.0 + f * a + g * a * a) * e;
            let factor = 1.0 - varies + varies * m;
            *value *= factor;
            if SLOPED {
                *by_length = varies * a * a * (h + g * a) * e / factor;
                *by_interaction += varies * (m / factor - 1.0);
            }
        }
    }

    /// A random frequency of all coordinates: zero in those with which its wave does not vary.
    pub fn frequency(&self, random: &mut Random) -> Vec<f64> {
        let one = |length: &f64| {
            if random.unit() < self.varies { self.smoothness.frequency(random) / length } else { 0.0 }
        };
        self.lengths.iter().map(one).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sampling::random::Purpose;

    /// Of two points, with derivatives by the logarithms of all length scales and t.
    fn between(smoothness: Smoothness, unknowns: &[f64], a: &[f64], b: &[f64]) -> (f64, Vec<f64>) {
        let d = a.len();
        let kernel = Kernel::new(smoothness, unknowns);
        let places = kernel.places(&DMatrix::from_fn(d, 2, |k, i| if i == 0 { a[k] } else { b[k] }));
        let (mut plain, mut value, mut slopes, mut last) = ([1.0], [1.0], vec![0.0; d], [0.0]);
        for (k, of) in places.iter().enumerate() {
            let (first, other) = (of.each_ref().map(|v| &v[..1]), of.each_ref().map(|v| v[1]));
            kernel.multiply::<false>(first, other, &mut plain, [&mut [0.0], &mut [0.0]]);
            kernel.multiply::<true>(first, other, &mut value, [&mut slopes[k..=k], &mut last]);
        }
        assert_eq!(plain, value);
        slopes.push(last[0]);
        (value[0], slopes)
    }

    /// Rasmussen & Williams (2006), "Gaussian Processes for Machine Learning", equations 4.9 and 4.17.
    #[test]
    fn correlations_are_the_published_ones() {
        let (r, root) = (0.7_f64 / 0.4, |n: f64| n.sqrt());
        let published = [
            (1.0 + root(3.0) * r) * (-root(3.0) * r).exp(),
            (1.0 + root(5.0) * r + 5.0 * r * r / 3.0) * (-root(5.0) * r).exp(),
            (-0.5 * r * r).exp(),
        ];
        for (smoothness, published) in Smoothness::ALL.into_iter().zip(published) {
            let told = between(smoothness, &[0.4_f64.ln(), 40.0, 0.0], &[0.2], &[0.9]).0;
            assert!((told - published).abs() < 1e-12, "{told} {published}");
        }
    }

    #[test]
    fn derivatives_are_those_of_differences() {
        for smoothness in Smoothness::ALL {
            let unknowns = [0.3, -0.8, 0.4, 0.0];
            let logarithm = |k: usize, h: f64| {
                let mut moved = unknowns;
                moved[k] += h;
                between(smoothness, &moved, &[0.3, -1.0], &[1.1, -0.6])
            };
            for k in 0..3 {
                let slope = (logarithm(k, 1e-5).0.ln() - logarithm(k, -1e-5).0.ln()) / 2e-5;
                let told = logarithm(k, 0.0).1[k];
                assert!((slope - told).abs() < 1e-8, "{smoothness:?} {slope} {told}");
            }
        }
    }

    #[test]
    fn far_points_are_not_correlated_and_equal_ones_are() {
        for smoothness in Smoothness::ALL {
            let of = |a: f64, b: f64| between(smoothness, &[0.02_f64.ln(), 40.0, 0.0], &[a], &[b]).0;
            assert!((of(3.0, 3.0) - 1.0).abs() < 1e-12 && of(3.0, 1e6) < 1e-60);
        }
    }

    /// The mean of cos(w (x - y)) over the frequencies is the correlation (Bochner's theorem).
    #[test]
    fn frequencies_have_the_spectrum_of_the_correlation() {
        for smoothness in Smoothness::ALL {
            let mut random = Random::new(1, Purpose::Unstated, 0);
            let unknowns = [0.0, 0.2, 0.0, 1.5_f64.ln(), 0.0];
            let kernel = Kernel::new(smoothness, &unknowns);
            let apart = [0.6, -0.3, 0.2];
            let count = 40_000;
            let wave = |_| kernel.frequency(&mut random).iter().zip(apart).map(|(w, x)| w * x).sum::<f64>().cos();
            let mean = (0..count).map(wave).sum::<f64>() / f64::from(count);
            let (told, _) = between(smoothness, &unknowns, &apart, &[0.0; 3]);
            assert!((mean - told).abs() < 0.015, "{smoothness:?} {mean}");
        }
    }
}

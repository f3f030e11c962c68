//! Correlations of a Gaussian process between two points.
//!
//! The correlation is the product over the coordinates of (1 + t m(r)) / (1 + t): m is Matern's correlation of the distance r
//! in that coordinate. Multiplied out it is a sum of functions of one coordinate, of two, of three and so on (Durrande et al.
//! 2013, "ANOVA kernels and RKHS of zero mean functions", without the centring). A small t makes the process nearly a sum of
//! functions of single coordinates, which few runs determine; a large one lets all coordinates interact.

use sampling::random::Random;

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

    /// Matern's correlation in one coordinate at a squared scaled distance, and its derivative by the latter.
    pub fn at(self, squared: f64) -> (f64, f64) {
        match self {
            Self::Once => {
                let a = (3.0 * squared).sqrt();
                let e = (-a).exp();
                ((1.0 + a) * e, -1.5 * e)
            }
            Self::Twice => {
                let a = (5.0 * squared).sqrt();
                let e = (-a).exp();
                ((1.0 + a + a * a / 3.0) * e, -5.0 / 6.0 * (1.0 + a) * e)
            }
            Self::Always => {
                let e = (-0.5 * squared).exp();
                (e, -0.5 * e)
            }
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

/// The correlation in coordinates that are divided by their length scales.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kernel {
    /// How smooth the process is.
    pub smoothness: Smoothness,
    /// The weight t of what varies with a coordinate, over what does not.
    pub interaction: f64,
}

impl Kernel {
    /// The correlation of two points.
    pub fn between(self, a: &[f64], b: &[f64]) -> f64 {
        let t = self.interaction;
        let factor = |(a, b): (&f64, &f64)| 1.0 + t * self.smoothness.at((a - b) * (a - b)).0;
        a.iter().zip(b).map(factor).product::<f64>() * (1.0 + t).powi(-(a.len() as i32))
    }

    /// The correlation by the squared scaled distance in each coordinate. Into `slopes` go the derivatives of its logarithm by
    /// the logarithm of each length scale, and last by that of the interaction.
    pub fn sloped(self, squared: impl Iterator<Item = f64>, slopes: &mut [f64]) -> f64 {
        let t = self.interaction;
        let last = slopes.len() - 1;
        let (mut value, mut by_interaction) = (1.0, 0.0);
        for (squared, slope) in squared.zip(&mut slopes[..last]) {
            let (m, by_squared) = self.smoothness.at(squared);
            let factor = 1.0 + t * m;
            value *= factor / (1.0 + t);
            *slope = -2.0 * squared * t * by_squared / factor;
            by_interaction += t * m / factor - t / (1.0 + t);
        }
        slopes[last] = by_interaction;
        value
    }

    /// A random frequency of all coordinates: zero in those with which its wave does not vary.
    pub fn frequency(self, dimensions: usize, random: &mut Random) -> Vec<f64> {
        let varies = self.interaction / (1.0 + self.interaction);
        let one = |_| if random.unit() < varies { self.smoothness.frequency(random) } else { 0.0 };
        (0..dimensions).map(one).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sampling::random::Purpose;

    /// Rasmussen & Williams (2006), "Gaussian Processes for Machine Learning", equations 4.9 and 4.17.
    #[test]
    fn correlations_are_the_published_ones() {
        let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} {b}");
        let (r, root) = (0.7_f64, |n: f64| n.sqrt());
        near(Smoothness::Once.at(r * r).0, (1.0 + root(3.0) * r) * (-root(3.0) * r).exp());
        near(Smoothness::Twice.at(r * r).0, (1.0 + root(5.0) * r + 5.0 * r * r / 3.0) * (-root(5.0) * r).exp());
        near(Smoothness::Always.at(r * r).0, (-0.5 * r * r).exp());
    }

    #[test]
    fn derivatives_are_those_of_differences() {
        for smoothness in Smoothness::ALL {
            for squared in [0.01, 0.5, 4.0] {
                let h = 1e-6;
                let slope = (smoothness.at(squared + h).0 - smoothness.at(squared - h).0) / (2.0 * h);
                assert!((slope - smoothness.at(squared).1).abs() < 1e-6, "{smoothness:?} {squared}");
            }
        }
    }

    /// The mean of cos(w (x - y)) over the frequencies is the correlation (Bochner's theorem).
    #[test]
    fn frequencies_have_the_spectrum_of_the_correlation() {
        for smoothness in Smoothness::ALL {
            let mut random = Random::new(1, Purpose::Unstated, 0);
            let kernel = Kernel { smoothness, interaction: 1.5 };
            let apart = [0.6, -0.3, 0.2];
            let count = 40_000;
            let wave = |_| {
                let frequency = kernel.frequency(3, &mut random);
                frequency.iter().zip(apart).map(|(w, x)| w * x).sum::<f64>().cos()
            };
            let mean = (0..count).map(wave).sum::<f64>() / f64::from(count);
            assert!((mean - kernel.between(&apart, &[0.0; 3])).abs() < 0.015, "{smoothness:?} {mean}");
        }
    }
}

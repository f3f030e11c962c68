//! Correlations of a Gaussian process between two points, by their distance in scaled coordinates.

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

    /// The correlation at a squared scaled distance, and its derivative by the latter.
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

    /// A random frequency in scaled coordinates, from the spectral density (Rahimi & Recht 2007, "Random features for
    /// large-scale kernel machines"; for Matern correlations it is Student's t distribution with twice their order).
    pub fn frequency(self, dimensions: usize, random: &mut Random) -> Vec<f64> {
        let freedom = match self {
            Self::Once => 3,
            Self::Twice => 5,
            Self::Always => 0,
        };
        let mut frequency = random.normals(dimensions);
        if freedom > 0 {
            let squares: f64 = random.normals(freedom).iter().map(|z| z * z).sum();
            let factor = (freedom as f64 / squares).sqrt();
            frequency.iter_mut().for_each(|f| *f *= factor);
        }
        frequency
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
            let apart = [0.6, -0.3, 0.2];
            let squared: f64 = apart.iter().map(|x| x * x).sum();
            let count = 40_000;
            let wave = |_| {
                let frequency = smoothness.frequency(3, &mut random);
                frequency.iter().zip(apart).map(|(w, x)| w * x).sum::<f64>().cos()
            };
            let mean = (0..count).map(wave).sum::<f64>() / f64::from(count);
            assert!((mean - smoothness.at(squared).0).abs() < 0.015, "{smoothness:?} {mean}");
        }
    }
}

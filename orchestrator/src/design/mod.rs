//! Which points a study simulates.
//!
//! Point `i` depends on the seed and on `i` alone (a Latin hypercube, also on the number of
//! points): shards, workers, an interrupted run and an extension all see the same points.

mod hypercube;
mod random;
mod sobol;

use crate::distribution::Distribution;
use crate::study;
use crate::study::Method;

use hypercube::Hypercube;
use sobol::Nets;

/// A rule that gives every index its point.
#[derive(Clone, Debug)]
pub struct Design {
    rule: Rule,
    seed: u64,
    points: u64,
    inputs: Vec<Distribution>,
}

#[derive(Clone, Debug)]
enum Rule {
    MonteCarlo,
    LatinHypercube(Hypercube),
    Sobol(Nets),
}

impl Design {
    /// A design over these inputs.
    ///
    /// # Errors
    /// When the method cannot serve so many inputs or points.
    pub fn new(design: &study::Design, inputs: Vec<Distribution>) -> Result<Self, String> {
        if design.points == 0 {
            return Err("points must be at least 1".to_owned());
        }
        if design.replicates == 0 {
            return Err("replicates must be at least 1".to_owned());
        }
        if design.replicates > 1 && design.method != Method::Sobol {
            return Err(
                "replicates belong to method = \"sobol\"; the points of the others tell \
                        by themselves how sure a count is"
                    .to_owned(),
            );
        }
        let dimensions = inputs.iter().filter(|input| input.varies()).count();
        let rule = match design.method {
            Method::MonteCarlo => Rule::MonteCarlo,
            Method::LatinHypercube => {
                Rule::LatinHypercube(Hypercube::new(design.seed, design.points))
            }
            Method::Sobol => Rule::Sobol(Nets::new(design, dimensions)?),
        };
        Ok(Self {
            rule,
            seed: design.seed,
            points: design.points,
            inputs,
        })
    }

    /// How many points there are.
    pub fn len(&self) -> u64 {
        self.points
    }

    /// Whether there is no point at all; there always is one.
    pub fn is_empty(&self) -> bool {
        self.points == 0
    }

    /// The parameters of the point at an index from 0.
    pub fn point(&self, index: u64) -> Vec<f64> {
        let mut dimension = 0;
        let value = |input: &Distribution| {
            if !input.varies() {
                return input.median();
            }
            let u = self.uniform(index, dimension);
            dimension += 1;
            input.quantile(u)
        };
        self.inputs.iter().map(value).collect()
    }

    /// A number in (0, 1).
    fn uniform(&self, index: u64, dimension: u32) -> f64 {
        match &self.rule {
            Rule::MonteCarlo => {
                random::uniform(self.seed, random::Purpose::Point, index, dimension)
            }
            Rule::LatinHypercube(hypercube) => hypercube.uniform(index, dimension),
            Rule::Sobol(nets) => nets.uniform(index, dimension),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn design(method: Method, points: u64, seed: u64) -> Design {
        let settings = study::Design {
            method,
            points,
            seed,
            replicates: if method == Method::Sobol { 4 } else { 1 },
        };
        let normal = Distribution::Normal {
            mean: 0.0,
            deviation: 1.0,
        };
        let fixed = Distribution::Fixed { value: 3.0 };
        Design::new(&settings, vec![normal, fixed, normal, normal]).unwrap()
    }

    const METHODS: [Method; 3] = [Method::MonteCarlo, Method::LatinHypercube, Method::Sobol];

    #[test]
    #[allow(clippy::cast_precision_loss)]
    fn means_deviations_and_correlations_are_right() {
        const N: u64 = 4096;
        for method in METHODS {
            let design = design(method, N, 7);
            let points: Vec<Vec<f64>> = (0..N).map(|index| design.point(index)).collect();
            let mean = |f: &dyn Fn(&Vec<f64>) -> f64| points.iter().map(f).sum::<f64>() / N as f64;
            for (a, b) in [(0, 2), (0, 3), (2, 3)] {
                // Four standard errors of a plain Monte Carlo estimate.
                let error = 4.0 / (N as f64).sqrt();
                assert!(mean(&|p| p[a]).abs() < error, "{method:?}");
                assert!(
                    (mean(&|p| p[a] * p[a]) - 1.0).abs() < 1.5 * error,
                    "{method:?}"
                );
                assert!(mean(&|p| p[a] * p[b]).abs() < error, "{method:?}");
            }
            assert!(points.iter().all(|point| point[1] == 3.0));
        }
    }

    #[test]
    fn seeds_differ_and_equal_seeds_agree() {
        for method in METHODS {
            let [a, b, c] = [1, 1, 2].map(|seed| design(method, 64, seed));
            assert_eq!(a.point(17), b.point(17));
            assert_ne!(a.point(17), c.point(17));
        }
    }

    #[test]
    fn an_extension_keeps_the_points() {
        for method in [Method::MonteCarlo, Method::Sobol] {
            let [short, long] = [100, 200].map(|points| design(method, points, 5));
            assert!((0..100).all(|index| short.point(index) == long.point(index)));
        }
    }
}

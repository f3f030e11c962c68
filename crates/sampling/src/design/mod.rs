//! Designs: the rules that place a study's points.
//!
//! Point `i` depends on the seed and on `i` alone: shards, workers, an interrupted run and an extension all
//! see the same points. The points of a Latin hypercube depend on their number too: they are the same for shards, workers and
//! interrupted runs, but cannot be extended.

pub mod correlation;
mod hypercube;
mod joint;
#[cfg(test)]
mod lasting_tests;
#[macro_use]
mod methods;
pub(crate) mod monte_carlo;
pub mod rule;
mod sampling;
mod sobol;

use std::sync::Arc;

use crate::distribution::Distribution;

use correlation::Correlation;
use rule::Rule;

pub use joint::Joint;
pub use rule::Inputs;
pub use sampling::Sampling;

// The list of all designs. A new one is a file with a type that implements `rule::Registered`, its `mod` line above and its line
// here. The name in a study, the JSON Schema and all checks follow.
methods! {
    MonteCarlo = monte_carlo::Independent, "Independent random points.";
    LatinHypercube = hypercube::Hypercube, "One point in each of N equally probable slices of every parameter.";
    Sobol = sobol::Nets, "A scrambled Sobol net.";
}

/// A rule that gives every index its point.
#[derive(Clone, Debug)]
pub struct Design {
    rule: Arc<dyn Rule>,
    points: u64,
    inputs: Vec<Distribution>,
    correlation: Option<Correlation>,
    joints: Vec<Joint>,
}

impl Design {
    /// A design over these inputs.
    ///
    /// # Errors
    /// When the method cannot serve this number of inputs or points.
    pub fn new(sampling: &Sampling, inputs: impl Into<Inputs>) -> Result<Self, String> {
        let inputs = with_leads(inputs.into());
        if sampling.points == 0 {
            return Err("points must be at least 1".to_owned());
        }
        if sampling.replicates == 0 {
            return Err("replicates must be at least 1".to_owned());
        }
        if sampling.replicates > 1 && !sampling.method.has_replicates() {
            let with = Method::named(Method::has_replicates);
            return Err(format!("replicates need method = {with}; remove them"));
        }
        let rule = sampling.method.rule(sampling, &inputs)?;
        let Inputs { distributions: inputs, correlation, joints } = inputs;
        Ok(Self { points: sampling.points, rule, inputs, correlation, joints })
    }

    /// Independently scrambled Sobol nets in turn, in the unit cube.
    ///
    /// # Errors
    /// When there is no such net of this number of dimensions or points.
    pub fn net(dimensions: usize, points: u64, seed: u64, replicates: u64) -> Result<Self, String> {
        let sampling = Sampling { method: Method::Sobol, points, seed, replicates };
        let unit = Distribution::Uniform { min: 0.0, max: 1.0 };
        Self::new(&sampling, vec![unit; dimensions])
    }

    /// How many points there are.
    pub fn len(&self) -> u64 {
        self.points
    }

    /// Always false: a design has at least one point.
    pub fn is_empty(&self) -> bool {
        self.points == 0
    }

    /// The parameters of the point at an index from 0.
    pub fn point(&self, index: u64) -> Vec<f64> {
        let mut dimension = 0;
        let places: Vec<f64> = self
            .inputs
            .iter()
            .map(|input| {
                if !input.varies() {
                    return 0.5;
                }
                dimension += 1;
                self.rule.uniform(index, dimension - 1)
            })
            .collect();
        let mut point: Vec<f64> = match &self.correlation {
            None => places.iter().zip(&self.inputs).map(|(&u, input)| input.quantile(u)).collect(),
            Some(correlation) => correlation.values(&places, &self.inputs),
        };
        for joint in &self.joints {
            joint.fill(&places, &mut point);
        }
        point
    }
}

/// The same inputs; of those that are drawn together only the lead takes a dimension of the design, as its number chooses
/// the row for all.
fn with_leads(mut inputs: Inputs) -> Inputs {
    for joint in &inputs.joints {
        let row = joint.row(0.5);
        for (&input, &value) in joint.inputs().iter().zip(row).skip(1) {
            inputs.distributions[input] = Distribution::Fixed { value };
        }
    }
    inputs
}

/// Points in the unit cube that belong to independently scrambled Sobol nets in turn.
///
/// # Errors
/// When there is no such net of this number of dimensions or points.
pub fn cube(dimensions: usize, points: u64, seed: u64, replicates: u64) -> Result<Vec<Vec<f64>>, String> {
    let net = Design::net(dimensions, points, seed, replicates)?;
    Ok((0..points).map(|index| net.point(index)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn design(method: Method, points: u64, seed: u64) -> Design {
        let settings = Sampling { method, points, seed, replicates: if method == Method::Sobol { 4 } else { 1 } };
        let normal = Distribution::Normal { mean: 0.0, deviation: 1.0 };
        let fixed = Distribution::Fixed { value: 3.0 };
        Design::new(&settings, vec![normal.clone(), fixed, normal.clone(), normal]).unwrap()
    }

    const METHODS: &[Method] = Method::ALL;
    const MANY: u64 = 4096;

    #[test]
    fn means_deviations_and_correlations_are_right() {
        for &method in METHODS {
            let n = MANY;
            let design = design(method, n, 7);
            let points: Vec<Vec<f64>> = (0..n).map(|index| design.point(index)).collect();
            let mean = |f: &dyn Fn(&Vec<f64>) -> f64| points.iter().map(f).sum::<f64>() / n as f64;
            for (a, b) in [(0, 2), (0, 3), (2, 3)] {
                // Four standard errors of a plain Monte Carlo estimate.
                let error = 4.0 / (n as f64).sqrt();
                assert!(mean(&|p| p[a]).abs() < error, "{method:?}");
                assert!((mean(&|p| p[a] * p[a]) - 1.0).abs() < 1.5 * error, "{method:?}");
                assert!(mean(&|p| p[a] * p[b]).abs() < error, "{method:?}");
            }
            assert!(points.iter().all(|point| point[1] == 3.0));
        }
    }

    #[test]
    fn seeds_differ_and_equal_seeds_agree() {
        for &method in METHODS {
            let [a, b, c] = [1, 1, 2].map(|seed| design(method, 20, seed));
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

    #[test]
    fn correlations_are_those_asked_for() {
        let [normal, bounded, lognormal] = [
            Distribution::Normal { mean: 5.0, deviation: 2.0 },
            Distribution::Uniform { min: 0.0, max: 1.0 },
            Distribution::Lognormal { mean: 2.0, deviation: 0.5 },
        ];
        for &method in METHODS {
            let n = MANY;
            let settings = Sampling { method, points: n, seed: 9, replicates: 1 };
            let pairs = [(0, 1, 0.8), (0, 3, -0.5), (1, 3, -0.2)];
            let fixed = Distribution::Fixed { value: 3.0 };
            let inputs = Inputs {
                joints: Vec::new(),
                distributions: vec![normal.clone(), normal.clone(), fixed, bounded.clone(), lognormal.clone()],
                correlation: Some(Correlation::new(5, &pairs).unwrap()),
            };
            let design = Design::new(&settings, inputs).unwrap();
            let points: Vec<Vec<f64>> = (0..n).map(|index| design.point(index)).collect();
            let pearson = |a: usize, b: usize| {
                let mean = |f: &dyn Fn(&Vec<f64>) -> f64| points.iter().map(f).sum::<f64>() / n as f64;
                let [ma, mb] = [mean(&|p| p[a]), mean(&|p| p[b])];
                let covariance = |i: usize, mi: f64, j: usize, mj: f64| mean(&|p| (p[i] - mi) * (p[j] - mj));
                covariance(a, ma, b, mb) / (covariance(a, ma, a, ma) * covariance(b, mb, b, mb)).sqrt()
            };
            // The error of a correlation is (1 - r^2) / sqrt(N); four of them. Between a normal and a uniform
            // number, the coefficient of the normal scores shrinks by sqrt(3 / pi).
            let shrunk = (3.0 / std::f64::consts::PI).sqrt();
            for (a, b, expected) in [(0, 1, 0.8), (0, 3, -0.5 * shrunk), (0, 4, 0.0)] {
                let error = 4.0 * (1.0 - expected * expected) / (n as f64).sqrt();
                let coefficient = pearson(a, b);
                assert!((coefficient - expected).abs() < error, "{method:?}: {coefficient} for {expected}");
            }
            assert!(points.iter().all(|p| p[2] == 3.0 && (0.0..=1.0).contains(&p[3])));
        }
    }

    #[test]
    fn numbers_that_make_no_design_are_refused() {
        let sampling = |method, points, replicates| Sampling { method, points, seed: 1, replicates };
        let unit = Distribution::Uniform { min: 0.0, max: 1.0 };
        for (refused, reason) in [
            (sampling(Method::Sobol, 0, 1), "points"),
            (sampling(Method::Sobol, 8, 0), "replicates must"),
            (sampling(Method::MonteCarlo, 8, 2), "replicates need"),
        ] {
            let error = Design::new(&refused, vec![unit.clone()]).unwrap_err();
            assert!(error.contains(reason), "{error}");
        }
        let design = Design::new(&sampling(Method::Sobol, 8, 2), vec![unit]).unwrap();
        assert_eq!((design.len(), design.is_empty()), (8, false));
    }

    /// Of the four points of each net, every half and every quarter of the square holds its share.
    #[test]
    fn the_cube_holds_even_nets_in_turn() {
        let points = cube(2, 8, 3, 2).unwrap();
        assert_eq!(points.len(), 8);
        for net in 0..2 {
            for [columns, rows] in [[4.0, 1.0], [2.0, 2.0], [1.0, 4.0]] {
                let cell = |p: &Vec<f64>| (p[0] * columns).floor() + columns * (p[1] * rows).floor();
                let mut cells: Vec<f64> = points.iter().skip(net).step_by(2).map(cell).collect();
                cells.sort_by(f64::total_cmp);
                assert_eq!(cells, [0.0, 1.0, 2.0, 3.0], "{columns} by {rows}");
            }
        }
        assert!(cube(2, 8, 3, 0).is_err());
    }

    #[test]
    fn methods_are_named_as_in_a_study() {
        assert_eq!(Method::LatinHypercube.name(), "latin-hypercube");
        assert_eq!(Method::named(Method::has_replicates), "sobol");
        let extensible = [Method::MonteCarlo, Method::Sobol];
        assert!(extensible.into_iter().all(Method::is_extensible));
        let named = Method::named(|method| extensible.contains(&method));
        assert_eq!(named, "monte-carlo or sobol");
        assert_eq!(Method::named(|_| false), "");
    }

    #[test]
    fn inputs_that_do_not_vary_need_no_design() {
        let fixed = Distribution::Fixed { value: 3.0 };
        for &method in METHODS {
            let sampling = Sampling { method, points: 8, ..Sampling::default() };
            let design = Design::new(&sampling, vec![fixed.clone(); 2]).unwrap();
            assert_eq!(design.point(7), [3.0, 3.0], "{method:?}");
        }
    }

    #[test]
    fn random_points_can_be_extended_and_others_cannot() {
        let extensible = |method: Method| method.is_extensible();
        let random = [Method::MonteCarlo, Method::Sobol];
        assert!(random.into_iter().all(extensible));
        assert!(!extensible(Method::LatinHypercube));
    }
}

//! The points of a plan: by a design, in the unit cube, at normal scores, and as surrogates see them.

use sampling::{
    design::{Design, Inputs, Sampling},
    distribution::Distribution,
};

use super::Plan;

impl Plan {
    /// The points of a design over the parameters.
    ///
    /// # Errors
    /// When the method cannot serve this number of parameters or points.
    pub fn design(&self, design: &Sampling) -> Result<Design, String> {
        let inputs = Inputs {
            distributions: self.distributions(),
            correlation: self.correlation.clone(),
            joints: self.joints.clone(),
        };
        Design::new(design, inputs)
    }

    /// The parameters at a point of the unit cube. Its axes are the parameters that vary; the others have their medians.
    pub fn from_cube(&self, cube: &[f64]) -> Vec<f64> {
        // Away from the ends of the unit interval where a distribution reaches to infinity.
        let given = self.varied().into_iter().zip(cube).map(|(k, &u)| match self.inputs[k].distribution.is_bounded() {
            [true, true] => u,
            _ => u.clamp(1e-6, 1.0 - 1e-6),
        });
        let places = self.with_fixed(given, 0.5);
        let point = self.inputs.iter().zip(&places).map(|(input, &u)| input.distribution.quantile(u));
        self.with_samples(&places, point.collect())
    }

    /// A number for each parameter: those that are given for the ones that vary, and `otherwise`.
    fn with_fixed(&self, mut given: impl Iterator<Item = f64>, otherwise: f64) -> Vec<f64> {
        let mut next = || given.next().expect("a number for each that varies");
        self.inputs.iter().map(|input| if input.distribution.varies() { next() } else { otherwise }).collect()
    }

    fn distributions(&self) -> Vec<Distribution> {
        self.inputs.iter().map(|input| input.distribution.clone()).collect()
    }

    /// Puts the rows of the samples into a point.
    fn with_samples(&self, places: &[f64], mut point: Vec<f64>) -> Vec<f64> {
        for joint in &self.joints {
            joint.fill(places, &mut point);
        }
        point
    }

    /// The parameters at independent standard normal scores of those that vary, correlated as the study says.
    pub fn at_scores(&self, scores: &[f64]) -> Vec<f64> {
        let all = self.with_fixed(scores.iter().copied(), 0.0);
        let inputs = self.distributions();
        let point: Vec<f64> = match &self.correlation {
            Some(correlation) => correlation.at_scores(&all, &inputs),
            None => inputs.iter().zip(&all).map(|(input, &z)| input.at_score(z)).collect(),
        };
        let unit = Distribution::Uniform { min: 0.0, max: 1.0 };
        let places: Vec<f64> = all.iter().map(|&z| unit.at_score(z)).collect();
        self.with_samples(&places, point)
    }

    /// A point as a surrogate sees it: a model changes evenly with the logarithm of a quantity that is normal in it.
    pub fn coordinates(&self, point: &[f64]) -> Vec<f64> {
        self.inputs
            .iter()
            .zip(point)
            .map(|(input, &value)| match &input.distribution {
                Distribution::Lognormal { .. } => value.ln(),
                _ => value,
            })
            .collect()
    }
}

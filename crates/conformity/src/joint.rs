//! Joint probabilities of normal errors of which some are correlated.

use super::genz;
use super::normal::{between, between_both};
use super::one_factor::OneFactor;

/// Standard normal errors with given correlations.
#[derive(Clone, Debug, Default)]
pub struct JointNormal {
    /// Errors with correlation +1 or -1 to another one: index, index of the other one, sign.
    twins: Vec<(usize, usize, f64)>,
    /// Errors that depend on each other, directly or through others.
    blocks: Vec<Block>,
    /// Whether probabilities of many errors are known to about 1e-3 only.
    roughly: bool,
}

#[derive(Clone, Debug)]
struct Block {
    members: Vec<usize>,
    correlation: Vec<Vec<f64>>,
    /// The part that they share, where that alone correlates them.
    common: Option<OneFactor>,
}

impl JointNormal {
    /// A number of errors, correlated in the given pairs and independent otherwise.
    ///
    /// # Errors
    /// When a coefficient is not from -1 to 1, or when the correlations contradict each other.
    pub fn new(errors: usize, pairs: &[(usize, usize, f64)]) -> Result<Self, String> {
        let mut matrix = vec![vec![0.0; errors]; errors];
        for (i, row) in matrix.iter_mut().enumerate() {
            row[i] = 1.0;
        }
        for &(a, b, coefficient) in pairs {
            if !(-1.0..=1.0).contains(&coefficient) {
                return Err(format!("the coefficient {coefficient} is not from -1 to 1"));
            }
            (matrix[a][b], matrix[b][a]) = (coefficient, coefficient);
        }
        let twins = twins(&matrix)?;
        let own = |i: &usize| twins.iter().all(|(twin, ..)| twin != i);
        let own: Vec<usize> = (0..errors).filter(own).collect();
        let matrix = independent(matrix, &own)?;
        let blocks = blocks(&matrix, own).into_iter().map(|members| {
            let correlation = part(&matrix, &members);
            Block {
                common: OneFactor::of(&correlation),
                correlation,
                members,
            }
        });
        Ok(Self {
            blocks: blocks.collect(),
            twins,
            roughly: false,
        })
    }

    /// The same errors, whose probabilities are only known to about 1e-3 where they are many: enough for a mean over many
    /// points, and much faster.
    pub fn roughly(self) -> Self {
        Self {
            roughly: true,
            ..self
        }
    }

    /// The probability that all errors lie between their limits, in units of their standard
    /// deviations.
    pub fn probability(&self, lower: &[f64], upper: &[f64]) -> f64 {
        let (mut lower, mut upper) = (lower.to_vec(), upper.to_vec());
        for &(twin, original, sign) in &self.twins {
            let limits = [sign * lower[twin], sign * upper[twin]];
            lower[original] = lower[original].max(limits[0].min(limits[1]));
            upper[original] = upper[original].min(limits[0].max(limits[1]));
        }
        let blocks = self.blocks.iter();
        blocks
            .map(|block| block.probability(&lower, &upper, self.roughly))
            .product()
    }
}

impl Block {
    fn probability(&self, lower: &[f64], upper: &[f64], roughly: bool) -> f64 {
        let pick = |values: &[f64]| {
            self.members
                .iter()
                .map(|&i| values[i])
                .collect::<Vec<f64>>()
        };
        match self.members[..] {
            [i] => between(lower[i], upper[i]),
            [i, j] => between_both(
                [lower[i], lower[j]],
                [upper[i], upper[j]],
                self.correlation[0][1],
            ),
            _ => match &self.common {
                Some(common) => common.probability(&pick(lower), &pick(upper)),
                None => genz::probability(&self.correlation, &pick(lower), &pick(upper), roughly),
            },
        }
    }
}

const CONTRADICTION: &str = "the correlations contradict each other: no errors can have them; bring the coefficients \
                             nearer to 0";

/// The correlations, brought nearer to 0 by a millionth where one error follows from several others, as that of a product
/// from its factors': then all have a density. A box's probability changes by about as little.
fn independent(mut matrix: Vec<Vec<f64>>, own: &[usize]) -> Result<Vec<Vec<f64>>, String> {
    const LITTLE: f64 = 1e-6;
    if genz::cholesky(&part(&matrix, own)).is_some() {
        return Ok(matrix);
    }
    for (i, row) in matrix.iter_mut().enumerate() {
        for (j, entry) in row.iter_mut().enumerate() {
            *entry *= if i == j { 1.0 } else { 1.0 - LITTLE };
        }
    }
    // A little independence takes away a dependence, but no contradiction.
    match genz::cholesky(&part(&matrix, own)) {
        Some(_) => Ok(matrix),
        None => Err(CONTRADICTION.to_owned()),
    }
}

/// Errors with a correlation of -1 or 1 to an earlier one, which must be correlated alike.
fn twins(matrix: &[Vec<f64>]) -> Result<Vec<(usize, usize, f64)>, String> {
    let mut twins = Vec::new();
    for (twin, row) in matrix.iter().enumerate() {
        let Some(original) = row[..twin].iter().position(|r| r.abs() == 1.0) else {
            continue;
        };
        let sign = row[original];
        let alike = |(a, b): (&f64, &f64)| (a - sign * b).abs() < 1e-12;
        if !row.iter().zip(&matrix[original]).all(alike) {
            return Err(CONTRADICTION.to_owned());
        }
        twins.push((twin, original, sign));
    }
    Ok(twins)
}

/// The correlations of some errors.
fn part(matrix: &[Vec<f64>], members: &[usize]) -> Vec<Vec<f64>> {
    let row = |&i: &usize| members.iter().map(|&j| matrix[i][j]).collect();
    members.iter().map(row).collect()
}

/// The errors that are connected by correlations, each in its order.
fn blocks(matrix: &[Vec<f64>], mut free: Vec<usize>) -> Vec<Vec<usize>> {
    let mut blocks = Vec::new();
    while !free.is_empty() {
        let mut members = vec![free.remove(0)];
        let mut next = 0;
        while next < members.len() {
            let from = &matrix[members[next]];
            let (linked, rest) = free.iter().partition(|&&i| from[i] != 0.0);
            free = rest;
            members.extend::<Vec<usize>>(linked);
            next += 1;
        }
        members.sort_unstable();
        blocks.push(members);
    }
    blocks
}

#[cfg(test)]
mod tests {
    use super::*;

    /// x1 = 0.6 x2 + 0.8 x3, as the error of a product from those of its factors: given x2, all limits are limits of x3.
    #[test]
    fn an_error_that_follows_from_two_others_limits_them() {
        let joint = JointNormal::new(3, &[(0, 1, 0.6), (0, 2, 0.8)]).unwrap();
        for (lower, upper) in [
            ([-1.0, -1.5, -0.4], [0.5, 0.7, 2.0]),
            ([0.2, -2.0, -2.0], [0.4, 2.0, 2.0]),
            ([-3.0, -1.0, -1.0], [1.4, 1.0, 1.0]),
            ([-0.5, 0.3, -1.0], [0.5, 1.0, 0.2]),
        ] {
            let [lower, upper]: [[f64; 3]; 2] = [lower, upper];
            const STEPS: i32 = 100_000;
            let width = (upper[1] - lower[1]) / f64::from(STEPS);
            let given = |i: i32| {
                let x = lower[1] + (f64::from(i) + 0.5) * width;
                let from = ((lower[0] - 0.6 * x) / 0.8).max(lower[2]);
                let to = ((upper[0] - 0.6 * x) / 0.8).min(upper[2]);
                between(from, to) * (-0.5 * x * x).exp() * width
            };
            let expected: f64 = (0..STEPS).map(given).sum::<f64>() / std::f64::consts::TAU.sqrt();
            let found = joint.probability(&lower, &upper);
            assert!(
                (found - expected).abs() < 5e-5,
                "{lower:?}: {found} {expected}"
            );
        }
    }

    /// Three errors with the sum 0: one of them is positive, or two of them are.
    #[test]
    fn errors_with_the_sum_0_are_never_all_positive() {
        let joint = JointNormal::new(3, &[(0, 1, -0.5), (0, 2, -0.5), (1, 2, -0.5)]).unwrap();
        let infinite = f64::INFINITY;
        assert!(joint.probability(&[0.0; 3], &[infinite; 3]) < 5e-4);
        let two = joint.probability(&[0.0, 0.0, -infinite], &[infinite, infinite, 0.0]);
        assert!((two - 1.0 / 6.0).abs() < 5e-4, "{two}");
    }

    #[test]
    fn contradictions_are_refused() {
        for (a, b, c) in [(0.7, 0.8, 0.0), (0.9, 0.9, -0.9), (-0.51, -0.51, -0.51)] {
            let pairs = [(0, 1, a), (0, 2, b), (1, 2, c)];
            let error = JointNormal::new(3, &pairs).unwrap_err();
            assert!(error.contains("contradict each other"), "{error}");
        }
    }

    #[test]
    fn independent_errors_multiply() {
        let joint = JointNormal::new(3, &[]).unwrap();
        let (lower, upper) = ([-1.0, -2.0, 0.0], [1.0, 0.5, 3.0]);
        let product: f64 = (0..3).map(|i| between(lower[i], upper[i])).product();
        assert_eq!(joint.probability(&lower, &upper), product);
    }

    #[test]
    fn only_what_is_connected_is_joint() {
        let joint = JointNormal::new(4, &[(0, 3, 0.7), (1, 2, 0.0)]).unwrap();
        let (lower, upper) = ([-1.0; 4], [0.5, 1.0, 2.0, 0.8]);
        let pair = between_both([-1.0, -1.0], [0.5, 0.8], 0.7);
        let expected = pair * between(-1.0, 1.0) * between(-1.0, 2.0);
        let found = joint.probability(&lower, &upper);
        assert!((found - expected).abs() < 1e-15, "{found} {expected}");
    }

    #[test]
    fn a_chain_is_one_block() {
        let joint = JointNormal::new(5, &[(4, 1, 0.5), (1, 3, 0.5)]).unwrap();
        let members: Vec<_> = joint
            .blocks
            .iter()
            .map(|block| block.members.clone())
            .collect();
        assert_eq!(members, [vec![0], vec![1, 3, 4], vec![2]]);
    }

    #[test]
    fn errors_that_are_equal_or_opposite_only_narrow_the_limits() {
        let r = 0.6;
        let pairs = [
            (0, 1, r),
            (0, 2, 1.0),
            (1, 2, r),
            (0, 3, -1.0),
            (1, 3, -r),
            (2, 3, -1.0),
        ];
        let joint = JointNormal::new(4, &pairs).unwrap();
        let found = joint.probability(&[-1.0, -1.5, -0.4, -0.5], &[1.0, 0.7, 2.0, 9.0]);
        let expected = between_both([-0.4, -1.5], [0.5, 0.7], r);
        assert_eq!(found, expected);
        let unlike = [(0, 1, r), (0, 2, 1.0)];
        assert!(JointNormal::new(3, &unlike).is_err());
    }

    #[test]
    fn impossible_correlations_are_refused() {
        let contradiction = [(0, 1, 0.9), (1, 2, 0.9), (0, 2, -0.9)];
        assert!(
            JointNormal::new(3, &contradiction)
                .unwrap_err()
                .contains("contradict")
        );
        assert!(
            JointNormal::new(2, &[(0, 1, 1.1)])
                .unwrap_err()
                .contains("1.1")
        );
        assert!(JointNormal::new(2, &[(0, 1, f64::NAN)]).is_err());
    }
}

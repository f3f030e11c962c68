//! Joint probabilities of normal errors of which some are correlated.

use std::borrow::Cow;

use super::{
    genz,
    normal::{between, between_both},
    one_factor::OneFactor,
};

/// Standard normal errors with given correlations.
#[derive(Clone, Debug, Default)]
pub struct JointNormal {
    /// Errors with correlation +1 or -1 to another one: index, index of the other one, sign.
    twins: Vec<(usize, usize, f64)>,
    /// Errors that depend on each other, directly or through others. Those of different blocks are independent, so that
    /// the probabilities of the blocks multiply.
    blocks: Vec<Block>,
    /// The block of each error.
    block_of: Vec<usize>,
}

#[derive(Clone, Debug)]
struct Block {
    members: Vec<usize>,
    /// Whether it is one error without a twin.
    single: bool,
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
        let mut joint = Self { block_of: vec![0; errors], ..Self::default() };
        for mut block in blocks(errors, pairs)? {
            let all = std::mem::take(&mut block.members);
            let twins = twins(&block.correlation)?;
            let originals: Vec<usize> = (0..all.len()).filter(|i| twins.iter().all(|(twin, ..)| twin != i)).collect();
            let correlation = with_density(part(&block.correlation, &originals))?;
            joint.twins.extend(twins.into_iter().map(|(twin, original, sign)| (all[twin], all[original], sign)));
            all.iter().for_each(|&i| joint.block_of[i] = joint.blocks.len());
            joint.blocks.push(Block {
                single: all.len() == 1,
                members: originals.iter().map(|&i| all[i]).collect(),
                common: OneFactor::of(&correlation),
                correlation,
            });
        }
        Ok(joint)
    }

    /// The probability that all errors lie between their limits, in units of their standard deviations.
    #[cfg(test)]
    pub fn probability(&self, lower: &[f64], upper: &[f64]) -> f64 {
        self.parts(lower, upper).iter().product()
    }

    /// The probability that the errors lie between their limits, in units of their standard deviations, for each block of errors
    /// that depend on each other; these probabilities multiply.
    pub fn parts(&self, lower: &[f64], upper: &[f64]) -> Vec<f64> {
        let [lower, upper] = self.narrowed(lower, upper);
        self.blocks.iter().map(|block| block.probability(&lower, &upper)).collect()
    }

    /// The number of the part that an error is all by itself; none where another one depends on it.
    pub fn single(&self, error: usize) -> Option<usize> {
        let number = self.block_of[error];
        self.blocks[number].single.then_some(number)
    }

    /// Limits that hold for errors with twins and for their twins, too.
    fn narrowed<'a>(&self, lower: &'a [f64], upper: &'a [f64]) -> [Cow<'a, [f64]>; 2] {
        let [mut lower, mut upper] = [Cow::from(lower), Cow::from(upper)];
        for &(twin, original, sign) in &self.twins {
            let limits = [sign * lower[twin], sign * upper[twin]];
            let [least, most] = [limits[0].min(limits[1]), limits[0].max(limits[1])];
            lower.to_mut()[original] = lower[original].max(least);
            upper.to_mut()[original] = upper[original].min(most);
        }
        [lower, upper]
    }
}

impl Block {
    fn probability(&self, lower: &[f64], upper: &[f64]) -> f64 {
        let pick = |values: &[f64]| self.members.iter().map(|&i| values[i]).collect::<Vec<f64>>();
        match self.members[..] {
            [i] => between(lower[i], upper[i]),
            [i, j] => between_both([lower[i], lower[j]], [upper[i], upper[j]], self.correlation[0][1]),
            _ => match &self.common {
                Some(common) => common.probability(&pick(lower), &pick(upper)),
                None => genz::probability(&self.correlation, &pick(lower), &pick(upper)),
            },
        }
    }
}

const CONTRADICTION: &str = "the correlations contradict each other: no errors can have them; bring the coefficients \
                             nearer to 0";

/// The correlations, brought nearer to 0 by a millionth where one error follows from several others, as that of a product
/// from its factors': then all have a density. A box's probability changes by about as little.
fn with_density(mut matrix: Vec<Vec<f64>>) -> Result<Vec<Vec<f64>>, String> {
    const LITTLE: f64 = 1e-6;
    if genz::cholesky(&matrix).is_some() {
        return Ok(matrix);
    }
    for (i, row) in matrix.iter_mut().enumerate() {
        for (j, entry) in row.iter_mut().enumerate() {
            *entry *= if i == j { 1.0 } else { 1.0 - LITTLE };
        }
    }
    // A little independence takes away a dependence, but no contradiction.
    match genz::cholesky(&matrix) {
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
        if !row.iter().zip(&matrix[original]).all(|(a, b)| (a - sign * b).abs() < 1e-12) {
            return Err(CONTRADICTION.to_owned());
        }
        twins.push((twin, original, sign));
    }
    Ok(twins)
}

/// The correlations of some errors.
fn part(matrix: &[Vec<f64>], members: &[usize]) -> Vec<Vec<f64>> {
    members.iter().map(|&i| members.iter().map(|&j| matrix[i][j]).collect()).collect()
}

/// Errors that depend on each other, each in its order, with their correlations.
pub struct Correlated {
    pub members: Vec<usize>,
    pub correlation: Vec<Vec<f64>>,
}

/// The errors in blocks that are independent of each other. A matrix of all errors would take the square of their number,
/// and its factor the cube.
pub fn blocks(errors: usize, pairs: &[(usize, usize, f64)]) -> Result<Vec<Correlated>, String> {
    let mut linked = vec![Vec::new(); errors];
    for &(a, b, coefficient) in pairs {
        if !(-1.0..=1.0).contains(&coefficient) {
            return Err(format!("the coefficient {coefficient} is not from -1 to 1"));
        }
        // Of a pair that is stated twice, the last coefficient counts.
        linked[a].retain(|(other, _)| *other != b);
        linked[b].retain(|(other, _)| *other != a);
        if coefficient != 0.0 {
            linked[a].push((b, coefficient));
            linked[b].push((a, coefficient));
        }
    }
    let mut place = vec![usize::MAX; errors];
    let mut blocks = Vec::new();
    for first in 0..errors {
        if place[first] != usize::MAX {
            continue;
        }
        let mut members = vec![first];
        place[first] = 0;
        let mut next = 0;
        while next < members.len() {
            for &(other, _) in &linked[members[next]] {
                if place[other] == usize::MAX {
                    place[other] = 0;
                    members.push(other);
                }
            }
            next += 1;
        }
        members.sort_unstable();
        members.iter().enumerate().for_each(|(k, &i)| place[i] = k);
        let mut correlation = vec![vec![0.0; members.len()]; members.len()];
        for (k, &i) in members.iter().enumerate() {
            correlation[k][k] = 1.0;
            linked[i].iter().for_each(|&(other, coefficient)| correlation[k][place[other]] = coefficient);
        }
        blocks.push(Correlated { members, correlation });
    }
    Ok(blocks)
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
            let probability = joint.probability(&lower, &upper);
            assert!((probability - expected).abs() < 5e-5, "{lower:?}: {probability} {expected}");
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
        let probability = joint.probability(&lower, &upper);
        assert!((probability - expected).abs() < 1e-15, "{probability} {expected}");
    }

    /// A chain of errors far apart in a list of many: a matrix of all of them would have 10^10 entries.
    #[test]
    fn many_independent_errors_are_multiplied() {
        const ERRORS: usize = 100_000;
        let pairs = [(7, 99_000, 0.5), (99_000, 400, -0.5)];
        let joint = JointNormal::new(ERRORS, &pairs).unwrap();
        let (lower, upper) = (vec![-4.5; ERRORS], vec![4.5; ERRORS]);
        let chain = JointNormal::new(3, &[(0, 1, 0.5), (1, 2, -0.5)]).unwrap();
        let chain = chain.probability(&[-4.5; 3], &[4.5; 3]);
        let expected = chain * between(-4.5, 4.5).powi(ERRORS as i32 - 3);
        let probability = joint.probability(&lower, &upper);
        assert!((probability / expected - 1.0).abs() < 1e-9, "{probability} {expected}");
        assert_eq!(joint.parts(&lower, &upper)[7], chain);
    }

    #[test]
    fn a_chain_is_one_block() {
        let joint = JointNormal::new(5, &[(4, 1, 0.5), (1, 3, 0.5)]).unwrap();
        let members: Vec<_> = joint.blocks.iter().map(|block| block.members.clone()).collect();
        assert_eq!(members, [vec![0], vec![1, 3, 4], vec![2]]);
    }

    #[test]
    fn errors_that_are_equal_or_opposite_only_narrow_the_limits() {
        let r = 0.6;
        let pairs = [(0, 1, r), (0, 2, 1.0), (1, 2, r), (0, 3, -1.0), (1, 3, -r), (2, 3, -1.0)];
        let joint = JointNormal::new(4, &pairs).unwrap();
        let probability = joint.probability(&[-1.0, -1.5, -0.4, -0.5], &[1.0, 0.7, 2.0, 9.0]);
        let expected = between_both([-0.4, -1.5], [0.5, 0.7], r);
        assert_eq!(probability, expected);
        let unlike = [(0, 1, r), (0, 2, 1.0)];
        assert!(JointNormal::new(3, &unlike).is_err());
    }

    #[test]
    fn impossible_correlations_are_refused() {
        let contradiction = [(0, 1, 0.9), (1, 2, 0.9), (0, 2, -0.9)];
        assert!(JointNormal::new(3, &contradiction).unwrap_err().contains("contradict"));
        assert!(JointNormal::new(2, &[(0, 1, 1.1)]).unwrap_err().contains("1.1"));
        assert!(JointNormal::new(2, &[(0, 1, f64::NAN)]).is_err());
    }
}

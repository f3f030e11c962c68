//! The part of a region that is verified, with its 95 % interval.
//!
//! A search prefers places where the surrogates are too optimistic, so their mean probability inside flatters what was
//! found. The study's own points inside correct it: each is foretold by surrogates that were fitted without it, and the
//! mean of verdict less forecast is added. This is the difference estimator of survey sampling (Särndal, Swensson and
//! Wretman 1992, "Model assisted survey sampling", 6.3; with forecasts as here Angelopoulos et al. 2023,
//! "Prediction-powered inference", Science 382, 669-674). It needs no surrogate to be right.

use sampling::statistics::moments::{mean, variance};
use statrs::distribution::{ContinuousCDF, StudentsT};

use super::region::{BoxStatement, Sample};

/// The points and predictions from which a region's probability and its interval are computed.
pub struct Evidence<'a> {
    /// A sample of the space that no search has seen, with the surrogates' probabilities.
    pub(super) unseen: Sample<'a>,
    /// The study's own points.
    pub(super) points: &'a [Vec<f64>],
    /// Whether each of them is verified; a failed one is not.
    pub(super) verified: &'a [bool],
    /// The probability that each of them is verified, by surrogates that were fitted without it.
    pub(super) foretold: &'a [f64],
}

impl Evidence<'_> {
    /// The verdict on a point, 1 or 0, less its forecast.
    fn error(&self, i: usize) -> f64 {
        f64::from(self.verified[i]) - self.foretold[i]
    }

    /// The mean square error of the forecasts over all points, with half a wrong one more than were seen, as Jeffreys' prior
    /// has it. The few points in a region cannot show that the surrogates err less than this.
    fn usual_square(&self) -> f64 {
        let points = self.points.len();
        let wrong: f64 = (0..points).map(|i| self.error(i).powi(2)).sum();
        (wrong + 0.5) / (points as f64 + 1.0)
    }

    /// The statement on a region: its share of the space, and how probable verification is in it. The interval is that of
    /// complete ignorance where it holds too few points.
    pub(super) fn statement(&self, contains: impl Fn(&[f64]) -> bool) -> BoxStatement {
        let sampled = self.unseen.points.iter().zip(self.unseen.verdicts);
        let sampled = sampled.filter(|(x, _)| contains(x)).map(|(_, p)| *p);
        let sampled: Vec<f64> = sampled.collect();
        let inside: Vec<usize> = (0..self.points.len()).filter(|&i| contains(&self.points[i])).collect();
        let errors: Vec<f64> = inside.iter().map(|&i| self.error(i)).collect();
        let n = errors.len() as f64;
        let mut statement = BoxStatement {
            share: sampled.len() as f64 / self.unseen.points.len() as f64,
            probability: mean(&sampled),
            interval: [0.0, 1.0],
        };
        let student = StudentsT::new(0.0, 1.0, n - 1.0).ok();
        let Some(student) = student.filter(|_| errors.len() > 1 && sampled.len() > 1) else {
            return statement;
        };
        // Few points inside may all happen to agree with their forecasts, so these count as no better than they admit.
        let admitted = inside.iter().map(|&i| self.foretold[i] * (1.0 - self.foretold[i]));
        let square = variance(&errors, 1).max(admitted.sum::<f64>() / n).max(self.usual_square());
        let deviation = (square / n + variance(&sampled, 1) / sampled.len() as f64).sqrt();
        let reach = student.inverse_cdf(0.975) * deviation;
        let probability = (statement.probability + mean(&errors)).clamp(0.0, 1.0);
        statement.probability = probability;
        statement.interval = [probability - reach, probability + reach].map(|p| p.clamp(0.0, 1.0));
        statement
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points of a line from 0 to 1.
    fn line(points: usize) -> Vec<Vec<f64>> {
        let place = |k| (k as f64 + 0.5) / points as f64;
        (0..points).map(|k| vec![place(k)]).collect()
    }

    /// What is stated of the lower half, whose forecasts all say 0.95, where one in `wrong` of the study's points is not verified.
    fn stated(points: usize, wrong: usize) -> BoxStatement {
        let (sample, studied) = (line(4000), line(points));
        let verified: Vec<bool> = (0..points).map(|k| k % wrong != wrong - 1).collect();
        let evidence = Evidence {
            unseen: Sample { points: &sample, verdicts: &vec![0.95; sample.len()] },
            points: &studied,
            verified: &verified,
            foretold: &vec![0.95; points],
        };
        evidence.statement(|x| x[0] < 0.5)
    }

    #[test]
    fn points_correct_what_surrogates_promise() {
        let statement = stated(400, 5);
        assert!((statement.share - 0.5).abs() < 1e-12, "{statement:?}");
        assert!((statement.probability - 0.8).abs() < 1e-12, "{statement:?}");
        // No narrower than Student's interval of 200 points, 1.972 sqrt(0.8 * 0.2 / 199), and hardly wider.
        let half = (statement.interval[1] - statement.interval[0]) / 2.0;
        assert!(half > 0.0559 && half < 0.061, "{statement:?}");
    }

    #[test]
    fn few_points_that_agree_show_little() {
        // All of ten are verified: no more than the forecasts admit, 0.95 +- 2.262 sqrt(0.95 * 0.05 / 10) at the least.
        let statement = stated(20, usize::MAX);
        assert!(statement.interval[0] < 0.85 && statement.interval[1] >= 0.99, "{statement:?}");
        assert_eq!(stated(2, 1).interval, [0.0, 1.0]);
    }
}

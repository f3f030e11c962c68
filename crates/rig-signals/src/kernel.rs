//! A Gaussian kernel that gives a signal's value between its samples.

/// A kernel over samples.
pub struct Kernel {
    /// The standard deviation in samples.
    width: f64,
}

impl Kernel {
    /// A kernel with a standard deviation of `width` samples.
    pub fn new(width: f64) -> Self {
        Self { width }
    }

    /// How many samples to either side it takes.
    pub fn reach(&self) -> usize {
        (5.0 * self.width).ceil() as usize
    }

    /// The whole sample nearest to a place, and the weights of the samples around it. They sum up to 1.
    pub fn at(&self, place: f64) -> (isize, Vec<f64>) {
        let whole = place.round();
        let reach = self.reach() as isize;
        let weights: Vec<f64> = (-reach..=reach)
            .map(|offset| {
                let far = (place - whole - offset as f64) / self.width;
                (-0.5 * far * far).exp()
            })
            .collect();
        let sum: f64 = weights.iter().sum();
        (whole as isize, weights.iter().map(|w| w / sum).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The weights follow a straight line between samples, and leave as much of white noise at every place.
    #[test]
    fn lines_stay_and_noise_does_not_depend_on_the_place() {
        let kernel = Kernel::new(1.5);
        let noise = |weights: &[f64]| weights.iter().map(|w| w * w).sum::<f64>();
        let (_, middle) = kernel.at(0.0);
        for place in [-3.7, 0.25, 0.5, 7.49] {
            let (whole, weights) = kernel.at(place);
            let reach = kernel.reach() as isize;
            let centre: f64 = (whole - reach..).zip(&weights).map(|(sample, w)| sample as f64 * w).sum();
            assert!((centre - place).abs() < 1e-6, "{place}: {centre}");
            assert!((noise(&weights) / noise(&middle) - 1.0).abs() < 1e-5, "{place}");
        }
    }
}

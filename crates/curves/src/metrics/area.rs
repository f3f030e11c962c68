//! The area between the distribution functions of the values.

use super::Pair;

/// The validation metric of Ferson, Oberkampf & Ginzburg (2008), "Model validation and predictive capability for the
/// thermal challenge problem", Comput. Methods Appl. Mech. Engrg. 197: the integral of |F_m(x) - F_r(x)| over x, with the
/// empirical distribution functions of the values. It sees how often which values occur, not when. Of samples of one
/// size it is the mean distance of the sorted values.
pub fn area(pair: &Pair) -> f64 {
    let [model, reference] = [pair.model, pair.reference].map(|values| {
        let mut values = values.to_vec();
        values.sort_unstable_by(f64::total_cmp);
        values
    });
    let distances = model.iter().zip(&reference).map(|(m, r)| (m - r).abs());
    distances.sum::<f64>() / model.len() as f64
}

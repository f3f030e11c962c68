//! A model that is asked each question once.
//!
//! A search comes back to places where it has been: it goes down from starts that were screened, and the posterior's
//! curvature is that of the last step. What the model said there is kept.

use std::{cell::RefCell, collections::HashMap};

use super::problem::{NoPrediction, Prediction, Query, Simulate};

/// A model with its answers so far.
pub struct Remembered<'a> {
    model: &'a dyn Simulate,
    answers: RefCell<HashMap<Vec<u64>, Prediction>>,
}

impl<'a> Remembered<'a> {
    /// A model of which these answers are known.
    pub fn new(model: &'a dyn Simulate, known: impl IntoIterator<Item = (Query, Prediction)>) -> Self {
        let known = known.into_iter().map(|(query, prediction)| (key(&query), prediction));
        Self { model, answers: RefCell::new(known.collect()) }
    }
}

/// All that an answer depends on, digit by digit.
fn key(query: &Query) -> Vec<u64> {
    let numbers = query.free.iter().chain(&query.latents);
    let case = query.case as u64;
    [case].into_iter().chain(numbers.map(|number| number.to_bits())).collect()
}

impl Simulate for Remembered<'_> {
    fn simulate(&self, queries: &[Query]) -> Result<Vec<Prediction>, NoPrediction> {
        let keys: Vec<Vec<u64>> = queries.iter().map(key).collect();
        let mut answers = self.answers.borrow_mut();
        let mut open: Vec<usize> = Vec::new();
        for (index, key) in keys.iter().enumerate() {
            if !answers.contains_key(key) && !open.iter().any(|&earlier| keys[earlier] == *key) {
                open.push(index);
            }
        }
        if !open.is_empty() {
            let asked: Vec<Query> = open.iter().map(|&index| queries[index].clone()).collect();
            let predictions = self.model.simulate(&asked)?;
            let new = open.iter().map(|&index| keys[index].clone());
            answers.extend(new.zip(predictions));
        }
        Ok(keys.iter().map(|key| answers[key].clone()).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::Cell;

    #[test]
    fn each_question_is_asked_once() {
        let asked = Cell::new(0);
        let model = |case: usize, p: &[f64], _: &[f64]| {
            asked.set(asked.get() + 1);
            if p[0] > 2.0 {
                return Err("too large".to_owned());
            }
            Ok(vec![p[0] + case as f64])
        };
        let query = |case, x| Query { case, free: vec![x], latents: Vec::new() };
        let model = Remembered::new(&model, [(query(5, 1.0), Ok(vec![7.0]))]);
        let ask = |queries: &[Query]| model.simulate(queries).unwrap();
        assert_eq!((ask(&[query(5, 1.0)]), asked.get()), (vec![Ok(vec![7.0])], 0));
        let first = ask(&[query(0, 1.0), query(1, 1.0), query(0, 1.0), query(0, 3.0)]);
        assert_eq!(first[..3], [Ok(vec![1.0]), Ok(vec![2.0]), Ok(vec![1.0])]);
        assert!(first[3].is_err());
        assert_eq!(asked.get(), 3);
        assert_eq!(ask(&[query(1, 1.0), query(0, 3.0)]), first[1..=3].iter().step_by(2).cloned().collect::<Vec<_>>());
        assert_eq!(asked.get(), 3);
        assert_eq!(ask(&[query(0, 2.0)]), [Ok(vec![2.0])]);
        assert_eq!(asked.get(), 4);
    }
}

//! The derivatives of the rates over the states, by differences, where most rates depend on few states.
//!
//! At first each state is changed alone, which shows what depends on it. From then on states are changed together that no
//! rate shares (Curtis, Powell & Reid 1974, J. Inst. Maths Applics 13, 117-119), and one change of all states tells whether
//! a rate depends on more than was seen. The dependencies that a description states are not used: they may be missing or wrong.

use crate::call::Called;

/// A difference that the known dependencies leave unexplained, over what they explain: more shows another dependency.
const UNEXPLAINED: f64 = 1e-3;
/// The share of a rate that is its rounding.
const ROUNDING: f64 = 1e3 * f64::EPSILON;

/// Gives the rates at a time, s, and states; whether there are any, as an FMU may refuse to compute them there.
pub type Rates<'a> = dyn FnMut(f64, &[f64], &mut [f64]) -> Called<bool> + 'a;

/// For each state the rates that depend on it, in order, with their slopes.
pub type Columns = Vec<Vec<(usize, f64)>>;

/// Where it is computed: the rates at a time, s, and states, and what is small for each state.
#[derive(Clone, Copy)]
pub struct LinearisationPoint<'a> {
    pub time: f64,
    pub states: &'a [f64],
    pub rates: &'a [f64],
    pub sizes: &'a [f64],
}

#[derive(Debug, Default)]
pub struct Jacobian {
    pub columns: Columns,
    /// The states that are changed together.
    groups: Vec<Vec<usize>>,
    at: Vec<f64>,
    rates: Vec<f64>,
}

impl Jacobian {
    /// One for `n` states.
    pub fn new(n: usize) -> Self {
        Self {
            columns: vec![Vec::new(); n],
            groups: (0..n).map(|state| vec![state]).collect(),
            at: vec![0.0; n],
            rates: vec![0.0; n],
        }
    }

    /// Computes the slopes. `None` where there are no rates a little beside the place; else whether rates depend on more
    /// than was known.
    pub fn compute(&mut self, f: &mut Rates, place: LinearisationPoint) -> Called<Option<bool>> {
        self.at.copy_from_slice(place.states);
        let is_sparse = self.groups.len() < self.columns.len();
        if is_sparse && self.by_groups(f, place)? && self.explains(f, place)? {
            return Ok(Some(false));
        }
        self.by_states(f, place)
    }

    /// Changes states together by a part of what is small for them, and computes the rates; whether there are any.
    fn change(
        &mut self,
        f: &mut Rates,
        place: LinearisationPoint,
        states: impl Iterator<Item = usize> + Clone,
        part: impl Fn(usize) -> f64,
    ) -> Called<bool> {
        for state in states.clone() {
            self.at[state] = place.states[state] + part(state) * place.sizes[state];
        }
        let computed = f(place.time, &self.at, &mut self.rates)?;
        for state in states.filter(|_| !computed) {
            self.at[state] = place.states[state];
        }
        Ok(computed)
    }

    /// The same ahead, or where the FMU refuses that, back.
    fn change_either_way(&mut self, f: &mut Rates, place: LinearisationPoint, states: &[usize]) -> Called<bool> {
        let states = states.iter().copied();
        Ok(self.change(f, place, states.clone(), |_| 1.0)? || self.change(f, place, states, |_| -1.0)?)
    }

    fn by_groups(&mut self, f: &mut Rates, place: LinearisationPoint) -> Called<bool> {
        let groups = std::mem::take(&mut self.groups);
        let mut outcome = Ok(true);
        for group in &groups {
            outcome = self.change_either_way(f, place, group);
            if !matches!(outcome, Ok(true)) {
                break;
            }
            for &state in group {
                // As rounding leaves it.
                let change = self.at[state] - place.states[state];
                for (rate, slope) in &mut self.columns[state] {
                    *slope = (self.rates[*rate] - place.rates[*rate]) / change;
                }
                self.at[state] = place.states[state];
            }
        }
        self.groups = groups;
        outcome
    }

    /// Whether the known dependencies explain what a change of all states does.
    fn explains(&mut self, f: &mut Rates, place: LinearisationPoint) -> Called<bool> {
        // No two states in the same proportion, so that no two effects cancel by a model's symmetry.
        if !self.change(f, place, 0..place.states.len(), |state| {
            let size = 0.5 + 0.5 * (state as f64 * 0.618_033_988_749_894_9).fract();
            if state.is_multiple_of(2) { size } else { -size }
        })? {
            return Ok(false);
        }
        let mut expected = vec![(0.0, 0.0); place.rates.len()];
        for (state, column) in self.columns.iter().enumerate() {
            let change = self.at[state] - place.states[state];
            for (rate, slope) in column {
                let (sum, size) = &mut expected[*rate];
                *sum += slope * change;
                *size += (slope * change).abs();
            }
        }
        self.at.copy_from_slice(place.states);
        Ok(place.rates.iter().zip(&self.rates).zip(expected).all(|((before, after), (sum, size))| {
            (after - before - sum).abs() <= UNEXPLAINED * size + ROUNDING * before.abs()
        }))
    }

    /// Changes each state alone.
    fn by_states(&mut self, f: &mut Rates, place: LinearisationPoint) -> Called<Option<bool>> {
        let mut more = false;
        for state in 0..place.states.len() {
            if !self.change_either_way(f, place, &[state])? {
                return Ok(None);
            }
            let change = self.at[state] - place.states[state];
            self.at[state] = place.states[state];
            let mut known = std::mem::take(&mut self.columns[state]).into_iter().peekable();
            for (rate, (after, before)) in self.rates.iter().zip(place.rates).enumerate() {
                let is_known = known.next_if(|(other, _)| *other == rate).is_some();
                if is_known || after != before {
                    self.columns[state].push((rate, (after - before) / change));
                    more |= !is_known;
                }
            }
        }
        if more {
            self.group();
        }
        Ok(Some(more))
    }

    /// Puts each state into the first group none of whose states it shares a rate with.
    fn group(&mut self) {
        self.groups.clear();
        let mut taken: Vec<Vec<bool>> = Vec::new();
        for (state, column) in self.columns.iter().enumerate() {
            let group =
                taken.iter().position(|taken| column.iter().all(|(rate, _)| !taken[*rate])).unwrap_or_else(|| {
                    taken.push(vec![false; self.columns.len()]);
                    self.groups.push(Vec::new());
                    taken.len() - 1
                });
            self.groups[group].push(state);
            for (rate, _) in column {
                taken[group][*rate] = true;
            }
        }
    }
}

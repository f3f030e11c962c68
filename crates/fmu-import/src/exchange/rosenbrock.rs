//! The linearly implicit Rosenbrock method RODAS of order 4(3), stiffly accurate and L-stable: Hairer & Wanner (1996),
//! Solving Ordinary Differential Equations II, section IV.7 and the code RODAS.
//!
//! One method serves stiff and other systems: the derivatives over the states are taken by differences at each step,
//! so that none of them is ever old.

use super::{
    jacobian::{Jacobian, LinearisationPoint, Rates},
    sparse::Triangles,
};
use crate::call::Called;

const GAMMA: f64 = 0.25;
/// The times of the stages.
const C: [f64; 6] = [0.0, 0.386, 0.21, 0.63, 1.0, 1.0];
/// The weights of the derivative over time.
const D: [f64; 6] = [0.25, -0.1043, 0.1035, -0.0362, 0.0, 0.0];
/// The places of the stages; the sixth is the fifth with its own increment.
const A: [&[f64]; 5] = [
    &[],
    &[1.544],
    &[0.946_678_528_081_582_6, 0.255_701_169_898_328_4],
    &[3.314_825_187_068_521, 2.896_124_015_972_201, 0.998_641_913_997_781_7],
    &[1.221_224_509_226_641, 6.019_134_481_288_629, 12.537_083_329_320_87, -0.687_886_036_105_895],
];
/// The weights of earlier increments in the right-hand sides.
const G: [&[f64]; 6] = [
    &[],
    &[-5.6688],
    &[-2.430_093_356_833_875, -0.206_359_915_709_191_5],
    &[-0.107_352_905_815_137_5, -9.594_562_251_023_355, -20.470_286_148_096_16],
    &[7.496_443_313_967_647, -10.246_804_314_643_52, -33.999_903_528_199_05, 11.708_908_932_061_6],
    &[
        8.083_246_795_921_522,
        -7.981_132_988_064_893,
        -31.521_594_328_743_71,
        16.319_305_431_231_36,
        -6.058_818_238_834_054,
    ],
];

/// The method with its workspace, for one number of states.
#[derive(Debug, Default)]
pub struct Rosenbrock {
    /// The derivatives of the rates over the states and over time, and the rates.
    jacobian: Jacobian,
    in_time: Vec<f64>,
    first: Vec<f64>,
    /// The matrix of the stages, decomposed.
    matrix: Triangles,
    increments: [Vec<f64>; 6],
    at: Vec<f64>,
    rates: Vec<f64>,
}

impl Rosenbrock {
    /// One for `n` states.
    pub fn new(n: usize) -> Self {
        Self {
            jacobian: Jacobian::new(n),
            in_time: vec![0.0; n],
            first: vec![0.0; n],
            matrix: Triangles::default(),
            increments: std::array::from_fn(|_| vec![0.0; n]),
            at: vec![0.0; n],
            rates: vec![0.0; n],
        }
    }

    /// Linearises at a time and states. `nominals` are the states' typical magnitudes, and `h` the likely step, s,
    /// after whose end no rates are asked for. Whether there are rates, there and a little beside it in each state.
    pub fn linearise(&mut self, f: &mut Rates, time: f64, states: &[f64], nominals: &[f64], h: f64) -> Called<bool> {
        if states.is_empty() {
            return Ok(true);
        }
        if !f(time, states, &mut self.first)? {
            return Ok(false);
        }
        let root = f64::EPSILON.sqrt();
        let sizes: Vec<f64> =
            states.iter().zip(nominals).map(|(state, nominal)| root * state.abs().max(*nominal)).collect();
        let Some(more) =
            self.jacobian.compute(f, LinearisationPoint { time, states, rates: &self.first, sizes: &sizes })?
        else {
            return Ok(false);
        };
        if more || !self.matrix.is_for(states.len()) {
            self.matrix = Triangles::of(&self.jacobian.columns);
        }
        // Without rates ahead in time, the error of the step says what that costs.
        self.in_time.fill(0.0);
        let later = (time + root * time.abs().max(h)).min(time + h);
        if later > time && f(later, states, &mut self.rates)? {
            for (slope, (after, before)) in self.in_time.iter_mut().zip(self.rates.iter().zip(&self.first)) {
                *slope = (after - before) / (later - time);
            }
        }
        Ok(true)
    }

    /// The first state, from 1, whose rate is no finite number where it was linearised, and that rate.
    pub fn unfit(&self) -> Option<(usize, f64)> {
        let mut rates = (1..).zip(self.first.iter().copied());
        rates.find(|(_, rate)| !rate.is_finite())
    }

    /// Tries a step of `h` seconds from where it was linearised. The error relative to `allowed` and the new states
    /// in `end`; none where the step cannot be computed.
    pub fn attempt(
        &mut self,
        f: &mut Rates,
        time: f64,
        states: &[f64],
        h: f64,
        allowed: &[f64],
        end: &mut [f64],
    ) -> Called<Option<f64>> {
        let n = states.len();
        if n == 0 {
            return Ok(Some(0.0));
        }
        if !self.matrix.decompose(&self.jacobian.columns, 1.0 / (h * GAMMA)) {
            return Ok(None);
        }
        for stage in 0..6 {
            if stage < 5 {
                self.at.copy_from_slice(states);
                for (weight, increment) in A[stage].iter().zip(&self.increments) {
                    add(&mut self.at, *weight, increment);
                }
            } else {
                add(&mut self.at, 1.0, &self.increments[4]);
            }
            if stage == 0 {
                self.rates.copy_from_slice(&self.first);
            } else if !f(time + C[stage] * h, &self.at, &mut self.rates)? {
                return Ok(None);
            }
            for (weight, increment) in G[stage].iter().zip(&self.increments) {
                add(&mut self.rates, weight / h, increment);
            }
            add(&mut self.rates, D[stage] * h, &self.in_time);
            self.matrix.solve(&mut self.rates);
            self.increments[stage].copy_from_slice(&self.rates);
        }
        end.copy_from_slice(&self.at);
        add(end, 1.0, &self.increments[5]);
        let mut worst = 0.0_f64;
        for ((error, allowed), value) in self.increments[5].iter().zip(allowed).zip(end.iter()) {
            let share = (error / allowed).abs();
            if !share.is_finite() || !value.is_finite() {
                return Ok(None);
            }
            worst = worst.max(share);
        }
        Ok(Some(worst))
    }
}

fn add(to: &mut [f64], weight: f64, what: &[f64]) {
    for (to, what) in to.iter_mut().zip(what) {
        *to += weight * what;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Fixed steps over a span; the last states and the largest error estimate.
    fn run(f: &mut Rates, mut states: Vec<f64>, span: f64, steps: usize) -> (Vec<f64>, f64) {
        let n = states.len();
        let mut method = Rosenbrock::new(n);
        let (h, ones) = (span / steps as f64, vec![1.0; n]);
        let mut largest = 0.0_f64;
        for step in 0..steps {
            let time = step as f64 * h;
            assert!(method.linearise(f, time, &states, &ones, h).unwrap());
            let mut end = vec![0.0; n];
            let error = method.attempt(f, time, &states, h, &ones, &mut end).unwrap();
            largest = largest.max(error.unwrap());
            states = end;
        }
        (states, largest)
    }

    #[test]
    fn the_order_is_four_with_time_in_the_rates() {
        // x' = -2 t x^2 with x(0) = 1 is 1 / (1 + t^2).
        let error = |steps| {
            let mut f = |t: f64, x: &[f64], rates: &mut [f64]| {
                rates[0] = -2.0 * t * x[0] * x[0];
                rates[1] = -x[1] + t.sin();
                Ok(true)
            };
            let (end, _) = run(&mut f, vec![1.0, 0.5], 1.0, steps);
            // x' = -x + sin t with x(0) = 1/2 is exp(-t) + (sin t - cos t) / 2.
            let other = (-1.0_f64).exp() + 0.5 * (1.0_f64.sin() - 1.0_f64.cos());
            (end[0] - 0.5).abs().max((end[1] - other).abs())
        };
        let order = (error(6) / error(12)).log2();
        assert!((order - 4.0).abs() < 0.35, "{order}");
    }

    /// The Jacobian of another place says nothing here.
    #[test]
    fn a_state_that_cannot_be_changed_has_no_jacobian() {
        let mut method = Rosenbrock::new(2);
        let mut closed = false;
        for expected in [true, false] {
            let mut f = |_: f64, x: &[f64], rates: &mut [f64]| {
                rates.copy_from_slice(x);
                Ok(!closed || x[1] == 2.0)
            };
            let seen = method.linearise(&mut f, 0.0, &[1.0, 2.0], &[1.0, 1.0], 0.1);
            assert_eq!(seen.unwrap(), expected);
            closed = true;
        }
    }

    #[test]
    fn a_stiff_system_is_stable_in_long_steps() {
        let mut f = |t: f64, x: &[f64], rates: &mut [f64]| {
            rates[0] = -1e6 * (x[0] - t.cos());
            Ok(true)
        };
        let (end, _) = run(&mut f, vec![0.0], 2.0, 20);
        assert!((end[0] - 2.0_f64.cos()).abs() < 1e-5, "{end:?}");
    }

    #[test]
    fn a_coupled_system_needs_the_exchange_of_rows() {
        // The first pivot of h = 4 is zero: 1 / (h gamma) - 1.
        let mut f = |_: f64, x: &[f64], rates: &mut [f64]| {
            rates[0] = x[0] + x[1];
            rates[1] = x[0] - x[1];
            Ok(true)
        };
        let mut method = Rosenbrock::new(2);
        assert!(method.linearise(&mut f, 0.0, &[1.0, 0.0], &[1.0; 2], 4.0).unwrap());
        method.jacobian.columns = vec![vec![(0, 1.0), (1, 1.0)], vec![(0, 1.0), (1, -1.0)]];
        let mut end = [0.0; 2];
        let error = method.attempt(&mut f, 0.0, &[1.0, 0.0], 4.0, &[1.0; 2], &mut end).unwrap();
        assert!(error.is_some());
    }

    /// Heat along a chain whose first state, once it is cool, cools the last: the states are looked at one by one twice,
    /// else by three or four groups.
    #[test]
    fn a_long_chain_takes_few_evaluations() {
        const N: usize = 300;
        let end = |steps: usize| {
            let mut evaluations = 0;
            let mut f = |_: f64, x: &[f64], rates: &mut [f64]| {
                evaluations += 1;
                for i in 0..N {
                    rates[i] = 1e5 * (x[i.max(1) - 1] - 2.0 * x[i] + x[(i + 1).min(N - 1)]);
                }
                rates[N - 1] += 1e3 * (x[0] - 0.9).min(0.0);
                Ok(true)
            };
            let start = (0..N).map(|i| if i < N / 2 { 1.0 } else { 0.0 }).collect();
            let (end, _) = run(&mut f, start, 0.5, steps);
            assert!(evaluations < 2 * N + 13 * steps, "{evaluations}");
            end
        };
        let (long, short) = (end(40), end(160));
        assert!(short[0] < 0.9 && short[N - 1] < 0.1, "{short:?}");
        assert!(long.iter().zip(&short).all(|(a, b)| (a - b).abs() < 1e-4), "{long:?} {short:?}");
    }

    #[test]
    fn what_cannot_be_computed_is_no_step() {
        let mut method = Rosenbrock::new(1);
        let mut f = |t: f64, _: &[f64], rates: &mut [f64]| {
            rates[0] = if t > 0.5 { f64::NAN } else { 1.0 };
            Ok(t < 0.7)
        };
        assert!(method.linearise(&mut f, 0.0, &[0.0], &[1.0], 1.0).unwrap());
        let mut end = [0.0];
        let mut attempt = |h| method.attempt(&mut f, 0.0, &[0.0], h, &[1.0], &mut end).unwrap();
        assert!(attempt(1.0).is_none());
        assert!(attempt(0.65).is_none());
        assert!(attempt(0.5).is_some());
        assert!(!method.linearise(&mut f, 0.9, &[0.0], &[1.0], 1.0).unwrap());
    }
}

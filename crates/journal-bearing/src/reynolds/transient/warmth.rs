//! The film's temperature around the bearing: one for each column, averaged over the gap and the width.
//!
//! A column holds the oil `M` and the heat `rho c M T`. Oil brings its temperature along (upwind), around the bearing, from the bath
//! at the ends and from feeds; a fed column mixes what is carried over with what comes in. Friction heats the column, and bush and
//! shaft take heat by conduction across the gap:
//!
//! ```text
//! rho c (M T - M0 T0)/dt = rho c sum(flux T_upstream) + Q - g_bush (T - T_bush) - g_shaft (T - T_shaft)
//! ```
//!
//! (the film's energy equation averaged over its thickness: Cope 1949, Proc. R. Soc. A 197, 201-217, with the conduction to both
//! surfaces that he left out). A step is implicit; its fluxes are the means of the film's step, which move its oil from `M0` to `M`,
//! so that no heat is lost. The viscosity of a step is that of the temperatures before it.

use serde::{Deserialize, Serialize};

use super::stage::NoSolution;

/// What the film exchanges heat with, and how well.
#[derive(Clone, Copy)]
pub struct HeatExchange<'a> {
    /// Temperature of the bush, K.
    pub bush: f64,
    /// Temperature of the shaft, K.
    pub shaft: f64,
    /// Temperature of the bath, K.
    pub bath: f64,
    /// Temperature of the oil that feeds bring, K.
    pub feed: f64,
    /// Temperature with which a film begins that has none yet, K.
    pub start: f64,
    /// Conductance from a film as thick as the clearance all around to bush and shaft, W/K.
    pub conductance: [f64; 2],
    /// Share of the oil drawn in at the ends that is the bath's, 1; the rest is as hot as the film there.
    pub fresh: f64,
    /// Heat capacity of the oil, J/(m3 K).
    pub capacity: f64,
    /// Viscosity, Pa.s, at a temperature, K.
    pub viscosity: &'a dyn Fn(f64) -> f64,
}

/// Heat that the film gives away, W: means over an interval.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HeatGiven {
    /// To the bush.
    pub bush: f64,
    /// To the shaft.
    pub shaft: f64,
    /// To the bath: what oil leaves with, beyond the bath's temperature.
    pub bath: f64,
    /// What feeds bring beyond the bath's temperature, as a loss.
    pub feed: f64,
    /// Stored in the film, beyond the bath's temperature.
    pub film: f64,
}

impl HeatGiven {
    /// Adds that of an internal step times its duration, s.
    pub(super) fn plus(&self, step: &Self, duration: f64) -> Self {
        Self {
            bush: self.bush + step.bush * duration,
            shaft: self.shaft + step.shaft * duration,
            bath: self.bath + step.bath * duration,
            feed: self.feed + step.feed * duration,
            film: self.film + step.film * duration,
        }
    }
}

/// The temperature of a column, K, and the reciprocal viscosity there, relative to the drive's.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Warm {
    pub temperature: f64,
    pub fluidity: f64,
}

/// A column during a step: oil in m3 and m3/s, conductances in W/K.
#[derive(Clone, Copy, Debug, Default)]
pub struct Column {
    /// Oil at the start and at the end.
    pub held: [f64; 2],
    /// Over the edge before the column, in the direction of the angle.
    pub around: f64,
    /// Out of the ends, and in.
    pub ends: [f64; 2],
    /// Out into feeds, and in.
    pub feed: [f64; 2],
    /// Friction heat, W.
    pub heat: f64,
    /// To bush and shaft.
    pub conductance: [f64; 2],
}

/// Most sweeps around the bearing until the temperatures are known.
const SWEEPS: usize = 200;
/// They are when a sweep changes none by more than this, K.
const KNOWN: f64 = 1e-10;

/// Moves the temperatures, K, on by a step of `duration` seconds. Returns what the film gave away.
pub fn step(
    columns: &[Column],
    temperatures: &mut [f64],
    duration: f64,
    exchange: &HeatExchange,
) -> Result<HeatGiven, NoSolution> {
    let n = columns.len();
    let start = temperatures.to_vec();
    let HeatExchange { capacity, bath, bush, shaft, feed, fresh, .. } = *exchange;
    // All temperatures count from the bath's, so that heat and oil need one balance only.
    let sweep = |i: usize, t: &mut [f64]| {
        let column = &columns[i];
        let (before, after) = ((i + n - 1) % n, (i + 1) % n);
        let leaves = columns[after].around;
        let [to_bush, to_shaft] = column.conductance;
        let keeps = column.held[1] / duration + (-column.around).max(0.0) + leaves.max(0.0) + column.ends[0]
            - (1.0 - fresh) * column.ends[1]
            + column.feed[0];
        let comes = column.held[0] / duration * (start[i] - bath)
            + column.around.max(0.0) * (t[before] - bath)
            + (-leaves).max(0.0) * (t[after] - bath)
            + column.feed[1] * (feed - bath);
        let warms = column.heat + to_bush * (bush - bath) + to_shaft * (shaft - bath);
        let new = bath + (capacity * comes + warms) / (capacity * keeps + to_bush + to_shaft);
        let change = (new - t[i]).abs();
        t[i] = new;
        change
    };
    let mut sweeps = 0;
    loop {
        let (mut change, t) = (0.0_f64, &mut *temperatures);
        for i in (0..n).chain((0..n).rev()) {
            change = change.max(sweep(i, t));
        }
        sweeps += 1;
        if change <= KNOWN {
            break;
        }
        if sweeps == SWEEPS || change.is_nan() {
            return Err(NoSolution);
        }
    }
    let mut given = HeatGiven::default();
    for ((column, t), start) in columns.iter().zip(&*temperatures).zip(&start) {
        let over = t - bath;
        given.bush += column.conductance[0] * (t - bush);
        given.shaft += column.conductance[1] * (t - shaft);
        given.bath += capacity * (column.ends[0] - (1.0 - fresh) * column.ends[1]) * over;
        given.feed += capacity * (column.feed[0] * over - column.feed[1] * (feed - bath));
        let stored = column.held[1] * over - column.held[0] * (start - bath);
        given.film += capacity * stored / duration;
    }
    Ok(given)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    fn exchange() -> HeatExchange<'static> {
        HeatExchange {
            bush: 350.0,
            shaft: 355.0,
            bath: 320.0,
            feed: 310.0,
            start: 340.0,
            conductance: [10.0, 10.0],
            fresh: 1.0,
            capacity: 1.7e6,
            viscosity: &|_| 0.02,
        }
    }

    /// Columns of a film in which `T = 340 + 8 sin(theta)` is steady: friction heats by what transport and conduction take.
    fn manufactured(n: usize) -> Vec<Column> {
        let (flow, out, conductance) = (3e-7, 2e-8, [12.0, 7.0]);
        let width = TAU / n as f64;
        let at = |theta: f64| 340.0 + 8.0 * theta.sin();
        let of = |i: usize| {
            let theta = width * i as f64;
            let share = width / TAU;
            // What leaves at the ends comes from the bath again, evenly: the flow around stays.
            let ends = [out * share; 2];
            let carried = 1.7e6 * flow * 8.0 * theta.cos() * width;
            let leaves = 1.7e6 * out * share * (at(theta) - 320.0);
            let conductance = conductance.map(|all| all * share);
            let conducts = conductance[0] * (at(theta) - 350.0) + conductance[1] * (at(theta) - 355.0);
            Column {
                held: [1e-9 * share; 2],
                around: flow,
                ends,
                heat: carried + leaves + conducts,
                conductance,
                ..Column::default()
            }
        };
        (0..n).map(of).collect()
    }

    /// Upwind transport is of first order: with columns half as wide the error halves.
    #[test]
    fn a_manufactured_solution_is_found_in_first_order() {
        let error = |n: usize| {
            let columns = manufactured(n);
            let mut t = vec![340.0; n];
            for _ in 0..200 {
                let given = step(&columns, &mut t, 1e-2, &exchange()).unwrap();
                let heat: f64 = columns.iter().map(|column| column.heat).sum();
                let left = heat - given.bush - given.shaft - given.bath - given.feed - given.film;
                assert!(left.abs() < 1e-8 * heat.abs(), "{left} of {heat} W");
            }
            let off = |(i, t): (usize, &f64)| (t - 340.0 - 8.0 * (TAU * i as f64 / n as f64).sin()).abs();
            t.iter().enumerate().map(off).fold(0.0, f64::max)
        };
        let [coarse, fine, finest] = [48, 96, 192].map(error);
        println!("{coarse} {fine} {finest} K");
        assert!(fine < 0.3 && (coarse / fine - 2.0).abs() < 0.1 && (fine / finest - 2.0).abs() < 0.1);
    }

    /// Oil that is carried backwards, that fills a gap and that a feed brings: the heat is all there.
    #[test]
    fn no_heat_is_lost() {
        let n = 12;
        let flow = |i: usize| 1e-7 * (0.5 - ((i % n) as f64 * 0.9).cos());
        let columns: Vec<Column> = (0..n)
            .map(|i| {
                let ends = [2e-8, 1e-8 * (i % 3) as f64];
                let feed = if i == 4 { [0.0, 4e-8] } else { [1e-9, 0.0] };
                let comes = flow(i) - flow(i + 1) + ends[1] - ends[0] + feed[1] - feed[0];
                Column {
                    held: [5e-9, 5e-9 + 1e-2 * comes],
                    around: flow(i),
                    ends,
                    feed,
                    heat: 0.3,
                    conductance: [1.0, 0.5],
                }
            })
            .collect();
        let mut t = vec![345.0; n];
        let carried_over = HeatExchange { fresh: 0.3, ..exchange() };
        let given = step(&columns, &mut t, 1e-2, &carried_over).unwrap();
        let left = 0.3 * n as f64 - given.bush - given.shaft - given.bath - given.feed - given.film;
        assert!(left.abs() < 1e-8, "{left} W: {given:?}");
        assert!(t.iter().all(|t| (310.0..400.0).contains(t)), "{t:?}");
    }
}

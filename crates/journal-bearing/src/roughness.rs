//! The film between rough surfaces: the gaps through which it sees them.
//!
//! Lengths are in units of the composite rms roughness `sigma`: `H` is the film ratio, the distance of the surfaces' mean
//! planes over `sigma`; it is negative where they cross.
//!
//! The film has a gap for each of its tasks, and all of them are `H` between smooth surfaces:
//!
//! * its *content*: the mean gap `H Phi(H) + phi(H)` (Patir & Cheng 1978). Its slope `Phi`, the share of the area where the
//!   surfaces do not touch, drives the film and bears its pressure;
//! * its *flow*: `H phi_p^(1/3)`, with the pressure flow factor (Patir & Cheng 1978);
//! * its *shear*: `H / (phi_f + phi_fs)`, with the shear stress factors (Patir & Cheng 1979), see [`stress`].
//!
//! Patir & Cheng's simulations end at `H = 0.5`. As the surfaces come closer, the touching area cuts the film into pockets
//! until nothing flows any more, at a touching share of about 0.42 (Persson et al. 2012, Eur. Phys. J. E 35:5; Wang & Mueser
//! 2021, Tribol. Lett. 69:1), which is `Phi = 0.58` and `H = 0.2`. Real patches scatter about it. The connected share of
//! the film therefore falls smoothly from one at `H = 0.5` to nothing at `H = -0.5`; oil in closed pockets neither flows, nor
//! is it squeezed, nor bears load. The asperities bear it.

mod flow;
mod reach;
mod stress;

use std::{f64::consts::TAU, sync::LazyLock};

use serde::{Deserialize, Serialize};

use crate::spline::{Spline, SplineEnd};
pub use flow::{pressure_flow_factor, shear_flow_factor};
pub use reach::Reach;
use stress::sliding_resistance;
pub use stress::{shear_stress_factor, sliding_stress_factor};

/// How the film sees rough surfaces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub enum RoughFilm {
    /// The film ignores the roughness: its gap is the distance of the mean planes, and must not close.
    #[default]
    Nominal,
    /// The mean gap between the asperities and the flow and stress factors of Patir & Cheng (1978, 1979) for isotropic
    /// surfaces. The factors count in full up to a film ratio of 5, and fade out where asperities no longer touch.
    MeanGap,
    /// The same without fading, and with the shear flow of surfaces of unlike roughness.
    FlowFactors {
        /// The journal's share of the composite roughness' variance, 0..1. At one half, the shear flows of both
        /// surfaces cancel.
        journal_share: f64,
    },
}

/// A gap and its slope over the distance of the mean planes.
pub type Width = [f64; 2];

/// Film ratio beyond which asperities do not touch: `F_5/2` is below 1e-13.
pub const NO_CONTACT: f64 = 7.0;
/// The lowest film ratio of the table. Below, all oil is in closed pockets.
const LEAST: f64 = -5.0;
/// Up to this film ratio the factors count in full.
const FULL: f64 = 5.0;
/// Table nodes per unit of `H`.
const PER_UNIT: f64 = 32.0;
const CELLS: usize = ((NO_CONTACT - LEAST) * PER_UNIT) as usize;
const NODES: usize = CELLS + 1;

/// The least film ratio of Patir & Cheng's simulations of the pressure flow.
const LEAST_FOR_FLOW: f64 = 0.5;
/// Film ratio at which no film is connected.
const CUT_OFF: f64 = -0.5;
/// Least share of the flow that is left, so that the pressure in closed pockets is determined.
const SEEPAGE: f64 = 1e-2;

/// A cubic over one cell of the table, lowest power first.
#[derive(Clone, Copy, Debug, Default)]
struct Cubic([f64; 4]);

impl Cubic {
    /// The cubic between two values with their slopes.
    fn between([a, slope_a]: Width, [b, slope_b]: Width) -> Self {
        let [slope_a, slope_b] = [slope_a / PER_UNIT, slope_b / PER_UNIT];
        let rise = b - a;
        Self([a, slope_a, 3.0 * rise - 2.0 * slope_a - slope_b, slope_a + slope_b - 2.0 * rise])
    }

    /// Value and slope at a place in 0..1.
    #[inline(always)]
    fn at(self, t: f64) -> Width {
        let [a, b, c, d] = self.0;
        [a + t * (b + t * (c + t * d)), PER_UNIT * (b + t * (2.0 * c + t * 3.0 * d))]
    }
}

/// Mean gap, content, flow and resistance, with their slopes, at a node of the table.
#[derive(Clone, Copy, Debug, Default)]
struct Node {
    mean: Width,
    content: Width,
    flow: Width,
    resistance: Width,
}

/// The same over a cell of the table. Its gaps share a line of the processor's cache, as the film looks them up in each column.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(64))]
pub struct Cell {
    /// Content and flow side by side, as the film asks for both in each of its columns; lowest power first.
    gaps: [[f64; 2]; 4],
    mean: Cubic,
    resistance: Cubic,
}

impl Cell {
    fn between(a: &Node, b: &Node) -> Self {
        let content = Cubic::between(a.content, b.content).0;
        let flow = Cubic::between(a.flow, b.flow).0;
        Self {
            gaps: std::array::from_fn(|power| [content[power], flow[power]]),
            mean: Cubic::between(a.mean, b.mean),
            resistance: Cubic::between(a.resistance, b.resistance),
        }
    }

    /// Content and flow at a place in 0..1.
    #[inline(always)]
    fn gaps(&self, t: f64) -> [f64; 2] {
        let [a, b, c, d] = &self.gaps;
        std::array::from_fn(|k| a[k] + t * (b[k] + t * (c[k] + t * d[k])))
    }

    /// Their slopes.
    #[inline(always)]
    fn slopes(&self, t: f64) -> [f64; 2] {
        let [_, b, c, d] = &self.gaps;
        std::array::from_fn(|k| PER_UNIT * (b[k] + t * (2.0 * c[k] + t * 3.0 * d[k])))
    }
}

/// The gaps of [`RoughFilm::MeanGap`] over the film ratio.
pub type Table = [Cell; CELLS];

static TABLE: LazyLock<Box<Table>> = LazyLock::new(tabulate);

/// The table, for many look-ups.
pub fn table() -> &'static Table {
    &TABLE
}

fn tabulate() -> Box<Table> {
    let ratio = |i: usize| LEAST + i as f64 / PER_UNIT;
    let mut nodes = mean_gaps();
    let spline = Spline::new(NODES, [SplineEnd::Free; 2]);
    let mut slopes = vec![0.0; NODES];
    let mut splined = |values: Vec<f64>| -> Vec<Width> {
        spline.slopes(&values, &mut slopes);
        values.iter().zip(&slopes).map(|(value, slope)| [*value, slope * PER_UNIT]).collect()
    };
    let means = nodes.iter().enumerate();
    let flows = splined(means.map(|(i, node)| flow_gap(ratio(i), node.mean[0])).collect());
    let resistances = splined((0..NODES).map(|i| faded_resistance(ratio(i))).collect());
    for (node, (flow, resistance)) in nodes.iter_mut().zip(flows.into_iter().zip(resistances)) {
        (node.flow, node.resistance) = (flow, resistance);
    }
    let cells: Box<[Cell]> = nodes.windows(2).map(|ends| Cell::between(&ends[0], &ends[1])).collect();
    cells.try_into().expect("a cell lies between two nodes")
}

/// `Phi` and `H Phi + phi` at the lowest film ratio.
const START: [f64; 2] = [2.866_515_718_791_939e-7, 5.346_165_533_833e-8];

/// Nodes with mean gap and content, by integrating the normal density once and twice.
fn mean_gaps() -> Vec<Node> {
    let density = |x: f64| (-0.5 * x * x).exp() / TAU.sqrt();
    let d = 0.5 / PER_UNIT;
    let [mut open, mut gap] = START;
    let mut content = 0.0;
    let mut x = LEAST;
    let mut node = Node::default();
    (node.mean, node.content) = ([gap, open], [content, 0.0]);
    let mut nodes = vec![node];
    while nodes.len() < NODES {
        let mut films = [open * connected(x), 0.0, 0.0];
        for film in &mut films[1..] {
            // Simpson's rule, and for the second integral the weights that match it.
            let [a, b, c] = [x, x + 0.5 * d, x + d].map(density);
            gap += d * open + d * d * (a + 2.0 * b) / 6.0;
            open += d * (a + 4.0 * b + c) / 6.0;
            x += d;
            *film = open * connected(x);
        }
        content += d * (films[0] + 4.0 * films[1] + films[2]) / 3.0;
        (node.mean, node.content) = ([gap, open], [content, films[2]]);
        nodes.push(node);
    }
    // From here on all of the film is connected, so its content is the mean gap. The integral began at an unknown constant:
    // shift it so that both meet here.
    let whole = ((LEAST_FOR_FLOW - LEAST) * PER_UNIT) as usize;
    let closed = nodes[whole].mean[0] - nodes[whole].content[0];
    for node in &mut nodes[..whole] {
        node.content[0] += closed;
    }
    for node in &mut nodes[whole..] {
        node.content = node.mean;
    }
    nodes
}

/// A cubic that rises from 0 to 1 between two places.
fn rise(from: f64, to: f64, at: f64) -> f64 {
    let t = ((at - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// The share of the open area whose film is connected.
fn connected(ratio: f64) -> f64 {
    rise(CUT_OFF, LEAST_FOR_FLOW, ratio)
}

/// The share of the factors that counts at a film ratio.
fn share(ratio: f64) -> f64 {
    1.0 - rise(FULL, NO_CONTACT, ratio)
}

/// The gap of the flow at a film ratio and its mean gap.
fn flow_gap(ratio: f64, mean: f64) -> f64 {
    let factor = 1.0 - share(ratio) * (1.0 - pressure_flow_factor(ratio.max(LEAST_FOR_FLOW)));
    if ratio >= LEAST_FOR_FLOW {
        return ratio * factor.cbrt();
    }
    // Below, the flow goes with the third power of the mean gap, as far as it is connected.
    let connected = SEEPAGE + (1.0 - SEEPAGE) * connected(ratio);
    mean * (factor * connected).cbrt() * LEAST_FOR_FLOW / MEAN_AT_LEAST
}

/// The mean gap at the least film ratio of the flow.
const MEAN_AT_LEAST: f64 = 0.697_796_5;

/// Resistance to sliding at a film ratio: the reciprocal of the gap of the shear.
fn faded_resistance(ratio: f64) -> f64 {
    let rough = sliding_resistance(ratio);
    match share(ratio) {
        1.0 => rough,
        share => share * rough + (1.0 - share) / ratio,
    }
}

/// The cell of the table at a film ratio, and the place in it; `None` above the table's end. Below its start, the start counts.
#[inline(always)]
fn look_up(table: &Table, ratio: f64) -> Option<(&Cell, f64)> {
    if ratio >= NO_CONTACT {
        return None;
    }
    let position = (ratio.max(LEAST) - LEAST) * PER_UNIT;
    // A conversion to 32 bits takes fewer instructions.
    let cell = (position as u32).min(CELLS as u32 - 1);
    Some((&table[cell as usize], position - f64::from(cell)))
}

impl RoughFilm {
    /// The gaps of content and flow at a film ratio.
    #[inline(always)]
    pub fn gaps(self, ratio: f64) -> [Width; 2] {
        let [[content, flow], [bears, widens]] = self.gaps_in(table(), ratio);
        [[content, bears], [flow, widens]]
    }

    /// The gaps of content and flow at a film ratio, then the slopes of both. Slopes that nobody uses cost nothing.
    #[inline(always)]
    pub(crate) fn gaps_in(self, table: &Table, ratio: f64) -> [[f64; 2]; 2] {
        if let Self::FlowFactors { .. } = self
            && ratio > FULL
        {
            let factor = pressure_flow_factor(ratio);
            let (flow, steep) = (ratio * factor.cbrt(), 0.56 * (1.0 - factor) / factor);
            let [content, bears] = open_gap(ratio);
            let widens = flow * (1.0 / ratio + steep / 3.0);
            return [[content, flow], [bears, widens]];
        }
        match look_up(table, ratio) {
            Some((cell, t)) => [cell.gaps(t), cell.slopes(t)],
            None => [[ratio; 2], [1.0; 2]],
        }
    }

    /// Resistance to sliding at a film ratio: the reciprocal of the gap of the shear.
    #[inline]
    pub fn resistance(self, ratio: f64) -> f64 {
        if let Self::FlowFactors { .. } = self
            && ratio > FULL
        {
            return sliding_resistance(ratio);
        }
        resistance(ratio)[0]
    }
}

/// The film's resistance to sliding at a film ratio as [`RoughFilm::MeanGap`] sees it, and its slope.
pub fn resistance(ratio: f64) -> Width {
    match look_up(table(), ratio) {
        Some((cell, t)) => cell.resistance.at(t),
        None => [1.0 / ratio, -1.0 / (ratio * ratio)],
    }
}

/// The mean gap between Gaussian surfaces over their roughness, 1, at a film ratio `H`: `H Phi(H) + phi(H)`, where `Phi` is the
/// normal distribution and `phi` its density (average gap of Patir & Cheng 1978).
pub fn mean_gap(ratio: f64) -> f64 {
    open_gap(ratio)[0]
}

/// The mean gap and its derivative `Phi(H)`, the share of the area where the surfaces do not touch.
fn open_gap(ratio: f64) -> Width {
    if ratio < LEAST {
        let [gap, slope] = TABLE[0].mean.at(0.0);
        let fall = (slope / gap * (ratio - LEAST)).exp();
        return [gap * fall, slope * fall];
    }
    look_up(table(), ratio).map_or([ratio, 1.0], |(cell, t)| cell.mean.at(t))
}

/// How fast the share of the area that bears the film grows as the surfaces part.
pub fn parting(ratio: f64) -> f64 {
    look_up(table(), ratio).map_or(0.0, |(cell, t)| {
        let [_, _, [c, _], [d, _]] = cell.gaps;
        PER_UNIT * PER_UNIT * (2.0 * c + t * 6.0 * d)
    })
}

#[cfg(test)]
mod tests {
    use super::reach::room;
    use super::*;

    /// `Phi` to 7 decimals: Abramowitz & Stegun 1964, table 26.1.
    #[test]
    fn the_mean_gap_is_that_of_the_normal_distribution() {
        for (ratio, distribution) in
            [(-3.0, 0.001_349_9), (-1.0, 0.158_655_3), (0.0, 0.5), (0.44, 0.670_031_4), (2.0, 0.977_249_9)]
        {
            let ratio: f64 = ratio;
            let density = (-0.5 * ratio * ratio).exp() / TAU.sqrt();
            let [gap, slope] = open_gap(ratio);
            assert!((slope - distribution).abs() < 2e-7, "{ratio}: {slope}");
            let expected = ratio * distribution + density;
            assert!((gap - expected).abs() < 3e-7, "{ratio}: {gap} {expected}");
        }
        let [gap, slope] = open_gap(5.999);
        assert!((gap - 5.999).abs() < 1e-8 && (slope - 1.0).abs() < 1e-8);
        assert_eq!(open_gap(7.0), [7.0, 1.0]);
        assert_eq!(open_gap(1e300), [1e300, 1.0]);
        // Below the table it tends to zero without a jump.
        let [above, below] = [-4.999, -5.001].map(mean_gap);
        assert!(below > 0.0 && below < above && above < 1.1 * below);
        assert!(mean_gap(-20.0) >= 0.0);
    }

    /// Up to five roughnesses the gaps are the published ones; the table interpolates them.
    #[test]
    fn the_film_s_gaps_are_the_published_ones() {
        let law = RoughFilm::MeanGap;
        // The table rounds the corner at the end of the published range.
        for k in 6..50 {
            let ratio = 0.1 * f64::from(k) + 0.03;
            let [[content, bears], [flow, _]] = law.gaps(ratio);
            let [mean, open] = open_gap(ratio);
            assert!((content - mean).abs() < 1e-6 && (bears - open).abs() < 1e-4);
            let published = pressure_flow_factor(ratio) * ratio.powi(3);
            assert!((flow.powi(3) / published - 1.0).abs() < 2e-3, "{ratio}");
            let stress = law.resistance(ratio) / sliding_resistance(ratio);
            assert!((stress - 1.0).abs() < 1e-3, "{ratio}: {stress}");
        }
    }

    /// Every gap is the distance itself, to the last bit, where asperities do not touch, and comes to it without a jump.
    #[test]
    fn far_surfaces_are_smooth() {
        let law = RoughFilm::MeanGap;
        for ratio in [NO_CONTACT, 7.3, 1e9] {
            assert_eq!(law.gaps(ratio), [[ratio, 1.0]; 2]);
            assert_eq!(law.resistance(ratio), 1.0 / ratio);
            assert_eq!(room(ratio), [ratio, 1.0]);
            assert_eq!(mean_gap(ratio), ratio);
        }
        let near = NO_CONTACT - 1e-9;
        for [gap, slope] in law.gaps(near).into_iter().chain([room(near)]) {
            assert!((gap - near).abs() < 1e-8 && (slope - 1.0).abs() < 1e-3);
        }
        assert!((law.resistance(near) * near - 1.0).abs() < 1e-8);
    }

    /// Beyond the connected film nothing is squeezed or borne, and hardly anything flows; on the way there no gap jumps.
    #[test]
    fn closed_pockets_bear_nothing() {
        let law = RoughFilm::MeanGap;
        for ratio in [CUT_OFF, -1.03, -4.9, -50.0] {
            let [[content, bears], [flow, _]] = law.gaps(ratio);
            assert!(bears.abs() < 1e-12 && content > 0.3 && content < 0.5);
            assert!(flow > 0.0 && flow.powi(3) < 1e-4, "{ratio}: {flow}");
        }
        let steps = (0..1200).map(|k| -5.0 + 0.01 * f64::from(k));
        for ratio in steps {
            let [[_, bears], [flow, widens]] = law.gaps(ratio);
            let [_, [next, _]] = law.gaps(ratio + 1e-6);
            assert!((0.0..=1.0 + 1e-12).contains(&bears), "{ratio}: {bears}");
            assert!(((next - flow) / 1e-6 - widens).abs() < 1e-3, "{ratio}");
        }
    }
}

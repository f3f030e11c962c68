//! What a step of the film gives: forces, torques, flows, and how well the balances close.

use std::ops::Range;

use nalgebra::Vector2;

use super::balance::Stage;
use super::compression;
use super::film::ReynoldsFilm;
use super::lanes::{dot, largest, sum_of};
use super::linear::load;
use super::roughness::shear_flow_factor;
use super::settings::Drive;
use super::stress::sliding_resistance;

/// The film after an interval, and its means over it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Diagnostics {
    /// External load that the film's pressure carries, N.
    pub film_load: Vector2<f64>,
    /// Rate of the eccentricity ratio, 1/s.
    pub velocity: Vector2<f64>,
    /// Torque with which the film brakes a journal that turns ahead of the bush, N.m.
    pub journal_torque: f64,
    /// Torque with which the film drags the bush along, N.m.
    pub bush_torque: f64,
    /// Largest pressure above that of the bath, Pa.
    pub max_pressure: f64,
    /// Smallest gap, m.
    pub smallest_gap: f64,
    /// Contact pressure of the cells' asperities integrated over the surface, N.
    pub contact_normal: f64,
    /// Oil that leaves at both ends, m3/s.
    pub outflow: f64,
    /// Oil that comes in at both ends, m3/s.
    pub inflow: f64,
    /// Heat that the film makes, W.
    pub heat: f64,
    /// Mean of the journal's torque over the interval, N.m.
    pub mean_journal_torque: f64,
    /// Mean of the heat over the interval, W.
    pub mean_heat: f64,
    /// Mean of the outflow over the interval, m3/s.
    pub mean_outflow: f64,
    /// Internal steps.
    pub steps: usize,
    /// Largest error of an internal step's mass balance, over the flow. Zero by definition where mass is not conserved.
    pub mass_error: f64,
    /// Largest error of an internal step's energy balance, over the power that goes through.
    pub energy_error: f64,
}

impl Diagnostics {
    /// Adds an internal step.
    pub(super) fn add(&mut self, step: Self, duration: f64) {
        let before = *self;
        *self = step;
        self.mean_journal_torque = before.mean_journal_torque + step.journal_torque * duration;
        self.mean_heat = before.mean_heat + step.heat * duration;
        self.mean_outflow = before.mean_outflow + step.outflow * duration;
        self.steps = before.steps + 1;
        self.mass_error = before.mass_error.max(step.mass_error);
        self.energy_error = before.energy_error.max(step.energy_error);
    }

    /// Turns the sums over the steps into means.
    pub(super) fn over(mut self, interval: f64) -> Self {
        if interval > 0.0 {
            self.mean_journal_torque /= interval;
            self.mean_heat /= interval;
            self.mean_outflow /= interval;
        }
        self
    }
}

/// Sums over the cells and edges, dimensionless.
#[derive(Default)]
struct Sums {
    load: Vector2<f64>,
    /// Integral of content over viscous gap: the shear of the sliding surfaces.
    shear: f64,
    /// Integral of the gap times the pressure's rise around the bush.
    rise: f64,
    /// The same of the gap that the roughness carries, by the sliding.
    rough: f64,
    /// Moment of the pressure on the surfaces' form errors, by turning journal and bush.
    form: [f64; 2],
    /// Dissipation of the pressure flow, and of oil that fills an emptier gap.
    loss: f64,
    /// What the bath's pressure spends on oil coming in, less what it takes up.
    bath: f64,
    /// What the oil's compression stores.
    stored: f64,
    max_pressure: f64,
}

/// Evaluates the end of a step whose last implicit stage was `stage`.
pub(super) fn diagnose(film: &ReynoldsFilm, stage: &Stage<'_>, drive: &Drive) -> Diagnostics {
    let settings = &film.settings;
    let radius = 0.5 * settings.diameter;
    let psi = settings.clearance / radius;
    let scale = settings.force_scale(drive.viscosity);
    let moment = scale * settings.clearance;
    let sums = sum(film, stage, drive);
    let sliding = drive.journal_speed - drive.bush_speed;
    let viscous = drive.viscosity * sliding * radius.powi(3) * settings.width / settings.clearance;
    let shear = viscous * sums.shear;
    // Of the pressure's moment on the moving gap each surface takes half; on their roughness, both take it alike.
    let journal_torque = shear + moment * (0.5 * (sums.rise + sums.rough) - sums.form[0]);
    let bush_torque = shear - moment * (0.5 * (sums.rise - sums.rough) - sums.form[1]);
    let velocity = film.state.velocity;
    let heat = shear * sliding + moment * sums.loss;
    let stored = moment * sums.stored;
    let works = [
        journal_torque * drive.journal_speed,
        -bush_torque * drive.bush_speed,
        moment * sums.load.dot(&velocity),
        moment * sums.bath,
    ];
    // A film that next to nothing moves is judged by what moving it a millionth of the clearance takes, and a billionth
    // of what the bath could spend on flowing through it.
    let bath = film.balance.open.iter().sum::<f64>() * stage.side.powi(2);
    let still = moment * ((1e-6 / stage.duration).powi(2) + 1e-9 * bath);
    let through = works.iter().map(|work| work.abs()).sum::<f64>() + heat.abs() + still;
    let flow = film.balance.end_flow();
    let volume = settings.clearance * radius * settings.width;
    let asperities = settings.asperities.as_ref();
    Diagnostics {
        film_load: sums.load * scale,
        velocity,
        journal_torque,
        bush_torque,
        max_pressure: (sums.max_pressure - stage.side) * 12.0 * drive.viscosity / (psi * psi),
        smallest_gap: film.smallest_gap(),
        contact_normal: asperities
            .map_or(0.0, |touch| touch.normal(&film.cells, &film.gap, settings)),
        outflow: flow.out * volume,
        inflow: flow.into * volume,
        heat,
        energy_error: (works.iter().sum::<f64>() - heat - stored).abs() / through,
        ..Diagnostics::default()
    }
}

/// Sums what the cells and edges contribute.
fn sum(film: &ReynoldsFilm, stage: &Stage<'_>, drive: &Drive) -> Sums {
    let (cells, gap, balance) = (&film.cells, &film.gap, &film.balance);
    let field = &film.state.field;
    let mut sums = Sums {
        load: load(cells, gap, &field.pressure).force,
        max_pressure: largest(&field.pressure),
        ..Sums::default()
    };
    for (i, range) in cells.columns() {
        let opening = opening(film, i);
        let squeeze = squeeze(film, drive, i);
        let pressed = dot(&gap.pressed[range.clone()], &field.pressure[range.clone()]);
        sums.form[0] += opening[0] * pressed;
        sums.form[1] += opening[1] * pressed;
        // Between rough surfaces, the gap does not close in step with the journal.
        if cells.conserves_mass() || film.form.roughness > 0.0 {
            sums.loss += filling_loss(film, stage, i, squeeze);
        }
    }
    sums.shear = if film.settings.flow_factors().is_some() {
        rough_shear(film, drive.rotation())
    } else {
        shear(film, drive.rotation())
    };
    for (own, before) in cells.neighbours() {
        let p = [&field.pressure[before], &field.pressure[own.clone()]];
        sums.loss += lost(&balance.along[own.clone()], p);
        let share = &cells.share[own.clone()];
        sums.rise += rise(share, &gap.edge[own.clone()], p);
        if let Some(journal_share) = film.settings.flow_factors() {
            let excess = film.form.roughness * (2.0 * journal_share - 1.0);
            let ratio = &gap.edge_ratio[own];
            let rough = |k: usize| share[k] * shear_flow_factor(ratio[k]) * (p[1][k] - p[0][k]);
            sums.rough += excess * sum_of(share.len(), rough);
        }
    }
    let n = field.pressure.len();
    let p = &field.pressure;
    sums.loss += lost(&balance.across[1..n], [&p[..n - 1], &p[1..]]);
    let open: f64 = balance
        .open
        .iter()
        .zip(p)
        .map(|(open, p)| open * (p - stage.side))
        .sum();
    let pressed: f64 = balance
        .open
        .iter()
        .zip(p)
        .map(|(open, p)| open * (p - stage.side) * p)
        .sum();
    sums.loss += pressed - open * stage.side;
    sums.bath = -open * stage.side;
    if film.settings.is_compressible() {
        let powers = compression::powers(film, stage, |column| squeeze(film, drive, column));
        (sums.loss, sums.stored, sums.bath) = (powers.loss, powers.stored, powers.bath);
    }
    sums
}

/// How fast turning the journal, or the bush, by an angle opens the gap in a column.
fn opening(film: &ReynoldsFilm, column: usize) -> [f64; 2] {
    (film.settings.profile)
        .opening_rates(film.cells.grid.theta_centre(column), film.state.angles)
        .map(|rate| rate / film.settings.clearance)
}

/// How fast the surfaces approach in a column.
fn squeeze(film: &ReynoldsFilm, drive: &Drive, column: usize) -> f64 {
    let opening = opening(film, column);
    let turning = opening[0] * drive.journal_speed + opening[1] * drive.bush_speed;
    film.state.velocity.dot(&film.cells.directions.mean[column]) - turning
}

/// Integral of content over viscous gap, where the surfaces do not touch.
fn shear(film: &ReynoldsFilm, rotation: f64) -> f64 {
    let resolved = film.resolved_gap();
    sheared(film, rotation, |edges| {
        let (h, apart) = (&film.gap.edge[edges.clone()], &film.gap.edge_apart[edges]);
        move |k, fluidity| {
            let h = if h[k] > resolved { h[k] } else { resolved };
            apart[k] / (h * fluidity)
        }
    })
}

/// The same between rough surfaces, by their stress factors.
fn rough_shear(film: &ReynoldsFilm, rotation: f64) -> f64 {
    let roughness = film.form.roughness;
    sheared(film, rotation, |edges| {
        let ratio = &film.gap.edge_ratio[edges];
        move |k, fluidity| sliding_resistance(ratio[k]) / (roughness * fluidity)
    })
}

/// Integral of content times a `resistance` at the edges between columns, which is given the fluidity there.
///
/// By the trapezoidal rule over the edges: around the ring it is as good as exact where the film is full, and a cell's
/// content is that which the rotation carries over its downstream edge. In the cells' middles the gap behind the narrowest
/// place would be wider by tens of per cent than the one that the content belongs to.
fn sheared<R: Fn(usize, f64) -> f64>(
    film: &ReynoldsFilm,
    rotation: f64,
    resistance: impl Fn(Range<usize>) -> R,
) -> f64 {
    let (area, fluidity) = (&film.cells.area, &film.liquid.fluidity);
    let content = &film.state.field.content;
    // The share of the content before an edge; the rest is that behind it.
    let before_counts = if rotation == 0.0 {
        0.5
    } else {
        f64::from(rotation > 0.0)
    };
    let shares = [before_counts, 1.0 - before_counts];
    let mut sum = 0.0;
    for (own, before) in film.cells.neighbours() {
        let n = own.len();
        let area = [&area[before.clone()][..n], &area[own.clone()][..n]];
        let fluidity = [&fluidity[before.clone()][..n], &fluidity[own.clone()][..n]];
        let content = [&content[before][..n], &content[own.clone()][..n]];
        let resistance = resistance(own);
        sum += sum_of(n, |k| {
            let carried = shares[0] * content[0][k] + shares[1] * content[1][k];
            let area = 0.5 * (area[0][k] + area[1][k]);
            let fluidity = 0.5 * (fluidity[0][k] + fluidity[1][k]);
            area * carried * resistance(k, fluidity)
        });
    }
    sum
}

/// Dissipation of the pressure flow through edges.
fn lost(conductance: &[f64], p: [&[f64]; 2]) -> f64 {
    let n = conductance.len();
    let p = p.map(|p| &p[..n]);
    sum_of(n, |k| conductance[k] * (p[0][k] - p[1][k]).powi(2))
}

/// Integral of the gap times the pressure's rise.
fn rise(share: &[f64], h: &[f64], p: [&[f64]; 2]) -> f64 {
    let n = share.len();
    let (h, p) = (&h[..n], p.map(|p| &p[..n]));
    sum_of(n, |k| share[k] * h[k] * (p[1][k] - p[0][k]))
}

/// Work lost in a column: oil that comes into a full cell from a less full one, or fills it up, arrives without the
/// pressure. `squeeze` is how fast the surfaces approach.
fn filling_loss(film: &ReynoldsFilm, stage: &Stage<'_>, column: usize, squeeze: f64) -> f64 {
    let (cells, gap, carried) = (&film.cells, &film.gap, &film.balance.carried);
    let field = &film.state.field;
    let w = cells.stride;
    let (own, left) = (column * w, cells.before(column) * w);
    let right = cells.after(column) * w;
    let mut loss = 0.0;
    for k in 0..w {
        let cell = own + k;
        let p = field.pressure[cell];
        if p == 0.0 {
            continue;
        }
        let lack = [left, right].map(|side| 1.0 - field.content[side + k]);
        let swept = carried[cell].max(0.0) * lack[0] - carried[right + k].min(0.0) * lack[1];
        let filled = (gap.cell[cell] - stage.mass[cell]) / stage.duration;
        loss += p * (swept + cells.area[cell] * (filled + squeeze * gap.cell_apart[cell]));
    }
    loss
}

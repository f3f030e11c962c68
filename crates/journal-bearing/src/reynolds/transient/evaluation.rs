//! Evaluation of the film at the end of a step: forces, torques, flows and the energy balance.

use std::ops::Range;

use nalgebra::Vector2;

use super::{
    asperities,
    compression::{self, Powers},
    diagnostics::Diagnostics,
    geometry::Geometry,
    stage::FilmStage,
    workspace::Workspace,
};
use crate::{
    reynolds::{
        lanes::{dot, largest, sum_of},
        settings::Drive,
    },
    roughness::shear_flow_factor,
};

/// Sums over cells and edges, dimensionless.
#[derive(Default)]
struct FilmSums {
    load: Vector2<f64>,
    /// Integral of content over viscous gap: the shear of the sliding surfaces.
    shear: f64,
    /// Integral of the gap times the pressure's rise around the bush.
    rise: f64,
    /// The same for the gap that moves with the rough surfaces' sliding (shear flow).
    rough: f64,
    /// Moment of the pressure on the form errors of journal and bush.
    form: [f64; 2],
    /// What the oil dissipates by its pressure flow and where it fills an emptier gap, what it stores, and the power of the
    /// pressures of bath and feeds on the oil that enters, less that on the oil that leaves.
    powers: Powers,
    max_pressure: f64,
}

/// Evaluates a step whose last implicit stage was `stage`.
pub fn diagnose(work: &Workspace, stage: &FilmStage, drive: &Drive) -> Diagnostics {
    let settings = &work.geometry.settings;
    let radius = 0.5 * settings.diameter;
    let psi = settings.clearance / radius;
    let scale = settings.force_scale(drive.viscosity);
    let moment = scale * settings.clearance;
    let sums = sum(work, stage, drive);
    let sliding = drive.journal_speed - drive.bush_speed;
    let viscous = drive.viscosity * sliding * radius.powi(3) * settings.width / settings.clearance;
    let shear = viscous * sums.shear;
    // Each surface takes half of the pressure's moment on the gap. The moment on the roughness acts on both alike.
    let journal_torque = shear + moment * (0.5 * (sums.rise + sums.rough) - sums.form[0]);
    let bush_torque = shear - moment * (0.5 * (sums.rise - sums.rough) - sums.form[1]);
    let velocity = work.state.velocity;
    let heat = shear * sliding + moment * sums.powers.loss;
    let stored = moment * sums.powers.stored;
    let works = [
        journal_torque * drive.journal_speed,
        -bush_torque * drive.bush_speed,
        moment * sums.load.dot(&velocity),
        moment * sums.powers.bath,
    ];
    // The energy error of a film at rest would be rounding over rounding. Its scale is therefore at least the power that
    // moves it by a millionth of the clearance, and a billionth of what the bath could spend on flow through the film.
    let through_flow = work.balance.open.iter().sum::<f64>() * stage.side.powi(2);
    let still = moment * ((1e-6 / stage.duration).powi(2) + 1e-9 * through_flow);
    let through = works.iter().map(|work| work.abs()).sum::<f64>() + heat.abs() + still;
    let flow = work.balance.end_flow();
    let volume = settings.clearance * radius * settings.width;
    let asperities = settings.asperities.as_ref();
    Diagnostics {
        film_load: sums.load * scale,
        velocity,
        journal_torque,
        bush_torque,
        max_pressure: (sums.max_pressure - stage.side) * 12.0 * drive.viscosity / (psi * psi),
        smallest_gap: work.geometry.smallest_gap(work.state.eps),
        crossing: work.geometry.crossing(work.state.eps),
        contact_normal: asperities.map_or(0.0, |surface| asperities::normal(surface, &work.geometry)),
        outflow: flow.out * volume,
        inflow: flow.into * volume,
        feed_flow: flow.fed * volume,
        heat,
        energy_error: (works.iter().sum::<f64>() - heat - stored).abs() / through,
        ..Diagnostics::default()
    }
}

/// Sums the contributions of cells and edges.
fn sum(work: &Workspace, stage: &FilmStage, drive: &Drive) -> FilmSums {
    let (cells, gap) = (&work.geometry.cells, &work.geometry.gap);
    let (settings, field) = (&work.geometry.settings, &work.state.field);
    let roughness = work.geometry.form.roughness;
    let mut sums = FilmSums {
        load: work.pressure_load().force,
        shear: shear(work, drive.rotation()),
        powers: powers(work, stage, drive),
        max_pressure: largest(&field.pressure),
        ..FilmSums::default()
    };
    for (i, range) in cells.columns() {
        let opening = opening(work, i);
        let pressed = dot(&gap.pressed[range.clone()], &field.pressure[range.clone()]);
        sums.form[0] += opening[0] * pressed;
        sums.form[1] += opening[1] * pressed;
    }
    for (behind, before) in cells.neighbours() {
        let p = [&field.pressure[before], &field.pressure[behind.clone()]];
        let (share, h) = (&cells.share[behind.clone()], &gap.edge[behind.clone()]);
        sums.rise += sum_of([share, h, p[0], p[1]], |[share, h, before, behind]| share * h * (behind - before));
        if let Some(journal_share) = settings.flow_factors() {
            let excess = roughness * (2.0 * journal_share - 1.0);
            let of = [share, &gap.edge_ratio[behind], p[0], p[1]];
            let rough =
                sum_of(of, |[share, ratio, before, behind]| share * shear_flow_factor(ratio) * (behind - before));
            sums.rough += excess * rough;
        }
    }
    sums
}

/// The powers of the oil, with those of the feeds.
fn powers(work: &Workspace, stage: &FilmStage, drive: &Drive) -> Powers {
    let squeeze = |column| squeeze(work, drive, column);
    let mut powers = if work.geometry.settings.is_compressible() {
        compression::powers(work, stage, squeeze)
    } else {
        of_constant_density(work, stage, squeeze)
    };
    let [loss, spent] = fed(work, stage);
    powers.loss += loss;
    powers.bath += spent;
    powers
}

/// The powers of oil that cannot be compressed. `squeeze` computes how fast the surfaces approach in a column.
fn of_constant_density(work: &Workspace, stage: &FilmStage, squeeze: impl Fn(usize) -> f64) -> Powers {
    let (cells, balance, p) = (&work.geometry.cells, &work.balance, &work.state.field.pressure);
    let mut loss = 0.0;
    // The mean gap of rough surfaces does not close in step with the journal, so it needs this term too.
    if cells.conserves_mass() || work.geometry.gap.rough {
        for (i, _) in cells.columns() {
            loss += filling_loss(work, stage, i, squeeze(i));
        }
    }
    for (behind, before) in cells.neighbours() {
        loss += lost(&balance.along[behind.clone()], [&p[before], &p[behind]]);
    }
    let n = p.len();
    loss += lost(&balance.across[1..n], [&p[..n - 1], &p[1..]]);
    let out = |(open, p): (&f64, &f64)| open * (p - stage.side);
    let open: f64 = balance.open.iter().zip(p).map(out).sum();
    let pressed: f64 = (balance.open.iter().zip(p)).map(|of| out(of) * of.1).sum();
    loss += pressed - open * stage.side;
    Powers { loss, bath: -open * stage.side, ..Powers::default() }
}

/// Power lost on the way from a feed's supply into its cells, and power that its pressure spends.
fn fed(work: &Workspace, stage: &FilmStage) -> [f64; 2] {
    let cells = work.geometry.cells.feed.iter();
    let of = cells.zip(&work.state.field.pressure).zip(&work.liquid.density);
    of.fold([0.0; 2], |[loss, spent], ((conductance, p), density)| {
        let flow = conductance * (p - stage.feed) / density;
        [loss + flow * (p - stage.feed), spent - flow * stage.feed]
    })
}

/// How fast turning the journal, and the bush, by an angle opens the gap in a column.
fn opening(work: &Workspace, column: usize) -> [f64; 2] {
    let settings = &work.geometry.settings;
    (settings.profile)
        .opening_rates(work.geometry.cells.grid.theta_centre(column), work.state.angles)
        .map(|rate| rate / settings.clearance)
}

/// How fast the surfaces approach in a column.
fn squeeze(work: &Workspace, drive: &Drive, column: usize) -> f64 {
    let opening = opening(work, column);
    let turning = opening[0] * drive.journal_speed + opening[1] * drive.bush_speed;
    let direction = &work.geometry.cells.directions.mean[column];
    work.state.velocity.dot(direction) - turning
}

/// Integral of content over viscous gap: the film's resistance to sliding.
fn shear(work: &Workspace, rotation: f64) -> f64 {
    let Geometry { cells, form, gap, .. } = &work.geometry;
    let resolved = cells.resolved_gap();
    let neighbours = cells.neighbours().into_iter();
    if !gap.rough {
        return sheared(work, rotation, neighbours, |_| {
            |[h, _]: [f64; 2], fluidity| {
                let h = if h > resolved { h } else { resolved };
                1.0 / (h * fluidity)
            }
        });
    }
    let resistance = |ratio: f64| {
        let resistance = form.rough_film.resistance(ratio) / form.roughness;
        resistance.min(1.0 / resolved)
    };
    if form.tilt != Vector2::zeros() {
        return sheared(work, rotation, neighbours, |_| |[_, ratio]: [f64; 2], fluidity| resistance(ratio) / fluidity);
    }
    // The gap is the same over the width.
    let columns = cells.columns().map(|(i, behind)| {
        let before = cells.before(i) * cells.stride;
        (behind, before..before + cells.stride)
    });
    sheared(work, rotation, columns, |edge| {
        let resistance = resistance(gap.edge_ratio[edge]);
        move |_: [f64; 2], fluidity| resistance / fluidity
    })
}

/// Integral of content over viscous gap: content times a resistance at the edges between neighbouring cells, which stand in ranges
/// of cells and of those before them. `resistance_at` gives its law for the edges of such a range from its first on, over gap, film
/// ratio, and fluidity.
///
/// It uses the trapezoidal rule over the edges, which around the ring is nearly exact where the film is full. The content
/// of a cell is that of the oil that the rotation carries over the cell's downstream edge, so it is paired with the gap
/// there. The gap in the middle of the cell would be tens of per cent too wide behind the narrowest place.
fn sheared<'a, Law: Fn([f64; 2], f64) -> f64>(
    work: &'a Workspace,
    rotation: f64,
    neighbours: impl Iterator<Item = (Range<usize>, Range<usize>)>,
    resistance_at: impl Fn(usize) -> Law,
) -> f64 {
    let (area, fluidity) = (&work.geometry.cells.land, &work.liquid.fluidity);
    let content = &work.state.field.content;
    // Weights of the content before an edge and of that behind it.
    let before_counts = if rotation == 0.0 { 0.5 } else { f64::from(rotation > 0.0) };
    let shares = [before_counts, 1.0 - before_counts];
    let mut sum = 0.0;
    for (behind, before) in neighbours {
        let of_both = |of: &'a [f64]| [&of[before.clone()], &of[behind.clone()]];
        let ([area, area_own], [fluidity, fluidity_own]) = (of_both(area), of_both(fluidity));
        let ([content, content_own], gap) = (of_both(content), &work.geometry.gap);
        let [h, ratio] = [&gap.edge, &gap.edge_ratio].map(|of| &of[behind.clone()]);
        let of = [area, area_own, fluidity, fluidity_own, content, content_own, h, ratio];
        let resistance = resistance_at(behind.start);
        sum += sum_of(of, |[a, a_own, f, f_own, c, c_own, h, ratio]| {
            let carried = shares[0] * c + shares[1] * c_own;
            0.5 * (a + a_own) * carried * resistance([h, ratio], 0.5 * (f + f_own))
        });
    }
    sum
}

/// Dissipation by the pressure flow through edges.
fn lost(conductance: &[f64], p: [&[f64]; 2]) -> f64 {
    sum_of([conductance, p[0], p[1]], |[conductance, before, behind]| conductance * (before - behind).powi(2))
}

/// Power lost in a column by oil that enters a full cell from a less full one, or fills it up: it arrives without the
/// cell's pressure. `squeeze` is how fast the surfaces approach.
fn filling_loss(work: &Workspace, stage: &FilmStage, column: usize, squeeze: f64) -> f64 {
    let (cells, gap, field) = (&work.geometry.cells, &work.geometry.gap, &work.state.field);
    let carried = &work.balance.carried;
    let w = cells.stride;
    let (first, left) = (column * w, cells.before(column) * w);
    let right = cells.after(column) * w;
    let mut loss = 0.0;
    for k in 0..w {
        let cell = first + k;
        let p = field.pressure[cell];
        // Cells that are not full have no pressure, and nothing is lost in them.
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

//! The bearing's geometry at a position of the journal.

use std::f64::consts::TAU;

use nalgebra::{Matrix2, Vector2};

use super::{
    cells::Cells,
    gap::{Form, Gap},
    state::Field,
};
use crate::{
    reynolds::{
        error::{FilmError, within},
        grid::Grid,
        lanes::{dot, smallest},
        settings::{Drive, FilmSettings},
    },
    roughness::{mean_gap, parting},
};

/// Least film ratio at which a journal may start: the mean planes of rough surfaces may cross by three roughnesses.
const DEEPEST: f64 = -3.0;

/// Smooth surfaces that come closer than this share of the clearance touch.
const TOUCHING: f64 = 1e-3;

/// Settings, cells and the gap at one position of the journal.
#[derive(Clone, Debug)]
pub struct Geometry {
    pub settings: FilmSettings,
    pub cells: Cells,
    pub form: Form,
    /// The present gap.
    pub gap: Gap,
}

impl Geometry {
    /// The geometry of a bearing, with the journal in the middle.
    pub fn new(settings: FilmSettings) -> Result<Self, FilmError> {
        settings.check()?;
        let width_to_diameter = settings.width / settings.diameter;
        let [columns, rows] = settings.cells;
        let half = Grid::standard(columns, rows, width_to_diameter);
        let tilted = settings.tilt != [0.0; 2];
        let grid = if tilted { half.whole_width() } else { half };
        let mut cells = Cells::new(grid, width_to_diameter, settings.cavitation);
        if let Some(feed) = &settings.feed {
            let dug = cells.dig(feed, settings.width);
            within(
                "feed extent",
                feed.extent,
                dug > 0,
                "wide and long enough for the middle of a cell; take more columns and rows, or a larger feed",
            )?;
        }
        let form = Form::default();
        let gap = Gap::new(&cells);
        let mut geometry = Self { settings, cells, form, gap };
        geometry.scale();
        Ok(geometry)
    }

    /// Gives the bearing another radial clearance, m. Form error and gap are as before until they are computed anew.
    pub fn set_clearance(&mut self, clearance: f64) {
        self.settings.clearance = clearance;
        self.scale();
    }

    /// Relates tilt and roughness to the clearance.
    fn scale(&mut self) {
        let settings = &self.settings;
        self.form.tilt = Vector2::from(settings.tilt) / settings.clearance;
        self.form.roughness = settings.film_roughness();
        self.form.rough_film = settings.rough_film;
    }

    /// Computes the form error with journal and bush turned by `angles`.
    pub fn shape(&mut self, angles: [f64; 2]) {
        let profile = &self.settings.profile;
        if profile.is_round() {
            return;
        }
        let grid = &self.cells.grid;
        let at = |theta: f64| profile.opening(theta, angles) / self.settings.clearance;
        self.form.middle.clear();
        self.form.edge.clear();
        for i in 0..grid.columns() {
            self.form.middle.push(at(grid.theta_centre(i)));
            self.form.edge.push(at(grid.theta_edge(i)));
        }
    }

    /// Computes the gap at an eccentricity ratio.
    pub fn move_to(&mut self, eps: Vector2<f64>) {
        self.gap.update(&self.cells, &self.form, eps);
    }

    /// Whether the surfaces leave each other room. The asperities of rough ones may touch, and a round, aligned journal among them
    /// finds its place by itself.
    pub fn is_open(&self) -> bool {
        if self.gap.rough {
            self.form.is_plain() || smallest(&self.gap.ratio).min(smallest(&self.gap.edge_ratio)) > DEEPEST
        } else {
            self.gap.smallest > 0.0
        }
    }

    /// The largest share of the change `change` of the eccentricity ratio from `eps` that leaves at least the share `rest` of
    /// the present gap everywhere. Rough surfaces may come closer by half their roughness in any case.
    pub fn allowed(&self, eps: Vector2<f64>, change: Vector2<f64>, rest: f64) -> f64 {
        let gap = &self.gap;
        let valleys = if gap.rough { 0.5 * self.form.roughness } else { 0.0 };
        let mut share: f64 = 1.0;
        if change.norm() > ((1.0 - rest) * gap.smallest).max(valleys) {
            let directions = &self.cells.directions;
            for (i, range) in self.cells.columns() {
                let closing = change.dot(&directions.mean[i]);
                let closing_before = change.dot(&directions.edge[i]);
                for at in range {
                    let room = ((1.0 - rest) * gap.cell[at]).max(valleys);
                    let room_before = ((1.0 - rest) * gap.edge[at]).max(valleys);
                    if closing * share > room {
                        share = room / closing;
                    }
                    if closing_before * share > room_before {
                        share = room_before / closing_before;
                    }
                }
            }
        }
        let nearest = 1.0 - eps.norm();
        let limit =
            if gap.rough { 1.0 - nearest + ((1.0 - rest) * gap.smallest).max(valleys) } else { 1.0 - rest * nearest };
        while self.form.is_plain() && share > 1e-12 && (eps + change * share).norm() > limit {
            share *= 0.5;
        }
        share
    }

    /// The smallest distance of the mean planes anywhere at the eccentricity ratio `eps`, in clearances, also between the cells'
    /// middles and at the ends of a tilted journal.
    fn smallest_distance(&self, eps: Vector2<f64>) -> f64 {
        let (form, directions) = (&self.form, &self.cells.directions);
        let ends = [eps + form.tilt, eps - form.tilt];
        if form.middle.is_empty() {
            1.0 - ends.map(|end| end.norm()).into_iter().fold(0.0, f64::max)
        } else {
            let places = |directions: &[Vector2<f64>], deviations: &[f64]| {
                (directions.iter().zip(deviations))
                    .flat_map(|(n, deviation)| ends.map(|end| 1.0 - end.dot(n) + deviation))
                    .fold(f64::INFINITY, f64::min)
            };
            places(&directions.mean, &form.middle).min(places(&directions.edge, &form.edge))
        }
    }

    /// The smallest gap anywhere at the eccentricity ratio `eps`, m; between rough surfaces the smallest mean gap, and zero where
    /// smooth ones touch.
    pub fn smallest_gap(&self, eps: Vector2<f64>) -> f64 {
        let (form, distance) = (&self.form, self.smallest_distance(eps));
        let narrowest =
            if form.feels(distance) { mean_gap(distance / form.roughness) * form.roughness } else { distance.max(0.0) };
        narrowest * self.settings.clearance
    }

    /// How far, in roughnesses, the mean planes of rough surfaces cross anywhere.
    pub fn crossing(&self, eps: Vector2<f64>) -> f64 {
        if self.form.roughness > 0.0 { (-self.smallest_distance(eps) / self.form.roughness).max(0.0) } else { 0.0 }
    }

    /// Whether smooth surfaces touch by tilt or form error.
    pub fn touches(&self, eps: Vector2<f64>) -> bool {
        let smooth = self.form.roughness == 0.0 && !self.form.is_plain();
        smooth && self.smallest_gap(eps) <= TOUCHING * self.settings.clearance
    }

    /// A duration no longer than a turning form error takes for two columns.
    pub fn resolve_turning(&self, duration: f64, drive: &Drive) -> f64 {
        if self.settings.profile.is_round() {
            return duration;
        }
        let speed = drive.journal_speed.abs().max(drive.bush_speed.abs());
        let turn = 2.0 * TAU / self.cells.grid.columns() as f64;
        if speed * duration > turn { turn / speed } else { duration }
    }

    /// The load lost per eccentricity ratio because asperities of a closing gap take area from the film.
    pub fn lost_area(&self, field: &Field) -> Matrix2<f64> {
        let (pressure, roughness) = (&field.pressure, self.form.roughness);
        let mut lost = Matrix2::zeros();
        for (i, range) in self.cells.columns() {
            let n = self.cells.directions.mean[i];
            // The gap is the same over the width of an aligned bearing.
            let sum: f64 = if self.form.tilt == Vector2::zeros() {
                let parting = parting(self.gap.film_ratio(range.start)) / roughness;
                parting * dot(&pressure[range.clone()], &self.cells.area[range])
            } else {
                let of = |c: usize| pressure[c] * self.cells.area[c];
                range.map(|c| of(c) * parting(self.gap.film_ratio(c)) / roughness).sum()
            };
            lost += n * n.transpose() * sum;
        }
        lost
    }
}

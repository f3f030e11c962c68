//! The bearing's geometry at a position of the journal.

use nalgebra::{Matrix2, Vector2};

use super::cells::Cells;
use super::gap::{Form, Gap};
use super::state::Field;
use crate::reynolds::grid::Grid;
use crate::reynolds::settings::{Drive, FilmError, FilmSettings};

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
        let cells = Cells::new(grid, width_to_diameter, settings.cavitation);
        let form = Form::default();
        let gap = Gap::new(&cells);
        let mut geometry = Self {
            settings,
            cells,
            form,
            gap,
        };
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

    /// Whether the surfaces leave each other room.
    pub fn is_open(&self) -> bool {
        self.gap.is_open(&self.form)
    }

    /// The share of the change `change` from `eps` that leaves at least the share `rest` of the present gap everywhere.
    pub fn allowed(&self, eps: Vector2<f64>, change: Vector2<f64>, rest: f64) -> f64 {
        let mut share = self.gap.allowed(&self.cells, &self.form, change, rest);
        let limit = 1.0 - rest * (1.0 - eps.norm());
        while self.form.is_plain() && share > 1e-12 && (eps + change * share).norm() > limit {
            share *= 0.5;
        }
        share
    }

    /// The smallest gap at the eccentricity ratio `eps`, m; between rough surfaces the smallest mean gap.
    pub fn smallest_gap(&self, eps: Vector2<f64>) -> f64 {
        let narrowest = self.gap.narrowest(&self.cells, &self.form, eps);
        narrowest * self.settings.clearance
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
        let turn = 2.0 * std::f64::consts::TAU / self.cells.grid.columns() as f64;
        if speed * duration > turn {
            turn / speed
        } else {
            duration
        }
    }

    /// The load lost per eccentricity ratio because asperities of a closing gap take area from the film.
    pub fn lost_area(&self, field: &Field) -> Matrix2<f64> {
        let pressure = &field.pressure;
        let mut lost = Matrix2::zeros();
        for (i, range) in self.cells.columns() {
            let n = self.cells.directions.mean[i];
            let sum: f64 = range
                .filter(|&c| pressure[c] != 0.0)
                .map(|c| pressure[c] * self.cells.area[c] * self.gap.parting(&self.form, c))
                .sum();
            lost += n * n.transpose() * sum;
        }
        lost
    }
}

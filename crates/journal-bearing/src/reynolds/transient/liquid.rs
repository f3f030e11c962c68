//! The oil's viscosity and density in each cell.

use super::{gap::Gap, state::Field, warmth::Warm};
use crate::{
    reynolds::settings::{Drive, FilmSettings},
    rheology::PressureLaw,
};

/// Viscosity and density cell by cell, relative to those at ambient pressure and low shear.
#[derive(Clone, Debug)]
pub struct Liquid {
    /// Reciprocal viscosity.
    pub fluidity: Vec<f64>,
    /// Density.
    pub density: Vec<f64>,
    /// Slope of the density over the dimensionless pressure, s.
    pub swelling: Vec<f64>,
    /// Mass flow per pressure gradient at `H = 1`: density times fluidity.
    pub ease: Vec<f64>,
    /// Slope of `ease` over the dimensionless pressure, s.
    pub easing: Vec<f64>,
    /// Whether `ease` is one everywhere.
    pub uniform: bool,
    /// Whether the density depends on the pressure.
    pub compressible: bool,
    /// Whether `ease` depends on the pressure.
    pub thickens: bool,
}

impl Liquid {
    /// Oil at ambient pressure.
    pub fn new(cells: usize) -> Self {
        let ones = || vec![1.0; cells];
        Self {
            fluidity: ones(),
            density: ones(),
            swelling: vec![0.0; cells],
            ease: ones(),
            easing: vec![0.0; cells],
            uniform: true,
            compressible: false,
            thickens: false,
        }
    }

    /// Computes the properties for the present field, with columns of `stride` cells as `warm` as they are. True when they have
    /// converged.
    pub fn update(
        &mut self,
        settings: &FilmSettings,
        gap: &Gap,
        field: &Field,
        (warm, stride): (&[Warm], usize),
        drive: &Drive,
    ) -> bool {
        let to_pascal = settings.pressure_scale(drive.viscosity);
        self.compress(settings, field, to_pascal);
        let even = warm.is_empty() && !settings.is_compressible();
        if settings.rheology.is_newtonian() && even {
            return true;
        }
        self.uniform = false;
        self.thickens = settings.is_compressible() || settings.rheology.pressure_law != PressureLaw::Constant;
        let psi = settings.clearance / (0.5 * settings.diameter);
        let sliding = (drive.journal_speed - drive.bush_speed).abs() / psi;
        let mut largest: f64 = 0.0;
        for (cell, fluidity) in self.fluidity.iter_mut().enumerate() {
            let pressure = field.pressure[cell] * to_pascal;
            let rate = sliding / gap.cell[cell];
            let thin = warm.get(cell / stride).map_or(1.0, |warm| warm.fluidity);
            let viscosity = drive.viscosity / thin;
            let now = thin / settings.rheology.ratio(viscosity, pressure, rate);
            largest = largest.max((now / *fluidity - 1.0).abs());
            *fluidity = now;
            let ease = now * self.density[cell];
            self.ease[cell] = ease;
            if self.thickens {
                let thickening = settings.rheology.thickening(viscosity, pressure);
                let swelling = self.swelling[cell] / self.density[cell];
                self.easing[cell] = ease * (swelling - thickening * to_pascal);
            }
        }
        largest < 1e-9
    }

    /// Computes the density, with `to_pascal` the pressure per unit of the field, Pa.s.
    pub fn compress(&mut self, settings: &FilmSettings, field: &Field, to_pascal: f64) {
        if !settings.is_compressible() {
            return;
        }
        self.compressible = true;
        let of = self.density.iter_mut().zip(&mut self.swelling);
        for ((density, swelling), pressure) in of.zip(&field.pressure) {
            let [ratio, slope] = settings.rheology.density_law.ratio(pressure * to_pascal);
            (*density, *swelling) = (ratio, slope * to_pascal);
        }
    }
}

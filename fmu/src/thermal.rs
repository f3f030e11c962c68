//! Heat transfer between film, bush with housing, shaft, oil bath and surroundings: lumped heat capacities connected by
//! conductances, as in the paper's Fig. 3.
//!
//! The paper gives none of its thermal constants. The conductances to oil and surroundings are calibrated
//! (`studies/calibration-rig.toml`) so that the measured friction power holds the measured temperatures of Table 2 in
//! steady state. `docs/evidence/calibration.md` tells which constants this determines.

use serde::{Deserialize, Serialize};

/// The temperatures at the start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Initialization {
    /// Those that are given.
    #[default]
    Given,
    /// Those at which heat in equals heat out, as they are reached from the given ones.
    SteadyState,
}

/// The thermal network's parameters.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Thermal {
    /// Heat capacity of the film and of the surface layers that follow its temperature within a turn, J/K.
    pub film_capacity: f64,
    /// Heat capacity of bush and housing, J/K.
    pub bush_capacity: f64,
    /// Heat capacity of the shaft, J/K.
    pub shaft_capacity: f64,
    /// Volume of the oil bath, m³.
    pub oil_volume: f64,
    /// Conductance from film to bush at the reference clearance, W/K.
    pub film_bush: f64,
    /// Conductance from film to shaft at the reference clearance, W/K.
    pub film_shaft: f64,
    /// Radial clearance at which the film's two conductances hold, m. At another clearance they are scaled by its
    /// reciprocal, as heat is conducted across the film (Fourier's law, `G = k*A/c`). At zero they are not scaled.
    pub reference_clearance: f64,
    /// Conductance from bush and housing to the oil bath, W/K.
    pub bush_oil: f64,
    /// Conductance from shaft to the oil bath, W/K.
    pub shaft_oil: f64,
    /// Conductance from bush and housing to the surroundings, W/K.
    pub bush_ambient: f64,
    /// Conductance from shaft to the surroundings, W/K.
    pub shaft_ambient: f64,
    /// Conductance from oil bath to the surroundings, W/K.
    pub oil_ambient: f64,
    /// Share of the boundary friction heat that goes into the shaft, 1; the rest goes into the bush.
    pub contact_heat_to_shaft: f64,
    /// Share of the side flow that is replaced by fresh oil from the bath, 1. The rest is hot oil that is drawn in again
    /// (hot-oil carry-over).
    pub fresh_oil: f64,
    /// Temperature of the oil bath at the start, K.
    pub initial_oil: f64,
    /// Temperature of the bush at the start, K.
    pub initial_bearing: f64,
    /// Temperature of the shaft above the bush's at the start, K.
    pub initial_shaft_rise: f64,
    /// Temperature of the film above the bush's at the start, K.
    pub initial_film_rise: f64,
    /// Temperatures stay at their initial values.
    pub isothermal: bool,
    /// Whether the temperatures start as given, or in the steady state.
    pub initialization: Initialization,
}

impl Default for Thermal {
    fn default() -> Self {
        Self {
            film_capacity: 2.0,
            bush_capacity: 200.0,
            shaft_capacity: 200.0,
            oil_volume: 0.3e-3,
            film_bush: 58.0,
            film_shaft: 58.0,
            reference_clearance: 2.0e-5,
            bush_oil: 0.126,
            shaft_oil: 0.127,
            bush_ambient: 0.0,
            shaft_ambient: 0.0,
            oil_ambient: 0.532,
            contact_heat_to_shaft: 0.5,
            fresh_oil: 1.0,
            initial_oil: 321.15,
            initial_bearing: 355.15,
            initial_shaft_rise: 0.0,
            initial_film_rise: 0.0,
            isothermal: false,
            initialization: Initialization::Given,
        }
    }
}

/// Temperatures of the nodes, K, or their rates, K/s.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Temperatures {
    /// The film.
    pub film: f64,
    /// Bush and housing.
    pub bush: f64,
    /// The shaft.
    pub shaft: f64,
    /// The oil bath.
    pub oil: f64,
}

impl Temperatures {
    /// Those of film, bush, shaft and oil bath.
    pub fn of([film, bush, shaft, oil]: [f64; 4]) -> Self {
        Self { film, bush, shaft, oil }
    }

    /// The same in one array.
    pub fn array(&self) -> [f64; 4] {
        [self.film, self.bush, self.shaft, self.oil]
    }
}

/// Heat sources and flows at one instant.
#[derive(Clone, Copy, Debug, Default)]
pub struct Heat {
    /// Viscous friction heat of the film, W.
    pub viscous: f64,
    /// Boundary friction heat of the asperities, W.
    pub boundary: f64,
    /// Heat capacity rate of the oil that flows from the film into the bath, W/K.
    pub side_flow: f64,
    /// The same of the oil that feeds bring into the film.
    pub fed: f64,
    /// Its temperature, K.
    pub fed_temperature: f64,
    /// Heat capacity of the oil bath, J/K.
    pub bath: f64,
    /// Temperature of the surroundings, K.
    pub ambient: f64,
    /// Radial clearance of the bearing, m.
    pub clearance: f64,
}

impl Thermal {
    /// The temperatures at the start.
    pub fn initial(&self) -> Temperatures {
        Temperatures {
            film: self.initial_bearing + self.initial_film_rise,
            bush: self.initial_bearing,
            shaft: self.initial_bearing + self.initial_shaft_rise,
            oil: self.initial_oil,
        }
    }

    /// Whether any heat can leave to the surroundings.
    pub fn loses_heat(&self) -> bool {
        self.bush_ambient + self.shaft_ambient + self.oil_ambient > 0.0
    }

    /// Heat flow to the surroundings, W, which are at `ambient` K.
    pub fn loss(&self, t: &Temperatures, ambient: f64) -> f64 {
        self.bush_ambient * (t.bush - ambient)
            + self.shaft_ambient * (t.shaft - ambient)
            + self.oil_ambient * (t.oil - ambient)
    }

    /// Rates of the nodes' temperatures, K/s: the energy balance of each node.
    ///
    /// What leaves the film is replaced by oil from feeds, and by oil from the bath for the rest. The bath takes what leaves, and
    /// spills as much as is fed.
    #[inline]
    pub fn rates(&self, t: &Temperatures, heat: &Heat) -> Temperatures {
        if self.isothermal {
            return Temperatures::default();
        }
        let [to_bush, to_shaft] = self.film_conductances(heat.clearance);
        let film_to_bush = to_bush * (t.film - t.bush);
        let film_to_shaft = to_shaft * (t.film - t.shaft);
        let fed = heat.fed.max(0.0);
        let from_bath = self.fresh_oil * (heat.side_flow - heat.fed).max(0.0);
        let film_to_oil = from_bath * (t.film - t.oil);
        let film_to_fed = fed * (t.film - heat.fed_temperature);
        let mut rates = self.rates_beside(t, heat, [film_to_bush, film_to_shaft, film_to_oil + fed * (t.film - t.oil)]);
        rates.film = (heat.viscous - film_to_bush - film_to_shaft - film_to_oil - film_to_fed) / self.film_capacity;
        rates
    }

    /// Conductances from the film to bush and shaft at a radial clearance, m, in W/K.
    pub fn film_conductances(&self, clearance: f64) -> [f64; 2] {
        let across = if self.reference_clearance > 0.0 { self.reference_clearance / clearance } else { 1.0 };
        [across * self.film_bush, across * self.film_shaft]
    }

    /// Rates of all temperatures but the film's, which gives this heat to bush, shaft and oil bath, W.
    #[inline]
    pub fn rates_beside(
        &self,
        t: &Temperatures,
        heat: &Heat,
        [film_to_bush, film_to_shaft, film_to_oil]: [f64; 3],
    ) -> Temperatures {
        let bush_to_oil = self.bush_oil * (t.bush - t.oil);
        let shaft_to_oil = self.shaft_oil * (t.shaft - t.oil);
        let boundary_to_shaft = self.contact_heat_to_shaft * heat.boundary;
        let boundary_to_bush = heat.boundary - boundary_to_shaft;
        Temperatures {
            film: 0.0,
            bush: (film_to_bush + boundary_to_bush - bush_to_oil - self.bush_ambient * (t.bush - heat.ambient))
                / self.bush_capacity,
            shaft: (film_to_shaft + boundary_to_shaft - shaft_to_oil - self.shaft_ambient * (t.shaft - heat.ambient))
                / self.shaft_capacity,
            oil: (film_to_oil + bush_to_oil + shaft_to_oil - self.oil_ambient * (t.oil - heat.ambient)) / heat.bath,
        }
    }
}

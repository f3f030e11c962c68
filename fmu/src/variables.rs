//! The stand's variables. `variables/table.txt` has a row for each with all that hosts and people know of it, where people will
//! look for it; `access_of` tells how it is read and set. Start values are those of `Stand::default()`.
//!
//! A new variable takes the next value reference. Tools store references, so that a variable keeps its own for good.

#[macro_use]
mod declare;

use crate::{
    bearing::{FILM, Feeding, FilmEnergy, FilmModel, ThermalClearance},
    stand::Stand,
    thermal::Initialization,
};
use declare::{V, computed, flag, label, whole};
use fmu_export::{
    model::{Access, Kind, Quantity, Role},
    units::{self, KELVIN_DIFFERENCE},
};
use journal_bearing::rheology::{DensityLaw, PressureLaw, ShearLaw};
use std::sync::LazyLock;

/// The variables in the order of their value references.
pub fn table() -> &'static [V] {
    &TABLE.variables
}

/// The variables as places in [`table`], in the order in which people read them.
pub fn listing() -> &'static [usize] {
    &TABLE.listing
}

struct Table {
    variables: Vec<V>,
    listing: Vec<usize>,
}

static TABLE: LazyLock<Table> = LazyLock::new(|| {
    let rows = include_str!("variables/table.txt").lines().skip(1);
    let mut rows: Vec<(usize, V)> = rows.map(variable).collect();
    let listing = rows.iter().map(|(reference, _)| *reference).collect();
    rows.sort_by_key(|(reference, _)| *reference);
    Table { variables: rows.into_iter().map(|(_, variable)| variable).collect(), listing }
});

/// The variable of a row, after its value reference.
fn variable(row: &'static str) -> (usize, V) {
    let cells: Vec<&str> = row.split('|').map(str::trim).collect();
    let [name, reference, role, unit, shown, least, most, about, follows, description] = cells[..] else {
        panic!("a row has ten cells: {row}");
    };
    let number = |cell: &str| (!cell.is_empty()).then(|| cell.parse().expect("it is a number"));
    let mut kind = access_of(name).unwrap_or_else(|| panic!("{name} cannot be accessed"));
    if let Kind::Real(real) = &mut kind {
        real.unit = match unit {
            "K diff" => &KELVIN_DIFFERENCE,
            _ => units::named(unit).unwrap_or_else(|| panic!("there is no unit {unit}")),
        };
        real.display = (!shown.is_empty()).then_some(shown);
        (real.min, real.max, real.nominal) = (number(least), number(most), number(about));
    } else if let Kind::Integer { min, max, .. } = &mut kind {
        [*min, *max] = [least, most].map(|cell| number(cell).map(|bound| bound as i32));
    }
    let role = match role {
        "input" => Role::Input,
        "parameter" => Role::Parameter,
        "tunable" => Role::TunableParameter,
        _ => Role::Output,
    };
    let inputs = Vec::from_iter(follows.split_whitespace()).leak();
    let variable = fmu_export::declare::variable(name, role, kind, description);
    (reference.parse().expect("a reference is a number"), variable.depends_on(inputs))
}

fmu_export::enumerations! {
    /// The laws of the viscosity over pressure.
    PRESSURE_LAW = "PressureLaw", "Law of the viscosity over pressure", [
        Constant = 1 "The viscosity does not depend on pressure",
        Barus = 2 "Barus (1893): exponential",
        Roelands = 3 "Roelands (1966)"
    ];
    /// The laws of the density over pressure.
    DENSITY_LAW = "DensityLaw", "Law of the density over pressure", [
        Constant = 1 "The density does not depend on pressure",
        DowsonHigginson = 2 "Dowson and Higginson (1966)"
    ];
    /// The laws of the viscosity over the shear rate.
    SHEAR_LAW = "ShearLaw", "Law of the viscosity over the shear rate", [
        Newtonian = 1 "The viscosity does not depend on the shear rate",
        Cross = 2 "Cross (1965)",
        Carreau = 3 "Carreau (1972)"
    ];
    /// How temperatures change the clearance.
    THERMAL_CLEARANCE = "ThermalClearance", "Thermal expansion in the clearance", [
        Off = 1 "The clearance is as it was measured",
        FreeBush = 2 "Bush and shaft expand freely",
        ConstrainedBush = 3 "The bush is pressed into a housing, which holds it"
    ];
    /// The temperatures of the film.
    FILM_ENERGY = "FilmEnergy", "Temperature of the film", [
        Lumped = 1 "One temperature",
        Circumferential = 2 "A temperature around the bearing"
    ];
    /// How oil is fed to the film.
    FEED = "Feed", "Feeds of oil in the bush", [
        None = 1 "The oil comes from the bath, at the bearing's ends",
        AxialGrooves = 2 "Grooves along the axis",
        Hole = 3 "Holes",
        CircumferentialGroove = 4 "A groove around the bush, in the middle of its width"
    ];
    /// What decides in the check by ISO 7902.
    DECIDES = "Decides", "What decides whether the operation is safe", [
        SpecificLoad = 1 "The load over the projected area",
        FilmThickness = 2 "The film's least thickness",
        Temperature = 3 "The temperature of bush and film",
        Speed = 4 "The speed, beside that at which mixed friction begins",
        OutsideOfStandard = 5 "ISO 7902 does not cover this: no speed, no load, another diameter than 24 mm to 2.5 m, or no laminar film"
    ];
    /// The temperatures at the start.
    INITIALIZATION = "Initialization", "Temperatures at the start", [
        Given = 1 "The initial temperatures that are set",
        SteadyState = 2 "Those at which heat in, averaged over a turn, equals heat out, as they are reached from the ones that are set"
    ];
}

/// Reads and writes the choice of the film model.
fn film_model() -> Access<Stand, i32, i32> {
    Access { get: |stand| stand.film.model.value(), set: Some(|stand, value| stand.film.model = FilmModel::of(*value)) }
}

/// How the variable with this name is read and set, if there is one.
fn access_of(name: &str) -> Option<Kind<Stand>> {
    Some(match name {
        "drive.speed" => input!(speed),
        "bearing.bushSpeed" => input!(bush_speed),
        "load.externalForce" => input!(external_force),
        "load.externalForceX" => input!(external_force_x),
        "load.externalForceY" => input!(external_force_y),
        "thermal.ambientTemperature" => input!(ambient_temperature),
        "drive.fluctuationAmplitude" => real!(drive.fluctuation_amplitude),
        "drive.fluctuationFrequency" => real!(drive.fluctuation_frequency),
        "drive.supportFriction" => real!(drive.support_friction),
        "drive.supportDrag" => real!(drive.support_drag),
        "load.stiffness" => real!(load.stiffness),
        "load.damping" => real!(load.damping),
        "load.preload" => real!(load.preload),
        "load.eccentricity" => real!(load.eccentricity),
        "load.leverRatio" => real!(load.lever_ratio),
        "load.travelRatio" => real!(load.travel_ratio),
        "load.springOffset" => real!(load.spring_offset),
        "load.phase" => real!(load.phase),
        "bearing.radialClearance" => real!(bearing.radial_clearance),
        "bearing.thermalClearance" => {
            choice!(THERMAL_CLEARANCE, ThermalClearance { Off = 1, FreeBush = 2, ConstrainedBush = 3 }, bearing.expansion.thermal_clearance)
        }
        "bearing.referenceTemperature" => real!(bearing.expansion.reference),
        "bearing.bushExpansion" => real!(bearing.expansion.bush),
        "bearing.shaftExpansion" => real!(bearing.expansion.shaft),
        "bearing.housingExpansion" => real!(bearing.expansion.housing),
        "bearing.bushWall" => real!(bearing.expansion.wall),
        "bearing.bushModulus" => real!(bearing.expansion.bush_modulus),
        "bearing.housingModulus" => real!(bearing.expansion.housing_modulus),
        "bearing.wearCoefficient" => real!(bearing.wear.coefficient),
        "bearing.width" => real!(bearing.width),
        "bearing.diameter" => real!(bearing.diameter),
        "bearing.film" => Kind::Enumeration { access: film_model(), of: &FILM },
        "bearing.feed" => {
            choice!(FEED, Feeding { None = 1, AxialGrooves = 2, Hole = 3, CircumferentialGroove = 4 }, bearing.supply.feed)
        }
        "bearing.feedAngle" => real!(bearing.supply.angle),
        "bearing.feedExtent" => real!(bearing.supply.extent),
        "bearing.feedLength" => real!(bearing.supply.length),
        "bearing.feedCount" => whole(field!(bearing.supply.count)),
        "bearing.feedPressure" => real!(bearing.supply.pressure),
        "bearing.feedTemperature" => real!(bearing.supply.temperature),
        "bearing.roughness" => real!(bearing.surface.roughness),
        "bearing.profileFile" => label(text!(bearing.profile_file)),
        "bearing.asperityDensity" => real!(bearing.surface.asperity_density),
        "bearing.asperitySlope" => real!(bearing.surface.asperity_slope),
        "bearing.compositeModulus" => real!(bearing.surface.composite_modulus),
        "bearing.boundaryFriction" => real!(bearing.surface.boundary_friction),
        "bearing.breakawayRatio" => real!(bearing.surface.breakaway_ratio),
        "bearing.transitionSpeed" => real!(bearing.surface.transition_speed),
        "bearing.massConserving" => flag(field!(bearing.resolution.mass_conserving)),
        "bearing.sidePressure" => real!(bearing.resolution.side_pressure),
        "bearing.cavityPressure" => real!(bearing.resolution.cavity_pressure),
        "bearing.tiltAlongLoad" => real!(bearing.resolution.tilt[0]),
        "bearing.tiltAcrossLoad" => real!(bearing.resolution.tilt[1]),
        "bearing.filmEnergy" => {
            choice!(FILM_ENERGY, FilmEnergy { Lumped = 1, Circumferential = 2 }, bearing.resolution.energy)
        }
        "bearing.filmColumns" => whole(field!(bearing.resolution.columns)),
        "bearing.filmRows" => whole(field!(bearing.resolution.rows)),
        "bearing.flowFactors" => flag(field!(bearing.resolution.flow_factors)),
        "bearing.journalRoughnessShare" => real!(bearing.resolution.journal_roughness_share),
        "oil.kinematicViscosity40" => real!(oil.kinematic_viscosity_40),
        "oil.kinematicViscosity100" => real!(oil.kinematic_viscosity_100),
        "oil.density15" => real!(oil.density_15),
        "oil.viscosityScale" => real!(oil.viscosity_scale),
        "oil.propertiesFile" => label(text!(oil.properties_file)),
        "oil.pressureLaw" => {
            choice!(PRESSURE_LAW, PressureLaw { Constant = 1, Barus = 2, Roelands = 3 }, oil.thickening.pressure_law)
        }
        "oil.pressureCoefficient" => real!(oil.thickening.pressure_coefficient),
        "oil.shearLaw" => {
            choice!(SHEAR_LAW, ShearLaw { Newtonian = 1, Cross = 2, Carreau = 3 }, oil.thickening.shear_law)
        }
        "oil.shearTime" => real!(oil.thickening.shear_time),
        "oil.shearExponent" => real!(oil.thickening.shear_exponent),
        "oil.shearLimit" => real!(oil.thickening.shear_limit),
        "oil.densityLaw" => {
            choice!(DENSITY_LAW, DensityLaw { Constant = 1, DowsonHigginson = 2 }, oil.thickening.density_law)
        }
        "thermal.initialOilTemperature" => real!(thermal.initial_oil),
        "thermal.initialBearingTemperature" => real!(thermal.initial_bearing),
        "thermal.initialization" => {
            choice!(INITIALIZATION, Initialization { Given = 1, SteadyState = 2 }, thermal.initialization)
        }
        "thermal.isothermal" => flag(field!(thermal.isothermal)),
        "thermal.initialShaftRise" => real!(thermal.initial_shaft_rise),
        "thermal.initialFilmRise" => real!(thermal.initial_film_rise),
        "thermal.filmCapacity" => real!(thermal.film_capacity),
        "thermal.bushCapacity" => real!(thermal.bush_capacity),
        "thermal.shaftCapacity" => real!(thermal.shaft_capacity),
        "thermal.oilVolume" => real!(thermal.oil_volume),
        "thermal.filmBushConductance" => real!(thermal.film_bush),
        "thermal.filmShaftConductance" => real!(thermal.film_shaft),
        "thermal.bushOilConductance" => real!(thermal.bush_oil),
        "thermal.shaftOilConductance" => real!(thermal.shaft_oil),
        "thermal.bushAmbientConductance" => real!(thermal.bush_ambient),
        "thermal.shaftAmbientConductance" => real!(thermal.shaft_ambient),
        "thermal.oilAmbientConductance" => real!(thermal.oil_ambient),
        "thermal.contactHeatToShaft" => real!(thermal.contact_heat_to_shaft),
        "thermal.freshOilShare" => real!(thermal.fresh_oil),
        "thermal.filmReferenceClearance" => real!(thermal.reference_clearance),
        "solver.tolerance" => real!(solver.tolerance),
        "solver.multirate" => flag(field!(solver.multirate)),
        "operation.specificLoadLimit" => real!(permitted.specific_load),
        "operation.temperatureLimit" => real!(permitted.temperature),
        "operation.transitionFilmThickness" => real!(permitted.transition_gap),
        "sensor.loadForce" => output!(load_force),
        "sensor.frictionTorque" => output!(friction_torque),
        "sensor.frictionPower" => output!(friction_power),
        "sensor.frictionCoefficient" => output!(friction_coefficient),
        "sensor.oilTemperature" => output!(oil_temperature),
        "sensor.bearingTemperature" => output!(bearing_temperature),
        "sensor.loadForceMean" => mean!(0),
        "sensor.frictionTorqueMean" => mean!(1),
        "sensor.frictionPowerMean" => mean!(2),
        "sensor.frictionCoefficientMean" => mean!(3),
        "sensor.oilTemperatureMean" => mean!(4),
        "sensor.bearingTemperatureMean" => mean!(5),
        "bearing.eccentricityRatio" => output!(eccentricity_ratio),
        "bearing.attitudeAngle" => output!(attitude_angle),
        "bearing.minFilmThickness" => output!(min_film_thickness),
        "bearing.maxFilmPressure" => output!(max_film_pressure),
        "bearing.filmViscosity" => output!(film_viscosity),
        "bearing.filmTemperature" => output!(film_temperature),
        "bearing.maxFilmTemperature" => output!(max_film_temperature),
        "bearing.sideFlow" => output!(side_flow),
        "bearing.feedFlow" => output!(feed_flow),
        "bearing.contactShare" => output!(contact_share),
        "bearing.contactReach" => output!(contact_reach),
        "bearing.contactTorque" => output!(contact_torque),
        "bearing.hotRadialClearance" => output!(hot_radial_clearance),
        "bearing.wearDepth" => output!(wear_depth),
        "bearing.journalVelocity" => output!(journal_velocity),
        "bearing.pressureLimit" => real!(bearing.pressure_limit),
        "operation.specificLoad" => operation!(specific_load),
        "operation.sommerfeldNumber" => operation!(sommerfeld),
        "operation.minFilmThicknessLimit" => operation!(gap_limit),
        "operation.transitionSpeed" => operation!(transition_speed),
        "operation.margin" => operation!(margin),
        "operation.safe" => flag(Access { get: |s| s.operation().margin >= 1.0, set: None }),
        "operation.decides" => {
            Kind::Enumeration { access: Access { get: |s| s.operation().decides, set: None }, of: &DECIDES }
        }
        "status.validity" => whole(Access { get: |s| s.validity(), set: None }),
        "bearing.stiffnessXX" => resting!(coefficients.stiffness.m11),
        "bearing.stiffnessXY" => resting!(coefficients.stiffness.m12),
        "bearing.stiffnessYX" => resting!(coefficients.stiffness.m21),
        "bearing.stiffnessYY" => resting!(coefficients.stiffness.m22),
        "bearing.dampingXX" => resting!(coefficients.damping.m11),
        "bearing.dampingXY" => resting!(coefficients.damping.m12),
        "bearing.dampingYX" => resting!(coefficients.damping.m21),
        "bearing.dampingYY" => resting!(coefficients.damping.m22),
        "bearing.whirlThreshold" => resting!(threshold),
        "thermal.ambientHeatFlow" => output!(ambient_heat_flow),
        "thermal.oilBathCapacity" => output!(oil_bath_capacity),
        "thermal.shaftTemperature" => output!(shaft_temperature),
        "thermal.slowestTimeConstant" => Kind::Real(computed(Stand::slowest_time_constant)),
        "drive.angle" => output!(shaft_angle),
        "drive.shaftSpeed" => output!(shaft_speed),
        _ => return None,
    })
}

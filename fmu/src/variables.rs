//! The stand's variables: a line each declares name, role, unit, range, description and access. Start values are those
//! of `Stand::default()`.
//!
//! To add a variable, write its line where people should find it, and run `cargo run -p plain-bearing-stand --bin
//! model-description`: it gives the variable the next free value reference, at the end of
//! `variables/references.txt`, and lists it in `modelDescription.xml`.

#[macro_use]
mod declare;
mod references;

use crate::bearing::{FILM, FilmModel, ThermalClearance};
use crate::stand::Stand;
use crate::thermal::Initialization;
use declare::V;
use fmu_export::declare::{output, parameter, tunable, variable};
use fmu_export::model::{Access, Kind, Role};
use fmu_export::units::*;
use journal_bearing::rheology::{DensityLaw, PressureLaw, ShearLaw};
use references::Table;
use std::sync::LazyLock;

/// The variables in the order of their value references.
pub fn table() -> &'static [V] {
    &TABLE.variables
}

/// The variables as places in [`table`], in the order in which people read them.
pub fn listing() -> &'static [usize] {
    &TABLE.listing
}

pub use references::FILE as REFERENCES;

static TABLE: LazyLock<Table> = LazyLock::new(|| {
    let groups = [
        inputs(),
        drive(),
        load(),
        bearing(),
        oil(),
        thermal(),
        solver(),
        outputs(),
    ];
    Table::new(groups.into_iter().flatten().collect())
});

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
    /// The temperatures at the start.
    INITIALIZATION = "Initialization", "Temperatures at the start", [
        Given = 1 "The initial temperatures that are set",
        SteadyState = 2 "Those at which heat in, averaged over a turn, equals heat out, as they are reached from the ones that are set"
    ];
}

fn inputs() -> Vec<V> {
    vec![
        input!(
            "drive.speed",
            &RADIAN_PER_SECOND,
            speed,
            "Mean shaft speed that the drive is set to"
        )
        .shown_in("rpm")
        .within(-2000.0, 2000.0)
        .about(30.0),
        input!(
            "load.externalForce",
            &NEWTON,
            external_force,
            "Force added to the bearing load, along the load line"
        )
        .within(-1e6, 1e6)
        .about(1e3),
        input!(
            "thermal.ambientTemperature",
            &KELVIN,
            ambient_temperature,
            "Temperature of the surroundings"
        )
        .shown_in("degC")
        .within(200.0, 500.0)
        .about(300.0),
    ]
}

fn drive() -> Vec<V> {
    vec![
        tunable(
            "drive.fluctuationAmplitude",
            &ONE,
            field!(drive.fluctuation_amplitude),
            "Amplitude of the speed fluctuation relative to the mean speed",
        )
        .shown_in("%")
        .within(0.0, 1.0)
        .about(0.025),
        parameter(
            "drive.fluctuationFrequency",
            &HERTZ,
            field!(drive.fluctuation_frequency),
            "Frequency of the speed fluctuation",
        )
        .within(0.0, 1e3)
        .about(1.0),
        tunable(
            "drive.supportFriction",
            &ONE,
            field!(drive.support_friction),
            "Friction coefficient of the support bearings, relative to load and journal radius; the torque sensor reads their torque, too",
        )
        .within(0.0, 1.0)
        .about(1e-3),
    ]
}

fn load() -> Vec<V> {
    vec![
        tunable(
            "load.stiffness",
            &NEWTON_PER_METRE,
            field!(load.stiffness),
            "Stiffness C of the elastic element",
        )
        .within(0.0, 1e7)
        .about(100.0),
        tunable(
            "load.damping",
            &NEWTON_SECOND_PER_METRE,
            field!(load.damping),
            "Damping coefficient beta of the elastic element",
        )
        .within(0.0, 1e5)
        .about(10.0),
        tunable(
            "load.preload",
            &NEWTON,
            field!(load.preload),
            "Starting force F0 of the elastic element",
        )
        .within(-1e5, 1e5)
        .about(50.0),
        tunable(
            "load.eccentricity",
            &METRE,
            field!(load.eccentricity),
            "Eccentricity of the shaft's mounting hole; 0 gives a constant load",
        )
        .shown_in("mm")
        .within(0.0, 0.1)
        .about(5e-4),
        tunable(
            "load.leverRatio",
            &ONE,
            field!(load.lever_ratio),
            "Force on the bearing over force of the elastic element",
        )
        .within(-1e3, 1e3)
        .about(10.0),
        tunable(
            "load.travelRatio",
            &ONE,
            field!(load.travel_ratio),
            "Travel of the elastic element over travel of the eccentric",
        )
        .within(-1e3, 1e3)
        .about(10.0),
        tunable(
            "load.springOffset",
            &METRE,
            field!(load.spring_offset),
            "Travel by which the elastic element is released at rest",
        )
        .shown_in("mm")
        .within(-10.0, 10.0)
        .about(0.03),
        tunable(
            "load.phase",
            &RADIAN,
            field!(load.phase),
            "Angle of the eccentric at shaft angle zero",
        )
        .shown_in("deg")
        .within(-100.0, 100.0)
        .about(1.0),
    ]
}

/// Reads and writes the choice of the film model.
fn film_model() -> Access<Stand, i32, i32> {
    Access {
        get: |stand| stand.film.model.value(),
        set: Some(|stand, value| stand.film.model = FilmModel::of(*value)),
    }
}

fn bearing() -> Vec<V> {
    vec![
        parameter("bearing.radialClearance", &METRE, field!(bearing.radial_clearance), "Radial clearance h as it was measured, see bearing.thermalClearance")
            .shown_in("mm").within(1e-7, 1e-2).about(2e-5),
        choice!("bearing.thermalClearance", THERMAL_CLEARANCE, ThermalClearance { Off = 1, FreeBush = 2, ConstrainedBush = 3 }, bearing.expansion.thermal_clearance,
            "Thermal expansion in the clearance that the film sees"),
        parameter("bearing.referenceTemperature", &KELVIN, field!(bearing.expansion.reference), "Temperature at which bearing.radialClearance was measured")
            .shown_in("degC").within(200.0, 600.0).about(300.0),
        parameter("bearing.bushExpansion", &PER_KELVIN, field!(bearing.expansion.bush), "Coefficient of thermal expansion of the bush")
            .within(0.0, 1e-3).about(1e-5),
        parameter("bearing.shaftExpansion", &PER_KELVIN, field!(bearing.expansion.shaft), "Coefficient of thermal expansion of the shaft")
            .within(0.0, 1e-3).about(1e-5),
        parameter("bearing.housingExpansion", &PER_KELVIN, field!(bearing.expansion.housing), "Coefficient of thermal expansion of the housing, which has the bush's temperature (constrained bush only)")
            .within(0.0, 1e-3).about(1e-5),
        parameter("bearing.bushWall", &METRE, field!(bearing.expansion.wall), "Wall thickness of the bush (constrained bush only)")
            .shown_in("mm").within(1e-6, 1.0).about(1e-3),
        parameter("bearing.bushModulus", &PASCAL, field!(bearing.expansion.bush_modulus), "Young's modulus of the bush (constrained bush only)")
            .shown_in("GPa").within(1e6, 1e13).about(1e11),
        parameter("bearing.housingModulus", &PASCAL, field!(bearing.expansion.housing_modulus), "Young's modulus of the housing (constrained bush only)")
            .shown_in("GPa").within(1e6, 1e13).about(1e11),
        parameter("bearing.wearCoefficient", &SQUARE_METRE_PER_NEWTON, field!(bearing.wear.coefficient), "Specific wear rate of the touching asperities: worn volume over force and sliding distance; 0 switches wear off")
            .shown_in("mm3/(N.m)").within(0.0, 1e-9).about(1e-16),
        parameter("bearing.width", &METRE, field!(bearing.width), "Bearing width B")
            .shown_in("mm").within(1e-4, 10.0).about(0.02),
        parameter("bearing.diameter", &METRE, field!(bearing.diameter), "Diameter D of the bush")
            .shown_in("mm").within(1e-4, 10.0).about(0.02),
        variable("bearing.film", Role::Parameter, Kind::Enumeration { access: film_model(), of: &FILM }, "Film model"),
        parameter("bearing.roughness", &METRE, field!(bearing.surface.roughness), "Composite rms roughness and waviness of both surfaces; 0 switches asperity contact off")
            .shown_in("um").within(0.0, 1e-3).about(1e-6),
        variable("bearing.profileFile", Role::Parameter, Kind::String { access: text!(bearing.profile_file) },
            "csv file of the radial deviation of bush and shaft over the angle (Reynolds film only); empty for round ones"),
        parameter("bearing.asperityDensity", &ONE, field!(bearing.surface.asperity_density), "Asperity density times summit radius times roughness")
            .within(0.0, 1.0).about(0.05),
        parameter("bearing.asperitySlope", &ONE, field!(bearing.surface.asperity_slope), "Roughness over summit radius")
            .within(0.0, 1.0).about(0.01),
        parameter("bearing.compositeModulus", &PASCAL, field!(bearing.surface.composite_modulus), "Composite elastic modulus of shaft and bush")
            .shown_in("GPa").within(0.0, 1e13).about(1e11),
        tunable("bearing.boundaryFriction", &ONE, field!(bearing.surface.boundary_friction), "Friction coefficient of touching asperities")
            .within(0.0, 10.0).about(0.1),
        tunable("bearing.breakawayRatio", &ONE, field!(bearing.surface.breakaway_ratio), "Friction of touching asperities at breakaway over that at full sliding speed")
            .within(0.1, 10.0).about(1.0),
        tunable("bearing.transitionSpeed", &METRE_PER_SECOND, field!(bearing.surface.transition_speed), "Sliding speed over which friction of touching asperities falls from breakaway to its full-speed value")
            .shown_in("mm/s").within(1e-5, 10.0).about(1e-3),
        variable("bearing.massConserving", Role::Parameter, Kind::Boolean { access: field!(bearing.resolution.mass_conserving) },
            "The oil's mass is conserved where the film ruptures; else its pressure only never falls below the bath's (Reynolds film only)"),
        parameter("bearing.sidePressure", &PASCAL, field!(bearing.resolution.side_pressure), "Pressure of the oil bath above that of the cavities, unless bearing.cavityPressure says it (Reynolds film only)")
            .shown_in("bar").within(0.0, 1e9).about(1e5),
        parameter("bearing.cavityPressure", &PASCAL, field!(bearing.resolution.cavity_pressure), "Absolute pressure in the cavities, under an oil bath at 101,325 Pa; negative: bearing.sidePressure holds (Reynolds film only)")
            .shown_in("kPa").within(-1.0, 101_325.0).about(1e5),
        parameter("bearing.tiltAlongLoad", &METRE, field!(bearing.resolution.tilt[0]), "Displacement of the journal's end by its tilt, along the load (Reynolds film only)")
            .shown_in("um").within(-1e-2, 1e-2).about(1e-6),
        parameter("bearing.tiltAcrossLoad", &METRE, field!(bearing.resolution.tilt[1]), "Displacement of the journal's end by its tilt, across the load (Reynolds film only)")
            .shown_in("um").within(-1e-2, 1e-2).about(1e-6),
        variable("bearing.filmColumns", Role::Parameter, Kind::Integer { access: field!(bearing.resolution.columns), min: Some(0), max: Some(2000) },
            "Columns of the film's cells around the bush; 0 takes as many as the width needs (Reynolds film only)"),
        variable("bearing.filmRows", Role::Parameter, Kind::Integer { access: field!(bearing.resolution.rows), min: Some(0), max: Some(200) },
            "Rows of the film's cells over half the width; 0 takes as many as the width needs (Reynolds film only)"),
        variable("bearing.flowFactors", Role::Parameter, Kind::Boolean { access: field!(bearing.resolution.flow_factors) },
            "The film sees the surfaces' roughness: mean gap and flow factors of Patir and Cheng (Reynolds film only)"),
        parameter("bearing.journalRoughnessShare", &ONE, field!(bearing.resolution.journal_roughness_share), "Journal's share of the composite roughness' variance; matters with flow factors (Reynolds film only)")
            .within(0.0, 1.0).about(0.5),
    ]
}

fn oil() -> Vec<V> {
    vec![
        parameter(
            "oil.kinematicViscosity40",
            &SQUARE_METRE_PER_SECOND,
            field!(oil.kinematic_viscosity_40),
            "Kinematic viscosity of the oil at 40 degC",
        )
        .shown_in("mm2/s")
        .within(1e-6, 1.0)
        .about(1e-4),
        parameter(
            "oil.kinematicViscosity100",
            &SQUARE_METRE_PER_SECOND,
            field!(oil.kinematic_viscosity_100),
            "Kinematic viscosity of the oil at 100 degC",
        )
        .shown_in("mm2/s")
        .within(1e-6, 1.0)
        .about(1e-5),
        parameter(
            "oil.density15",
            &KILOGRAM_PER_CUBIC_METRE,
            field!(oil.density_15),
            "Density of the oil at 15 degC",
        )
        .within(500.0, 2000.0)
        .about(880.0),
        tunable(
            "oil.viscosityScale",
            &ONE,
            field!(oil.viscosity_scale),
            "Factor on the viscosity of the oil law; 1 is the real oil",
        )
        .within(1e-3, 1e4)
        .about(1.0),
        variable(
            "oil.propertiesFile",
            Role::Parameter,
            Kind::String {
                access: text!(oil.properties_file),
            },
            "csv file of measured viscosity and density over temperature; empty for the two viscosities above",
        ),
        choice!("oil.pressureLaw", PRESSURE_LAW, PressureLaw { Constant = 1, Barus = 2, Roelands = 3 }, oil.thickening.pressure_law,
            "Law of the viscosity over pressure (Reynolds film only)"),
        parameter(
            "oil.pressureCoefficient",
            &PER_PASCAL,
            field!(oil.thickening.pressure_coefficient),
            "Pressure-viscosity coefficient at ambient pressure",
        )
        .shown_in("1/GPa")
        .within(0.0, 1e-6)
        .about(1e-8),
        choice!("oil.shearLaw", SHEAR_LAW, ShearLaw { Newtonian = 1, Cross = 2, Carreau = 3 }, oil.thickening.shear_law,
            "Law of the viscosity over the shear rate (Reynolds film only)"),
        parameter(
            "oil.shearTime",
            &SECOND,
            field!(oil.thickening.shear_time),
            "Time constant of the shear law",
        )
        .within(0.0, 1.0)
        .about(1e-7),
        parameter(
            "oil.shearExponent",
            &ONE,
            field!(oil.thickening.shear_exponent),
            "Exponent of the shear law",
        )
        .within(0.0, 2.0)
        .about(1.0),
        parameter(
            "oil.shearLimit",
            &ONE,
            field!(oil.thickening.shear_limit),
            "Viscosity at the highest shear rates over that at the lowest",
        )
        .within(0.0, 1.0)
        .about(0.5),
        choice!("oil.densityLaw", DENSITY_LAW, DensityLaw { Constant = 1, DowsonHigginson = 2 }, oil.thickening.density_law,
            "Law of the density over pressure (Reynolds film only)"),
    ]
}

fn thermal() -> Vec<V> {
    let conductance = |name, access, description| {
        tunable(name, &WATT_PER_KELVIN, access, description)
            .within(0.0, 1e6)
            .about(1.0)
    };
    let capacity = |name, access, description| {
        parameter(name, &JOULE_PER_KELVIN, access, description)
            .within(1e-3, 1e9)
            .about(100.0)
    };
    vec![
        parameter("thermal.initialOilTemperature", &KELVIN, field!(thermal.initial_oil), "Temperature of the oil bath at the start")
            .shown_in("degC").within(200.0, 600.0).about(300.0),
        parameter("thermal.initialBearingTemperature", &KELVIN, field!(thermal.initial_bearing), "Temperature of bush and housing at the start")
            .shown_in("degC").within(200.0, 600.0).about(300.0),
        choice!("thermal.initialization", INITIALIZATION, Initialization { Given = 1, SteadyState = 2 }, thermal.initialization,
            "Temperatures at the start: as set, or in the steady state that is reached from them"),
        variable("thermal.isothermal", Role::Parameter, Kind::Boolean { access: field!(thermal.isothermal) },
            "Temperatures stay at their initial values"),
        parameter("thermal.initialShaftRise", &KELVIN_DIFFERENCE, field!(thermal.initial_shaft_rise), "Temperature difference of shaft to bush at the start")
            .within(-300.0, 300.0).about(1.0),
        parameter("thermal.initialFilmRise", &KELVIN_DIFFERENCE, field!(thermal.initial_film_rise), "Temperature difference of film to bush at the start")
            .within(-300.0, 300.0).about(1.0),
        capacity("thermal.filmCapacity", field!(thermal.film_capacity), "Heat capacity of the film with the surface layers that follow it within a turn"),
        capacity("thermal.bushCapacity", field!(thermal.bush_capacity), "Heat capacity of bush and housing"),
        capacity("thermal.shaftCapacity", field!(thermal.shaft_capacity), "Heat capacity of the shaft"),
        parameter("thermal.oilVolume", &CUBIC_METRE, field!(thermal.oil_volume), "Volume of the oil bath")
            .shown_in("dm3").within(1e-6, 1e3).about(3e-4),
        conductance("thermal.filmBushConductance", field!(thermal.film_bush), "Conductance from film to bush at the reference clearance"),
        conductance("thermal.filmShaftConductance", field!(thermal.film_shaft), "Conductance from film to shaft at the reference clearance"),
        conductance("thermal.bushOilConductance", field!(thermal.bush_oil), "Conductance from bush and housing to the oil bath"),
        conductance("thermal.shaftOilConductance", field!(thermal.shaft_oil), "Conductance from shaft to the oil bath"),
        conductance("thermal.bushAmbientConductance", field!(thermal.bush_ambient), "Conductance from bush and housing to the surroundings"),
        conductance("thermal.shaftAmbientConductance", field!(thermal.shaft_ambient), "Conductance from shaft to the surroundings"),
        conductance("thermal.oilAmbientConductance", field!(thermal.oil_ambient), "Conductance from the oil bath to the surroundings"),
        tunable("thermal.contactHeatToShaft", &ONE, field!(thermal.contact_heat_to_shaft), "Part of the boundary friction heat that goes into the shaft; the rest goes into the bush")
            .within(0.0, 1.0).about(0.5),
        tunable("thermal.freshOilShare", &ONE, field!(thermal.fresh_oil), "Part of the side flow that fresh oil from the bath replaces; the rest is hot oil drawn in again")
            .within(0.0, 1.0).about(0.5),
        parameter("thermal.filmReferenceClearance", &METRE, field!(thermal.reference_clearance), "Radial clearance at which the film's conductances hold, as they go as its reciprocal; 0 makes them constant")
            .shown_in("mm").within(0.0, 1e-2).about(2e-5),
    ]
}

fn solver() -> Vec<V> {
    vec![
        parameter("solver.tolerance", &ONE, field!(solver.tolerance), "Relative tolerance of each internal step of the time integration; the host's tolerance goes before it")
            .within(1e-12, 1e-2).about(1e-6),
        variable("solver.multirate", Role::Parameter, Kind::Boolean { access: field!(solver.multirate) },
            "Leap over whole turns in communication steps much longer than a turn"),
    ]
}

fn outputs() -> Vec<V> {
    vec![
        output!("sensor.loadForce", &NEWTON, load_force, ["drive.speed", "load.externalForce"], "Force on the bearing F_N").within(-1e15, 1e15).about(1e3),
        output!("sensor.frictionTorque", &NEWTON_METRE, friction_torque, ["drive.speed", "load.externalForce"], "Friction torque on the shaft M").within(-1e18, 1e18).about(1.0),
        output!("sensor.frictionPower", &WATT, friction_power, ["drive.speed", "load.externalForce"], "Friction power M*omega").within(-1e21, 1e21).about(10.0),
        output!("sensor.frictionCoefficient", &ONE, friction_coefficient, ["drive.speed", "load.externalForce"], "Friction coefficient M/(F_N*D/2)").within(-1e9, 1e9).about(0.1),
        output!("sensor.oilTemperature", &KELVIN, oil_temperature, [], "Temperature of the oil bath").shown_in("degC").within(0.0, 1e12).about(300.0),
        output!("sensor.bearingTemperature", &KELVIN, bearing_temperature, [], "Temperature of the bush").shown_in("degC").within(0.0, 1e12).about(300.0),
        mean!("sensor.loadForceMean", &NEWTON, 0, ["drive.speed", "load.externalForce"], "Force on the bearing F_N").within(-1e15, 1e15).about(1e3),
        mean!("sensor.frictionTorqueMean", &NEWTON_METRE, 1, ["drive.speed", "load.externalForce"], "Friction torque on the shaft M").within(-1e18, 1e18).about(1.0),
        mean!("sensor.frictionPowerMean", &WATT, 2, ["drive.speed", "load.externalForce"], "Friction power M*omega").within(-1e21, 1e21).about(10.0),
        mean!("sensor.frictionCoefficientMean", &ONE, 3, ["drive.speed", "load.externalForce"], "Friction coefficient M/(F_N*D/2)").within(-1e9, 1e9).about(0.1),
        mean!("sensor.oilTemperatureMean", &KELVIN, 4, [], "Temperature of the oil bath").shown_in("degC").within(0.0, 1e12).about(300.0),
        mean!("sensor.bearingTemperatureMean", &KELVIN, 5, [], "Temperature of the bush").shown_in("degC").within(0.0, 1e12).about(300.0),
        output!("bearing.eccentricityRatio", &ONE, eccentricity_ratio, [], "Eccentricity of the journal over the radial clearance").within(0.0, 10.0).about(1.0),
        output!("bearing.attitudeAngle", &RADIAN, attitude_angle, [], "Angle from the load line to the eccentricity, positive in the direction of positive rotation").shown_in("deg").within(-4.0, 4.0).about(1.0),
        output!("bearing.minFilmThickness", &METRE, min_film_thickness, [], "Smallest film thickness").shown_in("um").within(0.0, 0.1).about(1e-6),
        output!("bearing.maxFilmPressure", &PASCAL, max_film_pressure, ["drive.speed", "load.externalForce"], "Largest film pressure above ambient pressure, which is that of the oil bath").shown_in("MPa").within(-1e9, 1e24).about(1e7),
        output!("bearing.filmViscosity", &PASCAL_SECOND, film_viscosity, [], "Dynamic viscosity of the film").shown_in("mPa.s").within(0.0, 1e24).about(0.01),
        output!("bearing.filmTemperature", &KELVIN, film_temperature, [], "Temperature of the film").shown_in("degC").within(0.0, 1e12).about(300.0),
        output!("bearing.sideFlow", &CUBIC_METRE_PER_SECOND, side_flow, ["drive.speed", "load.externalForce"], "Oil that leaves the film at both ends").shown_in("mm3/s").within(0.0, 1e6).about(1e-7),
        output!("bearing.contactShare", &ONE, contact_share, ["drive.speed", "load.externalForce"], "Force of the touching asperities' pressure over the load").shown_in("%").within(0.0, 1e9).about(1.0),
        output!("bearing.contactTorque", &NEWTON_METRE, contact_torque, ["drive.speed"], "Friction torque of the touching asperities").within(-1e18, 1e18).about(1.0),
        output!("bearing.hotRadialClearance", &METRE, hot_radial_clearance, [], "Radial clearance that the film sees: with thermal expansion and wear").shown_in("um").within(0.0, 1e9).about(1e-5),
        output!("bearing.wearDepth", &METRE, wear_depth, [], "Mean depth by which wear has opened the clearance").shown_in("um").within(0.0, 1e9).about(1e-6),
        output!("bearing.journalVelocity", &METRE_PER_SECOND, journal_velocity, ["drive.speed", "load.externalForce"], "Velocity of the journal along the load line").shown_in("mm/s").within(-1e12, 1e12).about(1e-4),
        output!("thermal.ambientHeatFlow", &WATT, ambient_heat_flow, ["thermal.ambientTemperature"], "Heat flow to the surroundings").within(-1e18, 1e18).about(10.0),
        output!("thermal.oilBathCapacity", &JOULE_PER_KELVIN, oil_bath_capacity, [], "Heat capacity of the oil bath at its temperature").within(0.0, 1e18).about(500.0),
        output!("thermal.shaftTemperature", &KELVIN, shaft_temperature, [], "Temperature of the shaft").shown_in("degC").within(0.0, 1e12).about(300.0),
        output("thermal.slowestTimeConstant", &SECOND, Stand::slowest_time_constant, "Slowest time constant of the heat balance at the present state, averaged over a turn; negative where a deviation grows, 0 when isothermal")
            .depends_on(&["drive.speed", "load.externalForce", "thermal.ambientTemperature"]).within(-1e12, 1e12).about(1e3),
        output!("drive.angle", &RADIAN, shaft_angle, [], "Shaft angle, from 0 at the start").shown_in("deg").within(-1e16, 1e16).about(100.0),
        output!("drive.shaftSpeed", &RADIAN_PER_SECOND, shaft_speed, ["drive.speed"], "Shaft speed with its fluctuation").shown_in("rpm").within(-4000.0, 4000.0).about(30.0),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_set_is_read_back() {
        let mut stand = Stand::default();
        for variable in table() {
            if let Kind::Real {
                access:
                    Access {
                        get,
                        set: Some(set),
                    },
                ..
            } = variable.kind
            {
                let other = get(&stand) * 1.5 + 1e-3;
                set(&mut stand, &other);
                assert_eq!(get(&stand), other, "{}", variable.name);
            }
        }
    }
}

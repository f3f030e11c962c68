//! The library's unit tests. They lie beside the code, and are compiled here: a harness of their own would compile all of the
//! library a second time, which takes as long as all else of these tests together.

#[path = "../../src/multirate/correction_tests.rs"]
mod correction;
#[path = "../../src/multirate/curves_tests.rs"]
mod curves;
#[path = "../../src/documentation_tests.rs"]
mod documentation;
#[path = "../../src/solver/dormand_prince_tests.rs"]
mod dormand_prince;
#[path = "../../src/drive_tests.rs"]
mod drive;
#[path = "../../src/multirate/equilibrium_tests.rs"]
mod equilibrium;
#[path = "../../src/bearing/film_tests.rs"]
mod film;
#[path = "../../src/bearing/friction_tests.rs"]
mod friction;
#[path = "../../src/bearing/hot_tests.rs"]
mod hot;
#[path = "../../src/load_tests.rs"]
mod load;
#[path = "../../src/oil/measured_tests.rs"]
mod measured;
#[path = "../../src/stand/steady/newton_tests.rs"]
mod newton;
#[path = "../../src/oil_tests.rs"]
mod oil;
#[path = "../../src/multirate/orbit_tests.rs"]
mod orbit;
#[path = "../../src/solver/rodas3_tests.rs"]
mod rodas3;
#[path = "../../src/solver/tests.rs"]
mod solver;
#[path = "../../src/stand/stiff_tests.rs"]
mod stiff;
#[path = "../../src/thermal_tests.rs"]
mod thermal;
#[path = "../../src/sensors/turn_tests.rs"]
mod turn;
#[path = "../../src/stand/validity_tests.rs"]
mod validity;
#[path = "../../src/variables_tests.rs"]
mod variables;
#[path = "../../src/bearing/wear_tests.rs"]
mod wear;

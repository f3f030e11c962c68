"""ECOS, a co-simulation engine in C++, through ecospy."""

from ecospy import EcosSimulation, EcosSimulationStructure
from ecospy.EcosParameterSet import EcosParameterSet
from scenario import FMU, OUTPUTS, START, STEP, STEPS, report

with EcosSimulationStructure() as structure:
    structure.add_model("stand", FMU)
    with EcosParameterSet() as parameters:
        for name, value in START.items():
            parameters.add_real(f"stand::{name}", value)
        structure.add_parameter_set("start", parameters)
    with EcosSimulation(structure=structure, step_size=STEP) as simulation:
        simulation.init(parameter_set="start")
        samples = []
        for _ in range(STEPS):
            simulation.step(1)
            samples.append([simulation.get_real(f"stand::{name}") for name in OUTPUTS])
report("ecospy", samples)

"""Two stands in an SSP: packs dist/two-bearings.ssp from two-bearings/ and the FMU, and runs it by FMPy.

libcosim, OMSimulator and other tools run the same file. The system has no connectors of its own, as libcosim
knows connections between components only (libcosimpy 0.0.6: "No such node (<xmlattr>.startElement)"): the first
stand's speed is a start value in the SSP.
"""

import zipfile
from pathlib import Path

from common import FMU, table
from fmpy.ssp.simulation import simulate_ssp
from fmpy.ssp.ssd import ParameterSet, read_ssd

HERE = Path(__file__).resolve().parent
SSP = FMU.with_name("two-bearings.ssp")
OUTPUTS = [f"{stand}.{name}" for stand in ["first", "second"]
           for name in ["sensor.loadForce", "sensor.frictionTorque", "bearing.eccentricityRatio"]]


def pack():
    """Writes the SSP."""
    folder = HERE / "two-bearings"
    with zipfile.ZipFile(SSP, "w", zipfile.ZIP_DEFLATED) as ssp:
        for file in sorted(path for path in folder.rglob("*") if path.is_file()):
            ssp.write(file, file.relative_to(folder))
        ssp.write(FMU, "resources/PlainBearingStand.fmu")
    return SSP


def parameters(ssp):
    """The parameters that the SSP binds to its components: FMPy reads them, but wants them handed over."""
    bound = ParameterSet(name="bound")
    for component in read_ssd(str(ssp)).system.elements:
        for binding in component.parameterBindings:
            for values in binding.parameterValues:
                for parameter in values.parameters:
                    parameter.name = f"{component.name}.{parameter.name}"
                    bound.parameters.append(parameter)
    return bound


def run(ssp, stop=1.0, step=0.001):
    return simulate_ssp(str(ssp), stop_time=stop, step_size=step, parameter_set=parameters(ssp))


if __name__ == "__main__":
    ssp = pack()
    print(ssp)
    table(run(ssp), OUTPUTS)

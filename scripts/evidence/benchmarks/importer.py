"""Runs an FMU with another importer, again and again.

Usage: importer.py KIND FMU STEP STEPS RUNS OUTPUT
KIND is `simulate` (fmpy.simulate_fmu), `loop` (fmpy's FMU2Slave, one instance reset between the runs), or
`omsimulator`. Loading and unpacking happen before the clock starts. Prints the CPU seconds of the runs, and
the output's last value.
"""

import sys
import tempfile
import time


def simulate(fmu, step, steps, output, folder):
    """A run by `fmpy.simulate_fmu`, with everything that it takes ready made handed over."""
    import fmpy

    description = fmpy.read_model_description(fmu, validate=False)
    unpacked = fmpy.extract(fmu, folder)

    def run():
        result = fmpy.simulate_fmu(unpacked, model_description=description, validate=False,
                                   start_time=0.0, stop_time=step * steps, step_size=step,
                                   output_interval=step, output=[output], fmi_type="CoSimulation")
        return result[output][-1]

    return run


def loop(fmu, step, steps, output, folder):
    """A run by a loop of doStep and getReal, on one instance."""
    import fmpy
    from fmpy.fmi2 import FMU2Slave

    description = fmpy.read_model_description(fmu, validate=False)
    [reference] = [v.valueReference for v in description.modelVariables if v.name == output]
    slave = FMU2Slave(guid=description.guid, unzipDirectory=fmpy.extract(fmu, folder), instanceName="loop",
                      modelIdentifier=description.coSimulation.modelIdentifier)
    slave.instantiate()

    def run():
        slave.reset()
        slave.setupExperiment(startTime=0.0, stopTime=step * steps)
        slave.enterInitializationMode()
        slave.exitInitializationMode()
        for index in range(steps):
            slave.doStep(currentCommunicationPoint=index * step, communicationStepSize=step)
            [value] = slave.getReal([reference])
        slave.terminate()
        return value

    return run


def omsimulator(fmu, step, steps, output, folder):
    """A run by OMSimulator, from a model that is loaded once."""
    from OMSimulator import OMSimulator

    oms = OMSimulator()
    oms.setTempDirectory(folder)
    oms.newModel("m")
    oms.addSystem("m.s", oms.system_wc)
    oms.addSubModel("m.s.f", fmu)
    oms.setResultFile("m", "")
    oms.setStopTime("m", step * steps)
    oms.setFixedStepSize("m", step)

    def run():
        oms.instantiate("m")
        oms.initialize("m")
        oms.simulate("m")
        value = oms.getReal(f"m.s.f.{output}")
        oms.terminate("m")
        return value[0] if isinstance(value, tuple) else value

    return run


def main():
    kind, fmu, step, steps, runs, output = sys.argv[1:]
    kinds = {"simulate": simulate, "loop": loop, "omsimulator": omsimulator}
    with tempfile.TemporaryDirectory() as folder:
        run = kinds[kind](fmu, float(step), int(steps), output, folder)
        value = run()  # once without the clock: lazy imports
        begun = time.process_time()
        for _ in range(int(runs)):
            value = run()
        print(time.process_time() - begun, float(value))


if __name__ == "__main__":
    main()

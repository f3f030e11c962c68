"""The C functions in their order, called directly: what the others are compared with."""

import fmpy
from fmpy.fmi2 import FMU2Slave
from scenario import OUTPUTS, START, STEP, STEPS, fmu, report

description = fmpy.read_model_description(fmu())
references = {variable.name: variable.valueReference for variable in description.modelVariables}
instance = FMU2Slave(guid=description.guid, unzipDirectory=fmpy.extract(fmu()),
                     modelIdentifier=description.coSimulation.modelIdentifier, instanceName="reference")
instance.instantiate()
instance.setupExperiment(startTime=0.0)
instance.setReal([references[name] for name in START], list(START.values()))
instance.enterInitializationMode()
instance.exitInitializationMode()
outputs = [references[name] for name in OUTPUTS]
samples = [instance.getReal(outputs)]
for i in range(STEPS):
    instance.doStep(i * STEP, STEP)
    samples.append(instance.getReal(outputs))
instance.terminate()
instance.freeInstance()
report("fmpy", samples)

"""PathSim with its block for FMUs."""

from pathsim import Connection, Simulation
from pathsim.blocks import Constant, Scope
from pathsim_fmi import CoSimulationFMU
from scenario import FMU, OUTPUTS, START, STEP, STEPS, STOP, report

block = CoSimulationFMU(FMU, start_values=START, dt=STEP)
wrapper = block.fmu_wrapper
start = {v.name: float(v.start or 0.0) for v in wrapper.model_description.modelVariables if v.causality == "input"}
inputs = [Constant({**start, **START}[name]) for name in wrapper.input_refs]
names = list(wrapper.output_refs)
scope = Scope()
connections = [Connection(source, block[i]) for i, source in enumerate(inputs)]
connections += [Connection(block[names.index(name)], scope[i]) for i, name in enumerate(OUTPUTS)]
samples = []
step = block._step_fmu


def recorded(time):
    step(time)
    values = dict(zip(names, wrapper.get_outputs_as_array()))
    samples.append([values[name] for name in OUTPUTS])


block.events[0].func_act = recorded
simulation = Simulation([*inputs, block, scope], connections, dt=STEP, log=False)
simulation.run(STOP)
extra = len(samples) - STEPS
report("pathsim-fmi", samples[:STEPS],
       f"it takes {extra} step{'s' * (extra != 1)} more than asked for" if extra else "")

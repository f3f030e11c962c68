"""libcosim, the Open Simulation Platform's engine in C++, through libcosimpy."""

from libcosimpy.CosimEnums import CosimVariableType
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimObserver import CosimObserver
from libcosimpy.CosimSlave import CosimLocalSlave
from scenario import FMU, OUTPUTS, START, STEP, STEPS, report

execution = CosimExecution.from_step_size(step_size=int(STEP * 1e9))
slave = execution.add_local_slave(CosimLocalSlave(fmu_path=FMU, instance_name="stand"))
variables = {}
for variable in execution.slave_variables(slave):
    name = variable.name
    variables[name.decode() if isinstance(name, bytes) else name] = variable.reference
for name, value in START.items():
    execution.real_initial_value(slave, variables[name], value)
observer = CosimObserver.create_last_value()
execution.add_observer(observer)
outputs = [variables[name] for name in OUTPUTS]
samples = []
for _ in range(STEPS):
    if not execution.step():  # for an FMU that ends the simulation, too
        break
    samples.append(list(observer.last_real_values(slave, outputs)))
report("libcosimpy", samples)

"""fmuloader: a ctypes binding of its own."""

import zipfile

from fmuloader.fmi2 import Fmi2Slave, Fmi2Status, Fmi2Type
from scenario import FMU, GUID, IDENTIFIER, OUTPUTS, REFERENCES, START, STEP, STEPS, report

with zipfile.ZipFile(FMU) as archive:
    own_memory = b'canNotUseMemoryManagementFunctions="true"' in archive.read("modelDescription.xml")
slave = Fmi2Slave(FMU, model_identifier=IDENTIFIER)
slave.instantiate("stand", Fmi2Type.CO_SIMULATION, guid=GUID, cannot_use_memory_management_functions=own_memory)
slave.setup_experiment(start_time=0.0)
slave.set_real([REFERENCES[name] for name in START], list(START.values()))
slave.enter_initialization_mode()
slave.exit_initialization_mode()
outputs = [REFERENCES[name] for name in OUTPUTS]
samples = [slave.get_real(outputs)]
for i in range(STEPS):
    status = slave.do_step(i * STEP, STEP)
    samples.append(slave.get_real(outputs))
    if status == Fmi2Status.DISCARD:  # the FMU ends the simulation
        break
slave.terminate()
slave.free_instance()
report("fmuloader", samples)

"""fmuloader: a ctypes binding of its own."""

import xml.etree.ElementTree as ET
import zipfile

from fmuloader.fmi2 import Fmi2Slave, Fmi2Type
from scenario import OUTPUTS, START, STEP, STEPS, fmu, report

root = ET.fromstring(zipfile.ZipFile(fmu()).read("modelDescription.xml"))
references = {variable.get("name"): int(variable.get("valueReference"))
              for variable in root.iter("ScalarVariable")}
slave = Fmi2Slave(fmu(), model_identifier=root.find("CoSimulation").get("modelIdentifier"))
slave.instantiate("stand", Fmi2Type.CO_SIMULATION, guid=root.get("guid"),
                  cannot_use_memory_management_functions=True)
slave.setup_experiment(start_time=0.0)
slave.set_real([references[name] for name in START], list(START.values()))
slave.enter_initialization_mode()
slave.exit_initialization_mode()
outputs = [references[name] for name in OUTPUTS]
samples = [slave.get_real(outputs)]
for i in range(STEPS):
    slave.do_step(i * STEP, STEP)
    samples.append(slave.get_real(outputs))
slave.terminate()
slave.free_instance()
report("fmuloader", samples)

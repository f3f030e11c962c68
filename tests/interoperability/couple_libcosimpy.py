"""The SSP of two bearings in libcosim: `couple_libcosimpy.py FOLDER FILE` runs the unpacked SSP for a second and
writes the outputs as JSON, each as a hexadecimal number."""

import json
import sys

from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimObserver import CosimObserver

OUTPUTS = ["sensor.loadForce", "sensor.frictionTorque", "bearing.eccentricityRatio"]

execution = CosimExecution.from_ssp_file(ssp_path=sys.argv[1], step_size=1_000_000)  # ns
observer = CosimObserver.create_last_value()
execution.add_observer(observer)
assert execution.step(step_count=1000)
found = {}
for stand in ["first", "second"]:
    slave = execution.slave_index_from_instance_name(stand)
    references = {}
    for variable in execution.slave_variables(slave):
        name = variable.name
        references[name.decode() if isinstance(name, bytes) else name] = variable.reference
    values = observer.last_real_values(slave, [references[name] for name in OUTPUTS])
    found |= {f"{stand}.{name}": value.hex() for name, value in zip(OUTPUTS, values)}
with open(sys.argv[2], "w", encoding="utf-8") as file:
    json.dump(found, file)

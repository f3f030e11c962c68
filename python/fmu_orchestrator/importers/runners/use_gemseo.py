"""GEMSEO with its plugin for FMUs."""

import numpy as np
from gemseo_fmu.disciplines.fmu_discipline import FMUDiscipline
from scenario import FMU, OUTPUTS, START, STEP, STOP, report

discipline = FMUDiscipline(FMU, input_names=list(START), output_names=OUTPUTS,
                           initial_time=0.0, final_time=STOP, time_step=STEP)
result = discipline.execute({name: np.array([value]) for name, value in START.items()})
columns = []
for name in OUTPUTS:
    columns.append(result[name])
report("gemseo-fmu", list(zip(*columns)))

"""FMPy: simulate_fmu, as its users call it."""

import fmpy
from scenario import OUTPUTS, START, STEP, STOP, fmu, report

result = fmpy.simulate_fmu(fmu(), stop_time=STOP, step_size=STEP, output_interval=STEP,
                           start_values=START, output=OUTPUTS)
report("fmpy", [[row[name] for name in OUTPUTS] for row in result])

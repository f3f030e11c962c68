"""FMPy: simulate_fmu, as its users call it."""

import fmpy
from scenario import FMU, KIND, OUTPUTS, START, STEP, STOP, TOLERANCE, report

own = {"step_size": STEP} if KIND == "CoSimulation" else {"relative_tolerance": TOLERANCE}
result = fmpy.simulate_fmu(FMU, fmi_type=KIND, start_time=0.0, stop_time=STOP, output_interval=STEP, start_values=START,
                           output=OUTPUTS, record_events=False, **own)
report("fmpy", [[row[name] for name in OUTPUTS] for row in result])

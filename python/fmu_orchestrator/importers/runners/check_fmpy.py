"""FMPy's validation."""

from fmpy.validation import validate_fmu
from scenario import FMU, report

report("fmpy", findings=validate_fmu(FMU))

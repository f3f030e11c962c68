"""fmi4c, the library in C of Hopsan, by its own functions."""

import ctypes

from scenario import FMU, OUTPUTS, PROGRAM, REFERENCES, START, STEP, STEPS, VERSION, report

library, c = ctypes.CDLL(PROGRAM), ctypes.CDLL(None)
REAL, POINTER = ctypes.c_double, ctypes.c_void_p
OLD = VERSION == "2.0"
PREFIX = "fmi2_" if OLD else "fmi3_"


def call(name, *arguments, result=ctypes.c_int, most=1):
    function = getattr(library, name if name.startswith("fmi4c") else PREFIX + name)
    function.restype = result
    value = function(*arguments)
    assert result is POINTER or value <= most, f"{name}: status {value}"
    assert result is not POINTER or value, f"{name}: nothing"
    return POINTER(value)


def values(write, names, numbers):
    array = (REAL * len(names))(*numbers)
    references = (ctypes.c_uint * len(names))(*(REFERENCES[name] for name in names))
    size = ctypes.c_size_t(len(names))
    call(("set" if write else "get") + ("Real" if OLD else "Float64"), instance, references, size, array, *([] if OLD else [size]))
    return list(array)


@ctypes.CFUNCTYPE(None, POINTER, POINTER, ctypes.c_int, POINTER)
def silent(*_):
    """Takes messages and drops them."""


fmu = call("fmi4c_loadFmu", FMU.encode(), b"stand", result=POINTER)
if OLD:
    allocate, free = (ctypes.cast(function, POINTER) for function in (c.calloc, c.free))
    instance = call("instantiate", fmu, 1, silent, allocate, free, None, None, 0, 0, result=POINTER)
    call("setupExperiment", instance, 0, REAL(0.0), REAL(0.0), 0, REAL(0.0))
else:
    off = ctypes.c_bool(False)
    instance = call("instantiateCoSimulation", fmu, off, off, off, off, None, ctypes.c_size_t(0), None, silent, None, result=POINTER)
values(True, list(START), START.values())
if OLD:
    call("enterInitializationMode", instance)
else:
    call("enterInitializationMode", instance, off, REAL(0.0), REAL(0.0), off, REAL(0.0))
call("exitInitializationMode", instance)
samples = [values(False, OUTPUTS, [])]
for i in range(STEPS):
    told = [] if OLD else [ctypes.byref(kind()) for kind in (ctypes.c_bool, ctypes.c_bool, ctypes.c_bool, REAL)]
    done = call("doStep", instance, REAL(i * STEP), REAL(STEP), 1 if OLD else ctypes.c_bool(True), *told, most=2)
    samples.append(values(False, OUTPUTS, []))
    if done.value == 2:  # fmi2Discard: the FMU ends the simulation
        break
call("terminate", instance)
report("", samples)

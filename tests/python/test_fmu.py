"""The packaged FMU, seen by fmpy."""

import math
import subprocess
import sys
import zipfile

import fmpy
import fmpy.validation
import numpy as np
import pytest
from fmpy.fmi1 import FMICallException

OUTPUTS = ["sensor.loadForce", "sensor.frictionTorque", "sensor.bearingTemperature",
           "bearing.eccentricityRatio", "drive.angle"]


def test_the_validator_finds_nothing(fmu):
    assert fmpy.validation.validate_fmu(str(fmu)) == []


def test_the_archive_holds_what_importers_look_for(fmu):
    names = zipfile.ZipFile(fmu).namelist()
    for name in ["modelDescription.xml", "model.png", "documentation/index.html",
                 "binaries/linux64/PlainBearingStand.so"]:
        assert name in names
    assert all(not name.startswith("/") and ".." not in name for name in names)


def test_every_capability_is_declared(description):
    capabilities = description.coSimulation
    for name in ["canHandleVariableCommunicationStepSize", "canInterpolateInputs",
                 "canNotUseMemoryManagementFunctions", "canGetAndSetFMUstate",
                 "canSerializeFMUstate", "providesDirectionalDerivative"]:
        assert getattr(capabilities, name), name
    assert capabilities.maxOutputDerivativeOrder == 1
    assert not capabilities.canBeInstantiatedOnlyOncePerProcess


def test_units_are_defined(description):
    defined = {unit.name: {display.name for display in unit.displayUnits}
               for unit in description.unitDefinitions}
    for variable in description.modelVariables:
        if variable.type == "Real":
            assert variable.unit in defined, variable.name
            assert variable.displayUnit in {None, *defined[variable.unit]}, variable.name


def test_a_simulation_by_fmpy(fmu):
    result = fmpy.simulate_fmu(str(fmu), stop_time=2.0, output_interval=0.01, output=OUTPUTS,
                               validate=True)
    assert len(result) == 201
    assert all(np.isfinite(result[name]).all() for name in OUTPUTS)
    assert result["drive.angle"][-1] == pytest.approx(2.0 * 31.41592653589793, rel=1e-9)


def test_odd_step_sizes_neither_fail_nor_drift(stand):
    instance = stand().start(stop=2.0)
    for i in range(120):
        instance.doStep(i / 60.0, 1.0 / 60.0)
    assert instance.get("drive.angle")[0] == pytest.approx(2.0 * 31.41592653589793, rel=1e-12)


def run(instance, first, last, step=0.01):
    for i in range(first, last):
        instance.doStep(i * step, step)
    return instance.get(*OUTPUTS)


def test_saved_states_continue_bit_for_bit(stand):
    instance = stand().start()
    run(instance, 0, 50)
    state = instance.getFMUstate()
    expected = run(instance, 50, 100)
    instance.setFMUstate(state)
    assert run(instance, 50, 100) == expected
    data = instance.serializeFMUstate(state)
    instance.freeFMUstate(state)
    other = stand()
    copy = other.deSerializeFMUstate(data)
    other.setFMUstate(copy)
    other.freeFMUstate(copy)
    assert run(other, 50, 100) == expected


def test_saved_states_move_to_another_process(stand, unpacked, tmp_path):
    instance = stand().start()
    run(instance, 0, 50)
    state = instance.getFMUstate()
    (tmp_path / "state").write_bytes(instance.serializeFMUstate(state))
    instance.freeFMUstate(state)
    expected = run(instance, 50, 100)
    program = f"""
import sys
sys.path.insert(0, {str(__import__('pathlib').Path(__file__).parent)!r})
import fmpy, conftest, test_fmu
instance = conftest.FMU2Stand({str(unpacked)!r}, fmpy.read_model_description({str(unpacked)!r}))
state = instance.deSerializeFMUstate(open({str(tmp_path / 'state')!r}, 'rb').read())
instance.setFMUstate(state)
print([value.hex() for value in test_fmu.run(instance, 50, 100)])
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == str([value.hex() for value in expected])


def test_damaged_states_change_nothing(stand):
    instance = stand().start()
    run(instance, 0, 10)
    state = instance.getFMUstate()
    data = bytearray(instance.serializeFMUstate(state))
    expected = run(instance, 10, 20)
    instance.setFMUstate(state)
    instance.freeFMUstate(state)
    for damaged in [data[:-1], bytes(len(data)), data[:40] + bytes([data[40] ^ 1]) + data[41:]]:
        with pytest.raises(FMICallException):
            instance.deSerializeFMUstate(bytes(damaged))
    assert run(instance, 10, 20) == expected


def test_a_step_rejecting_master_rolls_back(stand):
    """Step doubling: a long step is compared with two short ones and taken back."""
    instance = stand().start()
    time, step, taken, rejected = 0.0, 0.05, 0, 0
    while 0.5 - time > 1e-9:
        step = min(step, 0.5 - time)
        state = instance.getFMUstate()
        instance.doStep(time, step)
        (long,) = instance.get("sensor.loadForce")
        instance.setFMUstate(state)
        instance.doStep(time, step / 2)
        instance.doStep(time + step / 2, step / 2)
        (short,) = instance.get("sensor.loadForce")
        if abs(long - short) > 1e-6 * abs(short):
            instance.setFMUstate(state)
            step /= 2
            rejected += 1
        else:
            time += step
            taken += 1
        instance.freeFMUstate(state)
        assert step > 1e-6
    plain = stand().start()
    run(plain, 0, 50)
    assert instance.get("drive.angle")[0] == pytest.approx(plain.get("drive.angle")[0], rel=1e-9)
    assert taken > 0


def test_directional_derivatives_are_the_differences(stand):
    instance = stand().start()
    run(instance, 0, 100)
    known = "load.externalForce"
    unknowns = ["sensor.loadForce", "sensor.frictionCoefficient", "sensor.frictionPower"]
    references = [instance.names[name] for name in unknowns]
    derivative = instance.getDirectionalDerivative(references, [instance.names[known]], [1.0])
    (force,) = instance.get(known)
    values = []
    for shift in [-0.5, 0.5]:
        instance.set(known, force + shift)
        values.append(instance.get(*unknowns))
    for name, ours, low, high in zip(unknowns, derivative, *values):
        assert ours == pytest.approx(high - low, rel=1e-4, abs=1e-12), name


def test_inputs_with_slopes_beat_held_inputs(stand):
    """A speed ramp: with slopes the shaft angle is the ramp's integral, without it lags behind."""
    start, rate, step = 31.41592653589793, 5.0, 0.1
    instance = stand().start()
    reference = instance.names["drive.speed"]
    for i in range(10):
        instance.setReal([reference], [start + rate * i * step])
        instance.setRealInputDerivatives([reference], [1], [rate])
        instance.doStep(i * step, step)
    exact = start + rate / 2
    assert instance.get("drive.angle")[0] == pytest.approx(exact, rel=1e-9)
    held = stand().start()
    for i in range(10):
        held.set("drive.speed", start + rate * i * step)
        held.doStep(i * step, step)
    assert held.get("drive.angle")[0] == pytest.approx(exact - rate * step / 2, rel=1e-9)


def test_output_derivatives(stand):
    instance = stand().start()
    run(instance, 0, 100)
    rate = instance.getRealOutputDerivatives([instance.names["sensor.loadForce"]], [1])
    (before,) = instance.get("sensor.loadForce")
    instance.doStep(1.0, 1e-5)
    (after,) = instance.get("sensor.loadForce")
    assert list(rate)[0] == pytest.approx((after - before) / 1e-5, rel=1e-3)


def test_reset_is_a_new_start(stand):
    instance = stand().start()
    first = run(instance, 0, 20)
    instance.reset()
    instance.start()
    assert run(instance, 0, 20) == first


@pytest.mark.parametrize(("name", "value"), [
    ("bearing.radialClearance", -1e-5), ("bearing.width", math.nan), ("oil.density15", math.inf),
    ("sensor.loadForce", 1.0),
])
def test_unusable_values_are_refused(stand, name, value):
    instance = stand()
    instance.setupExperiment(startTime=0.0)
    instance.enterInitializationMode()
    with pytest.raises(FMICallException):
        instance.set(name, value)


STEADY = ["sensor.oilTemperature", "sensor.bearingTemperature"]


def test_a_steady_start_stays(stand):
    """The temperatures at the start of a turn are those at its end."""
    instance = stand()
    instance.setInteger([instance.names["thermal.initialization"]], [2])
    instance.start(thermal__initialBearingTemperature=330.0)
    begin = instance.get(*STEADY)
    assert begin == pytest.approx([321.16, 355.15], abs=0.02)
    for i in range(20):
        instance.doStep(0.01 * i, 0.01)
    assert instance.get(*STEADY) == pytest.approx(begin, abs=1e-7)
    assert instance.get("thermal.slowestTimeConstant")[0] == pytest.approx(2837, rel=0.01)


def test_a_steady_start_that_does_not_exist_is_an_error(stand):
    instance = stand()
    instance.setInteger([instance.names["thermal.initialization"]], [2])
    with pytest.raises(FMICallException):
        instance.start(thermal__oilAmbientConductance=0.0)


def test_termination_twice_and_reading_after_it(stand):
    instance = stand().start()
    before = run(instance, 0, 5)
    instance.terminate()
    with pytest.raises(FMICallException):
        instance.terminate()
    assert instance.get(*OUTPUTS) == before

"""The examples do what they say."""

import sys

import numpy as np
import pytest
from conftest import ROOT

EXAMPLES = ROOT / "examples"


@pytest.fixture(autouse=True)
def importable(fmu, monkeypatch):
    """The examples are scripts beside each other."""
    monkeypatch.syspath_prepend(str(EXAMPLES))
    for name in ["common", "speed_profile", "dynamic_load", "step_rejection", "two_bearings"]:
        sys.modules.pop(name, None)


def test_a_speed_profile_drives_the_shaft():
    import speed_profile as example
    exact = np.trapezoid(example.SPEEDS, example.TIMES)
    result = example.run()
    assert result["drive.angle"][-1] == pytest.approx(exact, rel=1e-3)
    assert result["drive.shaftSpeed"][700] == pytest.approx(3000 * example.RPM)
    assert result["bearing.contactShare"][100] > result["bearing.contactShare"][700]
    assert example.with_slopes()["drive.angle"] == pytest.approx(exact, rel=1e-9)


def test_a_dynamic_load_presses_the_film_thinner():
    import dynamic_load as example
    result = example.run(stop=0.4)
    time, load = result["time"], result["sensor.loadForce"]
    # The outputs come after a step, with the force that was held during it.
    pushed = example.force(np.round(time - 0.001, 9))
    assert load[1:] - pushed[1:] == pytest.approx(743.5, abs=60)
    assert result["bearing.eccentricityRatio"][215] > result["bearing.eccentricityRatio"][199] + 0.05
    assert result["bearing.maxFilmPressure"].max() > 4 * np.median(result["bearing.maxFilmPressure"])


def test_a_master_takes_steps_back():
    import step_rejection as example
    coupled, steps, rejected = example.run(stop=0.1)
    assert rejected > 5 and len(steps) > 10
    assert sum(length for _, length in steps) == pytest.approx(0.1)
    # The same in steps of a fixed length, so short that it does not matter.
    fine = example.Coupled()
    for i in range(5000):
        fine.step(i * 2e-5, 2e-5)
    error = abs(coupled.mass[0] - fine.mass[0])
    assert error < 0.1 * abs(fine.mass[0])
    # A hundredth of the tolerance takes ten times the steps, as the method is of first order.
    closer, more, _ = example.run(stop=0.1, tolerance=0.01 * example.TOLERANCE)
    assert len(more) > 5 * len(steps)
    assert abs(closer.mass[0] - fine.mass[0]) < 0.3 * error


def test_two_bearings_share_a_shaft():
    import two_bearings as example
    result = example.run(example.pack(), stop=0.2)
    first, second = result["first.sensor.loadForce"], result["second.sensor.loadForce"]
    assert len(result) >= 200 and np.ptp(first) > 20
    # An output of one stand reaches the other one at the next communication point.
    assert second[2:] == pytest.approx(first[1:-1], rel=1e-12)
    # The wider bearing runs more centrally.
    assert (result["second.bearing.eccentricityRatio"][50:] < result["first.bearing.eccentricityRatio"][50:]).all()

"""Unit systems of FMUs through the program: a value that is set in one unit arrives in the variable's own unit as the arithmetic of FMI
2.0.4, 2.2.2, gives it from the BaseUnits, or is refused. What people's names mean comes from scipy; fractions keep all digits.

    base = factor value + offset,   display = factor value + offset
"""

import csv
import subprocess
import zipfile
from fractions import Fraction as F
from math import pi

import pytest
from functions import SOURCE
from scipy import constants as c
from test_acceptance import PROGRAM

BASE = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")
TURN = 2 * pi
KINDS = {"length": {"m": 1}, "time": {"s": 1}, "frequency": {"s": -1}, "temperature": {"K": 1}, "mass": {"kg": 1}, "angle": {"rad": 1},
         "turning": {"s": -1, "rad": 1}, "speed": {"m": 1, "s": -1}, "acceleration": {"m": 1, "s": -2}, "force": {"kg": 1, "m": 1, "s": -2},
         "energy": {"kg": 1, "m": 2, "s": -2}, "power": {"kg": 1, "m": 2, "s": -3}, "pressure": {"kg": 1, "m": -1, "s": -2},
         "flow": {"m": 3, "s": -1}, "mass flow": {"kg": 1, "s": -1}, "number": {}, "inertia": {"kg": 1, "m": 2}}
# What people mean by a name: kind, factor and offset.
USUAL = {"1": ("number", 1), "%": ("number", c.centi), "m": ("length", 1), "cm": ("length", c.centi), "mm": ("length", c.milli), "um": ("length", c.micro),
         "s": ("time", 1), "h": ("time", c.hour), "Hz": ("frequency", 1), "1/s": ("frequency", 1), "rad/s": ("turning", 1), "rpm": ("turning", TURN / c.minute),
         "K": ("temperature", 1), "degC": ("temperature", 1, c.zero_Celsius), "°C": ("temperature", 1, c.zero_Celsius),
         "degF": ("temperature", c.degree_Fahrenheit, c.convert_temperature(0, "F", "K")), "kg": ("mass", 1), "g": ("mass", c.gram),
         "m/s": ("speed", 1), "km/h": ("speed", c.kmh), "m/s2": ("acceleration", 1), "N": ("force", 1), "kN": ("force", c.kilo), "J": ("energy", 1),
         "N.m": ("energy", 1), "kWh": ("energy", c.kilo * c.hour), "W": ("power", 1), "kW": ("power", c.kilo), "Pa": ("pressure", 1), "MPa": ("pressure", c.mega),
         "bar": ("pressure", c.bar), "psi": ("pressure", c.psi), "m3/h": ("flow", 1 / c.hour), "l/min": ("flow", c.liter / c.minute), "kg/s": ("mass flow", 1)}


def unit(name, *display, factor=1, offset=0, **exponents):
    """A unit with a BaseUnit and display units."""
    return name, {"factor": factor, "offset": offset, **exponents}, display


def bare(name, *display):
    """A unit without one."""
    return name, None, display


def usual(name):
    kind, factor, *offset = USUAL[name]
    return KINDS[kind], factor, *(offset or [0])


def meaning(system, name):
    """What the FMU says that a name means: exponents, factor and offset; none where it does not."""
    for own, base, display in system:
        if base is None:
            continue
        exponents = {key: power for key, power in base.items() if key in BASE and power}
        if own == name:
            return exponents, base["factor"], base["offset"]
        for shown, factor, offset in display:
            if shown == name:
                # unit = (display - offset) / factor; base = factor unit + offset.
                return exponents, base["factor"] / factor, base["offset"] - base["factor"] * offset / factor
    return None


def expected(system, given, own, value):
    """The value in the variable's own unit; none where the units are of different kinds."""
    if given == own:
        return value
    for name, _, display in system:
        for shown, factor, offset in display:
            if (name, shown) == (own, given):
                return (value - offset) / factor
    (exponents, factor, offset), (wanted, below, less) = (meaning(system, name) or usual(name) for name in (given, own))
    return (factor * value + offset - less) / below if exponents == wanted else None


METRE = unit("m", ("mm", 1000, 0), m=1)
KELVIN = unit("K", ("degC", 1, -273.15), K=1)
REFUSED = "refused"
# Units of the FMU; values with a unit that are set; the variable's unit; what comes out, where scipy and the standard do not say.
SYSTEMS = {
    # Usual.
    "length": ([METRE], [("5 mm", "m"), ("5 um", "m"), ("2 cm", "m"), ("1 s", "m", REFUSED)]),
    "temperature": ([KELVIN], [("20 degC", "K"), ("20 °C", "K"), ("212 degF", "K"), ("300 K", "K"), ("1 m", "K", REFUSED)]),
    "pressure": ([unit("Pa", ("bar", 1e-5, 0), kg=1, m=-1, s=-2)], [("1.5 bar", "Pa"), ("2 MPa", "Pa"), ("30 psi", "Pa"), ("1 N", "Pa", REFUSED)]),
    "torque": ([unit("N.m", kg=1, m=2, s=-2)], [("5 N.m", "N.m"), ("2 J", "N.m"), ("1 kWh", "N.m"), ("1 W", "N.m", REFUSED)]),
    "speed": ([unit("rad/s", ("rpm", 60 / TURN, 0), s=-1, rad=1)], [("60 rpm", "rad/s"), ("1 Hz", "rad/s", REFUSED)]),
    "flow": ([unit("m3/s", m=3, s=-1)], [("3600 m3/h", "m3/s"), ("60 l/min", "m3/s"), ("1 kg/s", "m3/s", REFUSED)]),
    # Unusual names and sizes.
    "tonne": ([unit("t", factor=1000, kg=1)], [("500 kg", "t"), ("2 t", "t"), ("3 g", "t"), ("1 m", "t", REFUSED)]),
    "calories": ([unit("kcal", factor=4184, kg=1, m=2, s=-2)], [("4184 J", "kcal"), ("1 kWh", "kcal")]),
    "furlong": ([unit("furlong", factor=201.168, m=1)], [("201.168 m", "furlong"), ("1 mm", "furlong"), ("1 m/s", "furlong", REFUSED)]),
    "downward": ([METRE, unit("depth", factor=-1, m=1)], [("3 depth", "m"), ("3 m", "depth"), ("40 mm", "depth")]),
    "own display": ([unit("W", ("dogpower", F(1, 250), 0), kg=1, m=2, s=-3)], [("2 dogpower", "W"), ("1 kW", "W")]),
    # Contradictory: other than people's names.
    "frequency": ([unit("1/s", s=-1), unit("rad/s", s=-1, rad=1)], [("1 1/s", "rad/s", REFUSED), ("1 rad/s", "1/s", REFUSED),
                  ("60 rpm", "1/s", 1.0), ("60 rpm", "rad/s", TURN)]),
    "h is a height": ([unit("h", m=1)], [("60 s", "h", REFUSED), ("60 mm", "h"), ("3 h", "h")]),
    "g is gravity": ([unit("g", factor=9.81, m=1, s=-2)], [("1 kg", "g", REFUSED), ("9.81 m/s2", "g")]),
    "a day of ten hours": ([unit("s", s=1), unit("d", factor=36000, s=1)], [("2 d", "s"), ("3600 s", "d"), ("1 h", "d")]),
    "min is an arc": ([unit("rad", ("min", 3437.75, 0), rad=1), unit("s", s=1)], [("1 min", "s", REFUSED), ("3437.75 min", "rad"), ("2 s", "s")]),
    "a per cent of a metre": ([METRE, unit("%", factor=0.01, m=1)], [("5 %", "m"), ("5 %", None, REFUSED)]),
    "mm is not what it is": ([unit("m", ("mm", 100, 0), m=1)], [("5 mm", "m"), ("5 cm", "m")]),
    # Offsets.
    "celsius as a unit": ([unit("cel", offset=273.15, K=1)], [("20 degC", "cel"), ("293.15 K", "cel"), ("68 degF", "cel")]),
    "rankine": ([unit("R", ("F", 1, -459.67), factor=F(5, 9), K=1)], [("0 degC", "R"), ("32 F", "R"), ("273.15 K", "R")]),
    "gauge pressure": ([unit("barg", factor=1e5, offset=101325, kg=1, m=-1, s=-2)], [("201325 Pa", "barg"), ("1.01325 bar", "barg")]),
    "fahrenheit as a unit": ([KELVIN, unit("degF", factor=F(5, 9), offset=459.67 * 5 / 9, K=1)], [("212 degF", "K"), ("100 degC", "degF"), ("0 K", "degF")]),
    # rad, with and without.
    "rad left out": ([unit("rad/s", s=-1)], [("60 rpm", "rad/s", TURN), ("2 rad/s", "rad/s")]),
    "rpm without rad": ([unit("rpm", factor=TURN / 60, s=-1)], [("6 rpm", "rpm"), (f"{TURN} rad/s", "rpm", 60.0)]),
    "rpm as a frequency": ([unit("rpm", factor=F(1, 60), s=-1)], [("1 Hz", "rpm"), ("3 rpm", "rpm")]),
    "a name that says nothing": ([unit("omega", s=-1)], [("60 rpm", "omega", REFUSED), ("2 omega", "omega"), ("2 Hz", "omega")]),
    "degrees": ([unit("rad", ("deg", 360 / TURN, 0), rad=1)], [("180 deg", "rad"), ("1 m", "rad", REFUSED)]),
    # Per cent and no unit.
    "no units": ([], [("5 %", None), ("0.5 1", None), ("5 m", None, REFUSED)]),
    "per cent": ([unit("%", factor=0.01)], [("5 %", None), ("0.05 1", "%"), ("5 %", "%")]),
    "parts": ([unit("ppm", factor=1e-6), unit("%", factor=0.01)], [("7 ppm", "%"), ("7 ppm", None), ("1 %", "ppm")]),
    # Incomplete.
    "no BaseUnit": ([bare("N.m")], [("1 J", "N.m"), ("5 N.m", "N.m"), ("1 N", "N.m", REFUSED)]),
    "display without BaseUnit": ([bare("K", ("degC", 1, -273.15))], [("20 degC", "K"), ("32 degF", "K")]),
    "unknown": ([bare("foo")], [("3 foo", "foo"), ("1 m", "foo", REFUSED), ("1 bar", "foo", REFUSED)]),
    "a unit that is only named": ([], [("2 kN", "N"), ("1 Pa", "N", REFUSED)]),
    "a factor of 0": ([unit("m", factor=0, m=1)], [("5 mm", "m", REFUSED), ("5 m", "m")]),
    # Ten more, chosen after the program was written.
    "degC without K": ([unit("degC", offset=273.15, K=1)], [("300 K", "degC"), ("20 degC", "degC"), ("68 degF", "degC")]),
    "degC without BaseUnit": ([bare("degC")], [("300 K", "degC"), ("68 degF", "degC")]),
    "own rpm of a frequency": ([unit("Hz", ("rpm", 60, 0), s=-1)], [("120 rpm", "Hz"), ("2 1/s", "Hz")]),
    "two of one kind": ([unit("N.m", kg=1, m=2, s=-2), unit("J", ("cal", F(1000, 4184), 0), kg=1, m=2, s=-2)], [("3 J", "N.m"), ("1 cal", "N.m")]),
    "deg in two units": ([unit("K", ("deg", 1, -273.15), K=1), unit("rad", ("deg", 360 / TURN, 0), rad=1)], [("20 deg", "K"), ("180 deg", "rad")]),
    "a dash": ([unit("-"), unit("%", factor=0.01)], [("5 %", "-"), ("3 1", "-"), ("4 -", None, 4.0)]),
    "a rise": ([("K", {"K": 1}, [("degC", 1, -273.15)])], [("10 degC", "K relative", 10.0), ("10 degC", "K"), ("9 degF", "K relative", 5.0)]),
    "moles": ([unit("kmol", factor=1000, mol=1), unit("mol", mol=1)], [("2 kmol", "mol"), ("3 mol", "kmol"), ("1 kg", "mol", REFUSED)]),
    "a force by mistake": ([unit("Nm", kg=1, m=1, s=-2)], [("2 kN", "Nm"), ("1 J", "Nm", REFUSED), ("1 N.m", "Nm", REFUSED)]),
    "signs of products": ([unit("kg·m²", kg=1, m=2)], [("3 kg.m2", "kg·m²", 3.0)]),
    "knots shown": ([unit("m/s", ("kn", F(3600, 1852), 0), m=1, s=-1)], [("10 kn", "m/s"), ("36 km/h", "m/s")]),
}


def definition(name, base, display):
    said = "" if base is None else "<BaseUnit " + " ".join(f'{key}="{float(v) if key in ("factor", "offset") else v!s}"' for key, v in base.items()) + "/>"
    shown = "".join(f'<DisplayUnit name="{one}" factor="{float(factor)!r}" offset="{float(offset)!r}"/>' for one, factor, offset in display)
    return f'<Unit name="{name}">{said}{shown}</Unit>'


@pytest.fixture(scope="module")
def binary(tmp_path_factory):
    made = tmp_path_factory.mktemp("units") / "functions.so"
    subprocess.run(["cc", "-shared", "-fPIC", "-O2", "-o", made, SOURCE, "-lm"], check=True)
    return made


def pack(path, binary, system, asked):
    """An FMU whose output n is its parameter n, in the unit of the nth question."""
    units = [(own or "").split(" ") for _, own, *_ in asked]
    variables = "".join(f'<ScalarVariable name="x{n}" valueReference="{n}" causality="parameter" variability="fixed"><Real start="0.5"'
                        f'{f""" unit="{own}" """ if own else ""}{""" relativeQuantity="true" """ if relative else ""}/></ScalarVariable>'
                        for n, (own, *relative) in enumerate(units, 1))
    missing = dict.fromkeys(own for own, *_ in units if own and own not in [one[0] for one in system])
    defined = "".join([*(definition(*one) for one in system), *(definition(own, None, ()) for own in missing)])
    with zipfile.ZipFile(path, "w") as fmu:
        fmu.writestr("modelDescription.xml", f"""<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="Units" guid="functions"><CoSimulation modelIdentifier="functions"/>
{f"<UnitDefinitions>{defined}</UnitDefinitions>" if defined else ""}
<DefaultExperiment startTime="0" stopTime="1" stepSize="1"/><ModelVariables>{variables}</ModelVariables><ModelStructure/></fmiModelDescription>""")
        fmu.write(binary, "binaries/linux64/functions.so")


def simulated(path, sets, count):
    names = ",".join(f"x{n}" for n in range(1, count + 1))
    asked = [PROGRAM, "simulate", path, "--record", names, *(f"--set={one}" for one in sets)]
    return subprocess.run(asked, capture_output=True, text=True, timeout=60)


def test_there_are_thirty_systems_and_ten_more():
    assert len(SYSTEMS) >= 40


@pytest.mark.parametrize("name", SYSTEMS)
def test_values_arrive_as_the_standard_says_or_are_refused(tmp_path, binary, name):
    system, asked = SYSTEMS[name]
    path = tmp_path / "units.fmu"
    pack(path, binary, system, asked)
    sets, results = [], {}
    for n, (given, own, *other) in enumerate(asked, 1):
        value, _, in_unit = given.partition(" ")
        result = other[0] if other else expected(system, in_unit, own or "1", float(value))
        assert result is not None, f"{given}: say what is expected"
        if result == REFUSED:
            done = simulated(path, [f"x{n}={given}"], len(asked))
            assert done.returncode == 2 and f"unit `{in_unit}`" in done.stderr, (given, own, done.stdout, done.stderr)
        else:
            sets.append(f"x{n}={given}")
            results[f"x{n}"] = result
    done = simulated(path, sets, len(asked))
    assert done.returncode == 0, done.stderr
    row = {key.split(" ")[0]: value for key, value in list(csv.DictReader(done.stdout.splitlines()))[-1].items()}
    for (key, result), one in zip(results.items(), sets, strict=True):
        assert float(row[key]) == pytest.approx(float(result), rel=1e-9, abs=1e-9), (name, one)

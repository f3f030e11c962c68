"""A live report simulates fresh points in the page, and comes to what the program does.

Needs Chromium and its driver (Debian: chromium, chromium-driver), the selenium package, and an FMU with its WebAssembly module:
`scripts/package-fmu --web`.
"""

import csv
import json
import re
import subprocess
import zipfile

import pytest
from small_modules import ENDLESS, TRAP, constant, with_module
from small_modules import module as small_module
from test_acceptance import PROGRAM
from test_report import browser, pytestmark  # noqa: F401

STUDY = """
fmu = "{fmu}"
[simulation]
stop = 150
step = 150
{simulation}
[design]
method = "monte-carlo"
points = {points}
[parameters."bearing.radialClearance"]
distribution = "truncated-normal"
mean = 0.020
deviation = 0.005
min = 0.002
unit = "mm"
[parameters."load.preload"]
distribution = "normal"
mean = 48
deviation = 5.5
unit = "N"
[parameters."load.stiffness"]
distribution = "triangular"
min = 70
mode = 100
max = 130
unit = "N/m"
[parameters."drive.speed"]
distribution = "uniform"
min = 290
max = 310
unit = "rpm"
[fixed]
"bearing.roughness" = "0.5 um"
[criteria.T_bearing]
variable = "sensor.bearingTemperature"
nominal = 82
tolerance = "0.75 %"
uncertainty = "0.3 degC"
unit = "degC"
{criteria}
"""
FINAL = """
[criteria.P]
variable = "sensor.frictionPower"
nominal = 14
tolerance = "20 %"
uncertainty = 0.9
unit = "W"
"""
OVER_TIME = "".join(f"""
[criteria.{statistic}]
variable = "sensor.loadForce"
statistic = "{statistic}"
nominal = 750
tolerance = 500
uncertainty = 10
unit = "N"
""" for statistic in ("mean", "min", "max", "rms", "amplitude"))


def program(*arguments):
    return subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True)


@pytest.fixture(scope="module")
def module(fmu):
    with zipfile.ZipFile(fmu) as archive:
        if not any(name.startswith("extra/") and name.endswith(".wasm") for name in archive.namelist()):
            pytest.skip("the FMU has no WebAssembly module; scripts/package-fmu --web adds it")
    return fmu


def live(folder, fmu, points=60, simulation="", criteria=FINAL):
    study = folder / "study.toml"
    study.write_text(STUDY.format(fmu=fmu, points=points, simulation=simulation, criteria=criteria))
    done = program("verify", study, "--output", folder / "out")
    assert done.returncode in (0, 1, 3), done.stderr
    done = program("report", folder / "out", "--live")
    assert done.returncode == 0, done.stderr
    return folder / "out" / "report.html"


ASK = "const done = arguments[1]; WhatIf.askFresh(arguments[0]).then(done, error => done(String(error)))"
# In study units; the triangular and the uniform parameter stay.
CHANGE = {"parameters": {"bearing.radialClearance": {"mean": 0.0215, "deviation": 0.004}, "load.preload": {"mean": 50, "deviation": 5}}}


@pytest.mark.parametrize("simulation, criteria", [("", FINAL), ("window = 20", OVER_TIME + FINAL)], ids=["final", "over time"])
def test_fresh_points_are_those_of_the_program(browser, tmp_path, module, simulation, criteria):  # noqa: F811
    """2,000 points, each value within 1e-12; `pytest -s` shows how long they took, and the page's size."""
    text = live(tmp_path, module, simulation=simulation, criteria=criteria)
    browser.get(text.as_uri())
    browser.set_script_timeout(300)
    asked = [browser.execute_async_script(ASK, CHANGE) for _ in range(3)]
    found = asked[-1]
    print(f"{len(found['values'][0])} points in {[round(one['milliseconds']) for one in asked]} ms; {text.stat().st_size / 1e6:.2f} MB")
    names = [column["name"] for column in browser.execute_script("return JSON.parse(document.getElementById('data').textContent).columns")]
    count = len(found["parameters"])
    table = tmp_path / "fresh.csv"
    with table.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["point", *names[:count]])
        writer.writerows([k + 1, *map(repr, row)] for k, row in enumerate(zip(*found["parameters"], strict=True)))
    done = program("verify", tmp_path / "study.toml", "--points-from", table, "--output", tmp_path / "again")
    assert done.returncode in (0, 1, 3), done.stderr
    with (tmp_path / "again" / "points.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == len(found["values"][0]) == 2000
    worst = 0
    for name, values in zip(names[count:], found["values"], strict=True):
        for row, value in zip(rows, values, strict=True):
            own = float(row[name]) if row[name] else None
            assert (own is None) == (value is None), f"{name} of point {row['point']}: {own} and {value}"
            if own is not None:
                worst = max(worst, abs(value - own) / max(abs(own), 1e-3))
    print(f"largest relative deviation {worst:.1e}")
    assert worst <= 1e-12
    summary = json.loads((tmp_path / "again" / "summary.json").read_text())
    assert (found["verdict"], found["accepted"]) == (summary["verdict"], summary["accepted"])
    assert [own["passed"] for own in found["criteria"]] == [own["passed"] for own in summary["criteria"].values()]
    means = [sum(list_) / 2000 for list_ in found["parameters"]]
    assert means == pytest.approx([0.0215, 50, 100, 300], rel=0.01)
    assert browser.get_log("browser") == []


def test_a_slider_simulates_and_the_mouse_draws(browser, tmp_path, module):  # noqa: F811
    browser.get(live(tmp_path, module, points=200).as_uri())
    browser.execute_script("""document.querySelectorAll('#whatif details').forEach(d => { d.open = true; });
      const s = document.querySelector('#whatif .parameters input[type=range]'); s.value = 0.4; s.dispatchEvent(new Event('input'))""")
    wait = """const done = arguments[0], begun = Date.now(), look = () => {
      const text = document.querySelector('#whatif .caution').textContent;
      if (text.includes('fresh points of the changed') || Date.now() - begun > 60000) done(text); else setTimeout(look, 50);
    }; look()"""
    browser.set_script_timeout(90)
    assert "From 2000 fresh points" in browser.execute_async_script(wait)
    assert browser.execute_script("return document.querySelector('#whatif .outcome').textContent").startswith("What if: ")
    # The plots count their own points, not the fresh ones.
    browser.execute_async_script("const done = arguments[0]; setTimeout(done, 300)")
    counts = browser.execute_script("return document.querySelector('figure.plane svg').textContent")
    points, accepted = (int(number) for number in re.search(r"(\d+) points.*?(\d+) accepted", counts).groups())
    assert points == 200 and accepted <= 200
    trace = """const done = arguments[0], svg = document.querySelector('figure.plane svg');
      svg.focus(); svg.dispatchEvent(new KeyboardEvent('keydown', { key: 'ArrowRight' }));
      const begun = Date.now(), look = () => {
        const paths = [...document.querySelectorAll('#tip .traces path')];
        if (paths.length === 2 || Date.now() - begun > 30000) done(paths.map(p => p.getAttribute('d').split('L').length)); else setTimeout(look, 50);
      }; look()"""
    assert browser.execute_async_script(trace) == [201, 201]
    assert browser.get_log("browser") == []


@pytest.fixture(scope="module")
def page(tmp_path_factory, module):
    return live(tmp_path_factory.mktemp("page"), module, points=200)


@pytest.mark.parametrize("other, trouble", [
    (b"no module", "expected magic word"),
    (small_module(imports=True), "Import #0"),
    (small_module(without=["DoStep"]), "the module does not export fmi2DoStep"),
    # Each new module takes address space: a browser refuses more than some hundred of them.
    (small_module({"DoStep": TRAP}), "each of them failed"),
    (small_module({"DoStep": constant(3)}), "each of them failed"),
    (small_module({"Instantiate": constant(0)}), "each of them failed"),
    # GetReal writes nothing.
    (small_module(), "each of them failed"),
    (small_module({"DoStep": ENDLESS}), "does not end a simulation"),
], ids=["no module", "imports", "no function", "trap", "error", "refused", "no results", "endless"])
def test_a_module_that_does_not_work_leaves_the_weights_and_the_page_says_why(browser, tmp_path, page, other, trouble):  # noqa: F811
    changed = tmp_path / "report.html"
    changed.write_text(with_module(page.read_text(), other))
    browser.get(changed.as_uri())
    browser.execute_script("""document.querySelectorAll('#whatif details').forEach(d => { d.open = true; });
      const s = document.querySelector('#whatif .parameters input[type=range]'); s.value = 0.4; s.dispatchEvent(new Event('input'))""")
    wait = """const done = arguments[0], begun = Date.now(), look = () => {
      const text = document.querySelector('#whatif .caution').textContent;
      if (/could not|simulated here/.test(text) || Date.now() - begun > 120000) done(text); else setTimeout(look, 50);
    }; look()"""
    browser.set_script_timeout(150)
    told = browser.execute_async_script(wait)
    assert "Other distributions by weights" in told and trouble in told
    assert browser.get_log("browser") == []


def test_points_that_fail_are_counted_and_the_page_says_so(browser, tmp_path, module):  # noqa: F811
    """Clearances of less than nothing are outside of the description's limits."""
    study = STUDY.replace('"truncated-normal"\nmean = 0.020\ndeviation = 0.005\nmin = 0.002', '"normal"\nmean = 0.007\ndeviation = 0.005')
    (tmp_path / "study.toml").write_text(study.format(fmu=module, points=200, simulation="", criteria=FINAL))
    program("verify", tmp_path / "study.toml", "--output", tmp_path / "out")
    assert program("report", tmp_path / "out", "--live").returncode == 0
    browser.get((tmp_path / "out" / "report.html").as_uri())
    browser.set_script_timeout(120)
    found = browser.execute_async_script(ASK, {"parameters": {"bearing.radialClearance": {"mean": 0.006, "deviation": 0.005}}})
    outside = sum(value < 0 for value in found["parameters"][0])
    assert found["failed"] >= outside > 50
    told = browser.execute_script("return document.querySelector('#whatif .caution').textContent")
    assert f"{found['failed']} failed and count as not accepted" in told


def test_what_a_cut_leaves_of_a_distribution_is_drawn_at_once(browser, page):  # noqa: F811
    """Beyond six deviations, of which one in 10^9 numbers lies; by rejection that takes hours."""
    browser.get(page.as_uri())
    browser.set_script_timeout(30)
    draw = """const [min, max] = arguments; let seed = 0.5;
      const uniform = () => { seed = (seed + 0.6180339887498949) % 1; return seed; };
      return Array.from({ length: 2000 }, () => Live.drawn({ distribution: 'truncated-normal', mean: 10, deviation: 2, min, max }, uniform))"""
    for ends, sign in (((22, None), 1), ((None, -2), -1)):
        values = [sign * (value - 10) / 2 for value in browser.execute_script(draw, *ends)]
        assert min(values) >= 6
        # Density by upper tail at 6, by the asymptotic series (Abramowitz and Stegun 26.2.12).
        assert sum(values) / 2000 == pytest.approx(6.1584, abs=0.01)


def test_without_a_module_the_message_says_so(tmp_path, fmu):
    bare = tmp_path / "bare.fmu"
    with zipfile.ZipFile(fmu) as archive, zipfile.ZipFile(bare, "w") as other:
        for name in archive.namelist():
            if not name.endswith(".wasm"):
                other.writestr(name, archive.read(name))
    (tmp_path / "study.toml").write_text(STUDY.format(fmu=bare, points=5, simulation="", criteria=FINAL))
    program("verify", tmp_path / "study.toml", "--output", tmp_path / "out")
    done = program("report", tmp_path / "out", "--live")
    assert done.returncode == 2
    assert "has no WebAssembly module" in done.stderr and "PlainBearingStand.wasm" in done.stderr

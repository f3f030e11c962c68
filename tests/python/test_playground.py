"""The page of the stand: it runs offline, fits small screens, and shows what the FMU computes.

Needs Chromium and its driver, and an FMU with its WebAssembly module: `scripts/package-fmu --web`.
"""

import csv
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest
from test_acceptance import PROGRAM
from test_report import barriers, browser, pytestmark  # noqa: F401

ROOT = Path(__file__).resolve().parents[2]
STATE = """const done = arguments[0], begun = Date.now(), look = () => {
  if (/simulated|cannot/.test(document.getElementById('state').textContent) || Date.now() - begun > 60000)
    done([document.getElementById('state').textContent, Playground.last()]);
  else setTimeout(look, 50);
}; look()"""
SPEED = """const s = document.querySelector('input[data-name="drive.speed"]'); document.getElementById('state').textContent = '';
  s.value = s.max; s.dispatchEvent(new Event('input'));"""


@pytest.fixture(scope="module")
def module(fmu):
    with zipfile.ZipFile(fmu) as archive:
        if not any(name.startswith("extra/") and name.endswith(".wasm") for name in archive.namelist()):
            pytest.skip("the FMU has no WebAssembly module; scripts/package-fmu --web adds it")
    return fmu


def simulated(fmu, folder, **values):
    settings = [part for name, value in values.items() for part in ("--set", f"{name.replace('__', '.')}={value}")]
    path = folder / "run.csv"
    subprocess.run([PROGRAM, "simulate", fmu, "--stop", "150", "--step", "1", *settings, "--output", path], check=True, stdout=subprocess.DEVNULL)
    with path.open() as file:
        return list(csv.DictReader(file))[-1]


def test_the_page_shows_what_the_fmu_computes(browser, tmp_path, module):  # noqa: F811
    subprocess.run([sys.executable, ROOT / "scripts/playground"], check=True)
    browser.get((ROOT / "dist/playground.html").as_uri())
    for change, settings in (("", {}), (SPEED, {"drive__speed": "1500 rpm"})):
        browser.execute_script(change)
        state, found = browser.execute_async_script(STATE)
        assert "simulated in" in state
        row = simulated(module, tmp_path, **settings)
        assert found["oil"] + 273.15 == pytest.approx(float(row["sensor.oilTemperature"]), rel=1e-9)
        assert found["bearing"] + 273.15 == pytest.approx(float(row["sensor.bearingTemperature"]), rel=1e-9)
        assert found["torque"] == pytest.approx(float(row["sensor.frictionTorque"]), rel=1e-6)
        # The field of the Reynolds equation against the map of the FMU, which was made of such fields.
        field, largest = found["pressure"]
        assert field == pytest.approx(largest, rel=0.02)
        assert len(found["curve"]) == 24
        labels = browser.execute_script("return ['pressure', 'stribeck', 'temperature', 'torque'].map(id => [...document.querySelectorAll(`#${id} text`)].map(t => t.textContent))")
        for texts in labels:
            assert len(texts) == len(set(texts)) or texts.count("0") <= 2, texts
        assert browser.execute_script("return document.querySelectorAll('.plots svg .one').length") >= 5
    for width in (400, 1280):
        browser.set_window_size(width, 900)
        assert browser.execute_script("return document.documentElement.scrollWidth <= innerWidth")
    assert browser.execute_script("return [...document.querySelectorAll('input')].every(i => i.closest('label'))")
    assert barriers(browser) == []
    assert browser.get_log("browser") == []

"""The report in a real browser: no error, hovering, selecting, the keyboard, any number of points.

Needs Chromium and its driver (Debian: chromium, chromium-driver) and the selenium package.
"""

import csv
import math
import os
import shutil
import subprocess
import time
from pathlib import Path

import pytest
from axe_core_python.selenium import Axe
from test_acceptance import PROGRAM

selenium = pytest.importorskip("selenium")
from selenium import webdriver  # noqa: E402
from selenium.webdriver.chrome.options import Options  # noqa: E402
from selenium.webdriver.chrome.service import Service  # noqa: E402
from selenium.webdriver.common.action_chains import ActionChains  # noqa: E402
from selenium.webdriver.common.by import By  # noqa: E402
from selenium.webdriver.common.keys import Keys  # noqa: E402

ROOT = Path(__file__).resolve().parents[2]
CHROMIUM, DRIVER = shutil.which("chromium"), shutil.which("chromedriver")
pytestmark = pytest.mark.skipif(not (CHROMIUM and DRIVER), reason="Chromium or its driver is not installed")

SWITCHES = """--headless=new --no-sandbox --disable-gpu --no-first-run --disable-background-networking
--disable-component-update --disable-sync --window-size=1300,1000""".split()


def report(folder, points):
    # With the features of the whole workspace, as `cargo test` built it: for one package cargo would build all anew.
    build = ["cargo", "build", "--quiet", "--locked", "--workspace", "--example", "report_demo"]
    subprocess.run(build, cwd=ROOT, check=True, env={**os.environ, "CARGO_TERM_COLOR": "never"})
    program = ROOT / os.environ.get("CARGO_TARGET_DIR", "target") / "debug/examples/report_demo"
    subprocess.run([program, str(points), str(folder)], cwd=ROOT, check=True)
    return folder / "report.html"


@pytest.fixture(scope="module")
def browser():
    options = Options()
    options.binary_location = CHROMIUM
    for switch in SWITCHES:
        options.add_argument(switch)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    driver = webdriver.Chrome(options=options, service=Service(DRIVER))
    # The rules of axe-core take 7 s on a quiet machine; on a busy one they outlasted the usual 30 s.
    driver.set_script_timeout(300)
    yield driver
    driver.quit()


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    return report(tmp_path_factory.mktemp("small"), 50)


def opened(browser, page):
    browser.get(page.as_uri())
    plot = browser.find_elements(By.CSS_SELECTOR, "figure.plane svg")[1]
    browser.execute_script("arguments[0].scrollIntoView({block: 'center', behavior: 'instant'})", plot)
    return plot


def settle(browser):
    """Lets the page draw what has changed."""
    browser.execute_async_script("const done = arguments[0]; requestAnimationFrame(() => requestAnimationFrame(done))")
    time.sleep(0.05)


def verified_mark(browser, plot):
    """Where the first verified point is, from the middle of the plot."""
    return browser.execute_script(
        """const m = arguments[0].querySelector('.pt.in').getAttribute('d').match(/M([\\d.]+),([\\d.]+)a([\\d.]+)/);
        const box = arguments[0].getBoundingClientRect(), view = arguments[0].viewBox.baseVal;
        return [(+m[1] + +m[3]) * box.width / view.width - box.width / 2, +m[2] * box.height / view.height - box.height / 2]""",
        plot,
    )


def selected(browser):
    settle(browser)
    return browser.find_element(By.ID, "selection-count").text


def barriers(browser):
    """What keeps people out of the page that is open, in a narrow window and in a wide one: rules of axe-core."""
    found = []
    try:
        for width in (400, 1280):
            metrics = {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": False}
            browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
            settle(browser)
            violations = Axe().run(browser)["violations"]
            found += [(width, rule["id"], node["html"][:200]) for rule in violations for node in rule["nodes"]]
    finally:
        browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
    return found


def test_no_errors_and_nothing_from_outside(browser, small):
    opened(browser, small)
    assert browser.get_log("browser") == []
    assert browser.execute_script("return performance.getEntriesByType('resource').length") == 0
    assert "http" not in small.read_text().replace("http://www.w3.org/2000/svg", "").replace("http-equiv", "")
    assert barriers(browser) == []


def test_hovering_shows_the_point_everywhere(browser, small):
    plot = opened(browser, small)
    x, y = verified_mark(browser, plot)
    ActionChains(browser).move_to_element_with_offset(plot, round(x), round(y)).perform()
    settle(browser)
    tip = browser.find_element(By.ID, "tip")
    assert tip.is_displayed() and "meets all criteria" in tip.text and "bearing.radialClearance" in tip.text
    rings = browser.find_elements(By.CSS_SELECTOR, "figure.plane .ring")
    assert len(rings) == 4 and all(ring.get_attribute("d") for ring in rings)


def test_dragging_selects_and_lists(browser, small):
    plot = opened(browser, small)
    assert selected(browser) == "None selected."
    drag = ActionChains(browser).move_to_element_with_offset(plot, -180, -150).click_and_hold()
    drag.move_by_offset(200, 150).move_by_offset(200, 150).release().perform()
    text = selected(browser)
    count = int(text.split()[0])
    assert count > 5
    assert len(browser.find_elements(By.CSS_SELECTOR, "#selection-table tbody tr")) == count
    browser.find_element(By.TAG_NAME, "body").send_keys(Keys.ESCAPE)
    assert selected(browser) == "None selected."


def test_the_keyboard_reaches_the_points(browser, small):
    plot = opened(browser, small)
    plot.send_keys(Keys.ARROW_RIGHT, Keys.ARROW_RIGHT, Keys.ENTER)
    assert selected(browser).startswith("1 selected")
    assert browser.find_element(By.ID, "tip").text.startswith("Point")


def test_other_axes_can_be_chosen(browser, small):
    opened(browser, small)
    choice = browser.find_element(By.CSS_SELECTOR, "figure.plane select")
    choice.send_keys("load.stiffness")
    settle(browser)
    titles = [t.text for t in browser.find_elements(By.CSS_SELECTOR, "figure.plane:first-of-type .title")]
    assert "load.stiffness (N/m)" in titles


def test_every_plot_has_a_name_for_screen_readers(browser, small):
    opened(browser, small)
    nameless = browser.execute_script(
        "return [...document.querySelectorAll('svg')].filter(s => !s.getAttribute('aria-label') && !s.closest('[aria-hidden]')"
        " && !s.hasAttribute('aria-hidden') && !s.classList.contains('key')).length"
    )
    assert nameless == 0


def test_a_point_says_how_probably_it_conforms(browser, small):
    plot = opened(browser, small)
    row = browser.find_element(By.CSS_SELECTOR, "#best tbody tr[data-id]")
    conforms = float(row.find_elements(By.TAG_NAME, "td")[3].get_attribute("textContent"))
    browser.execute_script("arguments[0].click()", row)
    settle(browser)
    cell = browser.find_element(By.CSS_SELECTOR, "#selection-table tbody td").text
    assert float(cell.split()[0]) == pytest.approx(conforms, abs=0.06)
    x, y = verified_mark(browser, plot)
    ActionChains(browser).move_to_element_with_offset(plot, round(x), round(y)).perform()
    settle(browser)
    assert "conforms with a probability of" in browser.find_element(By.ID, "tip").text


def test_trade_offs_are_drawn(browser, small):
    opened(browser, small)
    assert len(browser.find_elements(By.CSS_SELECTOR, "#pareto figure svg .chosen")) >= 1
    assert browser.find_element(By.CSS_SELECTOR, "#pareto tbody th").text.startswith("Best compromise")


SETTINGS = """
diameter = "25 mm"
time = { column = "t" }
load = { column = "F", variable = "sensor.loadForce", unit = "N", accuracy = "1 %" }
torque = { column = "M", variable = "sensor.frictionTorque", unit = "N.m", accuracy = "2 %" }
speed = { value = 300, unit = "rpm", accuracy = "2.5 rpm" }
"""


def test_the_page_of_a_recording(browser, tmp_path):
    force = lambda t: 750 * (1 + 0.5 * math.sin(10 * math.pi * t))  # noqa: E731
    rows = (f"{t},{force(t)},{0.00059 * force(t - 0.016)}" for t in (k / 1000 for k in range(12_000)))
    (tmp_path / "measured.csv").write_text("t,F,M\n" + "\n".join(rows) + "\n")
    (tmp_path / "settings.toml").write_text(SETTINGS)
    command = [PROGRAM, "synchronise", "measured.csv", "--settings", "settings.toml", "--output", "out"]
    subprocess.run(command, cwd=tmp_path, check=True, capture_output=True)
    browser.get((tmp_path / "out" / "report.html").as_uri())
    assert browser.get_log("browser") == []
    assert browser.find_element(By.ID, "answer").text.startswith("Torque later than the load by 16.000 ms (")
    assert len(browser.find_elements(By.CSS_SELECTOR, "#signals svg[aria-label]")) == 4
    assert len(browser.find_elements(By.CSS_SELECTOR, "#steady svg[aria-label]")) == 2
    assert barriers(browser) == []


@pytest.mark.parametrize("points", [100_000, pytest.param(1_000_000, marks=pytest.mark.long)])
def test_many_points_stay_small_and_work(browser, tmp_path, points):
    page = report(tmp_path, points)
    assert page.stat().st_size < 5_000_000
    plot = opened(browser, page)
    assert browser.get_log("browser") == []
    assert plot.find_elements(By.CSS_SELECTOR, ".pt.in")
    ActionChains(browser).move_to_element(plot).perform()
    settle(browser)
    assert browser.find_element(By.ID, "tip").text.startswith("Point")


def test_no_sideways_scrolling(browser, small):
    """In phones, too; wide tables scroll for themselves and can be reached with the keyboard."""
    try:
        for width in (320, 400, 1280):
            metrics = {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": False}
            browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
            browser.get(small.as_uri())
            assert browser.execute_script("return document.documentElement.scrollWidth") <= width
            unreachable = browser.execute_script(
                "return [...document.querySelectorAll('.scroll, pre')].filter(e => e.scrollWidth > e.clientWidth && e.tabIndex < 0).length"
            )
            assert unreachable == 0
    finally:
        browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})


CURVES = """
fmu = "model.fmu"
simulation = { stop = 2, step = 0.01 }
design = { method = "sobol", points = 16, seed = 1 }
[parameters."load.preload"]
distribution = "uniform"
min = 45
max = 51
unit = "N"
[criteria.error]
variable = "sensor.loadForce"
reference = { file = "recording.csv", time = "time", column = "sensor.loadForce [N]", unit = "N" }
metric = "rmse"
tolerance = "20 N"
unit = "N"
[criteria.share]
variable = "sensor.loadForce"
reference = { file = "recording.csv", time = "time", column = "sensor.loadForce [N]", unit = "N" }
metric = "corridor"
band = "20 N"
least = 0.5
"""


def test_curves_come_first_with_a_slider_that_judges(browser, tmp_path):
    shutil.copy(ROOT / "dist/PlainBearingStand.fmu", tmp_path / "model.fmu")
    shutil.copy(ROOT / "examples/tutorial/recording.csv", tmp_path)
    (tmp_path / "study.toml").write_text(CURVES)
    command = [PROGRAM, "verify", "study.toml", "--output", "out"]
    assert subprocess.run(command, cwd=tmp_path, capture_output=True).returncode in (0, 1)
    with (tmp_path / "out/points.csv").open() as file:
        points = list(csv.DictReader(file))
    browser.get((tmp_path / "out/report.html").as_uri())
    sections = [section.get_attribute("id") for section in browser.find_elements(By.CSS_SELECTOR, "main > section")]
    assert sections[:2] == ["verdict", "history"]
    counts = set()
    for name, limits, meets in (("error", (5, 12, 30), lambda v, l: v <= l), ("share", (0.2, 0.6, 0.95), lambda v, l: v >= l)):  # noqa: E741
        box = browser.find_element(By.CSS_SELECTOR, f".tune[data-criterion={name}]")
        assert "Its risk is not known" in box.find_element(By.XPATH, "preceding-sibling::p[1]").text
        for limit in limits:
            browser.execute_script("arguments[0].value = arguments[1]; arguments[0].dispatchEvent(new Event('input'))",
                                   box.find_element(By.CSS_SELECTOR, "[type=number]"), limit)
            settle(browser)
            expected = sum(meets(float(row[name]), limit) for row in points)
            assert box.find_element(By.CLASS_NAME, "note").text.startswith(f"{expected} of 16 points meet it"), (name, limit)
            key = "least" if name == "share" else "tolerance"
            snippet = browser.execute_script("return document.querySelector('#whatif .snippet').textContent")
            assert f"{key} = {limit}" in snippet, snippet
            counts.add((name, expected))
    assert len(counts) >= 4, "the limits must change the counts"
    assert browser.get_log("browser") == []

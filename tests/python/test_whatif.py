"""The page's "What if" gives the numbers of `orchestrator judge` with the changed study.

Needs Chromium and its driver (Debian: chromium, chromium-driver) and the selenium package.
"""

import json
import random
import subprocess

import pytest
from functions import pack
from test_acceptance import PROGRAM
from test_report import browser, pytestmark  # noqa: F401

STUDY = """
title = "Invented"
fmu = "none.fmu"
[design]
method = "monte-carlo"
points = 400
[criteria.T]
variable = "t"
nominal = 82
tolerance = "0.75 %"
uncertainty = "0.3 degC"
unit = "degC"
group = "both"
[criteria.F]
variable = "f"
nominal = 750
tolerance = "7 %"   # of the load
uncertainty = 30
coverage = 1.732
unit = "N"
group = "both"
[criteria."P.fr"]
variable = "p"
nominal = 14
tolerance = 3
uncertainty = 0.9
unit = "W"
"""
CORRELATED = '[[uncertainty-correlations]]\nbetween = ["F", "P.fr"]\ncoefficient = 0.6\n'
RULES = {
    "one point": "",
    "share": '[verdict]\nshare = "20 %"\n',
    "guard band": "[verdict]\nshare = 0.1\nguard-band = 0.5\n",
    "risk": '[verdict]\nshare = 0.05\nrisk = "20 %"\n',
    "correlated": CORRELATED + '[verdict]\nshare = "20 %"\nconfidence = 0.99\n',
}
CHANGES = [
    {},
    {"criteria": {"T": {"nominal": 81.7}}},
    {"criteria": {"T": {"tolerance": 0.4, "expanded": 0.1}, "F": {"expanded": 10}}},
    {"criteria": {"P.fr": {"nominal": 12.5, "tolerance": 2, "expanded": 0.25}}},
    {"share": 0.45, "criteria": {"F": {"nominal": 777.7, "tolerance": 90.5}}},
    {"criteria": {"T": {"nominal": 95}}},
]


def table(path):
    draw = random.Random(3)
    rows = ["point,t,f,p"]
    for k in range(1, 401):
        z, power = draw.gauss(0, 1), draw.gauss(13, 2)
        # Some points have no result.
        load = "nan" if k % 37 == 0 else repr(760 + 60 * z)
        rows.append(f"{k},{81.9 + 0.4 * draw.gauss(0, 1) + 0.05 * power!r},{load},{power!r}")
    path.write_text("\n".join(rows) + "\n")


def judged(folder, text):
    folder.mkdir(exist_ok=True)
    study = folder / "study.toml"
    study.write_text(text)
    done = subprocess.run([PROGRAM, "judge", study, folder.parent / "table.csv", "--output", folder / "out"], capture_output=True, text=True)
    assert done.returncode in (0, 1, 3), done.stderr
    return json.loads((folder / "out" / "summary.json").read_text())


def same(found, expected, place=""):
    """Equal words and counts, numbers within 1e-9."""
    if isinstance(expected, dict):
        for key, value in expected.items():
            same(found[key], value, f"{place}.{key}")
    elif isinstance(expected, list):
        assert len(found) == len(expected), place
        for k, value in enumerate(expected):
            same(found[k], value, f"{place}[{k}]")
    elif isinstance(expected, float):
        assert found == pytest.approx(expected, abs=1e-9), place
    else:
        assert found == expected, place


@pytest.mark.parametrize("rule", RULES)
def test_the_page_judges_as_the_program_does(browser, tmp_path, rule):  # noqa: F811
    table(tmp_path / "table.csv")
    judged(tmp_path / "first", STUDY + RULES[rule])
    browser.get((tmp_path / "first" / "out" / "report.html").as_uri())
    verdicts = set()
    for change in CHANGES:
        asked = browser.execute_script("return WhatIf.ask(arguments[0])", change)
        # The changed study, as the page writes it.
        summary = judged(tmp_path / "second", asked["text"])
        for name in ("points", "failed", "accepted", "verdict", "guard_band", "risk", "expected_verified"):
            same(asked[name], summary[name], name)
        same(asked["verified"], {"passed": summary["verified"], "fraction": summary["verified_fraction"], "interval": summary["verified_interval"]}, "verified")
        if summary["required"]:
            same(asked["interval"], summary["required"]["interval"], "required")
        for found, (name, criterion) in zip(asked["criteria"], summary["criteria"].items(), strict=True):
            same(found, {key: criterion.get(key) for key in ("passed", "fraction", "interval", "risk")}, name)
        (found,) = asked["groups"]
        same(found, summary["groups"]["both"], "both")
        verdicts.add(summary["verdict"])
    assert len(verdicts) > 1, "the changes must change the verdict"
    assert browser.get_log("browser") == []


UNLIKE = """
title = "Invented"
fmu = "none.fmu"
[design]
method = "monte-carlo"
points = 400
[criteria.T]
variable = "t"
at-most = 82.3
uncertainty = 0.3
uncertainty-distribution = "rectangular"
noise = 0.1
repeats = 5
unit = "degC"
group = "both"
[criteria.F]
variable = "f"
nominal = 750
tolerance = { minus = 40, plus = 90 }
noise = 30
repeats = 4
unit = "N"
group = "both"
[criteria."P.fr"]
variable = "p"
at-least = 10
uncertainty = 0.9
unit = "W"
"""
UNLIKE_CHANGES = [
    {},
    {"criteria": {"T": {"nominal": 82.0, "expanded": 0.2}}},
    {"criteria": {"F": {"nominal": 760, "minus": 20, "plus": 33.5, "expanded": 20}}},
    {"criteria": {"P.fr": {"nominal": 13}}, "share": 0.45},
    {"criteria": {"T": {"nominal": 70}}},
]


@pytest.mark.parametrize("rule", RULES)
def test_the_page_judges_limits_and_errors_of_any_kind(browser, tmp_path, rule):  # noqa: F811
    """A limit that stands alone, an uneven tolerance, a rectangle with Student's part."""
    table(tmp_path / "table.csv")
    judged(tmp_path / "first", UNLIKE + RULES[rule].replace('["F", "P.fr"]', '["T", "P.fr"]'))
    browser.get((tmp_path / "first" / "out" / "report.html").as_uri())
    for change in UNLIKE_CHANGES:
        asked = browser.execute_script("return WhatIf.ask(arguments[0])", change)
        summary = judged(tmp_path / "second", asked["text"])
        for name in ("points", "failed", "accepted", "verdict", "guard_band", "risk", "expected_verified"):
            same(asked[name], summary[name], name)
        for found, (name, criterion) in zip(asked["criteria"], summary["criteria"].items(), strict=True):
            same(found, {key: criterion.get(key) for key in ("passed", "fraction", "interval", "risk")}, name)
    assert browser.get_log("browser") == []


def random_study(draw):
    """A study, its setting for the page's script, and its points, some of which failed."""
    size, count = draw.choice([1, 3, 20, 50, 300]), draw.randint(1, 4)
    rows = [[draw.gauss(0, 1) if draw.random() > 0.03 else None for _ in range(count)] for _ in range(size)]
    certain, criteria, correlations, rule = draw.random() < 0.75, [], [], None
    text = f'fmu = "none.fmu"\n[design]\nmethod = "monte-carlo"\npoints = {size}\n'
    for k in range(count):
        tolerance = 10 ** draw.uniform(-0.5, 0.6)
        stated = {"expanded": tolerance * 10 ** draw.uniform(-1.3, 0.6), "coverage": draw.choice([2, 1.732, 1])}
        uncertainty = stated if certain or draw.random() < 0.5 else None
        own = {"name": f"c{k}", "nominal": draw.gauss(0, 0.7), "tolerance": tolerance, "uncertainty": uncertainty, "group": None}
        text += f'[criteria.c{k}]\nvariable = "c{k}"\nnominal = {own["nominal"]!r}\ntolerance = {tolerance!r}\n'
        if uncertainty:
            text += f"uncertainty = {uncertainty['expanded']!r}\ncoverage = {uncertainty['coverage']}\n"
        criteria.append(own)
    complete = all(own["uncertainty"] for own in criteria)
    for first in range(0, count - 1, 2):
        if complete and draw.random() < 0.5:
            coefficient = draw.choice([0.99, -0.9, 1, -1, draw.uniform(-1, 1)])
            correlations.append([first, first + 1, coefficient])
            text += f'[[uncertainty-correlations]]\nbetween = ["c{first}", "c{first + 1}"]\ncoefficient = {coefficient!r}\n'
    if draw.random() < 0.75:
        rule = {"share": draw.choice([0.05, 0.2, 0.5, 0.9]), "confidence": draw.choice([0.9, 0.95, 0.99])}
        text += f"[verdict]\nshare = {rule['share']}\nconfidence = {rule['confidence']}\n"
        kind = draw.choice(["risk", "band", "none"]) if complete else "none"
        if kind == "risk":
            rule["risk"] = draw.choice([0.02, 0.1, 0.3, 0.6])
            text += f"risk = {rule['risk']}\n"
        else:
            rule["band"] = draw.choice([0.2, 0.5, 1.0, 3.0]) if kind == "band" else 0
            text += f"guard-band = {rule['band']}\n" if kind == "band" else ""
    return text, {"criteria": criteria, "correlations": correlations, "rule": rule}, rows


JUDGE = """
const [setting, rows] = arguments;
const points = {
  size: rows.length, samples: 1, grid: false, completed: Uint8Array.from(rows, row => row.every(v => v !== null) ? 1 : 0),
  values: setting.criteria.map((_, k) => Float64Array.from(rows, row => row[k] ?? NaN)),
};
points.known = Judge.known(setting.criteria.map(() => ""), points.values);
const { flags, ...found } = Judge.judge(setting, points);
return found;
"""


def test_random_studies_are_judged_alike(browser, tmp_path):  # noqa: F811
    draw, verdicts = random.Random(5), set()
    table(tmp_path / "table.csv")
    judged(tmp_path / "first", STUDY)
    browser.get((tmp_path / "first" / "out" / "report.html").as_uri())
    for _ in range(60):
        text, setting, rows = random_study(draw)
        cells = [",".join("nan" if value is None else repr(value) for value in row) for row in rows]
        header = "point," + ",".join(own["name"] for own in setting["criteria"])
        lines = [header, *(f"{k + 1},{row}" for k, row in enumerate(cells))]
        (tmp_path / "table.csv").write_text("\n".join(lines) + "\n")
        summary, found = judged(tmp_path / "second", text), browser.execute_script(JUDGE, setting, rows)
        for name in ("points", "failed", "accepted", "verdict", "guard_band", "risk", "expected_verified"):
            same(found[name], summary[name], name)
        if summary["required"]:
            same(found["interval"], summary["required"]["interval"], "required")
        for own, criterion in zip(found["criteria"], summary["criteria"].values(), strict=True):
            same(own, {key: criterion.get(key) for key in ("passed", "fraction", "interval", "risk")})
        verdicts.add(summary["verdict"])
    assert verdicts == {"verified", "not verified", "inconclusive"}


def test_a_slider_changes_verdict_and_boxes_and_comes_back(browser, tmp_path):  # noqa: F811
    table(tmp_path / "table.csv")
    judged(tmp_path / "first", STUDY)
    browser.get((tmp_path / "first" / "out" / "report.html").as_uri())
    state = """return [document.querySelector('#whatif .outcome').textContent, document.querySelector('figure.plane .accept').getAttribute('d'),
      document.getElementById('changed-note').hidden]"""
    settle = "const done = arguments[0]; setTimeout(done, 300)"
    before = browser.execute_script(state)
    assert before[0].startswith("As the study stands: verified. ") and before[2]
    slider = "const s = document.querySelector('#whatif input[type=range]'); s.value = 0.9; s.dispatchEvent(new Event('input'))"
    browser.execute_script(slider)
    browser.execute_async_script(settle)
    after = browser.execute_script(state)
    assert after[0].startswith("What if: ") and after[0] != before[0] and after[1] != before[1] and not after[2]
    assert "nominal = 83.66" in browser.execute_script("return document.querySelector('#whatif .snippet').textContent")
    browser.execute_script("document.querySelector('#whatif .reset').click()")
    browser.execute_async_script(settle)
    assert browser.execute_script(state) == before
    assert browser.get_log("browser") == []
    controls = browser.execute_script("return [...document.querySelectorAll('#whatif input')].filter(i => !i.ariaLabel && !i.closest('label')).length")
    assert controls == 0


def test_some_points_of_nets_have_no_interval(browser, tmp_path):  # noqa: F811
    """Of 60 columns the page holds 6,250 points: not all 8,000 of sixteen nets, of which nobody can tell any more which belong together."""
    pack(tmp_path, 30, "linear")
    text = 'fmu = "functions.fmu"\n[design]\nmethod = "sobol"\nreplicates = 16\nseed = 1\npoints = 8000\n[verdict]\nshare = "50 %"\n'
    for k in range(1, 31):
        text += f'[parameters.x{k}]\ndistribution = "uniform"\nmin = 0\nmax = 1\n[criteria.c{k}]\nvariable = "linear"\nnominal = 3\ntolerance = 2\n'
    (tmp_path / "study.toml").write_text(text)
    for points, has_interval in ((1600, True), (8000, False)):
        out = tmp_path / str(points)
        asked = [PROGRAM, "verify", tmp_path / "study.toml", "--points", str(points), "--isolation", "none", "--extra-runs", "0", "--output", out]
        done = subprocess.run(asked, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        assert json.loads((out / "summary.json").read_text())["verified_interval"] is not None
        browser.get((out / "report.html").as_uri())
        found = browser.execute_script("return WhatIf.ask({criteria: {c1: {nominal: 2.9}}})")
        shares = [found["verified"], *found["criteria"]]
        assert [bool(one["interval"]) for one in shares] == [has_interval] * len(shares)
        assert bool(found["interval"]) == has_interval
        assert (found["verdict"] == "verified") == has_interval
    assert browser.get_log("browser") == []


# Points of some normal parameters and a linear value, whose share within a tolerance is known for any means and deviations.
TRIAL = """
const [size, parameters, studies, tail] = arguments;
let seed = 12345;
const uniform = () => {
  seed = (seed + 0x6D2B79F5) | 0;
  let t = Math.imul(seed ^ (seed >>> 15), 1 | seed);
  t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
  return ((t ^ (t >>> 14)) >>> 0) / 2 ** 32;
};
const normal = () => Math.sqrt(-2 * Math.log(1 - uniform())) * Math.cos(2 * Math.PI * uniform());
const drawn = Array.from({ length: parameters }, () => ({ distribution: 'normal', mean: 0, deviation: 1 }));
let held = 0, above = 0, few = 0;
for (let study = 0; study < studies; study++) {
  const slopes = drawn.map(normal), length = Math.hypot(...slopes);
  let nominal = normal() * length, tolerance = length * (0.1 + uniform());
  const changes = {};
  for (let k = 0; k <= uniform() * (parameters - 1); k++) changes[k] = { mean: 2 * uniform() - 1, deviation: 0.5 + 0.8 * uniform() };
  if (tail) {
    // All beyond two to three deviations, on the side to which the values move.
    const side = Math.sign(drawn.reduce((sum, _, k) => sum + slopes[k] * (changes[k]?.mean ?? 0), 0));
    tolerance = 1e3 * length;
    nominal = side * (tolerance + length * (2 + uniform()));
  }
  const columns = drawn.map(() => Float32Array.from({ length: size }, normal));
  const value = i => columns.reduce((sum, x, k) => sum + slopes[k] * x[i], 0);
  const flags = Uint8Array.from({ length: size }, (_, i) => Math.abs(value(i) - nominal) <= tolerance ? 1 : 0);
  const weights = Weights.of(drawn, changes, columns, size);
  if (Weights.effective(weights) < Weights.FEW) { few++; continue; }
  const own = drawn.map((before, k) => changes[k] ?? before), mean = own.reduce((sum, q, k) => sum + slopes[k] * q.mean, 0);
  const deviation = Math.hypot(...own.map((q, k) => slopes[k] * q.deviation));
  const truth = Numbers.between((nominal - tolerance - mean) / deviation, (nominal + tolerance - mean) / deviation);
  const [low, high] = Weights.interval(weights, flags, 0.95);
  held += low <= truth && truth <= high;
  above += truth > high;
}
return [held, studies - few, above];
"""


@pytest.mark.parametrize("size, parameters, studies, tail", [
    (300, 1, 1000, False), (1000, 2, 1000, False), (1000, 4, 1000, False), (5000, 7, 300, False),
    (300, 1, 1000, True), (1000, 1, 1000, True), (1000, 2, 1000, True)])
def test_weighted_shares_lie_in_their_intervals(browser, tmp_path, size, parameters, studies, tail):  # noqa: F811
    """As often as they say, over random changes of the distributions; `pytest -s` shows the numbers."""
    table(tmp_path / "table.csv")
    judged(tmp_path / "first", STUDY)
    browser.get((tmp_path / "first" / "out" / "report.html").as_uri())
    held, judged_studies, above = browser.execute_script(TRIAL, size, parameters, studies, tail)
    place = "in a tail" if tail else "in a band"
    print(f"{size} points, {parameters} parameters, {place}: {held} of {judged_studies} intervals hold the true share, "
          f"{above} lie below it")
    assert judged_studies > 0.9 * studies
    assert held >= 0.94 * judged_studies
    # A side of an interval of 95 % may fail in 2.5 %, give or take two deviations of 1,000 trials.
    assert above <= 0.035 * judged_studies

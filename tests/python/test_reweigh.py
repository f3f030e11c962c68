"""Under other distributions of the parameters, "What if" says what a fresh study would, or that it cannot know.

Needs Chromium and its driver (Debian: chromium, chromium-driver) and the selenium package.
"""

import json
import subprocess
import tomllib

import pytest
from test_acceptance import PROGRAM
from test_report import barriers, browser, pytestmark  # noqa: F401
from test_whatif import STUDY, judged, same, table

# Studies of normal parameters and linear values. Points that were drawn from some distributions are judged under others; then
# many fresh points of these tell the truth.
TRIAL = """
const [size, studies, kind] = arguments;
let seed = 4711;
const uniform = () => {
  seed = (seed + 0x6D2B79F5) | 0;
  let t = Math.imul(seed ^ (seed >>> 15), 1 | seed);
  t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
  return ((t ^ (t >>> 14)) >>> 0) / 2 ** 32;
};
const normal = () => Math.sqrt(-2 * Math.log(1 - uniform())) * Math.cos(2 * Math.PI * uniform());
const FRESH = 20000;
const counts = { decided: 0, wrong: 0, 'verified': 0, 'not verified': 0, 'not decided': 0, held: 0, old: 0 };
for (let study = 0; study < studies; study++) {
  const drawn = [0, 1].map(() => ({ distribution: 'normal', mean: 0, deviation: 1 }));
  const slopes = [0, 1].map(() => drawn.map(normal));
  const criteria = slopes.map((own, k) => {
    const length = Math.hypot(...own), tolerance = length * (0.5 + uniform());
    return { name: `c${k}`, nominal: normal() * length, tolerance, uncertainty: { expanded: tolerance * (0.2 + 0.6 * uniform()), coverage: 2 }, group: null };
  });
  const rule = kind === 'risk' ? { share: 10 ** (-1.5 * uniform()), confidence: 0.95, risk: 0.05 + 0.2 * uniform() } : null;
  const setting = { criteria, correlations: [], rule };
  const changes = Object.fromEntries(drawn.map((_, k) => [k, { mean: 2 * uniform() - 1, deviation: 0.5 + 0.8 * uniform() }]));
  const sample = (of, n) => {
    const parameters = of.map(q => Float32Array.from({ length: n }, () => q.mean + q.deviation * normal()));
    const values = slopes.map(own => Float64Array.from({ length: n }, (_, i) => own[0] * parameters[0][i] + own[1] * parameters[1][i]));
    return { size: n, samples: 1, grid: false, completed: new Uint8Array(n).fill(1), known: Judge.known(values.map(() => ''), values), values, parameters };
  };
  const points = sample(drawn, size), weights = Weights.of(drawn, changes, points.parameters, size);
  if (Weights.effective(weights) < Weights.FEW) continue;
  const before = Judge.judge(setting, points), found = Reweigh.judge(setting, points, before, weights, size);
  const truth = Judge.judge(setting, sample([0, 1].map(k => changes[k]), FRESH)), share = truth.acceptedShare.fraction;
  // What the whole space says: by its share, or by the probability of at least one accepted point among as many.
  const some = 1 - (1 - share) ** size, right = rule ? (share >= rule.share ? 'verified' : 'not verified') : some >= 0.5 ? 'verified' : 'not verified';
  counts[found.verdict]++;
  if (found.verdict !== 'not decided') {
    counts.decided++;
    counts.wrong += found.verdict !== right;
  }
  counts.old += before.verdict !== 'inconclusive' && before.verdict !== right;
  const [low, high] = rule ? found.interval : found.some, slack = rule ? 2 * Math.sqrt(share / FRESH) + 1e-9 : 0.02;
  counts.held += low <= (rule ? share : some) + slack && (rule ? share : some) - slack <= high;
}
return counts;
"""


@pytest.mark.parametrize("kind, size", [("risk", 400), ("risk", 2000), ("one point", 400)])
def test_verdicts_by_weights_are_those_of_the_changed_space(browser, tmp_path, kind, size):  # noqa: F811
    """`pytest -s` shows the numbers."""
    table(tmp_path / "table.csv")
    judged(tmp_path / "first", STUDY)
    browser.get((tmp_path / "first" / "out" / "report.html").as_uri())
    counts = browser.execute_script(TRIAL, size, 150, kind)
    print(f"{kind}, {size} points: {counts}")
    assert counts["verified"] > 5, "some changes must be decided"
    assert counts["wrong"] <= 0.05 * counts["decided"]
    assert counts["held"] >= 0.95 * (counts["decided"] + counts["not decided"])
    if kind == "risk":
        assert counts["not verified"] > 5
        assert counts["old"] > counts["wrong"], "the verdict of the points as they are must be worse"


UNITS = """
fmu = "{fmu}"
[simulation]
stop = 1
step = 1
[design]
method = "monte-carlo"
points = 60
[parameters."bearing.radialClearance"]
distribution = "normal"
mean = "20 um"
deviation = "2 um"
[criteria.T]
variable = "sensor.bearingTemperature"
nominal = "82 degC"
tolerance = "0.75 K"
"""


def test_a_unit_that_stands_in_a_text_stays(browser, tmp_path, fmu):  # noqa: F811
    def verified(name, text):
        (tmp_path / name).with_suffix(".toml").write_text(text)
        done = subprocess.run([PROGRAM, "verify", tmp_path / f"{name}.toml", "--output", tmp_path / name], capture_output=True, text=True)
        assert done.returncode in (0, 1), done.stderr
        return json.loads((tmp_path / name / "summary.json").read_text())

    first = verified("first", UNITS.format(fmu=fmu))
    browser.get((tmp_path / "first" / "report.html").as_uri())
    nominal = first["criteria"]["T"]["nominal"]
    change = {"parameters": {"bearing.radialClearance": {"mean": 20.5, "deviation": 1.9}}, "criteria": {"T": {"nominal": nominal + 0.25}}}
    second = verified("second", browser.execute_script("return WhatIf.ask(arguments[0]).text", change))
    was, now = (summary["parameters"][0] for summary in (first, second))
    assert was["unit"] == now["unit"] == "um"
    assert (was["mean"], now["mean"], now["deviation"]) == (20, 20.5, 1.9)
    assert second["criteria"]["T"]["nominal"] == nominal + 0.25
    assert second["criteria"]["T"]["unit"] == first["criteria"]["T"]["unit"]


CASES = """
fmu = "none.fmu"
[design]
method = "monte-carlo"
points = 400
[criteria.T]
variable = "t"
nominal = 82
tolerance = 0.6
unit = "degC"
[[cases]]
name = "slow"
[[cases]]
name = "fast"
criteria.T = { variable = "t", nominal = 81, tolerance = 0.6, unit = "degC" }
"""


def test_a_criterion_of_a_case_makes_no_table_of_its_own(browser, tmp_path):  # noqa: F811
    table(tmp_path / "table.csv")
    rows = (tmp_path / "table.csv").read_text().splitlines()
    rows = ["point,slow/T,fast/T", *(f"{row.split(',')[0]},{row.split(',')[1]},{row.split(',')[1]}" for row in rows[1:])]
    (tmp_path / "table.csv").write_text("\n".join(rows) + "\n")
    judged(tmp_path / "first", CASES)
    browser.get((tmp_path / "first" / "out" / "report.html").as_uri())
    asked = browser.execute_script("return WhatIf.ask({ criteria: { 'fast/T': { nominal: 81.5 } } })")
    assert asked["text"] is None
    snippet, hint, hidden = browser.execute_script(
        "const part = name => document.querySelector(`#whatif .${name}`); return [part('snippet').textContent, part('by-hand').textContent, part('save').hidden]")
    assert 'name = "fast"' in snippet and "nominal = 81.5" in snippet and 'unit = "degC"' in snippet
    # Comments alone: pasted into a study, they change nothing.
    assert tomllib.loads(snippet) == {}
    assert "by hand" in hint and hidden


def test_what_fails_in_one_case_counts_in_the_others(browser, tmp_path):  # noqa: F811
    table(tmp_path / "table.csv")
    rows = [row.split(",") for row in (tmp_path / "table.csv").read_text().splitlines()[1:]]
    # The second case has no value at every seventh point.
    rows = ["point,slow/T,fast/T", *(f"{k},{t},{'nan' if int(k) % 7 == 0 else t}" for k, t, *_ in rows)]
    (tmp_path / "table.csv").write_text("\n".join(rows) + "\n")
    summary = judged(tmp_path / "first", CASES.replace("tolerance = 0.6", "tolerance = 0.6\nuncertainty = 0.2", 1).replace("tolerance = 0.6, unit", "tolerance = 0.6, uncertainty = 0.3, unit"))
    browser.get((tmp_path / "first" / "out" / "report.html").as_uri())
    asked = browser.execute_script("return WhatIf.ask({})")
    for found, criterion in zip(asked["criteria"], summary["criteria"].values(), strict=True):
        same(found, {key: criterion.get(key) for key in ("passed", "fraction", "interval", "risk")})
    same(asked["verified"]["passed"], summary["verified"])
    assert asked["failed"] == summary["failed"] == 57
    assert barriers(browser) == []


def test_words_of_one_accepted_point(browser, tmp_path):  # noqa: F811
    rows = ["point,t,f,p", "1,82,750,14", *(f"{k},70,750,14" for k in range(2, 41))]
    (tmp_path / "table.csv").write_text("\n".join(rows) + "\n")
    judged(tmp_path / "first", STUDY.replace("points = 400", "points = 40"))
    browser.get((tmp_path / "first" / "out" / "report.html").as_uri())
    words = browser.execute_script("return document.getElementById('verdict').textContent")
    assert "the accepted point is outside of a tolerance of the true values" in words and "Of the 1 " not in words

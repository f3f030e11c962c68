"""`scripts/evidence/peers` without the peers: how it counts, reads and writes. The peers themselves are installed by the script only."""

import math
import sys
import tomllib
import zipfile
from xml.etree import ElementTree

import pytest
from test_acceptance import ROOT

sys.path.insert(0, str(ROOT / "scripts/evidence/peers.d"))
import measure  # noqa: E402

ROW = f"{measure.OUTPUT} {measure.PARAMETER} first"


def test_lines_that_a_user_writes(tmp_path):
    file = tmp_path / "program.py"
    file.write_text('"""A docstring."""\n\n# a comment\nx = 1  # one\nif x:\n    print(x)\n')
    assert measure.lines(file) == 3


@pytest.mark.parametrize("peer, said", [
    ("fmpy-salib", f"{ROW} 0.5 +- 2.5e-1 total 1 +- 0"), ("openturns", f"{ROW} 0.5 0.25 0.75 total 1 1 1")])
def test_indices_are_read_from_what_a_peer_says(peer, said):
    assert measure.said_index(peer, f"other\n{said}\n", "first") == "0.500 (0.250 to 0.750)"
    assert measure.said_index(peer, said, "total") == "1.000 (1.000 to 1.000)"


def test_what_is_left_of_the_points():
    done = measure.Run(1.0, 1.0, 0, "")
    assert measure.kept(done, [[1.0, 2.0], [1.0, math.nan]]) == "1"
    assert measure.kept(measure.Run(1.0, 1.0, -11, ""), []) == "none, SIGSEGV"
    assert measure.kept(measure.Run(1.0, 1.0, None, ""), []) == "none, does not end"
    assert measure.kept(measure.Run(1.0, 1.0, 1, "Traceback\nfoo.bar.Broken: no\n"), []) == "none, Broken"


def test_differences():
    assert measure.difference([[1.0], [math.nan]], [[1.0]]) == "none"
    assert measure.difference([[2.0], [4.0]], [[2.0], [5.0]]) == "2e-01"
    assert measure.difference([[2.0]], []) == "0 of 1 points have values"


def test_the_rare_studies(tmp_path):
    study = tomllib.loads(measure.rare_study(tmp_path, "branches").read_text(encoding="utf-8"))
    assert list(study["parameters"]) == ["x1", "x2"]
    assert study["criteria"] == {"margin": {"variable": "branches", "at-least": 0}}
    with zipfile.ZipFile(study["fmu"]) as fmu:
        variables = ElementTree.fromstring(fmu.read("modelDescription.xml")).iter("ScalarVariable")
    assert [variable.get("name") for variable in variables] == [*measure.NAMES, "branches", "oscillator"]
    stand = tomllib.loads(measure.rare_study(tmp_path, "stand").read_text(encoding="utf-8"))
    assert len(stand["parameters"]) == 7 and stand["criteria"]["margin"]["at-most"] == 28
    assert measure.rarely(0.00321, 0.00311, 0.00331) == "0.321 % (0.311 to 0.331 %)"


def test_a_table_goes_between_its_markers():
    page = measure.PAGE.read_text(encoding="utf-8")
    new = measure.put(page, "paper", measure.markdown([["", "a"], ["b", "1"]]))
    assert "<!-- paper:begin -->\n|  | a |\n|---|---|\n| b | 1 |\n<!-- paper:end -->" in new
    assert new.partition("<!-- paper:end -->")[2] == page.partition("<!-- paper:end -->")[2]

"""docs/paper.md is what scripts/paper writes: what the paper's tables tell, and what quick runs give."""

import re
import string
import subprocess
import sys

import pytest
from test_acceptance import PROGRAM, ROOT

sys.path.insert(0, str(ROOT / "scripts/claims"))
import claims  # noqa: E402
import printed  # noqa: E402
import simulated  # noqa: E402

TEMPLATE = claims.TEMPLATE.read_text(encoding="utf-8")
PAGE = (ROOT / "docs/paper.md").read_text(encoding="utf-8")


def test_the_page_agrees_with_the_tables():
    done = subprocess.run([ROOT / "scripts/paper", "--check"], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.parametrize("right, wrong", [
    ("needs 1.27 mm", "needs 1.28 mm"),                          # arithmetic with the tables
    ("| 3 | 0.0250 |", "| 3 | 0.0205 |"),                        # the clearance of a row of Table 3
    ("lacks M", "lacks m"),                                      # a sentence
])
def test_a_wrong_page_is_found(right, wrong):
    pattern = claims.expected(TEMPLATE, printed.values())
    assert re.fullmatch(pattern, PAGE) and right in PAGE
    assert not re.fullmatch(pattern, PAGE.replace(right, wrong))


@pytest.mark.parametrize("part", ["rig", "run", "map", "a", pytest.param("s", marks=pytest.mark.long)])
def test_the_page_agrees_with_the_runs(tmp_path, part):
    found = simulated.PARTS[part](simulated.Stand(PROGRAM, tmp_path))
    pattern = claims.expected(TEMPLATE, printed.values() | {f"{part}_{name}": value for name, value in found.items()})
    assert re.fullmatch(pattern, PAGE), claims.differing_line(pattern, PAGE)


def test_nothing_is_computed_that_the_page_does_not_show():
    shown = {name for _, name, _, _ in string.Formatter().parse(TEMPLATE) if name}
    # Of the parameters all is computed alike.
    assert [name for name in printed.values() if name not in shown and not name.startswith("t1_")] == []


@pytest.mark.parametrize("table, columns", [
    ("table1_parameters.csv", ["nominal", "accuracy", "average", "deviation"]),
    ("table2_criteria.csv", ["nominal", "accuracy"]),
])
def test_each_number_of_the_first_two_tables_stands_in_its_row(table, columns):
    for row in printed.rows(printed.PAPER / table):
        symbol = row["symbol"]
        line = next(line for line in PAGE.splitlines() if line.startswith(f"| {symbol}, ") and "±" in line)
        numbers = set(re.findall(r"\d+(?:\.\d+)?", line))
        assert {row[column] for column in columns} <= numbers, line

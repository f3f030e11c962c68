"""docs/paper.md is what scripts/evidence/paper writes: what the paper's tables tell, and what quick runs give."""

import re
import string
import subprocess
import sys

import pytest
from test_acceptance import PROGRAM, ROOT

sys.path.insert(0, str(ROOT / "scripts/evidence/claims"))
import claims  # noqa: E402
import printed  # noqa: E402
import simulated  # noqa: E402

TEMPLATE = claims.TEMPLATE.read_text(encoding="utf-8")
PAGE = (ROOT / "docs/paper.md").read_text(encoding="utf-8")


def test_the_page_agrees_with_the_tables():
    done = subprocess.run([ROOT / "scripts/evidence/paper", "--check"], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.parametrize("right, wrong", [
    ("needs 1.27 mm", "needs 1.28 mm"),                          # arithmetic with the tables
    ("  0.0250  ", "  0.0205  "),                                # the clearance of a row of Table 3
    ("lacks M", "lacks m"),                                      # a sentence
])
def test_a_wrong_page_is_found(right, wrong):
    pattern = claims.expected(TEMPLATE, printed.values())
    assert re.fullmatch(pattern, PAGE) and right in PAGE
    assert not re.fullmatch(pattern, PAGE.replace(right, wrong))


@pytest.mark.parametrize("part", ["rig", "run", "a", *(pytest.param(part, marks=pytest.mark.long) for part in ("map", "s"))])
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


@pytest.mark.parametrize("section, numbers", [
    ("Section 2", ["SAE 15W-40", "0.3 dm3", "±20 % (also section 3)", "-0.02 and +0.03 mm of 25 mm", "±0.02 mm", "NCTE 2300",
                   "BF1K-3EB of 8.5 x 8.5 mm", "PicoScope 3000", "±7 %", "300 rpm", "120 degC", "5,000 s"]),
    ("Table 2", ["31.4"]),
    ("Section 3", ["±2.5 %"]),
    ("Section 5.1", ["0.016 s", "0.046 ±0.002", "between 4 and 22 W"]),
    ("Sections 5.2", ["50 points", "150 s", "20 minutes", "8, 27, 34, 41, 42, 49", "3, 11, 24, 25, 37, 40, 42, 46, 48, 49",
                      "37 of 50", "10 of 50, 20 %", "10 of 50 |"]),
    ("Section 6", ["h 0.010 to 0.030", "B 18.5 to 19.5", "D 24.4 to 25.8", "C 85 to 125", "beta 10 to 17", "F0 35 to 60",
                   "epsilon from 0.35", "80.8 to 83.5 degC"]),
])
def test_each_number_of_the_text_stands_in_what_the_paper_says(section, numbers):
    part = re.search(rf"^## {re.escape(section)}\b.*?(?=^## )", PAGE, re.M | re.S)[0]
    # The first column; of Table 2, which has the stand's values beside its own, all.
    said = part if section == "Table 2" else "\n".join(line.split(" | ")[0] + " |" for line in part.splitlines())
    assert [number for number in numbers if number not in said] == []


def test_table_3_has_its_points():
    points = [row["point"] for row in printed.rows(printed.PAPER / "table3_solutions.csv")]
    assert re.search(r"^point +(.*)$", PAGE, re.M)[1].split() == points

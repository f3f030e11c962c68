"""The tutorial, word for word: its commands run in a clean folder, in the shell and in Python, and print what it shows.
"""

import os
import re
import subprocess
import sys

import pytest
from python_package import ENVIRONMENT
from test_acceptance import PROGRAM, ROOT

PAGE = ROOT / "docs" / "tutorial.md"
TEXT = PAGE.read_text(encoding="utf-8")
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```", re.MULTILINE | re.DOTALL)
BLOCKS = BLOCK.findall(TEXT)
ANSWERS = (0, 1, 3)
LEFT_OUT = "..."


def shown(block):
    """The commands of a block, each with the lines that it shows."""
    for part in re.split(r"^\$ ", block, flags=re.MULTILINE)[1:]:
        command, _, lines = part.partition("\n")
        yield command, lines.splitlines()


def agrees(lines, came):
    """Whether lines are what came, where `...` stands for any number of them."""
    pattern = "".join(r"(?:.*\n)*?" if line.strip() == LEFT_OUT else re.escape(line.rstrip()) + r" *\n" for line in lines)
    return re.fullmatch(pattern, "".join(f"{line.rstrip()}\n" for line in came.splitlines())) is not None


@pytest.fixture
def clone(tmp_path):
    """What a clone holds after the program was built."""
    for name in ("dist", "examples"):
        (tmp_path / name).symlink_to(ROOT / name)
    return tmp_path


def test_the_shell(clone):
    environment = {**os.environ, "PATH": f"{PROGRAM.parent}{os.pathsep}{os.environ['PATH']}"}
    folder = clone
    for kind, block in BLOCKS:
        if kind == "toml":
            (folder / "my.toml").write_text(block, encoding="utf-8")
        if kind != "console":
            continue
        for command, lines in shown(block):
            done = subprocess.run(["bash", "-c", command], cwd=folder, text=True, capture_output=True, env=environment)
            assert done.returncode in ANSWERS, done.stdout + done.stderr
            assert agrees(lines, done.stdout), f"{PAGE.name}: `{command}` printed\n{done.stdout}"
            folder = next(iter((folder / place for place in re.findall(r"\bcd (\w+)", command))), folder)
    assert (folder / "results/my/report.html").is_file()


PYTHON = """
import doctest, sys
test = doctest.DocTestParser().get_doctest(open(sys.argv[1]).read(), {}, "tutorial.md", sys.argv[2], 0)
sys.exit(doctest.DocTestRunner(optionflags=doctest.ELLIPSIS).run(test).failed != 0)
"""


def test_python(tmp_path):
    """One session; the study is written before the block that loads it."""
    lines = []
    for kind, block in BLOCKS:
        if kind == "toml":
            (tmp_path / "study.txt").write_text(block, encoding="utf-8")
            lines.append(">>> _ = open('my.toml', 'w').write(open('study.txt').read())\n")
        elif kind == "python":
            lines.append(block)
    session = tmp_path / "session.txt"
    session.write_text("\n".join(lines), encoding="utf-8")
    done = subprocess.run([sys.executable, "-c", PYTHON, session, PAGE], cwd=tmp_path, env=ENVIRONMENT, text=True, capture_output=True)
    assert done.returncode == 0, done.stdout + done.stderr
    assert (tmp_path / "curves.png").is_file() and (tmp_path / "sensitivity.png").is_file()


def test_both_have_the_same_steps():
    kinds = [kind for kind, _ in BLOCKS if kind != "toml"]
    assert kinds.count("console") == 6 and kinds.count("python") == 7
    assert len(TEXT.split()) <= 900


def test_the_recording_is_the_scripts(tmp_path):
    script = ROOT / "examples/tutorial/record.py"
    there = (script.parent / "recording.csv").read_text()
    for file in (script, script.parent / "recording.csv"):
        (tmp_path / file.name).write_bytes(file.read_bytes())
    (tmp_path / "recording.csv").unlink()
    environment = {**os.environ, "PATH": f"{PROGRAM.parent}{os.pathsep}{os.environ['PATH']}"}
    subprocess.run([sys.executable, tmp_path / script.name, ROOT / "dist/PlainBearingStand.fmu"], check=True, env=environment)
    assert (tmp_path / "recording.csv").read_text() == there


@pytest.mark.parametrize("lines, came, right", [
    (["a", "...", "c"], "a\nb\nb\nc\n", True), (["a", "..."], "a\n", True), (["a"], "a\nb\n", False), (["a", "...", "c"], "a\nb\n", False),
    (["1.5 N"], "1.6 N\n", False), ([], "", True), ([], "x\n", False)])
def test_other_words_and_numbers_are_found(lines, came, right):
    assert agrees(lines, came) == right

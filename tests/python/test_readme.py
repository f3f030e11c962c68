"""The README's commands, in their order, as a newcomer would give them."""

import os
import re
import shutil
import subprocess
import sys

import pytest
from test_acceptance import PROGRAM, ROOT

# A block of TOML is the study that the commands after it run; commands are indented, or stand in the table of tools.
PART = re.compile(r"^```toml\n([\s\S]*?)^```|^    (\S.*)|^\| (?:orchestrator|fmpy) \| `(.*)` \|$", re.MULTILINE)
# Not verified and inconclusive are answers.
ANSWERS = "[ $code = 0 ] || [ $code = 1 ] || [ $code = 3 ]"


def script():
    """The shell's script, whose first failure ends it."""
    lines = []
    for study, command, tool in PART.findall((ROOT / "README.md").read_text(encoding="utf-8")):
        command = re.sub(r"\s+# .*", "", command or tool)
        if command == "scripts/test":
            continue  # It runs this test.
        if study:
            lines.append(f"cat > my.toml <<'END'\n{study}END")
        elif command.startswith("fmpy"):
            lines.append(f'"$PYTHON" -c "import fmpy; {command}" || exit 2')
        elif " verify " in command or command == "scripts/verify":
            lines.append(f"code=0; {command} || code=$?; {ANSWERS} || exit 2")
        else:
            lines.append(f"{command} || exit 2")
    assert len(lines) >= 8, lines
    return lines


def run(lines, folder, **environment):
    done = subprocess.run(["bash", "-xc", "\n".join(lines)], cwd=folder, text=True, capture_output=True,
                          env={**os.environ, "PYTHON": sys.executable, **environment})
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_the_commands_work(tmp_path):
    """Those that need no building, with the FMU and the program that are there, fewer points and shorter runs."""
    (tmp_path / "dist").symlink_to(ROOT / "dist")
    built = [line for line in script() if not re.search(r"^export|scripts/verify", line)]
    less = {"points = 1024": "points = 8", "stop = 150": "stop = 5", "init my.fmu": "init my.fmu --stop 5 --step 0.1"}
    assert all(sum(much in line for line in built) == 1 for much in less)
    lines = built
    for much, little in less.items():
        lines = [line.replace(much, little) for line in lines]
    assert len(script()) == len(lines) + 2
    run(lines, tmp_path, PATH=f"{PROGRAM.parent}:{os.environ['PATH']}")
    assert (tmp_path / "results/my/report.html").is_file()


def test_the_first_screen_is_the_programs(tmp_path):
    shown = re.search(r"^```text\n([\s\S]*?)^```", (ROOT / "README.md").read_text(encoding="utf-8"), re.MULTILINE)[1]
    command = [PROGRAM, "verify", ROOT / "studies/paper-table3.toml", "--output", tmp_path]
    assert subprocess.run(command, text=True, capture_output=True).stdout.startswith(shown)


@pytest.mark.long
def test_the_commands_work_in_a_new_clone(tmp_path):
    clone = tmp_path / "clone"
    subprocess.run(["git", "clone", "--quiet", ROOT, clone], check=True)
    told = run(script()[:1], clone, CARGO_TARGET_DIR="target")
    assert len(told.splitlines()) <= 60, told
    assert str(clone / "results/paper/report.html") in told and str(clone / "target/release") in told
    run(script()[1:], clone, CARGO_TARGET_DIR="target")


@pytest.mark.parametrize("fault", ["", "cargo", "package-fmu"])
def test_verify_says_little(fault, tmp_path):
    """With talkative commands in the place of those that build; when one fails, its log is named."""
    for folder in ("scripts", "studies"):
        shutil.copytree(ROOT / folder, tmp_path / folder, ignore=shutil.ignore_patterns("__pycache__"))
    (tmp_path / "dist").symlink_to(ROOT / "dist")
    (tmp_path / "target").mkdir()
    (tmp_path / "target/release").symlink_to(PROGRAM.parent)
    for file in (tmp_path / "cargo", tmp_path / "scripts/package-fmu"):
        file.write_text(f"#!/bin/sh\nseq 1000\nexit {int(file.name == fault)}\n")
        file.chmod(0o755)
    environment = {**os.environ, "PATH": f"{tmp_path}:{os.environ['PATH']}", "CARGO_TARGET_DIR": "target"}
    done = subprocess.run([tmp_path / "scripts/verify"], text=True, capture_output=True, env=environment)
    said = (done.stdout + done.stderr).splitlines()
    assert len(said) <= 60 and (done.returncode == 0) == (not fault), said
    if fault:
        assert said[-1].startswith("failed: ") and f"{tmp_path}/.cache/" in said[-1]
    else:
        assert str(tmp_path / "results/paper/report.html") in said[-2] and "export PATH=" in said[-1]


@pytest.mark.parametrize("name", ["scripts/wheel", "scripts/package-fmu", "scripts/verify"])
def test_without_cargo_one_line_says_so(name, tmp_path):
    for tool in ("bash", "dirname", "env"):
        (tmp_path / tool).symlink_to(f"/usr/bin/{tool}")
    (tmp_path / "python3").symlink_to(sys.executable)
    done = subprocess.run([ROOT / name], text=True, capture_output=True, env={"PATH": str(tmp_path)})
    assert done.returncode != 0 and done.stdout == ""
    assert done.stderr.count("\n") == 1 and "cargo is missing: install Rust" in done.stderr, done.stderr

"""Puts the program, the FMU, the studies and the tutorial's recording into the wheel."""

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

LIBRARIES = {"win32": "plain_bearing_stand.dll", "darwin": "libplain_bearing_stand.dylib"}


class Contents(BuildHookInterface[Any]):
    """``scripts/wheel`` names the program (``WHEEL_PROGRAM``), its platform (``WHEEL_PLATFORM``) and the FMU (``WHEEL_FMU``).
    Otherwise, as where pip installs the source package, cargo builds both for this machine."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        # The source package has the sources beside this file, a checkout has them around it.
        sources = Path(self.root) / "sources"
        if not sources.is_dir():
            sources = Path(self.root).parent
        program, platform, fmu = (os.environ.get(f"WHEEL_{name}", "") for name in ("PROGRAM", "PLATFORM", "FMU"))
        build_data["pure_python"] = False
        if program and platform and fmu:
            build_data["tag"] = f"py3-none-{platform}"
        else:
            program, fmu = built(sources)
            build_data["infer_tag"] = True
        build_data["force_include"] |= {
            program: f"fmu_orchestrator/bin/{Path(program).name}",
            fmu: "fmu_orchestrator/dist/PlainBearingStand.fmu",
            str(sources / "studies"): "fmu_orchestrator/studies",
            str(sources / "examples/tutorial/recording.csv"): "fmu_orchestrator/examples/tutorial/recording.csv",
        }


def built(sources: Path) -> tuple[str, str]:
    """The program and the FMU."""
    # One by one: together, cargo would give each the features that the other wants.
    for package in ("orchestrator", "plain-bearing-stand"):
        run("cargo", "build", "--profile", "fmu", "--locked", "--package", package, cwd=sources)
    folder = sources / os.environ.get("CARGO_TARGET_DIR", "target") / "fmu"
    fmu = folder / "PlainBearingStand.fmu"
    library = folder / LIBRARIES.get(sys.platform, "libplain_bearing_stand.so")
    run(sys.executable, "scripts/package-fmu", "--local", str(library), "--output", str(fmu), cwd=sources)
    return str(folder / ("orchestrator.exe" if sys.platform == "win32" else "orchestrator")), str(fmu)


def run(*command: str, cwd: Path) -> None:
    try:
        subprocess.run(command, cwd=cwd, stdout=sys.stderr, check=True)
    except FileNotFoundError:
        raise SystemExit(f"{command[0]} is missing: install Rust first (rustup)") from None
    except subprocess.CalledProcessError as error:
        raise SystemExit(f"`{' '.join(command)}` failed with {error.returncode}") from None

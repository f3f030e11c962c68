"""Puts the program, the FMU, the studies and the tutorial's recording into the wheel."""

import os
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


class Contents(BuildHookInterface[Any]):
    """``scripts/wheel`` names the program (``WHEEL_PROGRAM``), its platform (``WHEEL_PLATFORM``) and the FMU (``WHEEL_FMU``)."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        program, platform, fmu = (os.environ.get(f"WHEEL_{name}", "") for name in ("PROGRAM", "PLATFORM", "FMU"))
        if not (program and platform and fmu):
            raise SystemExit("the wheel holds a program and an FMU: build it with scripts/wheel")
        root = Path(self.root).parent
        build_data["pure_python"] = False
        build_data["tag"] = f"py3-none-{platform}"
        build_data["force_include"] |= {
            program: f"fmu_orchestrator/bin/{Path(program).name}",
            fmu: "fmu_orchestrator/dist/PlainBearingStand.fmu",
            str(root / "studies"): "fmu_orchestrator/studies",
            str(root / "examples/tutorial/recording.csv"): "fmu_orchestrator/examples/tutorial/recording.csv",
        }

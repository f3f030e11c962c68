"""The FMUs' archives: the same bytes for the same contents."""

import zipfile
from dataclasses import dataclass
from pathlib import Path

from . import parameters
from .common import ROOT

TERMINALS = "terminalsAndIcons/terminalsAndIcons.xml"
EPOCH = (1980, 1, 1, 0, 0, 0)


@dataclass
class Form:
    """One of the FMUs that are made of the same binaries: its version of FMI, its description, its name."""

    version: int
    description: Path
    suffix: str

    def beside(self, output):
        """The FMU's file, beside that of FMI 2.0 Co-Simulation."""
        return output.with_name(f"{output.stem}{self.suffix}{output.suffix}")


FORMS = [
    Form(2, ROOT / "modelDescription/modelDescription.xml", ""),
    Form(3, ROOT / "fmu/descriptions/fmi3.xml", "-fmi3"),
    Form(2, ROOT / "fmu/descriptions/me.xml", "-me"),
    Form(3, ROOT / "fmu/descriptions/me-fmi3.xml", "-me-fmi3"),
]


def write(output, rows, form, more=None):
    """Zips modelDescription/, the form's description, the binaries and the parameter sets; `more` has further files by places."""
    folder = ROOT / "modelDescription"
    files = {path.relative_to(folder).as_posix(): path.read_bytes()
             for path in folder.rglob("*") if path.is_file()}
    files["modelDescription.xml"] = form.description.read_bytes()
    files |= {place: row.file.read_bytes() for row in rows if row.file for place in row.places(form.version)}
    files["documentation/licenses/LICENSE"] = (ROOT / "LICENSE").read_bytes()
    icon, terminals = files.pop("model.png"), files.pop(TERMINALS)
    # Terminals came with FMI 3.0. FMI Library reports a fatal error when their version is not the model description's.
    files |= {"model.png": icon} if form.version == 2 else {TERMINALS: terminals, "terminalsAndIcons/icon.png": icon}
    files |= parameters.files()
    files |= {place: file.read_bytes() for place, file in (more or {}).items()}
    output.parent.mkdir(parents=True, exist_ok=True)
    partial = output.with_suffix(".partial")
    with zipfile.ZipFile(partial, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as fmu:
        for name in sorted(files):
            entry = zipfile.ZipInfo(name, EPOCH)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.create_system = 3
            entry.external_attr = (0o755 if name.startswith("binaries/") else 0o644) << 16
            fmu.writestr(entry, files[name])
    partial.replace(output)

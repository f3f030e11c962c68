"""The FMU's archive: the same bytes for the same contents."""

import zipfile

from . import parameters
from .common import ROOT

EPOCH = (1980, 1, 1, 0, 0, 0)


def write(output, rows):
    """Zips modelDescription/, the binaries and the parameter sets."""
    folder = ROOT / "modelDescription"
    files = {path.relative_to(folder).as_posix(): path.read_bytes()
             for path in folder.rglob("*") if path.is_file()}
    files |= {row.place: row.file.read_bytes() for row in rows if row.file}
    files["documentation/licenses/LICENSE"] = (ROOT / "LICENSE").read_bytes()
    files["terminalsAndIcons/icon.png"] = files["model.png"]
    files |= parameters.files()
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

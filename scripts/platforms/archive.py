"""The FMU's archive: the same bytes for the same contents."""

import zipfile

from .common import ROOT

EPOCH = (1980, 1, 1, 0, 0, 0)


def write(output, rows):
    """Zips modelDescription/ and the binaries."""
    folder = ROOT / "modelDescription"
    files = {path.relative_to(folder).as_posix(): path
             for path in folder.rglob("*") if path.is_file()}
    files |= {row.place: row.file for row in rows if row.file}
    files["documentation/licenses/LICENSE"] = ROOT / "LICENSE"
    output.parent.mkdir(parents=True, exist_ok=True)
    partial = output.with_suffix(".partial")
    with zipfile.ZipFile(partial, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as fmu:
        for name in sorted(files):
            entry = zipfile.ZipInfo(name, EPOCH)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.create_system = 3
            entry.external_attr = (0o755 if name.startswith("binaries/") else 0o644) << 16
            fmu.writestr(entry, files[name].read_bytes())
    partial.replace(output)

"""FMI Library 3: reads an FMU as PyFMI and OMSimulator, which stand on it, do."""

import ctypes
import os
import shutil
import sys
import tempfile

from scenario import FMU, PROGRAM, VERSION, report

library = ctypes.CDLL(PROGRAM)
for name in ("jm_get_default_callbacks", "fmi_import_allocate_context", "fmi2_import_parse_xml", "fmi3_import_parse_xml"):
    getattr(library, name).restype = ctypes.c_void_p
context = ctypes.c_void_p(library.fmi_import_allocate_context(ctypes.c_void_p(library.jm_get_default_callbacks())))


def read(folder):
    """What it says of the files in a folder."""
    with tempfile.TemporaryFile() as told:
        # Its messages go to stderr.
        sys.stderr.flush()
        os.dup2(told.fileno(), 2)
        parse = library.fmi2_import_parse_xml if VERSION == "2.0" else library.fmi3_import_parse_xml
        known = parse(context, folder.encode(), None)
        told.seek(0)
        lines = told.read().decode(errors="replace").splitlines()
    faults = [line for line in lines if "ERROR" in line or "WARNING" in line or "FATAL" in line]
    return faults if known else faults or ["the model description is not read"]


note = ""
with tempfile.TemporaryDirectory() as folder:
    library.fmi_import_get_fmi_version(context, FMU.encode(), folder.encode())  # unpacks it, too
    findings = read(folder)
    if VERSION != "2.0" and any("GraphicalRepresentation" in line for line in findings):
        note = "but for the GraphicalRepresentation in terminalsAndIcons.xml, which it does not know"
        shutil.rmtree(f"{folder}/terminalsAndIcons")
        findings = read(folder)
report("", note=note, findings=findings)

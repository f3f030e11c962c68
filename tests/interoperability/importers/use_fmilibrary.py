"""FMI Library 3: reads an FMU as PyFMI and OMSimulator, which stand on it, do; its messages go to stderr.

    use_fmilibrary.py libfmilib_shared.so FMU
"""

import ctypes
import sys
import tempfile

library, fmu = ctypes.CDLL(sys.argv[1]), sys.argv[2].encode()
for name in ("jm_get_default_callbacks", "fmi_import_allocate_context", "fmi2_import_parse_xml", "fmi3_import_parse_xml"):
    getattr(library, name).restype = ctypes.c_void_p
context = ctypes.c_void_p(library.fmi_import_allocate_context(ctypes.c_void_p(library.jm_get_default_callbacks())))
with tempfile.TemporaryDirectory() as folder:
    # Unpacks it; in its numbers 2 is FMI 2.0, 3 is FMI 3.0.
    version = library.fmi_import_get_fmi_version(context, fmu, folder.encode())
    read = {2: library.fmi2_import_parse_xml, 3: library.fmi3_import_parse_xml}[version]
    assert read(context, folder.encode(), None), "the model description is not read"

"""The unwinder of programs for Linux: the system's, although Zig has none to link with.

When an FMU in C++ throws, its unwinder asks each function of the program above it whether that one catches. If program
and FMU had different unwinders, one would read the other's memory: the process would end with SIGSEGV, as if the FMU had
used a wrong address. With the same one it ends with SIGABRT and says that an exception came. So the program takes
libgcc_s, as C++ does; every Linux with glibc has it. Zig would put LLVM's unwinder into the program. A library that has
nothing but the names is enough to link with.
"""

from .common import CACHE, run

LIBRARY = "libgcc_s.so.1"
# The functions that Rust calls, by the version of libgcc that brought them.
FUNCTIONS = {
    "GCC_3.0": ["DeleteException", "GetDataRelBase", "GetIP", "GetLanguageSpecificData", "GetRegionStart", "GetTextRelBase",
                "RaiseException", "Resume", "SetGR", "SetIP"],
    "GCC_3.3": ["Backtrace", "FindEnclosingFunction", "GetCFA"],
    "GCC_4.2.0": ["GetIPInfo"],
}


def library(target, python):
    """A library with the names, for a target that Zig knows."""
    folder = CACHE / f"unwinder-{target}"
    folder.mkdir(parents=True, exist_ok=True)
    source, versions = folder / "names.c", folder / "names.map"
    names = {version: [f"_Unwind_{name}" for name in group] for version, group in FUNCTIONS.items()}
    source.write_text("".join(f"void {name}(void) {{}}\n" for group in names.values() for name in group), encoding="utf-8")
    versions.write_text("".join(f"{version} {{ global: {'; '.join(group)}; }};\n" for version, group in names.items()),
                        encoding="utf-8")
    run([python, "-m", "ziglang", "cc", "-target", target, "-shared", "-nostdlib", f"-Wl,-soname,{LIBRARY}",
         f"-Wl,--version-script={versions}", "-o", folder / LIBRARY, source])
    return folder / LIBRARY

"""The stand as a WebAssembly module, with which the playground simulates."""

from .build import LIBRARY, PROFILE, RUSTC, flags
from .common import IDENTIFIER, run, say, target_dir
from .cross import compiler_version, fetched, library_source

TARGET = "wasm32-unknown-unknown"
# Importers look into any folder of extra/; the name follows the FMI standard's advice, a domain in reverse.
PLACE = f"extra/com.github.plain-bearing/{IDENTIFIER}.wasm"


def module():
    """Builds the module."""
    more, environment = [], {}
    if not fetched(TARGET):
        library = library_source(compiler_version())
        more = ["-Zbuild-std=std,panic_abort"]
        environment = {"RUSTC_BOOTSTRAP": "1", "__CARGO_TESTS_ONLY_SRC_ROOT": str(library)}
    say("building the WebAssembly module")
    run(["cargo", *RUSTC, *LIBRARY, "--target", TARGET, *more], env=environment | flags(TARGET, "-Cstrip=symbols"))
    return target_dir() / TARGET / PROFILE / "plain_bearing_stand.wasm"

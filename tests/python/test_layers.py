"""The layers of the house: which module of the orchestrator may use which, and that no files import each other in a circle: those of a
crate, and those of the Python package, not even for their types. And that unit tests which lie beside the code are compiled.

A module on a floor may use modules of the floors below it, and no others. To put a module elsewhere, move its name in FLOORS, the only
place that knows the order.
"""

import ast
import re
import tomllib
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / "python" / "fmu_orchestrator"
ORCHESTRATOR = "orchestrator/src"

# The orchestrator's modules, from the ground up.
FLOORS = [
    {"error"},
    {"junit"},
    {"source", "recording", "plain"},
    {"results"},
    {"session", "identify"},
    {"options"},
    {"methods"},
    {"report"},
    {"compare", "packed"},
    {"reruns"},
    {"cli"},
    {"commands"},
    {"lib"},
    {"main"},
]

# The sources in which no files may import each other in a circle.
HOUSES = [
    "crates/calibration/src",
    "crates/conformity/src",
    "crates/curves/src",
    "crates/fmu-check/src",
    "crates/fmu-export/src",
    "crates/fmu-import/src",
    "crates/fmu-points/src",
    "crates/journal-bearing/src",
    "crates/number-tables/src",
    "crates/parameter-regions/src",
    "crates/point-journal/src",
    "crates/result-document/src",
    "crates/rig-signals/src",
    "crates/run-budget/src",
    "crates/sampling/src",
    "crates/sensitivity/src",
    "crates/study/src",
    "fmu/src",
    ORCHESTRATOR,
]

# Files that are meant to know each other: the stand has variables, and these say where in the stand they are.
MEANT = [("stand.rs", "variables.rs", "variables/")]

# Comments, strings and characters: no word in them is a path. A lifetime has no second quote.
SILENT = re.compile(r"""//[^\n]*|/\*|r(#*)".*?"\1|"[^"\\]*(?:\\.[^"\\]*)*"|'(?:\\.[^']*|[^\\'])'""", re.DOTALL)
# What only tests have, up to the word that says what it is.
TESTS = re.compile(r"#\s*\[\s*cfg\s*\(\s*(?:test\s*|all\s*\(\s*test\b[^]]*)\)\s*](?:\s*#\s*\[[^]]*])*\s*(?:pub\b\s*(?:\([^)]*\)\s*)?)?"
                   r"(?:(?:const|async|unsafe|extern)\s+)*(?:mod|use|fn)\b")
INLINE = re.compile(r"\bmod\s+(\w+)\s*(?={)")
MACRO = re.compile(r"(?<=\w)!\s*(?:\w+\s*)?(?=[({[])")
# A `use` (`use<'a>` is none), a path, or the rest of one that began with a type, another crate or a macro's variable.
PATHS = re.compile(r"(?P<public>\bpub\b\s*(?:\([^)]*\)\s*)?)?\buse\b(?P<use>[\w\s:{},*$]+);"
                   r"|(?:::|\$(?!crate\b))\s*\w+(?:\s*::\s*\w+)*+|(?P<path>\b\w++(?:\s*::\s*\w++)++)")
UP = ("crate", "self", "super")


def cut(text, pattern, end):
    """What is left of a text without the pieces that begin with a pattern, and these, each with its beginning."""
    left, pieces, at = [], [], 0
    while found := pattern.search(text, at):
        left.append(text[at:found.start()])
        at = end(text, found)
        pieces.append((found, text[found.end():at]))
    return " ".join([*left, text[at:]]), pieces


def end_of_silence(text, begun):
    """Comments between stars may lie within each other."""
    at, depth = begun.end(), int(begun[0] == "/*")
    while depth:
        mark = re.compile(r"/\*|\*/").search(text, at)
        at, depth = mark.end(), depth + (1 if mark[0] == "/*" else -1)
    return at


def end_of_item(code, begun, ends=";}"):
    """An item ends with its semicolon or with the brace that closes it."""
    depth = 0
    for mark in re.compile(r"[][(){};]").finditer(code, begun.end()):
        depth += (mark[0] in "([{") - (mark[0] in ")]}")
        if depth == 0 and mark[0] in ends:
            return mark.end()
    raise ValueError(f"`{begun[0]}` has no end")


def end_of_macro(code, begun):
    return end_of_item(code, begun, ")]}")


def parts(code, module):
    """The code of a module and of those that are written within it, each with its path."""
    rest, inner = cut(code, INLINE, end_of_item)
    yield module, rest
    for begun, piece in inner:
        yield from parts(piece, (*module, begun[1]))


def leaves(tree):
    """The paths of a `use`: a::{self, b::c as d} has a::self and a::b::c as d."""
    path, groups = [], [[]]
    for word in [*re.findall(r"\w+|[{},*]", tree), ","]:
        if word == "{":
            groups.append([*path])
        elif word in ",}":
            if len(path) > len(groups[-1]):
                yield path
            if word == "}":
                groups.pop()
            path = [*groups[-1]]
        else:
            path.append(word)


def absolute(path, module, children):
    """A path from the crate's root; None where it leads out of the crate."""
    if path and path[0] in children:
        return (*module, *path)
    if not path or path[0] not in UP:
        return None
    start = () if path[0] == "crate" else module
    while path and path[0] in UP:
        start, path = start[:-1] if path[0] == "super" else start, path[1:]
    return (*start, *path)


def named(code, module, children):
    """The paths that code names, each with the name under which it hands it on, if it does."""
    code, macros = cut(code, MACRO, end_of_macro)
    for _, words in macros:
        # What a macro makes of a module's name is its own affair: there, only the words of UP begin a path for certain.
        yield from named(words, module, ())
    for found in PATHS.finditer(code):
        # A single word was brought here by a `use`.
        if found["path"]:
            yield absolute(re.findall(r"\w+", found["path"]), module, children), None
        for path in leaves(found["use"] or ""):
            given = path.pop() if "as" in path else None
            if given:
                path.pop()
            last = path[-1]
            own = absolute(path[:-1] if last in ("self", "*") else path, module, children)
            yield own, (given or own[-1]) if own and found["public"] and last != "*" else None


def path_of(file):
    """The path of a file's module."""
    stem = file.removesuffix(".rs").removesuffix("/mod")
    return () if stem in ("lib", "mod") else tuple(stem.split("/"))


def top(file):
    """The top-level module of a file."""
    return file.split("/")[0].removesuffix(".rs")


class Tree:
    """The files of a crate, and as arrows which file uses which, with the name for which it does. Tests are left out."""

    def __init__(self, folder):
        names = [path.relative_to(folder).as_posix() for path in folder.rglob("*.rs")]
        names = [name for name in names if not name.endswith("tests.rs") and not name.startswith("bin/")]
        self.files = {path_of(name): name for name in names}
        # The names that a module hands on, and the paths from which it has them.
        self.handed_on = {}
        paths = []
        for module, file in self.files.items():
            children = {other[-1] for other in self.files if other and other[:-1] == module}
            code, _ = cut((folder / file).read_text(encoding="utf-8"), SILENT, end_of_silence)
            code, _ = cut(code, TESTS, end_of_item)
            for inner, part in parts(code, module):
                for path, given in named(part, inner, children):
                    if path is not None:
                        paths.append((module, path))
                    if given:
                        self.handed_on[module, given] = path
        used = {(module, *end) for module, path in set(paths) if (end := self.resolve(path))}
        # A part may name what belongs to the whole.
        self.arrows = sorted((self.files[module], self.files[to], name) for module, to, name in used
                             if module != to and not (to and module[:len(to)] == to))

    def resolve(self, path, depth=0):
        """The module in which a path ends, and the name that is used of it."""
        module = next((path[:n] for n in range(len(path), -1, -1) if path[:n] in self.files), None)
        if module is None or not path:
            return None
        name = path[len(module)] if len(path) > len(module) else module[-1]
        # A module of that name would be in the path: the name is one that is handed on, or defined here.
        origin = self.handed_on.get((module, name)) if len(path) > len(module) else None
        return self.resolve(origin, depth + 1) if origin and depth < 10 else (module, name)

    def circles(self):
        """The sets of files that use each other, directly or through others."""
        following = {}
        for file, to, _ in self.arrows:
            following.setdefault(file, set()).add(to)
        reached = {file: reach(following, file) for file in following}
        return {frozenset(other for other in own if file in reached.get(other, ())) for file, own in reached.items() if file in own}


def reach(following, file):
    reached, to_do = set(), [file]
    while to_do:
        new = following.get(to_do.pop(), set()) - reached
        reached |= new
        to_do += new
    return reached


def floor(module):
    found = [k for k, modules in enumerate(FLOORS) if module in modules]
    assert found, f"the module `{module}` is on no floor: add it to FLOORS"
    return found[0]


@pytest.fixture(scope="module")
def trees():
    return {house: Tree(ROOT / house) for house in HOUSES}


def test_no_arrow_goes_back_up(trees):
    tree = trees[ORCHESTRATOR]
    for file, to, name in tree.arrows:
        upper, lower = top(file), top(to)
        assert upper == lower or floor(upper) > floor(lower), (
            f"src/{file} uses `{name}` of `{lower}`, which is not below `{upper}`: move what both need to a lower floor")
    known = {top(file) for file in tree.files.values()}
    for module in set().union(*FLOORS):
        assert module in known, f"FLOORS names `{module}`, which is gone"


def test_no_files_of_a_crate_import_each_other_in_a_circle(trees):
    found = []
    for house, tree in trees.items():
        assert tree.arrows, f"{house}: its files use each other, but this test sees nothing"
        for circle in tree.circles():
            if not any(all(file.startswith(meant) for file in circle) for meant in MEANT):
                arrows = [f"{file} uses {name} of {to}" for file, to, name in tree.arrows if {file, to} <= circle]
                found.append(f"in {house}: " + "\n  ".join(arrows))
    assert not found, "\n".join(found)


@pytest.fixture
def write(tmp_path):
    """Writes files of a crate and reads it."""
    def write(**texts):
        for name, text in texts.items():
            path = tmp_path / f"{name.replace('__', '/')}.rs"
            path.parent.mkdir(exist_ok=True)
            path.write_text(text)
        return Tree(tmp_path)
    write(lib="pub mod high;\npub mod low;\n", low="pub struct Low;\n", low__own="pub fn g() {}",
          high__mod="pub mod part;\npub use part::Part;\n",
          high__part="use crate::low::{self, Low};\npub struct Part(Low);\n#[cfg(test)]\nmod tests { use crate::main::X; }")
    return write


def test_an_arrow_up_and_a_circle_of_files_are_found(write):
    tree = write(low="pub struct Low;\nfn f() { crate::high::part::g(); }")
    assert ("low.rs", "high/part.rs", "g") in tree.arrows
    assert tree.circles() == {frozenset({"high/part.rs", "low.rs"})}
    # Names that a module hands on belong to the file that defines them.
    tree = write(low="use crate::high::Part;\npub struct Low;")
    assert ("low.rs", "high/part.rs", "Part") in tree.arrows
    # The root names all in the macro that exports it, which is no use of it.
    tree = write(lib="pub mod high;\npub mod low;\nexport!(high::Part);\nfn f() { low::g(); }")
    assert [arrow for arrow in tree.arrows if arrow[0] == "lib.rs"] == [("lib.rs", "low.rs", "g")]


@pytest.mark.parametrize("text", [
    # A name that is handed on is used, and so is one within a macro, and one that only tests do without.
    "pub(crate) use crate::high::part::Part;",
    'fn f() { println!("{}", crate::high::part::g()); }',
    "#[cfg(not(test))]\nuse crate::high::part::Part;",
    "fn f() { assert!(g(&[crate::high::part::g()]), \"{}\", '\"'); }",
    "macro_rules! f { () => { $crate::high::part::g() } }",
    "pub mod inner { use super::super::high::part; }",
    "use crate::high::part::*;",
    "fn f<'a>(x: &'a str) -> Vec<crate::high::part::Part> { x == '\\''; }",
    "#[cfg(test)]\npub fn f(x: [u8; 3]) { { } }\nfn g() -> crate :: high /* one /* in */ another */ :: part::Part {}",
    "#[cfg(test)]\n#[path = \"x.rs\"]\nmod tests;\nfn f() { match r#\"a \" quote\"# { _ => <crate::high::part::Part>::new() } }",
])
def test_what_uses_a_name_is_seen(write, text):
    assert ("low.rs", "high/part.rs") in [arrow[:2] for arrow in write(low=text).arrows]


@pytest.mark.parametrize("text", [
    "//! crate::high::part::g()\n/* /* */ crate::high::part::g() */",
    'const A: &str = "\\" crate::high::part::g()";\nconst B: &[u8] = br##"x"# crate::high::part::g() "##;',
    "#[cfg(all(test, unix))]\n#[allow(unused)]\npub(crate) mod tests { fn f() { } use crate::high::part::g; }",
    "#[cfg(test)]\nuse crate::high::{part::g};",
    "#[cfg(test)]\nasync fn f(x: [u8; 3]) { { } crate::high::part::g() }",
    "use high::part::Part;\nfn f() { high::part::g(); <T>::own::g(); ::own::g() }\npub mod inner { use super::high::part; }",
])
def test_what_uses_nothing_is_not(write, text):
    assert [arrow for arrow in write(low=text).arrows if arrow[0] == "low.rs"] == []


def test_the_names_of_a_group_are_told_apart(write):
    tree = write(low="use std::{fs, io::{self, Read}};\npub use super::{low as own, high::{self, part::{Part as Own, g, *}, Part}};")
    assert [arrow[1:] for arrow in tree.arrows if arrow[0] == "low.rs"] == [
        ("high/mod.rs", "high"), ("high/part.rs", "Part"), ("high/part.rs", "g"), ("high/part.rs", "part")]
    assert {name: path for (module, name), path in tree.handed_on.items() if module == ("low",)} == {
        "own": ("low",), "high": ("high",), "Own": ("high", "part", "Part"), "g": ("high", "part", "g"), "Part": ("high", "Part")}


# A library without a harness of its own (`[lib] test = false`) has its unit tests in one of its test programs, which this file lists.
UNITS = "tests/stand/units.rs"
LISTED = re.compile(r'^#\[path = "(.*)"]\nmod \w+;$', re.MULTILINE)
# What only a harness would run.
UNHEARD = re.compile(r"#\s*!?\s*\[\s*(?:test\s*\]|cfg(?:_attr)?\s*\((?:[^]]*\W)?test\b)")


def without_harness():
    """The folders of the packages whose library has none."""
    with (ROOT / "Cargo.toml").open("rb") as file:
        members = tomllib.load(file)["workspace"]["members"]
    for folder in [folder for member in members for folder in ROOT.glob(member)]:
        with (folder / "Cargo.toml").open("rb") as file:
            if not tomllib.load(file).get("lib", {}).get("test", True):
                yield folder


def unheard(folder):
    """Files of such a package with tests that nothing runs."""
    units = folder / UNITS
    text = units.read_text(encoding="utf-8")
    listed = {(units.parent / path).resolve() for path in LISTED.findall(text)}
    if re.sub(r"//.*", "", LISTED.sub("", text)).strip():
        yield f"{UNITS}, which lists files and nothing else"
    if "\nmod units;\n" not in re.sub(r"^#\[.*\n.*", "", units.with_name("main.rs").read_text(encoding="utf-8"), flags=re.MULTILINE):
        yield f"{UNITS}, which main.rs does not name"
    for file in sorted((folder / "src").rglob("*.rs")):
        if file.name.endswith("tests.rs"):
            missing = file.resolve() not in listed
        else:
            code, _ = cut(file.read_text(encoding="utf-8"), SILENT, end_of_silence)
            missing = UNHEARD.search(code)
        if missing:
            yield file.relative_to(folder).as_posix()


def test_unit_tests_beside_the_code_are_compiled():
    folders = list(without_harness())
    assert ROOT / "fmu" in folders
    for folder in folders:
        assert not list(unheard(folder)), (
            f"nothing in {folder.name} runs the tests of these: put them into a file ..._tests.rs beside the code, and name it in {UNITS}")


NAMED = '#[path = "../../src/a_tests.rs"]\nmod a;\n'


@pytest.mark.parametrize("units, main, found", [
    (NAMED, "#![allow(x)]\nmod bush;\nmod units;\n", []),
    (NAMED, "mod bush;\n", [f"{UNITS}, which main.rs does not name"]),
    (NAMED, "mod bush;\n#[cfg(any())]\nmod units;\n", [f"{UNITS}, which main.rs does not name"]),
    (NAMED, "mod bush;\n// mod units;\n", [f"{UNITS}, which main.rs does not name"]),
    (f"#[cfg(any())]\n{NAMED}", "\nmod units;\n", [f"{UNITS}, which lists files and nothing else"]),
    (f"// {NAMED.replace(chr(10) + 'mod', chr(10) + '// mod')}", "\nmod units;\n", ["src/a_tests.rs"]),
])
def test_a_unit_test_that_nothing_runs_is_found(units, main, found, tmp_path):
    for name, text in {
        UNITS: units,
        "tests/stand/main.rs": main,
        "src/a.rs": '// #[cfg(test)]\nconst A: &str = "#[test]";\n#[cfg(not(windows))]\nmod latest;',
        "src/a_tests.rs": "#[test]\nfn f() {}",
        "src/b.rs": "#[cfg(test)]\nmod tests {}",
        "src/c.rs": "#[cfg(all(unix, test))]\nmod c_tests;",
        "src/d/tests.rs": "",
    }.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    assert list(unheard(tmp_path)) == [*found, "src/b.rs", "src/c.rs", "src/d/tests.rs"]


def imports(text: str) -> set[str]:
    """The modules of the same package that a file imports."""
    found = [node for node in ast.walk(ast.parse(text)) if isinstance(node, ast.ImportFrom) and node.level == 1]
    names = {alias.name for node in found if node.module is None for alias in node.names}
    return names | {node.module for node in found if node.module}


def test_no_circle():
    files = {file.stem: imports(file.read_text(encoding="utf-8")) for file in PACKAGE.glob("*.py")}
    assert "_study" in files["__init__"] and "_html" in files["_fmu"]
    list(TopologicalSorter(files).static_order())


def test_a_circle_is_found():
    with pytest.raises(CycleError):
        list(TopologicalSorter({"a": imports("from .b import x"), "b": imports("from . import a")}).static_order())

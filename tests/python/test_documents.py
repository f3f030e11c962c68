"""The documents: links and anchors lead somewhere, files that name a document name one that is there, the study reference has
every key of the schema, and all files name one version."""

import json
import re
import subprocess
import tomllib
from pathlib import Path

import jsonschema
import pytest
from test_acceptance import PROGRAM

ROOT = Path(__file__).resolve().parent.parent.parent
TRACKED = subprocess.run(["git", "ls-files"], cwd=ROOT, check=True, capture_output=True, text=True).stdout.splitlines()
DOCUMENTS = [name for name in TRACKED if name.endswith(".md") and (ROOT / name).is_file()]
SCHEMA = json.loads((ROOT / "studies/study.schema.json").read_text(encoding="utf-8"))
# Lines of code hold neither links nor headings.
CODE = re.compile(r"^( *)```.*?^\1```|`[^`\n]*`", re.MULTILINE | re.DOTALL)
LINK = re.compile(r"\]\(([^)\s]+)\)")


def text_of(name):
    return (ROOT / name).read_text(encoding="utf-8")


def anchors(text):
    """The anchors of a page's headings, as GitHub makes them."""
    found = set()
    fences = re.sub(r"^( *)```.*?^\1```", "", text, flags=re.MULTILINE | re.DOTALL)
    for heading in re.findall(r"^#+ +(.+?) *$", fences, re.MULTILINE):
        plain = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).lower()
        slug, number = re.sub(r"[^\w\- ]", "", plain).replace(" ", "-"), 0
        while (anchor := f"{slug}-{number}" if number else slug) in found:
            number += 1
        found.add(anchor)
    return found


def broken(name, text):
    """The links of a page that lead nowhere."""
    for target in LINK.findall(CODE.sub("", text)):
        if re.match(r"[a-z]+:", target):
            continue
        path, _, anchor = target.partition("#")
        file = (ROOT / name).parent / path if path else ROOT / name
        if not file.exists() or (anchor and anchor not in anchors(file.read_text(encoding="utf-8"))):
            yield target


def test_links_and_anchors_lead_somewhere():
    assert len(DOCUMENTS) > 20
    assert {name: found for name in DOCUMENTS if (found := list(broken(name, text_of(name))))} == {}


@pytest.mark.parametrize("link", ["verdict.md#no-such-heading", "none.md", "#nothing"])
def test_a_broken_link_is_found(link):
    assert list(broken("docs/README.md", f"See [this]({link}), not `[that](x)`.")) == [link]


def test_every_page_is_in_the_index():
    index = {Path(target.partition("#")[0]).as_posix() for target in LINK.findall(text_of("docs/README.md"))}
    pages = {Path(name).relative_to("docs").as_posix() for name in DOCUMENTS if name.startswith("docs/")}
    assert pages - index == {"README.md"}


def test_files_name_documents_that_are_there():
    named = re.compile(r"\bdocs/[\w./-]+\.md\b")
    missing = set()
    for name in TRACKED:
        if name == "CHANGELOG.md" or not re.search(r"(^scripts/|\.(rs|py|js|html|toml|md|yml|template|txt)$)", name):
            continue
        if (ROOT / name).is_file():
            found = named.findall((ROOT / name).read_text(encoding="utf-8", errors="replace"))
            missing |= {(name, document) for document in found if not (ROOT / document).exists()}
    assert missing == set()


def test_all_files_name_one_version():
    version = tomllib.loads(text_of("Cargo.toml"))["workspace"]["package"]["version"]
    cited, date = re.findall(r'^(?:version|date-released): "?([^"\n]+)"?$', text_of("CITATION.cff"), re.M)
    newest = re.search(r"^## \[(\d.*?)\] - (.*)$", text_of("CHANGELOG.md"), re.M)
    assert (cited, date) == newest.groups() and cited == version
    assert f"@v{version}\n" in text_of("docs/ci.md")


@pytest.mark.parametrize("place, page", [
    (SCHEMA["$defs"]["design"]["properties"]["method"], "running"), (SCHEMA["$defs"]["statistic"], "curves"),
    (SCHEMA["$defs"]["criterion"]["properties"]["metric"], "curves")])
def test_each_design_statistic_and_metric_has_its_words(place, page):
    text = text_of(f"docs/{page}.md")
    assert [name for name in place["enum"] if f"`{name}`" not in text] == []


def test_each_command_has_its_words():
    said = subprocess.run([PROGRAM, "--help"], check=True, capture_output=True, text=True).stdout
    commands = re.findall(r"^  ([a-z]+) ", said.partition("Commands:")[2].partition("Options:")[0], re.MULTILINE)
    assert len(commands) > 15
    assert [name for name in commands if not re.search(f"`{name}[` ]", text_of("docs/commands.md")) and name != "help"] == []


def blocks():
    return [tomllib.loads(block) for block in re.findall(r"^```toml\n(.*?)^```", text_of("docs/study.md"), re.M | re.S)]


def keys(schema, at=""):
    """The keys that a schema allows, each with the keys above it."""
    if "$ref" in schema:
        yield from keys(SCHEMA["$defs"][schema["$ref"].removeprefix("#/$defs/")], at)
    for key, value in schema.get("properties", {}).items():
        if key != "about":
            yield f"{at}/{key}"
            yield from keys(value, f"{at}/{key}")
    for inner in ("items", "additionalProperties"):
        if isinstance(schema.get(inner), dict):
            yield from keys(schema[inner], f"{at}/*")


def used(value, at=""):
    """The same of a study, with `*` for names that are free."""
    free = {"/fixed", "/inputs", "/parameters", "/criteria", "/identify/free", "/identify/known", "/identify/latent",
            "/identify/measured", "/tolerances/costs"}
    for key, inner in value.items():
        here = f"{at}/*" if at in free else f"{at}/{key}"
        yield here
        for part in inner if isinstance(inner, list) else [inner]:
            if isinstance(part, dict):
                yield from used(part, f"{here}/*" if isinstance(inner, list) else here)


def test_the_study_reference_has_every_key():
    # A case has the tables of a study: these keys stand there once.
    repeated = re.compile(r"/cases/\*/(simulation|fixed|inputs|criteria)/")
    wanted = {key for key in keys(SCHEMA) if not repeated.search(key)}
    in_text = {"/simulation/window", "/verdict/guard-band", "/verdict/point-risk", "/criteria/*/tolerance/minus",
               "/criteria/*/tolerance/plus"}
    shown = {key for block in blocks() for key in used(block)}
    assert wanted - shown == in_text
    for key in in_text:
        assert re.search(rf"\b{key.rpartition('/')[2]} = ", text_of("docs/study.md")), key


def test_the_study_reference_follows_the_schema():
    """But for keys that exclude each other, which stand side by side there."""
    study = {"fmu": "my.fmu"}
    for block in blocks():
        study |= block
    study["criteria"]["torque"]["unit"] = "N.m"
    errors = [error.message for error in jsonschema.Draft202012Validator(SCHEMA).iter_errors(study)]
    assert errors == []

"""The documents become a site without a warning; what leads nowhere is an error; nothing is loaded from elsewhere."""

import importlib.machinery
import importlib.util
import json
import re
import subprocess
import sys

import pytest
from test_acceptance import ROOT
from test_documents import DOCUMENTS

LOADED = re.compile(r'<(?:script|img|iframe)[^>]* src="?https?:|<link[^>]* rel="?stylesheet"?[^>]* href="?https?:|@import')


def page_of(name):
    return re.sub(r"README\.md$", "index.md", name).removesuffix(".md") + ".html"


def test_it_builds_and_can_be_searched(tmp_path):
    done = subprocess.run([sys.executable, ROOT / "scripts/site", "--output", tmp_path], capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")
    pages = {page_of(name): (tmp_path / page_of(name)).read_text(encoding="utf-8") for name in DOCUMENTS}
    assert [name for name, page in pages.items() if LOADED.search(page)] == []
    found = json.loads((tmp_path / "search/search_index.json").read_text(encoding="utf-8"))["docs"]
    assert {one["location"].partition("#")[0] for one in found} == set(pages)
    assert any(one["location"] == "docs/verdict.html#risks" and "guard band" in one["text"] for one in found)


@pytest.fixture
def site(tmp_path, monkeypatch):
    """The script, for a repository of its own with the pages that every site has."""
    loader = importlib.machinery.SourceFileLoader("site_script", str(ROOT / "scripts/site"))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader("site_script", loader))
    loader.exec_module(module)
    pages = ["README.md", "docs/README.md", "docs/ARCHITECTURE.md", "CONTRIBUTING.md", "CHANGELOG.md", "crates/one/README.md"]
    for name in [*pages, "crates/one/lib.rs"]:
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text("# A page\n")
    (tmp_path / "Cargo.toml").write_text('[workspace.package]\nversion = "1.2.3"\nrepository = "https://example.org/it"\n')
    monkeypatch.setattr(module, "ROOT", tmp_path)
    monkeypatch.setattr(module, "PAGES", tmp_path / "out/pages")
    monkeypatch.setattr(module, "tracked", lambda: pages)
    return module


@pytest.mark.parametrize("link, leads_to", [
    ("CONTRIBUTING.md#a-page", "CONTRIBUTING.html#a-page"),
    ("crates/one", "crates/one/index.html"),
    ("crates/one/lib.rs", "https://example.org/it/blob/v1.2.3/crates/one/lib.rs"),
    ("crates", "https://example.org/it/tree/v1.2.3/crates"),
])
def test_links_lead_to_pages_or_to_the_repository(site, tmp_path, link, leads_to):
    (tmp_path / "README.md").write_text(f"# First\n\nSee [this]({link}).\n")
    site.build(tmp_path / "html")
    assert f'href="{leads_to}"' in (tmp_path / "html/index.html").read_text(encoding="utf-8")


@pytest.mark.parametrize("link", ["none.md", "CONTRIBUTING.md#nothing", "crates/two"])
def test_a_link_that_leads_nowhere_ends_the_build(site, tmp_path, link):
    (tmp_path / "README.md").write_text(f"# First\n\nSee [this]({link}).\n")
    with pytest.raises(SystemExit):
        site.build(tmp_path / "html")

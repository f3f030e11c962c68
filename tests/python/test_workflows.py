"""What the workflows run is fixed: actions by commit, tools by version, and nothing is built with the right to write."""

import re

import pytest
from test_acceptance import ROOT

WORKFLOWS = sorted((ROOT / ".github/workflows").glob("*.yml"))


@pytest.mark.parametrize("file", WORKFLOWS, ids=lambda file: file.name)
def test_actions_and_tools_are_pinned(file):
    text = file.read_text(encoding="utf-8")
    actions = re.findall(r"uses: (.*)", text)
    assert actions and all(re.fullmatch(r"[\w/-]+@[0-9a-f]{40} # v\d+\.\d+\.\d+", action) for action in actions), actions
    assert all("--locked" in line and re.search(r"@\d", line) for line in re.findall(r"cargo install.*", text))


def test_the_jobs_that_may_write_build_nothing():
    jobs = re.split(r"^  (?=\w+:$)", (ROOT / ".github/workflows/release.yml").read_text(encoding="utf-8"), flags=re.MULTILINE)
    publish, site = [job for job in jobs if re.search(r"\w: write$", job, re.MULTILINE)]
    assert publish.startswith("publish:") and "needs: [test, assemble, try, wine]" in publish
    assert site.startswith("site:") and "needs: publish" in site
    assert not re.search(r"checkout|cargo|scripts/|docker|pip", publish + site)

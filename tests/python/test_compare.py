"""`compare` of the Python package: what the program's files say."""

import pytest
from python_package import PAPER

from fmu_orchestrator import OrchestratorError, Study, compare


def test_a_result_is_compared_with_itself_and_with_other_points(verified, tmp_path):
    same = compare(verified, verified.folder)
    assert same.same and not same.differences and not same.warnings and "No difference" in same._repr_html_()
    assert same.data["pairs"] == 60 and all(change["changed"] == 0 for change in same.data["criteria"].values())
    fewer = Study.load(PAPER).verify(points=50, seed=5, output=tmp_path / "fewer")
    other = compare(verified, fewer, output=tmp_path / "changes")
    assert not other.same and other.differences[0].startswith("10 points only in the old result: 51, 52")
    assert (tmp_path / "changes/compare.html").is_file()
    with pytest.raises(OrchestratorError, match="holds no study"):
        compare(verified, tmp_path / "nothing")

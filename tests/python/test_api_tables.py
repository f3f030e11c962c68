"""The Python package's tables and functions, as other libraries take them."""

import numpy as np
import pandas
import polars
import pyarrow
import pytest
import scipy.optimize
from python_package import PAPER

from fmu_orchestrator import OrchestratorError, Study, _arrow
from fmu_orchestrator._table import csv_of, parse


def test_libraries_take_tables_as_they_are():
    values = np.linspace(0, 1, 21)
    cells = ((k + 1, x, "" if k % 3 else x, str(k % 2 == 0).lower(), f"'=µ{k}") for k, x in enumerate(values.tolist()))
    lines = ["point,x,gap,flag,status", *(",".join(map(str, row)) for row in cells)]
    table = parse(iter(lines), ["count", "number", "number", "flag", "text"])
    arrow = pyarrow.table(table)
    arrow.validate(full=True)
    assert [str(kind) for kind in arrow.schema.types] == ["int64", "double", "double", "bool", "string"]
    assert arrow["gap"].null_count == 14 and arrow["status"][20].as_py() == "=µ20"
    # Numbers are not copied.
    assert arrow["x"].chunk(0).buffers()[1].address == table["x"].buffer_info()[0]
    for frame in [pandas.DataFrame.from_arrow(table), polars.DataFrame(table)]:
        assert frame["x"].to_list() == values.tolist() and frame["flag"].to_list() == [k % 2 == 0 for k in range(21)]
        assert list(frame["point"]) == list(range(1, 22))
    assert polars.DataFrame(table)["gap"].null_count() == 14
    assert np.isnan(table.to_numpy(["x", "gap"])[:, 1]).sum() == 14
    with pytest.raises(KeyError, match="there are point, x"):
        table["y"]


@pytest.mark.parametrize(("index", "head", "times"), [
    (None, "T", []),
    (pandas.Index([3, 5]), "T", []),
    (pandas.Index([0.5, 1.0]), "time,T", [0.5, 1.0]),
    (pandas.Index([0, 5], name="t [min]"), "t [min],T", [0.0, 5.0]),
    (pandas.to_timedelta([5, 6], unit="s"), "time [s],T", [5.0, 6.0]),
    (pandas.date_range("2026-11-03", periods=2, freq="10s", tz="Europe/Berlin", name="Zeit"), "time [s],T", [0.0, 10.0]),
    (pandas.to_datetime([]), "time [s],T", []),
])
def test_an_index_of_times_is_a_column(index, head, times):
    frame = pandas.DataFrame({"T": [] if index is not None and not len(index) else [1.0, 2.0]})
    names, *rows = csv_of(frame if index is None else frame.set_index(index)).decode().splitlines()
    assert names == head
    assert [float(row.split(",")[0]) for row in rows if "," in row] == times


@pytest.mark.parametrize("rows", [0, 1, 8, 9, 30])
def test_tables_of_any_length(rows):
    flags = [k % 3 == 1 for k in range(rows)]
    text = ["a,b,c\n", *(f"{k},{str(flag).lower()},{'x' * k}\n" for k, flag in enumerate(flags))]
    arrow = pyarrow.table(parse(iter(text), ["number", "flag", "text"]))
    arrow.validate(full=True)
    assert arrow.num_rows == rows and arrow["c"].to_pylist() == ["x" * k for k in range(rows)]
    assert arrow["b"].to_pylist() == flags


def test_what_others_have_taken_is_released():
    table = parse(iter(["a,b\n", "1,x\n", "2,y\n"]))
    kept = pyarrow.table(table)["b"]
    unused = table.__arrow_c_stream__()
    assert _arrow._alive
    del unused
    # A column outlives the table that it came from.
    assert kept.to_pylist() == ["x", "y"]
    del kept
    assert not _arrow._alive and not _arrow._streams


def test_a_function_of_arrays(verified):
    study = Study.load(PAPER)
    f = study.function()
    x = verified.points.to_numpy(f.inputs)
    assert f.inputs == study.parameters and f.outputs == study.criteria
    assert np.array_equal(f(x), verified.points.to_numpy(f.outputs))
    assert np.array_equal(f(x[3]), verified.points.to_numpy(f.outputs)[3])
    assert f(np.empty((0, 7))).shape == (0, 4)
    with pytest.raises(ValueError, match="its columns are bearing.radialClearance"):
        f(x[:, :3])


def test_some_inputs_and_one_output(verified):
    study = Study.load(PAPER)
    row = dict(zip(study.parameters, verified.points.to_numpy(study.parameters)[0], strict=True))
    names = ["load.preload", "bearing.radialClearance"]
    f = study.function(names, "P_fr", others={name: value for name, value in row.items() if name not in names})
    assert f([row[name] for name in names]) == verified.points["P_fr"][0]
    # No film fits into a gap that is none: the point has no result, the others do.
    found = f([[48.0, -1.0], [48.0, 0.02]])
    assert np.isnan(found[0]) and found[1] > 0
    for mistake, says in [(lambda: study.function(["load.prelaod"]), "no parameter `load.prelaod`"),
                          (lambda: study.function(names), "give `others` values for load.stiffness"),
                          (lambda: study.function(outputs="P"), "no criterion `P`")]:
        with pytest.raises(OrchestratorError, match=says):
            mistake()


def test_other_libraries_call_it(verified):
    """SALib's samples, OpenTURNS' functions, scipy's searches."""
    import openturns as ot
    from SALib.sample import latin

    study = Study.load(PAPER)
    others = {name: verified.points[name][0] for name in study.parameters if name != "bearing.radialClearance"}
    f = study.function(outputs=["P_fr"], others=others)
    x = latin.sample({"num_vars": 1, "names": f.inputs, "bounds": [[0.015, 0.025]]}, 6, seed=1)
    y = f(x)
    model = ot.PythonFunction(1, 1, func_sample=f)
    assert np.array_equal(np.array(model(ot.Sample(x))), y)
    one = study.function(outputs="P_fr", others=others)
    low, high = x[y[:, 0].argmax()], x[y[:, 0].argmin()]
    middle = (one(low) + one(high)) / 2
    root = scipy.optimize.brentq(lambda clearance: one([clearance]) - middle, *sorted([low[0], high[0]]), xtol=1e-6)
    assert one([root]) == pytest.approx(middle, rel=1e-3)


def test_points_are_given_as_any_table(verified, tmp_path):
    study = Study.load(PAPER)
    frame = pandas.DataFrame.from_arrow(verified.points).head(5)
    for name, table in [("pandas", frame), ("arrow", pyarrow.table(verified.points).slice(0, 5)),
                        ("mapping", {name: frame[name].tolist() for name in study.parameters})]:
        found = study.verify(points_from=table, output=tmp_path / name)
        assert found.points.to_numpy(study.criteria).tolist() == frame[study.criteria].to_numpy().tolist(), name

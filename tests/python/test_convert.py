"""Recordings in formats of their own become csv files; a library that is missing is named with what installs it."""

import collections
import csv
import datetime
import multiprocessing
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import traceback
from types import SimpleNamespace

import numpy as np
import pandas
import pytest
from test_acceptance import ROOT

sys.path.insert(0, str(ROOT / "python"))
from fmu_orchestrator import OrchestratorError, _convert
from fmu_orchestrator._convert import EXTRAS, Contents, _by_length, _valid, convert, convert_here, main
from fmu_orchestrator._rows import Options


def rows(path):
    with path.open(newline="") as file:
        return list(csv.reader(file))


def test_matlab_structures_and_picoscope(tmp_path):
    io = pytest.importorskip("scipy.io")
    run = {"t": np.arange(5.0), "p": np.array([1.0, np.nan, 3, 4, 5]), "slow": {"T": np.array([80.0, 81])}, "who": "Meier"}
    io.savemat(tmp_path / "run.mat", {"run": run})
    fast, slow = convert(tmp_path / "run.mat", tmp_path / "out")
    assert rows(fast)[:3] == [["run/t", "run/p"], ["0.0", "1.0"], ["1.0", ""]]
    assert rows(slow) == [["run/slow/T"], ["80.0"], ["81.0"]]
    io.savemat(tmp_path / "pico.mat", {"Tstart": -0.5, "Tinterval": 0.25, "A": np.array([1.0, 2, 3]), "Length": 3})
    [scope] = convert(tmp_path / "pico.mat")
    assert convert(tmp_path / "pico.mat") == [scope]
    assert rows(scope) == [["time [s]", "A"], ["-0.5", "1.0"], ["-0.25", "2.0"], ["0.0", "3.0"]]


def test_the_csv_of_another_logger_stays(tmp_path):
    io = pytest.importorskip("scipy.io")
    io.savemat(tmp_path / "rig.mat", {"a": np.arange(3.0)})
    (tmp_path / "rig.csv").write_text("measured")
    with pytest.raises(OrchestratorError, match="rig.csv is there already .* --output"):
        convert(tmp_path / "rig.mat")
    assert (tmp_path / "rig.csv").read_text() == "measured"
    assert {path.name for path in tmp_path.iterdir()} == {"rig.mat", "rig.csv"}


def test_a_table_of_numbers_alone_is_asked_about(tmp_path):
    """A row of codes (SRML's files of solar radiation) is no row of values."""
    path = tmp_path / "codes.txt"
    path.write_text("94255\t2018\t1000\n1\t1\t-20.5\n1\t2\t-21.3\n")
    with pytest.raises(OrchestratorError, match=r"line 1 \(`94255 2018 1000`\) .* may be values or names; say --header 0 .* --header 1"):
        convert_here(path, tmp_path)
    [named] = convert_here(path, tmp_path / "named", options=Options(header=1))
    assert rows(named) == [["94255", "2018", "1000"], ["1.0", "1.0", "-20.5"], ["1.0", "2.0", "-21.3"]]
    [values] = convert_here(path, tmp_path / "values", options=Options(header=0))
    assert rows(values)[:2] == [["1", "2", "3"], ["94255.0", "2018.0", "1000.0"]]


# So many files of each format are damaged: one; in the long run also three. With `MUTATED=2000` the process of each is a fork of this
# one, which has the libraries already; it prints what came of them (`pytest -s`).
MUTATED = [int(os.environ["MUTATED"])] if "MUTATED" in os.environ else [1, pytest.param(3, marks=pytest.mark.long)]
SAMPLES = {
    "csv": lambda path: path.write_text("time [s],T [degC]\n" + "".join(f"{k / 10},{20 + k % 7}\n" for k in range(60))),
    "xlsx": lambda path: pytest.importorskip("openpyxl") and pandas.DataFrame({"t": range(40), "x": range(40)}).to_excel(path, index=False),
    "parquet": lambda path: pandas.DataFrame({"t": pandas.date_range("2026-11-03", periods=40), "x": range(40)}).to_parquet(path),
    "mat": lambda path: pytest.importorskip("scipy.io").savemat(path, {"run": {"t": np.arange(40.0), "x": np.ones(40)}}),
    "h5": lambda path: _hdf5(path),
    "mf4": lambda path: _mdf(path),
    "tdms": lambda path: _tdms(path),
}


def _hdf5(path):
    with pytest.importorskip("h5py").File(path, "w") as file:
        file["t"], file["run/x"] = np.arange(40.0), np.ones((40, 2))


def _mdf(path):
    asammdf = pytest.importorskip("asammdf")
    with asammdf.MDF() as mdf:
        mdf.append([asammdf.Signal(np.ones(40), np.arange(40.0), name="x", unit="V")])
        mdf.save(path)


def _tdms(path):
    nptdms = pytest.importorskip("nptdms")
    with nptdms.TdmsWriter(path) as file:
        file.write_segment([nptdms.ChannelObject("g", "x", np.ones(40), {"wf_increment": 0.1})])


class Forks:
    """``subprocess`` for ``convert`` with forks, and what they took at most."""

    TimeoutExpired = subprocess.TimeoutExpired

    def __init__(self):
        self.seconds = self.megabytes = 0.0

    def run(self, command, timeout, **_):
        with tempfile.TemporaryFile("w+") as out, tempfile.TemporaryFile("w+") as err:
            begin, child = time.monotonic(), os.fork()
            if child == 0:
                code = 1
                try:
                    os.dup2(out.fileno(), 1), os.dup2(err.fileno(), 2)
                    sys.stdout, sys.stderr = os.fdopen(1, "w"), os.fdopen(2, "w")
                    code = main(command[4:])
                except OrchestratorError as error:
                    print(f"error: {error}", file=sys.stderr)
                    code = 2
                except BaseException:
                    traceback.print_exc()
                finally:
                    sys.stdout.flush(), sys.stderr.flush()
                    os._exit(code)
            done = 0
            while not done and time.monotonic() - begin < timeout:
                done, status, usage = os.wait4(child, os.WNOHANG)
                time.sleep(0.001)
            if not done:
                os.kill(child, signal.SIGKILL)
                _, _, usage = os.wait4(child, 0)
            self.seconds, self.megabytes = max(self.seconds, time.monotonic() - begin), max(self.megabytes, usage.ru_maxrss / 1024)
            if not done:
                raise subprocess.TimeoutExpired(command, timeout)
            out.seek(0), err.seek(0)
            return SimpleNamespace(returncode=os.waitstatus_to_exitcode(status), stdout=out.read(), stderr=err.read())


@pytest.mark.parametrize("files", MUTATED)
@pytest.mark.parametrize("ending", SAMPLES)
def test_a_damaged_file_is_read_or_is_one_line(tmp_path, ending, files, monkeypatch):
    """No crash, no hang, no flood: a library that fails costs a line."""
    forks, came = Forks(), collections.Counter()
    whole = tmp_path / f"whole.{ending}"
    if files > 100:
        monkeypatch.setattr(_convert, "subprocess", forks)
        # Libraries with threads may be loaded before a fork, but not used.
        writer = multiprocessing.get_context("fork").Process(target=SAMPLES[ending], args=(whole,))
        writer.start(), writer.join()
    else:
        SAMPLES[ending](whole)
    content, draw = whole.read_bytes(), random.Random(56)
    for number in range(files):
        damaged = bytearray(content)
        for _ in range(draw.randint(1, 12)):
            place, way = draw.randrange(len(damaged)), draw.random()
            if way < 0.6:
                damaged[place] = draw.randrange(256)
            elif way < 0.8:
                del damaged[place : place + draw.randint(1, 40)]
            else:
                damaged[place:place] = draw.randbytes(draw.randint(1, 20))
        path = tmp_path / f"{number}.{ending}"
        path.write_bytes(damaged)
        try:
            convert(path, tmp_path / "out" / str(number))
            came["read"] += 1
        except OrchestratorError as error:
            assert len(str(error).splitlines()) == 1, error
            said = str(error)
            came["crashed" if "crashed" in said else "too much memory" if "memory" in said else "too slow" if "not read within" in said else "refused"] += 1
        path.unlink()
        shutil.rmtree(tmp_path / "out", ignore_errors=True)
    assert forks.seconds < 31 and forks.megabytes < 500
    print(f"\n{ending}: {dict(came)}; at most {forks.seconds:.1f} s, {forks.megabytes:.0f} MB")


def test_series_of_one_length_belong_together():
    table = np.arange(12.0).reshape(6, 2)
    items = [("a", "bar", np.arange(6.0)), ("b/x", "", np.arange(6.0)), ("b/y", "", table), ("c", "", np.array(["x", "y"]))]
    contents = _by_length(items, Contents())
    assert [[channel[0] for channel in group.channels] for group in contents.groups] == [["a"], ["b/x", "b/y/1", "b/y/2"]]
    assert contents.left_out == ["c"]


def test_lost_samples_are_not_what_the_memory_held(tmp_path):
    path = tmp_path / "m.mf4"
    _mdf(path)
    content = path.read_bytes()
    # The group's address of its data: 24 + 8 * 2 bytes behind its sign.
    place = content.index(b"##DG") + 24 + 8 * 2
    path.write_bytes(content[:place] + bytes(8) + content[place + 8 :])
    with pytest.raises(OrchestratorError, match="it states 40 samples of `x` and holds 0: it is cut off or damaged"):
        convert_here(path, tmp_path / "out")


def test_what_a_library_logs_is_a_note(tmp_path, capsys):
    path = tmp_path / "m.tdms"
    _tdms(path)
    path.write_bytes(path.read_bytes()[:-20])
    convert(path, tmp_path / "out")
    assert re.fullmatch("note: its library says: .*Last segment of file has less data than expected.*\n", capsys.readouterr().err)


@pytest.mark.parametrize(("ending", "library"), [("mf4", "asammdf"), ("tdms", "nptdms"), ("h5", "h5py"), ("xlsx", "openpyxl")])
def test_a_missing_library_is_named(tmp_path, monkeypatch, ending, library):
    path = tmp_path / f"x.{ending}"
    path.write_bytes(b"something")
    monkeypatch.setitem(sys.modules, library, None)
    with pytest.raises(OrchestratorError, match=rf'x.{ending}: {library} is missing; pip install "fmu-orchestrator\[{EXTRAS[library]}\]"'):
        convert_here(path, tmp_path)


def test_what_cannot_be_read_is_one_line(tmp_path):
    pytest.importorskip("scipy.io")
    (tmp_path / "x.mat").write_bytes(b"MATLAB 5.0 MAT-file" + bytes(200))
    (tmp_path / "x.wav").write_bytes(b"RIFF\0\0\0\0")
    for name, remedy in [("x.mat", "export it as csv"), ("x.wav", "no text"), ("y.mat", "no such file")]:
        with pytest.raises(OrchestratorError, match=remedy) as error:
            convert(tmp_path / name)
        assert len(str(error.value).splitlines()) == 1


def test_invalid_samples_become_empty_cells():
    bits = np.array([False, True, False])
    signal = SimpleNamespace(name="T", samples=np.array([1.0, -1.0, 3.0]), invalidation_bits=bits)
    contents = Contents()
    assert _valid(signal, contents) == [1.0, None, 3.0]
    assert contents.invalid == {"T": 1}
    signal.invalidation_bits = None
    assert _valid(signal, contents) is signal.samples


def test_mdf_says_invalid_samples_and_its_start(tmp_path, capsys):
    asammdf = pytest.importorskip("asammdf")
    with asammdf.MDF(version="4.10") as file:
        file.start_time = datetime.datetime(2026, 11, 26, 13, 3, 3)
        invalid = np.arange(20) == 7
        values = np.where(invalid, -1.0, 50.0)
        file.append([asammdf.Signal(values, np.arange(20) / 10, name="T", unit="degC", invalidation_bits=invalid)])
        file.save(tmp_path / "x.mf4")
    [path] = convert(tmp_path / "x.mf4")
    assert rows(path)[0] == ["time [s]", "T [degC]"]
    assert rows(path)[8:10] == [["0.7", ""], ["0.8", "50.0"]]
    told = capsys.readouterr()
    assert "T: 1 samples are invalid" in told.err
    assert "time 0 is 2026-11-26T13:03:03" in told.out


def test_nothing_of_another_file_is_in_the_table(tmp_path, capsys):
    h5py = pytest.importorskip("h5py")
    (tmp_path / "secret.bin").write_bytes(np.arange(6.0).tobytes())
    with h5py.File(tmp_path / "x.h5", "w") as file:
        file["p"] = np.arange(6.0)
        file.create_dataset("other", (6,), "f8", external=[(str(tmp_path / "secret.bin"), 0, 48)])
        file["link"] = h5py.ExternalLink(str(tmp_path / "y.h5"), "/q")
    [path] = convert(tmp_path / "x.h5")
    assert rows(path)[0] == ["p"]
    assert "other (in another file)" in capsys.readouterr().err


def test_a_file_that_wants_much_memory_is_one_line(tmp_path):
    h5py = pytest.importorskip("h5py")
    with h5py.File(tmp_path / "x.h5", "w") as file:
        file.create_dataset("p", (400_000_000,), "f8", chunks=(1_000_000,), compression="gzip", fillvalue=1.0)
    with pytest.raises(OrchestratorError, match="memory|not readable") as error:
        convert(tmp_path / "x.h5")
    assert len(str(error.value).splitlines()) == 1


def test_numbers_that_netcdf_packs(tmp_path, capsys):
    h5py = pytest.importorskip("h5py")
    with h5py.File(tmp_path / "x.nc", "w") as file:
        file["time"] = np.arange(4.0)
        file["T"] = np.array([0, 5, -999, 10], "i2")
        file["T"].attrs.update(units="degC", scale_factor=0.5, add_offset=20.0, _FillValue=np.int16(-999))
        file["n"] = np.array([7, 8, 9, 9], "i4")
        file["n"].attrs["missing_value"] = np.array([9], "i4")
        file["n"].attrs["_FillValue"] = "none"
    [path] = convert(tmp_path / "x.nc")
    assert rows(path) == [["time", "T [degC]", "n"], ["0.0", "20.0", "7.0"], ["1.0", "22.5", "8.0"], ["2.0", "", ""], ["3.0", "25.0", ""]]
    told = capsys.readouterr()
    assert "T: its numbers times 0.5 plus 20.0" in told.out and "T: 1 samples are invalid" in told.err and "n: 2 samples" in told.err


def test_a_day_and_its_clock_in_a_spreadsheet(tmp_path):
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.Workbook()
    for row in [["Datum", "Zeit", "F [N]"], *([datetime.date(2026, 11, 3 + k // 2), datetime.time(23 * (1 - k // 2), 15 * (k % 2)), k] for k in range(4))]:
        book.active.append(row)
    book.save(tmp_path / "x.xlsx")
    [path] = convert(tmp_path / "x.xlsx")
    assert [row[0] for row in rows(path)] == ["time [s]", "0.0", "900.0", "3600.0", "4500.0"]


def test_stamps_of_parquet_and_tdms(tmp_path):
    pyarrow = pytest.importorskip("pyarrow")
    from pyarrow import parquet

    at = [datetime.datetime(2026, 11, 3, 22) + datetime.timedelta(seconds=10 * k) for k in range(3)]
    parquet.write_table(pyarrow.table({"time": at, "wait": [datetime.timedelta(milliseconds=k) for k in range(3)], "T": [1.0, 2.0, 3.0]}), tmp_path / "x.parquet")
    [path] = convert(tmp_path / "x.parquet", tmp_path / "out", zero="2026-11-03T21:59:50")
    assert rows(path) == [["time [s]", "wait [s]", "T"], *([str(10.0 * k + 10.0), str(0.001 * k), str(k + 1.0)] for k in range(3))]
    # Nanoseconds stay; moments of another column count from the same start.
    at = np.datetime64("2026-11-03T22:00:00.000000001") + np.arange(3) * np.timedelta64(20_001, "ns")
    pandas.DataFrame({"at": at, "late": at + np.timedelta64(2, "s"), "T": [1.0, 2.0, 3.0]}).to_parquet(tmp_path / "n.parquet")
    [path] = convert(tmp_path / "n.parquet", tmp_path / "out")
    assert rows(path)[2] == ["2.0001e-05", "2.000020001", "2.0"]
    nptdms = pytest.importorskip("nptdms")
    at = np.datetime64("2026-11-03T22:00:00.000") + np.arange(3) * np.timedelta64(250, "ms")
    with nptdms.TdmsWriter(tmp_path / "x.tdms") as file:
        file.write_segment([nptdms.ChannelObject("g", "at", at), nptdms.ChannelObject("g", "late", at + np.timedelta64(2, "s"))])
    [path] = convert(tmp_path / "x.tdms", tmp_path / "tdms", zero="2026-11-03T21:59:50+00:00")
    assert rows(path) == [["at [s]", "late [s]"], *([str(10 + 0.25 * k), str(12 + 0.25 * k)] for k in range(3))]


def test_a_unit_may_be_said_of_any_channel_and_what_says_nothing_is_refused(tmp_path):
    path = tmp_path / "m.parquet"
    pandas.DataFrame({"t": [0.0, 1.0], "x": [1.5, 2.5]}).to_parquet(path)
    [out] = convert_here(path, tmp_path / "out", options=Options(units={"x": "kN"}))
    assert out.read_text().startswith("t,x [kN]\n")
    with pytest.raises(OrchestratorError, match="there is no such channel; it has t, x"):
        convert_here(path, tmp_path / "out", options=Options(units={"y": "kN"}))
    with pytest.raises(OrchestratorError, match="--header is about text and spreadsheets"):
        convert_here(path, tmp_path / "out", options=Options(header=2))


def test_help_names_the_formats(capsys):
    with pytest.raises(SystemExit):
        main(["--help"])
    assert ".mf4" in capsys.readouterr().out


def test_cells_of_a_spreadsheet_are_what_is_shown(tmp_path):
    openpyxl = pytest.importorskip("openpyxl")

    def read(rows, **formats):
        book = openpyxl.Workbook()
        for row in rows:
            book.active.append(row)
        for column, form in formats.items():
            for cell in book.active[column][1:]:
                cell.number_format = form
        book.save(tmp_path / "m.xlsx")
        [path] = convert_here(tmp_path / "m.xlsx", tmp_path / "out")
        text = path.read_text().split()
        path.unlink()
        return text

    # Excel keeps 98.5 % as 0.985.
    assert read([["t", "eta"], [0.125, 0.985], [1.5, 0.9]], B="0.0%")[-3:] == ["[%]", "0.125,98.5", "1.5,90.0"]
    with pytest.raises(OrchestratorError, match="1500 or 1.500"):
        read([["t", "F"], [0.5, "1,500"], [1.5, "2,500"]])
    # 1.01 days as a time of day are a date of the year 1900.
    with pytest.raises(OrchestratorError, match="no time like the others"):
        read([["t", "F"], [0.99, 1.5], [1.01, 2.5]], A="h:mm:ss")


def test_hdf5_of_pandas_names_the_way_out(tmp_path):
    h5py = pytest.importorskip("h5py")
    with h5py.File(tmp_path / "x.h5", "w") as file:
        file["run/block0_values"] = np.arange(6.0).reshape(3, 2)
        file["run"].attrs["pandas_type"] = "frame"
    with pytest.raises(OrchestratorError, match=r"pandas.read_hdf\(FILE\).to_parquet"):
        convert_here(tmp_path / "x.h5", tmp_path / "out")


def test_sheets_keep_their_offsets_and_texts_their_doubt(tmp_path):
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.Workbook()
    for sheet, minute in ((book.active, 10), (book.create_sheet("b"), 0)):
        sheet.append(["time", "F [N]"])
        for second in range(3):
            sheet.append([datetime.datetime(2026, 11, 3, 12, minute, second), second + 0.125])
    book.save(tmp_path / "m.xlsx")
    late, first = convert_here(tmp_path / "m.xlsx", tmp_path / "out")
    assert late.read_text().split() == ["time", "[s],F", "[N]", "600.0,0.125", "601.0,1.125", "602.0,2.125"]
    assert first.read_text().splitlines()[1] == "0.0,0.125"
    book = openpyxl.Workbook()
    for row in (["t [s]", "F"], [0, 1.25], [1, "1.234"], [2, 1500.5]):
        book.active.append(row)
    book.save(tmp_path / "n.xlsx")
    with pytest.raises(OrchestratorError, match="`1.234` in column `F` may be 1234 or 1.234"):
        convert_here(tmp_path / "n.xlsx", tmp_path / "out")
    [path] = convert_here(tmp_path / "n.xlsx", tmp_path / "out", options=Options(decimal=","))
    assert path.read_text().splitlines()[1:] == ["0.0,1.25", "1.0,1234.0", "2.0,1500.5"]


def test_a_master_of_mdf_that_is_no_time_is_not_called_so(tmp_path, capsys):
    asammdf, numpy = pytest.importorskip("asammdf"), pytest.importorskip("numpy")
    with asammdf.MDF() as mdf:
        for name, master in (("p", ("crank", 2)), ("n", ("time", 1))):
            mdf.append(asammdf.Signal(numpy.arange(3.0), numpy.arange(3.0) * 5, name=name, unit="bar", master_metadata=master))
        mdf.save(tmp_path / "m.mf4")
    angle, time = convert_here(tmp_path / "m.mf4", tmp_path / "out")
    assert angle.read_text().startswith("crank") and time.read_text().startswith("time [s],n [bar]")
    assert "`crank` is an angle and no time" in capsys.readouterr().out


def test_a_zone_is_told_and_must_be_that_of_zero(tmp_path, capsys):
    for zone, other in (("+01:00", ""), ("", "+00:00")):
        path = tmp_path / "m.csv"
        path.write_text(f"when;F\n2026-11-03 12:00:00{zone};1.5\n2026-11-03 12:00:01{zone};2.5\n")
        convert_here(path, tmp_path / f"out{len(zone)}")
        zero = "2026-11-03T11:00:00+00:00" if zone else "2026-11-03T12:00:00"
        assert f"--zero {zero}\n" in capsys.readouterr().out
        convert_here(path, tmp_path / f"out{len(zone)}", zero=zero)
        with pytest.raises(OrchestratorError, match="zone, unlike --zero"):
            convert_here(path, tmp_path / "none", zero=f"2026-11-03T12:00:00{other}")

"""Text as loggers write it: read back exactly, or asked about with the option that decides; never anything else."""

import csv
import datetime
import os
import random
import re
import sys

import pandas
import pytest
from test_acceptance import ROOT

sys.path.insert(0, str(ROOT / "python"))
from fmu_orchestrator import OrchestratorError
from fmu_orchestrator._convert import convert_here
from fmu_orchestrator._rows import Options


def converted(tmp_path, content, name="m.csv", encoding="utf-8", **said):
    """The header and the rows of numbers of a file with this content."""
    path = tmp_path / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode(encoding))
    [out] = convert_here(path, tmp_path / "out", options=Options(**said))
    with out.open(newline="") as file:
        header, *rows = list(csv.reader(file))
    out.unlink()
    return header, [[float(cell) if re.fullmatch(r"-?\d+(\.\d*)?(e-?\d+)?", cell) else cell for cell in row] for row in rows]


def rows(*lines):
    return "\n".join(lines) + "\n"


def stamps(form, count=4, step=60):
    at = datetime.datetime(2026, 11, 3, 13, 15)
    return [f"{(at + datetime.timedelta(seconds=step * k)).strftime(form)};{k}.5" for k in range(count)]


@pytest.mark.parametrize("form", [
    "%Y-%m-%d %H:%M:%S", "%Y-%m-%dT%H:%MZ", "%Y/%m/%d %H:%M", "%d.%m.%y %H:%M", "%d.%m.%Y %H:%M:%S.%f", "%d-%b-%Y %H:%M:%S",
    "%m/%d/%Y %I:%M:%S %p", "%Y%m%d%H%M%S", "%Y%m%d:%H%M", "%Y-%m-%dT%H:%M:%S+01:00", "%b %d, %Y %I:%M:%S %p", "%a, %d %b %Y %H:%M:%S GMT",
    "%d. %B %Y %H:%M", "%H:%M:%S:000",
])
def test_stamps_become_seconds(tmp_path, form):
    header, table = converted(tmp_path, rows("when;F [N]", *stamps(form)))
    assert header == ["time [s]", "F [N]"]
    assert table == [[60.0 * k, k + 0.5] for k in range(4)]


@pytest.mark.parametrize(("cells", "seconds"), [
    (["23:59:30", "24:00:00", "24:00:30"], [0, 30, 60]),
    (["0d 23:59:30", "1d 00:00:00"], [0, 30]),
    (["0 days 23:59:30", "1 days 00:00:00"], [0, 30]),
    (["23:59:30", "00:00:00"], [0, 30]),
    (["13:15:07,25", "13:15:07,75"], [0, 0.5]),
    (["59:59.5", "60:00.5"], [0, 1.0]),
    # Months in other languages; days of one figure behind the year.
    (["28 févr. 2026 10:00:00", "1 mars 2026 10:00:00"], [0, 86400.0]),
    (["31. Juli 2026 10:00", "1. August 2026 10:00"], [0, 86400.0]),
    (["30 juin 2026 10:00", "1 juil. 2026 10:00"], [0, 86400.0]),
    (["31-dic-2026 10:00", "1-ene-2027 10:00"], [0, 86400.0]),
    (["2026/9/30", "2026/10/1"], [0, 86400.0]),
])
def test_hours_beyond_a_day_and_over_midnight(tmp_path, cells, seconds):
    _, table = converted(tmp_path, rows("Zeit;F [N]", *(f"{cell};1,5" for cell in cells)))
    assert [row[0] for row in table] == seconds


def test_date_and_time_in_several_columns_join(tmp_path):
    lines = ["Datum;Uhrzeit;T [°C]", "20.11.2026;23:59:00;20,0", "23.11.2026;00:01:00;21,0"]
    header, table = converted(tmp_path, rows(*lines), encoding="cp1252")
    assert header == ["time [s]", "T [degC]"] and table == [[0.0, 20.0], [2 * 86400 + 120.0, 21.0]]
    _, table = converted(tmp_path, rows("Year,Month,Day,Hour,Minute,T (°C)", "2026,12,31,23,30,1.5", "2027,1,1,0,0,2.5"))
    assert table == [[0.0, 1.5], [1800.0, 2.5]]


@pytest.mark.parametrize(("lines", "seconds", "said"), [
    (["Date;Time;T", "20240131;93015;1", "20240131;93045;2", "20240203;100015;3"], [0, 30, 261000], {}),
    (["Date;Time;T", "20240131;0935;1", "20240203;1000;2"], [0, 260700], {}),
    (["Date;HHMM;T", "20240131;935;1", "20240203;1000;2"], [0, 260700], {}),
    (["Date;Time;T", "20240131;93015.25;1", "20240131;93016.75;2"], [0, 1.5], {}),
    (["Date;Time;T", "2024-01-31;93015;1", "2024-02-03;93045;2"], [0, 259230], {}),
    (["Date;Time;T", "20240131;09:30:15;1", "20240203;09:30:45;2"], [0, 259230], {}),
    (["Date;Time;T", "240131;93015;1", "240201;94500;2"], [0, 87285], {}),
    (["Date;Time;T", "1/14/20;12:30a;1", "1/14/20;1:00a;2"], [0, 1800], {}),
    (["Year;Month;Day;Time;T", "2024;1;31;09:30:15;1", "2024;2;3;09:30:45;2"], [0, 259230], {}),
    (["Year;Month;Day;Time;T", "2024;1;31;93015;1", "2024;2;3;93045;2"], [0, 259230], {}),
    (["Date;T", "20240131;1", "20240201;2"], [0, 86400], {}),
    (["Date;Time;ms;T", "2024-01-31;09:30:15;0;1", "2024-01-31;09:30:15;250;2"], [0, 0.25], {}),
    (["Number;Date;Time;us;T", "1;2024-01-31;09:30:15;    100;1", "2;2024-01-31;09:30:15; 250100;2"], [0, 0.25], {}),
    (["Year;Month;Day;Hour;Minute;Second;Millisecond;T", "2024;1;31;9;30;15;500;1", "2024;1;31;9;30;16;000;2"], [0, 0.5], {}),
    (["MESS_DATUM;T", "2024013123;1", "2024020100;2"], [0, 3600], {}),
    # Without its leading zero: 1:05:05, not 10:50:05.
    (["a;b;T", "10505;1;1.5", "101010;2;2.5"], [0, 32705], {"format": "%H%M%S", "time": "a"}),
])
def test_days_and_clocks_of_figures_alone(tmp_path, lines, seconds, said):
    header, table = converted(tmp_path, rows(*lines), **said)
    assert header[0] == "time [s]" and header[-1] == "T" and [row[0] for row in table] == seconds
    # Elapsed seconds beside a day stay what they are.
    assert converted(tmp_path, rows("Date,t [s],T", "20240131,0,1", "20240131,1,3"))[0] == ["Date", "t [s]", "T"]
    assert converted(tmp_path, rows("Date,Time,T", "20240131,75.5,1", "20240131,99,3"))[0] == ["Date", "Time", "T"]


def test_marks_of_each_column_are_told(tmp_path, capsys):
    assert converted(tmp_path, rows("a;b;c", "0.5;0,25;1.234.567", "1.5;1234,5;2.345"))[1] == [[0.5, 0.25, 1234567.0], [1.5, 1234.5, 2345.0]]
    told = capsys.readouterr().out
    assert "decimal mark: , in `b`" in told and "decimal mark: ,; `.` stands between thousands in `c`" in told
    with pytest.raises(OrchestratorError, match="--decimal x=.: say . or , or NAME=MARK; the columns are a"):
        converted(tmp_path, rows("a", "0.5", "1.5"), decimal={"x": "."})


def test_sea_bird(tmp_path, capsys):
    head = ["* Sea-Bird SBE 9 Data File:", "# nquan = 3", "# name 0 = timeS: Time, Elapsed [seconds]", "# name 1 = t090C: Temperature [ITS-90, deg C]",
            "# name 2 = flag: flag", *(f"# span {k} =      0.082,     24.362" for k in range(3)), "# interval = seconds: 0.25", "# bad_flag = -9.990e-29", "*END*"]
    header, table = converted(tmp_path, rows(*head, "      0.083    13.5596 0.0000e+00", "      0.333-1.0255e+01 -9.990e-29"), name="m.cnv")
    assert header == ["timeS [s]", "t090C [degC]", "flag"] and table == [[0.083, 13.5596, 0.0], [0.333, -10.255, ""]]
    assert "1 cells are `-9.990e-29`, the header's mark of bad values" in capsys.readouterr().out
    with pytest.raises(OrchestratorError, match="binary; save it as ASCII"):
        converted(tmp_path, rows(head[0], head[2], "# file_type = binary", "*END*", "abc"), name="m.cnv")


def test_headers_of_loggers(tmp_path):
    toa5 = rows('"TOA5","st","CR1000","1","x","p","2","Table"', '"TIMESTAMP","RECORD","T_Avg"', '"TS","RN","Deg C"', '"","","Avg"',
                '"2026-11-03 13:15:00",1,20.5', '"2026-11-03 13:16:00",2,21.5')
    assert converted(tmp_path, toa5) == (["time [s]", "RECORD [RN]", "T_Avg [degC]"], [[0.0, 1.0, 20.5], [60.0, 2.0, 21.5]])
    preamble = rows("Prüfstand 7", "Bediener;Meier", "", "Zeit;T_oel;T_wasser", "s;°C;°C", "0;80,5;OVR", "1;81,5;90,25")
    header, table = converted(tmp_path, preamble, encoding="cp1252")
    assert header == ["Zeit [s]", "T_oel [degC]", "T_wasser [degC]"]
    # What is no number stays for the program to ask.
    assert table == [[0.0, 80.5, "OVR"], [1.0, 81.5, 90.25]]
    assert converted(tmp_path, rows("Rig 7;;", "t [s];F;n", "0;1,5;2", "1;2,5;3"))[0] == ["t [s]", "F", "n"]
    assert converted(tmp_path, rows("sep=;", "t [s];n [min⁻¹]", "0;1500", "1;1501"))[0] == ["t [s]", "n [1/min]"]
    tabs = rows("time\tT [degC]\tState", "2026-11-22 10:00:00\t20.0\ton", "2026-11-22 10:00:01\t20.1\ton")
    assert converted(tmp_path, tabs) == (["time [s]", "T [degC]"], [[0.0, 20.0], [1.0, 20.1]])


def test_what_stands_in_a_name_need_not_be_a_unit(tmp_path):
    header, _ = converted(tmp_path, rows("t (s),G(h),T in °C,n / rpm,x[2],Dev0/A", "0,1,2,3,4,5", "1,2,3,4,5,6"))
    assert header == ["t [s]", "G(h)", "T [degC]", "n [rpm]", "x[2]", "Dev0/A"]
    header, _ = converted(tmp_path, rows("~time/s,Current(A),Temp(min),I/mA,p(bar),Q(Ah),V(A),a/(b)", "0,1,2,3,4,5,6,7", "1,2,3,4,5,6,7,8"))
    assert header == ["time [s]", "Current [A]", "Temp(min)", "I/mA", "p [bar]", "Q [Ah]", "V(A)", "a/(b)"]


def test_what_other_peoples_loggers_wrote(tmp_path):
    # A mark of the encoding on each line; nanoseconds; figures in the unit behind a number.
    lines = [f'\ufeff"2026-11-03 13:15:00.{k}20000010",{k}.5 m/s²,{k} 1/min' for k in range(3)]
    header, table = converted(tmp_path, rows("Time,v,n", *lines))
    assert header == ["time [s]", "v [m/s2]", "n [1/min]"] and table == [[0.1 * k, k + 0.5, k] for k in range(3)]
    assert converted(tmp_path, rows("Time,v", "2026-11-03T13:15:00.000000010,1.5", "2026-11-03T13:15:00.000020031,2.5"))[1] == [[0, 1.5], [2.0021e-5, 2.5]]
    # Buoys write the month as MM and the minute as mm, and MM where nothing was measured.
    buoy = rows("#YY  MM DD hh mm  WVHT DPD APD WSPD ATMP WTMP", "#yr  mo dy hr mn   m sec sec m/s degC degC",
                *(f"2019 {at}  {height} 8 7 1.5 10 11" for at, height in (("04 02 13 40", "MM"), ("04 02 13 50", "1.5"), ("05 02 13 50", "MM"))))
    header, table = converted(tmp_path, buoy)
    assert header[:3] == ["time [s]", "WVHT [m]", "DPD [s]"] and [row[:2] for row in table] == [[0.0, "MM"], [600.0, 1.5], [600.0 + 30 * 86400, "MM"]]
    # Decimal commas with blanks between.
    assert converted(tmp_path, rows("Time [s]  F  n", "0,000  1,5 3", "0,100  2,5 4"))[1] == [[0.0, 1.5, 3.0], [0.1, 2.5, 4.0]]
    # Units in brackets below the names, blanks between; rows of marks alone.
    assert converted(tmp_path, rows("Time  F  n", "(s) (kN) (rpm)", "0.0 1.5 3", "0.1 2.5 4"))[0] == ["Time [s]", "F [kN]", "n [rpm]"]
    assert converted(tmp_path, rows("F [N]", "1.5", "n/a", "2.5", "n/a"))[1] == [[1.5], [""], [2.5], [""]]
    (tmp_path / "day.csv").write_text(rows("MATLAB_DATE,T", "737151,1.5", "737152,2.5"))
    [out] = convert_here(tmp_path / "day.csv", tmp_path / "out")
    assert out.read_text().splitlines()[0] == "MATLAB_DATE,T"


def test_rows_above_the_names_are_told(tmp_path, capsys):
    assert converted(tmp_path, rows("Serial;12345", "", "t [s];F", "0;1,5", "1;2,5", "End"))[1] == [[0.0, 1.5], [1.0, 2.5]]
    told = capsys.readouterr().out
    assert "1 lines with numbers above the recording were left out, line 1 first: `Serial 12345`" in told
    assert "1 lines hold no row of the recording and were left out, line 6 first: `End`" in told


def test_thousands_and_signs(tmp_path):
    lines = ["t [s];P [MWh]", "0;4.300,00", "1;900,50", "2;\u22121'200,25".replace("'", ".")]
    assert [row[1] for row in converted(tmp_path, rows(*lines))[1]] == [4300.0, 900.5, -1200.25]
    lines = rows("day;clock;P", "03-11-2026;12:00:00;1.5", "04-11-2026;12:10:00;2.5")
    assert converted(tmp_path, lines, format="%d-%m-%Y")[1] == [[0.0, 1.5], [87000.0, 2.5]]
    lines = ["t [s];P [kN]", "0;1'200.5", "1;12.25"]
    assert [row[1] for row in converted(tmp_path, rows(*lines))[1]] == [1200.5, 12.25]
    # A sign apart from its number; what a spreadsheet is to take for text.
    assert converted(tmp_path, rows("t [s];P", "0;+  1.5", "1;-  2.5", "2;'3.5"))[1] == [[0.0, 1.5], [1.0, -2.5], [2.0, 3.5]]
    assert converted(tmp_path, rows("t [s];T", "0;23.5 °C", "1;24.5 °C")) == (["t [s]", "T [degC]"], [[0.0, 23.5], [1.0, 24.5]])


@pytest.mark.parametrize(("lines", "words", "said"), [
    (["t [s];P", "0;1.500", "1;2.500"], ['--decimal "."', '--decimal ","'], {"decimal": "."}),
    (["Zeit [ms];P", "0;980", "300;1.001", "10000;999"], ["1001 or 1.001", '--decimal "."'], {"decimal": ","}),
    # What a mark is in one column says nothing of another one.
    (["a;b", "0.5;1.234", "1.5;2.345"], ["`1.234` in column `b` may be 1234 or 1.234", '--decimal "."', '--decimal ","', '--decimal "b=."'], {"decimal": {"b": ","}}),
    (["a\tb", "0,5\t1.234", "1,5\t2.345"], ["`1.234` in column `b`"], {"decimal": "."}),
    (["a;b", "4.300,25;1.234", "1.301,25;2.345"], ["`1.234` in column `b`"], {"decimal": ","}),
    (["a;b", "0.5;1", "0,5;2"], ["`0.5` has a decimal point and `0,5` a decimal comma", '--decimal "a=."'], {"decimal": {"a": "."}}),
    (["a;b", "1.234.567;3", "0.5;4"], ["`1.234.567` has several `.`, which is its decimal mark"], None),
    # Days and clocks of figures alone.
    (["Date;Time;T", "20240131;935;1", "20240203;945;2"], ["`935` may be a clock", '--format "%Y%m%d %H%M" or "%Y%m%d %H%M%S"', '--unit "Time=s"'], {"format": "%Y%m%d %H%M"}),
    (["Date;Time;T", "20240131;935;1", "20240203;945;2"], ['--unit "Time=s"'], {"units": {"Time": "s"}}),
    (["Date;Time;T", "240131;93015;1", "240128;94500;2", "240201;94500;2"], ['"%y%m%d" or "%d%m%y"'], {"format": "%y%m%d"}),
    (["Time;T", "93015;1", "93115;2"], ["`93015` may be a clock", '--format "%H%M%S"'], {"format": "%H%M%S"}),
    (["Time;T", "0;1", "15;2", "30;3", "45;4", "100;3", "115;3"], ['--format "%H%M"'], {"format": "%H%M"}),
    (["Date;Start;End Time;T", "20240131;93015;94015;1", "20240131;93115;94115;1"], ["the clock may be `Start` or `End Time`"], {"time": "Start"}),
    (["Date;Start;End;T", "2024-01-31;13:00;13:15;1.5", "2024-01-31;13:15;13:30;2.5"], ["the clock may be `Start` or `End`"], {"time": "Start"}),
    (["Total;Step;T", "0d 23:59:50;0d 00:00:05;1.5", "1d 00:00:00;0d 00:00:15;2.5"], ["the clock may be `Total` or `Step`"], {"time": "Total"}),
    (["Date;Hour;T", "2024-01-31;13.25;1.5", "2024-01-31;13.5;2.5"], ["`13.25` may be a clock"], {"time": "none"}),
    (["t;T", "PT0S;1.5", "PT1M30S;2.5"], ["`PT0S` is no known stamp"], {"time": "none"}),
    (["Date;HH;MM;SS;T", "20240131;9;30;15;1.5", "20240131;9;31;15;1.5"], ["1 rows have the day of the row before", "--time none"], {"time": "none"}),
    (["Year,Month,Day,Time,T", "2024,1,30,7.5,1.5", "2024,1,30,75.5,1.5"], ["several rows of one day", "--time NAME"], {"time": "Time"}),
    (["t [s],P", "0,980", '1500,"1,050"'], ["1050 or 1.050"], {"decimal": "."}),
    (["Year,Month,Day,Max,Min", "2026,11,1,12,3", "2026,11,2,13,4"], ["`Min` is called as the minute", "--time none"], {"time": "none"}),
    (["Year,Month,Day,Hour,Min,Max", "2026,11,1,12,3,4", "2026,11,2,13,4,5"], ["`Min` is called as the minute"], {"time": "none"}),
    (["year,month,day,HR,T", "2026,11,1,65,3", "2026,11,2,70,4"], ["`HR` is called as the hour of the time and holds 65"], {"time": "none"}),
    (["year,month,day,hour,T", "2026,11,1,1.5,3", "2026,11,1,2.5,4"], ["`hour`", "holds 1.5"], {"time": "none"}),
    (["year,month,day,T", "2026,11,30,3", "2026,11,31,4"], ["holds 31 in month 11"], {"time": "none"}),
    (["when;P", "26.11.03;1.5", "26.11.04;2.5"], ['"%d.%m.%y" or "%y.%m.%d"'], {"format": "%y.%m.%d"}),
    (["when;P", *(f"0{k}/11/2026 0{k}:15:07.250 PM;1.5" for k in (3, 4, 6))], ['"%d/%m/%Y %I:%M:%S.%f %p"'], {"format": "%d/%m/%Y %I:%M:%S.%f %p"}),
    (["when;P", *(f"0{k}/11/2026T0{k}:15+01:00;1.5" for k in (3, 4, 6))], ['"%d/%m/%YT%H:%M%z"'], {"format": "%d/%m/%YT%H:%M%z"}),
    (["t [s];P", "0;0,5", "1;2.500"], ["2500", "2.500"], {"decimal": ","}),
    (["when;P", "03/11/2026 12:00;1.5", "04/11/2026 12:00;2.5", "05/11/2026 12:00;2.5"], ["%d/%m/%Y", "%m/%d/%Y"], {"format": "%d/%m/%Y %H:%M"}),
    (["day;clock;P", "03-11-2026;12:00:00;1.5", "04-11-2026;12:10:00;2.5", "05-11-2026;12:00:00;2.5"], ['"%d-%m-%Y"', '"%m-%d-%Y"'], {"format": "%d-%m-%Y"}),
    (["when;P", "12:00;1.5", "12:01;2.5"], ["%H:%M", "%M:%S"], {"format": "%M:%S"}),
    (["von;bis;P", "02.06.2025 13:45;02.06.2025 14:45;1,5", "02.06.2025 14:45;02.06.2025 15:45;2,5"], ["--time", "von"], {"time": "von"}),
    (["when;P", *(f"2026-{30 + k} 13:15:00;{k}.5" for k in range(4))], ["`2026-30 13:15:00` is no known stamp", "--format", "--time"], {"format": "%Y-%j %H:%M:%S"}),
    (["quand;P", *(f"{k} nov. 2026 13h15;{k}.5" for k in range(1, 5))], ["`1 nov. 2026 13h15` is no known stamp"], {"time": "none"}),
    (["Period;P", *(f"2026-11-03T1{k}:00/2026-11-03T1{k + 1}:00;{k}.5" for k in range(4))], ["no known stamp"], {"time": "none"}),
    (["a;b", "foo;baz", "0;1.5", "1;2.5"], ["--header"], {"header": 1}),
    (["Albuquerque", "35.04 -106.6 1617 m version 1", "2019 56 2 25 0.5 79.9 102.6 1.5", "2019 56 2 25 1.5 79.8 102.5 1.5"], ["--header 0", "--header 3"], {"header": 0}),
    (["X,CH1,Start,Step", "0,1.5,", "1,2.5,"], ["--header 1"], {"header": 1}),
    (["t,F", "0,1,5", "1,2,5"], ["--delimiter", "decimal comma"], None),
    (["when;P", "11-03-02;1.5", "11-03-03;2.5"], ['"%d-%m-%y" or "%m-%d-%y" or "%y-%m-%d"'], {"format": "%y-%m-%d"}),
    (["t;F", "s;N", "0;1.5", "1;2.5", "t;F", "s;kN", "2;2.5"], ["another table begins on line 6 (`s kN`)"], None),
    (["t [s],F [N]", "0,1.5", "1,2.5", "t [s],F [kN]", "2,2.5"], ["another table begins on line 4"], None),
    (["Nr,at,x", "1,2026-11-03 13:15,5", "2,2026-11-03 13:16,6", "", "t [s],F,n", "0,1.5,7", "1,2.5,8", "2,3.5,9"], ["line 2", "--header 5"], {"header": 5}),
    ([",A,B", ",rpm,kind", "x,y,z", "0,1.5,7", "1,2.5,8"], ["--header"], {"header": 3}),
    (["time,signal,value", "0,F,1.5", "0,n,1500", "1,F,2.5", "1,n,1501"], ["`signal` says in each row whose value it is (`F`, `n`)"], None),
    (["timestamp;id;value", "0.0;1;1.5", "0.1;2;1500", "0.2;1;2.5", "0.3;2;1501"], ["`id` says in each row"], None),
    (["SECONDS;PID;VALUE;UNITS;", *(f"{k};{'nv'[k % 2]};{k}.5;{'rpm' if k % 2 else 'km/h'};" for k in range(6))], ["`PID` says in each row"], None),
    (["VarName;TimeString;VarValue", *(f"{'Fn'[k % 2]};03.11.2026 13:15:0{k};{k}.5" for k in range(6))], ["`VarName` says in each row"], None),
    (["entity_id,state,last_changed", *(f"sensor.{'ab'[k % 2]},{k}.5,2026-11-03T13:15:0{k}Z" for k in range(6))], ["`entity_id` says in each row"], None),
    (["t [s];X;Einheit", *(f"{k};{k}.5;{'rpm' if k % 2 else 'km/h'}" for k in range(6))], ["`Einheit` says in each row"], None),
    (["Zeit;Art;Messung", *(f"2026-11-03 10:00:0{k};{kind};1.5" for kind in "ab" for k in range(3))], ["`Art` says in each row"], None),
])
def test_two_readings_are_asked_about(tmp_path, lines, words, said):
    with pytest.raises(OrchestratorError) as error:
        converted(tmp_path, rows(*lines))
    assert all(word in str(error.value) for word in words) and len(str(error.value).splitlines()) == 1, error.value
    if said:
        converted(tmp_path, rows(*lines), **said)


def test_units_that_their_case_tells_apart(tmp_path):
    header, _ = converted(tmp_path, rows("t [s],h [nm],M [Nm],d [µm],k [µS],c [µM],p [bar(g)],q [PSI],a (mrad)", "0,1,2,3,4,5,6,7,8", "1,2,3,4,5,6,7,8,9"))
    assert header == ["t [s]", "h [nm]", "M [Nm]", "d [um]", "k [uS]", "c [uM]", "p [bar(g)]", "q [psi]", "a [mrad]"]


def test_numbers_that_are_none(tmp_path):
    """Two numbers in a cell, a sign behind one: they stay for the program to ask. Fortran's exponents are read."""
    lines = ["t;F", "0;12.5 100", "1;1.5D+03", "2;1.5-", "4;1 200.5", "5;2.5", "6;0 100", "7;3.5"]
    assert [row[1] for row in converted(tmp_path, rows(*lines))[1]] == ["12.5 100", 1500.0, "1.5-", 1200.5, 2.5, "0 100", 3.5]


def test_a_clock_that_falls_and_short_rows_are_told(tmp_path, capsys):
    converted(tmp_path, rows("Time,F,n", "12:59:59,1.5,1", "01:00:00,2.5", "01:00:01,2.5,3"))
    told = capsys.readouterr().out
    assert "-43199 .. 0 s; it falls 1 times" in told and "1 rows have fewer than 3 cells, line 3 first" in told
    # Cells of remarks that separate better than those of the recording.
    remarks = [*(f"span {k} = {k}.5, {k}.75" for k in range(4)), "interval = 5", *(f"  {k}.5   {k}.25  {k}.75" for k in range(9))]
    with pytest.raises(OrchestratorError, match="10 lines below line 1 .* are no rows like it, line 5 first"):
        converted(tmp_path, rows(*remarks), header=0, delimiter=",")
    assert len(converted(tmp_path, rows(*remarks), header=0)[1]) == 9
    # A column of states beside a time that comes again is none of signals' names; `T` is no time; frames are no parts of a second.
    steps = rows("time [s],T,State", "0,1.5,R", "1,2.5,R", "1,2.6,C", "2,2.5,C", "3,2.5,C")
    assert len(converted(tmp_path, steps)[1]) == 5
    with pytest.raises(OrchestratorError, match="`13:15:00:01` is no known stamp"):
        converted(tmp_path, rows("when,T", "13:15:00:01,1.5", "13:15:00:24,2.5"))


def test_what_is_left_out_is_told(tmp_path, capsys):
    lines = ["t [s],T [degC],State", *(f"{k},{k}.5,R" for k in range(20)), "Total,,", "20,20"]
    assert len(converted(tmp_path, rows(*lines))[1]) == 20
    told = capsys.readouterr().out
    assert "the last one, is cut off" in told and "`State` holds text" in told and "`Total" in told
    # A stray letter is no second table, though days have it.
    assert len(converted(tmp_path, rows("t [s],T [degC]", "0,1.5", "1,2.5", "d", "2,3.5"))[1]) == 3


def test_rows_of_strange_cells_stay(tmp_path):
    """Without them the times of a constant rate would shift, and only numbers of one sign would be left."""
    table = converted(tmp_path, rows("F [N];M", "1.5;2", "(2.5);(3)", "OVL;OVL", "#DIV/0!;1", "3.5;4"))[1]
    assert table == [[1.5, 2.0], ["(2.5)", "(3)"], ["OVL", "OVL"], [" #DIV/0!", 1.0], [3.5, 4.0]]
    assert converted(tmp_path, rows("F;M", "(1.5);2", "2.5;3", "3.5;4"))[0] == ["F", "M"]
    # The first rows have remarks behind their last column.
    lines = rows("t;F;Folder;run 7", "0;1.5;a;1", "1;2.5;b;2", *(f"{k};{k}.5" for k in range(2, 9)))
    with pytest.raises(OrchestratorError, match="line 2 has 4 cells and most rows have 2"):
        converted(tmp_path, lines)
    assert [row[0] for row in converted(tmp_path, lines, header=1)[1]] == [*range(9)]
    assert converted(tmp_path, rows("X,CH1,Start,Step", "Sequence,Volt,-3.5e-03,5e-06", "0,1.5", "1,2.5", "2,2.5"), header=1)[1][0] == [0, 1.5]


def test_blank_lines_between_values_are_told(tmp_path, capsys):
    assert len(converted(tmp_path, rows("x", "1", "", "2", "3"))[1]) == 3
    assert "1 blank lines between the values were left out, line 3 first" in capsys.readouterr().out
    converted(tmp_path, rows("x,y", "1,2", "", "2,3", "3,4"))
    assert "1 blank lines between the values were left out, line 3 first" in capsys.readouterr().out


def test_a_channel_that_is_empty_at_its_beginning_stays(tmp_path):
    header, table = converted(tmp_path, rows("t [s],A,B", *(f"{k},{k}.5,{'' if k < 2500 else k}" for k in range(2600))))
    assert header[2] == "B" and [row[2] for row in table[2499:2502]] == ["", 2500.0, 2501.0]


def test_a_letter_behind_some_numbers_is_no_unit(tmp_path):
    for cell in ("800m", "800 mV"):
        header, table = converted(tmp_path, rows("t [s],U", "0,1.2", f"1,{cell}", "2,1.1"))
        assert header[1] == "U" and [row[1] for row in table] == [1.2, cell, 1.1]


def generated(tmp_path, seed):
    """A table drawn at random, written by hand; whether it is read back or asked about."""
    draw = random.Random(seed)
    decimal = draw.choice(".,")
    delimiter = draw.choice([";", "\t", "|", *([","] if decimal == "." else [])])
    count, width = draw.randint(3, 40), draw.randint(1, 5)
    encoding = draw.choice(["utf-8", "utf-8-sig", "cp1252", "utf-16"])
    names = [f"{draw.choice(['F', 'Öl', 'n', 'p_1'])}{k}" for k in range(width)]
    units, known = zip(*(draw.choice([("N", "N"), ("°C", "degC"), ("bar", "bar"), ("1/min", "1/min"), ("", "")]) for _ in names), strict=True)
    step = draw.choice([0.01, 0.5, 1.0, 60.0, 3600.0])
    grouping = draw.choice(["", "", "." if decimal == "," else "'"])
    values = [[round(draw.uniform(-1, 1) * 10 ** draw.randint(0, 6), draw.randint(0, 4)) for _ in names] for _ in range(count)]
    # Drawn apart, so that a seed still draws what it drew before.
    more = random.Random(f"{seed} more")
    style, is_down, has_remark = more.choice(["", "", "+", "0", "E"]), more.random() < 0.2, more.random() < 0.2
    order = range(count)[::-1] if is_down else range(count)

    def written(value):
        sign = "-" if value < 0 else "+" if style == "+" else ""
        text = f"{abs(value):.12E}" if style == "E" else f"{abs(value):,}" if grouping else f"{abs(value)}"
        return sign + text.rjust(12 if style == "0" and not grouping else 0, "0").replace(",", "_").replace(".", decimal).replace("_", grouping)

    kind = draw.choice(["seconds", "iso", "german", "two"])
    start = datetime.datetime(2026, draw.randint(1, 12), draw.randint(1, 28), draw.randint(0, 23))
    times = [start + datetime.timedelta(seconds=step * k) for k in range(count)]
    first = {"seconds": lambda k: [written(round(step * k, 6))], "iso": lambda k: [times[k].isoformat(" ")],
             "german": lambda k: [times[k].strftime("%d.%m.%Y %H:%M:%S.%f").replace(".", ".")],
             "two": lambda k: [times[k].strftime("%d.%m.%Y"), times[k].strftime("%H:%M:%S.%f")]}[kind]
    heads = {"seconds": ["t"], "two": ["Datum", "Uhrzeit"]}.get(kind, ["Zeit"])
    head_units = ["s"] if kind == "seconds" else [""] * len(heads)
    empty = {(draw.randrange(count), draw.randrange(width)) for _ in range(draw.choice([0, 0, 2]))}
    lines = ["Rig 7", "", ] if draw.random() < 0.3 else []
    if draw.random() < 0.3 and all([*units, *(["s"] if kind == "seconds" else [])]):
        lines += [delimiter.join([*heads, *names]), delimiter.join([*head_units, *units])]
    else:
        lines += [delimiter.join(name + (f" [{unit}]" if unit else "") for name, unit in zip([*heads, *names], [*head_units, *units], strict=True))]
    lines += [delimiter.join([*first(k), *("" if (k, j) in empty else written(value) for j, value in enumerate(values[k]))]) for k in order]
    lines[-count // 2 : -count // 2] = ["-----"] if has_remark else []
    newline = draw.choice(["\n", "\r\n"])
    try:
        header, table = converted(tmp_path, newline.join([*lines, ""]), name=f"g{seed}.csv", encoding=encoding)
    except OrchestratorError as error:
        assert "; say --" in str(error), (seed, str(error))
        return False
    expected = [("t" if kind == "seconds" else "time") + " [s]", *(name + (f" [{unit}]" if unit else "") for name, unit in zip(names, known, strict=True))]
    there = [j for j in range(width) if any((k, j) not in empty for k in range(count))]
    assert header == [expected[0], *(expected[j + 1] for j in there)], seed
    for k, row in zip(order, table, strict=True):
        assert row[0] == pytest.approx(step * (k - (0 if kind == "seconds" else order[0])), abs=2e-6), (seed, k)
        assert row[1:] == ["" if (k, j) in empty else values[k][j] for j in there], (seed, k)
    assert len(table) == count, seed
    return True


def written_by_pandas(tmp_path, seed):
    """The same of a table that pandas writes."""
    draw = random.Random(seed)
    decimal = draw.choice(".,")
    count, width = draw.randint(8, 40), draw.randint(1, 5)
    index = pandas.date_range("2026-11-03 13:15", periods=count, freq=f"{draw.choice([100, 1000, 60_000, 3_600_000])}ms", name="when")
    columns = {f"F{k} [N]": [round(draw.uniform(-1, 1) * 10 ** draw.randint(0, 6), draw.randint(0, 4)) for _ in range(count)] for k in range(width)}
    frame = pandas.DataFrame(columns, index=index)
    frame.loc[frame.index[draw.randrange(count)], "F0 [N]"] = float("nan")
    seconds = (index - index[0]).total_seconds().tolist()
    if draw.random() < 0.4:
        frame.index = pandas.Index(seconds, name="t [s]")
    form = draw.choice([None, "%d.%m.%Y %H:%M:%S.%f", "%Y/%m/%d %H:%M:%S.%f", "%m/%d/%Y %H:%M:%S.%f"])
    encoding = draw.choice(["utf-8", "utf-8-sig", "utf-16", "cp1252"])
    letters = draw.choice([";", "\t", "|", *([","] if decimal == "." else [])])
    path = tmp_path / f"p{seed}.csv"
    frame.to_csv(path, sep=letters, decimal=decimal, date_format=form, encoding=encoding, na_rep=draw.choice(["", "NaN", "-"]),
                 quoting=draw.choice([csv.QUOTE_MINIMAL, csv.QUOTE_ALL, csv.QUOTE_NONNUMERIC]), lineterminator=draw.choice(["\n", "\r\n"]))
    try:
        header, table = converted(tmp_path, path.read_bytes(), name=path.name)
    except OrchestratorError as error:
        assert "; say --" in str(error), (seed, str(error))
        return False
    assert header == ["t [s]" if frame.index.name == "t [s]" else "time [s]", *columns], seed
    assert [row[0] for row in table] == pytest.approx(seconds, abs=2e-6), seed
    assert [["" if value != value else value for value in row] for row in frame.to_numpy().tolist()] == [row[1:] for row in table], seed
    return True


def test_generated_tables_come_back_or_are_asked_about(tmp_path):
    assert sum(generated(tmp_path, seed) for seed in range(40)) > 25
    assert sum(written_by_pandas(tmp_path, seed) for seed in range(20)) > 12


@pytest.mark.long
def test_300_generated_tables(tmp_path):
    """`GENERATED=5000` draws others."""
    begin = int(os.environ.get("GENERATED", "1000"))
    read = [sum(way(tmp_path, seed) for seed in range(begin, begin + 150)) for way in (generated, written_by_pandas)]
    print(f"{begin}: {read} of 150 by hand and 150 by pandas are read back, the others asked about")
    assert min(read) > 90

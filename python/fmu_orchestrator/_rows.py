"""Rows of text as a logger or a spreadsheet wrote them, as columns of numbers.

What has two possible readings is refused with both and the option that decides; what is left out is told. That is why stamps, numbers
and encodings are read here: dateutil takes 03/11 for March, pandas takes 1.234 for a number below 2, charset-normalizer ranks
encodings by likeliness, and none of them says that there was a choice.
"""

import contextlib
import csv
import dataclasses
import datetime
import functools
import math
import re
import unicodedata
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import islice, pairwise
from pathlib import Path
from typing import Any, NoReturn

from ._errors import OrchestratorError

SEPARATORS = {"tab": "\t", ";": ";", "|": "|", ",": ",", "space": " "}
SAMPLE = 2000
DAY_NS = 86400 * 10**9
# Cells that say that there is no value, whoever wrote them.
NOTHING = {"", "-", "--", "---", "nan", "n/a", "#n/a", "na", "null", "none", "<na>", "#n/v"}
NUMBER = re.compile(r"[+-]?(\d+([.,]\d*)*|[.,]\d+)([eE][+-]?\d+|[dD][+-]\d+)?")
OTHER = {".": ",", ",": "."}
# One to three digits, then groups of three: thousands, or a number with three decimals.
GROUPED = re.compile(r"[+-]?[1-9]\d{0,2}([.,]\d{3})+")
BLANKS = re.compile(r"[+-]?[1-9]\d{0,2}(['\u2019\u00a0\u202f\u2009 ])\d{3}(?:\1\d{3})*(?!\d)")
DAY = re.compile(r"(?:[A-Za-z]{2,3}[.,]* )?(\d{1,4})([-./ ]) ?(\d{1,2}|[^\W\d_]{3,9}(?=[-. ]))(?:(?<=\D)\.)?([-./ ]) ?(\d{1,4})(?!\d)")
MONTH_FIRST = re.compile(r"(?:[A-Za-z]{2,3}[.,]* )?([^\W\d_]{3,9})\.? (\d{1,2}),? (\d{4})(?!\d)")
LIKE_STAMP = re.compile(r"\d{1,4}\D+\d{1,3}\D+\d")
COMPACT = re.compile(r"((?:19|20)\d\d)([01]\d)([0-3]\d)[T :_]?(\d\d)(\d\d)(\d\d(?:[.,]\d+)?)?(Z|[+-]\d\d:?\d\d)?")
HOURS = re.compile(
    r"(?:(\d+) ?d(?:ays?)?,? ?)?(\d{1,6}):(\d\d)(?::(\d\d))?(?:[.,](\d{1,12})|(?<=:\d\d:\d\d):(\d{3}))?(?: ?([AaPp])\.?(?:[Mm]\.?)?)?(?: ?(Z|UTC|GMT|[+-]\d\d:?\d\d))?")
# How months begin in English, German, French, Spanish and Italian, without accents.
MONTHS = {name: k for k, names in enumerate("jan ene gen|feb fev|mar mrz|apr avr abr|may mai mag|jun juin giu|jul juil lug|aug aou ago|sep set|"
                                            "oct okt ott|nov|dec dez dic".split("|"), 1) for name in names.split()}
# Days and clocks as numbers, the names of their columns, and a form that says how they are written.
DAYS = ["%Y%m%d", "%d%m%Y", "%m%d%Y", "%y%m%d", "%d%m%y", "%m%d%y", "%Y%j", "%Y%m%d%H"]
CLOCKS = ["%H%M", "%H%M%S"]
CALLED_DAY = re.compile(r"(?i)(?<![a-z])(date|datum|dat|fecha|data|dato|day|tag|jour|ymd|y{2,4}mmdd)(?![a-z])|date$|datum$")
CALLED_CLOCK = re.compile(r"(?i)time|zeit|uhr|clock|hhmm|hora|heure|start|begin|stop|end$|^(von|bis)$|(?<![a-z])(hour|utc|hrmn)(?![a-z])")
FORM_OF_FIGURES = re.compile(r"((?:%[Yymdj])+)? ?(%H%M(?:%S)?)?")
FORMS = {"day first": "%d{0}%m{0}{1}", "month first": "%m{0}%d{0}{1}", "year first": "{1}{0}%m{0}%d"}
TIMES = {"t", "ts", "time", "zeit", "timestamp", "timestamps", "tout"}
# Names of columns in a table that has a row for each value of each signal.
SIGNALS = {"signal", "name", "channel", "variable", "parameter", "sensor", "tag", "id", "pid", "item", "kanal", "quantity", "measurement"}
VALUES = {"value", "values", "val", "wert", "messwert", "reading"}
PARTS = {"year": "year yr yy yyyy jahr", "month": "month mo mon mm monat", "day": "day dy dd tag", "hour": "hour hr hh stunde",
         "minute": "minute min mi minuten", "second": "second sec ss sekunde"}
MOST = {"year": 9999, "month": 12, "day": 31, "hour": 24, "minute": 59, "second": 60}
# Spellings that are right as they stand; only their case tells some of them apart (mN, MN; nm, Nm; us, uS).
KNOWN = set("1 % s ms us ns min h d Hz kHz MHz GHz m cm mm um km N kN mN MN N.m Nm N.mm Nmm kNm Pa hPa mbar kPa bar MPa psi W kW MW "
            "K degC degF deg rad mrad rad/s deg/s rpm 1/min 1/s m/s mm/s km/h m/s2 g kg kg/s g/s kg/h m3/s m3/h l/min V mV kV A mA uA Ah mAh J kJ "
            "kWh MWh Wh Ohm - W/m2 W/m^2 mg/m3 ppm nm uS mS".split())
# Others, in lower case.
UNITS = {word.strip(): unit for unit, words in {
    "degC": "deg c|℃|degc|grad c|cdeg|celsius", "degF": "deg f|℉|degf|fahrenheit", "K": "kelvin", "1/min": "min⁻¹|min-1", "rpm": "u/min|rpm",
    "N.m": "n m|n*m", "V": "volt|volts", "A": "ampere|amps", "s": "second|seconds|sekunden|sec", "min": "minutes", "h": "hours", "psi": "psi",
    "N": "newton", "W": "watt", "m": "meter|metre", "%": "percent"}.items() for word in words.split("|")}
OF_TIME = {"s", "ms", "us", "ns", "min", "h", "d"}
BRACKETS = ("[]", "()")
LETTERS = str.maketrans({"°": "deg", "·": ".", "²": "2", "³": "3", "µ": "u", "μ": "u"})


@dataclass
class Options:
    """What the user says of a file."""

    delimiter: str | None = None
    decimal: str | Mapping[str, str] | None = None  # by columns; of "" where a column itself does not tell
    encoding: str | None = None
    header: int | None = None
    format: str | None = None
    time: str | None = None
    units: dict[str, str] = field(default_factory=dict)


@dataclass
class Columns:
    """A table as it was understood."""

    time: list[float | None] | None
    channels: list[tuple[str, str, Sequence[Any]]]
    start: datetime.datetime | None = None
    told: list[str] = field(default_factory=list)


def unit(text: str) -> str:
    """A unit in the letters that the program knows; an unknown one stays."""
    bare = text.strip()
    bare = (bare[1:-1].strip() if bare[:1] + bare[-1:] in BRACKETS else bare).translate(LETTERS)
    return bare if bare in KNOWN else UNITS.get(bare.lower(), bare)


def _is_unit(text: str) -> bool:
    return unit(text) in KNOWN or len(text) > 2 and text[0] + text[-1] in BRACKETS and not _is_number(text[1:-1])


def is_time_name(name: str) -> bool:
    """Whether a column is called time: `T` is a temperature."""
    return name == "t" or name != "T" and name.lower() in TIMES


def split_name(name: str) -> tuple[str, str]:
    """The name without its unit, and that."""
    name = " ".join(name.split())
    if found := re.fullmatch(r"(.*\S) ?\[([^][]+)\]", name):
        return (name, "") if re.fullmatch(r"[\d, ]+", found[2]) and " [" not in name else (found[1], unit(found[2]))
    # `G(h)` and `T(min)` are names, `t (h)`, `t(h)` and `n(rpm)` are not; `time/s` is a time, and `Dev0/A` may be anything.
    for form in (r"(.*\S)( ?)\(([^()]+)\)", r"(.*\S)( )in (\S+)", r"(.*\S)( )/ (\S+)", r"(\S+)/( ?)\((.+)\)", r"(\S+)()/([^\s()]+)"):
        if (found := re.fullmatch(form, name)) and _is_unit(found[3]):
            bare, known = found[1].rstrip("/ "), unit(found[3])
            if found[2] or is_time_name(bare) and known in OF_TIME or "(" in name and known != "min" and (len(bare) > 2 or len(found[3]) > 1):
                return bare, known
    return name, ""


def text(path: Path, encoding: str | None) -> tuple[str, str]:
    """The text of a file and its encoding."""
    content = path.read_bytes()
    marks = [(b"\xff\xfe", "utf-16"), (b"\xfe\xff", "utf-16")]
    known = encoding or next((name for mark, name in marks if content.startswith(mark)), None)
    if known is None and content[1:8:2] == bytes(len(content[1:8:2])) and len(content) > 8 and 0 not in content[:8:2]:
        known = "utf-16-le"
    for name in [known] if known else ["utf-8", "cp1252"]:
        try:
            decoded = content.decode(name)
        except (UnicodeDecodeError, LookupError):
            continue
        if "\0" in decoded[:100_000]:
            break
        # Some loggers begin each line with the mark of the encoding.
        return decoded.replace("\ufeff", ""), name
    raise OrchestratorError(f"{path}: no text in {known or 'UTF-8 or Windows-1252'}; say --encoding, or export it as csv")


def read(path: Path, options: Options) -> Columns:
    """A file of text."""
    content, encoding = text(path, options.encoding)
    told = [] if encoding.startswith("utf-8") else [f"encoding: {encoding}"]
    lines = content.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    if lines[0].startswith("LabVIEW Measurement"):
        return _labview(path, lines, options)
    if lines[0].startswith("* Sea-Bird") and any(line.startswith("# name 0 = ") for line in lines):
        return _seabird(path, lines, options)
    delimiter = SEPARATORS.get(options.delimiter or "", options.delimiter)
    if lines[0].lower().startswith("sep=") and len(lines[0].strip()) == 5:
        delimiter, lines[0] = delimiter or lines[0][4], ""
    if delimiter is None:
        delimiter = _separator(path, lines)
    rows = _split(path, lines, delimiter)
    shown = next((name for name, letter in SEPARATORS.items() if letter == delimiter), delimiter)
    point = delimiter == "," and not any("," in cell and _is_number(cell) for row in rows for cell in row)
    columns = table(path, rows, options, "." if point else None, delimiter == " ")
    columns.told = [*told, f"between cells: {shown}", *columns.told]
    return columns


def _split(path: Path, lines: Sequence[str], delimiter: str) -> list[list[str]]:
    """The cells of all lines; a blank line has none."""
    if delimiter == " ":
        return [_words(line) for line in lines]
    try:
        # A quote that nobody closes would swallow the rest: each line is read alone.
        return [[cell.strip() for cell in next(csv.reader([line], delimiter=delimiter), [])] if line.strip() else [] for line in lines]
    except (csv.Error, TypeError) as error:
        raise OrchestratorError(f"{path}: {error}; say --delimiter") from error


def _words(line: str) -> list[str]:
    """Words of a line; a unit belongs to the name before it."""
    row: list[str] = []
    for word in re.findall(r'"[^"]*"|\S+', line.removeprefix("#")):
        if row and word[0] in "[(" and row[-1][:1] not in "[(":
            row[-1] += f" {word}"
        else:
            row.append(word.strip('"'))
    return row


def _is_number(cell: str) -> bool:
    if cell.isdigit():
        return True
    return NUMBER.fullmatch(_plain(cell)) is not None


def _plain(cell: str) -> str:
    cell = cell.strip().replace("\u2212", "-")
    found = None if cell.isascii() and "'" not in cell and " " not in cell else BLANKS.match(cell)
    return found[0].replace(found[1], "") + cell[found.end():] if found else cell


def _is_stamp(cell: str) -> bool:
    cell = cell.strip()
    return bool(cell) and cell[0].isalnum() and (_moment(cell, None) is not None)


def _is_value(cell: str) -> bool:
    return _is_number(cell) or _is_stamp(cell)


def _separator(path: Path, lines: Sequence[str]) -> str:
    """The one with which most lines have the same number of cells and these are values."""
    sample = [line for line in lines if line.strip()]
    # What remarks have between their words says nothing of the rows.
    sample = ([line for line in sample if line[0] not in "#*"] or sample)[:SAMPLE]
    best: list[tuple[float, str, float]] = []
    for letter in SEPARATORS.values():
        rows = [row for row in _split(path, sample, letter) if len(row) > 1 and any(_is_value(cell) or _suffix(cell) for cell in row)]
        widths = Counter(map(len, rows))
        if not widths:
            continue
        width, count = widths.most_common(1)[0]
        cells = [cell for row in rows if len(row) == width for cell in row if cell]
        sound = sum(_is_value(cell) or bool(_suffix(cell)) for cell in cells) / max(len(cells), 1)
        best.append((count / len(sample) * (0.5 + sound), letter, sound))
    # Blanks stand within cells, too: they separate where nothing else does, and beside decimal commas, between which is no number.
    others = [one for one in best if one[1] != " "]
    best = others if others and (best[-1][2] <= 0.7 or any(one[2] > 0.5 for one in others)) else best
    if not best:
        return ","
    best.sort(key=lambda one: -one[0])
    return best[0][1]


def table(path: Path, rows: list[list[str]], options: Options, decimal: str | None = None, exact: bool = False) -> Columns:
    """The columns of a table of texts; with ``exact``, an empty cell is none."""
    told: list[str] = []
    while rows and not any(rows[-1]):
        rows.pop()
    body = [k for k, row in enumerate(rows) if any(map(_is_value, row))]
    if options.header:
        body = [k for k in body if k >= options.header]
    if len(body) < 2:
        raise OrchestratorError(f"{path}: fewer than two rows of numbers; say --delimiter or --header, or export it as csv")
    # Rows of the recording have one width, or lack empty cells at their ends.
    filled = {k: max(j for j, cell in enumerate(row) if cell) + 1 for k, row in enumerate(rows) if any(row)}
    width, most = Counter(len(rows[k]) for k in body).most_common(1)[0][0], max(filled[k] for k in body)
    # Names that are stated are those of the longest rows, too.
    if options.header and filled.get(options.header - 1) == most and any(filled[k] == most and all(map(_is_value, rows[k][:width])) for k in body):
        width = most
    like = [rows[k] for k in body if len(rows[k]) == width or options.header]
    kinds, marks = zip(*(_kind([row[j] for row in like if j < len(row)]) for j in range(width)), strict=True)
    typed = [j for j, kind in enumerate(kinds) if kind != "text"]
    if not typed:
        raise OrchestratorError(f"{path}: no column of numbers; say --delimiter")

    def known(k: int) -> tuple[int, int]:
        """How many cells of a row are what their columns are, and how many there are."""
        row = rows[k]
        there = [j for j in typed if j < len(row) and row[j].lower() not in NOTHING and row[j] != marks[j]]
        return sum(_is_number(row[j]) or bool(_suffix(row[j])) if kinds[j] == "number" else _is_value(row[j]) for j in there), len(there)

    def fits(k: int) -> bool:
        row = rows[k]
        sound, there = known(k)
        fitting = len(row) == width if exact else filled[k] <= width
        return fitting and sound > 0 and 2 * sound >= there

    good = [k for k in body if fits(k)]
    # The recording begins with a row that has no doubt, and with rows with marks right above it.
    first = next((k for k in good if known(k)[0] == known(k)[1]), None)
    while first is not None and first - 1 in good[: good.index(first)]:
        first -= 1
    good = [k for k in good if first is not None and k >= first]
    if first is None or not good:
        raise OrchestratorError(f"{path}: no rows of numbers of one width; say --delimiter or --header")
    heads = {split_name(cell)[0] for row in rows[:first] for cell in row}

    def is_head(row: list[str]) -> bool:
        return all(split_name(cell)[0] in heads or _is_unit(cell) for cell in row if cell)

    # A row of marks alone is one, too, and among the others one of cells that are no numbers: the times of a constant rate would shift.
    good = sorted({*good, *(k for k in {*range(good[0], len(rows))}.difference(good) if any(rows[k]) and len(rows[k]) == width and (
        all(cell.lower() in NOTHING for cell in rows[k]) or (k < good[-1] or width > 1) and all(rows[k][j] for j in typed) and not is_head(rows[k])))})
    long = next((k for k in body if filled[k] > width and (k > good[0] or 1 < known(k)[0] == known(k)[1])), None)
    if long is not None:
        raise OrchestratorError(
            f"{path}: line {long + 1} has {filled[long]} cells and most rows have {width}; a decimal comma needs another letter between "
            "cells: say --delimiter, or correct the line")
    names, units, header = _header(path, rows, first, width, options)
    over = [k for k in body if k < header - 1 or header <= k < first and 2 * known(k)[0] > known(k)[1]]
    for k, after in pairwise(over):
        if k + 1 == after < header and len(rows[k]) == len(rows[after]) > 2 and min(sum(map(_is_value, rows[line])) for line in (k, after)) > 1:
            raise OrchestratorError(
                f"{path}: line {k + 1} (`{' '.join(rows[k])[:40]}`) belongs to another table, which stands above that of line {header}; save it as a "
                f"file of its own, and say --header {header} for the other")
    if over:
        told.append(f"{len(over)} lines with numbers above the recording were left out, line {over[0] + 1} first: `{' '.join(rows[over[0]])[:60]}`")
    columns_named = max((j + 1 for j, name in enumerate(names) if name), default=0)
    if columns_named > width:
        if not options.header:
            raise OrchestratorError(
                f"{path}: {columns_named} names on line {header} and {width} cells in most rows; say --delimiter, or --header {header} where the last "
                "names have no cells")
        told.append(f"no cells below `{'`, `'.join(filter(None, names[width:]))}`")
        names, units = names[:width], units[:width]
    if not header and options.header is None:
        # Codes and channel numbers may stand where names do: as values they would be a row that nobody measured.
        raise OrchestratorError(
            f"{path}: line {first + 1} (`{' '.join(rows[first])[:40]}`) is all numbers, and no names stand above: they may be values or names; say "
            f"--header 0 where they are values, or --header {first + 1}")
    if not header:
        told.append("no row of names: the columns are numbered")
    most = max(filled[k] for k in good)
    if header and len(names) < most:
        raise OrchestratorError(
            f"{path}: {len(names)} names on line {header} and {most} cells below; a decimal comma needs another letter between cells: say "
            "--delimiter or --header, or correct the names")
    last = len(rows) - 1
    if len(rows[last]) < width and last == good[-1] and len(good) > 2 and len(rows[good[-2]]) == width:
        good.pop()
        told.append(f"line {last + 1}, the last one, is cut off and was left out")
    others = [k for k in sorted({*range(first, len(rows))}.difference(good)) if any(rows[k]) and not (told and k == last)]
    if others:
        again = next((k for k in others if rows[k] not in rows[:first] and (width == 1 or sum(map(bool, rows[k])) > 1) and is_head(rows[k])), None)
        if again is not None:
            raise OrchestratorError(f"{path}: another table begins on line {again + 1} (`{' '.join(rows[again])[:60]}`); save each as a file of its own")
        shown = " ".join(rows[others[0]])[:60]
        if len(others) > len(good):
            raise OrchestratorError(
                f"{path}: {len(others)} lines below line {first + 1} (`{' '.join(rows[first])[:40]}`) are no rows like it, line {others[0] + 1} first: `{shown}`; "
                "say --delimiter or --header")
        told.append(f"{len(others)} lines hold no row of the recording and were left out, line {others[0] + 1} first: `{shown}`")
    blank = [k for k in range(good[0], good[-1]) if not any(rows[k])]
    if blank:
        told.append(f"{len(blank)} blank lines between the values were left out, line {blank[0] + 1} first: if values are missing there, write nan")
    short = [k for k in good if len(rows[k]) < width]
    if short:
        told.append(f"{len(short)} rows have fewer than {width} cells, line {short[0] + 1} first: their last columns are taken as empty; where other cells are missing, correct them")
    cells = [[rows[k][j] if j < len(rows[k]) else "" for k in good] for j in range(width)]
    return _columns(path, names, units, list(kinds), cells, decimal, options, told)


def _kind(cells: Sequence[str]) -> tuple[str, str]:
    """What a column holds, and the only text among its numbers, which is a mark."""
    there = list(islice((cell for cell in cells if cell.lower() not in NOTHING), SAMPLE))
    numbers, stamps = sum(map(_is_number, there)), sum(map(_is_stamp, there))
    if stamps > len(there) / 2:
        return "stamp", ""
    others = [cell for cell in there if not _is_number(cell)]
    with_unit, texts = sum(bool(_suffix(cell)) for cell in others), set(others)
    mark = others[0] if len(texts) == 1 < len(others) and numbers and not with_unit else ""
    return "number" if mark or max(numbers, with_unit) >= len(there) / 2 and numbers + with_unit else "text", mark


def _suffix(cell: str) -> str:
    """The unit behind a number."""
    if not cell or cell.isdecimal():
        return ""
    # A minus behind a number is its sign in some files, and no unit; a unit that begins with a figure stands behind a blank.
    found = re.fullmatch(NUMBER.pattern + r"\s*([^\d\s.,;-].*|(?<=\s)1/.*)", _plain(cell))
    # A letter right behind a figure may be a factor: 800m are 0.8.
    return found[found.re.groups] if found and _is_unit(found[found.re.groups]) and not re.search(r"[\d.,]m$", cell) else ""


def _header(path: Path, rows: list[list[str]], first: int, width: int, options: Options) -> tuple[list[str], list[str], int]:
    """Names and units above the first row, and the line of the names."""
    def cleaned(k: int) -> list[str]:
        row = list(rows[k])
        row[0] = row[0].lstrip("#%!~ ")
        if not row[0] and len(row) > width:
            row = row[1:]
        return [cell.strip("\"' ") for cell in row]

    if rows[0][:1] == ["TOA5"] and first >= 4:
        # Campbell Scientific: a line about the station, names, units, how each was processed.
        return rows[1], [unit(cell) if cell else "" for cell in rows[2]], 2
    if options.header:
        above = [k for k in range(options.header - 1, first) if any(rows[k])]
    else:
        above = []
        for k in range(first - 1, -1, -1) if options.header is None else ():
            # A spreadsheet fills up a title with empty cells.
            if above and not any(rows[k][width > 2 :]):
                break
            if any(rows[k]):
                if len(rows[k]) < max(width - 1, 2) and width > 1:
                    break
                above.insert(0, k)
    if not above:
        return [str(j + 1) for j in range(width)], [""] * width, 0
    heads = [cleaned(k) for k in above]

    def are_units(row: list[str]) -> bool:
        said = [cell for cell in row if cell]
        return 2 * sum(map(_is_unit, said)) > len(said)

    # Units stand right below the names, with at most two rows of remarks behind them.
    below = [j for j in range(max(1, len(heads) - 3), len(heads)) if are_units(heads[j])][-1:]
    if options.header:
        place, units = 0, heads[below[0]] if below else []
    elif below:
        place, units = below[0] - 1, heads[below[0]]
    elif len(heads) == 1:
        place, units = 0, []
    else:
        lines = " or ".join(f"line {k + 1} (`{' '.join(rows[k])[:30]}`)" for k in above[-3:])
        raise OrchestratorError(f"{path}: the names may be {lines}; say --header LINE")
    names = heads[place][:]
    units = [unit(cell) if cell else "" for cell in units]
    return names, units, above[place] + 1


def _numbers(
    path: Path, labels: Sequence[str], kinds: Sequence[str], cells: Sequence[Sequence[str]], said: Mapping[str, str], told: list[str]
) -> dict[int, Callable[[str], float | None]]:
    """How cells become numbers. Each column tells for itself: a point for decimals in one says nothing of another, in which it may
    stand between thousands."""
    numbers: dict[int, Callable[[str], float | None]] = {}
    groups: dict[str, list[str]] = {}
    for j, label in enumerate(labels):
        if kinds[j] == "number":
            decimal, has_marks, has_groups = _decimal(path, label, cells[j], said)
            between = OTHER[decimal]
            group = re.compile(rf"[+-]?[1-9]\d{{0,2}}(\{between}\d{{3}})+(\{decimal}\d*)?([eEdD][+-]?\d+)?")
            numbers[j] = functools.partial(_number, between, group)
            if has_marks:
                groups.setdefault(f"decimal mark: {decimal}" + (f"; `{between}` stands between thousands" if has_groups else ""), []).append(label)
    for words, names in groups.items():
        if words != "decimal mark: .":
            told.append(words + (f" in `{'`, `'.join(names)}`" if len(groups) > 1 else ""))
    return numbers


def _number(between: str, group: re.Pattern[str], cell: str) -> float | None:
    plain = _plain(cell)
    if not NUMBER.fullmatch(plain):
        return None
    if between in plain:
        if not group.fullmatch(plain):
            return None
        plain = plain.replace(between, "")
    value = float(plain.replace(",", ".").lower().replace("d", "e"))
    return value if math.isfinite(value) else None


def _decimal(path: Path, label: str, column: Sequence[str], said: Mapping[str, str]) -> tuple[str, bool, bool]:
    """Which of point and comma is the decimal mark of a column, whether it has marks, and whether one stands between thousands."""
    seen: dict[tuple[str, str], str] = {}  # the first cell in which a mark has a role
    for cell in column:
        if not cell or cell.isdecimal() or not NUMBER.fullmatch(cell := _plain(cell).removesuffix(_suffix(cell)).rstrip()):
            continue
        marks = re.findall("[.,]", cell)
        if len(set(marks)) == 2:
            seen.setdefault(("decimal", marks[-1]), cell)
        if marks:
            role = "thousands" if len(marks) > 1 else "unclear" if GROUPED.fullmatch(cell) else "decimal"
            seen.setdefault((role, marks[0]), cell)
    evidence, thousands, unclear = ({mark: seen[role, mark] for mark in ".," if (role, mark) in seen} for role in ("decimal", "thousands", "unclear"))
    doubtful = {mark: cell for mark, cell in unclear.items() if mark not in thousands and mark not in evidence}
    if label in said:
        decimal = said[label]
    elif len(evidence) == 1 and not doubtful:
        [decimal] = evidence
    elif len(thousands) == 1 and not evidence:
        decimal = OTHER[next(iter(thousands))]
    elif "" in said or not seen:
        decimal = said.get("", ".")
    elif doubtful:
        mark, cell = next(iter(doubtful.items()))
        beside = "".join(f" beside `{other}`" for other in evidence.values())
        raise OrchestratorError(
            f"{path}: `{cell}` in column `{label}` may be {cell.replace(mark, '')} or {cell.replace(mark, '.')}{beside}; say --decimal \"{mark}\" where "
            f"`{mark}` is the decimal mark, or --decimal \"{OTHER[mark]}\" where it stands between thousands; of this column alone, --decimal \"{label}={mark}\"")
    else:
        raise OrchestratorError(
            f"{path}: column `{label}`: `{evidence['.']}` has a decimal point and `{evidence[',']}` a decimal comma; say --decimal \"{label}=.\" or "
            f"--decimal \"{label}=,\", and the cells of the other kind stay as they are, or correct one")
    if decimal in thousands:
        raise OrchestratorError(f"{path}: column `{label}`: `{thousands[decimal]}` has several `{decimal}`, which is its decimal mark; correct one of its cells")
    return decimal, bool(seen), OTHER[decimal] in thousands or OTHER[decimal] in unclear


@dataclass
class Moment:
    """A stamp: its day and its time, or one of them."""

    days: Mapping[str, datetime.date] | None  # the days that it may mean, by the order of day and month
    seconds: float | None
    is_short: bool = False  # hours and minutes alone, or minutes and seconds
    has_zone: bool = False  # the stamp says it, and the time is that of Greenwich


@functools.lru_cache(1 << 14)
def _days(one: str, mark: str, two: str, behind: str, three: str) -> Mapping[str, datetime.date]:
    if sorted((len(one) // 3, len(three) // 3)) != [0, 1] and len(three) != 2 or two.isdigit() and mark != behind:
        return {}
    word = unicodedata.normalize("NFKD", two.lower()).encode("ascii", "ignore").decode()
    month = two if two.isdigit() else str(MONTHS.get(word[:4]) or MONTHS.get(word[:3], 0))
    readings = {"": (one, month, three)} if len(one) == 4 else {"": (three, month, one)}
    is_short = len(one) == len(three) == 2 and two.isdigit()
    if len(one) < 3 and two.isdigit() and (mark in "/-" or is_short):
        readings = {"day first": (three, two, one), **({"month first": (three, one, two)} if mark in "/-" else {})}
        if is_short:
            readings["year first"] = (one, two, three)
    days = {}
    for order, (year, at, day) in readings.items():
        with contextlib.suppress(ValueError):
            days[order] = datetime.date(int(year) + (2000 if len(year) == 2 else 0), int(at), int(day if len(day) < 3 else 0))
    return days


def _moment(cell: str, form: str | None) -> Moment | None:
    if form:
        if cell.isdecimal() and FORM_OF_FIGURES.fullmatch(form):
            # Where leading zeros are missing, 10505 would be 10:50:05.
            cell = cell.zfill(_width(form.replace(" ", "")))
        # The form of a date leaves the clock in a column beside it as it is.
        dated = not any(letter in form for letter in ("%H", "%I", "%M", "%S", "%X", "%c"))
        with contextlib.suppress(ValueError):
            at = datetime.datetime.strptime(cell, form)
            day = {"": at.date()} if any(letter in form for letter in ("%d", "%j", "%x", "%c")) else None
            if dated:
                return Moment(day, None)
            seconds = (at.replace(tzinfo=None) - datetime.datetime.combine(at.date(), datetime.time())).total_seconds()
            return Moment(day, seconds - (at.utcoffset() or datetime.timedelta()).total_seconds(), False, at.tzinfo is not None)
        beside = _moment(cell, None) if dated else None
        return beside if beside and beside.days is None else None
    if found := COMPACT.fullmatch(cell):
        cell = f"{found[1]}-{found[2]}-{found[3]} {found[4]}:{found[5]}{f':{found[6]}' if found[6] else ''}{found[7] or ''}"
    if found := MONTH_FIRST.match(cell):
        cell = f"{found[2]} {found[1]} {found[3]}{cell[found.end():]}"
    days, rest = None, cell
    if not HOURS.fullmatch(cell) and (found := DAY.match(cell)):
        days, rest = _days(*found.groups()), cell[found.end():].lstrip(" T,")
        if not days:
            return None
        if not rest:
            return Moment(days, None)
    clock = HOURS.fullmatch(rest)
    if clock is None:
        return None
    above, first, second, third, part, thousandths, half, zone = clock.groups()
    if part and third is None:
        # Only seconds have parts.
        first, second, third = "0", first, second
    if int(second) > 59 and first != "0" or int(third or 0) > 60 or third and part and clock[4] is None and (days or above or half):
        return None
    hours = int(first) if not half else int(first) % 12 + (12 if half in "pP" else 0)
    seconds = int(above or 0) * 86400 + hours * 3600 + int(second) * 60 + int(third or 0) + float(f"0.{part or thousandths or 0}")
    if zone and zone[0] in "+-":
        zone = zone.replace(":", "")
        seconds -= (int(zone[1:3]) * 3600 + int(zone[3:]) * 60) * (-1 if zone[0] == "-" else 1)
    return Moment(days, seconds, not (third or days or half), bool(zone))


def _columns(
    path: Path, names: list[str], units: list[str], kinds: list[str], cells: list[list[str]], decimal: str | None, options: Options, told: list[str]
) -> Columns:
    width = len(cells)
    names = [names[j] if j < len(names) and names[j] else str(j + 1) for j in range(width)]
    parts = [split_name(name) for name in names]
    labels = [bare for bare, _ in parts]
    said = [units[j] if j < len(units) and units[j] not in ("", "-") else parts[j][1] for j in range(width)]
    for column, given in options.units.items():
        if column not in labels and column not in names:
            raise OrchestratorError(f"{path}: --unit {column}: there is no such column; it has {', '.join(labels)}")
        said[labels.index(column) if column in labels else names.index(column)] = given
    said_marks = {"": options.decimal} if isinstance(options.decimal, str) else dict(options.decimal or {})
    said_marks |= {} if "" in said_marks or decimal is None else {"": decimal}
    for column, mark in said_marks.items():
        if column and column not in labels or mark not in OTHER:
            raise OrchestratorError(f"{path}: --decimal {column}{'=' * bool(column)}{mark}: say . or , or NAME=MARK; the columns are {', '.join(labels)}")
    numbers = _numbers(path, labels, kinds, cells, said_marks, told)
    taken: set[int] = set()
    options = _of_figures(path, labels, said, kinds, cells, numbers, options, taken)
    time, start = _time(path, labels, names, kinds, cells, numbers, options, told, taken)
    _refuse_signals_in_rows(path, labels, kinds, cells, time, taken)
    channels: list[tuple[str, str, Sequence[Any]]] = []
    timed = options.time or any(kinds[j] == "number" and (said[j] in OF_TIME or is_time_name(labels[j])) for j in range(width))
    for j in range(width):
        if j in taken:
            continue
        if not any(cells[j]):
            told.append(f"column `{labels[j]}` is empty and was left out")
            continue
        if kinds[j] != "number":
            sample = next((cell for cell in cells[j] if cell and not _is_number(cell)), "")
            held = "moments" if kinds[j] == "stamp" else "text"
            if time is None and not timed and sum(map(bool, map(LIKE_STAMP.match, cells[j]))) > len(cells[j]) / 2 < len(set(cells[j])):
                raise OrchestratorError(f"{path}: column `{labels[j]}` may be the time, but `{sample[:40]}` is no known stamp; say --format, or --time none")
            told.append(f"column `{labels[j]}` holds {held} (`{sample[:40]}`) and was left out")
            continue
        suffixes = {_suffix(cell) for cell in cells[j] if cell.lower() not in NOTHING}
        # Where only some have one, the others may be of any unit.
        plain = not said[j] and any(map(_is_number, cells[j]))
        suffix = next(iter(suffixes - {""})) if len(suffixes - {""}) == 1 and not plain else ""
        if suffix and said[j] and said[j] != unit(suffix):
            raise OrchestratorError(f"{path}: column `{labels[j]}` is in `{said[j]}` and its cells in `{unit(suffix)}`; say --unit \"{labels[j]}={unit(suffix)}\" or correct one")
        said[j] = unit(suffix) if suffix else said[j]
        values: list[Any] = []
        marks = 0
        for cell in cells[j]:
            if cell.lower() in NOTHING:
                marks += bool(cell)
                values.append(None)
            else:
                value = numbers[j](cell.removesuffix(suffix).strip())
                # What is no number stays for the reader to ask.
                values.append(cell if value is None else value)
        if marks:
            told.append(f"column `{labels[j]}`: {marks} cells such as `{next(c for c in cells[j] if c and c.lower() in NOTHING)}` became empty")
        texts = [value for value in values if isinstance(value, str)]
        if texts:
            told.append(f"column `{labels[j]}`: {len(texts)} cells are no numbers, such as `{texts[0][:40]}`, and stay as they are")
        channels.append((labels[j], said[j], values))
    if not channels:
        raise OrchestratorError(f"{path}: no column of numbers beside the time; say --delimiter or --header")
    return Columns(time, channels, start, told)


def _refuse_signals_in_rows(
    path: Path, labels: list[str], kinds: Sequence[str], cells: list[list[str]], time: Sequence[Any] | None, taken: set[int]
) -> None:
    """A table with a row for each value of each signal would become one column of all of them."""
    times = time or next((cells[j] for j, label in enumerate(labels) if is_time_name(label) and kinds[j] == "number"), [])
    for j, label in enumerate(labels):
        found = list(dict.fromkeys(cells[j]))
        named = label.lower() in SIGNALS and any(other.lower() in VALUES for other in labels) or kinds[j] == "text" and all(map(_is_unit, found))
        # Several rows of one time, each with another text.
        several = kinds[j] == "text" and 0 < 2 * len(set(times)) <= len(times) == len(set(zip(times, cells[j], strict=True)))
        if j not in taken and 1 < len(found) <= len(cells[j]) / 2 and (named or several):
            shown = "`, `".join(found[:3])
            raise OrchestratorError(f"{path}: column `{label}` says in each row whose value it is (`{shown}`); save a column for each, or a file for each")


def _time(
    path: Path, labels: list[str], names: list[str], kinds: Sequence[str], cells: list[list[str]],
    numbers: Mapping[int, Callable[[str], float | None]], options: Options, told: list[str], taken: set[int],
) -> tuple[list[float | None] | None, datetime.datetime | None]:
    """Seconds since the first stamp, and that, where there are stamps."""
    if options.time == "none":
        return None, None
    if options.time and options.time not in [*labels, *names]:
        raise OrchestratorError(f"{path}: --time {options.time}: there is no such column; it has {', '.join(labels)}")
    wanted = None if options.time is None else labels.index(options.time) if options.time in labels else names.index(options.time)
    stamps = [j for j, kind in enumerate(kinds) if kind == "stamp" or (options.format and wanted == j)]
    if options.format and not stamps:
        stamps = [j for j in range(len(kinds)) if any(_moment(cell, options.format) for cell in cells[j][:20])]
    moments = {j: [_moment(cell.strip(), options.format) if cell else None for cell in cells[j]] for j in stamps}
    heads = {j: next((moment for moment in moments[j] if moment), None) for j in stamps}
    days = [j for j, head in heads.items() if head and head.days and head.seconds is None]
    clocks = [j for j, head in heads.items() if head and head.days is None]
    whole = [j for j, head in heads.items() if head and head.days and head.seconds is not None]
    if wanted is not None:
        if wanted not in stamps:
            return None, None
        days, clocks, whole = ([j for j in group if j == wanted or (group is not whole and wanted in days + clocks)] for group in (days, clocks, whole))
    if not stamps:
        row = _calendar(path, labels, kinds, cells, numbers, taken)
        if row and "hour" not in _places(labels, kinds) and len(set(row)) < len(row):
            raise OrchestratorError(f"{path}: its columns of year, month and day have several rows of one day and no hour; say --time none, or --time NAME of another column")
        return (None, None) if row is None else _seconds(row, ", ".join(f"`{labels[j]}`" for j in sorted(taken)), told)
    if len(whole) == 1 and not (days and clocks):
        chosen = whole
    elif not whole and len(days) == 1 and len(clocks) == 1:
        chosen = [days[0], clocks[0]]
    elif not whole and len(clocks) + len(days) == 1:
        chosen = clocks or days
    else:
        several = " or ".join(f"`{labels[j]}`" for j in stamps)
        raise OrchestratorError(f"{path}: the time may be {several}; say --time NAME")
    taken.update(chosen)
    name = " and ".join(f"`{labels[j]}`" for j in chosen)
    joined = [_join([moments[j][k] for j in chosen]) for k in range(len(cells[0]))]
    head = next(moment for moment in joined if moment)
    if head.is_short and len(chosen) == 1:
        raise OrchestratorError(f"{path}: times such as `{cells[chosen[0]][0]}` may be hours and minutes or minutes and seconds; say --format \"%H:%M\" or \"%M:%S\"")
    def differs(moment: Moment | None) -> bool:
        return moment is None or (moment.days is None) != (head.days is None)

    bad = next((k for k, moment in enumerate(joined) if differs(moment) and any(cells[j][k] for j in chosen)), None)
    if bad is not None:
        raise OrchestratorError(f"{path}: `{' '.join(cells[j][bad] for j in chosen)}` of the time {name} (row {bad + 1}) is no time like the others; say --format, or correct the row")
    if head.days is None:
        return _of_day(joined, name, told), None
    readings: dict[str, list[int | None]] = {}
    for order in ("", *FORMS):
        if all(moment is None or moment.days and order in moment.days for moment in joined):
            readings[order] = [_at(moment, order) if moment else None for moment in joined]
    if not readings:
        raise OrchestratorError(f"{path}: the dates of {name} are none; say --format")
    sample = next(filter(None, cells[chosen[0]]))
    if len(readings) > 1:
        differences = [[at and at - min(filter(None, row)) for at in row] for row in readings.values()]
        rising = [order for order, row in readings.items() if _rises(row)]
        possible = " or the ".join(order.removesuffix(" first") for order in readings)
        if all(one == differences[0] for one in differences):
            told.append(f"`{sample}` may have the {possible} first: the same seconds either way, so time 0 is known but for its date")
        elif len(rising) == 1:
            readings = {rising[0]: readings[rising[0]]}
        else:
            mark, year = next(letter for letter in sample if not letter.isdigit()), "%Y" if re.search(r"\d{4}", sample) else "%y"
            rest = _form(sample)
            forms = " or ".join(f'"{FORMS[order].format(mark, year)}{rest}"' for order in readings)
            raise OrchestratorError(f"{path}: dates such as `{sample}` may have the {possible} first; say --format {forms}")
    order, row = next(iter(readings.items()))
    again = sum(before == after is not None for before, after in pairwise(row))
    if again and all(moment is None or moment.seconds is None for moment in joined):
        raise OrchestratorError(
            f"{path}: {name} holds days, and {again} rows have the day of the row before; write the clock beside it in one column, or say --time none, or "
            "--time NAME of another column")
    seconds, start = _seconds(row, name + (f" ({order})" if order and len(readings) == 1 else ""), told)
    return seconds, start.replace(tzinfo=datetime.UTC) if head.has_zone else start


def _form(stamp: str) -> str:
    """The form of what stands behind the day."""
    def clock(found: re.Match[str]) -> str:
        return f"{'%I' if half else '%H'}:%M{':%S' if found[1] else ''}{f'{found[2]}%f' if found[2] else ''}"

    found = DAY.match(stamp)
    rest, half = re.subn(r"[AaPp][Mm]$", "%p", re.sub(r"(Z|[+-]\d\d:?\d\d)$", "%z", stamp[found.end():] if found else ""))
    return re.sub(r"\d+:\d\d(:\d\d)?(?:([.,:])\d+)?", clock, rest)


def _rises(row: Sequence[Any]) -> bool:
    there = [value for value in row if value is not None]
    return all(after >= before for before, after in pairwise(there))


def _join(parts: list[Moment | None]) -> Moment | None:
    """A moment in one column, or its day and its time in two."""
    day, clock = parts[0], parts[-1]
    return day and clock and Moment(day.days, clock.seconds, day.is_short, clock.has_zone)


def _at(moment: Moment, order: str) -> int:
    """Nanoseconds since the day 0: loggers write more figures than a ``datetime`` has."""
    assert moment.days
    return moment.days[order].toordinal() * DAY_NS + round((moment.seconds or 0.0) * 1e9)


def _of_day(moments: Sequence[Moment | None], name: str, told: list[str]) -> list[float | None]:
    """Times of day; after midnight they begin anew."""
    there = [moment.seconds for moment in moments if moment and moment.seconds is not None]
    days, last, seconds = 0, there[0], []
    for moment in moments:
        value = moment.seconds if moment else None
        if value is not None:
            days, last = days + (value < last - 43200), value
        seconds.append(None if value is None else round(value + 86400 * days - there[0], 9))
    _tell_time(seconds, name + (f", over midnight {days} times" if days else ""), told)
    return seconds


def _tell_time(seconds: Sequence[float | None], name: str, told: list[str]) -> None:
    there = [value for value in seconds if value is not None]
    falls = sum(after < before for before, after in pairwise(there))
    told.append(f"time: {name}, {min(there):.12g} .. {max(there):.12g} s" + (f"; it falls {falls} times (a clock that was set back?)" if falls else ""))


def _seconds(row: Sequence[int | None], name: str, told: list[str]) -> tuple[list[float | None], datetime.datetime]:
    zero = next(at for at in row if at is not None)
    seconds = [None if at is None else (at - zero) / 1e9 for at in row]
    _tell_time(seconds, name, told)
    return seconds, datetime.datetime.fromordinal(zero // DAY_NS) + datetime.timedelta(microseconds=zero % DAY_NS // 1000)


def _places(labels: list[str], kinds: Sequence[str]) -> dict[str, int]:
    """The columns that are called as parts of a calendar."""
    places = {}
    for part, words in PARTS.items():
        # Beside a month `MM`, `mm` is a minute.
        found = [j for j, label in enumerate(labels) if ("mi" if label == "mm" and "MM" in labels else label.lower()) in words.split() and kinds[j] == "number"]
        if len(found) == 1:
            places[part] = found[0]
    return places


def _of_figures(
    path: Path, labels: list[str], said: list[str], kinds: list[str], cells: list[list[str]],
    numbers: Mapping[int, Callable[[str], float | None]], options: Options, taken: set[int],
) -> Options:
    """Makes stamps of days and clocks that are figures alone, such as 20240131 and 93015; gives the options that are left to obey."""
    form = FORM_OF_FIGURES.fullmatch(options.format or "")
    if options.time == "none" or form and form[1] and form[2] and " " not in form[0]:
        return options
    there = [[cell for cell in column if cell.lower() not in NOTHING] for column in cells]
    heads = [_moment(column[0], None if form else options.format) if kind == "stamp" and column else None for kind, column in zip(kinds, there, strict=True)]
    plain = [j for j, kind in enumerate(kinds) if kind == "number" and there[j] and said[j].lower() in ("", "hhmm", "hhmmss")]

    def fitting(j: int, forms: Sequence[str]) -> list[str]:
        return [form for form in forms if all(_figures(cell, form) for cell in there[j])]

    days = {j: found for j in plain if CALLED_DAY.search(labels[j]) and (found := fitting(j, [form[1]] if form and form[1] else DAYS))}
    clocks = {j: found for j in plain if j not in days and CALLED_CLOCK.search(labels[j]) and (found := fitting(j, [form[2]] if form and form[2] else CLOCKS))}
    timed = any(kinds[j] == "number" and j not in clocks and (said[j] in OF_TIME or not said[j] and is_time_name(labels[j]))
                and _rises([numbers[j](cell) for cell in there[j]]) for j in range(len(labels)))
    parts = _places(labels, kinds)
    has_parts = {"year", "month", "day"} <= parts.keys() and "hour" not in parts
    known_days = [head for head in heads if head and head.days]
    if timed or len(days) > 1 or any(head.seconds is not None for head in known_days):
        return options
    clocks = {j: found for j, found in clocks.items() if options.time not in labels or options.time == labels[j] or labels.index(options.time) in days} if options.time else clocks
    if len(clocks) + sum(head is not None and not head.days for head in heads) > 1:
        several = "` or `".join(labels[j] for j, head in enumerate(heads) if j in clocks or head and not head.days)
        raise OrchestratorError(f"{path}: the clock may be `{several}`; say --time NAME")

    def become(j: int, form: str) -> None:
        cells[j], kinds[j] = [_figures(cell, form) or cell for cell in cells[j]], "stamp"

    for j, found in days.items():
        rising = [form for form in found if _rises([_figures(cell, form) for cell in there[j]])]
        days[j] = found = rising if len(rising) == 1 else found
        if len(found) > 1:
            raise OrchestratorError(f"{path}: dates such as `{there[j][0]}` in column `{labels[j]}` have several readings; say --format \"" + '" or "'.join(found) + '"')
    for j, found in clocks.items():
        has_day = bool(days or known_days or has_parts)
        # What all rows have of leading zeros, or the name, tells how much there is.
        is_padded = len({len(cell) for cell in there[j]}) == 1 and any(cell[0] == "0" for cell in there[j])
        named = re.sub("[^hms]", "", (said[j] or labels[j]).lower())
        told = [one for one in found if one == (form and form[2]) or named.endswith("hhmmss"[: len(one)]) or is_padded and len(there[j][0]) == len(one)]
        values = [numbers[j](cell) or 0.0 for cell in there[j]]
        # Numbers of seconds would seldom all be clocks that pass a minute: late in the day, for long, or in steps that are regular only so.
        is_like = len({value // 100 for value in values}) > 1 and (
            min(values) >= 10_000 or max(values) >= 10_000 and (len(values) > 9 or not _rises(values)) or _is_regular(values))
        if not told and (len(found) > 1 if has_day else is_like):
            before = next((f"{day[0]} " for day in days.values()), "")
            forms = '" or "'.join(before + one for one in found)
            raise OrchestratorError(
                f"{path}: column `{labels[j]}`: `{there[j][0]}` may be a clock, or a number of seconds; say --format \"{forms}\", or --unit \"{labels[j]}=s\"")
        if told or has_day:
            become(j, (told or found)[0])
            heads[j] = _moment(_figures(there[j][0], found[0]) or "", None)
    for j, found in days.items():
        become(j, found[0])
    if has_parts and any(head and not head.days for head in heads):
        dates = [[numbers[parts[part]](cell) for cell in cells[parts[part]]] for part in ("year", "month", "day")]
        cells[parts["day"]] = ["-".join(f"{value:02.0f}" for value in row) if None not in row else "" for row in zip(*dates, strict=True)]
        kinds[parts["day"]] = "stamp"
        taken.update((parts["year"], parts["month"]))
    return dataclasses.replace(options, format=None if form and (days or clocks) else options.format)


def _width(form: str) -> int:
    return sum({"Y": 4, "j": 3}.get(letter, 2) for letter in form[1::2])


def _figures(cell: str, form: str) -> str | None:
    """A day or a clock that is written in figures alone, of which leading zeros may be missing, as a stamp."""
    head, *part = re.split("[.,]", cell)
    width = _width(form)
    if not head.isdecimal() or len(head) > width or len(part) > (form == "%H%M%S"):
        return None
    if form in CLOCKS:
        hours, minutes, seconds = (int(head.zfill(width).ljust(6, "0")[k : k + 2]) for k in (0, 2, 4))
        return f"{hours}:{minutes:02}:{seconds:02}" + "".join(f".{figures}" for figures in part if figures) if hours <= 24 and minutes < 60 and seconds < 60 else None
    with contextlib.suppress(ValueError):
        at = datetime.datetime.strptime(head.zfill(width), form)
        if len(head) >= width - 1 and 1900 <= at.year < 2100:
            return at.isoformat(" ") if "%H" in form else at.date().isoformat()
    return None


def _is_regular(values: Sequence[float]) -> bool:
    """Whether clocks of figures have one step where seconds would have several."""
    clocks = [value // 10_000 * 3600 + value // 100 % 100 * 60 + value % 100 for value in values]
    steps = [{round(after - before, 6) for before, after in pairwise(row)} for row in (values, clocks)]
    return len(values) > 4 and len(steps[0]) > 1 == len(steps[1])


def _calendar(
    path: Path, labels: list[str], kinds: Sequence[str], cells: list[list[str]], numbers: Mapping[int, Callable[[str], float | None]], taken: set[int]
) -> list[int | None] | None:
    """Year, month, day, hour and minute in columns."""
    places = _places(labels, kinds)
    if not {"year", "month", "day"} <= places.keys():
        return None

    def refuse(part: str, why: str) -> NoReturn:
        raise OrchestratorError(
            f"{path}: column `{labels[places[part]]}` is called as the {part} of the time and {why}; rename it where it is something else, or say --time none")

    for above, part in pairwise(["day", "hour", "minute", "second"]):
        if part in places and above not in places:
            refuse(part, f"no column is the {above}")
    if "minute" in places and labels[places["minute"]].lower() == "min" and any(label.lower() in ("max", "mean", "avg") for label in labels):
        refuse("minute", "stands beside a largest or a mean value")
    row: list[int | None] = []
    for k in range(len(cells[0])):
        values = {part: numbers[j](cells[j][k]) for part, j in places.items()}
        if any(value is None for value in values.values()):
            row.append(None)
            continue
        for part, most in MOST.items():
            value = values.get(part) or 0.0
            if not 0 <= value <= most or value % 1 and part != "second":
                refuse(part, f"holds {value:g}")
        try:
            day = datetime.date(*(int(values[part] or 0) for part in ("year", "month", "day")))
        except ValueError:
            refuse("day", f"holds {values['day']:g} in month {values['month']:g} of year {values['year']:g}")
        if day.year < 100:
            return None
        # Weather data count the hours from 1 to 24 and write the end of each.
        seconds = sum(of * (values.get(part) or 0) for part, of in (("hour", 3600), ("minute", 60), ("second", 1)))
        row.append(_at(Moment({"": day}, seconds), ""))
    taken.update(places.values())
    return row


def _labview(path: Path, lines: Sequence[str], options: Options) -> Columns:
    """LabVIEW's measurement files say how they are written."""
    marks = [k for k, line in enumerate(lines) if line.startswith("***End_of_Header***")]
    if len(marks) != 2:
        why = "LabVIEW's header has no end; export it as csv" if len(marks) < 2 else f"{len(marks) - 1} segments, each a recording of its own; save them as files of their own"
        raise OrchestratorError(f"{path}: {why}")
    known = {parts[0]: parts[1] for line in lines[: marks[0]] if len(parts := line.split("\t" if "\t" in line else ",")) > 1}
    delimiter = "," if known.get("Separator") == "Comma" else "\t"
    decimal, way = known.get("Decimal_Separator", "."), known.get("X_Columns", "One")
    about = {row[0]: row[1:] for row in _split(path, lines[marks[0] + 1 : marks[1]], delimiter) if row}
    names, *body = _split(path, lines[marks[1] + 1 :], delimiter)
    count, units = len([name for name in about.get("Samples", names) if name]), about.get("Y_Unit_Label", [])
    places = [2 * c + 1 if way == "Multi" else c + 1 for c in range(count)]
    for c, place in enumerate(places):
        if way == "Multi":
            names[place - 1] = f"{names[place - 1]} {c + 1} [s]"
        if c < len(units) and units[c] and place < len(names):
            names[place] += f" [{units[c]}]"
    last = places[-1] + 1
    body = [row[:last] + [""] * (last - len(row)) for row in body if any(row[:last])]
    columns = table(path, [names[:last], *body], dataclasses.replace(options, header=1, decimal=decimal))
    if way == "One":
        columns.time = list(columns.channels.pop(0)[2])
    elif way == "No":
        begins, steps = ({cell.replace(decimal, ".") for cell in about.get(key, [])[:count]} for key in ("X0", "Delta_X"))
        if len(begins) != 1 or len(steps) != 1 or "" in begins | steps:
            raise OrchestratorError(f"{path}: its channels have clocks of their own (X0, Delta_X); save it with X columns")
        columns.time = [round(float(*begins) + k * float(*steps), 12) for k in range(len(body))]
    if columns.time:
        columns.told.append(f"time: by LabVIEW's header, {columns.time[0]} .. {columns.time[-1]} s")
    return columns


def _seabird(path: Path, lines: Sequence[str], options: Options) -> Columns:
    """Sea-Bird's files name their columns above `*END*`; without blanks between them, each has eleven letters."""
    end = next((k for k, line in enumerate(lines) if line.startswith("*END*")), len(lines))
    known = dict(pair for line in lines[:end] if len(pair := line.removeprefix("# ").rstrip().split(" = ", 1)) == 2)
    if known.get("file_type") == "binary":
        raise OrchestratorError(f"{path}: its values are binary; save it as ASCII, as SBE Data Processing does")
    names, units = [], []
    for name in (known[f"name {k}"] for k in range(len(known)) if f"name {k}" in known):
        found = re.search(r"\[(?:.*, )?([^]]+)\]", name)
        names.append(name.partition(":")[0])
        units.append(f"[{found[1]}]" if found else "")
    rows = [line.split() for line in lines[end + 1 :]]
    wide = [[line[k : k + 11].strip() for k in range(0, 11 * len(names), 11)] if len(line.rstrip()) == 11 * len(names) else [] for line in lines[end + 1 :]]
    rows = [cut if len(row) != len(names) == len(cut) else row for row, cut in zip(rows, wide, strict=True)]
    bad, gaps = known.get("bad_flag"), 0
    for row in rows:
        for j, cell in enumerate(row):
            if bad and cell == bad:
                row[j], gaps = "", gaps + 1
    columns = table(path, [names, units, *rows], dataclasses.replace(options, header=1), ".")
    if gaps:
        columns.told.append(f"{gaps} cells are `{bad}`, the header's mark of bad values, and became empty")
    if columns.time is None and (interval := known.get("interval", "")).startswith("seconds"):
        columns.told.append(f"the header says that rows are {interval.partition(':')[2].strip()} s apart")
    return columns

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
from collections.abc import Callable, Iterable, Mapping, Sequence
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
# Numbers with the other mark between thousands, by their decimal mark.
THOUSANDS = {mark: re.compile(rf"[+-]?[1-9]\d{{0,2}}(\{other}\d{{3}})+(\{mark}\d*)?([eEdD][+-]?\d+)?") for mark, other in OTHER.items()}
# One to three digits, then groups of three: thousands, or a number with three decimals.
GROUPED = re.compile(r"[+-]?[1-9]\d{0,2}([.,]\d{3})+")
BLANKS = re.compile(r"[+-]?[1-9]\d{0,2}(['\u2019\u00a0\u202f\u2009 ])\d{3}(?:\1\d{3})*(?!\d)")
DAY = re.compile(r"(?:[A-Za-z]{2,3}[.,]* )?(\d{1,4})([-./ ]) ?(\d{1,2}|[^\W\d_]{3,9}(?=[-. ]))(?:(?<=\D)\.)?([-./ ]) ?(\d{1,4})(?!\d)")
MONTH_FIRST = re.compile(r"(?:[A-Za-z]{2,3}[.,]* )?([^\W\d_]{3,9})\.? (\d{1,2}),? (\d{4})(?!\d)")
LIKE_STAMP = re.compile(r"\d{1,4}\D+\d{1,4}\D+\d")
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
PART_OF_SECOND = re.compile(r"(?i)(ms(?:ec)?|millise[ck]\w*)|[uµ]s|microse[ck]\w*")
FORM_OF_FIGURES = re.compile(r"((?:%[Yymdj])+)? ?(%H%M(?:%S)?)?")
FORMS = {"day first": "%d{0}%m{0}{1}", "month first": "%m{0}%d{0}{1}", "year first": "{1}{0}%m{0}%d"}
TIMES = {"t", "ts", "time", "zeit", "timestamp", "timestamps", "tout"}
# Names of columns in a table that has a row for each value of each signal.
SIGNALS = set("signal name channel variable parameter sensor tag id pid item kanal quantity measurement varname tagname _field".split())
VALUES = set("value values val wert messwert reading varvalue _value".split())
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
class Table:
    """A table as it was understood."""

    time: list[float | None] | None
    channels: list[tuple[str, str, Sequence[Any]]]
    start: datetime.datetime | None = None
    told: list[str] = field(default_factory=list)


@dataclass(eq=False)
class Column:
    """A column of texts, and what they are."""

    name: str
    label: str  # the name without its unit
    unit: str
    kind: str  # number, stamp or text
    cells: list[str]
    decimal: str = "."
    is_taken: bool = False  # it belongs to the time

    def number(self, cell: str) -> float | None:
        plain, between = _plain(cell), OTHER[self.decimal]
        if not NUMBER.fullmatch(plain) or between in plain and not THOUSANDS[self.decimal].fullmatch(plain):
            return None
        value = float(plain.replace(between, "").replace(",", ".").lower().replace("d", "e"))
        return value if math.isfinite(value) else None

    def there(self) -> list[str]:
        return [cell for cell in self.cells if cell.lower() not in NOTHING]


def refuse(message: str) -> NoReturn:
    """Whoever knows the file puts its name before."""
    raise OrchestratorError(message)


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


def _find(columns: Sequence[Column], name: str | None) -> Column | None:
    """A column by its name without its unit, or with it."""
    return next((column for way in ("label", "name") for column in columns if getattr(column, way) == name), None)


def _listed(columns: Iterable[Column]) -> str:
    return ", ".join(column.label for column in columns)


def _quoted(columns: Iterable[Column], between: str) -> str:
    return between.join(f"`{column.label}`" for column in columns)


def text(path: Path, encoding: str | None) -> tuple[str, str]:
    """The text of a file and its encoding."""
    content = path.read_bytes()
    known = encoding or ("utf-16" if content.startswith((b"\xff\xfe", b"\xfe\xff")) else None)
    if known is None and content[1:8:2] == bytes(len(content[1:8:2])) and len(content) > 8 and 0 not in content[:8:2]:
        known = "utf-16-le"
    for name in [known] if known else ["utf-8", "cp1252"]:
        with contextlib.suppress(UnicodeDecodeError, LookupError):
            decoded = content.decode(name)
            if "\0" in decoded[:100_000]:
                break
            # Some loggers begin each line with the mark of the encoding.
            return decoded.replace("\ufeff", ""), name
    refuse(f"no text in {known or 'UTF-8 or Windows-1252'}; say --encoding, or export it as csv")


def read(path: Path, options: Options) -> Table:
    """A file of text."""
    content, encoding = text(path, options.encoding)
    lines = content.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    if lines[0].startswith("LabVIEW Measurement"):
        return _labview(lines, options)
    if lines[0].startswith("* Sea-Bird") and any(line.startswith("# name 0 = ") for line in lines):
        return _seabird(lines, options)
    delimiter = SEPARATORS.get(options.delimiter or "", options.delimiter)
    if lines[0].lower().startswith("sep=") and len(lines[0].strip()) == 5:
        delimiter, lines[0] = delimiter or lines[0][4], ""
    delimiter = delimiter or _separator(lines)
    rows = _split(lines, delimiter)
    shown = next((name for name, letter in SEPARATORS.items() if letter == delimiter), delimiter)
    point = delimiter == "," and not any("," in cell and _is_number(cell) for row in rows for cell in row)
    columns = table(rows, options, "." if point else None, delimiter == " ")
    columns.told[:0] = [*([] if encoding.startswith("utf-8") else [f"encoding: {encoding}"]), f"between cells: {shown}"]
    return columns


def _split(lines: Sequence[str], delimiter: str) -> list[list[str]]:
    """The cells of all lines; a blank line has none."""
    if delimiter == " ":
        return [_words(line) for line in lines]
    try:
        # A quote that nobody closes would swallow the rest: each line is read alone.
        return [[cell.strip().removeprefix("'") for cell in next(csv.reader([line], delimiter=delimiter), [])] if line.strip() else [] for line in lines]
    except (csv.Error, TypeError) as error:
        refuse(f"{error}; say --delimiter")


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
    return cell.isdigit() or NUMBER.fullmatch(_plain(cell)) is not None


def _plain(cell: str) -> str:
    cell = cell.strip().replace("\u2212", "-")
    if cell[:1] in "+-":
        cell = cell[:1] + cell[1:].lstrip()
    found = None if cell.isascii() and "'" not in cell and " " not in cell else BLANKS.match(cell)
    return found[0].replace(found[1], "") + cell[found.end():] if found else cell


def _is_stamp(cell: str) -> bool:
    cell = cell.strip()
    return cell[:1].isalnum() and _moment(cell) is not None


def _is_value(cell: str) -> bool:
    return _is_number(cell) or _is_stamp(cell)


def _suffix(cell: str) -> str:
    """The unit behind a number."""
    if not cell or cell.isdecimal():
        return ""
    # A minus behind a number is its sign in some files, and no unit; a unit that begins with a figure stands behind a blank.
    found = re.fullmatch(NUMBER.pattern + r"\s*([^\d\s.,;-].*|(?<=\s)1/.*)", _plain(cell))
    # A letter right behind a figure may be a factor: 800m are 0.8.
    return found[found.re.groups] if found and _is_unit(found[found.re.groups]) and not re.search(r"[\d.,]m$", cell) else ""


def _separator(lines: Sequence[str]) -> str:
    """The one with which most lines have the same number of cells and these are values."""
    sample = [line for line in lines if line.strip()]
    # What remarks have between their words says nothing of the rows.
    sample = ([line for line in sample if line[0] not in "#*"] or sample)[:SAMPLE]
    best: list[tuple[float, str, float]] = []
    for letter in SEPARATORS.values():
        rows = [row for row in _split(sample, letter) if len(row) > 1 and any(_is_value(cell) or _suffix(cell) for cell in row)]
        for width, count in Counter(map(len, rows)).most_common(1):
            cells = [cell for row in rows if len(row) == width for cell in row if cell]
            sound = sum(_is_value(cell) or bool(_suffix(cell)) for cell in cells) / max(len(cells), 1)
            best.append((count / len(sample) * (0.5 + sound), letter, sound))
    # Blanks stand within cells, too: they separate where nothing else does, and beside decimal commas, between which is no number.
    others = [one for one in best if one[1] != " "]
    best = others if others and (best[-1][2] <= 0.7 or any(one[2] > 0.5 for one in others)) else best
    return max(best, key=lambda one: one[0])[1] if best else ","


def table(rows: list[list[str]], options: Options, decimal: str | None = None, exact: bool = False) -> Table:
    """The columns of a table of texts; with ``exact``, an empty cell is none."""
    told: list[str] = []
    while rows and not any(rows[-1]):
        rows.pop()
    filled = {k: max(j for j, cell in enumerate(row) if cell) + 1 for k, row in enumerate(rows) if any(row)}
    body = [k for k in filled if k >= (options.header or 0) and any(map(_is_value, rows[k]))]
    if len(body) < 2:
        refuse("fewer than two rows of numbers; say --delimiter or --header, or export it as csv")
    # Rows of the recording have one width, or lack empty cells at their ends.
    width, most = Counter(len(rows[k]) for k in body).most_common(1)[0][0], max(filled[k] for k in body)
    # Names that are stated are those of the longest rows, too.
    if options.header and filled.get(options.header - 1) == most and any(filled[k] == most and all(map(_is_value, rows[k][:width])) for k in body):
        width = most
    like = [rows[k] for k in body if len(rows[k]) == width or options.header]
    kinds, marks = zip(*(_kind([row[j] for row in like if j < len(row)]) for j in range(width)), strict=True)
    typed = [j for j, kind in enumerate(kinds) if kind != "text"]
    if not typed:
        refuse("no column of numbers; say --delimiter")

    def known(row: list[str]) -> tuple[int, int]:
        """How many cells of a row are what their columns are, and how many there are."""
        there = [(kinds[j], row[j]) for j in typed if j < len(row) and row[j].lower() not in NOTHING and row[j] != marks[j]]
        return sum(_is_number(cell) or bool(_suffix(cell)) if kind == "number" else _is_value(cell) for kind, cell in there), len(there)

    counts = {k: known(rows[k]) for k in body}
    good = [k for k in body if (len(rows[k]) == width if exact else filled[k] <= width) and counts[k][0] > 0 and 2 * counts[k][0] >= counts[k][1]]
    # The recording begins with a row that has no doubt, and with rows with marks right above it.
    first = next((k for k in good if counts[k][0] == counts[k][1]), None)
    if first is None:
        refuse("no rows of numbers of one width; say --delimiter or --header")
    while first - 1 in good:
        first -= 1
    sure, end = {k for k in good if k >= first}, good[-1]
    heads = {split_name(cell)[0] for row in rows[:first] for cell in row}

    def is_head(row: list[str]) -> bool:
        return all(split_name(cell)[0] in heads or _is_unit(cell) for cell in row if cell)

    # A row of marks alone is one, too, and among the others one of cells that are no numbers: the times of a constant rate would shift.
    good = [k for k in range(first, len(rows)) if k in sure or any(rows[k]) and len(rows[k]) == width and (
        all(cell.lower() in NOTHING for cell in rows[k]) or (k < end or width > 1) and all(rows[k][j] for j in typed) and not is_head(rows[k]))]
    if long := next((k + 1 for k in body if filled[k] > width and (k > first or 1 < counts[k][0] == counts[k][1])), 0):
        refuse(f"line {long} has {filled[long - 1]} cells and most rows have {width}; a decimal comma needs another letter between cells: say --delimiter, "
               "or correct the line")
    names, units, header = _header(rows, first, width, options)
    over = [k for k in body if k < header - 1 or header <= k < first and 2 * counts[k][0] > counts[k][1]]
    for k, after in pairwise(over):
        if k + 1 == after < header and len(rows[k]) == len(rows[after]) > 2 and min(sum(map(_is_value, rows[line])) for line in (k, after)) > 1:
            refuse(f"line {k + 1} (`{' '.join(rows[k])[:40]}`) belongs to another table, which stands above that of line {header}; save it as a file of "
                   f"its own, and say --header {header} for the other")
    if over:
        told.append(f"{len(over)} lines with numbers above the recording were left out, line {over[0] + 1} first: `{' '.join(rows[over[0]])[:60]}`")
    named = max((j + 1 for j, name in enumerate(names) if name), default=0)
    if named > width and not options.header:
        refuse(f"{named} names on line {header} and {width} cells in most rows; say --delimiter, or --header {header} where the last names have no cells")
    if named > width:
        told.append(f"no cells below `{'`, `'.join(filter(None, names[width:]))}`")
    if not header and options.header is None:
        # Codes and channel numbers may stand where names do: as values they would be a row that nobody measured.
        refuse(f"line {first + 1} (`{' '.join(rows[first])[:40]}`) is all numbers, and no names stand above: they may be values or names; say --header 0 where "
               f"they are values, or --header {first + 1}")
    if not header:
        told.append("no row of names: the columns are numbered")
    most = max(filled[k] for k in good)
    if header and len(names) < most:
        refuse(f"{len(names)} names on line {header} and {most} cells below; a decimal comma needs another letter between cells: say --delimiter or --header, "
               "or correct the names")
    after = len(rows)
    if len(rows[-1]) < width and after - 1 == good[-1] and len(good) > 2 and len(rows[good[-2]]) == width:
        after = good.pop()
        told.append(f"line {after + 1}, the last one, is cut off and was left out")
    others = [k for k in sorted({*range(first, after)}.difference(good)) if any(rows[k])]
    if others:
        again = next((k for k in others if rows[k] not in rows[:first] and (width == 1 or sum(map(bool, rows[k])) > 1) and is_head(rows[k])), None)
        if again is not None:
            refuse(f"another table begins on line {again + 1} (`{' '.join(rows[again])[:60]}`); save each as a file of its own")
        shown = " ".join(rows[others[0]])[:60]
        if len(others) > len(good):
            refuse(f"{len(others)} lines below line {first + 1} (`{' '.join(rows[first])[:40]}`) are no rows like it, line {others[0] + 1} first: `{shown}`; "
                   "say --delimiter or --header")
        told.append(f"{len(others)} lines hold no row of the recording and were left out, line {others[0] + 1} first: `{shown}`")
    if blank := [k + 1 for k in range(good[0], good[-1]) if not any(rows[k])]:
        told.append(f"{len(blank)} blank lines between the values were left out, line {blank[0]} first: if values are missing there, write nan")
    if short := [k + 1 for k in good if len(rows[k]) < width]:
        told.append(f"{len(short)} rows have fewer than {width} cells, line {short[0]} first: their last columns are taken as empty; where other cells are missing, correct them")
    columns = []
    for j, kind in enumerate(kinds):
        name = names[j] if j < len(names) and names[j] else str(j + 1)
        label, own = split_name(name)
        stated = units[j] if j < len(units) and units[j] not in ("", "-") else own
        columns.append(Column(name, label, stated, kind, [rows[k][j] if j < len(rows[k]) else "" for k in good]))
    return _understood(columns, decimal, options, told)


def _kind(cells: Sequence[str]) -> tuple[str, str]:
    """What a column holds, and the only text among its numbers, which is a mark."""
    there = list(islice((cell for cell in cells if cell.lower() not in NOTHING), SAMPLE))
    if sum(map(_is_stamp, there)) > len(there) / 2:
        return "stamp", ""
    others = [cell for cell in there if not _is_number(cell)]
    numbers, with_unit = len(there) - len(others), sum(bool(_suffix(cell)) for cell in others)
    mark = others[0] if len(set(others)) == 1 < len(others) and numbers and not with_unit else ""
    return "number" if mark or max(numbers, with_unit) >= len(there) / 2 and numbers + with_unit else "text", mark


def _header(rows: list[list[str]], first: int, width: int, options: Options) -> tuple[list[str], list[str], int]:
    """Names and units above the first row, and the line of the names."""
    def cleaned(row: list[str]) -> list[str]:
        row = [row[0].lstrip("#%!~ "), *row[1:]]
        return [cell.strip("\"' ") for cell in (row[1:] if not row[0] and len(row) > width else row)]

    if rows[0][:1] == ["TOA5"] and first >= 4:
        # Campbell Scientific: a line about the station, names, units, how each was processed.
        return rows[1], [unit(cell) for cell in rows[2]], 2
    above = [k for k in range(options.header - 1, first) if any(rows[k])] if options.header else []
    for k in range(first - 1, -1, -1) if options.header is None else ():
        # A spreadsheet fills up a title with empty cells.
        if above and not any(rows[k][width > 2 :]) or any(rows[k]) and len(rows[k]) < max(width - 1, 2) and width > 1:
            break
        if any(rows[k]):
            above.insert(0, k)
    if not above:
        return [str(j + 1) for j in range(width)], [""] * width, 0
    heads = [cleaned(rows[k]) for k in above]
    # Units stand right below the names, with at most two rows of remarks behind them.
    below = [j for j in range(max(1, len(heads) - 3), len(heads)) if 2 * sum(map(_is_unit, filter(None, heads[j]))) > sum(map(bool, heads[j]))][-1:]
    if not (options.header or below or len(heads) == 1):
        lines = " or ".join(f"line {k + 1} (`{' '.join(rows[k])[:30]}`)" for k in above[-3:])
        refuse(f"the names may be {lines}; say --header LINE")
    place = 0 if options.header or not below else below[0] - 1
    return heads[place], [unit(cell) for cell in (heads[below[0]] if below else [])], above[place] + 1


def _decide_marks(columns: Sequence[Column], said: Mapping[str, str], told: list[str]) -> None:
    """Which of point and comma is the decimal mark of each column, which tells for itself: a point for decimals in one says nothing of
    another, in which it may stand between thousands."""
    groups: dict[str, list[Column]] = {}
    for column in columns:
        # The first cell in which a mark has a role.
        seen: dict[str, dict[str, str]] = {"decimal": {}, "thousands": {}, "unclear": {}}
        for cell in column.cells if column.kind == "number" else ():
            if not cell or cell.isdecimal() or not NUMBER.fullmatch(cell := _plain(cell).removesuffix(_suffix(cell)).rstrip()):
                continue
            marks = re.findall("[.,]", cell)
            if len(set(marks)) == 2:
                seen["decimal"].setdefault(marks[-1], cell)
            if marks:
                seen["thousands" if len(marks) > 1 else "unclear" if GROUPED.fullmatch(cell) else "decimal"].setdefault(marks[0], cell)
        decimals, thousands = seen["decimal"], seen["thousands"]
        doubtful = [(mark, seen["unclear"][mark]) for mark in ".," if mark in seen["unclear"] and mark not in thousands and mark not in decimals]
        if column.label in said:
            column.decimal = said[column.label]
        elif len(decimals) == 1 and not doubtful:
            [column.decimal] = decimals
        elif len(thousands) == 1 and not decimals:
            column.decimal = OTHER[next(iter(thousands))]
        elif "" in said or not any(seen.values()):
            column.decimal = said.get("", ".")
        elif doubtful:
            mark, cell = doubtful[0]
            beside = "".join(f" beside `{decimals[other]}`" for other in ".," if other in decimals)
            refuse(f"`{cell}` in column `{column.label}` may be {cell.replace(mark, '')} or {cell.replace(mark, '.')}{beside}; say --decimal \"{mark}\" where "
                   f"`{mark}` is the decimal mark, or --decimal \"{OTHER[mark]}\" where it stands between thousands; of this column alone, --decimal "
                   f"\"{column.label}={mark}\"")
        else:
            refuse(f"column `{column.label}`: `{decimals['.']}` has a decimal point and `{decimals[',']}` a decimal comma; say --decimal \"{column.label}=.\" or "
                   f"--decimal \"{column.label}=,\", and the cells of the other kind stay as they are, or correct one")
        decimal, other = column.decimal, OTHER[column.decimal]
        if decimal in thousands:
            refuse(f"column `{column.label}`: `{thousands[decimal]}` has several `{decimal}`, which is its decimal mark; correct one of its cells")
        if any(seen.values()):
            has_groups = other in thousands or other in seen["unclear"]
            groups.setdefault(f"decimal mark: {decimal}" + (f"; `{other}` stands between thousands" if has_groups else ""), []).append(column)
    for words, alike in groups.items():
        if words != "decimal mark: .":
            told.append(words + (f" in {_quoted(alike, ', ')}" if len(groups) > 1 else ""))


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


def _moment(cell: str, form: str | None = None) -> Moment | None:
    """What a cell says of the time."""
    if form:
        return _stated(cell, form)
    if found := COMPACT.fullmatch(cell):
        cell = f"{found[1]}-{found[2]}-{found[3]} {found[4]}:{found[5]}{f':{found[6]}' if found[6] else ''}{found[7] or ''}"
    if found := MONTH_FIRST.match(cell):
        cell = f"{found[2]} {found[1]} {found[3]}{cell[found.end():]}"
    days, rest = None, cell
    if not HOURS.fullmatch(cell) and (found := DAY.match(cell)):
        days, rest = _days(*found.groups()), cell[found.end():].lstrip(" T,")
        if not (days and rest):
            return Moment(days, None) if days else None
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


def _stated(cell: str, form: str) -> Moment | None:
    """The same by the form that the user states; that of a date leaves the clock in a column beside it as it is."""
    if cell.isdecimal() and FORM_OF_FIGURES.fullmatch(form):
        # Where leading zeros are missing, 10505 would be 10:50:05.
        cell = cell.zfill(_width(form.replace(" ", "")))
    is_day = not re.search("%[HIMSXc]", form)
    with contextlib.suppress(ValueError):
        at = datetime.datetime.strptime(cell, form)
        clock = at.replace(tzinfo=None) - datetime.datetime.combine(at.date(), datetime.time()) - (at.utcoffset() or datetime.timedelta())
        return Moment({"": at.date()} if re.search("%[djxc]", form) else None, None if is_day else clock.total_seconds(), False, at.tzinfo is not None)
    beside = _moment(cell) if is_day else None
    return beside if beside and beside.days is None else None


def _understood(columns: list[Column], decimal: str | None, options: Options, told: list[str]) -> Table:
    """Columns of texts as times and numbers."""
    for name, given in options.units.items():
        column = _find(columns, name) or refuse(f"--unit {name}: there is no such column; it has {_listed(columns)}")
        column.unit = given
    marks = {"": options.decimal} if isinstance(options.decimal, str) else dict(options.decimal or {})
    for name, mark in marks.items():
        if name and not any(column.label == name for column in columns) or mark not in OTHER:
            refuse(f"--decimal {name}{'=' * bool(name)}{mark}: say . or , or NAME=MARK; the columns are {_listed(columns)}")
    _decide_marks(columns, {**({"": decimal} if decimal else {}), **marks}, told)
    options = _of_figures(columns, options)
    time, start = _time(columns, options, told)
    _refuse_signals_in_rows(columns, time)
    is_timed = options.time or time or any(column.kind == "number" and (column.unit in OF_TIME or is_time_name(column.label)) for column in columns)
    channels: list[tuple[str, str, Sequence[Any]]] = []
    for column in (column for column in columns if not column.is_taken):
        if not any(column.cells):
            told.append(f"column `{column.label}` is empty and was left out")
        elif column.kind == "number":
            channels.append((column.label, *_channel(column, told)))
        else:
            sample = next((cell for cell in column.cells if cell and not _is_number(cell)), "")
            if not is_timed and (is_time_name(column.label) or sum(map(bool, map(LIKE_STAMP.match, column.cells))) > len(column.cells) / 2 < len(set(column.cells))):
                refuse(f"column `{column.label}` may be the time, but `{sample[:40]}` is no known stamp; say --format, or --time none")
            told.append(f"column `{column.label}` holds {'moments' if column.kind == 'stamp' else 'text'} (`{sample[:40]}`) and was left out")
    if not channels:
        refuse("no column of numbers beside the time; say --delimiter or --header")
    return Table(time, channels, start, told)


def _channel(column: Column, told: list[str]) -> tuple[str, list[Any]]:
    """The unit and the values of a column. What is no number stays for the reader to ask."""
    suffixes = {_suffix(cell) for cell in column.there()} - {""}
    # Where only some have one, the others may be of any unit.
    suffix = suffixes.pop() if len(suffixes) == 1 and (column.unit or not any(map(_is_number, column.cells))) else ""
    if suffix and column.unit not in ("", unit(suffix)):
        refuse(f"column `{column.label}` is in `{column.unit}` and its cells in `{unit(suffix)}`; say --unit \"{column.label}={unit(suffix)}\" or correct one")
    values: list[Any] = []
    for cell in column.cells:
        value = column.number(cell.removesuffix(suffix).strip())
        values.append(None if cell.lower() in NOTHING else cell if value is None else value)
    if marks := [cell for cell in column.cells if cell and cell.lower() in NOTHING]:
        told.append(f"column `{column.label}`: {len(marks)} cells such as `{marks[0]}` became empty")
    if texts := [value for value in values if isinstance(value, str)]:
        told.append(f"column `{column.label}`: {len(texts)} cells are no numbers, such as `{texts[0][:40]}`, and stay as they are")
    return unit(suffix) if suffix else column.unit, values


def _refuse_signals_in_rows(columns: Sequence[Column], time: Sequence[Any] | None) -> None:
    """A table with a row for each value of each signal would become one column of all of them."""
    times = time or next((column.cells for column in columns if is_time_name(column.label) and column.kind == "number"), [])
    for column in columns:
        found, is_text = list(dict.fromkeys(column.cells)), column.kind == "text"
        is_named = column.label == "entity_id" or column.label.lower() in SIGNALS and any(other.label.lower() in VALUES for other in columns)
        is_named = is_named or is_text and all(map(_is_unit, found))
        # Several rows of one time, each with another text.
        has_several = is_text and 0 < 2 * len(set(times)) <= len(times) == len(set(zip(times, column.cells, strict=True)))
        if not column.is_taken and 1 < len(found) <= len(column.cells) / 2 and (is_named or has_several):
            shown = "`, `".join(found[:3])
            refuse(f"column `{column.label}` says in each row whose value it is (`{shown}`); save a column for each, or a file for each")


def _time(columns: Sequence[Column], options: Options, told: list[str]) -> tuple[list[float | None] | None, datetime.datetime | None]:
    """Seconds since the first stamp, and that, where there are stamps."""
    if options.time == "none":
        return None, None
    wanted = _find(columns, options.time)
    if options.time and not wanted:
        refuse(f"--time {options.time}: there is no such column; it has {_listed(columns)}")
    stamps = [column for column in columns if column.kind == "stamp" or options.format and column is wanted]
    if options.format and not stamps:
        stamps = [column for column in columns if any(_moment(cell, options.format) for cell in column.cells[:20])]
    moments = {column: [_moment(cell.strip(), options.format) if cell else None for cell in column.cells] for column in stamps}
    heads = {column: next(filter(None, row), None) for column, row in moments.items()}
    days = [column for column, head in heads.items() if head and head.days and head.seconds is None]
    clocks = [column for column, head in heads.items() if head and head.days is None]
    whole = [column for column, head in heads.items() if head and head.days and head.seconds is not None]
    if wanted:
        if wanted not in stamps:
            return None, None
        whole, days, clocks = ([wanted] if wanted in group else group if group is not whole and wanted in days + clocks else [] for group in (whole, days, clocks))
    if not stamps:
        joined = _calendar(columns)
        chosen, between = [column for column in columns if column.is_taken], ", "
        if not joined:
            return None, None
    elif len(whole) == 1 and not (days and clocks) or not whole and max(len(days), len(clocks)) == 1:
        chosen, between = whole or days + clocks, " and "
        joined = [_join([moments[column][k] for column in chosen]) for k in range(len(columns[0].cells))]
    else:
        refuse(f"the time may be {_quoted(stamps, ' or ')}; say --time NAME")
    # Some loggers write the parts of a second into a column of their own.
    parts = [(column, 1000 if found[1] else 1_000_000) for column in columns if (found := PART_OF_SECOND.fullmatch(column.label))]
    parts = [(column, of) for column, of in parts if all(cell.isdecimal() and int(cell) < of for cell in column.cells)]
    if len(parts) == 1 and all(moment and moment.seconds is not None and moment.seconds % 1 == 0 for moment in joined):
        [(part, of)] = parts
        chosen = [*chosen, part]
        joined = [moment and dataclasses.replace(moment, seconds=(moment.seconds or 0.0) + int(cell) / of) for moment, cell in zip(joined, part.cells, strict=True)]
    for column in chosen:
        column.is_taken = True
    name, cells = _quoted(chosen, between), [" ".join(row) for row in zip(*(column.cells for column in chosen), strict=True)]
    head = next(filter(None, joined))
    if head.is_short and len(chosen) == 1:
        refuse(f"times such as `{cells[0]}` may be hours and minutes or minutes and seconds; say --format \"%H:%M\" or \"%M:%S\"")
    if stamps and (bad := next((k + 1 for k, moment in enumerate(joined) if cells[k].strip() and (moment is None or (moment.days is None) != (head.days is None))), 0)):
        refuse(f"`{cells[bad - 1]}` of the time {name} (row {bad}) is no time like the others; say --format, or correct the row")
    if head.days is None:
        return _of_day(joined, name, told), None
    order, row = _read_days(joined, name, next(filter(None, chosen[0].cells)), told)
    again = sum(before == after is not None for before, after in pairwise(row))
    if again and all(moment is None or moment.seconds is None for moment in joined):
        refuse(f"{name} holds days, and {again} rows have the day of the row before: several rows of one day want the clock beside it in one column; say --time none, "
               "or --time NAME of another column")
    zero = next(at for at in row if at is not None)
    seconds = [None if at is None else (at - zero) / 1e9 for at in row]
    _tell_time(seconds, name + (f" ({order})" if order else ""), told)
    start = datetime.datetime.fromordinal(zero // DAY_NS) + datetime.timedelta(microseconds=zero % DAY_NS // 1000)
    return seconds, start.replace(tzinfo=datetime.UTC) if head.has_zone else start


def _join(parts: list[Moment | None]) -> Moment | None:
    """A moment in one column, or its day and its time in two."""
    day, clock = parts[0], parts[-1]
    return day and clock and Moment(day.days, clock.seconds, day.is_short, clock.has_zone)


def _read_days(joined: Sequence[Moment | None], name: str, sample: str, told: list[str]) -> tuple[str, list[int | None]]:
    """The order of day and month that all rows allow, and nanoseconds since the day 0: loggers write more figures than a ``datetime``
    has."""
    def at(moment: Moment, order: str) -> int:
        return (moment.days or {})[order].toordinal() * DAY_NS + round((moment.seconds or 0.0) * 1e9)

    readings = {order: [at(moment, order) if moment else None for moment in joined]
                for order in ("", *FORMS) if all(moment is None or order in (moment.days or {}) for moment in joined)}
    if not readings:
        refuse(f"the dates of {name} are none; say --format")
    if len(readings) == 1:
        return next(iter(readings.items()))
    rising = [order for order, row in readings.items() if _rises(row)]
    differences = [[tick and tick - min(filter(None, row)) for tick in row] for row in readings.values()]
    possible = " or the ".join(order.removesuffix(" first") for order in readings)
    if all(one == differences[0] for one in differences):
        told.append(f"`{sample}` may have the {possible} first: the same seconds either way, so time 0 is known but for its date")
        return "", next(iter(readings.values()))
    if len(rising) == 1:
        return rising[0], readings[rising[0]]
    mark, year = next(letter for letter in sample if not letter.isdigit()), "%Y" if re.search(r"\d{4}", sample) else "%y"
    forms = " or ".join(f'"{FORMS[order].format(mark, year)}{_form(sample)}"' for order in readings)
    refuse(f"dates such as `{sample}` may have the {possible} first; say --format {forms}")


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


def _of_day(moments: Sequence[Moment | None], name: str, told: list[str]) -> list[float | None]:
    """Times of day; after midnight they begin anew."""
    values = [moment.seconds if moment else None for moment in moments]
    first = last = next(value for value in values if value is not None)
    days, seconds = 0, []
    for value in values:
        if value is not None:
            days, last = days + (value < last - 43200), value
        seconds.append(None if value is None else round(value + 86400 * days - first, 9))
    _tell_time(seconds, name + (f", over midnight {days} times" if days else ""), told)
    return seconds


def _tell_time(seconds: Sequence[float | None], name: str, told: list[str]) -> None:
    there = [value for value in seconds if value is not None]
    falls = sum(after < before for before, after in pairwise(there))
    told.append(f"time: {name}, {min(there):.12g} .. {max(there):.12g} s" + (f"; it falls {falls} times (a clock that was set back?)" if falls else ""))


def _places(columns: Sequence[Column]) -> dict[str, Column]:
    """The columns that are called as parts of a calendar."""
    has_months = any(column.label == "MM" for column in columns)
    places = {}
    for part, words in PARTS.items():
        # Beside a month `MM`, `mm` is a minute.
        found = [column for column in columns if column.kind == "number" and ("mi" if column.label == "mm" and has_months else column.label.lower()) in words.split()]
        if len(found) == 1:
            places[part] = found[0]
    return places


def _of_figures(columns: Sequence[Column], options: Options) -> Options:
    """Makes stamps of days and clocks that are figures alone, such as 20240131 and 93015; gives the options that are left to obey."""
    form = FORM_OF_FIGURES.fullmatch(options.format or "")
    if options.time == "none" or form and form[1] and form[2] and " " not in form[0]:
        return options
    heads = {column: _moment(there[0], None if form else options.format) for column in columns if column.kind == "stamp" and (there := column.there())}
    days: dict[Column, list[str]] = {}
    clocks: dict[Column, list[str]] = {}
    for column in columns:
        there = column.there()
        for called, kept, stated, usual in ((CALLED_DAY, days, form and form[1], DAYS), (CALLED_CLOCK, clocks, form and form[2], CLOCKS)):
            if column.kind == "number" and there and column.unit.lower() in ("", "hhmm", "hhmmss") and column not in days and called.search(column.label):
                fitting = [one for one in ([stated] if stated else usual) if all(_figures(cell, one) for cell in there)]
                kept.update({column: fitting} if fitting else {})
    is_timed = any(column.kind == "number" and column not in clocks and (column.unit in OF_TIME or not column.unit and is_time_name(column.label))
                   and _rises([column.number(cell) for cell in column.there()]) for column in columns)
    parts = _places(columns)
    has_parts = {"year", "month", "day"} <= parts.keys() and "hour" not in parts
    known_days = [head for head in heads.values() if head and head.days]
    if is_timed or len(days) > 1 or any(head.seconds is not None for head in known_days):
        return options
    if wanted := next((column for column in columns if column.label == options.time), None):
        clocks = {column: found for column, found in clocks.items() if column is wanted or wanted in days}
    several = [column for column in columns if column in clocks or (head := heads.get(column)) and not head.days]
    if len(several) > 1 and wanted not in several:
        refuse(f"the clock may be {_quoted(several, ' or ')}; say --time NAME")

    def become(column: Column, form: str) -> None:
        column.cells, column.kind = [_figures(cell, form) or cell for cell in column.cells], "stamp"

    for column, found in days.items():
        rising = [form for form in found if _rises([_figures(cell, form) for cell in column.there()])]
        days[column] = found = rising if len(rising) == 1 else found
        if len(found) > 1:
            forms = '" or "'.join(found)
            refuse(f"dates such as `{column.there()[0]}` in column `{column.label}` have several readings; say --format \"{forms}\"")
    for column, found in clocks.items():
        there, has_day = column.there(), bool(days or known_days or has_parts)
        # What all rows have of leading zeros, or the name, tells how much there is.
        is_padded = len({len(cell) for cell in there}) == 1 and any(cell[0] == "0" for cell in there)
        named = re.sub("[^hms]", "", (column.unit or column.label).lower())
        known = [one for one in found if one == (form and form[2]) or named.endswith("hhmmss"[: len(one)]) or is_padded and len(there[0]) == len(one)]
        # Two figures may be the hours alone, with parts or without.
        if not known and (len(found) > 1 or all(re.match(r"\d\d?(?!\d)", cell) for cell in there) if has_day else _are_clocks([column.number(cell) or 0.0 for cell in there])):
            forms = '" or "'.join(next((f"{form[0]} " for form in days.values()), "") + one for one in found)
            refuse(f"column `{column.label}`: `{there[0]}` may be a clock, or a number of seconds; say --format \"{forms}\", or --unit \"{column.label}=s\"")
        if known or has_day:
            become(column, (known or found)[0])
            heads[column] = _moment(column.there()[0])
    for column, found in days.items():
        become(column, found[0])
    if has_parts and any(head and not head.days for head in heads.values()):
        dates = zip(*([place.number(cell) for cell in place.cells] for place in (parts["year"], parts["month"], parts["day"])), strict=True)
        parts["day"].cells = ["" if None in row else "-".join(f"{value:02.0f}" for value in row) for row in dates]
        parts["day"].kind, parts["year"].is_taken, parts["month"].is_taken = "stamp", True, True
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


def _are_clocks(values: Sequence[float]) -> bool:
    """Whether numbers that could be clocks are hardly seconds: they pass a minute late in the day, for long, or in steps that are regular
    only so."""
    clocks = [value // 10_000 * 3600 + value // 100 % 100 * 60 + value % 100 for value in values]
    steps = [{round(after - before, 6) for before, after in pairwise(row)} for row in (values, clocks)]
    return len({value // 100 for value in values}) > 1 and (
        min(values) >= 10_000 or max(values) >= 10_000 and (len(values) > 9 or not _rises(values)) or len(values) > 4 and len(steps[0]) > 1 == len(steps[1]))


def _calendar(columns: Sequence[Column]) -> list[Moment | None] | None:
    """Year, month, day, hour and minute in columns."""
    places = _places(columns)
    if not {"year", "month", "day"} <= places.keys():
        return None

    def wrong(part: str, why: str) -> NoReturn:
        refuse(f"column `{places[part].label}` is called as the {part} of the time and {why}; rename it where it is something else, or say --time none")

    for above, part in pairwise(["day", "hour", "minute", "second"]):
        if part in places and above not in places:
            wrong(part, f"no column is the {above}")
    if "minute" in places and places["minute"].label.lower() == "min" and any(column.label.lower() in ("max", "mean", "avg") for column in columns):
        wrong("minute", "stands beside a largest or a mean value")
    moments: list[Moment | None] = []
    for cells in zip(*(column.cells for column in places.values()), strict=True):
        values = {part: value for (part, column), cell in zip(places.items(), cells, strict=True) if (value := column.number(cell)) is not None}
        if len(values) < len(places):
            moments.append(None)
            continue
        for part, value in values.items():
            if not 0 <= value <= MOST[part] or value % 1 and part != "second":
                wrong(part, f"holds {value:g}")
        try:
            day = datetime.date(*(int(values[part]) for part in ("year", "month", "day")))
        except ValueError:
            wrong("day", f"holds {values['day']:g} in month {values['month']:g} of year {values['year']:g}")
        if day.year < 100:
            return None
        # Weather data count the hours from 1 to 24 and write the end of each.
        clock = sum(of * values.get(part, 0) for part, of in (("hour", 3600), ("minute", 60), ("second", 1)))
        moments.append(Moment({"": day}, clock if "hour" in places else None))
    for column in places.values():
        column.is_taken = any(moments)
    return moments if any(moments) else None


def _labview(lines: Sequence[str], options: Options) -> Table:
    """LabVIEW's measurement files say how they are written."""
    marks = [k for k, line in enumerate(lines) if line.startswith("***End_of_Header***")]
    if len(marks) != 2:
        refuse("LabVIEW's header has no end; export it as csv" if len(marks) < 2 else
               f"{len(marks) - 1} segments, each a recording of its own; save them as files of their own")
    known = {parts[0]: parts[1] for line in lines[: marks[0]] if len(parts := line.split("\t" if "\t" in line else ",")) > 1}
    delimiter = "," if known.get("Separator") == "Comma" else "\t"
    decimal, way = known.get("Decimal_Separator", "."), known.get("X_Columns", "One")
    about = {row[0]: row[1:] for row in _split(lines[marks[0] + 1 : marks[1]], delimiter) if row}
    names, *body = _split(lines[marks[1] + 1 :], delimiter)
    count, units = len([name for name in about.get("Samples", names) if name]), about.get("Y_Unit_Label", [])
    places = [2 * c + 1 if way == "Multi" else c + 1 for c in range(count)]
    for c, place in enumerate(places):
        if way == "Multi":
            names[place - 1] = f"{names[place - 1]} {c + 1} [s]"
        if c < len(units) and units[c] and place < len(names):
            names[place] += f" [{units[c]}]"
    last = places[-1] + 1
    body = [row[:last] + [""] * (last - len(row)) for row in body if any(row[:last])]
    columns = table([names[:last], *body], dataclasses.replace(options, header=1, decimal=decimal))
    if way == "One":
        columns.time = list(columns.channels.pop(0)[2])
    elif way == "No":
        begins, steps = ({cell.replace(decimal, ".") for cell in about.get(key, [])[:count]} for key in ("X0", "Delta_X"))
        if len(begins) != 1 or len(steps) != 1 or "" in begins | steps:
            refuse("its channels have clocks of their own (X0, Delta_X); save it with X columns")
        columns.time = [round(float(*begins) + k * float(*steps), 12) for k in range(len(body))]
    if columns.time:
        columns.told.append(f"time: by LabVIEW's header, {columns.time[0]} .. {columns.time[-1]} s")
    return columns


def _seabird(lines: Sequence[str], options: Options) -> Table:
    """Sea-Bird's files name their columns above `*END*`; without blanks between them, each has eleven letters."""
    end = next((k for k, line in enumerate(lines) if line.startswith("*END*")), len(lines))
    known = dict(pair for line in lines[:end] if len(pair := line.removeprefix("# ").rstrip().split(" = ", 1)) == 2)
    if known.get("file_type") == "binary":
        refuse("its values are binary; save it as ASCII, as SBE Data Processing does")
    names = [known[f"name {k}"] for k in range(len(known)) if f"name {k}" in known]
    units = [f"[{found[1]}]" if (found := re.search(r"\[(?:.*, )?([^]]+)\]", name)) else "" for name in names]
    bad, gaps, rows = known.get("bad_flag"), 0, []
    for line in lines[end + 1 :]:
        row = line.split()
        if len(row) != len(names) and len(line.rstrip()) == 11 * len(names):
            row = [line[k : k + 11].strip() for k in range(0, 11 * len(names), 11)]
        gaps += row.count(bad) if bad else 0
        rows.append(["" if cell == bad else cell for cell in row])
    columns = table([[name.partition(":")[0] for name in names], units, *rows], dataclasses.replace(options, header=1), ".")
    if gaps:
        columns.told.append(f"{gaps} cells are `{bad}`, the header's mark of bad values, and became empty")
    if columns.time is None and (interval := known.get("interval", "")).startswith("seconds"):
        columns.told.append(f"the header says that rows are {interval.partition(':')[2].strip()} s apart")
    return columns

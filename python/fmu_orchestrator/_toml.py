"""Writes the content of a study as TOML, and changes it by dotted names."""

import json
import os
import re
import tomllib
from collections.abc import Callable, Iterable, Iterator, Mapping
from copy import deepcopy
from difflib import get_close_matches
from functools import cache
from numbers import Integral, Real
from pathlib import Path
from typing import Any

from ._errors import OrchestratorError
from ._files import HOME
from ._table import is_table

BARE = re.compile(r"[A-Za-z0-9_-]+")
Content = dict[str, Any]
Keep = Callable[[Any], str | os.PathLike[str]]


def text(content: Mapping[str, Any]) -> str:
    """The content as TOML."""
    return "\n".join(_table(content, ())) + "\n"


def _table(table: Mapping[str, Any], path: tuple[str, ...]) -> Iterator[str]:
    """The lines of a table: its values, then the tables in it under their headers."""
    for name, value in table.items():
        if not isinstance(value, Mapping) and not _is_tables(value):
            yield f"{_key(name)} = {_value(value)}"
    for name, value in table.items():
        inner = (*path, name)
        header = ".".join(map(_key, inner))
        if isinstance(value, Mapping):
            yield f"\n[{header}]"
            yield from _table(value, inner)
        elif _is_tables(value):
            for one in value:
                yield f"\n[[{header}]]"
                yield from _table(one, inner)


def _is_tables(value: Any) -> bool:
    return isinstance(value, list | tuple) and bool(value) and all(isinstance(one, Mapping) for one in value)


def _key(name: str) -> str:
    return name if BARE.fullmatch(name) else _value(name)


def _value(value: Any) -> str:
    # numpy's truth values and numbers are none of Python's.
    if isinstance(value, bool) or type(value).__name__ in ("bool", "bool_"):
        return str(bool(value)).lower()
    if isinstance(value, str | os.PathLike):
        return json.dumps(os.fspath(value), ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, Integral):
        return str(int(value))
    if isinstance(value, Real):
        return repr(float(value))
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{_key(name)} = {_value(one)}" for name, one in value.items()) + " }"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(map(_value, value)) + "]"
    if hasattr(value, "tolist"):
        return _value(value.tolist())
    raise OrchestratorError(f"a study cannot hold {value!r}, a {type(value).__name__}")


def placed(content: Mapping[str, Any], folder: Path, keep: Keep | None = None) -> Content:
    """A copy of the content of a study that stood in a folder, with the files that it names as absolute paths. Where a table
    stands for a file, ``keep`` writes it and says where."""

    def path_of(file: Any) -> Any:
        if isinstance(file, str | os.PathLike):
            return os.path.normpath(folder / file)
        return os.path.abspath(keep(file)) if keep and is_table(file) else file

    def inner(value: Any) -> Any:
        if isinstance(value, Mapping):
            return {name: path_of(one) if name == "file" else inner(one) for name, one in value.items()}
        return [inner(one) for one in value] if isinstance(value, list | tuple) else value

    copy: Content = {name: path_of(one) if name in ("fmu", "fixed-from") else inner(one) for name, one in content.items()}
    if isinstance(copy.get("identify"), dict) and "cases" in copy["identify"]:
        copy["identify"]["cases"] = path_of(content["identify"]["cases"])
    return copy


def changed(content: Mapping[str, Any], changes: Mapping[str, Any]) -> Content:
    """A copy with other values by dotted names, such as ``criteria.T.nominal``; None takes a key out."""
    copy = deepcopy(dict(content))
    for name, value in changes.items():
        _assign(copy, name, value)
    return copy


def refuse_unknown(before: Mapping[str, Any], after: Content, names: Iterable[str]) -> None:
    """Refuses dotted names with a key that no study knows, or with a new table that lacks what such a table needs, as
    misspelt."""
    for name in names:
        schema: Any = _schema()
        old: Any = before
        new: Any = after
        for part in _parts(after, name):
            if isinstance(new, list):
                schema, new = schema.get("items", {}), _case(new, part, name)
                old = next((case for case in old or () if case.get("name") == part), {})
            else:
                known = schema.get("properties", {})
                others = schema.get("additionalProperties", {})
                if part not in known and others is False:
                    raise OrchestratorError(f"{name}: no study has `{part}` there{_nearest(part, known)}")
                schema, new = known.get(part, others), new.get(part)
                kept, old = old, old.get(part, {}) if isinstance(old, Mapping) else {}
            schema = _schema()["$defs"][schema["$ref"].split("/")[-1]] if "$ref" in schema else schema
            if not isinstance(new, Mapping | list):
                break
            if isinstance(new, Mapping) and not old and not new.keys() >= set(schema.get("required", ())):
                raise OrchestratorError(f"{name}: there is no `{part}`{_nearest(part, kept)}")


@cache
def _schema() -> Content:
    schema: Content = json.loads((HOME / "studies" / "study.schema.json").read_text(encoding="utf-8"))
    return schema


def _nearest(name: str, known: Iterable[str]) -> str:
    near, all_known = get_close_matches(name, known, 1), ", ".join(known)
    if near:
        return f"; did you mean `{near[0]}`?"
    return f"; there are {all_known}" if all_known else "; a name with dots stands in quotes"


def _assign(content: Content, name: str, value: Any) -> None:
    table: Any = content
    parts = _parts(content, name)
    for depth, part in enumerate(parts[:-1]):
        if isinstance(table, list):
            table = _case(table, part, name)
        elif part in table:
            table = table[part]
        elif depth == 0 or len(parts) == depth + 2:
            table = table.setdefault(part, {})
        else:
            raise OrchestratorError(f"{name}: there is no `{part}` in it; there are {', '.join(table)}")
    if not isinstance(table, dict):
        raise OrchestratorError(f"{name}: `{'.'.join(parts[:-1])}` is no table")
    if value is None:
        table.pop(parts[-1], None)
    else:
        table[parts[-1]] = deepcopy(value)


def _parts(content: Content, name: str) -> list[str]:
    """The keys of a dotted name: names of parameters and criteria may hold dots, so known ones come first."""
    if '"' in name:
        try:
            return _keys(tomllib.loads(f"{name} = 0"))
        except tomllib.TOMLDecodeError as error:
            raise OrchestratorError(f"{name}: {error}") from None
    parts: list[str] = []
    table: Any = content
    rest = name
    while rest:
        known = [case.get("name", "") for case in table] if isinstance(table, list) else table
        fits = [key for key in known if rest == key or rest.startswith(f"{key}.")] if known else []
        key = max(fits, key=len) if fits else rest.partition(".")[0]
        parts.append(key)
        table = _case(table, key, name) if isinstance(table, list) else table.get(key) if isinstance(table, dict) else None
        rest = rest[len(key) + 1 :]
    return parts


def _keys(nested: Any) -> list[str]:
    [(key, inner)] = nested.items()
    return [key, *_keys(inner)] if isinstance(inner, dict) else [key]


def _case(cases: list[Any], name: str, whole: str) -> Any:
    for case in cases:
        if case.get("name") == name:
            return case
    raise OrchestratorError(f"{whole}: there is no case `{name}`; there are {', '.join(str(case.get('name')) for case in cases)}")

"""Hands columns to other libraries through the Arrow C data interface and its PyCapsules.

Specification: https://arrow.apache.org/docs/format/CDataInterface.html and CStreamInterface.html. It is written with ctypes,
because the package has no dependencies and a library for it is larger than the package.

Whoever takes a structure calls its ``release``; until then `_alive` holds what it points to.
"""

import ctypes
from array import array
from collections.abc import Iterator, Mapping
from itertools import accumulate, count
from math import isnan
from typing import Any, TypeAlias, cast

Column: TypeAlias = "array[float] | array[int] | list[bool] | list[str]"

NULLABLE = 2


class Schema(ctypes.Structure):
    """``struct ArrowSchema``"""


class Array(ctypes.Structure):
    """``struct ArrowArray``"""


class Stream(ctypes.Structure):
    """``struct ArrowArrayStream``"""


_Release = ctypes.CFUNCTYPE(None, ctypes.c_void_p)
_GetSchema = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p, ctypes.POINTER(Schema))
_GetNext = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p, ctypes.POINTER(Array))
_GetError = ctypes.CFUNCTYPE(ctypes.c_char_p, ctypes.c_void_p)

Schema._fields_ = [
    ("format", ctypes.c_char_p),
    ("name", ctypes.c_char_p),
    ("metadata", ctypes.c_char_p),
    ("flags", ctypes.c_int64),
    ("n_children", ctypes.c_int64),
    ("children", ctypes.POINTER(ctypes.POINTER(Schema))),
    ("dictionary", ctypes.c_void_p),
    ("release", _Release),
    ("private_data", ctypes.c_void_p),
]
Array._fields_ = [
    ("length", ctypes.c_int64),
    ("null_count", ctypes.c_int64),
    ("offset", ctypes.c_int64),
    ("n_buffers", ctypes.c_int64),
    ("n_children", ctypes.c_int64),
    ("buffers", ctypes.POINTER(ctypes.c_void_p)),
    ("children", ctypes.POINTER(ctypes.POINTER(Array))),
    ("dictionary", ctypes.c_void_p),
    ("release", _Release),
    ("private_data", ctypes.c_void_p),
]
Stream._fields_ = [
    ("get_schema", _GetSchema),
    ("get_next", _GetNext),
    ("get_last_error", _GetError),
    ("release", _Release),
    ("private_data", ctypes.c_void_p),
]

_alive: dict[int, Any] = {}
_keys = count(1)


def _keep(things: Any) -> int:
    key = next(_keys)
    _alive[key] = things
    return key


def _children(structure: Any) -> Iterator[Any]:
    for place in range(structure.n_children):
        yield structure.children[place]


def _released(kind: Any) -> Any:
    """The function that releases a structure with its children."""

    def release(address: int) -> None:
        structure = kind.from_address(address)
        for child in _children(structure):
            # A child that was moved elsewhere is released there.
            if child.contents.release:
                child.contents.release(ctypes.addressof(child.contents))
        _alive.pop(structure.private_data, None)
        structure.release = _Release()

    return _Release(release)


_release_schema = _released(Schema)
_release_array = _released(Array)


def _pointers(kind: Any, structures: list[Any]) -> Any:
    return (ctypes.POINTER(kind) * len(structures))(*map(ctypes.pointer, structures))


def _fill_schema(schema: Schema, form: bytes, name: str, children: list[Schema], flags: int = 0) -> None:
    pointers, text = _pointers(Schema, children), name.encode()
    schema.format, schema.name, schema.metadata, schema.flags = form, text, None, flags
    schema.n_children, schema.children, schema.dictionary = len(children), pointers, None
    schema.release = _release_schema
    schema.private_data = _keep((form, text, children, pointers))


def _fill_array(array_: Array, length: int, buffers: list[Any], children: list[Array], nulls: int = 0) -> None:
    addresses = (ctypes.c_void_p * len(buffers))(*(_address(buffer) for buffer in buffers))
    pointers = _pointers(Array, children)
    array_.length, array_.null_count, array_.offset = length, nulls, 0
    array_.n_buffers, array_.buffers = len(buffers), addresses
    array_.n_children, array_.children, array_.dictionary = len(children), pointers, None
    array_.release = _release_array
    array_.private_data = _keep((buffers, addresses, children, pointers))


def _address(buffer: Any) -> int | None:
    """Where the bytes of a buffer are; the buffer must stay alive."""
    if buffer is None:
        return None
    if isinstance(buffer, array):
        return buffer.buffer_info()[0]
    return ctypes.cast(ctypes.c_char_p(buffer), ctypes.c_void_p).value


def _bits(flags: list[bool]) -> bytes:
    """Flags, eight to a byte, the first in the lowest bit."""
    ones = bytes(flags) + bytes(-len(flags) % 8)
    packed = 0
    # All bytes at once: each holds 0 or 1, so a shift by less than eight stays within it.
    for bit in range(8):
        packed |= int.from_bytes(ones[bit::8], "little") << bit
    return packed.to_bytes(len(ones) // 8, "little")


def _form(column: Column) -> bytes:
    if isinstance(column, array):
        return b"g" if column.typecode == "d" else b"l"
    return b"b" if column and isinstance(column[0], bool) else b"u"


def _buffers(column: Column) -> tuple[list[Any], int]:
    """The buffers of a column, and how many of its cells are null."""
    if isinstance(column, array):
        nulls = sum(map(isnan, column)) if column.typecode == "d" else 0
        there = _bits([not isnan(value) for value in column]) if nulls else None
        return [there, column], nulls
    if _form(column) == b"b":
        return [None, _bits(cast("list[bool]", column))], 0
    texts = [str(text).encode() for text in column]
    return [None, array("i", accumulate(map(len, texts), initial=0)), b"".join(texts)], 0


class _Source:
    """What a stream hands out: one batch of all columns."""

    def __init__(self, columns: Mapping[str, Column]) -> None:
        self.columns = dict(columns)
        self.over = False

    def schema(self, into: Schema) -> None:
        children = []
        for name, column in self.columns.items():
            child = Schema()
            _fill_schema(child, _form(column), name, [], NULLABLE)
            children.append(child)
        _fill_schema(into, b"+s", "", children)

    def next(self, into: Array) -> None:
        if self.over:
            into.release = _Release()
            return
        self.over = True
        length = len(next(iter(self.columns.values()), ()))
        children = []
        for column in self.columns.values():
            child = Array()
            buffers, nulls = _buffers(column)
            _fill_array(child, length, buffers, [], nulls)
            children.append(child)
        _fill_array(into, length, [None], children)


def _source(address: int) -> _Source:
    source = _alive[Stream.from_address(address).private_data]
    assert isinstance(source, _Source)
    return source


def _give_schema(address: int, out: Any) -> int:
    _source(address).schema(out.contents)
    return 0


def _give_next(address: int, out: Any) -> int:
    _source(address).next(out.contents)
    return 0


def _give_error(_: int) -> None:
    return None


def _end_stream(address: int) -> None:
    structure = Stream.from_address(address)
    _alive.pop(structure.private_data, None)
    structure.release = _Release()


# The functions live as long as the module, because others hold their addresses.
_get_schema, _get_next = _GetSchema(_give_schema), _GetNext(_give_next)
_get_error, _release_stream = _GetError(_give_error), _Release(_end_stream)

NAME = b"arrow_array_stream"
_Destructor = ctypes.PYFUNCTYPE(None, ctypes.c_void_p)
_new = ctypes.PYFUNCTYPE(ctypes.py_object, ctypes.c_void_p, ctypes.c_char_p, _Destructor)(
    ("PyCapsule_New", ctypes.pythonapi)
)
_pointer = ctypes.PYFUNCTYPE(ctypes.c_void_p, ctypes.c_void_p, ctypes.c_char_p)(
    ("PyCapsule_GetPointer", ctypes.pythonapi)
)
# The structures that capsules hold, by address.
_streams: dict[int, Stream] = {}


def _destroy(capsule: int) -> None:
    address = _pointer(capsule, NAME)
    # A stream that nobody has taken still holds its columns.
    if address in _streams and _streams[address].release:
        _release_stream(address)
    _streams.pop(address, None)


_destructor = _Destructor(_destroy)


def stream(columns: Mapping[str, Column]) -> object:
    """A capsule with a stream of the columns."""
    structure = Stream(_get_schema, _get_next, _get_error, _release_stream, _keep(_Source(columns)))
    address = ctypes.addressof(structure)
    _streams[address] = structure
    return _new(address, NAME, _destructor)

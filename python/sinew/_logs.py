"""Logs as users have them: paths, data frames, dictionaries of columns."""

from __future__ import annotations

import os
import zlib
from collections.abc import Mapping, Sequence
from typing import Any, Protocol, TypeAlias, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _sinew


@runtime_checkable
class DataFrame(Protocol):
    """What a data frame of pandas or polars has."""

    @property
    def columns(self) -> Any: ...

    def __getitem__(self, name: Any, /) -> Any: ...


#: One log: a path, a data frame, or a mapping of column names to arrays of equal length.
Log: TypeAlias = str | os.PathLike[str] | DataFrame | Mapping[str, ArrayLike]
#: One log or several.
Logs: TypeAlias = Log | Sequence[Log]


def native_logs(logs: Logs) -> list[str] | list[tuple[str, bytes]]:
    """Paths where all logs are files, else names and contents."""
    many = list(logs) if isinstance(logs, Sequence) and not isinstance(logs, str) else [logs]
    if all(isinstance(log, str | os.PathLike) for log in many):
        return [os.fspath(log) for log in many]  # type: ignore[arg-type]
    return [_content(log) for log in many]


def _content(log: Log) -> tuple[str, bytes]:
    if isinstance(log, str | os.PathLike):
        with open(log, "rb") as file:
            return os.fspath(log), file.read()
    text = _sinew.table_text(_columns(log))
    # By its content, so that a table has the same name wherever it is given, and another one another name.
    return f"table {zlib.crc32(text):08x}", text


def _columns(table: Any) -> list[tuple[str, Any]]:
    index: list[tuple[str, Any]] = []
    if isinstance(table, Mapping):
        names = list(table)
    elif isinstance(table, DataFrame):
        names = list(table.columns)
        index = _index(table, names)
    else:
        raise TypeError(
            "a log must be a path, a data frame or a mapping of columns, "
            f"but is of type {type(table).__name__}"
        )
    for name in names:
        if not isinstance(name, str):
            raise TypeError(f"names of columns must be text, but one is {name!r}")
    return index + [(name, _column(table[name])) for name in names]


def _index(table: Any, names: list[Any]) -> list[tuple[str, Any]]:
    """The index of a pandas data frame where it holds times, or has a name, which a mere count of rows has not."""
    index = getattr(table, "index", None)
    if index is None or not hasattr(index, "dtype"):
        return []
    name = getattr(index, "name", None)
    values = _column(index)
    holds_times = isinstance(values, list) and getattr(index, "inferred_type", "").startswith(("date", "time"))
    if holds_times and not isinstance(name, str):
        name = "time"
    if not isinstance(name, str) or name in names:
        return []
    return [(name, values)]


def _column(values: Any) -> Any:
    array = np.asarray(values)
    if array.dtype.kind == "M":
        return ["" if np.isnat(stamp) else str(stamp) for stamp in array]
    if array.dtype.kind == "m":
        # A unit of their own, so that no other is taken from the name of the column.
        return ["" if np.isnat(span) else f"{span.astype('timedelta64[ns]').astype(np.int64)} ns" for span in array]
    if array.dtype.kind == "O" or array.dtype.kind in "UT":
        labels = np.atleast_1d(array).tolist()
        if all(isinstance(label, str) for label in labels):
            return array.tolist()
        # Stamps with a zone, dates, clock times and durations of Python and pandas, missing ones among them.
        if any(hasattr(label, "isoformat") or hasattr(label, "total_seconds") for label in labels):
            return [_time_text(label) for label in labels]
        # Columns of data frames with missing values are objects.
        return np.array([np.nan if value is None else value for value in np.atleast_1d(array)], dtype=float)
    return array


def _time_text(value: Any) -> str:
    if value is None or value != value:
        return ""
    if hasattr(value, "total_seconds"):
        return f"{value.total_seconds()!r} s"
    return str(value.isoformat())

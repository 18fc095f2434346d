"""Logs as users have them: paths, data frames, dictionaries of columns."""

from __future__ import annotations

import os
import zlib
from collections.abc import Mapping, Sequence
from typing import Any, Protocol, TypeAlias, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

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
    if isinstance(table, Mapping):
        names = list(table)
    elif isinstance(table, DataFrame):
        names = list(table.columns)
    else:
        raise TypeError(
            "a log must be a path, a data frame or a mapping of columns, "
            f"but is of type {type(table).__name__}"
        )
    for name in names:
        if not isinstance(name, str):
            raise TypeError(f"names of columns must be text, but one is {name!r}")
    return [(name, _column(table[name])) for name in names]


def _column(values: Any) -> Any:
    array = np.asarray(values)
    if array.dtype.kind == "O" or array.dtype.kind in "UT":
        labels = array.tolist()
        if all(isinstance(label, str) for label in np.atleast_1d(array).tolist()):
            return labels
        # Columns of data frames with missing values are objects.
        return np.array([np.nan if value is None else value for value in np.atleast_1d(array)], dtype=float)
    return array

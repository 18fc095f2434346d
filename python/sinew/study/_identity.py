"""Whether an objective is the one that computed earlier trials."""

from __future__ import annotations

import functools
import re
import sys
import types
from collections.abc import Iterable
from hashlib import sha256
from typing import Any


def identity(objective: Any) -> str:
    """Name of an objective, version of Python and digest of what it does: its own code, its parameters and what it encloses.

    Functions of other modules that it calls are not part of it.
    """
    kind = objective.func if isinstance(objective, functools.partial) else objective
    name = getattr(kind, "__qualname__", type(kind).__qualname__)
    digest = sha256(repr(_parts(objective)).encode()).hexdigest()[:16]
    return f"{name} py{sys.version_info[0]}.{sys.version_info[1]} {digest}"


def is_another(one: str, other: str) -> bool:
    """Whether two identities are of different objectives; code of two versions of Python is not compared."""
    (name, python, digest), (name2, python2, digest2) = one.rsplit(" ", 2), other.rsplit(" ", 2)
    return name != name2 or (python == python2 and digest != digest2)


def _parts(value: Any, depth: int = 0) -> Any:
    def each(values: Iterable[Any]) -> list[Any]:
        return [_parts(one, depth + 1) for one in values]

    # Functions may enclose themselves or each other.
    if depth > 8:
        return type(value).__name__
    match value:
        case functools.partial():
            return each((value.func, *value.args, *sorted(value.keywords.items())))
        case types.MethodType():
            return each((value.__func__, value.__self__))
        case types.FunctionType():
            return each((value.__code__, value.__defaults__, *map(_content, value.__closure__ or ())))
        case types.CodeType():
            return each((value.co_code.hex(), value.co_names, value.co_consts))
        case tuple() | list():
            return each(value)
        case frozenset():
            # Their order is another one in every process.
            return sorted(map(repr, value))
    # Without addresses, which are others in every process.
    text = re.sub(r" at 0x[0-9a-fA-F]+", "", repr(value))
    call = getattr(type(value), "__call__", None)
    return each((text, call)) if isinstance(call, types.FunctionType) else text


def _content(cell: types.CellType) -> Any:
    try:
        return cell.cell_contents
    except ValueError:  # It is empty.
        return None

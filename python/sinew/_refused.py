"""Refusals of values of the wrong kind, by name."""

from __future__ import annotations

import operator
from collections.abc import Mapping
from typing import Any


def whole(name: str, value: Any, least: int = 0) -> int:
    """A whole number; raises `TypeError` or `ValueError` that names it."""
    expected = f"{name} must be a whole number of at least {least}, but is {value!r}"
    try:
        number = operator.index(value)
    except TypeError:
        raise TypeError(expected) from None
    if number < least or isinstance(value, bool):
        raise ValueError(expected)
    return number


def wrong_kind(error: TypeError, given: Mapping[str, Any]) -> TypeError:
    """An error of the native part, which names the field that it could not read, with the value and the reason."""
    name = str(error).rpartition(".")[2]
    if name not in given:
        return error
    reason = f": {error.__cause__}" if error.__cause__ is not None else ""
    return TypeError(f"{name} is {given[name]!r}, which is of the wrong kind{reason}")

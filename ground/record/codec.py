# SPDX-License-Identifier: GPL-3.0-or-later
"""Converts messages to JSON values and back, guided by their type hints."""

from __future__ import annotations

import dataclasses
from enum import Enum
from functools import cache
from types import GenericAlias
from typing import Any, TypeAlias, TypeVar, get_args, get_type_hints

from ground.model import Incoming
from ground.requests import Outgoing

Json: TypeAlias = Any
T = TypeVar("T", bound=Incoming | Outgoing)
KINDS: dict[str, type[Incoming]] = {kind.__name__: kind for kind in get_args(Incoming)}
SENT_KINDS: dict[str, type[Outgoing]] = {kind.__name__: kind for kind in get_args(Outgoing)}


def to_json(value: object) -> Json:
    """Convert: dataclasses to objects, tuples to lists, enums to values, bytes to hexadecimal."""
    if dataclasses.is_dataclass(value):
        return {f.name: to_json(getattr(value, f.name)) for f in dataclasses.fields(value)}
    if isinstance(value, Enum):
        return value.value
    if isinstance(value, tuple):
        return [to_json(item) for item in value]
    if isinstance(value, bytes):
        return value.hex()
    return value


def from_json(kind: type[T], data: Json) -> T:
    """Restore a message that to_json() converted. Raises ValueError if the data do not fit."""
    try:
        message: T = _value(kind, data)
    except (KeyError, TypeError, AttributeError) as error:
        raise ValueError(f"this is not a {kind.__name__}: {error}") from error
    return message


@cache
def _hints(kind: type) -> dict[str, Any]:
    return get_type_hints(kind)


def _value(kind: Json, data: Json) -> Json:
    if hasattr(kind, "__dataclass_fields__"):
        hints = _hints(kind)
        return kind(*(_value(hints[name], data[name]) for name in kind.__dataclass_fields__))
    if isinstance(kind, GenericAlias):  # tuple[...]
        kinds = get_args(kind)
        if kinds[-1] is Ellipsis:
            return tuple(_value(kinds[0], item) for item in data)
        return tuple(_value(k, item) for k, item in zip(kinds, data, strict=True))
    if kind is bytes:
        return bytes.fromhex(data)
    if isinstance(kind, type) and issubclass(kind, Enum | float | int | str):
        return kind(data)
    return data

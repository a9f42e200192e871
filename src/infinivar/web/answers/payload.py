"""What is read from the payload of a request, checked: values of other kinds than the page sends are refused."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from typing import Any

from infinivar.errors import printable
from infinivar.web.answers.answer import RefusedError

MOST_CELLS = 400
"""Most cells along an axis of a map."""

_LONGEST = 200


def whole(payload: Mapping[str, Any], key: str, low: int, high: int, otherwise: int | None = None) -> int:
    """A whole number between two ends."""
    value = payload.get(key, otherwise)
    if isinstance(value, bool) or not isinstance(value, int) or not low <= value <= high:
        raise RefusedError(f"{key} must be a whole number from {low} to {high}")
    return value


def flag(payload: Mapping[str, Any], key: str) -> bool:
    """Yes or no."""
    value = payload.get(key)
    if not isinstance(value, bool):
        raise RefusedError(f"{key} must be true or false")
    return value


def number(payload: Mapping[str, Any], key: str) -> float:
    """A finite number."""
    value = payload.get(key)
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(_float(value)):
        raise RefusedError(f"{key} must be a finite number")
    return float(value)


def _float(value: float) -> float:
    try:
        return float(value)
    except OverflowError:
        return math.inf


def text(payload: Mapping[str, Any], key: str, otherwise: str | None = None, longest: int = _LONGEST) -> str:
    """A text of at most some length."""
    value = payload.get(key, otherwise)
    if not isinstance(value, str) or len(value) > longest:
        raise RefusedError(f"{key} must be text of at most {longest} characters")
    return value


def word(payload: Mapping[str, Any], key: str, known: Collection[str], otherwise: str | None = None) -> str:
    """One of some words; the first is not a default, `otherwise` is."""
    value = text(payload, key, otherwise)
    if value not in known:
        raise RefusedError(f"{key} = {printable(value)!r} must be one of {', '.join(map(printable, known))}")
    return value


def words(payload: Mapping[str, Any], key: str, known: Collection[str]) -> list[str]:
    """A list of words, each one of some words; all of them by default. The list may name words that are gone by now."""
    value = payload.get(key)
    if value is None:
        return list(known)
    if not isinstance(value, list) or not all(isinstance(one, str) for one in value):
        raise RefusedError(f"{key} must be a list of names")
    return [one for one in known if one in value]


def texts(payload: Mapping[str, Any], key: str) -> dict[str, str]:
    """A mapping of texts; empty by default."""
    value = payload.get(key, {})
    if not isinstance(value, dict) or not all(isinstance(one, str) for one in value.values()):
        raise RefusedError(f"{key} must map names to texts")
    return value


def names(payload: Mapping[str, Any], key: str, most: int) -> list[str]:
    """A list of at least one and at most so many texts, such as names or the keys of a value in tables."""
    value = payload.get(key)
    if not isinstance(value, list) or not 0 < len(value) <= most:
        raise RefusedError(f"{key} must be a list of 1 to {most} names")
    return [text({key: one}, key) for one in value]

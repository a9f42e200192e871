"""Higher derivatives of products, quotients, roots, compositions and inverse functions.

A *row of derivatives* is a list: a function's value, then its first, second ... derivative by one variable, as floats or
arrays that broadcast. Terms that are exactly the number 0.0 are skipped, so rows of mostly constant functions cost little.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from infinivar._core.array_namespace import Array, namespace

Row = Sequence[Array]


def is_zero(value: Any) -> bool:
    """Whether a value is exactly the number 0, not an array of zeros."""
    return isinstance(value, (int, float)) and value == 0


def _times(one: Array, other: Array) -> Array:
    return 0.0 if is_zero(one) or is_zero(other) else one * other


def _plus(one: Array, other: Array) -> Array:
    if is_zero(one) or is_zero(other):
        return one if is_zero(other) else other
    return one + other


def total(*rows: Row) -> list[Array]:
    """Derivatives of a sum of functions, up to the shortest row's order."""
    found = list(rows[0])
    for row in rows[1:]:
        found = [_plus(one, other) for one, other in zip(found, row, strict=False)]
    return found


def product(one: Row, other: Row) -> list[Array]:
    """Derivatives of the product of two functions, up to the shorter row's order.

    Source: Leibniz's rule.
    """
    found = []
    for order in range(min(len(one), len(other))):
        term: Array = 0.0
        for k in range(order + 1):
            term = _plus(term, math.comb(order, k) * _times(one[k], other[order - k]))
        found.append(term)
    return found


def quotient(one: Row, other: Row) -> list[Array]:
    """Derivatives of the quotient of two functions, up to the shorter row's order.

    Source: Leibniz's rule for ``quotient * other = one``.
    """
    found: list[Array] = []
    for order in range(min(len(one), len(other))):
        term = one[order]
        for k in range(order):
            term = _plus(term, -math.comb(order, k) * _times(found[k], other[order - k]))
        found.append(0.0 if is_zero(term) else term / other[0])
    return found


def root(row: Row) -> list[Array]:
    """Derivatives of the square root of a positive function.

    Source: Leibniz's rule for ``root * root = row``.
    """
    xp = namespace(row[0])
    found: list[Array] = [xp.sqrt(row[0])]
    for order in range(1, len(row)):
        term = row[order]
        for k in range(1, order):
            term = _plus(term, -math.comb(order, k) * _times(found[k], found[order - k]))
        found.append(0.0 if is_zero(term) else 0.5 * term / found[0])
    return found


def composed(outer: Row, inner: Row) -> list[Array]:
    """Derivatives of ``outer(inner(t))`` by t, up to the shorter row's order.

    Parameters
    ----------
    outer   Derivatives of the outer function by its argument, at the value of the inner one.
    inner   Derivatives of the inner function by t.

    Source: the chain rule, ``(outer o inner)' = (outer' o inner) inner'``, repeated.
    """
    if len(outer) == 1 or len(inner) == 1:
        return [outer[0]]
    return [outer[0], *product(composed(outer[1:], inner[:-1]), inner[1:])]


def inverse(row: Row, at: Array) -> list[Array]:
    """Derivatives of the inverse of an increasing function by its value; `at` is the argument at which `row` holds.

    Source: ``x'(y) = 1/f'(x(y))``, differentiated by the chain rule.
    """
    found: list[Array] = [at]
    for order in range(1, len(row)):
        slope = composed(row[1 : order + 1], found)
        found.append(quotient([1.0] + [0.0] * (order - 1), slope)[-1])
    return found

"""The tightest limit of a design, and the margin that it leaves."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TypeVar

Key = TypeVar("Key")


def tightest_of(demands: Mapping[Key, float]) -> Key | None:
    """Limit with the largest demand over allowance; None if no limit is loaded."""
    return max(demands, key=lambda key: demands[key], default=None)


def margin_of(demands: Mapping[Key, float]) -> float:
    """Allowance over demand of the tightest limit. [-]"""
    worst = max(demands.values(), default=0.0)
    return 1.0 / worst if worst > 0.0 else math.inf

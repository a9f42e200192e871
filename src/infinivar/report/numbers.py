"""Number formats of report pages: those of `infinivar.units.plain`, with typeset powers of ten."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from typing import Any

from infinivar import units
from infinivar._core.text import capitalise

_BOUND = "\N{NO-BREAK SPACE}"
_UNIT = (
    r"(?:%|°C|degC?|rpm|rad/s|Wh|(?:[kmMG]?(?:N|m|s|W|J|V|A|K|H|Hz|Pa|g)|ohm)(?:[ /][ckm]?m(?:²|\^2)?|/s²?|/[AKW])?)"
)
_BEFORE_UNIT = re.compile(rf"(?:(?<=\d)|(?<=</sup>)) (?={_UNIT}(?!\w))")


def si(value: float | None, digits: int = 3) -> Any:
    """A number such as "1500" or "1.5 × 10" with a raised exponent; "–" for nan."""
    return raised(units.plain(value, digits))


def quantity(value: float | None, unit: str, digits: int = 3) -> Any:
    """A number with its unit, if any; "–" alone for nan."""
    from markupsafe import Markup

    if value is None or math.isnan(value):
        return "–"
    return (
        Markup("{}{}{}").format(si(value, digits), _BOUND, unit.replace(" ", _BOUND))
        if unit not in ("", "1")
        else si(value, digits)
    )


def raised(text: str) -> Any:
    """A plain number with its power of ten typeset."""
    from markupsafe import Markup

    mantissa, power, exponent = text.partition("e")
    if not power or not exponent.lstrip("-").isdigit():
        return text
    return Markup("{0}{2}×{2}10<sup>{1}</sup>").format(mantissa, exponent.replace("-", "−"), _BOUND)


def bound(page: str) -> str:
    """A page in which no line breaks between a number and its unit."""
    return _BEFORE_UNIT.sub(_BOUND, page)


def watts(value: float) -> Any:
    """A power to 0.01 W, or to three digits where that is too coarse or too fine."""
    if math.isnan(value):
        return "–"
    size = abs(value)
    if size == 0.0 or 0.01 <= size < 1e4:
        return f"{value:.2f} W"
    return quantity(value, "W")


def percent(share: float) -> str:
    """A share in percent, to 0.1 %."""
    return "–" if math.isnan(share) else units.percent(share, 1)


def celsius(temperature: float | None) -> str:
    """A temperature in kelvin as "92 °C"; "–" for nan."""
    return "–" if temperature is None else units.celsius(temperature)


def signed(value: float, digits: int = 3) -> Any:
    """A change with its sign."""
    return raised(units.signed(value, digits))


FILTERS: dict[str, Callable[..., Any]] = {
    "capitalise": capitalise,
    "si": si,
    "signed": signed,
    "quantity": quantity,
    "watts": watts,
    "percent": percent,
    "celsius": celsius,
}
"""Filters for templates."""

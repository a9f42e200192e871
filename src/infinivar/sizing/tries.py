"""Values of templates to try, each with everything that a search chooses: read, checked, and made into drives."""

from __future__ import annotations

import itertools
import math
import numbers
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from infinivar._core.bounds import fits, words
from infinivar._core.fields import quantities_of, with_values
from infinivar.drivetrain.drive import is_machine
from infinivar.errors import InputError, ParameterError, nearest, printable, require
from infinivar.sizing.design import (
    COBOTIC_PATHS,
    FOLLOWING,
    ROLES,
    SCALES,
    STEERING_RATIO,
    WHEELS,
    architecture_of,
    role_words,
    short_path,
    shown,
)
from infinivar.sizing.machine_templates import searched_values, weighed
from infinivar.study.schema import SCALE
from infinivar.study.study import Study
from infinivar.units import parse

VALUES = 7
"""Values of a range that are tried first, in equal ratios with its ends."""

BESIDE = 2
"""Values tried then on each side of the best, in equal ratios up to its neighbours, which are left out."""

MOST = 1000
"""Most combinations of values for one template."""

_WHOLE = ("teeth", SCALE.name)
"""Names of values that are whole numbers."""

Point = tuple[float, ...]
"""A value for each `Try`. In SI."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Try:
    """Values of one field of a template.

    Attributes
    ----------
    path      In the drive, such as "output.series_spring.stiffness".
    unit      In SI.
    values    In rising order.
    ranged    Whether they stand for a range, so that more are tried around the best.
    """

    path: str
    unit: str
    values: tuple[float, ...]
    ranged: bool = False

    def around(self, best: float) -> tuple[float, ...]:
        """The best of the values, and those between its neighbours that are tried next."""
        if not self.ranged:
            return (best,)
        place = self.values.index(best)
        ends = self.values[max(place - 1, 0)], self.values[min(place + 1, len(self.values) - 1)]
        steps = [np.geomspace(best, end, BESIDE + 2)[1:-1] for end in ends if end != best]
        return _several(self.path, [best, *(float(one) for some in steps for one in some)])


def _several(path: str, values: Iterable[float]) -> tuple[float, ...]:
    """Values in rising order, each once; whole where the field is."""
    whole = path.rpartition(".")[2] in _WHOLE
    return tuple(sorted({float(round(one)) if whole else float(one) for one in values}))


def points(tries: Sequence[Try]) -> list[Point]:
    """Every combination of the values."""
    return list(itertools.product(*(one.values for one in tries)))


def points_around(tries: Sequence[Try], best: Point) -> list[Point]:
    """Combinations around the best that are tried next."""
    near = itertools.product(*(one.around(value) for one, value in zip(tries, best, strict=True)))
    return [point for point in near if point != best]


def drive_at(drive: Any, tries: Sequence[Try], point: Point) -> Any:
    """The template with a combination of values; the number of motors on a shaft is none of its fields."""
    chosen = {one.path: value for one, value in zip(tries, point, strict=True) if one.path not in SCALES}
    return with_values(drive, chosen)


def tries_of(study: Study, templates: Sequence[str], given: Mapping[str, Any]) -> dict[str, tuple[Try, ...]]:
    """Read and check the values to try, by template.

    Parameters
    ----------
    study : Study
    templates : sequence   Names of the drives that are searched.
    given : mapping        By ``drives.NAME.PATH``: numbers in SI, texts with units, or one text, such as "100 N/mm, 140 N/mm"
        or the range "60 N/mm..300 N/mm".

    Raises
    ------
    InputError
        If a path is unknown, of a drive that is not searched, or of a value that the search chooses itself, or a value cannot be
        read, is out of its range or refused by the drive.
    """
    require(isinstance(given, Mapping), "tries", repr(given), "values by path, such as drives.NAME.screw.lead")
    found: dict[str, list[Try]] = {}
    for key, said in given.items():
        name, path = _place(study, templates, key)
        found.setdefault(name, []).append(_try(study.drives[name], str(key), path, said))
    for name, some in found.items():
        count = math.prod(len(one.values) for one in some)
        if count > MOST:
            raise InputError(
                f"tries: {count:,} combinations of values for drives.{name}; at most {MOST:,} are searched"
            )
        _check_drives(study.drives[name], name, some)
    return {name: tuple(some) for name, some in found.items()}


def _place(study: Study, templates: Sequence[str], key: object) -> tuple[str, str]:
    """Drive and path of a value."""
    head, _, rest = str(key).partition(".")
    name, _, path = rest.partition(".")
    if head != "drives" or not path:
        raise InputError(
            f"tries: {printable(str(key))} must be drives.NAME.PATH, such as drives.{templates[0]}.output.series_spring.stiffness"
        )
    if name not in study.drives:
        raise InputError(
            f"tries: {printable(str(key))}: the study has no drive {printable(name)!r}{nearest(name, study.drives)}; its drives: "
            f"{', '.join(study.drives)}"
        )
    if name not in templates:
        raise InputError(
            f"tries: {printable(str(key))}: drives.{name} is not searched, but {' and '.join(templates)}; name it with drive"
        )
    return name, path


def _refusal(path: str, cobotic: bool) -> str | None:
    """Why a search cannot try values of a path that it chooses itself, or that it does not use; None if it may."""
    role = next((role for role in ROLES if path.startswith(f"{role}.")), None)
    if role is not None:
        own = next((one for one in SCALES if one == f"{role}.{SCALE.name}"), None)
        return f"the search itself chooses the {role_words(role)}{'' if own is None else f'; only {own} can be tried'}"
    known = (
        {**dict.fromkeys(COBOTIC_PATHS.values(), "ranges"), STEERING_RATIO: "steering_ratios", WHEELS: "wheels"}
        if cobotic
        else {}
    )
    option = {**known, "pulley.radius": "radius"}.get(path)
    if option is not None:
        return f"the search itself chooses it, as {option} says"
    if cobotic and path in FOLLOWING:
        return "it follows from what the search chooses"
    if path.startswith("control."):
        return "has no effect: neither steady operation nor prescribed motion depends on controllers"
    return None


def _try(drive: Any, key: str, path: str, said: Any) -> Try:
    """Values of one path."""
    fields = quantities_of(drive) | {one: SCALE for one in SCALES if _has(drive, one)}
    own = searched_values(drive) if is_machine(drive) and not weighed(drive) else []
    refusal = "the search itself chooses it, as ranges says" if path in own else None
    if refusal is None and path not in SCALES:
        refusal = _refusal(short_path(path), architecture_of(drive) == "cobotic")
    if refusal is None and path not in fields:
        refusal = f"drives.{key.split('.')[1]} has no such value{nearest(path, fields)}"
    if refusal is not None:
        raise InputError(f"tries: {printable(key)}: {refusal}")
    unit, bound = (fields[path].metadata[name] for name in ("unit", "bound"))
    values, ranged = _values(key, said, unit)
    for value in values:
        require(fits(bound, value), f"tries: {key}", shown(value, unit), words(bound))
        whole = path not in SCALES or (value >= 1.0 and value.is_integer())
        require(whole, f"tries: {key}", shown(value, unit), "a whole number of motors, 1 or more")
        require(values.count(value) == 1, f"tries: {key}", f"{shown(value, unit)} twice", "different values")
    return Try(path=path, unit=unit, values=_spread(path, *values) if ranged else tuple(sorted(values)), ranged=ranged)


def _has(drive: Any, path: str) -> bool:
    """Whether a drive of one axis has the motor to which a path of `SCALES` leads."""
    if is_machine(drive):
        return False
    return path == "motor.scale" or getattr(drive, "steering", None) is not None


def _spread(path: str, low: float, high: float) -> tuple[float, ...]:
    """Values of a range in equal ratios, with its ends."""
    return _several(path, [low, *map(float, np.geomspace(low, high, VALUES)[1:-1]), high])


def _values(key: str, said: Any, unit: str) -> tuple[list[float], bool]:
    """Values as stated, or the ends of a range, and whether they are these. In SI."""
    wrong = (
        f"tries: {key} must be values, or a range LOW..HIGH above 0 with the least first, got {printable(str(said))!r}"
    )
    if isinstance(said, str) and ".." in said:
        ends = [_number(key, one, unit) for one in said.split("..")]
        if len(ends) != 2 or not 0.0 < ends[0] < ends[1]:
            raise InputError(wrong)
        return ends, True
    each = said.split(",") if isinstance(said, str) else said
    if isinstance(each, numbers.Real):
        each = [each]
    if not isinstance(each, Iterable) or not (values := [_number(key, one, unit) for one in each]):
        raise InputError(wrong)
    return values, False


def _number(key: str, said: Any, unit: str) -> float:
    """A value from a number in SI, or a text with its unit."""
    if isinstance(said, numbers.Real) and not isinstance(said, bool) and math.isfinite(said):
        return float(said)
    said = said.strip() if isinstance(said, str) else said
    try:
        return parse(said, unit)
    except InputError as problem:
        raise InputError(f"tries: {key} = {printable(str(said))!r} {problem}") from None


def _check_drives(drive: Any, name: str, tries: Sequence[Try]) -> None:
    """Raise InputError if the template refuses a combination of values."""
    for point in points(tries):
        try:
            drive_at(drive, tries, point)
        except ParameterError as problem:
            said = ", ".join(f"{one.path} = {shown(value, one.unit)}" for one, value in zip(tries, point, strict=True))
            raise InputError(f"tries: drives.{name} refuses {said}: {problem}") from None

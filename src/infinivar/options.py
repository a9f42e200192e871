"""Options of commands, each described once: a frozen dataclass a command, whose fields carry help, unit, bounds and default.

The command line, the explorer and the reports read name, help, unit and default from the fields.
"""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, ClassVar, NamedTuple, Self

from infinivar import units
from infinivar.errors import InputError

Read = Callable[[str, Any], Any]
"""From the name of an option, for messages, and what is stated to its value in SI; raises InputError."""


@dataclasses.dataclass(frozen=True, slots=True, kw_only=True)
class Option:
    """What an option is, beside its name and default, which its field has.

    Attributes
    ----------
    help      Sentence for listings.
    stated    Type of what is stated: bool, int, float, str, Path, list[str], list[int] or tuple[str, str].
    read      Its value from what is stated.
    usual     What holds where it is not given, in words; "" if the default or the help says so.
    unit      SI unit of the value; "" if it has none.
    least     Of a whole or plain number.
    choices   Words that may be stated; empty for any.
    name      On the command line, if not that of its field.
    metavar   What stands for it in listings, if not its type.
    show      Its value in words, if not that of numbers in `unit`.
    of_files  Whether it names files of this machine, which a page must not open.
    """

    help: str
    stated: Any = str
    read: Read
    usual: str = ""
    unit: str = ""
    least: float | None = None
    choices: tuple[str, ...] = ()
    name: str = ""
    metavar: str | None = None
    show: Callable[[Any], str] | None = None
    of_files: bool = False


def option(help: str, stated: Any = str, read: Read | None = None, *, default: Any = None, **known: Any) -> Any:
    """Field of an option; `known` has further attributes of `Option`. By default, the value is what is stated."""
    made = Option(help=help, stated=stated, read=read or (lambda name, said: said), **known)
    return dataclasses.field(default=default, metadata={"option": made})


def flag(help: str) -> Any:
    """Field of an option that is on or off."""
    return option(help, bool, default=False)


def choice(help: str, choices: Sequence[str], *, default: str) -> Any:
    """Field of an option that is one of some words."""

    def read(name: str, said: str) -> str:
        if said not in choices:
            raise InputError(f"{name} {said!r} must be one of {', '.join(choices)}")
        return said

    return option(help, str, read, default=default, choices=tuple(choices))


def amount(help: str, unit: str, **known: Any) -> Any:
    """Field of an option such as "20 N"; its value is in SI."""
    return option(help, str, lambda name, said: quantity(name, said, unit), unit=unit, **known)


def amounts(help: str, unit: str, **known: Any) -> Any:
    """Field of an option such as "2 mm, 5 mm"; its values are in SI."""
    return option(help, str, lambda name, said: quantities(name, said, unit), unit=unit, **known)


def numbers(help: str, *, default: tuple[float, ...] | None = None, **known: Any) -> Any:
    """Field of an option such as "100,8,1"."""

    def read(name: str, said: str) -> tuple[float, ...]:
        try:
            return tuple(float(part) for part in said.split(","))
        except ValueError:
            raise InputError(f"{name} {said!r} must be numbers separated by commas, such as 100,8,1") from None

    return option(help, str, read, default=default, unit="1", **known)


def words(help: str, **known: Any) -> Any:
    """Field of an option such as "linear, polach"."""

    def read(name: str, said: str) -> tuple[str, ...]:
        return tuple(part.strip() for part in said.split(",") if part.strip())

    return option(help, str, read, **known)


def headings(help: str) -> Any:
    """Field of an option such as "time=t, angle=Knee angle [deg]": headings of columns by name."""
    return option(help, str, headings_of)


def headings_of(name: str, said: str | None) -> dict[str, str] | None:
    """Headings of columns by name, from "name=heading, name=heading"; None for none.

    Raises
    ------
    InputError
        If the text is anything else.
    """
    if said is None:
        return None
    found = {}
    for part in said.split(","):
        role, mark, heading = part.partition("=")
        if not mark or not role.strip() or not heading.strip():
            raise InputError(f'{name} {said!r} must be roles and headings, such as "time=t, angle=Knee angle [deg]"')
        found[role.strip()] = heading.strip()
    return found


def quantity(name: str, said: str, unit: str) -> float:
    """SI value of an option such as "20 N"."""
    try:
        return units.parse(said, unit)
    except InputError as problem:
        raise InputError(f"{name} {said!r} {problem}") from None


def quantities(name: str, said: str, unit: str) -> tuple[float, ...]:
    """SI values of an option such as "2 mm, 5 mm"."""
    return tuple(quantity(name, part.strip(), unit) for part in said.split(","))


def span(name: str, said: str, low: str, high: str, unit: str) -> tuple[float, float]:
    """Ends of a range above 0 from their texts, in SI; `name` and `said` are for messages."""
    ends = quantity(name, low.strip(), unit), quantity(name, high.strip(), unit)
    if not 0.0 < ends[0] <= ends[1]:
        raise InputError(f"{said} must be a range above 0, the least first")
    return ends


class Row(NamedTuple):
    """One option of a report: its name, its value in words, and what it is."""

    name: str
    value: str
    help: str


class Options:
    """Base of the options of a command: a frozen dataclass whose fields the functions above make."""

    __slots__ = ()

    command: ClassVar[str]
    """Its name on the command line."""

    @classmethod
    @functools.cache
    def described(cls) -> Mapping[str, Option]:
        """What each option is, by name."""
        return {field.name: field.metadata["option"] for field in dataclasses.fields(cls)}  # type: ignore[arg-type]

    @classmethod
    def default(cls, name: str) -> Any:
        """The value of an option that is not given."""
        return next(field.default for field in dataclasses.fields(cls) if field.name == name)  # type: ignore[arg-type]

    @classmethod
    def read(cls, said: Mapping[str, Any], named: Callable[[str], str] = str) -> Self:
        """Options from what is stated; those that are missing or None keep their defaults.

        Parameters
        ----------
        said : mapping   What is stated, by name.
        named            The name of an option in messages.

        Raises
        ------
        InputError
            If a text cannot be read.
        """
        known = cls.described()
        given = {name: one for name, one in said.items() if one is not None}
        return cls(**{name: known[name].read(named(name), one) for name, one in given.items()})

    def arguments(self, *names: str) -> dict[str, Any]:
        """Options by name, as arguments of the function of the command: all, or those of some names."""
        return {name: getattr(self, name) for name in names or self.described()}

    @classmethod
    def usual(cls, name: str) -> str:
        """What holds where an option is not given, in words; "" if its help says so."""
        known, default = cls.described()[name], cls.default(name)
        return known.usual or ("" if default is None else _shown(default, known))

    def rows(self) -> Iterator[Row]:
        """Yield each option with its value in words, for a report."""
        for name, known in self.described().items():
            value = getattr(self, name)
            words = self.usual(name) if value is None else _shown(value, known)
            yield Row(name.replace("_", " "), words or "–", known.help)


def _shown(value: Any, known: Option) -> str:
    """A value in words."""
    if known.show is not None:
        return known.show(value)
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, Mapping):
        return ", ".join(f"{name} = {one}" for name, one in value.items())
    if isinstance(value, tuple | list):
        return ", ".join(_shown(one, known) for one in value)
    if isinstance(value, float) and known.unit:
        return units.show(value, known.unit)
    return f"{value:g}" if isinstance(value, float) else str(value)

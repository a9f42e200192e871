"""What a verdict hangs on: the same decision with another answer to each choice that a study leaves open."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any, NamedTuple

from infinivar._core.described import derived, finite, reported
from infinivar._core.frozen import FrozenDict
from infinivar._core.result import Frozen, Result, result
from infinivar._core.text import aligned, counted, joined
from infinivar.errors import InputError
from infinivar.study.choices import Variant
from infinivar.units import plain

MOST = 10
"""Rows that are shown."""

_NAMED = 3
"""Answers that a verdict names for one winner; of more, all but the first two are counted."""

_SAME = 1e-9
"""Relative change of a figure below which a choice has no effect."""


class Judged(NamedTuple):
    """What decides on one drive."""

    able: bool
    """Whether it is feasible in all that is required."""
    values: tuple[float, ...]
    """Of which the least wins: one of mixed use or of the region, else one for each motion or task."""

    @property
    def figure(self) -> float:
        """Sum of the values, to be shown."""
        return sum(self.values)


Answered = tuple[tuple[str, str, str], Mapping[str, Judged]]
"""Choice, what is used and what instead, in words; and what decides with that answer, by drive."""


def winner(judged: Mapping[str, Judged]) -> str | None:
    """The able drive with the least of each value; None if no drive is able, or none has the least of each."""
    able = {name: one for name, one in judged.items() if one.able}
    if not able:
        return None
    count = len(next(iter(able.values())).values)
    least = {min(able, key=lambda name, place=place: able[name].values[place]) for place in range(count)}
    return least.pop() if len(least) == 1 else None


@result
class HangingRow(Frozen):
    """One choice answered otherwise.

    Attributes
    ----------
    choice, used, instead   In words: what is chosen, as it is, and as it is here.
    figures                 What decides, by drive; nan where a wheel slips.
    able                    Whether feasible, by drive.
    winner                  Name of the best drive; None if there is none.
    flips                   Whether that is another one than with what is used.
    """

    choice: str = reported()
    used: str = reported()
    instead: str = reported()
    figures: Mapping[str, float] = reported(convert=finite)
    able: Mapping[str, bool] = reported(key="feasible")
    winner: str | None = reported()
    flips: bool = reported()

    @property
    def lead(self) -> float:
        """Figure of the next able drive over that of the best: how near the row is to another winner. [-]"""
        first = sorted(self.figures[name] for name, able in self.able.items() if able)[:2]
        return first[1] / first[0] if len(first) == 2 and first[0] > 0.0 else math.inf


@result
class Hanging(Result):
    """What a verdict hangs on, as `Comparison.hangs_on`: choices that no source settles, each with the winner it gives.

    Attributes
    ----------
    figure, unit : str   What decides.
    titles               Of the drives, by name.
    used : HangingRow    With what the study has.
    rows                 At most ten: those that flip the winner first, then those that come nearest to it.
    tried : int          Answers tried, with those that change no figure.
    more : int           Answers with an effect that are not among the rows.
    """

    figure: str = reported()
    unit: str = reported()
    titles: Mapping[str, str]
    used: HangingRow = reported()
    rows: tuple[HangingRow, ...] = reported()
    tried: int = reported()
    more: int = reported(default=0)

    @property
    def flips(self) -> tuple[HangingRow, ...]:
        """Rows with another winner."""
        return tuple(row for row in self.rows if row.flips)

    @derived()
    def decided(self) -> bool:
        """Whether every answer gives the same winner."""
        return not self.flips

    @derived()
    def verdict(self) -> str:
        """One sentence: whether the winner is the same with every answer, or the choices on which it hangs, nearest first."""
        if not self.tried:
            return "No choice is open"
        if self.decided:
            return f"{self._won(self.used)} with each of {counted(self.tried, 'answers')} to open choices"
        by: dict[str, list[str]] = {}
        for row in self.flips:
            by.setdefault(self._won(row), []).append(f"{row.choice}: {row.instead}")
        more = "; see the table" if any(len(answers) > _NAMED for answers in by.values()) else ""
        return f"Undecidable: {'; '.join(f'{won} with {_or(answers)}' for won, answers in by.items())}{more}"

    @property
    def headline(self) -> str:
        """The winner with what is used, and by how much it leads; or that there is none."""
        able = sorted(self.used.figures[name] for name, able in self.used.able.items() if able)
        if self.used.winner is None:
            return "None leads in everything required." if able else "None meets all that is required."
        best, others = able[0], f" of {len(self.titles)}" if len(self.titles) > 1 else ""
        lead = f"the only one{others} that meets all that is required" if others else "meets all that is required"
        if len(able) > 1:
            share = f" ({plain(100.0 * (1.0 - best / able[1]), 2)} %)" if best > 0.0 else ""
            lead = f"{plain(able[1] - best, 2)} {self.unit}{share} less than the next"
        return f"{self.titles[self.used.winner]}: {self.figure} {plain(best, 3)} {self.unit}, {lead}."

    @property
    def turned_by(self) -> str:
        """The choices that turn the winner, nearest first, or that none does; one sentence."""
        if not self.tried:
            return "No choice is open."
        if self.decided:
            return f"The same with each of {counted(self.tried, 'answers')} to open choices."
        return f"Not decided: another wins with {_or([f'{row.choice}: {row.instead}' for row in self.flips])}."

    @property
    def prefix(self) -> str:
        """What comes before the verdict on the study as it is: nothing if that is decided."""
        return "" if self.decided else f"{self.verdict}. With what is used: "

    def _won(self, row: HangingRow) -> str:
        if row.winner is not None:
            return f"{self.titles[row.winner]} {'wins' if len(self.titles) > 1 else 'is feasible'}"
        return "none leads" if any(row.able.values()) else "none is feasible"

    @property
    def heading(self) -> tuple[str, ...]:
        """Heads of the columns of `cells`; drives by name."""
        return ("choice", "used", "instead", *self.titles, "winner")

    @property
    def cells(self) -> tuple[tuple[str, ...], ...]:
        """The table as text, the study as it is first."""
        return tuple(
            (
                row.choice,
                row.used,
                row.instead,
                *(self._figure(row, name) for name in self.titles),
                f"{row.winner or 'none'}{' (flips)' if row.flips else ''}",
            )
            for row in (self.used, *self.rows)
        )

    def _figure(self, row: HangingRow, name: str) -> str:
        value = row.figures[name]
        said = f"{plain(value, 3)} {self.unit}" if math.isfinite(value) else "slips"
        return said if row.able[name] else f"({said})"

    @property
    def lines(self) -> tuple[str, ...]:
        """The table in aligned lines, for a terminal; figures of infeasible drives in brackets.

        Where it would be wider than 98 columns, the widest cells are wrapped between words and behind hyphens.
        """
        figures = range(3, 3 + len(self.titles))
        return tuple(aligned((self.heading, *self.cells), figures)) if self.rows else ()


def _or(said: list[str]) -> str:
    if len(said) > _NAMED:
        said = [*said[: _NAMED - 1], f"{len(said) - _NAMED + 1} more"]
    return joined(said, "or")


def hang(
    variants: Iterable[Variant],
    judge: Callable[[str, Any, Variant], Judged],
    used: Mapping[str, Judged],
    titles: Mapping[str, str],
    figure: str,
    unit: str,
    also: Iterable[Answered] = (),
) -> Hanging:
    """Decide again with each variant; drives that it does not change are not computed again.

    Parameters
    ----------
    variants : iterable of Variant
    judge : callable               What decides on a changed drive: its name, the drive, and the variant.
    used : name to Judged          With what the study has.
    titles : name to text
    figure, unit : str             What decides, and its unit.
    also : iterable of Answered    Answers of which what decides is known.

    Returns
    -------
    Hanging   Without variants of which a drive cannot be judged.
    """
    answered: list[Answered] = []
    for variant in variants:
        try:
            changed = {name: judge(name, drive, variant) for name, drive in variant.drives.items()}
        except InputError:
            continue  # such a drive cannot move as required, which says nothing about the verdict
        answered.append(((variant.choice, variant.used, variant.instead), {**used, **changed}))
    return decided_again(used, [*answered, *also], titles, figure, unit)


def decided_again(
    used: Mapping[str, Judged],
    answered: Iterable[Answered],
    titles: Mapping[str, str],
    figure: str,
    unit: str,
) -> Hanging:
    """What a decision hangs on, from what decides with each answer: choice, what is used and what instead, in words."""
    won, rows, tried = winner(used), [], 0
    for words, judged in answered:
        tried += 1
        if all(_same(one, used[name]) for name, one in judged.items()):
            continue
        found = winner(judged)
        rows.append(_made(words, judged, found, found != won))
    rows.sort(key=lambda row: (not row.flips, row.lead))
    return Hanging(
        figure=figure,
        unit=unit,
        titles=FrozenDict(titles),
        used=_made(("as used", "", ""), used, won, flips=False),
        rows=tuple(rows[:MOST]),
        tried=tried,
        more=max(0, len(rows) - MOST),
    )


def _same(one: Judged, other: Judged) -> bool:
    return one.able == other.able and all(
        math.isclose(a, b, rel_tol=_SAME) or (math.isnan(a) and math.isnan(b))
        for a, b in zip(one.values, other.values, strict=True)
    )


def _made(
    words: tuple[str, str, str],
    judged: Mapping[str, Judged],
    won: str | None,
    flips: bool,
) -> HangingRow:
    choice, used, instead = words
    return HangingRow(
        choice=choice,
        used=used,
        instead=instead,
        figures=FrozenDict({name: one.figure for name, one in judged.items()}),
        able=FrozenDict({name: one.able for name, one in judged.items()}),
        winner=won,
        flips=flips,
    )


def printed_lines(hanging: Hanging | None) -> Iterator[str]:
    """Yield what a command prints: a heading and the table, or one line if nothing has an effect."""
    if hanging is None or not hanging.tried:
        return
    if not hanging.rows:
        tried = "the one answer" if hanging.tried == 1 else f"none of {hanging.tried} answers"
        effect = "has no effect" if hanging.tried == 1 else "has an effect"
        yield f"What this verdict hangs on: {tried} to open choices {effect}."
        return
    yield f"What this verdict hangs on ({hanging.figure}; in brackets: infeasible):"
    yield from (f"  {line}" for line in hanging.lines)
    if hanging.more:
        yield f"  {hanging.more} more with an effect on figures"

"""The same session at the handle on a cobotic and on conventional displays: energy, force, stiffness, mass felt, heat.

Values that no source states are varied one at a time. A statement is undecidable where the variants that meet the requirement
disagree.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from infinivar._core.array_namespace import Array
from infinivar._core.arrays import shown
from infinivar._core.described import derived, finite, reported
from infinivar._core.fields import check_instance
from infinivar._core.result import Result, result
from infinivar._core.text import joined
from infinivar.analysis.hanging import Hanging, Judged, decided_again
from infinivar.analysis.shared_motor import SharedMotor, share_motor
from infinivar.displays.handle_session import (
    PARTS,
    HandleSession,
    cobotic_part,
    geared_part,
)
from infinivar.displays.kinds import AdmittanceDisplay, ImpedanceDisplay
from infinivar.displays.pair import CONVENTIONAL, YES_OR_NO, DisplayPair
from infinivar.displays.rounds import RUN_UP, TURNING, WAYS, round_of
from infinivar.displays.stability import MASSES, WALLS, least_stable_mass, stiffest_wall
from infinivar.errors import ParameterError, require
from infinivar.motion.users import ArmModel
from infinivar.units import plain

MARGIN = 1.1
"""To the limit of stability, as in a Z-width."""


@result
class DisplayComparison(Result):
    """A session on all displays, as returned by `compare_displays`; V variants, D ways and displays, N numbers of axes.

    Of the force, mass and stiffness there is one of the cobotic display and one of each conventional one: C = D - 2.

    Attributes
    ----------
    session : HandleSession
    arm : str                      Whose arm.
    assuming : V texts             What is assumed; the first is as shown.
    displays : D texts             Three ways to run the cobotic display, the conventional display, and its rivals.
    differences : texts            What is not the same for every display, beside its drive.
    axes : (N,) int
    parts : 6 texts                Parts of the session, and the run-ups of the cylinder.
    energy : (V, D, N, 6) float    From the supply in one round, nan where a wheel would slip. [J]
    steering : (V, N) float        Of that, for steering. [J]
    user : (V, D, N) float         From the user in one round. [J]
    winding : (V, D, N) float      Heat in the winding of the hottest motor, mean of a round. [W]
    heating : (V, D, N) float      Root mean square of current over continuous current, of the motor nearest to it. [-]
    feasible : (V, D, N) bool      Whether force and speed required are reached, all limits kept, and free motion is stable.
    limit : (V, D, N) texts        What is exceeded where it is not; "" elsewhere.
    stop : (V, N) float            Time at rest from which it saves energy to stop the cylinder. [s]
    largest_force : (V, C) float   Of an axis, at which wheels slip, and which the motor can hold. [N]
    least_force : (V, C) float     Friction that the user feels; with a force sensor its noise. [N]
    least_mass : (V, C) float      Felt in free motion: the least stable virtual mass with a margin of 1.1 and the handle; the
        reflected mass and the handle. nan if none is stable. [kg]
    largest_mass : (V, C) float    Felt; inf if any virtual mass above the least is stable. [kg]
    stiffness : (V, C) float       Of the stiffest stable wall, over a margin of 1.1, at the handle. [N m^-1]
    margin : (V, C) float          Virtual mass of the session over the least stable one; stable beyond 1; inf without one. [-]
    """

    session: HandleSession
    arm: str = reported()
    assuming: tuple[str, ...] = reported()
    displays: tuple[str, ...] = reported()
    differences: tuple[str, ...] = reported()
    axes: np.ndarray = reported()
    parts: tuple[str, ...] = reported()
    energy: np.ndarray = reported("J", convert=finite)
    steering: np.ndarray = reported("J", convert=finite)
    user: np.ndarray = reported("J", convert=finite)
    winding: np.ndarray = reported("W", convert=finite)
    heating: np.ndarray = reported("1", convert=finite, key="heating_1")
    feasible: np.ndarray = reported()
    limit: np.ndarray = reported()
    stop: np.ndarray = reported("s", convert=finite)
    largest_force: np.ndarray = reported("N", convert=finite)
    least_force: np.ndarray = reported("N", convert=finite)
    least_mass: np.ndarray = reported("kg", convert=finite)
    largest_mass: np.ndarray = reported("kg", convert=finite)
    stiffness: np.ndarray = reported("N/m", convert=finite)
    margin: np.ndarray = reported("1", convert=finite, key="margin_1")

    @property
    def total(self) -> np.ndarray:
        """Energy of a round. (V, D, N) [J]"""
        return np.sum(self.energy, axis=-1)

    @property
    def conventionals(self) -> tuple[str, ...]:
        """The conventional display and its rivals."""
        return self.displays[len(WAYS) :]

    @property
    def names(self) -> tuple[str, ...]:
        """Displays, whatever the cobotic one's cylinder does. C texts"""
        return ("cobotic", *self.conventionals)

    def cheaper(self, display: str = TURNING, rival: str = CONVENTIONAL) -> tuple[str, ...]:
        """Which display draws less energy at each number of axes.

        Parameters
        ----------
        display : str   How the cobotic display is run, one of the first three of `displays`.
        rival : str     A conventional display.

        Returns
        -------
        N texts   "cobotic", the name of the rival, or "undecidable" if variants that meet the requirement disagree. If a display
            exceeds a limit as shown, "cobotic alone" or "conventional alone" for the other one, or "neither".
        """
        place, other = self._place(display), self._rival(rival)
        found = []
        for count in range(len(self.axes)):
            sound = self.feasible[:, place, count] & self.feasible[:, other, count]
            wins = (self.total[:, place, count] < self.total[:, other, count])[sound]
            if not sound[0]:
                mine, theirs = self.feasible[0, place, count], self.feasible[0, other, count]
                found.append("cobotic alone" if mine else f"{rival} alone" if theirs else "neither")
            else:
                found.append(("cobotic" if wins[0] else rival) if np.all(wins == wins[0]) else "undecidable")
        return tuple(found)

    def range_of(self, values: np.ndarray, feasible: np.ndarray | None = None) -> tuple[float, float, float]:
        """A value as shown, and the least and largest of the variants that are feasible; values (V,)."""
        sound = np.isfinite(values) if feasible is None else np.asarray(feasible) & np.isfinite(values)
        kept = np.asarray(values)[sound]
        return (float(values[0]), *((float(np.min(kept)), float(np.max(kept))) if kept.size else (math.nan, math.nan)))

    def flips(self, display: str, axes: int, rival: str = CONVENTIONAL) -> tuple[str, ...]:
        """Variants that meet the requirement and reverse which display draws less than with what is shown."""
        place, count, other = self._place(display), self._count(axes), self._rival(rival)
        both = self.feasible[:, place, count] & self.feasible[:, other, count]
        wins = self.total[:, place, count] < self.total[:, other, count]
        return tuple(
            name for name, win, sound in zip(self.assuming, wins, both, strict=True) if sound and win != wins[0]
        )

    def hangs_on(self, display: str = TURNING, axes: int = 1) -> Hanging:
        """Choices that no source settles, each with the display that draws less; of the variants compared, one at a time.

        Parameters
        ----------
        display : str   How the cobotic display is run, one of the first three of `displays`.
        axes : int      One of those compared.
        """
        place, count = self._place(display), self._count(axes)

        def judged(variant: int) -> dict[str, Judged]:
            each = {"cobotic": place, **{name: self._rival(name) for name in self.conventionals}}
            return {
                name: Judged(bool(self.feasible[variant, row, count]), (float(self.total[variant, row, count]),))
                for name, row in each.items()
            }

        answered = [
            (words, judged(variant))
            for variant, name in enumerate(self.assuming)
            if (words := _choice_words(name)) is not None
        ]
        titles = {"cobotic": f"cobotic, {display}", **{name: name for name in self.conventionals}}
        return decided_again(judged(0), answered, titles, f"energy of a round, {_axes_words(axes)}", "J")

    @derived()
    def verdict(self) -> str:
        """One-sentence answer: which display draws less energy, by number of axes and by what the cylinder does."""
        said = [f"{name}: {_grouped(self.axes, self.cheaper(name))}" for name in WAYS]
        return f"Less energy in a round of {plain(self.session.round_time)} s: {'; '.join(said)}."

    @derived()
    def lines(self) -> tuple[str, ...]:
        """Statements with ranges: energy by number of axes, force, mass, stiffness, and work of the user."""
        said = []
        for place, count in enumerate(self.axes):
            each = [
                f"{name} {_span(*self.range_of(self.total[:, row, place], self.feasible[:, row, place]), 'J')}"
                for row, name in enumerate(self.displays)
            ]
            said.append(f"{_axes_words(count)}: {', '.join(each)}")
        first = len(WAYS)
        meets = np.any(self.feasible[:, 0] & self.feasible[:, first], axis=-1)
        for title, values, scale, unit in (
            ("largest force of an axis", self.largest_force, 1.0, "N"),
            ("friction felt", self.least_force, 1.0, "N"),
            ("least mass felt", self.least_mass, 1.0, "kg"),
            ("stiffest stable wall", self.stiffness, 1e-3, "N/mm"),
        ):
            each = [
                f"{name} {_span(*self.range_of(scale * values[:, side], meets), unit)}"
                for side, name in enumerate(self.names)
            ]
            said.append(f"{title}: {', '.join(each)}")
        count = self.user.shape[-1] - 1
        given = [
            f"{name} {_span(*self.range_of(np.round(self.user[:, row, count], 9) + 0.0, self.feasible[:, row, count]), 'J')}"
            for row, name in ((0, "cobotic"), *enumerate(self.conventionals, first))
        ]
        said.append(f"work of the user, {_axes_words(int(self.axes[-1]))}: {', '.join(given)}")
        return tuple(said)

    @derived()
    def _hangs_on(self) -> dict[str, dict[int, Hanging]]:
        """Of each way to run the cobotic display, by number of axes."""
        return {name: {count: self.hangs_on(name, count) for count in np.asarray(self.axes).tolist()} for name in WAYS}

    @derived()
    def _cheaper(self) -> dict[str, tuple[str, ...]]:
        return {name: self.cheaper(name) for name in WAYS}

    def _place(self, display: str) -> int:
        require(display in WAYS, "display", repr(display), f"one of {', '.join(WAYS)}")
        return self.displays.index(display)

    def _rival(self, name: str) -> int:
        require(name in self.conventionals, "rival", repr(name), f"one of {', '.join(self.conventionals)}")
        return self.displays.index(name)

    def _count(self, axes: int) -> int:
        known = np.asarray(self.axes).tolist()
        require(axes in known, "axes", repr(axes), f"one of {', '.join(map(str, known))}")
        return known.index(axes)


def compare_displays(
    pair: DisplayPair,
    session: HandleSession | None = None,
    *,
    arm: ArmModel | Sequence[ArmModel] | None = None,
    axes: Sequence[int] = (1, 2, 3, 4, 5, 6),
    variants: Mapping[str, DisplayPair] | None = None,
) -> DisplayComparison:
    """Compare the same session on a cobotic display, on a conventional one, and on its rivals.

    Parameters
    ----------
    pair : DisplayPair               As shown, with the rivals.
    session : HandleSession          By default one with all parts.
    arm : ArmModel or several        For stability; of several, as grips of one user are, the worst; by default "vanbeek2015".
    axes : (N,) int                  Numbers of axes, rising.
    variants : text to DisplayPair   With other values of what is assumed, such as `assumed_variants`.

    Returns
    -------
    DisplayComparison

    Raises
    ------
    ParameterError
        If an argument is out of range.

    Source: `cobotic_part`, `geared_part`, `share_motor`'s run-up, `least_stable_mass` and `stiffest_wall`.
    """
    session = HandleSession() if session is None else session
    arm = ArmModel.named("vanbeek2015") if arm is None else arm
    check_instance("pair", pair, DisplayPair)
    check_instance("session", session, HandleSession)
    hands = (arm,) if isinstance(arm, ArmModel) else tuple(arm) if isinstance(arm, Sequence) else ()
    if not hands or not all(isinstance(hand, ArmModel) for hand in hands):
        raise ParameterError(f"arm must be an ArmModel, got {shown(arm)}")
    counts = np.asarray(axes)
    whole = counts.ndim == 1 and counts.size > 0 and counts.dtype.kind == "i"
    rising = whole and bool(counts[0] >= 1 and np.all(np.diff(counts) > 0))
    require(rising, "axes", axes, "whole numbers from 1 on that rise")
    if variants is not None and not isinstance(variants, Mapping):
        raise ParameterError(f"variants must map texts to DisplayPair, got a {type(variants).__name__}")
    pairs = {"as shown": pair, **({} if variants is None else dict(variants))}
    for name, one in pairs.items():
        check_instance(f"variants.{name}", one, DisplayPair)
        same = tuple(one.rivals) == tuple(pair.rivals)
        require(same, f"variants.{name}.rivals", ", ".join(one.rivals) or "none", "those of the pair")
    measured: dict[Any, tuple[float, float]] = {}
    each = [round_of(one, session, counts.tolist()) for one in pairs.values()]
    felt = [_felt(one, session, hands, measured) for one in pairs.values()]
    for one, of in zip(each, felt, strict=True):
        for row in range(one["limit"].shape[0]):
            side = max(0, row - len(WAYS) + 1)
            exceeded = _unfelt(session, {name: values[side] for name, values in of.items()})
            here = one["limit"][row]
            here[here == ""] = exceeded
        one["feasible"], one["limit"] = one["limit"] == "", one["limit"].astype(str)
    return DisplayComparison(
        session=session,
        arm=joined([hand.name for hand in hands], "or"),
        assuming=tuple(pairs),
        displays=(*WAYS, *pair.conventionals),
        differences=pair.differences,
        axes=counts,
        parts=(*PARTS, RUN_UP),
        **{name: np.array([one[name] for one in each]) for name in each[0]},
        **{name: np.array([one[name] for one in felt]) for name in felt[0]},
    )


def _unfelt(session: HandleSession, felt: Mapping[str, float]) -> str:
    """What a display exceeds of what the user may feel; "" if nothing. An unstable mass is beyond any."""
    if not felt["margin"] > 1.0:
        return "stability in free motion"
    if session.largest_friction is not None and not felt["least_force"] <= session.largest_friction:
        return "friction felt"
    if session.largest_mass is not None and not felt["least_mass"] <= session.largest_mass:
        return "mass felt"
    return ""


def _felt(
    pair: DisplayPair, session: HandleSession, hands: tuple[ArmModel, ...], known: dict[Any, tuple[float, float]]
) -> dict[str, tuple[float, ...]]:
    """Force, mass and stiffness of an axis of each display, the cobotic one first."""
    each = [_measured(pair.admittance, pair, session, hands, known, float(pair.cobotic.transmission.slip_force))]
    for name, rival in pair.conventionals.items():
        motors = rival.motors
        strength = motors.gain * float(rival.drive.motor.continuous_current)
        makes = partial(pair.rival, name)
        each.append(_measured(makes, pair, session, hands, known, strength))
    return {name: tuple(one[name] for one in each) for name in each[0]}


def _measured(
    makes: Callable[[float], AdmittanceDisplay | ImpedanceDisplay],
    pair: DisplayPair,
    session: HandleSession,
    hands: tuple[ArmModel, ...],
    known: dict[Any, tuple[float, float]],
    strength: float,
) -> dict[str, float]:
    """Of one display, made from a virtual mass."""
    display = makes(session.felt_mass)
    found = {"largest_force": strength}
    if isinstance(display, ImpedanceDisplay):
        _, wall = _remembered(
            known, _loop(display, hands), lambda: (0.0, float(np.min([stiffest_wall(display, hand) for hand in hands])))
        )
        mass = display.reflected_mass + pair.handle_mass
        felt = {"least_mass": mass, "largest_mass": mass, "margin": math.inf}
    else:
        least, wall = _remembered(known, _loop(display, hands), lambda: _admitted(makes, hands))
        felt = {
            "least_mass": MARGIN * least + pair.handle_mass,
            "largest_mass": math.inf if least < MASSES[1] else math.nan,
            "margin": (session.felt_mass - pair.handle_mass) / least,
        }
    return {**found, "least_force": display.least_force, **felt, "stiffness": display.at_handle(wall / MARGIN)}


def _admitted(makes: Callable[[float], Any], hands: tuple[ArmModel, ...]) -> tuple[float, float]:
    """Least virtual mass that is stable in every hand, and the stiffest stable wall with that mass and its margin."""
    least = float(np.max([least_stable_mass(makes(1.0).softest(), hand) for hand in hands]))
    if not math.isfinite(least):
        return math.nan, math.nan
    return least, float(np.min([stiffest_wall(makes(MARGIN * least), hand, between=WALLS) for hand in hands]))


def _loop(display: AdmittanceDisplay | ImpedanceDisplay, hands: tuple[ArmModel, ...]) -> Any:
    """What the stability of a display depends on: most variants change something else."""
    moves = isinstance(display, AdmittanceDisplay)
    controller = (display.servo, display.surface_speed) if moves else display.force_per_current
    plants = [display.plant(hand) for hand in hands]
    matrices = tuple(part.tobytes() if isinstance(part, np.ndarray) else part for plant in plants for part in plant)
    same = (display.handle_mass, display.wall_damping, display.samples_late)
    return matrices, display.drive.control, controller, same


def _remembered(known: dict[Any, Any], key: Any, compute: Callable[[], tuple[float, float]]) -> tuple[float, float]:
    if key not in known:
        known[key] = compute()
    return known[key]


def _axes_words(count: int) -> str:
    return f"{count} ax{'i' if count == 1 else 'e'}s"


def _choice_words(name: str) -> tuple[str, str, str] | None:
    """Choice, what is used and what instead, of the name of a variant; None for one of a value or of another machine."""
    choice, _, instead = name.partition(": ")
    if instead and ", " not in choice:
        return choice, "as shown", instead
    return (
        (name, "no", "yes") if name in YES_OR_NO or (name.startswith("reconstruction") and ", " not in name) else None
    )


def _grouped(axes: np.ndarray, words: Sequence[str]) -> str:
    """Numbers of axes by answer."""
    by: dict[str, list[str]] = {}
    for count, word in zip(np.asarray(axes).tolist(), words, strict=True):
        by.setdefault(word, []).append(str(count))
    return ", ".join(f"{word} at {' '.join(counts)}" for word, counts in by.items())


def _span(shown: float, low: float, high: float, unit: str) -> str:
    if not math.isfinite(low):
        return "beyond a limit"
    return f"{plain(shown, 3)} {unit} ({plain(low, 3)} to {plain(high, 3)})"


def _plain_rows(values: np.ndarray) -> Any:
    """Nested lists, with None for nan and infinity."""
    if np.ndim(values) == 0:
        return float(values) if math.isfinite(values) else None
    return [_plain_rows(row) for row in np.asarray(values)]


def display_break_even(
    pair: DisplayPair,
    session: HandleSession | None = None,
    *,
    force: Array,
    axes: Sequence[int] = (1, 2, 3, 4, 5, 6),
    duty: Array,
) -> SharedMotor:
    """Mean powers of both displays where a force is held for a share of the time, with free motion and idling in the rest.

    Parameters
    ----------
    pair : DisplayPair
    session : HandleSession     Its free motion and idling share the rest as in the session; one run-up in each round. Its other
        parts do not matter.
    force : (F,) float          Held by each axis, rising, >= 0. [N]
    axes : (N,) int             Numbers of axes.
    duty : float or (D,) float  Shares of time in which the force is held, 0 to 1.

    Returns
    -------
    SharedMotor   Its legs are the axes.

    Raises
    ------
    ParameterError
        If an argument is out of range.

    Source: `share_motor`, with the powers of free motion from `cobotic_part` and `geared_part`.
    """
    session = HandleSession() if session is None else session
    check_instance("pair", pair, DisplayPair)
    check_instance("session", session, HandleSession)
    shares = session.shares
    rest = shares["free"] + shares["idle"]
    free = shares["free"] / rest if rest > 0.0 else 0.0
    powers = np.zeros(np.size(np.asarray(axes))), 0.0
    if free > 0.0:
        mass, share = pair.handle_mass, pair.compensation
        powers = (
            np.array(
                [cobotic_part(pair.cobotic, session, "free", axes=int(one), handle_mass=mass).supply for one in axes]
            ),
            geared_part(pair.conventional, session, "free", axes=1, handle_mass=mass, compensation=share).supply,
        )
    return share_motor(
        pair.cobotic,
        pair.conventional,
        force=force,
        legs=axes,
        duty=duty,
        period=session.round_time,
        run_up_time=pair.run_up_time,
        held_by_friction=pair.friction_helps,
        free_share=free,
        free_power=powers,
    )

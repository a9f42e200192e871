"""The paper's statements on dynamic range and low electrical power, evaluated for a cobotic and a conventional display.

The paper prints no number for either. Each is compared with the conventional display that meets the same requirement, so that no
threshold of ours decides. Values that the paper does not print are varied; a variant that does not meet the requirement does
not count.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from annotated_types import Gt

from infinivar._core.described import derived, reported
from infinivar._core.fields import check_instance, check_number
from infinivar._core.result import Result, result
from infinivar.analysis.shared_motor import share_motor
from infinivar.displays.comparison import MARGIN, DisplayComparison, compare_displays
from infinivar.displays.handle_session import HandleSession, cobotic_part, geared_part
from infinivar.displays.kinds import AdmittanceDisplay, ImpedanceDisplay
from infinivar.displays.pair import CONVENTIONAL, FACTOR, DisplayPair, assumed_variants, display_choices, usual_rivals
from infinivar.displays.rounds import DISPLAYS, RESTING, STOPPED, TURNING, round_of
from infinivar.displays.stability import largest_force_gain, stiffest_wall
from infinivar.errors import require
from infinivar.motion.users import ArmModel
from infinivar.paper.claims.claim import Checked, Claim, Found, Kind, Variant, row, yes
from infinivar.study.load import shipped_study

_SIX = 6
"""Axes of the paper's display, as reconstructed: wheels on one cylinder for each axis of a hand."""

_DEFINITIONS: Mapping[str, str] = {
    STOPPED: "a cylinder that stops while idle",
    RESTING: "a cylinder that stops while idle and while a constant force is held",
}


_PARTS: Mapping[str, str] = {
    "free": "free motion",
    "contact": "contact",
    "hold": "holding",
    "explore": "exploring",
    "idle": "idling",
}


@result
class DisplayClaims(Result):
    """Verdicts on the paper's statements, as returned by `display_claims`.

    Attributes
    ----------
    claims : tuple of Claim           By `Claim.id`, H1 to H9; `infinivar.paper.claims.claim.Finding` describes the fields.
    comparison : DisplayComparison    The session with which some of them are evaluated, with one and six axes.
    """

    claims: tuple[Claim, ...] = reported()
    comparison: DisplayComparison = reported()

    def claim(self, name: str) -> Claim:
        """The claim of an id.

        Raises
        ------
        ParameterError
            If there is none; the message lists those known.
        """
        known = {one.id: one for one in self.claims}
        require(name in known, "name", repr(name), f"one of {', '.join(known)}")
        return known[name]

    @property
    def lines(self) -> tuple[str, ...]:
        """One line for each claim: id, place, claim, verdict, reason."""
        return tuple(f"{one.id} ({one.section}) {one.claim}: {one.verdict}. {one.why}" for one in self.claims)

    @derived()
    def verdict(self) -> str:
        """One sentence: the claims by verdict."""
        by: dict[str, list[str]] = {}
        for one in self.claims:
            by.setdefault(one.verdict, []).append(one.id)
        return "; ".join(f"{verdict}: {', '.join(names)}" for verdict, names in by.items())


def display_claims(
    session: HandleSession | None = None, *, arm: ArmModel | None = None, factor: float = FACTOR
) -> DisplayClaims:
    """Ask the paper's statements on dynamic range and electrical power of the shipped machine.

    Parameters
    ----------
    session : HandleSession   Whose energy is evaluated; by default one with all parts.
    arm : ArmModel            For stability; by default "vanbeek2015". Its values are varied as well.
    factor : float            By which assumed values are multiplied and divided, > 1.

    Returns
    -------
    DisplayClaims   Of reconstruction A, with B and other values of what the paper does not print as variants, against Motor 2 at
        4:1 on each axis.

    Raises
    ------
    ParameterError
        If an argument is out of range, or the shipped machine does not meet what the session requires.

    Source: faulring2006, abstract, section IV-B and section VII.
    """
    session = HandleSession() if session is None else session
    arm = ArmModel.named("vanbeek2015") if arm is None else arm
    check_instance("session", session, HandleSession)
    check_number("factor", factor, "1", Gt(1))
    drives: Any = shipped_study("faulring2006").drives
    pair = DisplayPair(cobotic=drives["cobotic"], conventional=drives["motor2-gear4"])
    pairs = {"as shown": pair, **assumed_variants(pair, {"reconstruction B": drives["cobotic-b"]}, factor=factor)}
    found = compare_displays(pair, session, arm=arm, axes=(1, _SIX), variants=dict(list(pairs.items())[1:]))
    require(
        bool(np.all(found.feasible[0])), "session", repr(session), "one whose requirement the shipped machine meets"
    )
    meets = {name: one for name, one, sound in zip(pairs, pairs.values(), found.feasible, strict=True) if np.all(sound)}
    others = [
        (f"arm {words}", compare_displays(pair, session, arm=one, axes=(1,))) for words, one in _arms(arm, factor)
    ]
    rivals = _rivals(pair, arm, float(found.least_mass[0, 0]))
    beside = _beside(pair, session, arm)
    chosen = {name: round_of(pair, one, (1, _SIX)) for name, one in _sessions(session, factor)}
    requested = {
        "H1": _holding(meets, session, _SIX),
        "H2": _holding(meets, session, 1),
        "H3": _session(found, _SIX, chosen),
        "H4": _session(found, 1, chosen),
        "H5": _clutched(meets, session),
        "H6": _backdrivable(found, others, meets, rivals, beside),
        "H7": _range(found, others, rivals, beside),
        "H8": _infinite(found),
        "H9": _motors(pair, drives["cobotic-b"]),
    }
    return DisplayClaims(
        claims=tuple(
            Claim(
                id=name,
                section=section,
                figure=None,
                claim=claim,
                paper=paper,
                unit=unit,
                **finding.settled()._asdict(),
            )
            for (name, finding), (section, claim, paper, unit) in zip(requested.items(), _STATED, strict=True)
        ),
        comparison=found,
    )


_STATED = (
    ("abstract", "A cobot resists high forces at very little electrical power: six axes", "very little", "W"),
    ("abstract", "A cobot resists high forces at very little electrical power: one axis", "very little", "W"),
    ("abstract", "A cobotic haptic display consumes little power: a session with six axes", "low", "J"),
    ("abstract", "A cobotic haptic display consumes little power: a session with one axis", "low", "J"),
    ("IV-B", "The device renders a completely clutched state", "complete", "mm/s"),
    ("VII", "It renders a highly backdrivable state", "highly", "kg"),
    ("VII", "Cobots raise the dynamic range of haptic devices", "increase", "1"),
    ("VII", "The dynamic range extends infinitely", "infinite", "1"),
    ("VII", "A cobot needs fewer and smaller high-power actuators", "reduced", "kg"),
)


def _holding(meets: Mapping[str, DisplayPair], session: HandleSession, axes: int) -> Checked:
    """Power while each axis holds the force required, against that of the conventional display."""
    held = replace(session, hold_force=session.required_force)

    def found(pair: DisplayPair, held: HandleSession = held) -> Found:
        mine = cobotic_part(pair.cobotic, held, "hold", axes=axes, handle_mass=pair.handle_mass).supply
        other = geared_part(
            pair.conventional,
            held,
            "hold",
            axes=axes,
            handle_mass=pair.handle_mass,
            friction_helps=pair.friction_helps,
        ).supply
        mine, other = mine + (axes + 1) * pair.standby_power, other + axes * pair.standby_power
        return Found(mine, f"below {other:.2f} W, of the conventional display", yes(mine < other))

    first, *rest = ((name, found(pair)) for name, pair in meets.items())
    shown = meets["as shown"]
    idle = cobotic_part(shown.cobotic, held, "idle", axes=axes, handle_mass=shown.handle_mass).supply
    standby = float(shown.cobotic.amplifier.standby_power)
    stopped = Found(standby, first[1].threshold, yes(True))
    why = (
        f"Holding {session.required_force:g} N on each axis takes {first[1].computed:.2f} W while the cylinder turns, of which "
        f"it needs {idle:.2f} W without a force; a cylinder at rest needs {standby:g} W."
    )
    variants = [row("value", name, one) for name, one in rest]
    variants += [
        row("value", f"required force {words}, {one.required_force:.3g} N", found(shown, one))
        for words, one in _forces(shown, held)
    ]
    return Checked(first[1], why, [*variants, row("definition", "a cylinder at rest while it holds", stopped)])


def _session(found: DisplayComparison, axes: int, chosen: Mapping[str, Mapping[str, np.ndarray]]) -> Checked:
    """Energy of a session against that of the conventional display."""
    count = found.axes.tolist().index(axes)

    def finding(total: np.ndarray, display: str) -> Found:
        mine, other = (float(total[DISPLAYS.index(name), count]) for name in (display, CONVENTIONAL))
        return Found(mine, f"below {other:.1f} J, of the conventional display", yes(mine < other))

    shown = finding(found.total[0], TURNING)
    variants = [
        row("value", name, finding(found.total[place], TURNING))
        for place, name in enumerate(found.assuming)
        if place and np.all(found.feasible[place, [0, -1], count])
    ]
    variants += [
        row("choice", name, finding(np.sum(one["energy"], axis=-1), TURNING))
        for name, one in chosen.items()
        if np.all(one["feasible"][[0, -1], count])
    ]
    variants += [row("definition", words, finding(found.total[0], name)) for name, words in _DEFINITIONS.items()]
    parts = dict(zip(found.parts, found.energy[0, 0, count], strict=True))
    most = max(parts, key=lambda name: parts[name])
    held = float(found.energy[0, -1, count, found.parts.index("hold")])
    why = (
        f"The turning cylinder costs {float(found.energy[0, 0, count, found.parts.index('idle')]):.1f} J while idle, when the "
        f"conventional display needs none; that one needs {held:.1f} J to hold. The largest part of the cobotic display is "
        f"{_PARTS[most]}, {parts[most]:.1f} J."
    )
    return Checked(shown, why, variants)


def _clutched(meets: Mapping[str, DisplayPair], session: HandleSession) -> Checked:
    """Speed of a link under the force required, with its wheel steered so that it holds."""
    force = session.required_force

    def turning(pair: DisplayPair, *, steered: bool) -> Found:
        element = pair.cobotic.transmission
        speed = {"cylinder_speed": float(pair.cobotic.cylinder_speed)}
        if steered:
            tangent = element.deliver(**speed, link_speed=0.0, link_force=-force).steering_tangent
            angle = float(np.arctan(np.asarray(tangent)))
        else:
            angle = 0.0
        drift = 1e3 * float(element.operate(**speed, steering_angle=angle, link_force=-force).link_speed)
        return Found(abs(drift) if abs(drift) > 1e-9 else 0.0, "0 mm/s", yes(abs(drift) <= 1e-9))

    shown = turning(meets["as shown"], steered=True)
    variants = [row("value", name, turning(pair, steered=True)) for name, pair in list(meets.items())[1:]]
    locked = turning(meets["as shown"], steered=False)
    variants += [
        row("definition", "a cylinder at rest", Found(0.0, shown.threshold, yes(True))),
        row("definition", "a wheel kept at the angle 0 while the cylinder turns", locked),
    ]
    why = (
        f"Under {force:g} N, a wheel steered by its slip angle holds the link still, as does a cylinder at rest; kept at the "
        f"angle 0, the link creeps at {locked.computed:.2f} mm/s. Beyond the slip limit nothing holds."
    )
    return Checked(shown, why, variants)


def _measured(
    found: DisplayComparison, others: list[tuple[str, DisplayComparison]]
) -> Iterator[tuple[str, DisplayComparison, int]]:
    """Variants that meet the requirement, with other arms, and where their measures are; the first is as shown."""
    for place, name in enumerate(found.assuming):
        if np.all(found.feasible[place, [0, -1]]):
            yield name, found, place
    for name, one in others:
        yield name, one, 0


_DAMPING = (30.0, 100.0, 300.0, 1000.0)
"""Wall dampings among which each display has the one that permits its stiffest wall. [N s m^-1]"""


class _Rival(NamedTuple):
    """A conventional display that pushes as hard as that shown."""

    words: str
    mass: float
    """Least mass felt. [kg]"""
    ratio: float
    """Stiffest wall over least mass felt, of the cobotic display over its own. [-]"""
    damped: float
    """That ratio with the damping that permits the stiffest wall of each."""


def _rivals(pair: DisplayPair, arm: ArmModel, least_mass: float) -> list[_Rival]:
    """That shown and others: without gear but with a larger motor, and with a force sensor as in the cobotic display."""

    def walls(display: AdmittanceDisplay | ImpedanceDisplay) -> np.ndarray:
        """Stiffest wall with the damping shown, and with any."""
        dampings = (pair.wall_damping, *_DAMPING)
        found = [stiffest_wall(replace(display, wall_damping=damping), arm) for damping in dampings]
        return np.array([found[0], np.nanmax(found)])

    ours = walls(pair.admittance(least_mass - pair.handle_mass)) / least_mass
    drive, found = pair.conventional, []
    motor = drive.motor.scaled(drive.gearhead.ratio)
    direct = replace(drive, motor=motor, gearhead=replace(drive.gearhead, ratio=1.0))
    for geared, words in ((drive, ""), (direct, "direct drive")):
        bare = replace(replace(pair, conventional=geared).impedance(), filter_frequency=pair.filter_frequency)
        stiffest, help_ = walls(bare), largest_force_gain(bare, arm) / MARGIN
        # A controller may leave the sensor out at the wall.
        helped = np.fmax(stiffest, walls(replace(bare, force_gain=help_)))
        for gain, wall, sensor in ((0.0, stiffest, ""), (help_, helped, "a force sensor")):
            mass = bare.reflected_mass / (1.0 + gain) + pair.handle_mass
            named = " and ".join(filter(None, (words, sensor)))
            found.append(_Rival(named, mass, *(float(one) for one in ours * mass / wall)))
    return found


_OF_EVERY = ("damping of the walls", "structure of every display")
"""Choices that concern what is felt, alike in every display."""


class _Beside(NamedTuple):
    """The cobotic display beside a conventional one of the same handle, sensor, damping, structure and delay."""

    words: str
    masses: tuple[float, float]
    """Least mass felt, cobotic and conventional. [kg]"""
    walls: tuple[float, float]
    """Stiffest wall at the handle. [N m^-1]"""

    @property
    def ratio(self) -> float:
        """Of stiffest wall over least mass. [-]"""
        return self.walls[0] / self.walls[1] * self.masses[1] / self.masses[0]


def _beside(pair: DisplayPair, session: HandleSession, arm: ArmModel) -> list[_Beside]:
    """Rivals as shown, and each conventional display with another damping or structure of all."""
    wide = replace(pair, rivals=usual_rivals(pair.conventional))
    choices = {name: one for name, one in display_choices(wide).items() if name.startswith(_OF_EVERY)}
    found = compare_displays(wide, session, arm=arm, axes=(1,), variants=choices)
    rows = []
    for place, name in enumerate(found.assuming):
        for side, rival in enumerate(found.names[1:], 1):
            words = [] if rival == CONVENTIONAL else [f"beside: {rival}"]
            words += [name] if place else []
            masses, walls = (tuple(one[place, [0, side]].tolist()) for one in (found.least_mass, found.stiffness))
            if words and np.all(np.isfinite([*masses, *walls])):
                rows.append(_Beside(", ".join(words), masses, walls))
    return rows


def _backdrivable(
    found: DisplayComparison,
    others: list[tuple[str, DisplayComparison]],
    meets: Mapping[str, DisplayPair],
    rivals: list[_Rival],
    beside: list[_Beside],
) -> Checked:
    """Least mass felt, against that of the conventional display."""

    def finding(one: DisplayComparison, place: int) -> Found:
        mine, other = one.least_mass[place]
        return Found(float(mine), f"below {other:.2f} kg, of the conventional display", yes(bool(mine < other)))

    (_, shown), *rest = ((name, finding(one, place)) for name, one, place in _measured(found, others))
    variants: list[Variant] = [row("value", name, one) for name, one in rest]
    pair = meets["as shown"]
    leg = pair.cobotic
    mass = float(leg.mass_of_link or math.nan) + pair.handle_mass
    groups = leg.transmission.groups(leg.cylinder_speed)
    drag = float(groups.rolling_force) + float(leg.guideway.friction_force(leg.transmission.preload))
    reflected, rubbing = float(found.least_mass[0, 1]), float(found.least_force[0, 1])
    words = f"below {reflected:.2f} kg and {rubbing:.1f} N, of the conventional display"
    free = Found(mass, words, yes(mass < reflected and drag < rubbing))
    variants.append(row("definition", "a decoupled wheel, along which the link rolls", free))
    felt = float(found.least_mass[0, 0])
    variants += [
        row(
            "choice",
            f"a conventional display with {rival.words}",
            Found(felt, f"below {rival.mass:.2f} kg, of the conventional display", yes(felt < rival.mass)),
        )
        for rival in rivals
        if rival.words
    ]
    for one in beside:
        mine, other = one.masses
        made = Found(mine, f"below {other:.2f} kg, of the conventional display", yes(mine < other))
        variants.append(row("choice", one.words, made))
    why = (
        f"With {found.arm} it lets feel {shown.computed:.2f} kg, and with the wheel decoupled {mass:.2f} kg and {drag:.2f} N of "
        f"friction. The conventional display reflects {reflected:.2f} kg and rubs with {rubbing:.1f} N, less what it feeds "
        "forward."
    )
    return Checked(shown, why, variants)


def _ratios(one: DisplayComparison, place: int) -> np.ndarray:
    """Stiffest wall over least mass felt, of both displays. (2,) [s^-2]"""
    return one.stiffness[place] / one.least_mass[place]


def _range(
    found: DisplayComparison,
    others: list[tuple[str, DisplayComparison]],
    rivals: list[_Rival],
    beside: list[_Beside],
) -> Checked:
    """Stiffest wall over least mass, cobotic over conventional."""

    def finding(one: DisplayComparison, place: int) -> Found:
        mine, other = _ratios(one, place)
        return Found(float(mine / other), "above 1, of the conventional display", yes(bool(mine > other)))

    (_, shown), *rest = ((name, finding(one, place)) for name, one, place in _measured(found, others))
    mine, other = found.stiffness[0] / 1e3
    why = (
        f"Stiffest wall over least mass felt, relative to the conventional display: {mine:.1f} N/mm and "
        f"{found.least_mass[0, 0]:.2f} kg against {other:.2f} N/mm and {found.least_mass[0, 1]:.2f} kg, with {found.arm}. The "
        "paper names no conventional display to compare with; both walls are damped alike, and no structure is stated."
    )
    variants = [row("value", name, one) for name, one in rest]
    for rival in rivals:
        other = [f"a conventional display with {rival.words}"] if rival.words else []
        for ratio, words in (
            (rival.ratio, other),
            (rival.damped, [*other, "both walls damped to be as stiff as possible"]),
        ):
            if words:
                made = Found(ratio, "above 1, of the conventional display", yes(ratio > 1.0))
                variants.append(row("choice", ", ".join(words), made))
    for one in beside:
        made = Found(one.ratio, "above 1, of the conventional display", yes(one.ratio > 1.0))
        variants.append(row("choice", one.words, made))
    return Checked(shown, why, variants)


def _infinite(found: DisplayComparison) -> Checked:
    """Whether stiffest over softest impedance has a limit."""
    decades = math.log10(float(_ratios(found, 0)[0]) / (2.0 * math.pi * 0.1) ** 2)
    shown = Found(decades, "infinite (decades at 0.1 Hz)", yes(False))
    locked: list[tuple[Kind, str, Found]] = [
        (
            "definition",
            "wheels locked on a cylinder at rest as the stiffest state, which has no stiffness in the model",
            Found("infinite", shown.threshold, yes(True)),
        )
    ]
    why = (
        f"A sampled wall is stable with {found.arm} up to a finite stiffness: {decades:.1f} decades of impedance at 0.1 Hz. The "
        "ratio of the transmission itself has no limit: locked on a cylinder at rest it yields nothing up to the slip limit."
    )
    return Checked(shown, why, [row(*one) for one in locked])


def _motors(pair: DisplayPair, other: Any) -> Checked:
    """Masses of the motors of six axes."""
    shared = [
        share_motor(leg, pair.conventional, force=[0.0], legs=(1, _SIX), duty=1.0) for leg in (pair.cobotic, other)
    ]

    def finding(place: int, count: int, *, cylinder: bool) -> Found:
        one = shared[place]
        mass = float(one.shared_mass[count]) + (float(one.cylinder_mass) if cylinder else 0.0)
        alone = float(one.separate_mass[count])
        return Found(mass, f"below {alone:.2f} kg, of a motor for each axis", yes(mass < alone))

    shown = finding(0, 1, cylinder=False)
    variants = [
        row("value", "reconstruction B", finding(1, 1, cylinder=False)),
        row("definition", "the cylinder counted as well", finding(0, 1, cylinder=True)),
        row("definition", "one axis", finding(0, 0, cylinder=False)),
        row("definition", "one axis, the cylinder counted as well", finding(0, 0, cylinder=True)),
    ]
    why = (
        f"One power motor and {_SIX} steering motors weigh {shown.computed:.2f} kg. The cylinder, an assumption, weighs "
        f"{float(shared[0].cylinder_mass):.2f} kg at least."
    )
    return Checked(shown, why, variants)


def _forces(pair: DisplayPair, session: HandleSession) -> Iterator[tuple[str, HandleSession]]:
    """Sessions in which another force is required and held, if both displays can."""
    motors = pair.motors.gain * pair.conventional.motor.continuous_current
    able = min(float(pair.cobotic.transmission.slip_force), float(motors))
    for words, scale in ((f"/ {FACTOR:g}", 1.0 / FACTOR), (f"x {FACTOR:g}", FACTOR)):
        force = scale * session.required_force
        if force < able:
            yield words, replace(session, required_force=force, hold_force=force)


def _sessions(session: HandleSession, factor: float) -> Iterator[tuple[str, HandleSession]]:
    """Sessions with more or less of one part, or with other forces up to that required."""
    for name in ("free", "contact", "hold", "explore"):
        for words, scale in ((f"{factor:g} times as much", factor), (f"1/{factor:g} as much", 1.0 / factor)):
            share = scale * getattr(session, name)
            if share > 0.0 and share - getattr(session, name) <= session.shares["idle"]:
                yield f"{words} {_PARTS[name]} in the session", replace(session, **{name: share})
    for name in ("contact_force", "hold_force", "explore_force"):
        for words, scale in ((f"x {factor:g}", factor), (f"/ {factor:g}", 1.0 / factor)):
            force = min(scale * getattr(session, name), max(session.required_force, getattr(session, name)))
            yield f"{name.replace('_', ' ')} {words}, {force:.3g} N", replace(session, **{name: force})


def _arms(arm: ArmModel, factor: float) -> Iterator[tuple[str, ArmModel]]:
    """The arm with other values: each of its three alone."""
    for name in ("mass", "damping", "stiffness"):
        for words, scale in ((f"{name} x {factor:g}", factor), (f"{name} / {factor:g}", 1.0 / factor)):
            yield words, replace(arm, **{name: scale * getattr(arm, name)})

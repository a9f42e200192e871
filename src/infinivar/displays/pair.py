"""A cobotic and a conventional display for the same handle, and the same pair with other values of what is assumed."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Literal

from annotated_types import Ge, Gt, Interval

from infinivar._core.fields import check_instance, check_number, check_real, component, quantity
from infinivar.displays.handle_session import check_displays
from infinivar.displays.kinds import AdmittanceDisplay, ImpedanceDisplay
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.errors import require
from infinivar.machines.motors import LinkMotors
from infinivar.parts.amplifier import Amplifier
from infinivar.study.choices import STANDBY, answers

YES_OR_NO = (
    "friction of the conventional display compensated",
    "friction of the conventional display helps to hold",
    "slip angle followed at the wall",
    "returned power stored",
)
"""Choices that are answered by yes or no, and by no as shown."""

WALL_DAMPINGS = (100.0, 400.0)
"""Compared with walls without damping. [N s m^-1]"""

_MODELS = ("steering model", "axle bearings", "bell bearing", "cylinder bearings", "gear friction")
"""Open choices of the cobotic drive that are varied; the creep law is the paper's."""

FACTOR = 1.5
"""Assumed values are varied by this factor either way."""


@dataclass(frozen=True, slots=True, kw_only=True)
class DisplayPair:
    """A cobotic and a conventional display for the same handle, with what no drive states.

    Raises
    ------
    ParameterError
        If a field is out of range, or a drive cannot be the axis of a display.
    """

    cobotic: CoboticDrive = component("One leg, with the motor of the common cylinder")
    conventional: ConventionalDrive = component("Drive of one axis")
    handle_mass: float = quantity("kg", Gt(0), "Mass of the handle on each axis", default=0.5)
    viscous_friction: float = quantity("N s/m", Ge(0), "Of the conventional display, at the handle", default=2.0)
    filter_frequency: float = quantity("Hz", Gt(0), "Of the force sensor of the cobotic display", default=100.0)
    compensation: float = quantity(
        "1",
        Interval(ge=0, le=1),
        "Share of its constant friction that the conventional display feeds forward",
        default=0.0,
    )
    friction_helps: bool = component("Whether friction of the conventional drive helps to hold", default=False)
    slip_feedforward: bool = component("Whether wheels at a wall follow the slip angle without pause", default=False)
    run_up_time: float = quantity("s", Gt(0), "Of a stopped cylinder", default=1.5)
    standby_power: float = quantity("W", Ge(0), "Of each amplifier, beside that of the drives", default=0.0)
    wall_damping: float = quantity("N s/m", Ge(0), "Of the virtual walls of both displays", default=0.0)
    cylinder: Literal["set", "least loss"] = component(
        "Speed of the cylinder: as set, or in each part of a session that of least loss, down to a fifth", default="set"
    )

    def __post_init__(self) -> None:
        """Validate the fields."""
        check_displays(self.cobotic, self.conventional)
        check_real(self)
        for name in ("friction_helps", "slip_feedforward"):
            value = getattr(self, name)
            require(isinstance(value, bool), name, repr(value), "true or false")
        require(self.cylinder in ("set", "least loss"), "cylinder", repr(self.cylinder), "set or least loss")

    @property
    def motors(self) -> LinkMotors:
        """Motors of the conventional display."""
        return LinkMotors(drive=self.conventional, stick_speed=1e-9)

    def admittance(self, mass: float, wall: float = 0.0) -> AdmittanceDisplay:
        """One axis of the cobotic display. The force sensor is at the link; the handle is beyond it."""
        return AdmittanceDisplay(
            drive=self.cobotic,
            virtual_mass=mass,
            wall_stiffness=wall,
            handle_mass=self.handle_mass,
            filter_frequency=self.filter_frequency,
            wall_damping=self.wall_damping,
        )

    def impedance(self) -> ImpedanceDisplay:
        """One axis of the conventional display."""
        return ImpedanceDisplay(
            drive=self.conventional,
            handle_mass=self.handle_mass,
            viscous_friction=self.viscous_friction,
            wall_damping=self.wall_damping,
        )


def assumed_variants(
    pair: DisplayPair, reconstructions: Mapping[str, CoboticDrive] | None = None, *, factor: float = FACTOR
) -> dict[str, DisplayPair]:
    """Pairs in which one assumed value differs at a time, of each reconstruction of the cobotic drive.

    Parameters
    ----------
    pair : DisplayPair             As shown.
    reconstructions : name to CoboticDrive   Other reconstructions of the same machine.
    factor : float                 By which values are multiplied and divided, > 1.

    Returns
    -------
    dict   What is assumed, to the pair; that shown is not among them.
    """
    check_instance("pair", pair, DisplayPair)
    check_number("factor", factor, "1", Gt(1))
    known = {} if reconstructions is None else dict(reconstructions)
    for name, drive in known.items():
        check_instance(f"reconstructions.{name}", drive, CoboticDrive)
    drives = {"": pair.cobotic, **{f"{name}, ": drive for name, drive in known.items()}}
    found = {name: replace(pair, cobotic=drive) for name, drive in known.items()}
    for prefix, drive in drives.items():
        here = replace(pair, cobotic=drive)
        for words, scale in ((f"x {factor:g}", factor), (f"/ {factor:g}", 1.0 / factor)):
            for name, change in _SCALED.items():
                found[f"{prefix}{name} {words}"] = change(here, scale)
        changed = (
            replace(here, compensation=1.0),
            replace(here, friction_helps=True),
            replace(here, slip_feedforward=True),
            _storing(here),
        )
        found |= {f"{prefix}{name}": one for name, one in zip(YES_OR_NO, changed, strict=True)}
        found |= {f"{prefix}{name}": one for name, one in display_choices(here).items()}
    return found


def display_choices(pair: DisplayPair) -> dict[str, DisplayPair]:
    """Pairs with another answer to one choice that no source settles, by "choice: answer".

    Models of the cobotic drive, the speed of its cylinder, standby per amplifier, and the damping of the walls of both displays.
    """
    found = {
        f"{choice}: {instead}": replace(pair, cobotic=drive)
        for choice, _, instead, drive in answers(pair.cobotic)
        if choice in _MODELS
    }
    found["cylinder speed: least loss in each part"] = replace(pair, cylinder="least loss")
    found[f"standby per amplifier: {STANDBY:g} W each"] = replace(pair, standby_power=STANDBY)
    for damping in WALL_DAMPINGS:
        found[f"damping of the walls: {damping:g} N s/m"] = replace(pair, wall_damping=damping)
    return found


def _pressed(pair: DisplayPair, scale: float) -> DisplayPair:
    return replace(pair, cobotic=pair.cobotic.pressed(scale * float(pair.cobotic.transmission.preload)))


def _rubbing(pair: DisplayPair, scale: float) -> DisplayPair:
    """With other friction of the steering."""
    steering, wheel = pair.cobotic.steering, pair.cobotic.transmission
    assert steering is not None
    bell = float(steering.friction_torques(wheel)["bell"]) / float(wheel.preload)
    changed = replace(
        steering, bell_bearing=None, bell_friction=scale * bell, sliding_friction=scale * steering.sliding_friction
    )
    return replace(pair, cobotic=replace(pair.cobotic, steering=changed))


def _guided(pair: DisplayPair, scale: float) -> DisplayPair:
    guideway = pair.cobotic.guideway
    changed = {name: scale * value for name in ("coefficient", "friction") if (value := getattr(guideway, name))}
    return replace(pair, cobotic=replace(pair.cobotic, guideway=replace(guideway, **changed)))


def _dragged(pair: DisplayPair, scale: float) -> DisplayPair:
    guideway = pair.conventional.guideway
    changed = {name: scale * value for name in ("coefficient", "friction") if (value := getattr(guideway, name))}
    return replace(pair, conventional=replace(pair.conventional, guideway=replace(guideway, **changed)))


def _storing(pair: DisplayPair) -> DisplayPair:
    def stored(amplifier: Amplifier) -> Amplifier:
        return replace(amplifier, regeneration="store", storage_efficiency=1.0)

    return replace(
        pair,
        cobotic=replace(pair.cobotic, amplifier=stored(pair.cobotic.amplifier)),
        conventional=replace(pair.conventional, amplifier=stored(pair.conventional.amplifier)),
    )


_SCALED: Mapping[str, Callable[[DisplayPair, float], DisplayPair]] = {
    "preload": _pressed,
    "steering friction": _rubbing,
    "guideway friction": _guided,
    "drag of the conventional display": _dragged,
    "handle mass": lambda pair, scale: replace(pair, handle_mass=scale * pair.handle_mass),
    "viscous friction of the conventional display": lambda pair, scale: replace(
        pair, viscous_friction=scale * pair.viscous_friction
    ),
    "filter frequency": lambda pair, scale: replace(pair, filter_frequency=scale * pair.filter_frequency),
    "run-up time": lambda pair, scale: replace(pair, run_up_time=scale * pair.run_up_time),
}

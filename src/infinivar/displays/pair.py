"""A cobotic display and conventional ones for the same handle, and the same with other values of what is assumed."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal

from annotated_types import Ge, Gt, Interval

from infinivar._core.fields import check_instance, check_number, check_real, component, given, quantity
from infinivar._core.frozen import FrozenDict
from infinivar.displays.handle_session import check_displays
from infinivar.displays.kinds import RIGID, AdmittanceDisplay, ImpedanceDisplay
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.errors import require
from infinivar.machines.motors import LinkMotors
from infinivar.parts.linear import Guideway
from infinivar.study.choices import STANDBY, answers

CONVENTIONAL = "conventional"
"""Name of the conventional display of a pair."""

YES_OR_NO = (
    "friction of the conventional display compensated",
    "friction of the conventional display helps to hold",
    "slip angle followed at the wall",
    "returned power stored",
)
"""Choices that are answered by yes or no, and by no as shown."""

WALL_DAMPINGS = (0.0, 400.0)
"""Compared with walls that are damped as shown. [N s m^-1]"""

STRUCTURES: Mapping[str, tuple[float, float | None]] = {
    "1000 N/mm": (1e6, None),
    "100 N/mm": (1e5, None),
    "100 N/mm with 100 N s/m": (1e5, 100.0),
    "10 N/mm": (1e4, None),
}
"""Compared with a structure as shown: stiffness and damping, by default 0.05 of critical. [N m^-1], [N s m^-1]"""

CABLE_FRICTION, CABLE_STIFFNESS = 0.1, 3.5e3
"""At the handle of a desktop display with cable transmission: friction [N], and stiffness with locked motors [N m^-1].

Source: massie1994.
"""

_MODELS = ("steering model", "axle bearings", "bell bearing", "cylinder bearings", "gear friction")
"""Open choices of the cobotic drive that are varied; the creep law is the paper's."""

FACTOR = 1.5
"""Assumed values are varied by this factor either way."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Rival:
    """A conventional display beside that of a pair, with the same handle, sensor, wall damping, sampling and delay.

    Raises
    ------
    ParameterError
        If a field is out of range.
    """

    drive: ConventionalDrive = component("Drive of one axis")
    force_control: bool = component(
        "Whether it measures the force and moves as a virtual mass, as the cobotic display does", default=False
    )
    structure_stiffness: float | None = quantity(
        "N/m", Gt(0), "Between encoder and handle; default: that of the pair", default=None
    )
    source: str = component("Where the values come from that differ from those of the pair", default="assumed")

    def __post_init__(self) -> None:
        """Validate the fields."""
        check_instance("drive", self.drive, ConventionalDrive)
        check_real(self)
        require(isinstance(self.force_control, bool), "force_control", repr(self.force_control), "true or false")

    @property
    def motors(self) -> LinkMotors:
        """Motors of the axes."""
        return LinkMotors(drive=self.drive, stick_speed=1e-9)


@dataclass(frozen=True, slots=True, kw_only=True)
class DisplayPair:
    """A cobotic and a conventional display for the same handle, further rivals, and what no drive states.

    All have the same handle, force sensor with its filter, wall damping and delay. What differs: `differences`.

    Raises
    ------
    ParameterError
        If a field is out of range, or a drive cannot be the axis of a display.
    """

    cobotic: CoboticDrive = component("One leg, with the motor of the common cylinder")
    conventional: ConventionalDrive = component("Drive of one axis")
    handle_mass: float = quantity("kg", Gt(0), "Mass of the handle on each axis", default=0.5)
    viscous_friction: float = quantity("N s/m", Ge(0), "Of conventional displays, at the drive", default=2.0)
    filter_frequency: float = quantity("Hz", Gt(0), "Of the force sensor, where a display has one", default=100.0)
    structure_stiffness: float | None = quantity(
        "N/m",
        Gt(0),
        "Between encoder and handle of every display; default: that of the drive, else rigid",
        default=None,
    )
    structure_damping: float | None = quantity(
        "N s/m", Ge(0), "Beside structure and sensor of every display; default: 0.05 of critical", default=None
    )
    sensor_stiffness: float | None = quantity(
        "N/m", Gt(0), "Of the force sensor, where a display has one; default: rigid", default=None
    )
    force_noise: float = quantity("N", Ge(0), "Of the force sensor: the least force that it resolves", default=0.0)
    encoder_resolution: float = quantity(
        "m", Ge(0), "Travel at the output for one count, of every display", default=0.0
    )
    samples_late: Literal[0, 1] = component("Samples by which every controller acts late", default=1)
    rivals: Mapping[str, Rival] = component("Further conventional displays, by name", default_factory=FrozenDict)
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
    wall_damping: float = quantity("N s/m", Ge(0), "Of the virtual walls of every display", default=100.0)
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
        check_instance("rivals", self.rivals, Mapping)
        for name, rival in self.rivals.items():
            check_instance(f"rivals.{name}", rival, Rival)
            check_displays(self.cobotic, rival.drive)
        object.__setattr__(self, "rivals", FrozenDict(self.rivals))

    @property
    def conventionals(self) -> Mapping[str, Rival]:
        """The conventional display and its rivals, by name."""
        return {CONVENTIONAL: Rival(drive=self.conventional), **self.rivals}

    @property
    def motors(self) -> LinkMotors:
        """Motors of the conventional display."""
        return self.conventionals[CONVENTIONAL].motors

    @property
    def differences(self) -> tuple[str, ...]:
        """What is not the same for every display, in words, beside the drive itself."""
        rates = {"cobotic": self.cobotic.control.sample_rate}
        rates |= {name: one.drive.control.sample_rate for name, one in self.conventionals.items()}
        said = [f"sample rate of {name}: {rate:g} Hz" for name, rate in rates.items() if rate != rates["cobotic"]]
        said += [
            f"structure of {name}: {one.structure_stiffness:g} N/m"
            for name, one in self.conventionals.items()
            if one.structure_stiffness not in (None, self.structure_stiffness)
        ]
        each = {"cobotic": self.admittance(1.0), **{name: self.rival(name, 1.0) for name in self.conventionals}}
        rigid = [name for name, one in each.items() if one.carried_by == RIGID]
        said += [f"structure {RIGID}: {', '.join(rigid)}"] if rigid else []
        sensed = ["cobotic", *(name for name, one in self.conventionals.items() if one.force_control)]
        return (*said, f"force sensor: {', '.join(sensed)}")

    @property
    def _same(self) -> dict[str, Any]:
        """What every display has."""
        names = (
            "handle_mass",
            "wall_damping",
            "structure_stiffness",
            "structure_damping",
            "encoder_resolution",
            "samples_late",
        )
        return {name: getattr(self, name) for name in names}

    @property
    def _sensor(self) -> dict[str, Any]:
        """What every display with a force sensor has."""
        return {name: getattr(self, name) for name in ("filter_frequency", "sensor_stiffness", "force_noise")}

    def admittance(self, mass: float, wall: float = 0.0) -> AdmittanceDisplay:
        """One axis of the cobotic display. The force sensor is at the link; the handle is beyond it."""
        return AdmittanceDisplay(
            drive=self.cobotic, virtual_mass=mass, wall_stiffness=wall, **self._same, **self._sensor
        )

    def impedance(self) -> ImpedanceDisplay:
        """One axis of the conventional display."""
        found = self.rival(CONVENTIONAL, 1.0)
        assert isinstance(found, ImpedanceDisplay)
        return found

    def rival(self, name: str, mass: float) -> AdmittanceDisplay | ImpedanceDisplay:
        """One axis of a conventional display; the virtual mass is that of one with force control."""
        one = self.conventionals[name]
        same = {
            **self._same,
            "drive": one.drive,
            "viscous_friction": self.viscous_friction,
            "structure_stiffness": given(one.structure_stiffness, self.structure_stiffness),
        }
        if one.force_control:
            return AdmittanceDisplay(**same, **self._sensor, virtual_mass=mass)
        friction = sum(one.motors.frictions) * (1.0 - self.compensation)
        return ImpedanceDisplay(**same, coulomb_friction=friction)


def usual_rivals(drive: ConventionalDrive) -> dict[str, Rival]:
    """Conventional displays that push as hard as one does: without gear, with a cable, and with the same force control.

    Parameters
    ----------
    drive : ConventionalDrive   Of the conventional display.

    Returns
    -------
    dict   *direct drive*: as many more motors on one shaft as the gear reduced, without gear. *cable drive*: the same motor and
        ratio by a capstan without backlash and gear loss; friction and stiffness are those stated of a desktop display, which
        pushes with a fifth of the force. *with a force sensor*: the drive itself, moved as a virtual mass.

    Source: massie1994 for the cable.
    """
    check_instance("drive", drive, ConventionalDrive)
    free = {"efficiency": 1.0, "loss_model": "coulomb"}
    direct = replace(
        drive,
        motor=drive.motor.scaled(drive.gearhead.ratio),
        gearhead=replace(drive.gearhead, name="none", ratio=1.0, inertia=None, **free),
    )
    cable = replace(
        drive, gearhead=replace(drive.gearhead, name="capstan", **free), guideway=Guideway(friction=CABLE_FRICTION)
    )
    return {
        "direct drive": Rival(drive=direct, source="assumed: motors in parallel, without gear"),
        "cable drive": Rival(
            drive=cable, structure_stiffness=CABLE_STIFFNESS, source="massie1994: friction and stiffness; else assumed"
        ),
        "with a force sensor": Rival(drive=drive, force_control=True, source="assumed: sensor of the cobotic display"),
    }


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

    Models of the cobotic drive, the speed of its cylinder, standby per amplifier, and damping of the walls and structure of every
    display.
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
    for words, values in STRUCTURES.items():
        found[f"structure of every display: {words}"] = _carried(pair, *values)
    return found


def _carried(pair: DisplayPair, stiffness: float, damping: float | None) -> DisplayPair:
    rivals = {name: replace(one, structure_stiffness=None) for name, one in pair.rivals.items()}
    return replace(pair, structure_stiffness=stiffness, structure_damping=damping, rivals=FrozenDict(rivals))


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
    def dragged(drive: ConventionalDrive) -> ConventionalDrive:
        changed = {
            name: scale * value for name in ("coefficient", "friction") if (value := getattr(drive.guideway, name))
        }
        return replace(drive, guideway=replace(drive.guideway, **changed))

    return _each(pair, dragged)


def _each(pair: DisplayPair, change: Callable[[ConventionalDrive], ConventionalDrive]) -> DisplayPair:
    """With a change to the drive of every conventional display."""
    rivals = {name: replace(one, drive=change(one.drive)) for name, one in pair.rivals.items()}
    return replace(pair, conventional=change(pair.conventional), rivals=FrozenDict(rivals))


def _storing(pair: DisplayPair) -> DisplayPair:
    def stored(drive: Any) -> Any:
        return replace(drive, amplifier=replace(drive.amplifier, regeneration="store", storage_efficiency=1.0))

    return replace(_each(pair, stored), cobotic=stored(pair.cobotic))


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

"""A package of somebody else that extends the program: built in a folder, installed as far as Python can tell."""

import sys

CODE = '''
from dataclasses import dataclass, replace

import numpy as np
from annotated_types import Ge, Gt

import infinivar as iv

K = 0.25


def creepage(x):
    xp = iv.array_namespace(x)
    return x + K * x * xp.abs(x)


def slope(x):
    xp = iv.array_namespace(x)
    return 1.0 + 2.0 * K * xp.abs(x)


def force(xi):
    xp = iv.array_namespace(xi)
    xi = xp.clip(xi, -1.0 - K, 1.0 + K)
    return 2.0 * xi / (1.0 + xp.sqrt(1.0 + 4.0 * K * xp.abs(xi)))


SOFT = iv.contact.CreepLaw(name="soft", creepage=creepage, slope=slope, force=force, slip_creepage=1.0 + K)
MAGNETS = iv.Limit.own("MAGNETS", 100, "demagnetisation")


@dataclass(frozen=True, slots=True, kw_only=True)
class OiledGearhead(iv.parts.Gearhead):
    """Gearhead whose lubricant drags in proportion to the speed of the motor."""

    drag: float = iv.quantity("N m s", Ge(0), "Friction torque at the motor over its speed", default=0.0)

    def operate(self, *, output_torque, output_speed, motor_rated_torque):
        dry = iv.parts.Gearhead.operate(
            self, output_torque=output_torque, output_speed=output_speed, motor_rated_torque=motor_rated_torque
        )
        friction = self.drag * dry.motor_speed
        return replace(dry, motor_torque=dry.motor_torque + friction, loss=dry.loss + friction * dry.motor_speed)


@dataclass(frozen=True, slots=True, kw_only=True)
class VoiceCoil:
    """Linear motor that moves the load directly."""

    constant: float = iv.quantity("N/A", Gt(0), "Force over current")
    resistance: float = iv.quantity("ohm", Gt(0), "Resistance of the coil")
    coil_mass: float = iv.quantity("kg", Gt(0), "Mass of the coil")
    largest_force: float = iv.quantity("N", Gt(0), "Force at which the magnets begin to lose their magnetisation")
    guideway: iv.parts.Guideway = iv.component("Guideway", default_factory=iv.parts.Guideway)

    def __post_init__(self):
        iv.check_fields(self)

    def operate(self, *, speed, force):
        winding = (force / self.constant) ** 2 * self.resistance + 0.0 * speed
        electric = winding + force * speed
        return iv.drivetrain.DrivePoint(
            power_in=np.maximum(electric, 0.0),
            power_out=force * speed,
            losses={"winding": winding, "amplifier": np.maximum(-electric, 0.0)},
            utilisation={MAGNETS: np.abs(force) / self.largest_force},
        )

    def follow(self, course, *, load_mass=0.0):
        total = course.driving_force(load_mass + self.coil_mass).value
        point = self.operate(speed=course.speed, force=total)
        return iv.drivetrain.MovingPoint(
            power_in=point.power_in,
            power_out=course.driving_force(load_mass).value * course.speed,
            losses=point.losses,
            stored={"coil": self.coil_mass * course.acceleration * course.speed},
            utilisation={(MAGNETS, "coil"): np.abs(total) / self.largest_force},
            states={},
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class TwoTones(iv.motion.PeriodicMotion):
    """A sinusoid, and one of three times its frequency."""

    shape = "two-tones"
    distance: float = iv.quantity("m", Gt(0), "Amplitude of the slow sinusoid")
    ripple: float = iv.quantity("m", Ge(0), "Amplitude of the fast sinusoid", default=0.0)
    frequency: float = iv.quantity("Hz", Gt(0), "Frequency of the slow sinusoid")

    @property
    def period(self):
        return 1.0 / self.frequency

    @property
    def fastest(self):
        return 3.0 * self.frequency

    def derivatives(self, time, orders):
        turn = 2.0 * np.pi * self.frequency
        tones = ((self.distance, turn), (self.ripple, 3.0 * turn))
        return [
            sum(size * rate**order * np.sin(rate * time + 0.5 * np.pi * order) for size, rate in tones)
            for order in range(orders + 1)
        ]


@dataclass(frozen=True, slots=True, kw_only=True)
class Once:
    """A motion that does not repeat."""

    def at(self, time):
        return (0.0, 0.0, 0.0)

    @property
    def breaks(self):
        return ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Bare:
    """A drive whose field says nothing."""

    x: float

    def operate(self, *, speed, force):
        return None
'''

WORDS = """
[infinivar.creep_laws]
soft = {0}:SOFT

[infinivar.parts]
oiled = {0}:OiledGearhead

[infinivar.drives]
voice-coil = {0}:VoiceCoil

[infinivar.motions]
two-tones = {0}:TwoTones
once = {0}:Once

[infinivar.limits]
magnets = {0}:MAGNETS
"""


def install(folder, monkeypatch, words=WORDS, code=CODE, package="mylab"):
    """Make a package importable, with its entry points, while a test runs."""
    monkeypatch.syspath_prepend(folder)
    (folder / f"{package}.py").write_text(code, "utf-8")
    about = folder / f"{package}-1.2.dist-info"
    about.mkdir()
    (about / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {package}\nVersion: 1.2\n", "utf-8")
    (about / "entry_points.txt").write_text(words.format(package), "utf-8")
    monkeypatch.delitem(sys.modules, package, raising=False)

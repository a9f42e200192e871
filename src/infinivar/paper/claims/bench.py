"""Two drives that shake a mass: dynamic maps for judging claims, and the values that the paper leaves open."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from infinivar._core.frozen import FrozenDict
from infinivar.analysis.cycles.performance import PAPER, Definition
from infinivar.analysis.cycles.shaking import DynamicMap
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.drivetrain.drive import needed
from infinivar.drivetrain.steering import SteeringPlant
from infinivar.paper.claims.claim import Found, PaperMachine, Variant, either_way
from infinivar.paper.claims.planes import Cells, Scale, plane_map
from infinivar.parts.linear import Guideway


class Pair(NamedTuple):
    """Maps of the two drives that Fig 17 compares, and the scale of the frequency axis."""

    cobotic: DynamicMap
    conventional: DynamicMap
    frequency_axis: Scale = "logarithmic"

    @property
    def weight(self) -> np.ndarray:
        """Relative area of each cell; the frequencies are equally spaced in their logarithm."""
        steps = self.cobotic.frequency if self.frequency_axis == "linear" else np.ones_like(self.cobotic.frequency)
        return np.broadcast_to(steps[:, None], self.cobotic.works.shape)

    @property
    def below(self) -> np.ndarray:
        """Cells below 10 Hz and above 10 % of the maximum power in which at least one drive works."""
        plane = (self.cobotic.frequency < 10.0)[:, None] & (self.cobotic.fraction > 0.1)[None, :]
        return plane & (self.cobotic.works | self.conventional.works)

    def mean(self, values: np.ndarray, where: np.ndarray) -> float:
        """Area-weighted mean over the selected cells; nan if none is selected."""
        weight = self.weight[where]
        return float(np.average(np.asarray(values)[where], weights=weight)) if weight.size else float("nan")

    def median(self, values: np.ndarray, where: np.ndarray) -> float:
        """Area-weighted median over the selected cells; nan if none is selected."""
        known, weight = np.asarray(values)[where], self.weight[where]
        if not known.size:
            return float("nan")
        order = np.argsort(known)
        reached = np.cumsum(weight[order])
        return float(known[order][np.searchsorted(reached, 0.5 * reached[-1])])


class Bench(NamedTuple):
    """A cobotic and a conventional drive, and the mass that they shake."""

    cobotic: CoboticDrive
    conventional: ConventionalDrive
    power: float
    load_mass: float

    @classmethod
    def of(cls, machine: PaperMachine, name: str = "cobotic") -> Bench:
        """The bench with one of the machine's cobotic drives and the Motor 2 drive."""
        return cls(machine.cobotic(name), machine.conventional("motor2-gear4"), machine.power, machine.load_mass)

    def moved(self, parameter: str, factor: float) -> Bench:
        """The bench with one parameter multiplied by a factor."""
        return MOVES[parameter].move(self, factor)

    def pair(
        self,
        definition: Definition = PAPER,
        *,
        cells: Cells = "coarse",
        power_axis: Scale = "linear",
        frequency_axis: Scale = "logarithmic",
    ) -> Pair:
        """Dynamic maps of both drives."""
        cobotic, conventional = (
            plane_map(drive, self.power, self.load_mass, definition, cells, power_axis)
            for drive in (self.cobotic, self.conventional)
        )
        return Pair(cobotic, conventional, frequency_axis)


class Move(NamedTuple):
    """A value that the paper leaves open: its name and unit, how to read it from a bench, and how to multiply it by a factor."""

    words: str
    unit: str
    value: Callable[[Bench], float]
    move: Callable[[Bench, float], Bench]


def _steering(drive: CoboticDrive) -> SteeringPlant:
    return needed(drive.steering, "steering")


def _with_cobotic(change: Callable[[CoboticDrive, float], CoboticDrive]) -> Callable[[Bench, float], Bench]:
    return lambda bench, factor: bench._replace(cobotic=change(bench.cobotic, factor))


def _with_conventional(
    change: Callable[[ConventionalDrive, float], ConventionalDrive],
) -> Callable[[Bench, float], Bench]:
    return lambda bench, factor: bench._replace(conventional=change(bench.conventional, factor))


def steering_inertia(drive: CoboticDrive) -> float:
    """Inertia of bell and steering motor about the steering axis. [kg m^2]"""
    steering = _steering(drive)
    return steering.inertia_of_bell + steering.ratio**2 * needed(steering.motor.rotor_inertia, "rotor_inertia")


def with_steering_inertia(drive: CoboticDrive, factor: float) -> CoboticDrive:
    """The drive with the inertia of bell and steering motor multiplied by a factor."""
    steering = _steering(drive)
    motor = replace(steering.motor, rotor_inertia=factor * needed(steering.motor.rotor_inertia, "rotor_inertia"))
    return replace(drive, steering=replace(steering, motor=motor, bell_inertia=factor * steering.inertia_of_bell))


def bell_friction(drive: CoboticDrive) -> float:
    """Friction torque of the bell bearing. [N m]"""
    return float(_steering(drive).friction_torques(drive.transmission)["bell"])


def with_bell_friction(drive: CoboticDrive, factor: float) -> CoboticDrive:
    """The drive with the friction of its bell bearing multiplied by a factor."""
    arm = factor * bell_friction(drive) / drive.transmission.preload
    return replace(drive, steering=replace(_steering(drive), bell_bearing=None, bell_friction=arm))


def patch_friction(drive: CoboticDrive) -> float:
    """Torque to turn the contact patch on the spot, from its size and sliding friction. [N m]"""
    return float(_steering(drive).friction_torques(drive.transmission)["patch"])


def with_patch_friction(drive: CoboticDrive, factor: float) -> CoboticDrive:
    """The drive with the torque to turn the contact patch multiplied by a factor."""
    steering = _steering(drive)
    return replace(drive, steering=replace(steering, sliding_friction=factor * steering.sliding_friction))


def with_link_mass(drive: CoboticDrive, factor: float) -> CoboticDrive:
    """The drive with its link mass multiplied by a factor."""
    return replace(drive, link_mass=factor * needed(drive.mass_of_link, "link_mass"))


def with_link_drag(drive: CoboticDrive, factor: float) -> CoboticDrive:
    """The drive with the friction of the link guideway multiplied by a factor."""
    guide = drive.guideway
    return replace(drive, guideway=Guideway(friction=factor * guide.friction, coefficient=factor * guide.coefficient))


def with_cylinder_radius(drive: CoboticDrive, factor: float) -> CoboticDrive:
    """The drive with its cylinder radius multiplied by a factor, at the same cylinder speed."""
    element = drive.transmission
    return replace(drive, transmission=replace(element, cylinder_radius=factor * element.cylinder_radius))


def with_drag(drive: ConventionalDrive, factor: float) -> ConventionalDrive:
    """The drive with the drag at its load multiplied by a factor."""
    return replace(drive, guideway=Guideway(friction=factor * drive.guideway.friction))


MOVES: Mapping[str, Move] = FrozenDict(
    {
        "steering_inertia": Move(
            "inertia about the steering axis",
            "kg m^2",
            lambda bench: steering_inertia(bench.cobotic),
            _with_cobotic(with_steering_inertia),
        ),
        "link_mass": Move(
            "link mass of the cobotic drive",
            "kg",
            lambda bench: needed(bench.cobotic.mass_of_link, "link_mass"),
            _with_cobotic(with_link_mass),
        ),
        "bell_friction": Move(
            "friction torque of the bell bearing",
            "N m",
            lambda bench: bell_friction(bench.cobotic),
            _with_cobotic(with_bell_friction),
        ),
        "drag": Move(
            "drag at the load of the conventional drive",
            "N",
            lambda bench: bench.conventional.guideway.friction,
            _with_conventional(with_drag),
        ),
        "patch_friction": Move(
            "torque to turn the contact patch",
            "N m",
            lambda bench: patch_friction(bench.cobotic),
            _with_cobotic(with_patch_friction),
        ),
        "link_drag": Move(
            "drag of the cobotic drive's link",
            "N",
            lambda bench: (
                bench.cobotic.guideway.friction
                + bench.cobotic.guideway.coefficient * bench.cobotic.transmission.preload
            ),
            _with_cobotic(with_link_drag),
        ),
        "preload": Move(
            "preload of the wheel",
            "N",
            lambda bench: bench.cobotic.transmission.preload,
            _with_cobotic(lambda drive, factor: drive.pressed(factor * drive.transmission.preload)),
        ),
        "cylinder_radius": Move(
            "radius of the cylinder",
            "m",
            lambda bench: bench.cobotic.transmission.cylinder_radius,
            _with_cobotic(with_cylinder_radius),
        ),
        "output_inertia": Move(
            "inertia of the conventional drive's gear and pulley",
            "kg m^2",
            lambda bench: needed(bench.conventional.output_inertia, "output_inertia"),
            _with_conventional(
                lambda drive, factor: replace(
                    drive, output_inertia=factor * needed(drive.output_inertia, "output_inertia")
                )
            ),
        ),
        "load_mass": Move(
            "mass of the load",
            "kg",
            lambda bench: bench.load_mass,
            lambda bench, factor: bench._replace(load_mass=factor * bench.load_mass),
        ),
        "power": Move(
            "maximum power of the requirement",
            "W",
            lambda bench: bench.power,
            lambda bench, factor: bench._replace(power=factor * bench.power),
        ),
    }
)
"""Values that the paper does not print, by name."""

TRACED = ("steering_inertia", "link_mass", "bell_friction", "drag")
"""Values for which the report states the range over which a verdict stays the same."""


def demands(machine: PaperMachine, found: Callable[[PaperMachine], Found], *keys: str) -> Iterator[Variant]:
    """Findings with each value of the requirement varied by `FACTOR`, one at a time: the paper prints none of them."""
    for key in keys or ("force", "speed", "power"):
        yield from either_way(f"required {key}", lambda factor, key=key: found(machine.demanding(key, factor)))

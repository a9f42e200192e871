"""Resonances of springs between motor and load that a sampled speed loop excites instead of damping them."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from typing import NamedTuple

from infinivar._core.fields import given
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.drivetrain.graphs import bandwidths
from infinivar.motion.duty_cycles import DutyCycle
from infinivar.motion.scenario import Scenario
from infinivar.parts.spring import Spring, TorsionSpring
from infinivar.units import plain


class Resonance(NamedTuple):
    """Resonance of a spring between motor and load."""

    name: str
    """Of the spring."""
    locked: float
    """Frequency with the motor locked. [Hz]"""
    free: float
    """Frequency with a free motor, which is that of a loop much slower than it. [Hz]"""
    sample_rate: float
    """Of the controllers. [Hz]"""

    @property
    def excited(self) -> bool:
        r"""Whether the sampled speed loop feeds energy into the resonance.

        The loop holds a torque proportional to minus the motor speed over each sample of time T. Of a speed at frequency f,
        the hold passes the share sinc(f T) with a delay of T/2; the part in phase with the speed, which damps, is
        ``sinc(f T) cos(pi f T) = sin(2 pi f T)/(2 pi f T)``. It is positive below half the sample rate, and negative from
        there up to the sample rate; then it repeats, smaller.

        Source: franklin1998, zero-order hold.
        """
        return math.sin(2.0 * math.pi * self.free / self.sample_rate) < 0.0

    def __str__(self) -> str:
        """What it means for a simulation."""
        return (
            f"caution: the {self.name} resonates at {plain(self.free, 3)} Hz ({plain(self.locked, 3)} Hz with the motor locked), "
            f"beyond half the sample rate of {plain(self.sample_rate, 4)} Hz, where the sampled controllers can excite it; "
            "raise control.sample_rate, or leave out a spring this stiff"
        )


def warnings(drive: object, scenario: Scenario) -> tuple[str, ...]:
    """What the resonances of a drive mean for its simulation under control; empty if nothing."""
    found = [str(one) for one in excited(drive, scenario)]
    if isinstance(drive, ConventionalDrive) and scenario.link != "free":
        start, imposed = scenario.path.at(0.0).position, scenario.link == "imposed"
        found.insert(0, str(bandwidths.of(drive, start, scenario.moved_mass, imposed=imposed)))
    return tuple(filter(None, found))


def caution(drive: object, duty: DutyCycle) -> str:
    """Why the loops of a drive are unstable with the load of a duty cycle; "" if they are not, or cannot be simulated."""
    if not isinstance(drive, ConventionalDrive) or drive.motor.rotor_inertia is None:
        return ""
    found = bandwidths.of(drive, float(duty.at(0.0)[0]), duty.moved_mass)
    return str(found) if found.unstable else ""


def excited(drive: object, scenario: Scenario) -> tuple[Resonance, ...]:
    """Resonances that the controllers of a conventional drive excite, by name of the spring.

    Each spring is taken alone, the others as rigid, a progressive one at its steepest. Not judged are drives with a linkage,
    whose ratio varies, and cobotic drives, whose controllers do not measure the speed behind the spring.
    """
    if not isinstance(drive, ConventionalDrive) or drive.output.linkage is not None or scenario.link == "free":
        return ()
    return tuple(one for one in _resonances(drive, scenario) if one.excited)


def _resonances(drive: ConventionalDrive, scenario: Scenario) -> Iterator[Resonance]:
    travel, gear = drive.stage.travel_per_radian, drive.gearhead
    # Masses at the output of the stage; a load that is moved by an external agent does not yield.
    load = math.inf if scenario.link == "imposed" else scenario.moved_mass
    rotor = (given(drive.motor.rotor_inertia, 0.0) + given(gear.inertia, 0.0)) * (gear.ratio / travel) ** 2
    stage = given(drive.gear_output_inertia, 0.0) / travel**2
    rate = drive.control.sample_rate
    springs = [
        (place.name, _steepest(place.part), load, rotor + stage)
        for place in drive.chain
        if place.kind == "series" and isinstance(place.part, (Spring, TorsionSpring))
    ]
    if gear.torsion is not None:
        springs.append(("gearhead", gear.torsion.steepest / travel**2, load + stage, rotor))
    for name, stiffness, outer, inner in springs:
        if outer > 0.0 and inner > 0.0:
            locked, free = (
                math.sqrt(stiffness * share) / (2.0 * math.pi) for share in (1 / outer, 1 / outer + 1 / inner)
            )
            yield Resonance(name, locked, free, rate)


def _steepest(spring: Spring | TorsionSpring) -> float:
    """Largest stiffness of a spring; of a table, that between its rows. [N/m], [N m/rad]"""
    if spring.deflections is None or spring.forces is None:
        return given(spring.stiffness, 0.0)
    rows = list(zip(spring.deflections, spring.forces, strict=True))
    return max((f1 - f0) / (x1 - x0) for (x0, f0), (x1, f1) in itertools.pairwise(rows))

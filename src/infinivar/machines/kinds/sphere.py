"""A sphere between rollers as a drive: a motor turns shaft 1 at a constant speed, the steering angle sets that of shaft 2."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar

import numpy as np
from annotated_types import Gt, Interval

from infinivar._core.array_namespace import Array
from infinivar._core.bounds import FINITE, NonZero
from infinivar._core.fields import brief, check, check_real, component, given, quantity, several
from infinivar.drivetrain.control import CoboticControl
from infinivar.drivetrain.drive import DrivePoint, motor_side, needed, placed
from infinivar.drivetrain.steering import SteeringPlant
from infinivar.errors import ParameterError
from infinivar.limits import Demand, Limit
from infinivar.machines import bonds
from infinivar.machines.course import MachineCourse
from infinivar.machines.kind import MachineDrive, MovingMachine, motor_of, servo_of
from infinivar.machines.machine import TaskPoint, rows
from infinivar.machines.motors import PowerMotor, SteeringServo
from infinivar.machines.pictures import rollers
from infinivar.machines.pictures.strokes import Picture
from infinivar.machines.rolling import ROLLING_LOSSES, RollingState, judged, slip_demands
from infinivar.machines.system import Defaults, Forces, Place
from infinivar.machines.wheel import Wheel
from infinivar.motion.histories import VectorHistory
from infinivar.motion.machine_scenario import MachineScenario
from infinivar.parts.amplifier import Amplifier
from infinivar.parts.gearhead import Gearhead
from infinivar.parts.motor import Motor
from infinivar.transmission.driven_contact import DrivenContact
from infinivar.transmission.rolling_contact import RollingContact
from infinivar.transmission.sphere_layout import LayoutName, Roller
from infinivar.transmission.spherical import SphericalIVT, SphericalPoint

_STEPS = 20
_CLOSE = 1e-9
"""Error of the output speed, over the speed of shaft 1, at which the search for the steering angle ends."""

_SLOWEST = 2.5e-3
"""Speed of shaft 2, over that of shaft 1, below which static friction of its roller leaves the operation indeterminate."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RollerPlace:
    """Where one roller touches the sphere, and the direction of its axle; a roller without an axle is steered."""

    x: float = quantity("1", FINITE, "Unit vector from the centre of the sphere to the roller, along x", default=0.0)
    y: float = quantity("1", FINITE, "Along y", default=0.0)
    z: float = quantity("1", FINITE, "Along z", default=0.0)
    axle_x: float | None = quantity("1", FINITE, "Unit vector along a fixed axle, along x", default=None)
    axle_y: float | None = quantity("1", FINITE, "Along y", default=None)
    axle_z: float | None = quantity("1", FINITE, "Along z", default=None)
    shaft: float | None = quantity("1", Interval(ge=1, le=2), "Shaft of a drive roller: 1 or 2", default=None)

    def __post_init__(self) -> None:
        """Validate the fields."""
        check_real(self)
        _ = self.roller

    @property
    def roller(self) -> Roller:
        """The roller; vectors are scaled to length 1."""
        axle = (self.axle_x, self.axle_y, self.axle_z)
        steered = all(part is None for part in axle)
        if self.shaft is not None and self.shaft not in (1.0, 2.0):
            raise ParameterError(f"shaft must be 1 or 2, got {self.shaft:g}")
        shaft = None if self.shaft is None else 1 if self.shaft == 1.0 else 2
        return Roller(
            position=_scaled("x, y and z", (self.x, self.y, self.z)),
            axis=None if steered else _scaled("axle_x, axle_y and axle_z", tuple(part or 0.0 for part in axle)),
            shaft=shaft,
        )


_POINT_BY_LAW = "creepage by the creep law, without spin"

_KEPT = 16
"""Operations of a transmission that are kept: drives that differ in motor, gearhead or amplifier share them."""

_steered: dict[Any, tuple[np.ndarray, SphericalPoint]] = {}


def _scaled(names: str, vector: tuple[float, ...]) -> tuple[float, ...]:
    length = sum(part * part for part in vector) ** 0.5
    if not length > 0.0:
        raise ParameterError(f"{names} must not all be 0")
    return tuple(part / length for part in vector)


@dataclass(frozen=True, slots=True, kw_only=True)
class SphereMechanics(Defaults):
    """A sphere between rollers and two shafts with their inertias; one steering angle turns all steered rollers.

    The configuration is the angles of the shafts.
    """

    ivt: SphericalIVT
    shaft_inertias: tuple[float, float]
    sphere_inertia: float
    stick_speed: float
    coordinates: tuple[str, ...] = ("w_1_rad_s", "w_2_rad_s", "sphere_x_rad_s", "sphere_y_rad_s", "sphere_z_rad_s")
    configuration: tuple[str, ...] = ("shaft_1_rad", "shaft_2_rad")
    steered: tuple[str, ...] = ("gamma_rad",)
    losses: tuple[str, ...] = ROLLING_LOSSES

    @property
    def inertia(self) -> np.ndarray:
        """Mass matrix of shafts and sphere. (5, 5)"""
        return np.diag([*self.shaft_inertias, *[self.sphere_inertia] * 3])

    @property
    def demands(self) -> tuple[tuple[Limit, str], ...]:
        """Slip of each roller."""
        return slip_demands(len(self.ivt.kinds), "roller")

    def at(self, configuration: np.ndarray, rates: np.ndarray) -> Place:
        """Constant inertia."""
        return Place(rates[:, :2], np.broadcast_to(self.inertia, (len(rates), 5, 5)), 0.0 * rates, None)

    def act(self, place: Place, rates: np.ndarray, angles: np.ndarray, turning: np.ndarray) -> Forces:
        """Forces of the rollers, and what resists the rolling of those on fixed axles."""
        found, exerted, losses, turned = self.ivt.moving(
            rates, angles[:, 0], turning[:, 0] if np.ndim(turning) else 0.0, self.stick_speed
        )
        return Forces(exerted, turned[:, None], *judged(losses, found.slip_demand))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SphereMachine(MovingMachine):
    """A sphere between rollers with a source on shaft 1 and a load or user on shaft 2.

    Raises
    ------
    ParameterError
        If a field is out of range.
    """

    ivt: SphericalIVT = component("The transmission")
    input_inertia: float = quantity("kg m^2", Gt(0), "Inertia of shaft 1 with its rollers, without a motor")
    output_inertia: float = quantity("kg m^2", Gt(0), "Inertia of shaft 2 with its rollers and load")
    sphere_inertia: float = quantity("kg m^2", Gt(0), "Inertia of the sphere about its centre")
    motor: Motor | None = component("Motor on shaft 1", default=None)
    gearhead: Gearhead | None = component("Its gearhead", default=None)
    amplifier: Amplifier = component("Amplifier of the motor", default_factory=Amplifier)
    input_speed: float = quantity("rad/s", NonZero(), "Speed of shaft 1, if the motor holds it", default=1.0)
    steering: SteeringPlant | None = component("Servo of the steering", default=None)
    control: CoboticControl = component("Controllers", default_factory=CoboticControl)

    driven: ClassVar[str] = "shaft_1"

    def __post_init__(self) -> None:
        """Validate the fields."""
        check(self)

    @property
    def home(self) -> np.ndarray:
        """Angles of the shafts at the start."""
        return np.zeros(2)

    @property
    def set_speed(self) -> float:
        """Speed of the motor's coordinate. [rad s^-1]"""
        return self.input_speed

    def mechanics(self, stick_speed: float) -> SphereMechanics:
        """Contacts and inertia."""
        return SphereMechanics(
            ivt=self.ivt,
            shaft_inertias=(self.input_inertia, self.output_inertia),
            sphere_inertia=self.sphere_inertia,
            stick_speed=stick_speed,
        )

    def servo(self, stick_speed: float) -> SteeringServo:
        """Servo of the steering."""
        return servo_of(self.steering, self.ivt.steering, self.amplifier, stick_speed)

    def power_motor(self, stick_speed: float) -> PowerMotor | None:
        """Motor of shaft 1."""
        return motor_of(self.motor, self.gearhead, self.amplifier, 0, stick_speed / self.ivt.drive.wheel_radius)

    @property
    def contacts(self) -> Sequence[RollingContact]:
        """The rollers."""
        return self.ivt.patches()

    def bonds(self, stick_speed: float) -> bonds.Bonds:
        """Shafts and sphere, and rollers."""
        named = (
            ("shaft_1", "w_1", "J_1", "shaft"),
            ("shaft_2", "w_2", "J_2", "shaft"),
            *((f"sphere_{axis}", rf"\Omega_{axis}", "J_s", "sphere") for axis in "xyz"),
        )
        turning = [
            bonds.Coordinate(name, symbol, f"J_{name}", letter, "kg m^2", title)
            for name, symbol, letter, title in named
        ]
        ports = [one.name for one in turning]
        body = bonds.inertias(turning, self.mechanics(stick_speed).inertia)
        return bonds.Bonds.of(body, bonds.rollers(self.ivt, ports, stick_speed), bonds.user(ports[:2]))

    def roll(self, rates: np.ndarray, angles: np.ndarray) -> np.ndarray:
        """Of shafts and sphere."""
        return self.ivt.rolling_rates(float(angles[0]), self.set_speed)


@dataclass(frozen=True, slots=True, kw_only=True)
class SphereDrive(MachineDrive):
    """A motor on shaft 1 of a sphere between rollers; shaft 2 moves a joint, at any ratio of either sign."""

    WORD: ClassVar[str] = "sphere"
    shown: ClassVar[str] = (
        ": the rollers in their places, and their forces on the sphere. A steered roller has its axle along that part of the "
        "axis of the sphere which is tangential there."
    )

    motor: Motor = component("Motor of shaft 1")
    gearhead: Gearhead = component("Gearhead between motor and shaft 1")
    input_speed: float = quantity("rad/s", NonZero(), "Constant speed of shaft 1")
    sphere_radius: float = quantity("m", Gt(0), "Radius of the sphere")
    layout: LayoutName | None = component(
        "Positions of the rollers: tetrahedral or cubic; tetrahedral if no rollers are given", default=None
    )
    rollers: tuple[RollerPlace, ...] | None = several(
        "Positions of the rollers, instead of a layout", RollerPlace, default=None
    )
    roller: Wheel = component("Drive rollers")
    steering_roller: Wheel | None = component("Steered rollers; like the drive rollers if not given", default=None)
    idler: Wheel | None = component("Idlers of the cubic layout; like the drive rollers if not given", default=None)
    amplifier: Amplifier = component("Amplifier of the motor", default_factory=Amplifier)
    input_inertia: float | None = quantity(
        "kg m^2", Gt(0), "Inertia of shaft 1 with its rollers, without motor and gearhead, for simulation", default=None
    )
    output_inertia: float | None = quantity(
        "kg m^2", Gt(0), "Inertia of shaft 2 with its rollers, without a load, for simulation", default=None
    )
    sphere_inertia: float | None = quantity(
        "kg m^2", Gt(0), "Inertia of the sphere about its centre, for simulation", default=None
    )
    transmission: SphericalIVT = field(init=False, repr=False, compare=False, default=None)  # type: ignore[assignment]

    __repr__ = brief

    def __post_init__(self) -> None:
        """Validate the fields and make the transmission."""
        check(self)
        contacts = {}
        for key, name in (("roller", "drive"), ("steering_roller", "steering"), ("idler", "idler")):
            wheel = getattr(self, key)
            if wheel is not None:
                try:
                    contacts[name] = wheel.on("sphere", self.sphere_radius)
                except ParameterError as problem:
                    raise ParameterError(f"{key}.{problem}") from None
        if self.layout is not None and self.rollers is not None:
            raise ParameterError("layout and rollers exclude each other: rollers state the positions")
        places = None if self.rollers is None else tuple(one.roller for one in self.rollers)
        layout = given(self.layout, "tetrahedral")
        made = SphericalIVT(sphere_radius=self.sphere_radius, layout=layout, rollers=places, **contacts)
        if self.idler is not None and "idler" not in made.kinds:
            raise ParameterError("idler does not apply: no roller has a fixed axle and no shaft; remove it")
        object.__setattr__(self, "transmission", made)

    @property
    def commands(self) -> tuple[str, ...]:
        """Commands that work besides those of all machines."""
        return ("simulate", "size")

    @property
    def coordinates(self) -> tuple[str, ...]:
        """The angle of shaft 2."""
        return ("angle",)

    @property
    def home(self) -> tuple[float, ...]:
        """0; nothing depends on it."""
        return (0.0,)

    def moving(self, load_mass: float = 0.0, load_inertia: float = 0.0) -> SphereMachine:
        """The sphere and its shafts with their inertias, and that of a load, for `infinivar.simulate_machine`.

        Parameters
        ----------
        load_mass, load_inertia : float   Of the load on shaft 2; a joint has no mass, only inertia. [kg], [kg m^2]

        Raises
        ------
        ParameterError
            If an inertia that motion requires is missing, or there is a mass.
        """
        if load_mass:
            raise ParameterError(
                f"load_mass must be 0 for a joint, got {load_mass:g} kg: state load_inertia about the joint"
            )
        return SphereMachine(
            ivt=self.transmission,
            input_inertia=needed(self.input_inertia, "input_inertia"),
            output_inertia=needed(self.output_inertia, "output_inertia") + load_inertia,
            sphere_inertia=needed(self.sphere_inertia, "sphere_inertia"),
            motor=self.motor,
            gearhead=self.gearhead,
            amplifier=self.amplifier,
            input_speed=self.input_speed,
        )

    def turned(self, point: TaskPoint, wrench: np.ndarray) -> tuple[float, SphericalPoint]:
        """Steering angle at one operating point under a torque on the load (1,), and the operation of the transmission. [rad]"""
        angle = float(point.states["steering_angle_rad"])
        torque = float(np.asarray(wrench)[0])
        found = self.transmission.operate(steering_angle=angle, input_speed=self.input_speed, output_torque=torque)
        return angle, found

    def picture(self, point: TaskPoint, pose: np.ndarray, twist: np.ndarray, wrench: np.ndarray) -> Picture:
        """The sphere between its rollers."""
        return rollers.picture(self.transmission, self.turned(point, wrench)[1])

    def rolling(self, point: TaskPoint, twist: np.ndarray, wrench: np.ndarray) -> Iterator[RollingState]:
        """Yield the state of each roller; its creepage is that of the law, as spin shares in the slip."""
        angle, found = self.turned(point, wrench)
        for index, (kind, wheel) in enumerate(zip(found.kinds, self.transmission.patches(), strict=True)):
            groups = wheel.groups(self.sphere_radius * float(np.linalg.norm(found.sphere_velocity)))
            driven = kind == "drive"
            if driven and isinstance(wheel, DrivenContact):
                groups = groups._replace(creep_stiffness=groups.creep_stiffness * wheel.stiffness_ratio)
            force, demand = float(found.roller_forces[index]), float(found.slip_demand[index])
            share = force / groups.slip_force
            creepage = math.nan
            if demand <= 1.0 and abs(share) < 1.0:
                creepage = float(groups.formulas(wheel.creep_law).creepage(share)) / groups.creep_group
            yield RollingState(
                name=f"{kind} roller {found.kinds[: index + 1].count(kind)}",
                law=wheel.creep_law,
                groups=groups,
                lateral_force=force,
                creepage=creepage,
                slip_demand=demand if math.isfinite(demand) else math.inf,
                contact=wheel.contact,
                preload=wheel.preload,
                notes=(("steering angle", angle), ("note", _POINT_BY_LAW)),
                along=driven,
            )

    def scenario(
        self, machine: SphereMachine, time: np.ndarray, pose: np.ndarray, wrench: np.ndarray, closed: bool
    ) -> MachineScenario:
        """Shaft 2 follows angles (t, 1) under torques on the load (t, 1) by prescribed steering angles: those of steady operation
        with the inertia of shaft 2; closed: whether half of it settles.

        Raises
        ------
        ParameterError
            If a roller slips.
        """
        moves = VectorHistory(time=time, values=pose)
        speed = np.array([moves.rate(float(one))[0] for one in time])
        torque = machine.output_inertia * np.array([moves.acceleration(float(one))[0] for one in time]) + wrench[:, 0]
        angle, point = self.steer(speed, torque)
        if not np.all(np.isfinite(angle)):
            raise ParameterError("a roller of the sphere slips: no steering angle gives the motion")
        steering = VectorHistory(time=time, values=angle[:, None])
        shafts = np.concatenate([0.0 * wrench, wrench], axis=-1)
        return MachineScenario(
            duration=float(time[-1]),
            steering=steering,
            servos=False,
            rates=[self.input_speed, float(speed[0]), *np.asarray(point.sphere_velocity)[0]],
            wrench=VectorHistory(time=time, values=shafts, smooth=False) if np.any(shafts) else None,
            settling_time=0.5 * float(time[-1]) if closed else None,
        )

    def steer(self, speed: Array, torque: Array) -> tuple[np.ndarray, SphericalPoint]:
        """Steering angle at which shaft 2 turns at a speed under a torque on its load, and the operation there.

        Parameters
        ----------
        speed, torque : (...,) float   [rad s^-1], [N m]

        Returns
        -------
        angle, point   nan where a roller would slip. [rad]

        Notes
        -----
        The angle without creep is corrected by the speed that creep costs, which depends little on the angle: a contraction,
        accelerated by the secant rule. It passes through shaft 2 at rest, where the steering angle is near a quarter turn.
        """
        required, load = np.broadcast_arrays(np.asarray(speed, dtype=float), np.asarray(torque, dtype=float))
        key = (self.transmission, float(self.input_speed), required.shape, required.tobytes(), load.tobytes())
        known = _steered.get(key)
        if known is None:
            known = _steered[key] = self._steer(required, load)
            while len(_steered) > _KEPT:
                _steered.pop(next(iter(_steered)), None)
        return known

    def _steer(self, required: np.ndarray, load: np.ndarray) -> tuple[np.ndarray, SphericalPoint]:
        first, second = self.transmission.ideal_speeds(np.array([0.5 * np.pi, 0.0]))
        lever = float(second[1] / first[0])

        def angle_of(ideal: np.ndarray) -> np.ndarray:
            # w_1/w_2 = tan(gamma)/lever; gamma in (0, pi), so that shaft 1 turns as given.
            return np.arctan2(abs(self.input_speed) * lever, ideal * np.sign(self.input_speed))

        def off(ideal: np.ndarray) -> tuple[np.ndarray, SphericalPoint]:
            point = self.transmission.operate(
                steering_angle=angle_of(ideal), input_speed=self.input_speed, output_torque=load
            )
            return np.asarray(point.output_speed) - required, point

        ideal = required.copy()
        error, point = off(ideal)
        before, last = ideal, error
        ideal = ideal - np.where(np.isfinite(error), error, 0.0)
        for _ in range(_STEPS):
            error, point = off(ideal)
            if np.all(~(np.abs(error) > _CLOSE * abs(self.input_speed))):
                break
            rise, run = error - last, ideal - before
            slope = np.where(np.abs(rise) > 0, run / np.where(np.abs(rise) > 0, rise, 1.0), 1.0)
            step = np.where(np.isfinite(slope) & (slope > 0.2) & (slope < 5.0), slope, 1.0) * error
            before, last = ideal, error
            ideal = ideal - np.where(np.isfinite(step), step, 0.0)
        return angle_of(ideal), point

    def _in_motion(self, speed: np.ndarray, torque: np.ndarray) -> np.ndarray:
        """Speeds, where near rest in the slowest motion whose friction does not help to hold the torque."""
        slowest = _SLOWEST * abs(self.input_speed)
        way = np.where(speed != 0.0, np.sign(speed), np.where(torque < 0.0, -1.0, 1.0))
        return np.where(np.abs(speed) < slowest, way * slowest, speed)

    def _driven(self, angle: np.ndarray, point: SphericalPoint, turning: Array = 0.0) -> DrivePoint:
        """Motor, gearhead and amplifier behind an operation of the transmission and a further torque on shaft 1."""
        side = motor_side(
            self.motor,
            self.gearhead,
            output_torque=np.asarray(point.input_torque) + turning,
            output_speed=np.full(angle.shape, float(self.input_speed)),
        )
        power_in, burnt, returned = self.amplifier.supply(side.power)
        return DrivePoint(
            power_in=power_in,
            power_out=point.power_out,
            losses={**side.losses, "amplifier": burnt, **point.losses},
            utilisation={**point.utilisation, **side.utilisation, **returned},
            states={**side.states, "steering_angle_rad": angle},
        )

    def perform(self, *, pose: Array, twist: Array, wrench: Array) -> TaskPoint:
        """As `infinivar.machines.machine.Machine.perform`.

        At rest, and slower than 1/400 of shaft 1, the losses are those at that speed: static friction of the roller on shaft 2
        leaves them indeterminate.
        """
        _, xi, load = rows(self, pose, twist, wrench)
        return self._point(xi[..., 0], load[..., 0])

    @property
    def lacking(self) -> Mapping[str, str]:
        """What of its motion `follow` does not count, with the reason."""
        names = [name for name in ("output_inertia", "sphere_inertia") if getattr(self, name) is None]
        moves = {"moving masses": f"{names[0]} is missing"} if names else {}
        return {"steering": "that of a sphere is not modelled", **moves}

    def counts(self, course: MachineCourse) -> bool:
        """Whether `follow` counts more than `perform`: what accelerates."""
        return course.accelerates

    def follow(self, course: MachineCourse) -> TaskPoint:
        r"""Operation along a course with the inertias of shaft 2 and of the sphere.

        Shaft 1 keeps its speed. The sphere turns with :math:`w_2 = k_2\,\Omega_p` about the axis p of shaft 2, so that its energy
        changes with the power :math:`I\,w_2\,\dot w_2/k_2^2`, which shaft 1 delivers.

        Source: Euler; `SphericalIVT.ideal_speeds` for k_2.
        """
        speed, load = np.broadcast_arrays(course.twist[2, ..., 0], course.wrench[2, ..., 0])
        rise = np.broadcast_to(course.acceleration[2, ..., 0], speed.shape)
        shaft = given(self.output_inertia, 0.0) * rise
        ratio = float(self.transmission.ideal_speeds(0.0)[1])
        sphere = given(self.sphere_inertia, 0.0) / ratio**2 * speed * rise
        found = self._point(speed, load + shaft, sphere / self.input_speed)
        return replace(
            found, power_out=found.power_out - shaft * speed, stored={"shaft 2": shaft * speed, "sphere": sphere}
        )

    def _point(self, speed: np.ndarray, torque: np.ndarray, turning: Array = 0.0) -> TaskPoint:
        """Operation at speeds and torques on the load, with a further torque on shaft 1: (...,) each."""
        moving = self._in_motion(speed, torque)
        angle, point = self.steer(moving, torque)
        found = self._driven(angle, point, turning)
        # What the slowest motion delivers beyond the required one is not drawn either.
        beyond = np.where(moving == speed, 0.0, found.power_out - torque * speed)
        shape = speed.shape
        kinds = self.transmission.kinds
        parts = tuple(f"{kind} roller {kinds[: place + 1].count(kind)}" for place, kind in enumerate(kinds))
        demands: dict[Demand, np.ndarray] = {
            (Limit.SLIP, part): np.asarray(point.slip_demand)[..., place] for place, part in enumerate(parts)
        }
        own = {limit: demand for limit, demand in found.utilisation.items() if limit not in point.utilisation}
        demands |= {key: np.broadcast_to(demand, shape) for key, demand in placed(own).items()}
        demands |= {(limit, "roller"): np.broadcast_to(demand, shape) for limit, demand in point.pressed.items()}
        return TaskPoint(
            power_in=np.broadcast_to(found.power_in - beyond, shape),
            power_out=np.broadcast_to(found.power_out - beyond, shape),
            losses={name: np.broadcast_to(loss, shape) for name, loss in found.losses.items()},
            demands=demands,
            parts=parts,
            part_losses=sum(np.asarray(loss) for loss in point.roller_losses.values()),
            part_forces=np.asarray(point.roller_forces),
            part_speeds=np.full((*shape, len(parts)), np.nan),
            steering=np.where(np.array([kind == "steering" for kind in kinds]), angle[..., None], np.nan),
            states={name: np.broadcast_to(value, shape) for name, value in found.states.items()},
        )

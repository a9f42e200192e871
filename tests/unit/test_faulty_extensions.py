"""Own parts, drives and motions that are wrong: what is refused, and what the message says."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from annotated_types import Ge

import infinivar as iv

SHAKE = iv.DutyCycle(motion=iv.motion.Sinusoid(distance=0.02, frequency=2.0), load_mass=0.8)


@dataclass(frozen=True, slots=True, kw_only=True)
class Magic(iv.parts.Gearhead):
    """Leaves out a constant torque: over a symmetric cycle that adds up to nothing."""

    gain: float = iv.quantity("N m", Ge(0), "Torque left out", default=0.001)

    def operate(self, *, output_torque, output_speed, motor_rated_torque):
        true = iv.parts.Gearhead.operate(
            self, output_torque=output_torque, output_speed=output_speed, motor_rated_torque=motor_rated_torque
        )
        return replace(true, motor_torque=true.motor_torque - self.gain)


@pytest.mark.parametrize("gain", [1e-8, 0.001, 0.05])
def test_the_balance_of_a_part_closes_at_each_instant(study, gain):
    drive = study.drives["motor1-gear1"]
    machine = replace(drive, gearhead=Magic(ratio=drive.gearhead.ratio, efficiency=0.9, gain=gain))
    with pytest.raises(
        iv.AuditError, match="power_in differs from power_out, losses and stored powers together by up to"
    ):
        iv.duty_cycle(machine, SHAKE)


@pytest.mark.parametrize("name", ["motor1-gear1", "cobotic"])
def test_the_parts_of_the_program_close_at_each_instant(study, name):
    point = iv.duty_cycle(study.drives[name], SHAKE).point
    missing = point.power_in - point.power_out - sum(point.losses.values()) - sum(point.stored.values())
    assert np.max(np.abs(missing)) < 1e-12 * np.max(np.abs(point.power_in))


class Coil:
    """A voice coil whose operating point can be changed."""

    coil = 0.3

    def __init__(self, **changed):
        self.changed = changed

    def _values(self, force, power_out, speed):
        winding = (force / 18.0) ** 2 * 1.4 + 0.0 * speed
        needed = winding + force * speed
        return {
            "power_in": np.maximum(needed, 0.0),
            "power_out": power_out,
            "losses": {"winding": winding, "amplifier": np.maximum(-needed, 0.0)},
            "states": {},
        }

    def operate(self, *, speed, force):
        values = {**self._values(force, force * speed, speed), "utilisation": {iv.Limit.SPEED: np.abs(speed)}}
        change = self.changed.get("operate", lambda values: {})
        return iv.drivetrain.DrivePoint(**{**values, **change(values)})

    def follow(self, course, *, load_mass=0.0):
        force = course.driving_force(load_mass + self.coil).value
        out = course.driving_force(load_mass).value * course.speed
        stored = {"coil": self.coil * course.acceleration * course.speed}
        values = self._values(force, out, course.speed) | {"stored": stored}
        values["utilisation"] = {(iv.Limit.SPEED, "coil"): np.abs(course.speed)}
        change = self.changed.get("follow", lambda values: {})
        return iv.drivetrain.MovingPoint(**{**values, **change(values)})


def changed(values, name, **items):
    return {name: {**values[name], **items}}


REFUSED = {
    "nan": (
        lambda v: {"utilisation": {key: np.nan * one for key, one in v["utilisation"].items()}},
        r"utilisation of SPEED.* must be a demand over its allowance, >= 0, got nan",
    ),
    "negative": (
        lambda v: {"utilisation": {key: -one - 0.1 for key, one in v["utilisation"].items()}},
        r"utilisation of SPEED.* must be a demand over its allowance, >= 0, got -",
    ),
    "complex": (lambda v: {"power_in": v["power_in"] + 0j}, "power_in must be real numbers, got complex numbers"),
    "text": (
        lambda v: changed(v, "losses", winding="a lot"),
        r"losses\['winding'\] must be real numbers, got 'a lot'",
    ),
    "failure": (lambda v: {"power_in": 1 / 0}, "fails with ZeroDivisionError: division by zero; expected"),
}


def _required(drive):
    return iv.Study(name="m", requirement=iv.Requirement(force=40.0, speed=0.8), drives={"c": drive})


@pytest.mark.parametrize("name", REFUSED)
@pytest.mark.filterwarnings("error")
def test_what_an_own_drive_cannot_return(name):
    change, words = REFUSED[name]
    with pytest.raises(iv.ParameterError, match=rf"^Coil\.operate.*{words}"):
        iv.compare(_required(Coil(operate=change)), quick=True)
    with pytest.raises(iv.ParameterError, match=rf"^Coil\.follow.*{words}"):
        iv.duty_cycle(Coil(follow=change), SHAKE)


def test_the_own_drive_itself_is_sound():
    assert iv.compare(_required(Coil()), quick=True).results["c"].audit_residual < 1e-12
    assert iv.duty_cycle(Coil(), SHAKE).closure < 1e-12


def test_other_names_of_arguments_are_told():
    class Positional:
        def operate(self, pace, push):
            return None

    message = (
        r"Positional\.operate fails with TypeError: .*expected operate\(\*, speed, force\), which returns a DrivePoint"
    )
    with pytest.raises(iv.ParameterError, match=message) as caught:
        iv.steady_map(Positional(), [0.1], [1.0])
    assert isinstance(caught.value.__cause__, TypeError)


class TupleGear(iv.parts.Gearhead):
    def operate(self, *, output_torque, output_speed, motor_rated_torque):
        return output_torque, output_speed


class OtherGear(iv.parts.Gearhead):
    def operate(self, *, torque, speed):
        return None


class BrokenGear(iv.parts.Gearhead):
    def operate(self, *, output_torque, output_speed, motor_rated_torque):
        return {}["loss"]


class LooseGuide:
    def friction_force(self, preload=0.0):
        return 0.0

    def operate(self, *, force, speed, preload=0.0):
        return 0.0


@pytest.mark.parametrize(
    ("part", "words"),
    [
        ({"gearhead": TupleGear}, r"TupleGear\.operate must return a GearPoint, got a tuple"),
        (
            {"gearhead": OtherGear},
            r"part OtherGear fails with TypeError: .*output_torque.*expected the methods of Gearhead",
        ),
        (
            {"gearhead": BrokenGear},
            r"BrokenGear\.operate fails with KeyError: 'loss'; expected operate\(output_torque, ",
        ),
        (
            {"guideway": LooseGuide},
            r"part LooseGuide fails with TypeError.*expected the methods of the part that it repl",
        ),
    ],
)
def test_a_part_that_fails_is_named(study, part, words):
    drive = study.drives["motor1-gear1"]
    own = {key: kind(ratio=5.0, efficiency=0.9) if key == "gearhead" else kind() for key, kind in part.items()}
    with pytest.raises(iv.ParameterError, match=words):
        iv.duty_cycle(replace(drive, **own), SHAKE)
    with pytest.raises(iv.ParameterError, match=words):
        iv.steady_map(replace(drive, **own), [0.1], [1.0])


@dataclass(frozen=True, kw_only=True)
class Wobble(iv.motion.PeriodicMotion):
    shape = "wobble"
    fault: str = "none"
    period = 1.0
    fastest = 3.0

    def derivatives(self, time, orders):
        return None if self.fault == "none" else [time][orders]


@pytest.mark.parametrize(
    ("fault", "words"),
    [
        ("none", r"Wobble\.derivatives must return 5 values for 4 orders, .*; got a NoneType"),
        ("fails", r"Wobble\.derivatives\(time, orders\) fails with IndexError: .*; expected 5 values for 4 orders"),
    ],
)
def test_a_motion_that_fails_is_named(study, fault, words):
    with pytest.raises(iv.ParameterError, match=words):
        iv.duty_cycle(study.drives["motor1-gear1"], iv.DutyCycle(motion=Wobble(fault=fault), load_mass=0.8))

"""Benches of friction: a motor without load, screws and worms over speed, and a strain-wave gear over the rotor's angle."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from infinivar._core.array_namespace import Array
from infinivar.calibration.bench import Parameter
from infinivar.calibration.geared import motor_with
from infinivar.calibration.measured.law import At, Form, Law, Term
from infinivar.parts.gear_friction import stribeck_factor
from infinivar.parts.motor import Motor

_BARE = Motor(voltage=1e3, resistance=1e-3, torque_constant=1.0, no_load_current=0.0, continuous_torque=1.0)
"""A motor whose voltage and resistance do not matter here."""

_EITHER_WAY = (-1.0, 1.0)
_TWO_TURNS = (-4.0 * math.pi, 4.0 * math.pi)

WAVES = 4
"""Most waves of friction in a turn of the rotor."""


def _without_load(at: At, values: Mapping[str, Any], common: Mapping[str, Array]) -> Mapping[str, Array]:
    """Current of a motor that drives only its own friction.

    Source: `Motor.operate`; definition.
    """
    constant = at.settings["torque_constant"]
    motor = motor_with(_BARE, {**values, "torque_constant": constant, "resistance": _BARE.resistance})
    return {"current": np.asarray(motor.operate(torque=0.0, speed=np.abs(at.known["speed"])).current)}


NO_LOAD = Law(
    name="no_load",
    title="no-load current of a motor over its speed",
    known={"speed": "rad/s"},
    read={"current": "A"},
    settings={"torque_constant": "N m/A"},
    terms={
        "motor_friction": Term(Parameter("N m", "mN m", "friction torque that is independent of speed"), 0.01),
        "motor_viscous": Term(Parameter("N m s", "uN m s", "friction torque per speed"), 1e-5),
    },
    forms={"constant": Form(("motor_friction",)), "viscous": Form(("motor_friction", "motor_viscous"))},
    expected=_without_load,
    over="speed",
)


def _screw(at: At, values: Mapping[str, Any], common: Mapping[str, Array]) -> Mapping[str, Array]:
    """Motor torque along the motion: friction with a term that falls with speed, and the load, which changes sign.

    Source: budynas2011, section 8-2 (a load raised and lowered); duclusaud2025, model M2 (Stribeck).
    """
    speed, way = np.abs(at.known["speed"]), np.sign(at.known["direction"])
    slow = stribeck_factor(speed, values["stribeck_speed"], values["stribeck_exponent"])
    load = values["load"] + values["load_stribeck"] * slow
    return {
        "torque": values["friction"]
        + values["viscous"] * speed
        + values["friction_stribeck"] * slow
        + np.where(way > 0, load, -load)
    }


_LINEAR = ("friction", "viscous", "load")
_STRIBECK = (*_LINEAR, "friction_stribeck", "stribeck_speed")

SCREW = Law(
    name="screw_friction",
    title="motor torque of a screw or worm over speed, up and down under a load",
    known={"speed": "rad/s", "direction": "1"},
    read={"torque": "N m"},
    settings={},
    terms={
        "friction": Term(Parameter("N m", "mN m", "friction torque that is independent of speed and direction"), 2e-3),
        "viscous": Term(Parameter("N m s", "uN m s", "friction torque per speed"), 3e-5),
        "load": Term(Parameter("N m", "mN m", "half the difference of torque up and down"), 3e-4),
        "friction_stribeck": Term(Parameter("N m", "mN m", "additional friction torque at rest"), 5e-4),
        "stribeck_speed": Term(Parameter("rad/s", "rad/s", "speed at which it falls to 1/e", divides=True), 1.5, 1.0),
        "stribeck_exponent": Term(Parameter("1", "1", "exponent of that fall"), 1.0, 1.0),
        "load_stribeck": Term(
            Parameter("N m", "mN m", "additional half difference at rest", least=-1.0), 0.0, size=3e-4
        ),
    },
    forms={
        "constant": Form(("friction", "load")),
        "viscous": Form(_LINEAR),
        "Stribeck": Form(_STRIBECK),
        "Stribeck by direction": Form((*_STRIBECK, "load_stribeck")),
    },
    expected=_screw,
    over="speed",
    ranges={"direction": _EITHER_WAY},
)


def _over_the_turn(at: At, values: Mapping[str, Any], common: Mapping[str, Array]) -> Mapping[str, Array]:
    """Size of the friction torque: a mean and waves of the rotor's angle; detent torque helps one way, brakes the other.

    Source: tuttle1996 (waves of friction with the angle of the wave generator).
    """
    angle, way = at.known["rotor_angle"], np.sign(at.known["direction"])
    found = values["mean"] + way * values["mean_detent"]
    for wave in range(1, WAVES + 1):
        cos, sin = np.cos(wave * angle), np.sin(wave * angle)
        found = found + values[f"cos{wave}"] * cos + values[f"sin{wave}"] * sin
        found = found + way * (values[f"detent_cos{wave}"] * cos + values[f"detent_sin{wave}"] * sin)
    return {"torque": found}


def _waves(count: int, head: str = "") -> tuple[str, ...]:
    return tuple(f"{head}{part}{wave}" for wave in range(1, count + 1) for part in ("cos", "sin"))


def _signed(meaning: str) -> Term:
    return Term(Parameter("N m", "N m", meaning, least=-1e3), 0.0, size=1.0)


STRAIN_WAVE = Law(
    name="friction_over_angle",
    title="friction of a geared actuator over the rotor's angle, both ways",
    known={"rotor_angle": "rad", "direction": "1"},
    read={"torque": "N m"},
    settings={},
    terms={
        "mean": Term(Parameter("N m", "N m", "mean friction torque"), 5.0),
        "mean_detent": _signed("half the difference of the means of both directions"),
        **{name: _signed("wave of friction") for name in _waves(WAVES)},
        **{name: _signed("wave of detent torque") for name in _waves(WAVES, "detent_")},
    },
    forms={
        "constant": Form(("mean",)),
        **{
            f"{count} wave{'s' * (count > 1)}": Form(("mean", "mean_detent", *_waves(count)))
            for count in range(1, WAVES + 1)
        },
        **{
            f"{count} waves, {detent} of detent": Form(
                ("mean", "mean_detent", *_waves(count), *_waves(detent, "detent_"))
            )
            for count in range(2, WAVES + 1)
            for detent in (1, 2)
        },
    },
    expected=_over_the_turn,
    over="rotor_angle",
    ranges={"direction": _EITHER_WAY, "rotor_angle": _TWO_TURNS},
)

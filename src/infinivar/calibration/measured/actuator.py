"""Benches of a geared actuator: steady current and power, and torque under a constant current, driving and driven."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from infinivar._core.array_namespace import Array
from infinivar.calibration.bench import Parameter
from infinivar.calibration.geared import PARAMETERS, gearhead_with, motor_with
from infinivar.calibration.measured.law import At, Form, Law, Term
from infinivar.parts.gearhead import Gearhead
from infinivar.parts.motor import Motor

_MOTOR = Motor(voltage=1e3, resistance=1e-3, torque_constant=1.0, no_load_current=0.0, continuous_torque=1.0)


def _steady(at: At, values: Mapping[str, Any], common: Mapping[str, Array]) -> Mapping[str, Array]:
    """Current and electrical power at a speed and torque of the output.

    Source: `Gearhead.operate`, `Motor.operate`.
    """
    gear = gearhead_with(
        Gearhead(ratio=at.settings["gear_ratio"], efficiency=1.0),
        {**values, "friction_stribeck": 0.0, "stribeck_speed": 1.0},
    )
    point = gear.operate(output_torque=at.known["torque"], output_speed=at.known["speed"], motor_rated_torque=1.0)
    none = {"motor_friction": 0.0, "motor_viscous": 0.0}
    electric = motor_with(_MOTOR, {**values, **none}).operate(torque=point.motor_torque, speed=point.motor_speed)
    return {"current": electric.current, "power": electric.power}


STEADY = Law(
    name="steady_actuator",
    title="current and electrical power of a geared actuator at steady speed and torque",
    known={"speed": "rad/s", "torque": "N m"},
    read={"current": "A", "power": "W"},
    settings={"gear_ratio": "1"},
    terms={
        "torque_constant": Term(PARAMETERS["torque_constant"], 0.1),
        "resistance": Term(PARAMETERS["resistance"], 0.1),
        "friction": Term(PARAMETERS["friction"], 1.0),
        "viscous": Term(PARAMETERS["viscous"], 0.01),
        "load_share": Term(PARAMETERS["load_share"], 0.05),
    },
    forms={
        "constant": Form(("torque_constant", "resistance", "friction")),
        "viscous": Form(("torque_constant", "resistance", "friction", "viscous")),
        "load": Form(("torque_constant", "resistance", "friction", "load_share")),
        "viscous, load": Form(("torque_constant", "resistance", "friction", "viscous", "load_share")),
    },
    expected=_steady,
    over="speed",
)


def _constant_current(at: At, values: Mapping[str, Any], common: Mapping[str, Array]) -> Mapping[str, Array]:
    r"""Output torque under a current while the output is turned: friction grows with the torques on both sides of the gear.

    With :math:`\tau_i = k i (1 - |i|/i_s)` and :math:`\tau_i - \tau_o = f\,\mathrm{sgn}\,w`, the friction
    :math:`f = F + K(|\tau_i| + |\tau_o|)` is, where both torques have one sign,
    :math:`(F + 2 K|\tau_i|)/(1 \pm K)`: plus while the motor drives, minus while it is driven.

    Source: duclusaud2025, model M3 with equal load terms, solved for the friction; the gain of each further run is its own.
    """
    current, way = at.known["current"], np.sign(at.known["speed"])
    bent = 1.0 - values["saturation"] * np.abs(current)
    entering = values["torque_per_current"] * np.exp(common["gain"]) * current * bent
    drives = np.where(entering * way >= 0.0, 1.0, -1.0)
    size = np.abs(entering)
    share = values["load_share"]
    both = (values["friction"] + 2.0 * share * size) / (1.0 + drives * share)
    # Near zero torque the output may change sign against the input: there |tau_o| = f - |tau_i|.
    turned = values["friction"] / (1.0 - share)
    friction = np.where((drives > 0) & (size < both), turned, both)
    return {"torque": entering + values["offset"] - way * friction}


_GAIN = ("torque_per_current", "offset", "friction")

BACKDRIVE = Law(
    name="constant_current",
    title="output torque of a geared actuator at constant current, motoring and back-driven",
    known={"current": "A", "speed": "rad/s"},
    read={"torque": "N m"},
    settings={},
    terms={
        "torque_per_current": Term(Parameter("N m/A", "N m/A", "output torque per current without friction"), 1.0),
        "offset": Term(Parameter("N m", "N m", "zero of the torque sensor", least=-math.inf), 0.0, size=0.1),
        "friction": Term(Parameter("N m", "N m", "constant friction torque at the output"), 0.3),
        "load_share": Term(Parameter("1", "%", "friction per torque on either side of the gear", most=0.9), 0.05),
        "saturation": Term(Parameter("1/A", "1/A", "fall of the torque constant per current"), 0.005),
    },
    forms={
        "constant": Form(_GAIN),
        "load": Form((*_GAIN, "load_share")),
        "load, saturation": Form((*_GAIN, "load_share", "saturation")),
    },
    expected=_constant_current,
    over="current",
    common={"gain": 0.5},
    from_second=True,
)

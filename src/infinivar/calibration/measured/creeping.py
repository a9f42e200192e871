"""Bench of rolling wheels that creep under a driving force: creep law, growth with load, saturation, rolling resistance."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from infinivar._core.array_namespace import Array
from infinivar.calibration.bench import Parameter
from infinivar.calibration.measured.law import At, Form, Law, Term
from infinivar.contact.creep import lateral_force

REFERENCE_LOAD = 40.0
"""Wheel load to which the creep stiffness refers. [N]"""


def _creep(at: At, values: Mapping[str, Any], common: Mapping[str, Array]) -> Mapping[str, Array]:
    r"""Driving force of a wheel: creep force, saturating at the friction limit, and the drag of wheel and rollers.

    :math:`F = \mu W\, g(C (W/W_0)^n \xi/(3 \mu W)) + D c - S s` with the creep law g, the creepage :math:`\xi`, and the
    wheel's speeds along and across, c and s, over that of the robot.

    Source: `infinivar.contact.creep.lateral_force`; definition of the drags.
    """
    load, creepage = at.known["load"], np.abs(at.known["creepage"])
    stiffness = values["stiffness"] * (load / REFERENCE_LOAD) ** values["exponent"]
    most = values["friction"] * load
    creep = most * lateral_force(at.form.creep_law, stiffness * creepage / (3.0 * most))
    return {"force": creep + values["drag"] * np.abs(at.known["along"]) - values["help"] * np.abs(at.known["across"])}


_LAWS = ("vermeulen-johnson", "exact")
_LINEAR = ("stiffness", "exponent")
_CREEP = ("stiffness", "exponent", "friction")

CREEPING = Law(
    name="wheel_creep",
    title="driving force of rolling wheels over creepage and wheel load",
    known={"creepage": "1", "load": "N", "along": "1", "across": "1"},
    read={"force": "N"},
    settings={},
    terms={
        "stiffness": Term(Parameter("N", "N", "force per creepage at 40 N", divides=True), 50.0),
        "exponent": Term(Parameter("1", "1", "exponent of its growth with load", least=-3.0, most=3.0), 0.5, 0.0, 0.5),
        "friction": Term(Parameter("1", "1", "friction limit over load", divides=True, most=3.0), 0.6, 0.6),
        "drag": Term(Parameter("N", "N", "drag of the wheel that rolls along"), 2.0),
        "help": Term(Parameter("N", "N", "force by which rollers that turn help", least=-20.0), 0.0, size=1.0),
    },
    forms={
        "linear": Form(_LINEAR, "linear"),
        **{law: Form(_CREEP, law) for law in _LAWS},
        "linear, drag": Form((*_LINEAR, "drag"), "linear"),
        "linear, drag, rollers": Form((*_LINEAR, "drag", "help"), "linear"),
        **{f"{law}, drag": Form((*_CREEP, "drag"), law) for law in _LAWS},
        **{f"{law}, drag, rollers": Form((*_CREEP, "drag", "help"), law) for law in _LAWS},
    },
    expected=_creep,
    over="creepage",
)

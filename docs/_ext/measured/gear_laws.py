"""Which gear law is closest to the identified friction of real actuators, over load, speed and direction."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from infinivar._core.frozen import FrozenDict
from infinivar._core.result import Frozen, result
from infinivar.parts import catalogue
from infinivar.parts.gear_friction import GearFriction, friction_budget, terms

LAWS = ("coulomb", "proportional", "coulomb and viscous")
"""Laws that are compared: the two that a data sheet can supply, and the simplest measured one."""

_POINTS = (41, 40)
"""Number of loads and of speeds."""


@result
class LawError(Frozen):
    """Distance of a fitted gear law from the identified friction of an actuator.

    Attributes
    ----------
    law : name.
    values : fitted parameters: torques [N m] at the output, coefficients [N m s], efficiencies [-].
    error : RMS difference of the friction torque at the output. [N m]
    share : the same over the RMS friction torque. [-]
    """

    law: str
    values: tuple[float, ...]
    error: float
    share: float


@result
class ActuatorLaws(Frozen):
    """Gear laws fitted to one actuator.

    Attributes
    ----------
    key, name : of the actuator.
    form : identified form that counts as true.
    largest_load, largest_speed : ends of the range, at the output. [N m], [rad s^-1]
    speed, torque, friction : grid of output speeds, torques on the load and friction torques. [rad s^-1], [N m], [N m]
    laws : fitted laws by name.
    """

    key: str
    name: str
    form: str
    largest_load: float
    largest_speed: float
    speed: np.ndarray
    torque: np.ndarray
    friction: np.ndarray
    laws: Mapping[str, LawError]

    @property
    def closer(self) -> str:
        """The closer one of the two laws of a data sheet."""
        return min(LAWS[:2], key=lambda law: self.laws[law].error)


def identified(key: str, form: str) -> GearFriction:
    """Friction of an actuator in one of the forms identified.

    Source: duclusaud2025.
    """
    values = {
        name: value for name, value, _ in catalogue.friction_terms(catalogue.data("actuator_friction")[key][form])
    }
    return GearFriction(**values)


def actuators() -> dict[str, str]:
    """Keys of the identified actuators, and the most complete form of each."""
    raw = catalogue.data("actuator_friction")
    return {key: max(set(one) & set(catalogue.FORMS)) for key, one in raw.items() if isinstance(one, dict)}


def compare(key: str, load_share: float = 1.0) -> ActuatorLaws:
    """Fit the gear laws to the identified friction of an actuator, in both directions.

    Parameters
    ----------
    key : str            From `actuators`.
    load_share : float   Largest load over the assumed one.

    Returns
    -------
    ActuatorLaws   Over equally spaced loads of either sign, and speeds up to that without load at the usual supply voltage.

    Notes
    -----
    The laws are linear in their parameters, so each fit is a least-squares problem with one solution. The proportional law
    has one efficiency for each direction, both fitted; friction over load while the motor drives may exceed 1.

    Source: duclusaud2025, for the friction; faulring2006, section VI-A, for the Coulomb law.
    """
    actuator, form = catalogue.data("actuator_friction")[key], actuators()[key]
    most = load_share * actuator["largest_load"]
    fastest = actuator["supply_voltage"] / actuator[form]["kt"]
    torque = np.linspace(-most, most, _POINTS[0])[None, :]
    speed = np.linspace(fastest / _POINTS[1], fastest, _POINTS[1])[:, None]
    friction = friction_budget(speed, torque, **terms(identified(key, form)))
    speed, torque = (np.broadcast_to(one, friction.shape) for one in (speed, torque))
    driving = torque > 0
    load = np.abs(torque)
    forms: dict[str, Sequence[np.ndarray]] = {
        "coulomb": [np.ones_like(load)],
        "proportional": [np.where(driving, load, 0.0), np.where(driving, 0.0, load)],
        "coulomb and viscous": [np.ones_like(load), speed],
    }
    size = math.sqrt(float(np.mean(friction**2)))
    found = {}
    for law, columns in forms.items():
        matrix = np.stack([column.ravel() for column in columns], axis=1)
        values = np.linalg.lstsq(matrix, friction.ravel(), rcond=None)[0]
        if law == "proportional":
            # No more than all of the load's power can be lost while it drives the motor.
            values = np.asarray([values[0], min(values[1], 1.0)])
        error = math.sqrt(float(np.mean((matrix @ values - friction.ravel()) ** 2)))
        shown = (1.0 / (1.0 + values[0]), 1.0 - values[1]) if law == "proportional" else values
        found[law] = LawError(law=law, values=tuple(map(float, shown)), error=error, share=error / size)
    return ActuatorLaws(
        key=key,
        name=actuator["name"],
        form=form,
        largest_load=most,
        largest_speed=fastest,
        speed=speed,
        torque=torque,
        friction=friction,
        laws=FrozenDict(found),
    )

"""The rolling contact in a bond graph: creep as a resistance, or creep and steering as one resistance with two ports."""

from __future__ import annotations

import functools

from infinivar._core.array_namespace import Array, namespace
from infinivar.bondgraph import graph as bg
from infinivar.bondgraph.graph import Element, Parameter
from infinivar.contact import creep
from infinivar.transmission import creepage, turning
from infinivar.transmission.geometry import LossGroups
from infinivar.transmission.rotary_linear import RotaryLinearIVT


def contact(ivt: RotaryLinearIVT, groups: LossGroups, stick: Parameter) -> tuple[list[Element], list[str]]:
    """The contact's creep; with `steering_model` "spin" its resistance to steering, too.

    Parameters
    ----------
    ivt : RotaryLinearIVT
    groups : LossGroups   At the cylinder's speed.
    stick : Parameter     Rolling speed below which the contact is viscous. [m s^-1]

    Returns
    -------
    elements, chains   Attached to the 0-junction "lateral" and driven by a signal "v"; with spin there is a 1-junction
        "turning" as well, open to the bell.

    Raises
    ------
    ParameterError
        If the creep law has a flow loss ("faulring").
    """
    law = creep.law_in_motion(ivt.creep_law)
    parameters = {
        "slip_force": Parameter(r"\mu P", float(groups.slip_force), "N"),
        "creep_stiffness": Parameter("C", float(groups.creep_stiffness), "N"),
        "stick_speed": stick,
    }
    first, second = (0.0, 0.0) if groups.yielding is None else map(float, groups.yielding)
    angle = {"first": Parameter("k_1", first), "second": Parameter("k_2", second)}
    if not ivt.turns_with_spin:
        parameters["slip_creepage"] = Parameter(r"\xi_s", float(groups.slip_creepage(law)))
        lateral, shares, signals = _lateral, _shares, ("v",)
        if groups.yielding is not None:
            lateral, shares, signals = _steered_lateral, _steered_shares, ("v", "phi")
            parameters |= angle
        made = bg.resistance(
            "creep",
            "f_u",
            functools.partial(lateral, groups.formulas(law)),
            signals=signals,
            parameters=parameters,
            losses=shares,
            title="creep",
        )
        return [made], ["lateral > creep"]
    patch = turning.TurningPatch.of(ivt, groups)
    parameters |= angle | {
        "slip_creepage": Parameter(r"\xi_s", float(groups.full_slip)),
        "lever": Parameter("h", float(patch.lever), "m"),
        "a_over_b": Parameter("a/b", float(patch.a_over_b)),
        "poisson": Parameter(r"\nu", float(patch.poisson)),
    }
    made = bg.resistance(
        "creep", "f_u", _turning, signals=("v", "phi"), parameters=parameters, losses=_turning_shares, title="creep"
    )
    return [bg.one("turning", r"\dot{\phi}"), made], ["lateral > creep", "turning > creep"]


def _lateral(law: creep.Formulas, u: Array, v: Array, slip_creepage: Array, **given: Array) -> Array:
    """Lateral force of the contact under a creep law."""
    return creepage.lateral_force(law, u, v, **given)


def _shares(u: Array, v: Array, effort: Array, **given: Array) -> dict[str, Array]:
    """The power that the contact loses, as creep or as slip."""
    power = effort * u
    slides = creepage.slips(u, v, **given)
    xp = namespace(u, v)
    return {"creep": xp.where(slides, 0.0, power), "slip": xp.where(slides, power, 0.0)}


def _steered_lateral(law: creep.Formulas, u: Array, v: Array, phi: Array, **given: Array) -> Array:
    """The same for a patch whose creep stiffness changes with the steering angle."""
    return _lateral(law, u, v, **_at_angle(phi, **given))


def _steered_shares(u: Array, v: Array, phi: Array, effort: Array, **given: Array) -> dict[str, Array]:
    return _shares(u, v, effort, **_at_angle(phi, **given))


def _at_angle(phi: Array, creep_stiffness: Array, first: Array, second: Array, **given: Array) -> dict[str, Array]:
    """Parameters of the contact with the creep stiffness at a steering angle."""
    sine = namespace(phi).sin(phi)
    compliance, _, _ = creepage.compliance(sine * sine, first, second)
    return {"creep_stiffness": creep_stiffness / compliance, **given}


def _turning(u: Array, rate: Array, v: Array, phi: Array, slip_creepage: Array, **given: Array) -> tuple[Array, Array]:
    """Lateral force of the contact, and the moment that resists steering."""
    return turning.law(u, rate, v, **_at_angle(phi, **given))


def _turning_shares(
    u: Array, rate: Array, v: Array, phi: Array, effort: tuple[Array, Array], slip_creepage: Array, **given: Array
) -> dict[str, Array]:
    """The power that the contact loses, by creep, by slip and by turning."""
    by_creep, by_turning = turning.shares(effort[0] * u, effort[1] * rate)
    here = _at_angle(phi, **given)
    kept = {name: here[name] for name in ("slip_force", "creep_stiffness", "lever", "stick_speed")}
    slides = turning.slip_demand(u, rate, v, slip_creepage=slip_creepage, **kept) > 1.0
    xp = namespace(u, v)
    return {
        "creep": xp.where(slides, 0.0, by_creep),
        "slip": xp.where(slides, by_creep, 0.0),
        "steering patch": by_turning,
    }

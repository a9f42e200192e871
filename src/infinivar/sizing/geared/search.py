"""Search over all pairs of motor and gearhead that fit together, at given output stages or over the radius of a pulley."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.errors import ParameterError, require
from infinivar.motion.duty_cycles import DutyCycle, shares_of
from infinivar.parts.gearhead import LossModel
from infinivar.parts.stage import OutputStage
from infinivar.sizing.geared.at_stages import at_stages
from infinivar.sizing.geared.candidates import candidates
from infinivar.sizing.geared.over_radius import best_over_radius
from infinivar.sizing.geared.result import GearedSizing, Objective
from infinivar.sizing.geared.tasks import tasks_of
from infinivar.study.requirement import Requirement


def size_geared(
    template: ConventionalDrive,
    motors: Mapping[str, Any],
    gearheads: Mapping[str, Any],
    pairs: Any,
    *,
    duty: Mapping[str, DutyCycle],
    requirement: Requirement | None = None,
    stages: Sequence[OutputStage] | None = None,
    radius: tuple[float, float] | None = None,
    objective: Objective = "energy",
    travel: float | None = None,
    loss_model: LossModel | None = None,
    samples: int | None = None,
    top: int = 20,
    prune: bool = True,
) -> GearedSizing:
    """Find the best motor, gearhead and output stage for a required region and motions.

    Parameters
    ----------
    template : ConventionalDrive   Everything but motor and gearhead, which are replaced; gearheads count as rigid.
    motors, gearheads : mapping    Columns by the names of the fields of `Motor` and `Gearhead`, in SI, nan where not stated. A
        limit that is not stated is not checked.
    pairs : (n, 2) int             Row of the motor and of the gearhead of each pair.
    duty : mapping of DutyCycle    Motions by name; may be empty.
    requirement : Requirement      Required region; none by default.
    stages : sequence              Output stages to try with every pair, such as screws of several leads; by default that of the
        template.
    radius : (float, float)        Least and largest radius of the template's pulley, instead of `stages`. [m]
    objective : str                energy: least mean power from the supply, over the motions by their shares of time, equal if
        none states one. mass: least mass of motor and gearhead, of equals the one with the largest margin. front: all designs
        of which no other has less of both.
    travel : float                 End-to-end travel of the load, as for `duty_cycle`. [m]
    loss_model : str               coulomb or proportional, of all gearheads; by default that of the template's.
    samples : int                  Instants of a motion; as many as `duty_cycle` has by default.
    top : int                      Number of designs to return; of a front, all are.
    prune : bool                   Whether closed forms spare candidates that cannot be feasible, or over a range of radii cannot
        be among the best, the evaluation at every instant. The result is the same without, only later.

    Returns
    -------
    GearedSizing   Empty of designs if no candidate is feasible.

    Raises
    ------
    ParameterError
        If an argument is out of range or does not fit the others.
    """
    require(objective in ("energy", "mass", "front"), "objective", repr(objective), "energy, mass or front")
    require(isinstance(top, int) and top >= 1, "top", top, ">= 1")
    if objective != "mass" and not duty:
        raise ParameterError(
            "duty is empty: the energy needs a motion; with a required region only, use objective = 'mass'"
        )
    gear = replace(template.gearhead, stiffness=None, backlash=None)
    template = replace(template, gearhead=gear)
    tasks = tasks_of(template, duty, requirement, travel=travel, samples=samples)
    shares = shares_of(duty) or dict.fromkeys(duty, 1.0 / max(len(duty), 1))
    found = candidates(
        template,
        motors,
        gearheads,
        pairs,
        loss_model=loss_model or template.gearhead.loss_model,
        moving=bool(duty),
        weighed=objective != "energy",
    )
    options = {"objective": objective, "shares": shares, "top": top, "prune": prune}
    if radius is None:
        return at_stages(found, tasks, tuple(stages or (template.stage,)), **options)
    if stages is not None:
        raise ParameterError("stages and radius are both given: state stages to try, or the range of a pulley's radius")
    if template.pulley is None:
        raise ParameterError(
            f"radius does not apply to a {template.stage.title}: only a pulley has a continuous range; state the "
            f"{template.stage.title}s to try as stages"
        )
    low, high = radius
    require(0.0 < low <= high < float("inf"), "radius", radius, "a range above 0, least first", "m")
    return best_over_radius(found, tasks, (float(low), float(high)), **options)

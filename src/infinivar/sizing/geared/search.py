"""Search over all pairs of motor and gearhead that fit together, at given output stages or over the radius of a pulley."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.drivetrain.masses import check_known
from infinivar.drivetrain.service import service_of
from infinivar.motion.duty_cycles import DutyCycle
from infinivar.parts.gearhead import LossModel
from infinivar.parts.stage import OutputStage
from infinivar.sizing.found import Design, GearedSizing
from infinivar.sizing.geared.at_stages import at_stages
from infinivar.sizing.geared.candidates import Candidates, candidates
from infinivar.sizing.geared.nearest import nearest_over_radius, nearest_stage
from infinivar.sizing.geared.over_radius import best_over_radius
from infinivar.sizing.geared.tasks import Task, tasks_of
from infinivar.sizing.progress import Progress
from infinivar.sizing.tables import GearedRequest, Objective
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
    progress: Progress | None = None,
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
        none states one. mass: least mass of the whole drive, with a range of radii at the smallest that is feasible; space: least
        volume of the box around it, likewise. price: least price of motor and gearhead, which all must state. front: of designs
        of which no other has less power and less mass those that are 3 % of their mass apart, and its ends.
    travel : float                 End-to-end travel of the load, as for `duty_cycle`. [m]
    loss_model : str               coulomb, proportional or strain wave, of all gearheads; by default that of the template's.
    samples : int                  Instants of a motion; as many as `duty_cycle` has by default.
    top : int                      Number of designs to return; of a front, all are.
    prune : bool                   Whether closed forms spare candidates that cannot be feasible, or over a range of radii cannot
        be among the best, the evaluation at every instant. The result is the same without, only later.
    progress : callable            Called with words on the best design so far and the share of work done, 0 to 1.

    Returns
    -------
    GearedSizing   Empty of designs if no candidate is feasible.

    Raises
    ------
    ParameterError
        If an argument is out of range or does not fit the others.
    """
    request = GearedRequest(
        template=template,
        motors=motors,
        gearheads=gearheads,
        pairs=pairs,
        duty=duty,
        requirement=requirement,
        stages=tuple(stages or ()),
        radius=radius,
        objective=objective,
        travel=travel,
        loss_model=loss_model,
        samples=samples,
        top=top,
        prune=prune,
    )
    return best_geared(request, progress)


def best_geared(request: GearedRequest, progress: Progress | None = None) -> GearedSizing:
    """Find the best drives; see `size_geared`."""
    request.check_motions()
    found, tasks = _problem(request)
    search = at_stages if request.radius is None else best_over_radius
    return search(found, tasks, request, progress)


def nearest_miss(request: GearedRequest) -> Design | None:
    """Return the infeasible candidate that comes nearest to keeping all limits.

    It is the one whose tightest limit has the largest margin; of several, the one with the largest margin of the next limit that
    is exceeded, and so on, then the lightest. In a search for the least mass only candidates count whose masses are stated.

    Closed forms rank all pairs, at all stages or over 13 radii; the best 64 are evaluated at every instant, each at its best
    radius.

    Returns
    -------
    Design   None if no pair can be evaluated, every candidate is out of reach, or all those evaluated are feasible.
    """
    found, tasks = _problem(request)
    search = nearest_stage if request.radius is None else nearest_over_radius
    return search(found, tasks, request)


def candidates_of(request: GearedRequest) -> Candidates:
    """Pairs of motor and gearhead, as drives with rigid gearheads."""
    template = request.template
    return candidates(
        replace(template, gearhead=replace(template.gearhead, stiffness=None, backlash=None)),
        request.motors,
        request.gearheads,
        request.pairs,
        loss_model=request.gear_law,
        moving=request.moving,
        stated=request.stated,
        service=service_of(request.template, request.duty, request.requirement, request.travel),
        envelope=request.envelope,
    )


def _problem(request: GearedRequest) -> tuple[Candidates, tuple[Task, ...]]:
    """Candidates, and what they are judged by."""
    found = candidates_of(request)
    tasks = tasks_of(found.template, request.duty, request.requirement, request.travel, request.samples)
    if request.weighed:
        check_known(found.template, found.service)
    return found, tasks

"""Scenarios: what a drive goes through in a simulation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from annotated_types import Gt, Interval

from infinivar._core.bounds import NonZero
from infinivar._core.fields import check, check_choice, check_kind, component, quantity, tagged
from infinivar.errors import ParameterError
from infinivar.motion.forces import ConstantForce, SinusoidalForce, StepForce
from infinivar.motion.motion import Force, Motion
from infinivar.motion.motions import Cruise, Reach, Rest, Sinusoid, Step
from infinivar.motion.recordings import RecordedForce, Waypoints
from infinivar.motion.task import Task

MOTIONS: dict[str, type] = {kind.shape: kind for kind in (Rest, Cruise, Sinusoid, Step, Reach, Waypoints)}
FORCES: dict[str, type] = {kind.shape: kind for kind in (ConstantForce, SinusoidalForce, StepForce, RecordedForce)}
"""Kinds of motion and force that a scenario's table can ask for, by the word in `shape`; the first if it has none."""

_MOST_RESULTS = 1e6


@dataclass(frozen=True, slots=True, kw_only=True)
class Scenario(Task):
    """One run of a drive in time.

    - `link` ``controlled``: the drive's controllers follow `motion`; ``imposed``: the load is moved from outside exactly
      along `motion`, and controllers follow it, too; ``free``: nothing but `force` acts on it, and nothing is followed.
    - `steering` ``controlled``: the wheel is steered as the link loop asks; ``locked`` and ``decoupled``: its servo keeps it
      at 0 and at a right angle; ``held``: at `steering_angle`.
    - `cylinder` ``running``: at speed from the beginning and kept there; ``run-up``: from rest to speed in
      `run_up_time`; ``at rest``: kept standing.

    Raises
    ------
    ParameterError
        If a field is outside its range or does not go with another; the message names it.
    """

    duration: float = quantity("s", Gt(0), "How long the run is")
    output_step: float | None = quantity(
        "s", Gt(0), "Time between results; a thousandth of the run if left out", default=None
    )
    link: Literal["controlled", "imposed", "free"] = component("Who moves the link", default="controlled")
    motion: Motion | None = tagged("Motion of the link; it holds still if left out", MOTIONS, default=None)
    force: Force | None = tagged("Force on the load from outside; none if left out", FORCES, default=None)
    steering: Literal["controlled", "locked", "decoupled", "held"] = component(
        "What the steering does", default="controlled"
    )
    steering_angle: float | None = quantity("rad", NonZero(), "Angle at which the steering is held", default=None)
    cylinder: Literal["running", "run-up", "at rest"] = component("What the cylinder does", default="running")
    run_up_time: float | None = quantity("s", Gt(0), "Time in which the cylinder is to reach its speed", default=None)
    electrical: Literal["current", "voltage"] = component(
        "What the amplifier imposes: a current, or a voltage, with the winding's inductance", default="current"
    )
    stick_speed: float | None = quantity(
        "m/s",
        Gt(0),
        "Speed of the link below which friction sticks; if left out 0.1 mm/s, 0.01 mm/s on a conventional drive",
        default=None,
    )
    tolerance: float = quantity("1", Interval(gt=0, le=1e-3), "Relative tolerance of the integration", default=1e-10)
    method: Literal["LSODA", "Radau", "BDF", "CVODES"] = component("Solver; CVODES needs CasADi", default="LSODA")

    def __post_init__(self) -> None:
        """Refuse what does not go together."""
        check(self)
        check_kind("motion", self.path, MOTIONS, "at")
        if self.force is not None:
            check_kind("force", self.force, FORCES, "value")
        if self.output_step is not None and self.duration / self.output_step > _MOST_RESULTS:
            least = self.duration / _MOST_RESULTS
            raise ParameterError(
                f"output_step must be >= {least:g} s, a millionth of duration, got {self.output_step:g}"
            )
        check_choice(self, "steering", {"controlled": (), "locked": (), "decoupled": (), "held": ("steering_angle",)})
        check_choice(self, "cylinder", {"running": (), "run-up": ("run_up_time",), "at rest": ()})
        if self.cylinder == "at rest" and self.steering == "controlled":
            raise ParameterError(
                "cylinder = 'at rest' moves nothing: steering must be locked, decoupled or held with it"
            )
        if self.link == "free" and self.motion is not None:
            raise ParameterError("motion does not apply with link = 'free'; remove it")
        if self.link == "imposed" and self.force is not None:
            raise ParameterError("force does not apply with link = 'imposed', where the motion is given; remove it")
        if self.link == "imposed" and isinstance(self.motion, Step):
            raise ParameterError("motion.shape = 'step' cannot be imposed: it needs an infinite force; use reach")
        if self.link == "controlled" and self.steering != "controlled" and self.motion is not None:
            raise ParameterError(f"motion does not apply with steering = {self.steering!r}; remove it, or impose it")

    @property
    def path(self) -> Motion:
        """The motion, holding still if none is given."""
        return Rest() if self.motion is None else self.motion

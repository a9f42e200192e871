"""Scenarios: runs of a drive to simulate."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from annotated_types import Gt, Interval

from infinivar._core.bounds import NonZero
from infinivar._core.fields import check_choice, check_kind, check_real, component, quantity, tagged
from infinivar._core.plugins import is_own
from infinivar.axis import LINEAR, Axis
from infinivar.errors import ParameterError, require
from infinivar.motion.forces import ConstantForce, SinusoidalForce, StepForce
from infinivar.motion.motion import Force, Motion, PeriodicMotion
from infinivar.motion.motions import Cruise, Reach, Rest, Sinusoid, Step
from infinivar.motion.task import Task, check_motion, check_task
from infinivar.motion.waypoints import RecordedForce, Waypoints
from infinivar.units import plain

MOTIONS: dict[str, type] = {kind.shape: kind for kind in (Rest, Cruise, Sinusoid, Step, Reach, Waypoints)}
FORCES: dict[str, type] = {kind.shape: kind for kind in (ConstantForce, SinusoidalForce, StepForce, RecordedForce)}
"""Kinds of motion and force of a scenario, by their name in `shape`; defaults to the first."""

_MOST_RESULTS = 1e6


@dataclass(frozen=True, slots=True, kw_only=True)
class Scenario(Task):
    """One simulated run of a drive.

    - `link` ``controlled``: the drive's controllers follow `motion`; ``imposed``: an external agent moves the load exactly
      along `motion`, and the controllers follow it as well; ``free``: only `force` acts on the load, without control.
    - `steering` ``controlled``: the link controller steers the wheel; ``locked`` and ``decoupled``: the steering servo holds
      it at 0 and at a right angle; ``held``: the servo holds it at `steering_angle`.
    - `cylinder` ``running``: at constant speed from the start; ``run-up``: accelerates from rest in `run_up_time`;
      ``at rest``: held at rest.

    Raises
    ------
    ParameterError
        If a field is out of range or conflicts with another; the message names it.
    """

    duration: float = quantity("s", Gt(0), "Duration of the run")
    output_step: float | None = quantity(
        "s", Gt(0), "Time between results; defaults to a thousandth of the run", default=None
    )
    settling_time: float | None = quantity(
        "s",
        Gt(0),
        "Time from the start by which limits are not judged, in which the controllers settle; defaults to none",
        default=None,
    )
    link: Literal["controlled", "imposed", "free"] = component("What moves the link", default="controlled")
    motion: Motion | None = tagged("Motion of the link; defaults to rest", MOTIONS, default=None)
    force: Force | None = tagged("External force on the load; defaults to none", FORCES, default=None)
    steering: Literal["controlled", "locked", "decoupled", "held"] = component(
        "State of the steering", default="controlled"
    )
    steering_angle: float | None = quantity("rad", NonZero(), "Angle at which the steering is held", default=None)
    cylinder: Literal["running", "run-up", "at rest"] = component("State of the cylinder", default="running")
    run_up_time: float | None = quantity("s", Gt(0), "Time for the cylinder to reach its speed", default=None)
    electrical: Literal["current", "voltage"] = component(
        "What the amplifier imposes: current, or voltage (includes the winding's inductance)", default="current"
    )
    stick_speed: float | None = quantity(
        "m/s",
        Gt(0),
        "Speed of the link below which friction sticks; defaults to 0.1 mm/s, or 0.01 mm/s for a conventional drive",
        default=None,
    )
    tolerance: float = quantity("1", Interval(gt=0, le=1e-3), "Relative tolerance of the integration", default=1e-10)
    method: Literal["auto", "LSODA", "Radau", "BDF", "CVODES"] = component(
        "Solver; auto: compiled where the system has a C compiler, otherwise LSODA; CVODES needs CasADi", default="auto"
    )

    def __post_init__(self) -> None:
        """Validate the fields and their combination."""
        check_real(self)
        check_kind("motion", self.path, MOTIONS, "at")
        if is_own(self.path) and isinstance(self.path, PeriodicMotion):
            check_motion(self.path)
        if self.force is not None:
            check_kind("force", self.force, FORCES, "value")
        _ = self.axis  # refuses a mixture
        if self.output_step is not None and self.duration / self.output_step > _MOST_RESULTS:
            least = self.duration / _MOST_RESULTS
            raise ParameterError(
                f"output_step must be >= {least:g} s, a millionth of duration, got {self.output_step:g}"
            )
        if self.settling_time is not None:
            allowed = f"< duration ({plain(self.duration)} s)"
            require(self.settling_time < self.duration, "settling_time", f"{plain(self.settling_time)} s", allowed)
        check_choice(self, "steering", {"controlled": (), "locked": (), "decoupled": (), "held": ("steering_angle",)})
        check_choice(self, "cylinder", {"running": (), "run-up": ("run_up_time",), "at rest": ()})
        if self.cylinder == "at rest" and self.steering == "controlled":
            raise ParameterError(
                "steering must be locked, decoupled or held with cylinder = 'at rest', which moves nothing"
            )
        if self.link == "free" and self.motion is not None:
            raise ParameterError("motion does not apply with link = 'free'; remove it")
        if self.link == "imposed" and self.force is not None:
            raise ParameterError("force does not apply with link = 'imposed', which prescribes the motion; remove it")
        if self.link == "imposed" and isinstance(self.motion, Step):
            raise ParameterError("motion.shape = 'step' cannot be imposed, as it requires an infinite force; use reach")
        if self.link == "imposed" and isinstance(self.motion, Cruise) and self.motion.start > 0.0:
            raise ParameterError(
                f"motion.start must be 0 s for an imposed cruise, which jumps to its speed by an infinite force, "
                f"got {plain(self.motion.start)}; use reach"
            )
        if self.link == "controlled" and self.steering != "controlled" and self.motion is not None:
            raise ParameterError(
                f"motion does not apply with steering = {self.steering!r}; remove it or set link = 'imposed'"
            )

    @property
    def axis(self) -> Axis:
        """Whether the load moves along a line or about a joint."""
        motion = None if isinstance(self.path, Rest) else getattr(self.path, "axis", LINEAR)
        forces = [] if self.force is None else [("force", getattr(self.force, "axis", LINEAR))]
        return self._common_axis(motion, *forces)

    @property
    def states_axis(self) -> bool:
        """Whether motion, force or mass of the load decide the axis; a load at rest may be along or about any."""
        masses = (self.load_mass, self.load_inertia)
        return not isinstance(self.path, Rest) or self.force is not None or any(mass is not None for mass in masses)

    @property
    def path(self) -> Motion:
        """The motion; at rest if none is given."""
        return Rest() if self.motion is None else self.motion


def check_scenario(scenario: object) -> None:
    """Raise ParameterError unless it is a scenario; the message says what to write in place of a motion or a name."""
    check_task("scenario", scenario, Scenario, "scenarios", ", duration=...")

"""The user at the handle of a machine."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from annotated_types import Ge, Gt

from infinivar._core.fields import check_real, component, quantity
from infinivar.errors import ParameterError, nearest


@dataclass(frozen=True, slots=True, kw_only=True)
class ArmModel:
    """Passive arm of a user along one axis: a mass at the handle, a damper and a spring to where the hand wants to be.

    A user can stiffen the arm at will. What is found with one arm, such as a limit of stability, is therefore true for that arm
    only; name it and its source.

    Raises
    ------
    ParameterError
        If a field is outside its range; the message names field, value and unit.
    """

    name: str = component("Whose arm, in which posture")
    mass: float = quantity("kg", Gt(0), "Effective mass at the handle")
    damping: float = quantity("N s/m", Ge(0), "Damping of arm and grip")
    stiffness: float = quantity("N/m", Ge(0), "Stiffness of arm and grip")
    source: str = component("Where the values come from", default="assumed")

    def __post_init__(self) -> None:
        """Validate the fields."""
        check_real(self)
        for field in ("name", "source"):
            text = getattr(self, field)
            if not isinstance(text, str) or not text.strip():
                raise ParameterError(f"{field} must be a text that says what the arm is, got {text!r}")

    @classmethod
    def named(cls, name: str) -> ArmModel:
        """An arm from the literature, by the key of its source; "vanbeek2015" so far.

        Raises
        ------
        ParameterError
            If there is none of this name; the message lists those known.
        """
        if not isinstance(name, str) or name not in ARMS:
            hint = nearest(name, ARMS) if isinstance(name, str) else ""
            raise ParameterError(f"arm must be one of {', '.join(ARMS)}, got {name!r}{hint}")
        return ARMS[name]


ARMS: Mapping[str, ArmModel] = {
    "vanbeek2015": ArmModel(
        name="one subject of vanbeek2015",
        mass=0.554,
        damping=6.45,
        stiffness=135.0,
        source="vanbeek2015, Fig 3: fit to one trial with a handle held by hand",
    ),
}
"""Arms with published values, by the key of their source."""

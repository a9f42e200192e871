"""A claim with its verdict, and the machine it is checked on."""

from __future__ import annotations

import functools
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from importlib import resources
from typing import Any, Literal, NamedTuple

from infinivar import power
from infinivar.analysis.compare import Comparison, compare
from infinivar.analysis.dynamic import DynamicMap, dynamic_map
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.drivetrain.drive import needed
from infinivar.study.load import shipped_study
from infinivar.study.study import Study
from infinivar.transmission.operating_point import OperatingPoint
from infinivar.transmission.rotary_linear import RotaryLinearIVT

Verdict = Literal["holds", "does not hold", "undecidable"]


class Range(NamedTuple):
    """Values of one parameter, all others as shipped, over which a claim keeps its verdict; None: as far as looked."""

    parameter: str
    unit: str
    shipped: float
    low: float | None
    high: float | None


class Variant(NamedTuple):
    """What is found under another assumption or definition."""

    assuming: str
    computed: float | str | None
    verdict: Verdict


class Finding(NamedTuple):
    """What a check found: the value (a number, or a few words), the verdict, and why in one sentence.

    `ranges` says how far parameters that the paper leaves open may move before the verdict changes, `variants` what is
    found, and with which verdict, under other assumptions and definitions.
    """

    computed: float | str | None
    verdict: Verdict
    why: str
    ranges: tuple[Range, ...] = ()
    variants: tuple[Variant, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Claim:
    """One claim of the paper, checked.

    `paper` and `computed` are numbers where the claim is one, else words; `figure` is the figure it belongs to.
    """

    id: str
    section: str
    figure: int | None
    claim: str
    paper: float | str
    computed: float | str | None
    verdict: Verdict
    why: str
    ranges: tuple[Range, ...] = ()
    variants: tuple[Variant, ...] = ()


@functools.cache
def statements() -> tuple[dict[str, Any], ...]:
    """Every claim as the paper makes it: id, section, figure (if any), claim, paper."""
    text = (resources.files("infinivar.analysis") / "claims" / "claims.toml").read_text("utf-8")
    return tuple(tomllib.loads(text)["claim"])


PLANE = (
    tuple(0.1 * 300.0 ** (place / 59) for place in range(60)),
    tuple((place + 0.5) / 60 for place in range(60)),
)
"""Of Fig 17: frequencies from 0.1 to 30 Hz, and fractions of the maximum power. [Hz], [-]"""


class Machine:
    """The paper's machine as shipped, with what several checks need computed once."""

    set_name = "faulring2006"

    @functools.cached_property
    def comparison(self) -> Comparison:
        """All drives of the set against its requirement."""
        return compare(replace(self.study, duty={}))

    @functools.cached_property
    def study(self) -> Study:
        """All drives of the set, without computing anything."""
        return shipped_study(self.set_name)

    @functools.cached_property
    def shaken(self) -> Mapping[str, DynamicMap]:
        """Fig 17: dynamic maps of both cobotic drives and of Motor 2's, by name, in the paper's definition."""
        return {name: self.shake(name) for name in ("cobotic", "cobotic-b", "motor2-gear4")}

    def shake(self, name: str) -> DynamicMap:
        """Dynamic map of one drive over the plane of Fig 17."""
        return dynamic_map(self.moving(name), *PLANE, power=self.power, load_mass=self.load_mass)

    def moving(self, name: str) -> CoboticDrive | ConventionalDrive:
        """A drive of the set by name."""
        drive = self.study.drives[name]
        assert isinstance(drive, (CoboticDrive, ConventionalDrive))
        return drive

    @property
    def power(self) -> float:
        """Maximum power of the requirement. [W]"""
        return needed(self.study.requirement.power, "requirement.power")

    @property
    def load_mass(self) -> float:
        """Mass that is moved. [kg]"""
        return needed(self.study.requirement.load_mass, "requirement.load_mass")

    @property
    def drive(self) -> CoboticDrive:
        """The cobotic drive of reconstruction A."""
        drive = self.study.drives["cobotic"]
        assert isinstance(drive, CoboticDrive)
        return drive

    @property
    def element(self) -> RotaryLinearIVT:
        """Its rolling-contact element; the efficiency depends on H and K alone."""
        return self.drive.transmission

    @property
    def cylinder_speed(self) -> float:
        """Speed of its cylinder. [rad/s]"""
        return self.drive.cylinder_speed


def at_ratio(element: RotaryLinearIVT, load: Any, ratio: Any, cylinder_speed: float = 14.0) -> OperatingPoint:
    """The element driving a link at a reduction ratio and a load.

    Parameters
    ----------
    load : (...,) float    Link force over slip force, f. [-]
    ratio : (...,) float   Cylinder surface speed over link speed, 1/|tan phi|, without creep. [-]

    Source: faulring2006, Fig 7 (its axes).
    """
    import numpy as np

    angle = -np.arctan(1.0 / np.asarray(ratio, dtype=float))
    return element.operate(cylinder_speed=cylinder_speed, steering_angle=angle, link_force=load * element.slip_force)


def efficiency_by(element: RotaryLinearIVT, load: Any, ratio: Any) -> Any:
    """Efficiency of `at_ratio`, also where the creepage of Eq 17 is beyond full slip; nan beyond the slip force. [-]"""
    point = at_ratio(element, load, ratio)
    return power.efficiency(point.power_in, point.power_out)


def about(value: float, paper: float, tolerance: float) -> Verdict:
    """Whether a computed value agrees with the printed one to what its printed digits mean."""
    return yes(abs(value - paper) <= tolerance)


def yes(condition: bool) -> Verdict:
    """The verdict on a claim that is true or false."""
    return "holds" if condition else "does not hold"

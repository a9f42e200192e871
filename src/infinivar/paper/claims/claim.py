"""A claim, the machine on which it is checked, its findings and its verdict.

A claim is undecidable if a choice of ours, or a value the paper leaves open, reverses the verdict.
"""

from __future__ import annotations

import functools
import re
import tomllib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from importlib import resources
from types import MappingProxyType
from typing import Any, Literal, NamedTuple

from infinivar import power
from infinivar._core.text import few
from infinivar.analysis.compare import Comparison, compare_drives
from infinivar.analysis.cycles.performance import PAPER
from infinivar.analysis.cycles.shaking import DynamicMap
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.drivetrain.drive import needed
from infinivar.paper.claims.planes import plane_map
from infinivar.parts.shaft_bearings import CylinderBearings
from infinivar.study.load import shipped_study
from infinivar.study.requirement import Requirement
from infinivar.study.study import Study
from infinivar.transmission.operating_point import OperatingPoint
from infinivar.transmission.rolling_contact import SteeringModel
from infinivar.transmission.rotary_linear import RotaryLinearIVT

Verdict = Literal["holds", "by construction", "does not hold", "undecidable"]
"""By construction: the machine was fitted to the claim, or every law of the program implies it. That is no test, and no pass."""

Kind = Literal["choice", "definition", "value", "contrary"]

KINDS: Mapping[Kind, str] = MappingProxyType(
    {
        "choice": "our choice",
        "definition": "definition the paper leaves open",
        "value": "value the paper does not print",
        "contrary": "contradicts the paper; for comparison only",
    }
)
"""What a variant changes. If any of the first three reverses a verdict, the claim is undecidable; the last does not count."""

FACTOR = 1.5
"""Assumed values are varied by this factor either way, which is how well they are known."""

_NAMED = 4
"""Most variants named in a reason; the table lists them all."""


class Found(NamedTuple):
    """A computed value, the threshold it is compared with, and the resulting verdict."""

    computed: float | str | None
    threshold: str
    verdict: Verdict


class Variant(NamedTuple):
    """The finding under another choice, definition or value."""

    kind: Kind
    assuming: str
    computed: float | str | None
    threshold: str
    verdict: Verdict


class Range(NamedTuple):
    """Range of one parameter, all others as shipped, over which the verdict stays the same; None: no limit within the search."""

    parameter: str
    unit: str
    shipped: float
    low: float | None
    high: float | None


class Finding(NamedTuple):
    """Result of a check: value (a number or a few words), threshold, verdict, and the reason in one or two sentences.

    `shown` is the verdict with the shipped choices, definitions and values alone. `variants` holds the findings under other
    ones, `ranges` how far parameters that the paper leaves open may change before `shown` does.
    """

    computed: float | str | None
    threshold: str
    verdict: Verdict
    shown: Verdict
    why: str
    ranges: tuple[Range, ...] = ()
    variants: tuple[Variant, ...] = ()


def yes(condition: bool) -> Verdict:
    """The verdict on a claim that is either true or false."""
    return "holds" if condition else "does not hold"


def _spaced(text: str) -> str:
    """The text with a space before each percent sign, as everywhere else."""
    return re.sub(r"(?<=\d)%", " %", text)


def near(value: float, printed: float, tolerance: float) -> Found:
    """Whether a computed value agrees with a printed one."""
    return Found(value, f"within {tolerance:g} of {printed:g}", yes(abs(value - printed) <= tolerance))


def row(kind: Kind, assuming: str, found: Found) -> Variant:
    """Make a variant from its finding."""
    computed = _spaced(found.computed) if isinstance(found.computed, str) else found.computed
    return Variant(kind, _spaced(assuming), computed, _spaced(found.threshold), found.verdict)


def either_way(words: str, found: Callable[[float], Found]) -> Iterator[Variant]:
    """Findings with an assumed value divided by `FACTOR` and multiplied by it; `found` takes what multiplies the value."""
    for factor, sign in ((1 / FACTOR, "/"), (FACTOR, "x")):
        yield row("value", f"{words} {sign} {FACTOR:g}", found(factor))


_COUNTED: Mapping[Verdict, tuple[str, str]] = MappingProxyType(
    {
        "holds": ("holds", "hold"),
        "by construction": ("holds by construction", "hold by construction"),
        "does not hold": ("does not hold", "do not hold"),
        "undecidable": ("is undecidable", "are undecidable"),
    }
)
"""Each verdict as the predicate of one claim and of several."""


def counted(verdicts: Sequence[Verdict]) -> str:
    """One sentence: how many claims have each verdict; empty without claims."""
    if not verdicts:
        return ""
    found = [
        f"{count} {words[count != 1]}" for verdict, words in _COUNTED.items() if (count := verdicts.count(verdict))
    ]
    return f"Of {len(verdicts)} claim{'s' if len(verdicts) != 1 else ''}, {', '.join(found)}."


def turned(verdict: Verdict, variants: Iterable[Variant]) -> list[Variant]:
    """Variants that count and reverse the verdict."""
    opposite = {"holds": "does not hold", "does not hold": "holds"}.get(verdict)
    return [variant for variant in variants if variant.kind != "contrary" and variant.verdict == opposite]


class Checked(NamedTuple):
    """What a check finds, before the choices, definitions and values tried besides, which take most of its time.

    Parameters
    ----------
    found : Found        Finding with the shipped choices, definitions and values.
    why : str            Reason, in one or more full sentences; or a function that returns it.
    variants, ranges     Findings under other choices, definitions and values, and ranges of open ones; or functions.
    by_construction      The machine was fitted to the claim, or no law of the program permits anything else; `why` says which.
    """

    found: Found
    why: str | Callable[[], str]
    variants: Iterable[Variant] | Callable[[], Iterable[Variant]] = ()
    ranges: Iterable[Range] | Callable[[], Iterable[Range]] = ()
    by_construction: bool = False

    def settled(self) -> Finding:
        """The finding: undecidable if any variant that counts reverses the verdict; the reason then names those variants.

        A claim that holds by construction is not decided by variants: they only show how closely it does.
        """
        found, why, variants, ranges = self.found, _made(self.why), tuple(_made(self.variants)), _made(self.ranges)
        built = self.by_construction and found.verdict == "holds"
        against = [] if built else turned(found.verdict, variants)
        verdict = "by construction" if built else found.verdict
        if against:
            named = few([variant.assuming for variant in against], _NAMED, "; ")
            reversal = {
                "holds": "Holds as shown, but not with",
                "does not hold": "Does not hold as shown, but would with",
            }
            why = f"{reversal[verdict]}: {named}. {why}"
            verdict = "undecidable"
        return Finding(
            computed=_spaced(found.computed) if isinstance(found.computed, str) else found.computed,
            threshold=_spaced(found.threshold),
            verdict=verdict,
            shown=found.verdict,
            why=_spaced(why),
            ranges=tuple(ranges),
            variants=variants,
        )


def _made(value: Any) -> Any:
    return value() if callable(value) else value


@dataclass(frozen=True, slots=True, kw_only=True)
class Claim:
    """One claim of the paper, checked.

    `paper` and `computed` are numbers in `unit` if the claim states a number, otherwise text. `figure` is the number of the
    figure that the claim belongs to. `infinivar.paper.claims.claim.Finding` describes the other fields.
    """

    id: str
    section: str
    figure: int | None
    claim: str
    paper: float | str
    computed: float | str | None
    threshold: str
    verdict: Verdict
    shown: Verdict
    why: str
    unit: str = "1"
    ranges: tuple[Range, ...] = ()
    variants: tuple[Variant, ...] = ()

    @property
    def flips(self) -> tuple[str, ...]:
        """Choices, definitions and values that reverse the verdict as shown."""
        return tuple(variant.assuming for variant in turned(self.shown, self.variants))


@functools.cache
def statements() -> tuple[dict[str, Any], ...]:
    """The claims of the paper: id, section, figure (if any), claim, paper, unit (if any)."""
    text = (resources.files("infinivar.paper") / "claims" / "claims.toml").read_text("utf-8")
    return tuple(tomllib.loads(text)["claim"])


class PaperMachine:
    """The paper's machine as shipped; quantities that several checks need are computed once."""

    set_name = "faulring2006"

    def __init__(
        self,
        creep_law: str = "",
        steering_model: SteeringModel = "shear",
        demand: tuple[str, float] | None = None,
        cylinder_bearings: CylinderBearings | None = None,
    ) -> None:
        """The machine, with another creep law than that of the set if one is named, and the paper's steering by default.

        `demand` is a key of the requirement and the factor by which it is multiplied. The paper names the friction of the
        cylinder's bearings and states no value; by default it is not counted.
        """
        self.creep_law = creep_law
        self.steering_model: SteeringModel = steering_model
        self.demand = demand
        self.cylinder_bearings = cylinder_bearings

    def __eq__(self, other: object) -> bool:
        """True for any two of the same laws: both represent the shipped machine, however much they have computed so far."""
        return isinstance(other, PaperMachine) and self._laws == other._laws

    def __hash__(self) -> int:
        """Equal for equal machines."""
        return hash((self.set_name, *self._laws))

    @property
    def _laws(self) -> tuple[str, SteeringModel, tuple[str, float] | None, CylinderBearings | None]:
        return self.creep_law, self.steering_model, self.demand, self.cylinder_bearings

    def demanding(self, key: str, factor: float) -> PaperMachine:
        """The same machine under another requirement: "force", "speed" or "power" multiplied by a factor."""
        return PaperMachine(self.creep_law, self.steering_model, (key, factor), self.cylinder_bearings)

    @functools.cached_property
    def comparison(self) -> Comparison:
        """Comparison of all drives of the set against its requirement."""
        return compare_drives(replace(self.study, duty={}))

    @property
    def study(self) -> Study:
        """The shipped study, with all drives of the set."""
        return _study(self)

    @functools.cached_property
    def shaken(self) -> Mapping[str, DynamicMap]:
        """Fig 17: dynamic maps of both cobotic drives and of the Motor 2 drive, by name, by the paper's definition."""
        return {name: self.shake(name) for name in ("cobotic", "cobotic-b", "motor2-gear4")}

    def shake(self, name: str) -> DynamicMap:
        """Dynamic map of one drive over the plane of Fig 17."""
        return plane_map(self.moving(name), self.power, self.load_mass, PAPER, "fine", "linear")

    def cobotic(self, name: str) -> CoboticDrive:
        """A cobotic drive of the set by name."""
        drive = self.study.drives[name]
        assert isinstance(drive, CoboticDrive)
        return drive

    def conventional(self, name: str) -> ConventionalDrive:
        """A conventional drive of the set by name."""
        drive = self.study.drives[name]
        assert isinstance(drive, ConventionalDrive)
        return drive

    def moving(self, name: str) -> CoboticDrive | ConventionalDrive:
        """A drive of the set by name."""
        drive = self.study.drives[name]
        assert isinstance(drive, (CoboticDrive, ConventionalDrive))
        return drive

    @property
    def requirement(self) -> Requirement:
        """Required region of the set."""
        return self.study.required(self.set_name)

    @property
    def power(self) -> float:
        """Maximum power of the requirement. [W]"""
        return needed(self.requirement.power, "requirement.power")

    @property
    def load_mass(self) -> float:
        """Mass of the load. [kg]"""
        return needed(self.requirement.load_mass, "requirement.load_mass")

    @property
    def drive(self) -> CoboticDrive:
        """The cobotic drive of reconstruction A."""
        return self.cobotic("cobotic")

    @property
    def element(self) -> RotaryLinearIVT:
        """The rolling-contact element; its efficiency depends on H and K alone."""
        return self.drive.transmission

    @property
    def cylinder_speed(self) -> float:
        """Cylinder speed of the cobotic drive. [rad/s]"""
        return self.drive.cylinder_speed


@functools.lru_cache(maxsize=64)
def _study(machine: PaperMachine) -> Study:
    """The study of a machine, one of all that are equal."""
    found = shipped_study(machine.set_name)
    if machine.demand is not None:
        key, factor = machine.demand
        requested = needed(found.requirement, "requirement")
        found = replace(found, requirement=replace(requested, **{key: factor * needed(getattr(requested, key), key)}))
    if (machine.creep_law, machine.steering_model, machine.cylinder_bearings) == ("", "shear", None):
        return found
    laws: dict[str, Any] = {"steering_model": machine.steering_model}
    laws |= {"creep_law": machine.creep_law} if machine.creep_law else {}
    drives = {
        name: replace(
            drive,
            transmission=replace(drive.transmission, **laws),
            cylinder_bearings=machine.cylinder_bearings or drive.cylinder_bearings,
        )
        if isinstance(drive, CoboticDrive)
        else drive
        for name, drive in found.drives.items()
    }
    return replace(found, drives=drives)


def at_ratio(element: RotaryLinearIVT, load: Any, ratio: Any, cylinder_speed: float = 14.0) -> OperatingPoint:
    """Operating point of an element that drives a link at a given reduction ratio and load.

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
    """Efficiency at `at_ratio`, even where Eq 17 implies a creepage beyond full slip; nan beyond the slip force. [-]"""
    point = at_ratio(element, load, ratio)
    return power.efficiency(point.power_in, point.power_out)

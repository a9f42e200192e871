"""The paper's claims on efficiency asked of a sphere between rollers, beside the wheel on a cylinder.

The paper states its claims for a wheel on a cylinder. Here sphere and cylinder have one radius, and rollers and wheel are the
same; radius, preload and material, which the paper does not print, are varied.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from infinivar._core.result import Result, result
from infinivar.analysis.sphere_map import efficiency_of
from infinivar.errors import ParameterError, nearest, require
from infinivar.figures import gear_points
from infinivar.paper.claims.claim import Verdict
from infinivar.study.catalogue import materials
from infinivar.study.load import shipped_study
from infinivar.transmission.rolling_contact import RollingContact
from infinivar.transmission.rotary_linear import RotaryLinearIVT
from infinivar.transmission.spherical import SphericalIVT, SphericalPoint

_HALF, _SURFACE_SPEED = 0.5, 0.7
"""Load over mu P, and speed of the surface of sphere and cylinder: 14 rad/s times the 50 mm of the reconstruction. [m s^-1]"""

_RATIOS = np.geomspace(1.0, 100.0, 9)
_BEST, _LARGE = (0.6, 0.7), (0.7, 0.8, 0.9, 0.95)
"""Loads at which the best efficiency is sought, and the largest load. [-]"""

_READING, _SIMILAR, _STEEP, _MOTOR_AND_GEAR = 0.01, 0.15, 0.2, 0.87 * 0.88
_TYPES = ("planetary", "harmonic", "worm")

PARTS = ("elastic creep", "kinematic creep", "rolling", "bearing")
"""Parts of the loss. Kinematic creep is what spin adds: the loss less that of contacts that do not feel it."""

_CLAIMS: Mapping[str, tuple[str, str]] = {
    "E1": ("efficiency at 100:1 and half load", "at least 0.49"),
    "E2": ("efficiency at 8:1 and half load", "at least 0.93"),
    "E3": ("efficiency at 1:1 and half load", "0.49 to 0.51"),
    "E4": ("best efficiency", "at least 0.97"),
    "E8": ("largest median difference to gears of a type", "within 0.15"),
    "E8 high": ("the same, of gears whose efficiency is known with high confidence", "within 0.15"),
    "E9": ("drop from 8:1 to 100:1", "at least 0.2, and rolling and bearings lose the larger part at 100:1"),
    "E11": ("largest load at 8:1 over mu P", "0.95"),
    "B2": ("best efficiency with motor 0.87 and gear 0.88", "below 0.75"),
}


@result
class SphereClaims(Result):
    """Claims on efficiency asked of both layouts of the sphere and of the wheel; n claims, m cases.

    Attributes
    ----------
    claims : n names                  Of the claims.
    asked, threshold : n texts        What is computed, and where the claim holds.
    cases : m texts                   Layout, radius, preload and material.
    sphere, wheel : (n, m) float      What is computed. [-]
    sphere_holds, wheel_holds : (n, m) bool
    sphere_lost, wheel_lost : name to (m,) float   Losses at 8:1 and half load over the power delivered, by `PARTS`. [-]
    """

    claims: tuple[str, ...]
    asked: tuple[str, ...]
    threshold: tuple[str, ...]
    cases: tuple[str, ...]
    sphere: np.ndarray
    wheel: np.ndarray
    sphere_holds: np.ndarray
    wheel_holds: np.ndarray
    sphere_lost: Mapping[str, np.ndarray]
    wheel_lost: Mapping[str, np.ndarray]

    def verdict(self, claim: str) -> Verdict:
        """Whether a claim holds of the sphere: in all cases, in none, or undecidable as the paper does not print the values.

        Rows of one claim count together: those whose names begin with the same id.
        """
        holds = self.sphere_holds[[name.split()[0] == claim.split()[0] for name in self.claims]]
        return "holds" if holds.all() else "undecidable" if holds.any() else "does not hold"

    def better(self, claim: str) -> int:
        """Number of cases in which the sphere has the larger value."""
        place = self.claims.index(claim)
        return int(np.sum(self.sphere[place] > self.wheel[place]))

    def why(self) -> str:
        """What the sphere loses more than the wheel at 8:1 and half load, by median over the cases, and what decides."""
        more = {name: float(np.median(self.sphere_lost[name] - self.wheel_lost[name])) for name in PARTS}
        total = float(np.median(sum(self.sphere_lost.values()) - sum(self.wheel_lost.values())))  # type: ignore[arg-type]
        most = max(more, key=lambda name: more[name])
        words = ", ".join(f"{name} {100.0 * value:+.1f} %" for name, value in more.items())
        way = "more" if total > 0 else "less"
        return (
            f"At 8:1 and half load the sphere loses {100.0 * abs(total):.1f} % of the power delivered {way} than the wheel: "
            f"{words} (medians). The largest part is {most}."
        )


def sphere_claims(
    *,
    radius: Sequence[float] = (0.02, 0.03, 0.06),
    preload: Sequence[float] = (200.0, 650.0),
    material: Sequence[str] = ("bearing-steel", "ti-6al-4v"),
    layout: Sequence[str] = ("tetrahedral", "cubic"),
) -> SphereClaims:
    """Ask the paper's claims on efficiency of a sphere between rollers.

    Parameters
    ----------
    radius : row of float     Of sphere and cylinder. [m]
    preload : row of float    Of each roller, and of the wheel. [N]
    material : row of names   Of all bodies, from the catalogue.
    layout : row of names     Of the rollers.

    Returns
    -------
    SphereClaims   Of all combinations. Rollers and wheel are those of the shipped reconstruction, with its friction limit. Where
        shaft 2 creeps back under its load, the efficiency counts as 0. Limits that the preload alone exceeds do not count.

    Raises
    ------
    ParameterError
        If a row is empty, or a value is not one that the transmission permits.
    """
    rows = {"radius": radius, "preload": preload, "material": material, "layout": layout}
    for name, row in rows.items():
        require(
            isinstance(row, Sequence) and not isinstance(row, str) and len(row) > 0, name, repr(row), "a row of values"
        )
    found, titles = [], []
    for size, force, stuff in itertools.product(radius, preload, material):
        wheel = _wheel(size, force, stuff)
        known = _of_wheel(wheel)
        for arrangement in layout:
            found.append((_of_sphere(wheel, arrangement), known))
            titles.append(f"{arrangement}, {1e3 * size:g} mm, {force:g} N, {stuff}")
    (sphere, sphere_holds, sphere_lost), (wheels, wheel_holds, wheel_lost) = (
        [np.array([one[side][part] for one in found]).T for part in range(3)] for side in (0, 1)
    )
    return SphereClaims(
        claims=tuple(_CLAIMS),
        asked=tuple(requested for requested, _ in _CLAIMS.values()),
        threshold=tuple(threshold for _, threshold in _CLAIMS.values()),
        cases=tuple(titles),
        sphere=sphere,
        wheel=wheels,
        sphere_holds=sphere_holds > 0,
        wheel_holds=wheel_holds > 0,
        sphere_lost=dict(zip(PARTS, sphere_lost, strict=True)),
        wheel_lost=dict(zip(PARTS, wheel_lost, strict=True)),
    )


def _wheel(radius: float, preload: float, material: str) -> RotaryLinearIVT:
    """The wheel of the reconstruction with other values that the paper does not print."""
    shipped: Any = shipped_study("faulring2006").drives["cobotic"]
    known, body = shipped.transmission, _material(material)
    geometry = replace(known.geometry, wheel_material=body, cylinder_material=body)
    changed = {"preload": preload, "cylinder_radius": radius, "geometry": geometry, "creep_law": "exact"}
    return replace(known, **changed)


def _material(name: str) -> Any:
    known = materials()
    if name not in known:
        raise ParameterError(f"material must be one of {', '.join(known)}, got {name!r}{nearest(str(name), known)}")
    return known[name]


def as_sphere(wheel: RotaryLinearIVT, layout: str, *, spins: bool = True) -> SphericalIVT:
    """A sphere of the radius of a wheel's cylinder, with that wheel as each roller; without spin, its contacts do not feel it."""
    radius = float(wheel.cylinder_radius)
    roller = RollingContact(
        wheel_radius=wheel.wheel_radius,
        preload=wheel.preload,
        friction=wheel.friction,
        geometry=wheel.geometry,
        surface="sphere",
        surface_radius=radius,
        creep_law=wheel.creep_law,
        steering_model=None if spins else "shear",
    )
    return SphericalIVT(sphere_radius=radius, drive=roller, layout=layout)  # type: ignore[arg-type]


def _of_sphere(wheel: RotaryLinearIVT, layout: str) -> tuple[list[float], list[bool], list[float]]:
    ivt, plain = as_sphere(wheel, layout), as_sphere(wheel, layout, spins=False)
    # All points at once, as each call of the solver takes its time: by ratio, by load at 1:1, by load at 8:1, of both senses.
    requested = [
        *((one, _HALF) for one in _RATIOS),
        *((1.0, one) for one in _BEST),
        *((8.0, one) for one in (_HALF, *_LARGE)),
    ]
    ratio, load = np.array(requested).T
    point = _at(ivt, np.concatenate([ratio, -ratio]), np.concatenate([load, load]))
    delivered = np.where((point.power_in > 0) & (point.power_out <= 0), 0.0, efficiency_of(point))
    both = delivered.reshape(2, -1)
    found = np.where(np.isnan(both[0]), both[1], np.fmax(*both))
    curve, best, eight = np.split(found, [len(_RATIOS), len(_RATIOS) + len(_BEST)])
    at_100 = {name: float(loss[len(_RATIOS) - 1]) for name, loss in point.losses.items()}
    resisted = (at_100["rolling"] + at_100["bearing"]) / sum(at_100.values())
    place = len(_RATIOS) + len(_BEST)
    place += len(ratio) * int(np.nan_to_num(both[1, place]) > np.nan_to_num(both[0, place]))
    lost = sum(float(loss[place]) for loss in point.losses.values()) / float(point.power_out[place])
    without = _at(plain, 8.0 if place < len(ratio) else -8.0, _HALF)
    parts = [float(without.losses[name] / without.power_out) for name in ("creep", "rolling", "bearing")]
    values = _asked(curve, float(eight[0]), float(np.nanmax(best)), resisted, _largest(eight[1:]))
    return *values, [parts[0], lost - sum(parts), *parts[1:]]


def _at(ivt: SphericalIVT, ratio: Any, load: Any) -> SphericalPoint:
    """At a ratio, negative for the other sense, and a force of the output roller over mu P."""
    angle = np.arctan(ratio)
    kappa = load * ivt.drive.slip_force / np.sin(angle)
    return ivt.operate(steering_angle=angle, sphere_speed=_SURFACE_SPEED / ivt.sphere_radius, load=kappa)


def _largest(efficiency: np.ndarray) -> float:
    """Largest of `_LARGE` that is transmitted; below them half load."""
    return float(np.max(_LARGE, where=np.isfinite(efficiency), initial=_HALF))


def _of_wheel(wheel: RotaryLinearIVT) -> tuple[list[float], list[bool], list[float]]:
    def point(ratio: Any, load: Any) -> Any:
        return wheel.deliver(
            cylinder_speed=_SURFACE_SPEED / wheel.cylinder_radius,
            link_speed=_SURFACE_SPEED / ratio,
            link_force=load * wheel.slip_force,
        )

    curve, at_8, at_100 = point(_RATIOS, _HALF).efficiency, point(8.0, _HALF), point(100.0, _HALF)
    resisted = sum(float(at_100.losses[name]) for name in ("rolling", "bearing")) / float(sum(at_100.losses.values()))
    best = np.nanmax(point(np.array([[1.0], [2.0], [4.0]]), np.array(_BEST)).efficiency)
    largest = _largest(point(8.0, np.array(_LARGE)).efficiency)
    lost = [float(at_8.losses[name] / at_8.power_out) for name in ("creep", "rolling", "bearing")]
    requested = _asked(curve, float(at_8.efficiency), float(best), resisted, largest)
    return *requested, [lost[0], 0.0, *lost[1:]]


def _asked(
    curve: np.ndarray, at_8: float, best: float, resisted: float, largest: float
) -> tuple[list[float], list[bool]]:
    """What is asked by each claim, and whether it holds."""
    best = max(best, float(np.nanmax(curve)))
    at_1, at_100 = float(curve[0]), float(curve[-1])
    apart, known, drop, system = _from_gears(curve), _from_gears(curve, "high"), at_8 - at_100, best * _MOTOR_AND_GEAR
    values = [at_100, at_8, at_1, best, apart, known, drop, largest, system]
    holds = [
        at_100 >= 0.50 - _READING,
        at_8 >= 0.94 - _READING,
        abs(at_1 - 0.50) <= _READING,
        best >= 0.98 - _READING,
        abs(apart) <= _SIMILAR,
        abs(known) <= _SIMILAR,
        drop >= _STEEP and resisted > 0.5,
        largest >= _LARGE[-1],
        system < 0.75,
    ]
    return values, holds


def _from_gears(curve: np.ndarray, confidence: str = "") -> float:
    """Median difference to the gears of a type up to 100:1, of the type with the largest; of one confidence if named."""
    known, apart = gear_points.gears(), []
    for kind in _TYPES:
        each = [
            float(np.interp(np.log(ratio), np.log(_RATIOS), curve)) - efficiency
            for ratio, efficiency, sure in known[kind]
            if ratio <= _RATIOS[-1] and confidence in ("", sure)
        ]
        apart += [float(np.median(each))] if each else []
    return max(apart, key=abs)

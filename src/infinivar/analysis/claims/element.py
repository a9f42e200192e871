"""Checks of the claims about the rolling-contact element (sections III and IV)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from infinivar.analysis.claims.claim import Finding, Machine, about, at_ratio, efficiency_by, yes
from infinivar.contact.exact import lateral_creep
from infinivar.parts import catalogue
from infinivar.transmission.rotary_linear import RotaryLinearIVT

_HALF = 0.5
_SIMILAR = 0.15
_COULOMBIC = 1 / 3
"""Spread of a torque over a twentyfold speed up to which one would call it independent of speed."""
_BANDS = (
    ("planetary", 1, 50),
    ("planetary", 50, 150),
    ("planetary", 150, 2000),
    ("worm", 1, 150),
    ("harmonic", 50, 150),
)
# Printed as whole percents read off a plot: half a percent of rounding and as much of reading.
_READING = 0.01


def excess_creep(force_ratio: float) -> np.ndarray:
    """Creep of the exact theory over that of the linear law at a force ratio, one value a curve."""
    from scipy.interpolate import PchipInterpolator

    found = [
        PchipInterpolator(curve["force_ratio"], curve["scaled_creepage"])(force_ratio) for curve in lateral_creep()
    ]
    return 3.0 * np.asarray(found) / force_ratio


def with_friction_model(element: RotaryLinearIVT, model: str) -> RotaryLinearIVT:
    """The design with another friction model of its axle bearings."""
    geometry = element.geometry
    assert geometry is not None
    bearing = replace(geometry.axle_bearing, friction_model=model)
    return replace(element, geometry=replace(geometry, axle_bearing=bearing))


def e1(machine: Machine) -> Finding:
    """Efficiency at 100:1 and half load."""
    value = float(at_ratio(machine.element, _HALF, 100.0).efficiency)
    why = "The geometry of the reconstruction was chosen to meet this figure and E2, so it holds by construction."
    return Finding(value, about(value, 0.50, _READING), why)


def e2(machine: Machine) -> Finding:
    """Efficiency at 8:1 and half load."""
    value = float(at_ratio(machine.element, _HALF, 8.0).efficiency)
    why = "The geometry of the reconstruction was chosen to meet this figure and E1, so it holds by construction."
    return Finding(value, about(value, 0.94, _READING), why)


def e3(machine: Machine) -> Finding:
    """Efficiency at 1:1 and half load, with Eqs 16 and 17."""
    element = replace(machine.element, creep_law="faulring")
    value = float(efficiency_by(element, _HALF, 1.0))
    ratios = np.geomspace(0.5, 1.0, 2001)
    falls = ratios[np.nanargmin(np.abs(efficiency_by(element, _HALF, ratios) - 0.5))]
    why = f"Eqs 16 and 17 with H and K that meet E1 and E2 give {value:.3f} at 1:1 and fall to 0.50 only near {falls:.2f}:1."
    return Finding(value, about(value, 0.50, _READING), why)


def e4(machine: Machine) -> Finding:
    """Best efficiency over load and ratio."""
    load, ratio = np.linspace(0.02, 0.999, 300)[:, None], np.geomspace(0.3, 100.0, 600)[None, :]
    efficiency = at_ratio(machine.element, load, ratio).efficiency
    row, column = np.unravel_index(np.nanargmax(efficiency), efficiency.shape)
    value = float(efficiency[row, column])
    place = f"{ratio[0, column]:.2f}:1 and {load[row, 0]:.2f} of the slip force"
    why = f"The best point is at {place}; it lies within a point of the printed 98 percent."
    return Finding(value, about(value, 0.98, _READING), why)


def e5(machine: Machine) -> Finding:
    """Departure of the exact creep curve from the linear law."""
    at60, at70 = excess_creep(0.6), excess_creep(0.7)
    value = f"{at60.min():.2f}-{at60.max():.2f} x at 0.6, {at70.min():.2f}-{at70.max():.2f} x at 0.7"
    why = "Exact rolling theory creeps this much more than the linear law there (a/b from 0.2 to 5), beyond any 10 % band."
    return Finding(value, yes(at60.max() <= 1.1), why)


def e6(machine: Machine) -> Finding:
    """Bearing loss over hysteresis loss."""
    groups = machine.element.groups(machine.cylinder_speed)
    geometry = machine.element.geometry
    assert geometry is not None
    value = float(groups.bearing_torque / groups.rolling_torque)
    factor = geometry.hysteresis_factor
    with_skf = with_friction_model(machine.element, "skf").groups(machine.cylinder_speed)
    why = (
        f"{value:.1f} with the largest hysteresis loss factor that the paper allows, {factor:g}, and ten with "
        f"{factor * value / 10:.4f}: the loss factor, which the paper does not print, decides. With SKF's later model of "
        f"the same bearings it is {float(with_skf.bearing_torque / with_skf.rolling_torque):.0f}."
    )
    return Finding(value, "undecidable", why)


def e7(machine: Machine) -> Finding:
    """Speed dependence of the rolling losses, by SKF's model of the bearings."""
    element = with_friction_model(machine.element, "skf")
    speeds = machine.cylinder_speed * np.array([0.1, 0.3, 1.0, 2.0])
    groups = element.groups(speeds)
    torque = np.asarray(groups.rolling_torque + groups.bearing_torque)
    spread = float(np.ptp(torque) / torque.mean())
    geometry = element.geometry
    assert geometry is not None
    why = (
        "Hysteresis does not know speed. By SKF's model of the axle bearings, in which the sliding torque falls as a film "
        f"builds up and the rolling torque rises, the sum changes by {spread:.0%} from a tenth to twice the cylinder's speed "
        f"with a base oil of {geometry.axle_bearing.viscosity * 1e6:.0f} mm2/s; up to a third counts as independent here."
    )
    return Finding(f"torque changes by {spread:.0%} over 20:1 in speed", yes(spread < _COULOMBIC), why)


def e8(machine: Machine) -> Finding:
    """Element at half load against catalogue gears of the same ratio, band by band."""
    found, worst = [], 0.0
    for kind, low, high in _BANDS:
        gears = [
            gear for gear in catalogue.data("gear_efficiencies")["gear"] if gear["type"] == kind and "ratio" in gear
        ]
        ratio, efficiency = np.asarray([(gear["ratio"], gear["efficiency"]) for gear in gears]).T
        within = (ratio >= low) & (ratio < high)
        # Beyond about 440:1 half load drags the link backwards: the element transmits nothing.
        element = np.nan_to_num(at_ratio(machine.element, _HALF, ratio[within]).efficiency)
        difference = float(np.median(element - efficiency[within]))
        worst = max(worst, abs(difference))
        found.append(f"{kind} {low}-{high}:1 {difference:+.2f}")
    why = (
        f"Median of element (half load) minus gear, by band of ratio; similar would be within {_SIMILAR:g}. The element "
        "keeps up with planetary stages to about 50:1 and with worm gears, and falls behind both planetary and harmonic "
        "drives above, where rolling loss H decides; harmonic and worm data are weak."
    )
    return Finding(", ".join(found), yes(worst <= _SIMILAR), why)


def e9(machine: Machine) -> Finding:
    """Share of rolling loss at 100:1 at the loads of Fig 8."""
    shares = {}
    for load in (0.15, 0.5, 0.95):
        point = at_ratio(machine.element, load, 100.0)
        total = sum(float(loss) for loss in point.losses.values())
        shares[load] = 1.0 - float(point.losses["creep"]) / total
    drop = [float(at_ratio(machine.element, _HALF, ratio).efficiency) for ratio in (8.0, 100.0)]
    value = ", ".join(f"{share:.0%} at f = {load}" for load, share in shares.items())
    why = (
        f"From 8:1 to 100:1 efficiency falls from {drop[0]:.2f} to {drop[1]:.2f}; rolling and bearing are most of the loss "
        "at 100:1 at light and half load, while near slip creep takes more than they do."
    )
    return Finding(value, yes(shares[0.15] > 0.5 and shares[0.5] > 0.5), why)


def e10(machine: Machine) -> Finding:
    """Spread of the slip angle over three decades of cylinder speed."""
    speeds = np.array([0.1, 1.0, 14.0, 100.0])
    point = at_ratio(machine.element, _HALF, 8.0, cylinder_speed=speeds)  # type: ignore[arg-type]
    slip_angle = np.arctan(point.creep_speed / np.abs(point.rolling_speed))
    value = float(np.ptp(slip_angle) / np.abs(slip_angle).mean())
    why = (
        "Steady creep of elastic bodies with Coulomb friction knows no time scale, so no law here contains a speed: it "
        "holds by construction, as it does in exact rolling theory."
    )
    return Finding(f"relative spread {value:.0e}", yes(value < 1e-9), why)


def e11(machine: Machine) -> Finding:
    """Peaks of the 95 % curve by Eq 16 and by Eq 17."""
    ratio = np.geomspace(1.0, 100.0, 2001)
    peaks = [
        float(np.nanmax(efficiency_by(replace(machine.element, creep_law=law), 0.95, ratio)))
        for law in ("linear", "faulring")
    ]
    why = (
        "The curves are drawn (Fig 7) but the paper prints no values to hold them against; at f = 0.95 Eq 17 multiplies "
        "Eq 16 by 0.31 at most, so the two cannot both be the drawn curve."
    )
    return Finding(f"peak at f = 0.95: {peaks[0]:.2f} by Eq 16, {peaks[1]:.2f} by Eq 17", "undecidable", why)


CHECKS = {
    "E1": e1,
    "E2": e2,
    "E3": e3,
    "E4": e4,
    "E5": e5,
    "E6": e6,
    "E7": e7,
    "E8": e8,
    "E9": e9,
    "E10": e10,
    "E11": e11,
}

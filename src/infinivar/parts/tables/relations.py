"""Figures of data sheets that follow from others: what each row of a table must agree with, or not exceed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from infinivar.parts.heat import COPPER, REFERENCE
from infinivar.parts.structure.beams import Section
from infinivar.parts.structure.stock import DENSITIES, all_coils, coiled_mass, coils_of_body, wire_rate
from infinivar.parts.tables.search import Rows
from infinivar.parts.tables.table import PartTable

Compared = tuple[np.ndarray, np.ndarray]
"""What a row states, and what follows from its other values: the same figure twice, or a figure and its bound."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Relation:
    """Two figures of a row that must agree, or one that must not exceed the other, within a tolerance."""

    kind: str
    name: str
    law: Callable[[Rows], Compared]
    unit: str
    tolerance: float
    """Largest difference: relative, or absolute for an efficiency."""
    reason: str
    """Why not less."""
    follows: str
    """What the second figure follows from, or is."""
    resolution: float = 0.0
    """Half of the last digit of what is stated, in SI: a difference within it is none."""
    at_most: bool = False
    """Whether the first figure may be less than the second."""

    def deviations(self, table: PartTable) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Both figures of each row, and how far they are apart; nan where a row does not state all that they need."""
        with np.errstate(all="ignore"):
            one, other = self.law(Rows(table))
            if self.unit == "1" and not self.at_most:
                apart = other - one
            elif self.at_most:
                apart = np.maximum(one / other - 1.0, 0.0)
            else:
                apart = np.where(np.abs(other - one) > self.resolution, other / one - 1.0, 0.0)
        return one, other, np.where(np.isfinite(one) & np.isfinite(other), apart, np.nan)


def no_load_speed(rows: Rows) -> Compared:
    """No-load speed: stated, and (V - R I0)/K. [rad s^-1]

    Source: data sheets, maxon2020.
    """
    return rows.stated_no_load_speed, rows.no_load_speed


def ideal_speed(rows: Rows) -> Compared:
    """No-load speed as stated, and the speed of a motor without friction, V/K, that it must not exceed. [rad s^-1]

    Source: data sheets, maxon2020.
    """
    return rows.stated_no_load_speed, rows.voltage / rows.torque_constant


def stall_torque(rows: Rows) -> Compared:
    """Stall torque: stated, and K V/R less friction. [N m]

    Source: data sheets, maxon2020.
    """
    return rows.stated_stall_torque, rows.stall_torque


def stall_current(rows: Rows) -> Compared:
    """Stall current: stated, and V/R. [A]

    Source: data sheets, maxon2020.
    """
    return rows.stated_stall_current, rows.stall_current


def continuous_current(rows: Rows) -> Compared:
    """Continuous current: stated, and that of the continuous torque, T/K + I0. [A]

    Source: data sheets, maxon2020.
    """
    stated, follows = rows.stated_continuous_current, rows.continuous_current
    # A torque that was derived from the current agrees with it, which says nothing.
    return stated, np.where(rows.derived == "continuous_torque", np.nan, follows)


def peak_efficiency(rows: Rows) -> Compared:
    """Peak efficiency: stated, and (1 + c R/K^2) (1 - sqrt(I0 R/V))^2. [-]

    Source: data sheets, maxon2020; with viscous friction, faulhaber2020.
    """
    return rows.stated_peak_efficiency, rows.peak_efficiency


def friction_torque(rows: Rows) -> Compared:
    """No-load torque: stated friction with what grows with speed, and K I0. [N m]

    Source: faulhaber2020.
    """
    return rows.stated_friction_torque + rows.viscous_friction * rows.no_load_speed, rows.no_load_torque


def runs_free(rows: Rows) -> Compared:
    """No-load current, and the stall current that it must not reach, V/R. [A]

    Source: data sheets, maxon2020: otherwise the motor cannot overcome its own friction.
    """
    return rows.no_load_current, rows.stall_current


def below_stall(rows: Rows) -> Compared:
    """Continuous current, and the stall current that it must not exceed, V/R. [A]

    Source: data sheets, maxon2020: the supply voltage drives no more.
    """
    return np.fmax(rows.stated_continuous_current, rows.continuous_current), rows.stall_current


def viscous_share(rows: Rows) -> Compared:
    """Friction that grows with speed, at no-load speed, and the no-load torque of which it is a part, K I0. [N m]

    Source: faulhaber2020.
    """
    viscous = np.where(rows.viscous_friction > 0.0, rows.viscous_friction, np.nan)
    return viscous * rows.no_load_speed, rows.no_load_torque


def heat_at_continuous_current(rows: Rows) -> Compared:
    """Continuous current, and the current that heats the winding to its limit at 25 °C ambient. [A]

    The winding settles where ``I^2 R (1 + alpha dT) (R_wh + R_ha)`` equals its temperature rise dT. Friction heat is left out,
    which only raises the bound.

    Source: maxon2020 (thermal resistances, coefficient of copper).
    """
    rise = rows.max_winding_temperature - REFERENCE
    resistance = rows.resistance * (1.0 + COPPER * rise)
    bound = np.sqrt(rise / (resistance * (rows.winding_to_housing + rows.housing_to_ambient)))
    stated = rows.stated_continuous_current
    return np.where(np.isnan(stated), rows.continuous_current, stated), bound


def peak_over_continuous(rows: Rows) -> Compared:
    """Continuous torque, and the peak torque that it must not exceed. [N m]

    Source: data sheets, maxon2020.
    """
    return rows.continuous_torque, rows.peak_torque


def magnets_over_continuous(rows: Rows) -> Compared:
    """Continuous current, and the current that demagnetises the magnets, which it must not exceed. [A]

    Source: maxon2020.
    """
    return np.fmax(rows.stated_continuous_current, rows.continuous_current), rows.demagnetisation_current


def rotor_in_housing(rows: Rows) -> Compared:
    """Rotor inertia, and the inertia of all of the motor's mass at its outer radius, m (D/2)^2. [kg m^2]

    Source: definition of the moment of inertia: no part of the rotor is farther from the axis than the housing.
    """
    return rows.rotor_inertia, rows.mass * (0.5 * rows.diameter) ** 2


def intermittent_over_continuous(rows: Rows) -> Compared:
    """Continuous output torque of a gearhead, and the intermittent torque that it must not exceed. [N m]

    Source: data sheets, maxon2020.
    """
    return rows.continuous_torque, rows.intermittent_torque


def rings(rows: Rows) -> Compared:
    """Bore of a bearing, and the outside diameter that it must not reach. [m]

    Source: geometry.
    """
    return rows.bore, rows.outside_diameter


def _coils(rows: Rows) -> np.ndarray:
    """Coils that deflect: as stated, else of a closed body. [-]"""
    return np.where(np.isnan(rows.coils), coils_of_body(rows.body_length, rows.wire_diameter), rows.coils)


def spring_rate(rows: Rows) -> Compared:
    """Stiffness of a spring: stated, and G d^4/(8 D^3 n). [N m^-1]

    Source: wahl1963.
    """
    coil = rows.outer_diameter - rows.wire_diameter
    return rows.stiffness, wire_rate(rows.wire_diameter, coil, _coils(rows))


def spring_force(rows: Rows) -> Compared:
    """Permissible force of a spring: stated, and initial tension and stiffness at the permissible length. [N]

    Source: Hooke's law.
    """
    along = rows.stiffness * np.abs(rows.permissible_length - rows.free_length)
    return rows.permissible_force, np.nan_to_num(rows.initial_tension) + along


def spring_opens(rows: Rows) -> Compared:
    """Initial tension of a spring, and the permissible force that it must not reach. [N]

    Source: Hooke's law: otherwise the spring never opens.
    """
    return rows.initial_tension, rows.permissible_force


def spring_mass(rows: Rows) -> Compared:
    """Mass of a spring: stated, and that of its steel wire with ends or hooks. [kg]

    Source: geometry, `coiled_mass`.
    """
    coil = rows.outer_diameter - rows.wire_diameter
    return rows.mass, coiled_mass(rows.wire_diameter, coil, all_coils(_coils(rows)))


def coil_room(rows: Rows) -> Compared:
    """Twice the diameter of a spring's wire, and the outer diameter that it must not reach. [m]

    Source: geometry.
    """
    return 2.0 * rows.wire_diameter, rows.outer_diameter


def tube_mass(rows: Rows) -> Compared:
    """Mass of a tube over its length: stated, and section times density, that stated or usual for its metal. [kg m^-1]

    Source: geometry.
    """
    usual = np.where(rows.metal == "aluminium", DENSITIES["aluminium"], DENSITIES["steel"])
    density = np.where(np.isnan(rows.density), usual, rows.density)
    radius = 0.5 * rows.outer_diameter
    return rows.tube_density, density * Section(radius, radius - rows.wall).area


def tube_room(rows: Rows) -> Compared:
    """Twice the wall of a tube, and the outer diameter that it must not reach. [m]

    Source: geometry.
    """
    return 2.0 * rows.wall, rows.outer_diameter


_ROUNDED = "both are rounded to three digits"
_EXACT = "a bound without exceptions; 1 % for rounding"
RELATIONS = (
    Relation(
        kind="motors",
        name="no-load speed",
        law=no_load_speed,
        unit="rad/s",
        tolerance=0.10,
        reason="the voltage drop of brushes and iron loss, which no stated constant describes, take up to a tenth",
        follows="(V - R I0)/K",
    ),
    Relation(
        kind="motors",
        name="no-load speed below V/K",
        law=ideal_speed,
        unit="rad/s",
        tolerance=0.10,
        reason="torque constants of two digits are off by up to 5 %, and so are speeds",
        follows="the speed without friction, V/K",
        at_most=True,
    ),
    Relation(
        kind="motors",
        name="stall torque",
        law=stall_torque,
        unit="N m",
        tolerance=0.10,
        reason="the torque constant falls by some percent in saturation",
        follows="K V/R less friction",
    ),
    Relation(
        kind="motors",
        name="stall current",
        law=stall_current,
        unit="A",
        tolerance=0.05,
        reason=f"{_ROUNDED}, and a resistance of tens of milliohm to two or three",
        follows="V/R",
    ),
    Relation(
        kind="motors",
        name="continuous current",
        law=continuous_current,
        unit="A",
        tolerance=0.20,
        reason="of flat brushless motors, torque and current are up to 17 % apart in the shipped catalogue: the stated torque "
        "exceeds even K I, so that the two hold for different conditions",
        follows="T/K + I0",
    ),
    Relation(
        kind="motors",
        name="peak efficiency",
        law=peak_efficiency,
        unit="1",
        tolerance=0.10,
        reason="the voltage drop of brushes, which no stated constant describes, takes up to 8 points of large motors",
        follows="(1 - sqrt(I0 R/V))^2",
    ),
    Relation(
        kind="motors",
        name="friction torque",
        law=friction_torque,
        unit="N m",
        tolerance=0.15,
        reason="no-load current and speed are typical values; small friction torques are stated to 0.01 mN m",
        follows="K I0",
        resolution=5e-6,
    ),
    Relation(
        kind="motors",
        name="no-load current",
        law=runs_free,
        unit="A",
        tolerance=0.0,
        reason="at the stall current the motor does not turn at all",
        follows="the stall current, V/R",
        at_most=True,
    ),
    Relation(
        kind="motors",
        name="continuous current below stall",
        law=below_stall,
        unit="A",
        tolerance=0.01,
        reason=_EXACT,
        follows="the stall current, V/R",
        at_most=True,
    ),
    Relation(
        kind="motors",
        name="viscous friction",
        law=viscous_share,
        unit="N m",
        tolerance=0.01,
        reason=_EXACT,
        follows="the no-load torque, K I0",
        at_most=True,
    ),
    Relation(
        kind="motors",
        name="heat at continuous current",
        law=heat_at_continuous_current,
        unit="A",
        tolerance=0.05,
        reason="thermal resistances are rounded to two digits, 5 % of the temperature rise, and half of that of the current",
        follows="the current that heats the winding to its limit",
        at_most=True,
    ),
    Relation(
        kind="motors",
        name="continuous torque",
        law=peak_over_continuous,
        unit="N m",
        tolerance=0.01,
        reason=_EXACT,
        follows="the peak torque",
        at_most=True,
    ),
    Relation(
        kind="motors",
        name="demagnetisation current",
        law=magnets_over_continuous,
        unit="A",
        tolerance=0.01,
        reason=_EXACT,
        follows="the current that demagnetises the magnets",
        at_most=True,
    ),
    Relation(
        kind="motors",
        name="rotor inertia",
        law=rotor_in_housing,
        unit="kg m^2",
        tolerance=0.01,
        reason=_EXACT,
        follows="m (D/2)^2",
        at_most=True,
    ),
    Relation(
        kind="gearheads",
        name="continuous torque",
        law=intermittent_over_continuous,
        unit="N m",
        tolerance=0.01,
        reason=_EXACT,
        follows="the intermittent torque",
        at_most=True,
    ),
    Relation(
        kind="bearings",
        name="bore",
        law=rings,
        unit="m",
        tolerance=0.0,
        reason="the balls need room between the rings",
        follows="the outside diameter",
        at_most=True,
    ),
    Relation(
        kind="springs",
        name="stiffness",
        law=spring_rate,
        unit="N/m",
        tolerance=0.25,
        reason="the shear modulus is that of spring steel; wire of stainless steel has 14 % less, and makers state rates to 10 %",
        follows="G d^4/(8 D^3 n)",
    ),
    Relation(
        kind="springs",
        name="permissible force",
        law=spring_force,
        unit="N",
        tolerance=0.05,
        reason="lengths are rounded to 0.1 mm, up to 5 % of the deflection of the shortest springs",
        follows="stiffness times deflection at the permissible length",
    ),
    Relation(
        kind="springs",
        name="initial tension",
        law=spring_opens,
        unit="N",
        tolerance=0.0,
        reason="a spring opens before its permissible force",
        follows="the permissible force",
        at_most=True,
    ),
    Relation(
        kind="springs",
        name="mass",
        law=spring_mass,
        unit="kg",
        tolerance=0.15,
        reason="hooks and ends take half a coil to a coil more or less, of ten or more, and are of steel of 7700 to 8000 kg/m^3",
        follows="the mass of its wire",
    ),
    Relation(
        kind="springs",
        name="wire",
        law=coil_room,
        unit="m",
        tolerance=0.0,
        reason="the coils need room within",
        follows="the outer diameter",
        at_most=True,
    ),
    Relation(
        kind="tubes",
        name="mass over length",
        law=tube_mass,
        unit="kg/m",
        tolerance=0.05,
        reason="densities of alloys of aluminium differ by 4 %; masses are rounded to three digits",
        follows="section times density",
    ),
    Relation(
        kind="tubes",
        name="wall",
        law=tube_room,
        unit="m",
        tolerance=0.0,
        reason="a tube is hollow",
        follows="the outer diameter",
        at_most=True,
    ),
)
"""Every relation that `check_parts` tests, where a row states all that it needs."""

"""Calculation sheet of a wheel-cylinder contact: patch, stress, creep, friction torques and life, each with its formula."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from infinivar._core.described import derived, reported
from infinivar._core.result import Result, result
from infinivar.contact import creep, flash, hysteresis, shakedown, spin, wear
from infinivar.contact.bodies import plane_strain_modulus
from infinivar.contact.exact_law import NARROWEST, WIDEST
from infinivar.drivetrain.cobotic import CoboticDrive, legs_of
from infinivar.drivetrain.drive import is_machine, refuse_machine
from infinivar.drivetrain.steering import SteeringPlant
from infinivar.errors import InputError
from infinivar.limits import Limit
from infinivar.parts.linear import Guideway
from infinivar.parts.structure import beams
from infinivar.parts.structure.tube import Tube
from infinivar.study.check import check_study
from infinivar.study.provenance import Provenance
from infinivar.study.study import Study
from infinivar.transmission import turning
from infinivar.transmission.geometry import ContactGeometry, LossGroups, PressedContact
from infinivar.transmission.rotary_linear import RotaryLinearIVT
from infinivar.units import plain, unlike_one

HALF = 0.5
"""Share of the slip force at which creep, wear, life and efficiency are evaluated."""

STEERING_RATES = (1.0, 6.0, 20.0)
"""Steering rates of the sheet. [rad s^-1]"""

WORN = 10e-6
"""Wear depth for which the rolling distance is given. [m]"""

_THIN = 10.0
"""Mean radius over wall from which handbooks take a wall as a thin shell."""

RATIOS = (1.0, 8.0, 100.0)
"""Reduction ratios at which the efficiency is evaluated."""


@dataclass(frozen=True, slots=True)
class Line:
    """One line of the sheet."""

    section: str
    name: str
    symbol: str
    value: float
    """In SI."""
    unit: str
    """SI unit, "1" for a pure number."""
    shown_in: str
    """Display unit."""
    how: str
    """Formula, condition or source."""


@result
class ContactSheet(Result):
    """Calculation sheet of one drive, as returned by `contact_sheet`.

    Attributes
    ----------
    name, title : str   Name of the drive, in the study and for display.
    drive               The drive.
    lines               Results in order.
    utilisation         Demand over allowance of each known stress limit; above 1 the contact is over-stressed.
    given               Provenance of the input values.
    reconstruction      Reconstruction statements of the parameter sets used.
    """

    name: str = reported(key="drive")
    title: str = reported()
    drive: CoboticDrive
    lines: tuple[Line, ...] = reported(table="")
    utilisation: Mapping[Limit, float] = reported("1")
    given: tuple[Provenance, ...] = reported()
    reconstruction: tuple[str, ...] = reported()

    @property
    def exceeded(self) -> tuple[Limit, ...]:
        """Exceeded stress limits."""
        return tuple(limit for limit, demand in self.utilisation.items() if demand > 1.0)

    @derived()
    def verdict(self) -> str:
        """One-sentence verdict: the tightest stress limit, and whether it is exceeded."""
        if not self.utilisation:
            return "Stress limits unknown: the contact is given by measured groups, or the strength of its materials is missing."
        worst = max(self.utilisation, key=lambda limit: self.utilisation[limit])
        demand = self.utilisation[worst]
        if demand > 1.0:
            # The axle's bearings may be too large for the wheel: no stress.
            word = "EXCEEDED" if worst == Limit.CLEARANCE else "OVER-STRESSED"
            return f"{word}: {worst.words}, {unlike_one(demand, f'{demand:.2f}')} times the allowance."
        return f"Within stress limits; tightest limit: {worst.words} (margin {1.0 / demand:.2f})."

    def value(self, name: str) -> float:
        """The value of the first line of that name, in SI.

        Raises
        ------
        KeyError
            If no line has that name.
        """
        for line in self.lines:
            if line.name == name:
                return line.value
        raise KeyError(name)


def contact_sheets(study: Study, drive: str | None = None) -> tuple[ContactSheet, ...]:
    """Compute the contact sheets of all cobotic drives of a study and of the legs of its machines, or of one.

    Parameters
    ----------
    study : Study          Drives of other types are skipped.
    drive : str, optional  Name of one cobotic drive.

    Returns
    -------
    tuple of ContactSheet   In the order of the study.

    Raises
    ------
    InputError
        If the drive does not exist or has no wheel on a cylinder.
    """
    check_study(study)
    return tuple(contact_sheet(study, name) for name in cobotic_drives(study, drive))


def cobotic_drives(study: Study, drive: str | None) -> dict[str, CoboticDrive]:
    """All cobotic drives of a study by name, or one.

    Raises
    ------
    InputError
        If there is none, or none of that name.
    """
    contacts = {name: wheeled for name, found in study.drives.items() if (wheeled := leg_of(found)) is not None}
    machines = {name: one for name, one in study.drives.items() if is_machine(one) and name not in contacts}
    for name, one in machines.items():
        if not contacts or name == drive:
            refuse_machine(one, "contact", f"drives.{name}")
    if not contacts:
        raise InputError("no drive of type cobotic; only cobotic drives have a wheel on a cylinder")
    if drive is None:
        return contacts
    if drive not in contacts:
        raise InputError(f"drive {drive!r} must be one of {', '.join(contacts)}")
    return {drive: contacts[drive]}


def leg_of(drive: Any) -> CoboticDrive | None:
    """The drive itself if it is cobotic, or the leg of a machine that has such legs."""
    return drive if isinstance(drive, CoboticDrive) else legs_of(drive)


def contact_sheet(study: Study, name: str) -> ContactSheet:
    """Compute the contact sheet of one cobotic drive, or of the leg of a machine."""
    drive = leg_of(study.drives[name])
    assert drive is not None
    inside = "leg." if is_machine(study.drives[name]) else ""
    element, utilisation, limits = drive.transmission, {}, drive.transmission.utilisation
    if element.wheels > 1:  # the sheet is of one wheel, with its share of the force
        element = replace(element, wheels=1)
        drive = replace(drive, transmission=element, guideway=Guideway())
    lines: list[Line] = []
    groups = element.groups(drive.cylinder_speed)
    geometry, contact = element.geometry, element.contact
    if geometry is not None and contact is not None:
        _patch(lines, element, geometry, contact)
        _strength(lines, element, geometry, contact)
        utilisation = limits
        if element.tube is not None:
            _tube(lines, drive, element.tube, contact)
    _creep(lines, drive, groups)
    _rolling(lines, drive, groups)
    if drive.steering is not None:
        _steering(lines, drive.steering, element)
    if element.turns_with_spin:
        _spin(lines, drive)
    if geometry is not None and contact is not None:
        _life(lines, drive, geometry, contact, groups)
        _temperature(lines, drive, geometry, contact, groups)
    _efficiency(lines, drive, groups)
    return ContactSheet(
        name=name,
        title=study.titles[name],
        drive=drive,
        lines=tuple(lines),
        utilisation=utilisation,
        given=tuple(
            row
            for row in study.provenance
            if row.owner == name
            and row.field.startswith(
                tuple(inside + key for key in ("transmission.", "cylinder_speed", "steering.bell", "steering.s"))
            )
        ),
        reconstruction=study.reconstruction,
    )


def _writer(lines: list[Line], section: str) -> Callable[..., None]:
    """Return a function that adds lines to a section of the sheet."""

    def add(name: str, symbol: str, value: Any, unit: str, shown_in: str, how: str) -> None:
        lines.append(Line(section, name, symbol, float(value), unit, shown_in, how))

    return add


def _patch(lines: list[Line], element: RotaryLinearIVT, geometry: ContactGeometry, contact: PressedContact) -> None:
    e_star = plane_strain_modulus(geometry.wheel_material, geometry.cylinder_material)
    along = 1.0 / element.wheel_radius + 1.0 / element.cylinder_radius
    add = _writer(lines, "Patch, wheel steered along the circumference")

    patch = contact.patch
    add("preload", "P", element.preload, "N", "N", "given")
    add("plane-strain modulus", "E*", e_star, "Pa", "GPa", "1/E* = sum of (1 - nu^2)/E")
    add("relative radius, rolling", "1/c_x", 1.0 / along, "m", "mm", "c_x = 1/r + 1/R")
    add("relative radius, lateral", "1/c_y", geometry.crown_radius, "m", "mm", "c_y = 1/r_c")
    add("semi-axis, rolling", "a", patch.a, "m", "mm", "Hertz, elliptic integrals (johnson1985)")
    add("semi-axis, lateral", "b", patch.b, "m", "mm", "")
    add("axis ratio", "a/b", contact.axis_ratio, "1", "1", "")
    add("peak pressure", "p0", patch.peak_pressure, "Pa", "GPa", "3 P/(2 pi a b)")
    add("mean pressure", "pm", patch.mean_pressure, "Pa", "GPa", "2/3 p0")
    add("approach", "delta", patch.approach, "m", "um", "of distant points")
    slanting, across = _steered(element).values()
    how = f"axis turned {math.degrees(slanting.rotation):.1f} deg from rolling, p0 = {_giga(slanting)} GPa"
    add("axis ratio at 45 deg", "a/b", slanting.axis_ratio, "1", "1", how)
    add("axis ratio at 90 deg", "a/b", across.axis_ratio, "1", "1", f"p0 = {_giga(across)} GPa")


def _steered(element: RotaryLinearIVT) -> dict[int, PressedContact]:
    """The contact at steering angles in degrees; none for measured values."""
    if element.geometry is None:
        return {}
    radii = {"wheel_radius": element.wheel_radius, "cylinder_radius": element.cylinder_radius}
    return {
        degrees: element.geometry.press(**radii, preload=element.preload, steering_angle=math.radians(degrees))
        for degrees in (45, 90)
    }


def _giga(contact: PressedContact) -> str:
    return plain(contact.patch.peak_pressure / 1e9, 3)


def _strength(lines: list[Line], element: RotaryLinearIVT, geometry: ContactGeometry, contact: PressedContact) -> None:
    add = _writer(lines, "Strength")
    stress = geometry.stress(contact)
    for body, material in geometry.bodies.items():
        allowed = "yield strength unknown"
        if material.yield_strength is not None:
            allowed = f"yields at {plain(0.5 * material.yield_strength / 1e6)} MPa (half of yield strength, Tresca)"
        depth = f"{plain(stress.depth[body] * 1e3, 3)} mm below the surface"
        add(f"largest shear, {body}", "tau", stress.shear[body], "Pa", "MPa", f"{depth}; {allowed}")
    what = {
        Limit.YIELD: "largest shear over half of yield strength",
        Limit.HARDNESS: "mean pressure over hardness",
    }
    for limit, demand in stress.utilisation.items():
        how = f"{what[limit]}{': EXCEEDED' if demand > 1.0 else ''}"
        add(f"utilisation, {limit.words}", "", demand, "1", "%", how)
    patch = contact.patch
    for body, material in geometry.bodies.items():
        if material.yield_strength is None or contact.axis_ratio > shakedown.LONGEST:
            continue
        allowed = shakedown.shakedown_pressure(patch.a, patch.b, 0.5 * material.yield_strength, element.friction)
        how = f"repeated rolling stays elastic below it (johnson1985); p0 is {plain(patch.peak_pressure / allowed, 2)} of it"
        how += "; with the friction limit at rest" if _falls(geometry) else ""
        add(f"shakedown pressure, {body}", "", allowed, "Pa", "GPa", how)


def _tube(lines: list[Line], drive: CoboticDrive, tube: Tube, contact: PressedContact) -> None:
    add = _writer(lines, "Cylinder as a tube, wheel half way between its end plates")
    middle, preload = 0.5 * tube.length, drive.transmission.preload
    slender = tube.shell.radius / tube.shell.thickness
    rough = "" if slender >= _THIN else f"; an estimate, as R/t = {plain(slender, 2)} is below {_THIN:g}"
    unknown = "; the density of the material is not stated" if tube.mass is None else ""
    add("mass", "m", _known(tube.mass), "kg", "kg", f"tube and end plates{unknown}")
    how = "about its axis"
    if drive.cylinder_inertia is not None:
        how += f"; the drive states {plain(1e3 * drive.cylinder_inertia)} g m^2, which is used"
    add("inertia", "J", _known(tube.inertia), "kg m^2", "g m^2", how)
    add("ovalisation", "", preload * tube.ovalisation(middle), "m", "um", f"what the wall gives way{rough}")
    add(
        "bending",
        "",
        preload * tube.bending(middle),
        "m",
        "um",
        "of the tube that stays round, with shear; adds to the ovalisation",
    )
    tension = preload * tube.tension(middle, math.sqrt(contact.patch.a * contact.patch.b))
    strength, allowed = tube.material.yield_strength, "yield strength unknown"
    if strength is not None:
        allowed = f"{plain(100.0 * tension / strength, 3)} % of the yield strength; fatigue is not judged"
    add("tension in the wall", "", tension, "Pa", "MPa", f"at its inside, once a turn: {allowed}{rough}")
    beam = preload * beams.stress(tube.section, tube.length, middle)
    add("bending stress", "", beam, "Pa", "MPa", "as a beam; part of the tension along the axis")
    first = _known(tube.first_mode) / (2.0 * math.pi)
    add(
        "first bending mode",
        "",
        first,
        "1/s",
        "Hz",
        "at most: a slender beam on its end plates, without motor and wheel",
    )


def _known(value: Any) -> float:
    """A value, or nan if it is None, which a sheet shows as a dash."""
    return math.nan if value is None else float(value)


def _falls(geometry: ContactGeometry) -> bool:
    """Whether the friction limit falls with speed."""
    return geometry.friction_decay_speed is not None and geometry.fast_friction_ratio < 1.0


def _friction(lines: list[Line], drive: CoboticDrive, groups: LossGroups) -> None:
    """The slip force, and the friction limit behind it where that depends on the speed."""
    add = _writer(lines, "Creep")
    element = drive.transmission
    if element.geometry is None or not _falls(element.geometry):
        add("slip force", "mu P", groups.slip_force, "N", "N", "")
        return
    speed = plain(abs(element.cylinder_radius * drive.cylinder_speed), 3)
    how = f"falls to {plain(element.geometry.fast_friction_ratio, 3)} of it at high speed"
    add("friction limit at rest", "mu0", element.friction, "1", "1", how)
    add(
        "friction limit",
        "mu",
        element.friction_limit(drive.cylinder_speed),
        "1",
        "1",
        f"at the surface speed of {speed} m/s",
    )
    add(
        "slip force",
        "mu P",
        groups.slip_force,
        "N",
        "N",
        f"at {speed} m/s, as in all that follows for a wheel that rolls",
    )


def _creep(lines: list[Line], drive: CoboticDrive, groups: LossGroups) -> None:
    add = _writer(lines, "Creep")
    element = drive.transmission

    contact = element.contact
    if contact is not None:
        add("combined shear modulus", "G", contact.shear_modulus, "Pa", "GPa", "2/(1/G1 + 1/G2)")
        for name, value in contact.coefficients._asdict().items():
            how = {"c22": "Kalker's lateral coefficient (kalker1990)", "c11": "longitudinal", "c23": "lateral by spin"}
            add(f"creep coefficient {name.upper()}", name.upper(), value, "1", "1", how.get(name, "spin moment"))
    how = "given" if contact is None else "C22 G a b"
    add("creep stiffness", "C", groups.creep_stiffness, "N", "kN", how)
    for degrees, steered in _steered(element).items():
        how = f"{plain(steered.creep_stiffness / groups.creep_stiffness, 3)} of C"
        add(f"creep stiffness at {degrees} deg", "C", steered.creep_stiffness, "N", "kN", how)
    _friction(lines, drive, groups)
    add("creep group", "K", groups.creep_group, "1", "1", "C/(mu P)")
    if contact is None:
        how = f"assumed for law exact, with Poisson's ratio {groups.poisson:g}: measured values do not tell the patch"
        add("axis ratio", "a/b", groups.axis_ratio, "1", "1", how)
    for name, law in creep.LAWS.items():
        if law.flow_factor is not None:
            continue  # below 70 % of the slip force it is the linear law
        how = f"at half the slip force, law {name}{', in use' if law == element.creep_law else ''}"
        if law.on_patch is not None and not NARROWEST <= groups.axis_ratio <= WIDEST:
            how += f"; fitted for a/b from {NARROWEST:g} to {WIDEST:g}: that of the nearest"
        creepage = groups.formulas(law).creepage(HALF) / groups.creep_group
        add("creepage", "u/|v|", creepage, "1", "‰", how)


def _rolling(lines: list[Line], drive: CoboticDrive, groups: LossGroups) -> None:
    add = _writer(lines, f"Rolling, cylinder at {plain(drive.cylinder_speed)} rad/s")
    element = drive.transmission
    geometry, contact = element.geometry, element.contact

    speed = abs(element.cylinder_radius * drive.cylinder_speed)
    turning = speed / element.wheel_radius
    add("surface speed", "R omega", speed, "m/s", "m/s", "")
    add("wheel speed", "", turning, "rad/s", "rpm", "R omega/r; higher by 1/cos(phi) when steered")
    how = "given" if geometry is None else f"alpha_fr 3 P a/16 with alpha_fr = {plain(geometry.hysteresis_factor, 3)}"
    add("hysteresis torque", "tau_in", groups.rolling_torque, "N m", "mN m", how)
    if geometry is not None and contact is not None:
        paper = hysteresis.line_torque(element.preload, contact.patch.a, geometry.hysteresis_factor)
        add("as a line contact", "", paper, "N m", "mN m", "alpha_fr 2 P a/(3 pi), as in faulring2006")
        lateral = geometry.lateral_share * groups.slip_force
        moment = geometry.axle.moment(element.preload, lateral, element.wheel_radius, turning)
        bearing = geometry.axle_bearing
        model = "M = mu F d/2" if bearing.friction_model == "coefficient" else "SKF model"
        how = f"two {bearing.name}, {model}, lateral force {plain(lateral, 3)} N"
        add("bearing torque", "tau_wa", moment.total, "N m", "mN m", how)
        if bearing.friction_model == "skf":
            for name in ("rolling", "sliding", "seal", "drag"):
                part = getattr(moment.first, name) + getattr(moment.second, name)
                add(f"  {name} part", "", part, "N m", "mN m", "")
        lateral = geometry.lateral_share * element.slip_force
        starting = geometry.axle.starting_moment(element.preload, lateral, element.wheel_radius)
        how = f"from rest, lateral force {plain(lateral, 3)} N" if _falls(geometry) else "from rest"
        add("bearing torque at start", "", starting, "N m", "mN m", how)
        if groups.rolling_torque > 0:
            share = groups.bearing_torque / groups.rolling_torque
            add("bearing over hysteresis", "", share, "1", "1", "about 10 in faulring2006")
    else:
        add("bearing torque", "tau_wa", groups.bearing_torque, "N m", "mN m", "given")
    add("rolling resistance", "", groups.rolling_force, "N", "N", "(tau_in + tau_wa)/r")
    add("rolling group", "H", groups.rolling_group, "1", "1", "(tau_in + tau_wa)/(r mu P)")


def _steering(lines: list[Line], steering: SteeringPlant, element: RotaryLinearIVT) -> None:
    add = _writer(lines, "Steering")

    torques = steering.friction_torques(element)
    if element.contact is not None:
        patch = element.contact.patch
        add(
            "to turn the patch",
            "",
            torques["patch"],
            "N m",
            "mN m",
            f"3/8 {'mu' if element.turns_with_spin else 'mu_s'} P times a quarter of the patch perimeter",
        )
        thin = spin.line_moment(element.preload, patch.b, steering.sliding_friction)
        add("as a uniform line", "", thin, "N m", "mN m", "mu_s P b/2, as in faulring2006")
    else:
        add("to turn the patch", "", torques["patch"], "N m", "mN m", "mu_s P b/2")
    how = "given" if steering.bell_bearing is None else f"{steering.bell_bearing.name} under the preload, from rest"
    add("bell bearing torque", "", torques["bell"], "N m", "mN m", how)
    add("bell friction", "c_b", torques["bell"] / element.preload, "m", "mm", "torque over preload")


def _spin(lines: list[Line], drive: CoboticDrive) -> None:
    """Steering as spin: of the rolling patch, and on the spot."""
    add = _writer(lines, "Steering as spin")
    element = drive.transmission
    rolling = abs(element.cylinder_radius * drive.cylinder_speed)
    patch = turning.TurningPatch.of(element, element.groups(drive.cylinder_speed))
    add("rolling speed", "v", rolling, "m/s", "m/s", "of the cylinder's surface: link locked")
    for rate in STEERING_RATES:
        force, moment = turning.law(0.0, rate, rolling, **patch._asdict())
        add(f"lateral force at {rate:g} rad/s", "", force, "N", "N", "without creep, by spin alone; exact theory")
        add(f"moment at {rate:g} rad/s", "", moment, "N m", "mN m", "")
    creep, moment = turning.on_the_spot(element, HALF * element.slip_force)
    half = "half the slip force"
    if element.geometry is not None and _falls(element.geometry):
        half = f"{plain(HALF * element.slip_force, 3)} N, half the slip force at rest"
    how = f"of a locked link under {half}, per angle steered while the cylinder rests"
    add("creep on the spot", "", creep, "m/rad", "mm/rad", how)
    add("moment on the spot", "", moment, "N m", "mN m", "under the same force")


def _life(
    lines: list[Line], drive: CoboticDrive, geometry: ContactGeometry, contact: PressedContact, groups: LossGroups
) -> None:
    add = _writer(lines, "Life, half the slip force sideways")
    element = drive.transmission

    lateral = HALF * groups.slip_force
    revolutions = geometry.axle.life(element.preload, lateral, element.wheel_radius)
    turning = abs(element.cylinder_radius * drive.cylinder_speed) / element.wheel_radius
    add("axle bearings, L10", "L10", revolutions, "1", "1", "revolutions that 90 % of bearing pairs survive (ISO 281)")
    add("at cylinder speed", "", revolutions * 2.0 * math.pi / turning, "s", "h", "in continuous rotation")
    safety = geometry.axle.static_safety(element.preload, lateral, element.wheel_radius)
    how = "C0 over equivalent static load (ISO 76); below 1 the raceways are dented"
    add("static safety", "s0", safety, "1", "1", how)
    hardness = min((body.hardness for body in geometry.bodies.values() if body.hardness is not None), default=None)
    if geometry.wear_coefficient is None or hardness is None:
        return
    creepage = groups.formulas(element.creep_law).creepage(HALF) / groups.creep_group
    distance = wear.rolling_distance(
        depth=WORN,
        track_radius=element.wheel_radius,
        track_width=2.0 * contact.patch.b,
        lateral_force=lateral,
        creepage=creepage,
        friction=element.friction_limit(drive.cylinder_speed),
        hardness=hardness,
        wear_coefficient=geometry.wear_coefficient,
    )
    how = f"Archard, k = {geometry.wear_coefficient:.1g}: order of magnitude only"
    add(f"rolling to {WORN * 1e6:.0f} um of wear", "", distance, "m", "km", how)


def _temperature(
    lines: list[Line], drive: CoboticDrive, geometry: ContactGeometry, contact: PressedContact, groups: LossGroups
) -> None:
    add = _writer(lines, f"Flash temperature, half the slip force, cylinder at {plain(drive.cylinder_speed)} rad/s")
    element, patch = drive.transmission, contact.patch
    speed = abs(element.cylinder_radius * drive.cylinder_speed)
    resistances = []
    for body, material in geometry.bodies.items():
        if material.conductivity is None or material.heat_capacity is None:
            return
        found = flash.resistance(patch.a, patch.b, speed, material.conductivity, material.heat_capacity)
        peclet = speed * patch.a * material.heat_capacity / material.conductivity
        add(f"thermal resistance, {body}", "R", found, "K/W", "K/W", f"moving source, V a c/k = {plain(peclet, 3)}")
        resistances.append(found)
    power = element.operate(
        cylinder_speed=drive.cylinder_speed, steering_angle=0.0, link_force=HALF * groups.slip_force
    ).losses["creep"]
    add("creep power", "", power, "W", "W", "f_u u, all of it heat in the patch")
    how = "of the patch above the bodies, heat spread like the pressure; about twice that, as only part of the patch slides"
    add("flash temperature", "", flash.temperature_rise(power, *resistances), "K", "K", how)


def _efficiency(lines: list[Line], drive: CoboticDrive, groups: LossGroups) -> None:
    add = _writer(lines, "Efficiency of the element at half the slip force")
    element = drive.transmission
    for ratio in RATIOS:
        point = element.operate(
            cylinder_speed=abs(drive.cylinder_speed),
            steering_angle=-math.atan(1.0 / ratio),
            link_force=HALF * groups.slip_force,
        )
        how = "surface speed : link speed"
        if point.efficiency != point.efficiency:
            how += "; the wheel slips, or the rolling loss exceeds the transmitted power"
        add(f"at {ratio:g}:1", "eta", point.efficiency, "1", "%", how)

"""A drive as an actuator of MuJoCo: a plugin in C, a fragment of MJCF that uses it, and a model that runs at once.

The drive follows a commanded force as far as voltage, current, temperature and the friction of the wheel permit; the law behind
is that of `operate` with a winding at its temperature. Energy from the supply and temperatures are states of the actuator.
"""

from __future__ import annotations

import hashlib
import importlib.util
import math
import sys
from dataclasses import replace
from importlib import resources
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Comment, Element, SubElement, indent, tostring

import numpy as np

from infinivar._core import extras
from infinivar._core.array_namespace import Array, namespace
from infinivar._core.c_library import FLAGS, SWITCH, CompilerError, binary, compiler
from infinivar.drivetrain.drive import followed, operated
from infinivar.errors import InputError, ParameterError, printable
from infinivar.exports.laws import COURSE, Law, function, identifier, record, results_of
from infinivar.exports.plant import naming_laws
from infinivar.limits import Limit
from infinivar.motion.course import Course
from infinivar.parts import heat
from infinivar.parts.heat_steps import REFERENCE, nodes_of
from infinivar.parts.motor import Motor

_STATES = ("energy_J", "winding_K", "housing_K")
"""States of an actuator; the temperatures are stored as rises above ambient."""
_LIMITS = (Limit.SLIP, Limit.VOLTAGE, Limit.PEAK, Limit.DEMAGNETISATION, Limit.TEMPERATURE)
"""What limits the force; the other demands are of ratings, and are only measured."""
_REACTION = 0.1
"""The winding heats up no faster than would bring it to its limit within this time. [s]"""
_LEAST = 1e-30
"""Keeps a divisor from 0."""
_SMALL_MOTION = 1e-6
"""Speed and acceleration at which inertias are found. [m s^-1], [m s^-2]"""
_USUAL_LOAD = 1.0
"""Mass or moment of inertia of the load of the model where none is stated. [kg], [kg m^2]"""


def actuator_law(drive: Any) -> Law:
    """The law of a drive with its motor at temperatures: powers, losses, demands and rates of the states.

    Parameters
    ----------
    drive : CoboticDrive or ConventionalDrive

    Returns
    -------
    Law   Of position [m or rad], speed, force, and the temperatures of winding, housing and ambient [K].

    Source: heat as in `infinivar.parts.heat`, maxon2020.
    """
    motor: Motor = drive.motor
    heated = not heat.missing(motor)

    def evaluate(*, winding: Array, housing: Array, ambient: Array, **values: Array) -> dict[str, Array]:
        warm = heat.warm(motor, winding) if heated else motor
        point = operated(replace(drive, motor=warm), **values)
        demands = dict(point.utilisation)
        rates: list[Any] = [0.0, 0.0]
        if heated:
            current = point.states["motor_current_A"]
            friction = sum(point.losses.get(name, 0.0) for name in ("motor friction", "motor iron"))
            rates, demands[Limit.TEMPERATURE] = _heat(warm, current, friction, winding, housing, ambient)
        found = results_of(point, {limit.name: demand for limit, demand in demands.items()})
        return {**found, "winding_K_per_s": rates[0], "housing_K_per_s": rates[1]}

    rotary = drive.axis.rotary
    units = ("rad", "rad/s", "N m") if rotary else ("m", "m/s", "N")
    inputs = dict(zip(("position", "speed", "force"), units, strict=True))
    return Law("actuator", {**inputs, "winding": "K", "housing": "K", "ambient": "K"}, evaluate)


def _heat(motor: Motor, current: Array, friction: Array, winding: Array, housing: Array, ambient: Array) -> Any:
    """Rates of the temperatures, and the current over that which lets the winding approach its limit."""
    xp = namespace(current, winding)
    nodes, joule = nodes_of(motor), current * current * motor.resistance
    rates = nodes.rates(joule, friction, winding, housing, ambient)
    across = (winding - housing) / nodes.winding_to_housing
    left = across + nodes.capacities[0] * ((motor.max_winding_temperature or math.nan) - winding) / _REACTION
    return rates, xp.sqrt(joule / xp.maximum(left, _LEAST))


def mujoco_files(drive: Any, name: str, load_mass: float | None) -> tuple[dict[str, bytes], tuple[str, ...]]:
    """Plugin, its source, fragment and model by the names of the files; and notes.

    Parameters
    ----------
    drive : CoboticDrive or ConventionalDrive
    name : str          Of files, plugin ("infinivar.NAME"), instance, actuator and joint: letters, digits and "_".
    load_mass : float   Mass or moment of inertia that the model moves; None: 1. [kg] or [kg m^2]

    Raises
    ------
    InputError
        If MuJoCo or a C compiler is missing, the compiler fails, or a law has no C.

    Source: todorov2012.
    """
    extras.check("mujoco", "robots", "--as mujoco")
    command = compiler()
    if command is None:
        raise InputError(
            f"--as mujoco needs a C compiler: cc, gcc, clang or that of the variable CC, and {SWITCH} not 0"
        )
    headers, library = _mujoco()
    with naming_laws():
        text, sensors, version = plugin_source(drive, name)
    linked = () if sys.platform == "darwin" else ("-Wl,--no-as-needed",)
    flags = (*FLAGS, "-fvisibility=hidden", "-isystem", str(headers), *linked, str(library))
    failed = f"--as mujoco: the C compiler {' '.join(command)} failed with the headers of MuJoCo in {headers}"
    try:
        compiled = binary(text, "model.so", *flags)
    except CompilerError as problem:
        raise InputError(f"{failed}: {printable(str(problem))}") from problem
    if compiled is None:
        raise InputError(failed)
    inertia, notes = _inertia(drive)
    if load_mass is None:
        notes = (
            *notes,
            f"the load of {name}.xml is {_USUAL_LOAD:g} {'kg m^2' if drive.axis.rotary else 'kg'}: none is stated",
        )
    ending = "dylib" if sys.platform == "darwin" else "so"
    return {
        f"{name}.{ending}": compiled,
        f"{name}_mujoco.c": text.encode(),
        f"{name}_actuator.xml": _fragment(name, sensors, version),
        f"{name}.xml": _model(name, f"{name}.{ending}", drive.axis.rotary, load_mass, inertia),
    }, notes


def _mujoco() -> tuple[Path, Path]:
    """Folder of headers, and library, of the MuJoCo that is installed."""
    spec = importlib.util.find_spec("mujoco")
    folder = Path((spec and spec.origin) or "").parent
    library = next((one for ending in ("so.*", "*.dylib") for one in sorted(folder.glob(f"libmujoco.{ending}"))), None)
    if library is None or not (folder / "include" / "mujoco" / "mujoco.h").is_file():
        raise InputError(f"--as mujoco: {folder} has no headers and library of MuJoCo; reinstall the wheel of mujoco")
    return folder / "include", library


def plugin_source(drive: Any, name: str) -> tuple[str, tuple[str, ...], str]:
    """C of the plugin, the names of what its sensors measure, and the version: the same text for the same law.

    Raises
    ------
    TypeError, AttributeError
        If a law of another package decides by a value, or calls what C has not.
    """
    law = actuator_law(drive)
    tape, results = record(law)
    shown = [identifier(one) for one in results]
    sensors = (*_STATES, *shown[:-2])
    limits = [shown.index(f"demand_{limit.name}") for limit in _LIMITS if f"demand_{limit.name}" in shown]
    rates = [shown.index("power_in_W"), len(shown) - 2, len(shown) - 1]
    quoted = ", ".join(f'"{one}"' for one in sensors)
    lines = [
        "#include <math.h>",
        "",
        "enum { POSITION, SPEED, FORCE, WINDING_IN, HOUSING_IN, AMBIENT_IN, INPUTS, SUPPLY = INPUTS };",
        f"enum {{ OUTPUTS = {len(shown)}, SENSORS = {len(sensors)}, LIMITS = {len(limits)} }};",
        f"enum {{ VOLTAGE_OUT = {shown.index('motor_voltage_V')}, VOLTAGE_DEMAND = {shown.index('demand_VOLTAGE')} }};",
        f'static const char plugin_name[] = "infinivar.{name}";',
        f"enum {{ ROTARY = {int(drive.axis.rotary)} }};",
        f"static const double AMBIENT = {REFERENCE!r};",
        f"static const char *const sensors[] = {{{quoted}}};",
        f'static const char known[] = "{", ".join(sensors)}";',
        f"static const int limits[] = {{{', '.join(map(str, limits))}}};",
        f"static const int rates[] = {{{', '.join(map(str, rates))}}};",
        "static const double settled[] = {1e-12};",
        "",
        *function("static void law", "law_data", tape, results, "double", ("INPUTS", "OUTPUTS")),
        (resources.files("infinivar.exports") / "data" / "mujoco.c").read_text("utf-8"),
    ]
    version = hashlib.sha256("\n".join(lines).encode()).hexdigest()[:16]
    return "\n".join([f'static const char version[] = "{version}";', *lines]), sensors, version


def _inertia(drive: Any) -> tuple[float, tuple[str, ...]]:
    """Mass or moment of inertia of the drive at its load, at position 0; and notes."""
    moving: dict[str, Any] = {name: np.asarray(0.0) for name in COURSE}
    moving |= {"speed": np.asarray(_SMALL_MOTION)}
    try:
        with np.errstate(all="ignore"):
            taken, held = (
                sum(map(float, followed(drive, Course(**{**moving, **more})).stored.values()))
                for more in ({"acceleration": np.asarray(_SMALL_MOTION)}, {})
            )
    except ParameterError as problem:
        return 0.0, (f"the joint has no armature: {problem}",)
    found = (taken - held) / _SMALL_MOTION**2
    if not (math.isfinite(found) and found >= 0.0):
        return 0.0, ("the joint has no armature: the drive cannot move at position 0",)
    return found, ()


def _fragment(name: str, sensors: tuple[str, ...], version: str) -> bytes:
    root = Element("mujocoinclude")
    plugin = f"infinivar.{name}"
    instance = SubElement(SubElement(SubElement(root, "extension"), "plugin", plugin=plugin), "instance", name=name)
    SubElement(instance, "config", key="ambient", value=repr(REFERENCE))
    SubElement(instance, "config", key="version", value=version)
    known = {"name": name, "joint": name, "plugin": plugin, "instance": name, "actdim": str(len(_STATES))}
    SubElement(SubElement(root, "actuator"), "plugin", known)
    measured = SubElement(root, "sensor")
    for one in sensors:
        SubElement(measured, "plugin", name=f"{name}.{one}", plugin=plugin, instance=name)
    return _written(root)


def _model(name: str, library: str, rotary: bool, load_mass: float | None, inertia: float) -> bytes:
    mass = max(_USUAL_LOAD if load_mass is None else load_mass, 1e-9)
    root = Element("mujoco", model=name)
    root.append(Comment(f" Load the plugin first: mujoco.mj_loadPluginLibrary(path of {library}). "))
    SubElement(root, "option", timestep="0.001")
    body = SubElement(SubElement(root, "worldbody"), "body", name="load")
    body.append(Comment(" armature: mass or moment of inertia of the drive at its load, at position 0 "))
    kind, axis = ("hinge", "0 0 1") if rotary else ("slide", "1 0 0")
    SubElement(body, "joint", name=name, type=kind, axis=axis, armature=f"{inertia:.9g}")
    weight = {"mass": "1" if rotary else repr(mass), "diaginertia": " ".join([repr(mass if rotary else 1e-3)] * 3)}
    SubElement(body, "inertial", {"pos": "0 0 0", **weight})
    SubElement(body, "geom", type="box", size="0.05 0.02 0.02", contype="0", conaffinity="0")
    SubElement(root, "include", file=f"{name}_actuator.xml")
    return _written(root)


def _written(root: Element) -> bytes:
    indent(root)
    return tostring(root) + b"\n"

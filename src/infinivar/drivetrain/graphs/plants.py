"""Bond graphs of the drive-trains: the plants of the paper's Figs 2, 6 and 11-14, from parts.

The elements use the laws of `infinivar.contact`, `infinivar.parts` and `infinivar.transmission`. Friction sticks below a
`stick_speed` (see `infinivar.contact.friction.coulomb`), which is stated at the link and scaled to each shaft by its ratio.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, cast

from infinivar._core.array_namespace import Array, namespace
from infinivar.bondgraph import graph as bg
from infinivar.bondgraph.graph import BondGraph, Element, Parameter, Signal
from infinivar.contact.friction import STICK_SPEED
from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.drivetrain.drive import Drive, check_graph, needed, refuse_machine
from infinivar.drivetrain.graphs import compliances, contact_pieces, cylinder_support, output_pieces, pieces, stages
from infinivar.drivetrain.graphs.pieces import Electrical
from infinivar.errors import ParameterError, require
from infinivar.transmission.rotary_linear import RotaryLinearIVT

CONVENTIONAL_STICK_SPEED = 1e-5
"""Default link speed below which friction of a conventional drive sticks; lower, because a load held by friction creeps as long
as it rests. [m s^-1]"""


def lossless_transmission(ivt: RotaryLinearIVT) -> BondGraph:
    """The ideal element: one transformer, modulated by the steering angle.

    Source: faulring2006, Fig 2, Eq 1 and Eq 2.
    """
    return BondGraph(
        "Lossless transmission",
        [
            bg.one("surface", r"\omega", title="cylinder"),
            bg.transformer(
                "wheel", r"-R\tan\phi", _lossless_ratio, signals=("phi",), parameters=_radius(ivt), title="wheel"
            ),
            bg.one("link", r"\dot{l}"),
        ],
        ["surface > wheel > link"],
        [Signal(name="phi", symbol=r"\phi")],
    )


def _across(phi: Array, radius: Array) -> Array:
    return radius * _sin(phi)


def _along(phi: Array, radius: Array) -> Array:
    return -radius * _cos(phi)


def transmission_plant(ivt: RotaryLinearIVT, *, cylinder_speed: float, stick_speed: float = STICK_SPEED) -> BondGraph:
    """The element with its creep, rolling and bearing losses; the steering angle `phi` is an input.

    Parameters
    ----------
    ivt : RotaryLinearIVT
    cylinder_speed : float   Speed at which friction limit and bearing friction are evaluated. [rad s^-1]
    stick_speed : float      [m s^-1]

    Returns
    -------
    BondGraph   Open at its 1-junctions "surface" (cylinder speed) and "link"; with `steering_model` "spin" also at "turning"
        (steering rate).

    Raises
    ------
    ParameterError
        If the creep law has a flow loss ("faulring").

    Source: faulring2006, Fig 6, in passive form.
    """
    groups = ivt.groups(cylinder_speed)
    stick = Parameter(r"v_{\varepsilon}", stick_speed, "m/s")
    contact, contact_chains = contact_pieces.contact(ivt, groups, stick)

    def rolling(name: str, symbol: str, torque: Array, title: str) -> Element | None:
        return pieces.friction(name, symbol, float(torque) / ivt.wheel_radius, "N", stick, title)

    attached, chains = pieces.attach(
        rolling=(
            rolling("hysteresis", r"f_{in}", groups.rolling_torque, "rolling"),
            rolling("axle", r"f_{wa}", groups.bearing_torque, "bearing"),
        )
    )
    return BondGraph(
        "Transmission plant",
        [
            bg.one("surface", r"\omega"),
            bg.one("link", r"\dot{l}"),
            _turn("surface_across", r"R\sin\phi", _across, _radius(ivt)),
            _turn("surface_along", r"-R\cos\phi", _along, _radius(ivt)),
            _turn("link_across", r"\cos\phi", _cos, {}),
            _turn("link_along", r"\sin\phi", _sin, {}),
            bg.zero("lateral", "f_u"),
            bg.zero("tractive", "f_r"),
            bg.one("rolling", "v"),
            *contact,
            *attached,
        ],
        [
            "surface > surface_across > lateral",
            "link > link_across > lateral",
            "surface > surface_along > tractive",
            "link > link_along > tractive",
            *contact_chains,
            "tractive > rolling",
            *chains,
        ],
        [Signal(name="phi", symbol=r"\phi"), Signal(name="v", symbol="v", of="rolling")],
    )


def steering_plant(
    drive: CoboticDrive, *, electrical: Electrical = "current", stick_speed: float = STICK_SPEED
) -> BondGraph:
    """Steering motor, lossless gear, and the bell with its friction; measures the steering angle `phi`.

    Raises
    ------
    ParameterError
        If a value that motion requires is missing; the message names the field.

    Source: faulring2006, Fig 11.
    """
    steering = drive.steering
    if steering is None:
        raise ParameterError("steering is missing: time-domain simulation needs the steering plant")
    friction = steering.friction_torques(drive.transmission)
    turning = stick_speed / drive.transmission.wheel_radius
    stick = Parameter(r"\varepsilon_s", turning, "rad/s")
    motor_stick = Parameter(r"\varepsilon_{m,s}", turning * steering.ratio, "rad/s")
    elements, chains, signals = pieces.motor_terminals(
        steering.motor, drive.steering_amplifier, "s", electrical, motor_stick, "steering", "steering."
    )
    # A patch that rolls as it turns belongs to the transmission.
    shear = 0.0 if drive.transmission.turns_with_spin else friction["patch"]
    attached, attached_chains = pieces.attach(
        bell=(
            pieces.friction("bell_bearing", r"T_{bell}", friction["bell"], "N m", stick, "steering bearing"),
            pieces.friction("patch", r"T_{shear}", shear, "N m", stick, "steering patch"),
        )
    )
    return BondGraph(
        "Steering plant",
        [
            bg.one("bell", r"\dot{\phi}"),
            bg.inertia("J_b", "J_b", steering.inertia_of_bell, "kg m^2", title="bell"),
            *elements,
            pieces.gear("gear", "n_s", steering.ratio),
            *attached,
        ],
        [*chains, "rotor > gear > bell > J_b", *attached_chains],
        [
            *signals,
            Signal(name="phi", symbol=r"\phi", of="bell", integral=True),
            Signal(name="phi_rate", symbol=r"\dot{\phi}", of="bell"),
        ],
    )


def cylinder_plant(
    drive: CoboticDrive, *, electrical: Electrical = "current", stick_speed: float = STICK_SPEED, alone: bool = True
) -> BondGraph:
    """Cylinder motor, gearhead and cylinder.

    Parameters
    ----------
    alone : bool   Whether the cylinder's bearings carry the preload alone; in a system, the forces of the contact add to it,
        and `cobotic_graph` has their friction.

    Returns
    -------
    BondGraph   Open at its 1-junction "cylinder".

    Raises
    ------
    ParameterError
        If a value that motion requires is missing; the message names the field.

    Source: faulring2006, Fig 12.
    """
    inertia = needed(drive.inertia_of_cylinder, "cylinder_inertia")
    stick = Parameter(
        r"\varepsilon_{m,c}", stick_speed / drive.transmission.cylinder_radius * drive.gearhead.ratio, "rad/s"
    )
    elements, chains, signals = pieces.motor_terminals(drive.motor, drive.amplifier, "c", electrical, stick, "", "")
    gear, gear_chains, gear_signals = pieces.gearhead(drive.gearhead, drive.motor, "c", stick)
    held, held_chains = cylinder_support.under_preload(drive, stick_speed) if alone else ([], [])
    return BondGraph(
        "Cylinder plant",
        [
            bg.one("cylinder", r"\omega"),
            bg.inertia("J_c", "J_c", inertia, "kg m^2", title="cylinder"),
            *elements,
            *gear,
            *held,
        ],
        [*chains, "rotor > gear > cylinder > J_c", *gear_chains, *held_chains],
        [*signals, *gear_signals, Signal(name="omega", symbol=r"\omega", of="cylinder")],
    )


def link_plant(drive: CoboticDrive, *, stick_speed: float = STICK_SPEED) -> BondGraph:
    """The link on its guideway; measures its position `l`.

    Returns
    -------
    BondGraph   Open at its 1-junction "link", which connects to the transmission and the load.

    Raises
    ------
    ParameterError
        If the link's mass is missing.

    Source: faulring2006, Fig 13.
    """
    mass = needed(drive.mass_of_link, "link_mass")
    stick = Parameter(r"v_{\varepsilon}", stick_speed, "m/s")
    drag = drive.guideway.friction_force(drive.transmission.unbalanced_preload)
    attached, chains = pieces.attach(link=(pieces.friction("guideway", r"f_{lg}", drag, "N", stick),))
    return BondGraph(
        "Link plant",
        [
            bg.one("link", r"\dot{l}"),
            bg.inertia("m_l", "m_l", mass, "kg", title="link"),
            *attached,
        ],
        ["link > m_l", *chains],
        pieces.motion_signals("link"),
    )


def cobotic_graph(
    drive: CoboticDrive,
    *,
    load_mass: float | None = None,
    electrical: Electrical = "current",
    imposed_motion: bool = False,
    stick_speed: float = STICK_SPEED,
) -> BondGraph:
    """The complete cobotic system: four plants, a load, and an external force or motion.

    Parameters
    ----------
    drive : CoboticDrive      Requires `cylinder_inertia`, `link_mass`, the motors' inertia and `steering`.
    load_mass : float         Mass of the load; None for none. [kg]
    electrical                "current" or "voltage".
    imposed_motion : bool     Whether the external input is a speed ("motion") rather than a force ("force").
    stick_speed : float       Link speed below which friction sticks. [m s^-1]

    Returns
    -------
    BondGraph   With inputs for cylinder and steering current, and force or motion.

    Raises
    ------
    ParameterError
        If a value that motion requires is missing; the message names the field.

    Source: faulring2006, Fig 10.
    """
    options: dict[str, Any] = {"stick_speed": stick_speed}
    speed, rotary = output_pieces.speed_symbol(drive.output), drive.axis.rotary
    load, chains = pieces.load(load_mass, imposed_motion, speed=speed, rotary=rotary)
    spliced = output_pieces.between(drive.output, "link.link", "output")
    support = cylinder_support.under_wheel(drive, stick_speed)
    return bg.join(
        "Cobotic system",
        {
            "steering": steering_plant(drive, electrical=electrical, **options),
            "cylinder": cylinder_plant(drive, electrical=electrical, alone=False, **options),
            "transmission": transmission_plant(drive.transmission, cylinder_speed=drive.cylinder_speed, **options),
            "link": link_plant(drive, **options),
        },
        [
            "cylinder.cylinder > transmission.surface",
            "transmission.link > link.link",
            *(["steering.bell > transmission.turning"] if drive.transmission.turns_with_spin else []),
            *support.chains,
            *spliced.chains,
            *chains,
        ],
        elements=[*support.elements, *load, *spliced.elements],
        signals=[*support.signals, *spliced.signals],
    )


def conventional_graph(
    drive: ConventionalDrive,
    *,
    load_mass: float | None = None,
    electrical: Electrical = "current",
    imposed_motion: bool = False,
    stick_speed: float = CONVENTIONAL_STICK_SPEED,
) -> BondGraph:
    """The conventional system; arguments as in `cobotic_graph`.

    Source: faulring2006, Fig 14.
    """
    motor_stick = Parameter(
        r"\varepsilon_m", stick_speed / float(drive.stage.travel_per_radian) * drive.gearhead.ratio, "rad/s"
    )
    elements, chains, signals = pieces.motor_terminals(
        drive.motor, drive.amplifier, "n", electrical, motor_stick, "", ""
    )
    gear, gear_chains, gear_signals = pieces.gearhead(drive.gearhead, drive.motor, "n", motor_stick)
    line = output_pieces.drive_end(drive.output)
    spliced = output_pieces.between(drive.output, line, "load")
    speed = output_pieces.speed_symbol(drive.output) if line != "load" else r"\dot{l}"
    stage, stage_chains, stage_signals, path = stages.output_stage(drive, stick_speed)
    torsion, stretch = compliances.gear_torsion(drive), compliances.stage_stretch(drive)
    stages.check_inertias(drive, load_mass or 0.0, imposed_motion)
    path = " > ".join(filter(None, ("rotor > gear", torsion.node, path, stretch.node, line)))
    load, load_chains = pieces.load(load_mass, imposed_motion, at="load", speed=speed, rotary=drive.axis.rotary)
    stick = Parameter(r"v_{\varepsilon}", stick_speed, "m/s")
    attached, attached_chains = pieces.attach(
        **{line: (pieces.friction("guideway", r"f_{lg}", drive.guideway.friction_force(), "N", stick),)}
    )
    encoder = pieces.encoder_signals("rotor") if torsion.node or stretch.node else []
    return BondGraph(
        "Conventional system",
        [
            *load,
            *stage,
            *attached,
            *elements,
            *gear,
            *torsion.elements,
            *stretch.elements,
            *([] if line == "load" else [bg.one(line, r"\dot{l}")]),
            *spliced.elements,
        ],
        [
            *chains,
            path,
            *spliced.chains,
            *stage_chains,
            *attached_chains,
            *gear_chains,
            *load_chains,
            *torsion.chains,
            *stretch.chains,
        ],
        [
            *signals,
            *gear_signals,
            *stage_signals,
            *pieces.motion_signals(line),
            *spliced.signals,
            *torsion.signals,
            *encoder,
        ],
    )


def plant_graph(
    drive: Drive, plant: str = "system", *, electrical: str = "current", load_mass: float | None = None
) -> BondGraph:
    """The graph of a drive, or of one of its plants.

    Parameters
    ----------
    drive : CoboticDrive or ConventionalDrive
    plant : str           "system"; for a cobotic drive also "lossless", "transmission", "steering", "cylinder", "link".
    electrical : str      "current" or "voltage".
    load_mass : float     Mass of the load in the system; None for none. [kg]

    Returns
    -------
    BondGraph   Complete: sources replace the neighbours of a plant.

    Raises
    ------
    ParameterError
        If the plant or electrical side is unknown, or a value that motion requires is missing.

    Source: those of the plants of this module.
    """
    require(electrical in ("current", "voltage"), "electrical", repr(electrical), "current or voltage")
    side = cast(Electrical, electrical)
    refuse_machine(drive, "graph")
    if not isinstance(drive, (CoboticDrive, ConventionalDrive)):
        raise ParameterError(f"a drive of type {type(drive).__name__} has no bond graph")
    check_graph(drive)
    makers: dict[str, Callable[[], BondGraph]] = {}
    if isinstance(drive, ConventionalDrive):
        makers["system"] = lambda: conventional_graph(drive, load_mass=load_mass, electrical=side)
    elif isinstance(drive, CoboticDrive):
        element, speed = drive.transmission, drive.cylinder_speed
        makers = {
            "system": lambda: cobotic_graph(drive, load_mass=load_mass, electrical=side),
            "lossless": lambda: lossless_transmission(element),
            "transmission": lambda: transmission_plant(element, cylinder_speed=speed),
            "steering": lambda: steering_plant(drive, electrical=side),
            "cylinder": lambda: cylinder_plant(drive, electrical=side),
            "link": lambda: link_plant(drive),
        }
    require(plant in makers, "plant", repr(plant), f"one of {', '.join(makers)}")
    neighbours = _NEIGHBOURS.get(plant, {})
    if plant == "transmission" and isinstance(drive, CoboticDrive) and drive.transmission.turns_with_spin:
        neighbours = neighbours | _STEERED
    return _closed(makers[plant](), neighbours)


_STEERED: dict[str, tuple[Element, bool]] = {"turning": (bg.flow_source("from_steering", r"\dot{\phi}"), False)}
"""Source that replaces the steering plant at a contact with spin."""


# Sources that replace a plant's neighbours at its open junctions, and whether they take up power there.
_NEIGHBOURS: dict[str, dict[str, tuple[Element, bool]]] = {
    "lossless": {
        "surface": (bg.flow_source("from_cylinder", r"\omega"), False),
        "link": (bg.effort_source("to_link", "f_l"), True),
    },
    "transmission": {
        "surface": (bg.flow_source("from_cylinder", r"\omega"), False),
        "link": (bg.flow_source("to_link", r"\dot{l}"), True),
    },
    "cylinder": {"cylinder": (bg.effort_source("to_transmission", r"\tau"), True)},
    "link": {"link": (bg.effort_source("from_transmission", "f_l"), False)},
}


def _closed(graph: BondGraph, neighbours: Mapping[str, tuple[Element, bool]]) -> BondGraph:
    sources = [source for source, _ in neighbours.values()]
    bonds = [
        f"{junction} > {source.name}" if takes else f"{source.name} > {junction}"
        for junction, (source, takes) in neighbours.items()
    ]
    return BondGraph(graph.name, [*sources, *graph.elements], [*bonds, *graph.bonds], graph.signals, graph.titles)


def _turn(name: str, symbol: str, law: Callable[..., Array], parameters: dict[str, Parameter]) -> Element:
    """Transformer from a velocity of cylinder or link to one of the wheel's directions."""
    return bg.transformer(name, symbol, law, signals=("phi",), parameters=parameters)


def _radius(ivt: RotaryLinearIVT) -> dict[str, Parameter]:
    return {"radius": Parameter("R", ivt.cylinder_radius, "m")}


def _lossless_ratio(phi: Array, radius: Array) -> Array:
    return -radius * namespace(phi).tan(phi)


def _sin(phi: Array) -> Array:
    return namespace(phi).sin(phi)


def _cos(phi: Array) -> Array:
    return namespace(phi).cos(phi)

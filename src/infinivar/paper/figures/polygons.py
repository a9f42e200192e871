"""Figures 3 and 4: velocities and forces between wheel and cylinder at an operating point, to scale."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from infinivar.figures import style
from infinivar.paper.claims.claim import PaperMachine, at_ratio
from infinivar.paper.figures.steered_wheel import arrow, directions

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from infinivar.transmission.operating_point import OperatingPoint

RATIO, LOAD = 2.0, 0.5
"""Operating point of Figures 3 and 4: surface speed over link speed without creep, and link force over slip force."""

COLOURS = {
    "link": style.COLOURS[0],
    "cylinder": style.COLOURS[1],
    "rolling": style.COLOURS[2],
    "lateral": style.COLOURS[3],
}
"""Colours of link, cylinder, rolling direction and lateral direction in Figures 3 and 4."""

_AROUND_TIP = 1.7
"""Half the width of the enlarged tip over the length of the vector that closes the triangle."""


class Triangles(NamedTuple):
    """How two triangles with a common long side are drawn: that of the directions of both bodies, and that of the wheel."""

    legs: tuple[str, str]
    """From the origin to the tip."""
    long: str
    short: str
    """Closes the second triangle in the enlarged tip."""
    unit: str
    symbols: Mapping[str, str]
    words: Mapping[str, str]
    zero: float
    """Direction of the long side at steering angle 0. [deg]"""
    angle_at: tuple[float, float]
    """Place of the steering angle's label, over the length of the long side."""
    ideal: str
    """Label of the tip without what the short side stands for."""
    side: str
    """Horizontal alignment of that label."""


VELOCITIES = Triangles(
    legs=("cylinder", "link"),
    long="rolling",
    short="lateral",
    unit="m/s",
    symbols={
        "link": r"$\dot{l}\,\hat{\jmath}_2$",
        "cylinder": r"$R\omega\,\hat{\jmath}_1$",
        "rolling": r"$r\dot{\theta}\,\hat{n}_2$",
        "lateral": r"$u\,\hat{n}_1$",
    },
    words={
        "link": r"link speed $\dot{l}$",
        "cylinder": r"surface speed $R\omega$",
        "rolling": r"rolling speed $r\dot{\theta}$",
        "lateral": r"lateral creep $u$",
    },
    zero=-90.0,
    angle_at=(0.3, -0.18),
    ideal="without creep",
    side="left",
)

FORCES = Triangles(
    legs=("link", "cylinder"),
    long="lateral",
    short="rolling",
    unit="N",
    symbols={
        "link": r"$f_l\,\hat{\jmath}_2$",
        "cylinder": r"$-(\tau/R)\,\hat{\jmath}_1$",
        "rolling": r"$-f_r\,\hat{n}_2$",
        "lateral": r"$-f_u\,\hat{n}_1$",
    },
    words={
        "link": r"link force $f_l$",
        "cylinder": r"cylinder force $\tau/R$",
        "rolling": r"rolling resistance $f_r$",
        "lateral": r"lateral force $f_u$",
    },
    zero=0.0,
    angle_at=(0.52, 0.11),
    ideal="without rolling\nresistance",
    side="right",
)

_ON_WHEEL = {"link": 1.0, "cylinder": -1.0, "rolling": -1.0, "lateral": -1.0}
"""Signs of the forces on the wheel along the directions of Figure 3."""


def _operating_point(machine: PaperMachine) -> OperatingPoint:
    """Operating point of Figures 3 and 4: the element drives its link forward."""
    return at_ratio(machine.element, LOAD, RATIO, machine.cylinder_speed)


def _frames(angle: float) -> dict[str, np.ndarray]:
    """Unit vectors seen from above: j2 along the link, j1 against the surface's motion, n1 lateral, n2 rolling."""
    lateral, rolling = directions(angle)
    return {"link": np.array([1.0, 0.0]), "cylinder": np.array([0.0, -1.0]), "lateral": lateral, "rolling": rolling}


def velocities(machine: PaperMachine) -> dict[str, Any]:
    """Velocity vectors; "link" plus "cylinder" equals "rolling" plus "lateral".

    Returns
    -------
    dict
        angle [rad]; amounts: signed, by direction [m/s]; vectors: by direction, seen from above [m/s]; ideal: position of the
        tip without creep [m/s].

    Source: faulring2006, Fig 3.
    """
    point = _operating_point(machine)
    angle = float(point.steering_angle)
    surface = machine.element.cylinder_radius * float(point.cylinder_speed)
    amounts = {
        "link": float(point.link_speed),
        "cylinder": surface,
        "rolling": float(point.rolling_speed),
        "lateral": float(point.creep_speed),
    }
    return {
        "angle": angle,
        "amounts": amounts,
        "vectors": {name: amount * _frames(angle)[name] for name, amount in amounts.items()},
        "ideal": np.array([-surface * math.tan(angle), -surface]),
    }


def forces(machine: PaperMachine) -> dict[str, Any]:
    """Force vectors; "link" plus "cylinder" equals "rolling" plus "lateral".

    Returns
    -------
    dict
        angle [rad]; amounts: signed, by direction, with rolling = (tau_in + tau_wa)/r and the sign of the rolling speed [N];
        vectors: as they act on the wheel, seen from above [N]; ideal: position of the tip without rolling resistance [N];
        power: from the cylinder, to the link, lost to creep, and lost to rolling and bearings [W].

    Source: faulring2006, Fig 4.
    """
    point = _operating_point(machine)
    element, angle = machine.element, float(point.steering_angle)
    resisting = float(element.groups(machine.cylinder_speed).rolling_force)
    amounts = {
        "link": float(point.link_force),
        "cylinder": float(point.torque) / element.cylinder_radius,
        "rolling": math.copysign(resisting, float(point.rolling_speed)),
        "lateral": float(point.lateral_force),
    }
    return {
        "angle": angle,
        "amounts": amounts,
        "vectors": {name: _ON_WHEEL[name] * amount * _frames(angle)[name] for name, amount in amounts.items()},
        "ideal": amounts["link"] * np.array([1.0, -math.tan(angle)]),
        "power": {
            "cylinder": float(point.power_in),
            "link": float(point.power_out),
            "lateral": float(point.losses["creep"]),
            "rolling": float(point.losses["rolling"] + point.losses["bearing"]),
        },
    }


def draw(kind: Triangles, numbers: Mapping[str, Any]) -> Figure:
    """Draw the triangles to scale, and their tip enlarged."""
    with style.styled():
        made, (whole, tip) = style.figure(8.4, 4.6, 1, 2)
        _polygon(whole, kind, numbers["vectors"])
        long = float(np.hypot(*numbers["vectors"][kind.long]))
        _draw_angle(whole, numbers["angle"], long, kind)
        whole.set_title("to scale")
        _close_up(tip, kind, numbers)
        tip.set_title(_enlarged(numbers, kind.short))
        for ax in (whole, tip):
            ax.set(xlabel=f"along the link [{kind.unit}]", ylabel=f"around the cylinder [{kind.unit}]")
        _amounts_below(made, kind, numbers)
    return made


def _polygon(ax: Axes, kind: Triangles, vectors: Mapping[str, np.ndarray]) -> None:
    """Draw both legs from the origin to the tip, and the long side; the enlarged tip shows the remaining gap."""
    first, second = kind.legs
    corner = vectors[first]
    tip = corner + vectors[second]
    size = float(np.max(np.abs(tip)))
    for start, name, inside in (
        (np.zeros(2), first, 0.5 * tip),
        (corner, second, 0.5 * tip),
        (np.zeros(2), kind.long, corner),
    ):
        arrow(ax, start, start + vectors[name], COLOURS[name])
        _label(ax, start, start + vectors[name], kind.symbols[name], COLOURS[name], inside, 0.11 * size)
    ax.plot([0], [0], "ko", ms=3)
    ax.set_aspect("equal")
    for limits, reach in ((ax.set_xlim, float(tip[0])), (ax.set_ylim, float(tip[1]))):
        limits(min(0.0, reach) - 0.25 * size, max(0.0, reach) + 0.3 * size)


def _label(
    ax: Axes, start: np.ndarray, end: np.ndarray, text: str, colour: str, inside: np.ndarray, distance: float
) -> None:
    """Write text beside the middle of a vector, on the side away from the point `inside`."""
    middle, along = 0.5 * (start + end), (end - start) / np.hypot(*(end - start))
    normal = np.array([-along[1], along[0]])
    normal = -normal if normal @ (inside - middle) > 0 else normal
    side = "center" if abs(normal[0]) < 0.6 else "left" if normal[0] > 0 else "right"
    distance *= 1.0 if side == "center" else 0.6
    x, y = middle + distance * normal
    ax.text(x, y, text, color=colour, ha=side, va="center", fontsize=11)


def _draw_angle(ax: Axes, angle: float, length: float, kind: Triangles) -> None:
    """Draw and label the steering angle at the origin, from the direction at angle 0 to the actual one."""
    from matplotlib.patches import Arc

    low, high = sorted((kind.zero, kind.zero - math.degrees(angle)))
    ax.add_patch(Arc((0, 0), 0.7 * length, 0.7 * length, theta1=low, theta2=high, color="black", lw=0.9))
    words = f"$\\phi$ = {math.degrees(angle):.1f}°".replace("-", "\N{MINUS SIGN}")
    x, y = (share * length for share in kind.angle_at)
    ax.text(x, y, words, ha="center", va="center", fontsize=8)


def _close_up(ax: Axes, kind: Triangles, numbers: Mapping[str, Any]) -> None:
    """Draw the tip, where the last leg meets the long side and the short side of the second triangle closes the gap."""
    leg, long, short = kind.legs[1], kind.long, kind.short
    vectors = numbers["vectors"]
    gap = vectors[short]
    tip = vectors[long] + gap
    reach = _AROUND_TIP * float(np.hypot(*gap))
    centre = (tip + vectors[long] + numbers["ideal"]) / 3.0
    for end, name in ((tip, leg), (vectors[long], long)):
        along = vectors[name] / np.hypot(*vectors[name])
        ax.plot(*np.stack([end - 4 * reach * along, end], -1), color=COLOURS[name], lw=1.8, solid_capstyle="butt")
        arrow(ax, end - 0.2 * reach * along, end, COLOURS[name])
        # The label of the leg goes between both lines, the label of the long side outside.
        other = 2.0 * tip - vectors[long] if name == leg else tip
        # Visible length of the line: its label goes beside the middle.
        with np.errstate(divide="ignore"):
            shown = float(np.min((reach + np.sign(along) * (end - centre)) / np.abs(along)))
        _label(ax, end - 1.1 * shown * along, end, kind.symbols[name], COLOURS[name], other, 0.2 * reach)
    arrow(ax, tip - gap, tip, COLOURS[short])
    _label(ax, tip - gap, tip, kind.symbols[short], COLOURS[short], numbers["ideal"], 0.2 * reach)
    ax.plot(*numbers["ideal"], "kx", ms=6, mew=1.4)
    ax.annotate(
        kind.ideal,
        xy=numbers["ideal"],
        xytext=(7 if kind.side == "left" else -7, 7),
        textcoords="offset points",
        ha=kind.side,
        fontsize=8,
    )
    ax.set_aspect("equal")
    ax.set(xlim=(centre[0] - reach, centre[0] + reach), ylim=(centre[1] - reach, centre[1] + reach))
    ax.ticklabel_format(useOffset=False)
    ax.locator_params(nbins=4)


def _amounts_below(made: Figure, kind: Triangles, numbers: Mapping[str, Any]) -> None:
    """Add a legend of all vectors with their signed amounts."""
    from matplotlib.lines import Line2D

    handles = [
        Line2D(
            [],
            [],
            color=COLOURS[name],
            lw=2,
            label=f"{kind.words[name]} = {amount:.4g} {kind.unit}".replace("-", "\N{MINUS SIGN}"),
        )
        for name, amount in numbers["amounts"].items()
    ]
    made.legend(handles=handles, loc="outside lower center", ncols=2)


def _enlarged(numbers: Mapping[str, Any], short: str) -> str:
    """Title of the enlarged tip, with its magnification."""
    whole = max(float(np.max(np.abs(vector))) for vector in numbers["vectors"].values())
    times = 1.5 * whole / (2 * _AROUND_TIP * float(np.hypot(*numbers["vectors"][short])))
    return f"tip, enlarged about {float(f'{times:.1g}'):g} times"

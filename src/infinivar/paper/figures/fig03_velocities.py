"""Figure 3: velocities between wheel and cylinder at an operating point, to scale."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from infinivar.figures import style
from infinivar.paper.claims.claim import Machine, at_ratio
from infinivar.paper.figures.fig01_steered_wheel import arrow, directions

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from infinivar.transmission.operating_point import OperatingPoint

RATIO, LOAD = 2.0, 0.5
"""Operating point of Figures 3 and 4: surface speed over link speed without creep, and link force over slip force."""

TITLE = "Velocities at the contact"

CAPTION = (
    "Velocity of the wheel relative to the cylinder surface at 2:1 and half the slip force, to scale. It is the sum of link and "
    "surface velocity, and also of rolling velocity and lateral creep (Eq 3, Eq 4). Creep is so small that the second triangle "
    "is visible only in the enlarged tip (right). Seen from above: the link moves to the right, the surface up."
)

COLOURS = {
    "link": style.COLOURS[0],
    "cylinder": style.COLOURS[1],
    "rolling": style.COLOURS[2],
    "lateral": style.COLOURS[3],
}
"""Colours of link, cylinder, rolling direction and lateral direction in Figures 3 and 4."""

_AROUND_TIP = 1.7
"""Half the width of the enlarged tip over the length of the vector that closes the triangle."""

_SYMBOLS = {
    "link": r"$\dot{l}\,\hat{\jmath}_2$",
    "cylinder": r"$R\omega\,\hat{\jmath}_1$",
    "rolling": r"$r\dot{\theta}\,\hat{n}_2$",
    "lateral": r"$u\,\hat{n}_1$",
}
_WORDS = {
    "link": r"link speed $\dot{l}$",
    "cylinder": r"surface speed $R\omega$",
    "rolling": r"rolling speed $r\dot{\theta}$",
    "lateral": r"lateral creep $u$",
}


def operating_point(machine: Machine) -> OperatingPoint:
    """Operating point of Figures 3 and 4: the element drives its link forward."""
    return at_ratio(machine.element, LOAD, RATIO, machine.cylinder_speed)


def frames(angle: float) -> dict[str, np.ndarray]:
    """Unit vectors seen from above: j2 along the link, j1 against the surface's motion, n1 lateral, n2 rolling."""
    lateral, rolling = directions(angle)
    return {"link": np.array([1.0, 0.0]), "cylinder": np.array([0.0, -1.0]), "lateral": lateral, "rolling": rolling}


def data(machine: Machine) -> dict[str, Any]:
    """Velocity vectors; "link" plus "cylinder" equals "rolling" plus "lateral".

    Returns
    -------
    dict
        angle [rad]; amounts: signed, by direction [m/s]; vectors: by direction, seen from above [m/s]; ideal: position of the
        tip without creep [m/s].
    """
    point = operating_point(machine)
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
        "vectors": {name: amount * frames(angle)[name] for name, amount in amounts.items()},
        "ideal": np.array([-surface * math.tan(angle), -surface]),
    }


def draw(ax: Axes, numbers: Mapping[str, Any]) -> None:
    """Draw both triangles to scale."""
    polygon(ax, numbers["vectors"], ("cylinder", "link"), "rolling", _SYMBOLS)
    long = float(np.hypot(*numbers["vectors"]["rolling"]))
    draw_angle(ax, numbers["angle"], long, -90.0, (0.3 * long, -0.18 * long))
    ax.set(xlabel="along the link [m/s]", ylabel="around the cylinder [m/s]")


def draw_tip(ax: Axes, numbers: Mapping[str, Any]) -> None:
    """Draw the enlarged tip, in which creep closes the triangle."""
    close_up(ax, numbers, ("link", "rolling", "lateral"), "without creep", "left", _SYMBOLS)
    ax.set(xlabel="along the link [m/s]", ylabel="around the cylinder [m/s]")


def polygon(
    ax: Axes, vectors: Mapping[str, np.ndarray], legs: tuple[str, str], hypotenuse: str, symbols: Mapping[str, str]
) -> None:
    """Draw both legs from the origin to the tip, and the hypotenuse; the enlarged tip shows the remaining gap."""
    corner = vectors[legs[0]]
    tip = corner + vectors[legs[1]]
    size = float(np.max(np.abs(tip)))
    for start, name, inside in (
        (np.zeros(2), legs[0], 0.5 * tip),
        (corner, legs[1], 0.5 * tip),
        (np.zeros(2), hypotenuse, corner),
    ):
        arrow(ax, start, start + vectors[name], COLOURS[name])
        _label(ax, start, start + vectors[name], symbols[name], COLOURS[name], inside, 0.11 * size)
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


def draw_angle(ax: Axes, angle: float, length: float, reference: float, at: tuple[float, float]) -> None:
    """Draw and label the steering angle at the origin, from the direction at angle 0, `reference` [deg], to the actual one."""
    from matplotlib.patches import Arc

    low, high = sorted((reference, reference - math.degrees(angle)))
    ax.add_patch(Arc((0, 0), 0.7 * length, 0.7 * length, theta1=low, theta2=high, color="black", lw=0.9))
    words = f"$\\phi$ = {math.degrees(angle):.1f}°".replace("-", "\N{MINUS SIGN}")
    ax.text(*at, words, ha="center", va="center", fontsize=8)


def close_up(
    ax: Axes,
    numbers: Mapping[str, Any],
    names: tuple[str, str, str],
    ideal: str,
    side: str,
    symbols: Mapping[str, str],
) -> None:
    """Draw the tip, where the last leg meets the long side and the short side of the second triangle closes the gap.

    `names` are the last leg, the long side and the short side. `ideal` labels the position of the tip without the loss that
    the short side stands for; `side` is the horizontal alignment of that label.
    """
    leg, long, short = names
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
        _label(ax, end - 1.1 * shown * along, end, symbols[name], COLOURS[name], other, 0.2 * reach)
    arrow(ax, tip - gap, tip, COLOURS[short])
    _label(ax, tip - gap, tip, symbols[short], COLOURS[short], numbers["ideal"], 0.2 * reach)
    ax.plot(*numbers["ideal"], "kx", ms=6, mew=1.4)
    ax.annotate(
        ideal,
        xy=numbers["ideal"],
        xytext=(7 if side == "left" else -7, 7),
        textcoords="offset points",
        ha=side,
        fontsize=8,
    )
    ax.set_aspect("equal")
    ax.set(xlim=(centre[0] - reach, centre[0] + reach), ylim=(centre[1] - reach, centre[1] + reach))
    ax.ticklabel_format(useOffset=False)
    ax.locator_params(nbins=4)


def amounts_below(made: Figure, numbers: Mapping[str, Any], words: Mapping[str, str], unit: str) -> None:
    """Add a legend of all vectors with their signed amounts."""
    from matplotlib.lines import Line2D

    handles = [
        Line2D(
            [],
            [],
            color=COLOURS[name],
            lw=2,
            label=f"{words[name]} = {amount:.4g} {unit}".replace("-", "\N{MINUS SIGN}"),
        )
        for name, amount in numbers["amounts"].items()
    ]
    made.legend(handles=handles, loc="outside lower center", ncols=2)


def enlarged(numbers: Mapping[str, Any], short: str) -> str:
    """Title of the enlarged tip, with its magnification."""
    whole = max(float(np.max(np.abs(vector))) for vector in numbers["vectors"].values())
    times = 1.5 * whole / (2 * _AROUND_TIP * float(np.hypot(*numbers["vectors"][short])))
    return f"tip, enlarged about {float(f'{times:.1g}'):g} times"


def draw_all(machine: Machine) -> Figure:
    """Draw the figure."""
    numbers = data(machine)
    with style.styled():
        made, (whole, tip) = style.figure(8.4, 4.6, 1, 2)
        draw(whole, numbers)
        draw_tip(tip, numbers)
        whole.set_title("to scale")
        tip.set_title(enlarged(numbers, "lateral"))
        amounts_below(made, numbers, _WORDS, "m/s")
    return made

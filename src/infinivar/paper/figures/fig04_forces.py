"""Figure 4: forces of the contact on the wheel at an operating point, to scale."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from infinivar.figures import style
from infinivar.paper.claims.claim import Machine
from infinivar.paper.figures.fig03_velocities import (
    amounts_below,
    close_up,
    draw_angle,
    enlarged,
    frames,
    operating_point,
    polygon,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

TITLE = "Forces at the contact"

CAPTION = (
    "Force of the cylinder on the wheel at the operating point of Figure 3, to scale. It is the sum of the link force and the "
    "force from the cylinder torque, and also of lateral force and rolling resistance (Eq 5, Eq 6), which oppose the velocities "
    "of Figure 3. Rolling resistance is so small that the second triangle is visible only in the enlarged tip (right)."
)

_SYMBOLS = {
    "link": r"$f_l\,\hat{\jmath}_2$",
    "cylinder": r"$-(\tau/R)\,\hat{\jmath}_1$",
    "rolling": r"$-f_r\,\hat{n}_2$",
    "lateral": r"$-f_u\,\hat{n}_1$",
}
_WORDS = {
    "link": r"link force $f_l$",
    "cylinder": r"cylinder force $\tau/R$",
    "rolling": r"rolling resistance $f_r$",
    "lateral": r"lateral force $f_u$",
}
_ON_WHEEL = {"link": 1.0, "cylinder": -1.0, "rolling": -1.0, "lateral": -1.0}
"""Signs of the forces on the wheel along the directions of Figure 3."""


def data(machine: Machine) -> dict[str, Any]:
    """Force vectors; "link" plus "cylinder" equals "rolling" plus "lateral".

    Returns
    -------
    dict
        angle [rad]; amounts: signed, by direction, with rolling = (tau_in + tau_wa)/r and the sign of the rolling speed [N];
        vectors: as they act on the wheel, seen from above [N]; ideal: position of the tip without rolling resistance [N];
        power: from the cylinder, to the link, lost to creep, and lost to rolling and bearings [W].
    """
    point = operating_point(machine)
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
        "vectors": {name: _ON_WHEEL[name] * amount * frames(angle)[name] for name, amount in amounts.items()},
        "ideal": amounts["link"] * np.array([1.0, -math.tan(angle)]),
        "power": {
            "cylinder": float(point.power_in),
            "link": float(point.power_out),
            "lateral": float(point.losses["creep"]),
            "rolling": float(point.losses["rolling"] + point.losses["bearing"]),
        },
    }


def draw(ax: Axes, numbers: Mapping[str, Any]) -> None:
    """Draw both triangles to scale."""
    polygon(ax, numbers["vectors"], ("link", "cylinder"), "lateral", _SYMBOLS)
    long = float(np.hypot(*numbers["vectors"]["lateral"]))
    draw_angle(ax, numbers["angle"], long, 0.0, (0.52 * long, 0.11 * long))
    ax.set(xlabel="along the link [N]", ylabel="around the cylinder [N]")


def draw_tip(ax: Axes, numbers: Mapping[str, Any]) -> None:
    """Draw the enlarged tip, in which rolling resistance closes the triangle."""
    close_up(ax, numbers, ("cylinder", "lateral", "rolling"), "without rolling\nresistance", "right", _SYMBOLS)
    ax.set(xlabel="along the link [N]", ylabel="around the cylinder [N]")


def draw_all(machine: Machine) -> Figure:
    """Draw the figure."""
    numbers = data(machine)
    with style.styled():
        made, (whole, tip) = style.figure(8.4, 4.6, 1, 2)
        draw(whole, numbers)
        draw_tip(tip, numbers)
        whole.set_title("to scale")
        tip.set_title(enlarged(numbers, "rolling"))
        amounts_below(made, numbers, _WORDS, "N")
    return made

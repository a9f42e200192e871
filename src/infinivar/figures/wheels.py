"""Losses of each wheel of a machine at one point, with the shares of their slip limits; or the machine, if it is given."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from infinivar._core.array_namespace import Array
from infinivar._core.fields import check_instance
from infinivar.errors import InputError, ParameterError
from infinivar.figures import machine as machines
from infinivar.figures import pictures, style
from infinivar.limits import Limit
from infinivar.machines.many_legs import LeggedDrive, MachinePoint
from infinivar.machines.pictures import rollers as sphere
from infinivar.machines.pictures import wheeled
from infinivar.transmission.legs import Legs, LegsPoint
from infinivar.transmission.mechanism import MechanismPoint
from infinivar.transmission.planar import PlanarCobot
from infinivar.transmission.platform import Platform
from infinivar.transmission.spherical import SphericalIVT, SphericalPoint

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Point = MechanismPoint | LegsPoint | MachinePoint | SphericalPoint


def data(found: Point) -> dict[str, Any]:
    """Losses and slip demands by wheel.

    Parameters
    ----------
    found : MechanismPoint, LegsPoint, MachinePoint or SphericalPoint   One point with known losses.

    Returns
    -------
    dict   wheel: what the wheels are; names: of each; losses: by name, (k,) [W]; slip: demand over allowance, (k,); limit;
        shared: losses of what is common to all wheels, by name, or None where the point has the wheels only [W].

    Raises
    ------
    InputError
        If there are many points, or the losses are undefined, which the message gives the limit for.
    """
    kind = found.contact
    demand, limit = np.asarray(found.slip_demand), np.asarray(found.limit)
    if demand.ndim != 1 or limit.ndim:
        raise InputError(f"losses by {kind} are drawn at one point, got points of shape {limit.shape}")
    known = {name: np.broadcast_to(loss, demand.shape) for name, loss in found.contact_losses.items()}
    if not all(np.all(np.isfinite(loss)) for loss in known.values()):
        raise InputError(f"losses by {kind} are undefined at this point: {Limit(int(limit)).words}")
    names = [str(place + 1) for place in range(len(demand))]
    if isinstance(found, SphericalPoint):
        names = [f"{name}\n{of}" for name, of in zip(names, found.kinds, strict=True)]
    shared = {name: float(loss) for name, loss in found.losses.items() if name not in known} or None
    return {
        "wheel": kind,
        "names": names,
        "losses": known,
        "slip": demand,
        "limit": Limit(int(limit)),
        "shared": shared,
    }


def draw(ax: Axes, numbers: Mapping[str, Any]) -> None:
    """Draw one bar for each wheel, of its losses one upon the other."""
    places = np.arange(len(numbers["names"]))
    height = np.zeros(len(places))
    for name, loss in numbers["losses"].items():
        if np.any(loss > 0):
            colour = style.loss_colour(name)
            ax.bar(places, loss, bottom=height, width=0.6, label=name, color=colour, edgecolor="white", linewidth=0.5)
            height = height + loss
    for place, top, share in zip(places, height, numbers["slip"], strict=True):
        words = "slides" if share > 1.0 else f"{100.0 * share:.0f} %"
        ax.annotate(words, (place, top), (0, 2), textcoords="offset points", ha="center", va="bottom", fontsize=8)
    ax.set_xticks(places, labels=numbers["names"])
    ax.set_ylim(0.0, 1.15 * float(height.max()) or 1.0)
    ax.set_xlabel(f"{numbers['wheel']}; numbers above the bars are shares of its slip limit")
    ax.set_ylabel("loss [W]")
    total = sum(float(np.sum(loss)) for loss in numbers["losses"].values())
    words = f"losses {total:.3g} W"
    if numbers["shared"] is not None:
        other = sum(numbers["shared"].values())
        words = f"losses {total + other:.3g} W: {numbers['wheel']}s {total:.3g} W, motor, gearhead and amplifier {other:.3g} W"
    ax.set_title(
        f"{words}\n{numbers['limit'].words}" if numbers["shared"] else f"{words}, {numbers['limit'].words}", fontsize=9
    )


def draw_all(found: Point) -> Figure:
    """Draw the figure; arguments as in `data`."""
    numbers = data(found)
    with style.styled():
        made, ax = style.figure(max(4.8, 0.7 * len(numbers["names"]) + 2.0), 3.4)
        draw(ax, numbers)
        if ax.get_legend_handles_labels()[0]:
            made.legend(loc="outside right upper")
    return made


def mechanism(found: MechanismPoint, *, cobot: PlanarCobot | None = None) -> Figure:
    """Losses by wheel, or a planar cobot with its forces if it is given."""
    if cobot is None:
        return draw_all(found)
    check_instance("cobot", cobot, PlanarCobot)
    return pictures.draw_all(wheeled.picture(wheeled.steered(cobot, found)))


def rollers(found: SphericalPoint, *, ivt: SphericalIVT | None = None) -> Figure:
    """Losses by roller, or the sphere between its rollers with their forces if it is given."""
    if ivt is None:
        return draw_all(found)
    check_instance("ivt", ivt, SphericalIVT)
    return pictures.draw_all(sphere.picture(ivt, found))


def legs(
    found: LegsPoint | MachinePoint,
    *,
    machine: LeggedDrive | Legs | None = None,
    platform: Platform | None = None,
    position: Array | None = None,
    rotation: Array = (0.0, 0.0, 0.0),
) -> Figure:
    """Losses by leg, or the machine with its forces if machine, platform and position are given, the rotation as in `at`."""
    point = getattr(found, "legs", found)
    given = {"machine": machine, "platform": platform, "position": position}
    if all(value is None for value in given.values()):
        return draw_all(found)
    for name, value in given.items():
        if value is None:
            raise ParameterError(f"{name} is missing: a machine is drawn from machine, platform and position")
    own = getattr(machine, "legs", machine)
    check_instance("machine", own, Legs)
    check_instance("platform", platform, Platform)
    return machines.draw_all(platform, own, point, position, rotation)  # type: ignore[arg-type]

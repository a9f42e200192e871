"""Models compared with measurements: a motor's map, and the friction of geared actuators."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from infinivar.figures import style
from measured import gear_laws, motor_map

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MODELS: Mapping[str, tuple[str, ...]] = {
    "resistance and constant friction": (),
    "with a constant power": ("constant",),
    "with slow friction and resistance to alternating current": ("alternating", "slow friction"),
}
"""Fits whose residuals are drawn, and the extra losses of each."""

_DRAWN = ("erob80_50", "mx64")


def map_data() -> dict[str, Any]:
    """Speed [rpm] and torque [N m] of the loaded points, noise of the efficiency, and residuals in points by model."""
    measured = motor_map.published()
    loaded, sigma = measured.loaded, motor_map.noise(measured)
    fits = {name: motor_map.fit(measured, extra, sigma if extra[1:] else None) for name, extra in MODELS.items()}
    return {
        "speed": measured.speed[loaded] * 30.0 / np.pi,
        "torque": measured.torque[loaded],
        "noise": (100.0 * sigma * measured.efficiency / measured.power_in)[loaded],
        "residuals": {name: 100.0 * found.residual[loaded] for name, found in fits.items()},
    }


def draw_residuals(ax: Axes, numbers: Mapping[str, Any], model: str) -> Any:
    """Draw the residuals of a model over speed and torque."""
    drawn = ax.scatter(
        numbers["speed"], numbers["torque"], c=numbers["residuals"][model], cmap="RdBu_r", vmin=-6, vmax=6, s=14
    )
    rms = float(np.sqrt(np.mean(numbers["residuals"][model] ** 2)))
    ax.set_title(f"{model}\n{rms:.2f} points rms", fontsize="small")
    ax.set_xlabel("speed [rpm]")
    return drawn


def draw_map() -> Figure:
    """Residuals of three models of the motor map."""
    numbers = map_data()
    with style.styled():
        made, axes = style.figure(10.0, 3.4, columns=len(MODELS), sharey=True)
        drawn = [draw_residuals(ax, numbers, model) for ax, model in zip(np.ravel(axes), MODELS, strict=True)]
        np.ravel(axes)[0].set_ylabel("torque [N m]")
        made.colorbar(drawn[0], ax=list(np.ravel(axes)), label="fitted less measured\nefficiency [points]")
    return made


def gear_data(key: str) -> dict[str, Any]:
    """Identified friction and fitted laws of an actuator over its load, at a tenth and at nine tenths of its speed."""
    found = gear_laws.compare(key)
    rows = {"slow": found.speed.shape[0] // 10, "fast": 9 * found.speed.shape[0] // 10}
    forward, back = found.laws["proportional"].values
    load = found.torque[0]
    return {
        "name": found.name,
        "load": load,
        "speed": {name: float(found.speed[row, 0]) for name, row in rows.items()},
        "identified": {name: found.friction[row] for name, row in rows.items()},
        "coulomb": np.full_like(load, found.laws["coulomb"].values[0]),
        "proportional": np.where(load > 0, (1.0 / forward - 1.0) * load, (1.0 - back) * np.abs(load)),
    }


def draw_gear(ax: Axes, numbers: Mapping[str, Any]) -> None:
    """Draw friction over load: identified at two speeds, and two fitted laws."""
    for name, dash in (("slow", "-"), ("fast", "--")):
        label = f"identified, {numbers['speed'][name]:.1f} rad/s"
        ax.plot(numbers["load"], numbers["identified"][name], dash, color="black", label=label)
    for law, colour in zip(("coulomb", "proportional"), style.COLOURS, strict=False):
        ax.plot(numbers["load"], numbers[law], color=colour, label=law)
    ax.set_title(numbers["name"], fontsize="small")
    ax.set_xlabel("torque on the load [N m]; negative: the load drives")
    ax.legend(fontsize="x-small")


def draw_gears() -> Figure:
    """Friction over load of a harmonic drive and of a spur gear, identified and by the two gear laws."""
    with style.styled():
        made, axes = style.figure(8.0, 3.4, columns=len(_DRAWN))
        for ax, key in zip(np.ravel(axes), _DRAWN, strict=True):
            draw_gear(ax, gear_data(key))
        np.ravel(axes)[0].set_ylabel("friction torque [N m]")
    return made

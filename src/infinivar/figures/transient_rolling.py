"""Rolling while creepage and spin change: forces and energies over the distance rolled."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from infinivar.contact.exact.transient import TransientRolling
from infinivar.errors import InputError
from infinivar.figures import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_FORCES = {
    "fy": r"lateral force over $\mu N$",
    "fx": r"force along rolling over $\mu N$",
    "mz": r"moment over $\mu N c$",
}
_ENERGIES = {"work": "work of the creepages", "dissipated": "dissipated", "stored": "stored since the start"}


def data(found: TransientRolling) -> dict[str, Any]:
    """Distance over c; forces that are not 0 throughout, and energies.

    Raises
    ------
    InputError
        If no state has converged.
    """
    if found.outcome[0] != "converged":
        raise InputError("states that have not converged have no figure: the first outcome is 'not converged'")
    forces = {name: getattr(found, name) for name in _FORCES}
    return {
        "distance": found.distance,
        "forces": {name: force for name, force in forces.items() if np.nanmax(np.abs(force)) > 1e-9},
        "energies": {
            "work": found.work,
            "dissipated": found.dissipated,
            "stored": found.energy - found.start_energy,
        },
    }


def draw_series(ax: Axes, distance: np.ndarray, series: Mapping[str, np.ndarray], labels: Mapping[str, str]) -> None:
    """Draw curves over the distance."""
    order = list(labels)
    for name, values in series.items():
        place = order.index(name)
        ax.plot(distance, values, color=style.colour(place), ls=("-", "--", "-.")[place], label=labels[name])
    ax.axhline(0.0, color="grey", lw=0.6)
    style.name_beside(ax, fontsize=8)


def draw_all(found: TransientRolling) -> Figure:
    """Draw the forces, and the energies below."""
    numbers = data(found)
    with style.styled():
        made, axes = style.figure(7.0, 4.6, 2, 1, sharex=True)
        draw_series(axes[0], numbers["distance"], numbers["forces"], _FORCES)
        draw_series(axes[1], numbers["distance"], numbers["energies"], _ENERGIES)
        axes[0].set_ylabel("forces on the track [-]")
        axes[1].set_ylabel(r"energy times $Gc/(\mu N)^2$ [-]")
        axes[1].set_xlabel("distance rolled over $c$ [-]")
        axes[1].set_xlim(0.0, numbers["distance"][-1])
    return made

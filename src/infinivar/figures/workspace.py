"""Losses and limits of a platform over its workspace: one map of positions for each height."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from infinivar.analysis.workspace import WorkspaceMap
from infinivar.errors import InputError
from infinivar.figures import machine_tasks, style
from infinivar.limits import Limit

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MOST = 6
"""Largest number of heights drawn; of more, equally spaced ones."""

_COLUMNS = 3


def data(found: WorkspaceMap) -> list[dict[str, Any]]:
    """Numbers of each map, as of `infinivar.figures.machine_tasks.map_data`.

    Raises
    ------
    InputError
        If the map has fewer than two positions along x or y.
    """
    if min(len(found.x), len(found.y)) < 2:
        raise InputError("a workspace of one position along x or y cannot be drawn: use its points instead")
    count = len(found.z)
    places = np.unique(np.linspace(0, count - 1, min(count, MOST)).round().astype(int))
    limit, loss = np.asarray(found.points.limit), np.asarray(found.points.loss)
    return [
        {
            "title": f"z = {1e3 * found.z[place]:.4g} mm",
            "x": 1e3 * np.asarray(found.x),
            "y": 1e3 * np.asarray(found.y),
            "loss": np.where(limit[:, :, place] == Limit.OK, loss[:, :, place], np.nan),
            "limit": limit[:, :, place],
        }
        for place in places
    ]


def draw_all(found: WorkspaceMap) -> Figure:
    """Draw the figure, all heights with one scale of losses."""
    from matplotlib.colors import Normalize
    from matplotlib.patches import Patch

    maps = data(found)
    known = np.concatenate([one["loss"][np.isfinite(one["loss"])] for one in maps])
    columns = min(len(maps), _COLUMNS)
    rows = -(-len(maps) // columns)
    with style.styled():
        made, axes = style.figure(
            2.7 * columns + 1.6, 2.7 * rows + 1.0, rows, columns, squeeze=False, sharex=True, sharey=True
        )
        scale = Normalize(float(known.min()), float(known.max())) if known.size else None
        meshes = [
            machine_tasks.draw_map(ax, one, scale=scale, legend=False) for ax, one in zip(axes.flat, maps, strict=False)
        ]
        for ax in axes.flat[len(maps) :]:
            ax.set_axis_off()
        for place, ax in enumerate(axes.flat[: len(maps)]):
            ax.label_outer()
            if place + columns >= len(maps):
                ax.xaxis.set_tick_params(labelbottom=True)
                ax.set_xlabel("x [mm]")
        drawn = [mesh for mesh in meshes if mesh is not None]
        if drawn:
            made.colorbar(drawn[0], ax=list(axes.flat), label="loss [W]", shrink=0.9)
        codes = sorted({int(code) for one in maps for code in np.unique(one["limit"])} - {int(Limit.OK)})
        if codes:
            handles = [Patch(facecolor=machine_tasks.shade(code), label=Limit(code).words) for code in codes]
            made.legend(handles=handles, loc="outside lower center", ncols=min(len(handles), 4))
    return made

"""Compute the map of lateral creep with spin anew: ``python tools/tabulate_spin.py``.

Ten minutes on two free cores. Each patch is stored as soon as it is done, and a second start goes on from there.
"""

from __future__ import annotations

import argparse
import functools
import itertools
import math
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path

import numpy as np

from infinivar.contact.exact.grid import Floats
from infinivar.contact.exact.many import extrapolated, refined
from infinivar.contact.exact.patch import RollingPatch
from infinivar.contact.exact.spin_map import A_OVER_B, ANGLES, HALF, POISSON, SIZES, Scales, linear_part, scales

GRIDS, LONG_GRIDS = (10, 20), (20, 40)
"""Cells in each row of the two grids from which forces are extrapolated; the latter for patches longer than `LONG`."""

LONG = 5.0
"""a/b beyond which forces under a large spin err by up to 0.04 of mu N on the coarser pair of grids."""

ROUND = (0.25, 2.0)
"""a/b between which the coarser pair is kept: it errs by 0.0033 of mu N at most at 178 random nodes. On other patches, where it
errs by 0.008 at 327 random nodes, forces are refined where its own estimate of the error exceeds `many.ROUGH`."""

SLENDER = 8.0
"""a/b beyond which spin may take so little power that errors between the nodes would make it negative."""

_RESISTANCE = 0.14
"""What is added there against spin, at a/b = 20, times nu^2 u (1 - u); it changes the moment by 0.005 mu N h at most."""

_RINGS, _RAYS = 400, 800
"""Steps of the integral of full slip, whose integrand turns about a point."""


FILE = Path(__file__).parents[1] / "src" / "infinivar" / "contact" / "data" / "spin_map.npz"
_FOLDER = Path("spin_map_parts")


def main(arguments: list[str] | None = None) -> None:
    """Compute what the folder of parts lacks, and write the map once it lacks nothing."""
    parser = argparse.ArgumentParser(prog="python tools/tabulate_spin.py", description=__doc__)
    parser.add_argument("--processes", type=int, default=2, help="processes at a time (default: 2)")
    parser.add_argument("--parts", type=Path, default=_FOLDER, help=f"folder of finished parts (default: {_FOLDER})")
    parser.add_argument("--to", type=Path, default=FILE, help="file to write (default: that of the package)")
    requested = parser.parse_args(arguments)
    requested.parts.mkdir(parents=True, exist_ok=True)
    required = list(itertools.product(range(len(A_OVER_B)), range(len(POISSON))))
    _compute(
        [one for one in required if not _part(requested.parts, one).exists()], requested.parts, requested.processes
    )
    values = np.stack([np.load(_part(requested.parts, one)) for one in required])
    if not np.isfinite(values).all():
        raise SystemExit("the solver has not converged everywhere: no map is written")
    np.savez_compressed(
        requested.to,
        values=values.reshape(len(A_OVER_B), len(POISSON), *values.shape[1:]).astype(np.float32),
        a_over_b=np.array(A_OVER_B),
        poisson=np.array(POISSON),
    )
    print(f"{requested.to}: {requested.to.stat().st_size / 1024:.0f} kB")


def _part(folder: Path, one: tuple[int, int]) -> Path:
    return folder / f"{one[0]}_{one[1]}.npy"


def _one(one: tuple[int, int], folder: Path) -> None:
    """Compute one patch; its file appears only when it is complete."""
    path = _part(folder, one)
    draft = path.with_suffix(".draft.npy")
    np.save(draft, table(A_OVER_B[one[0]], POISSON[one[1]]))
    draft.replace(path)


def _compute(missing: list[tuple[int, int]], folder: Path, processes: int) -> None:
    from rich.progress import track

    if not missing:
        return
    with ProcessPoolExecutor(processes) as pool:
        waiting = [pool.submit(_one, one, folder) for one in missing]
        for done in track(as_completed(waiting), description="patches", total=len(waiting)):
            done.result()


def solved(a_over_b: float, poisson: float, lateral: float, spin: float) -> Floats:
    """Lateral force over mu N and moment over mu N c by the solver, extrapolated from two grids, refined outside `ROUND`: (2,).

    nan if an iteration has not converged.
    """
    coarse, fine = LONG_GRIDS if a_over_b > LONG else GRIDS
    patch, creepage = RollingPatch(a_over_b=a_over_b, poisson=poisson, cells=fine), (0.0, lateral, spin)
    found = extrapolated(patch, creepage, coarse)
    if not ROUND[0] < a_over_b < ROUND[1]:
        found = refined(found, patch, creepage, float(scales(a_over_b, poisson).lever))
    return found.forces[1:]


@functools.lru_cache(maxsize=2)
def _patch(a_over_b: float) -> tuple[Floats, Floats, Floats]:
    """Places x, y of a patch and their parts of the load."""
    ring = (np.arange(_RINGS) + 0.5) / _RINGS
    ray = (np.arange(_RAYS) + 0.5) * (2.0 * math.pi / _RAYS)
    part = np.sqrt(1.0 - ring**2) * ring
    part = np.repeat(part / part.sum() / _RAYS, _RAYS)
    root = math.sqrt(a_over_b)
    return root * np.outer(ring, np.cos(ray)).ravel(), np.outer(ring, np.sin(ray)).ravel() / root, part


def full_slip(a_over_b: float, lever: float, alpha: float) -> Floats:
    r"""Lateral force over mu N and moment over mu N h of a patch that slips as a rigid body: (2,).

    .. math:: f_y = \int p\,\frac{s_y}{|s|}\,dA, \qquad m = \int p\,\frac{x s_y - y s_x}{|s|}\,dA, \qquad
        s = (-\phi y,\ \upsilon + \phi x)

    Source: Coulomb's law under the Hertz pressure p.
    """
    x, y, part = _patch(a_over_b)
    turn = math.sin(alpha) / lever
    slip_x, slip_y = -turn * y, math.cos(alpha) + turn * x
    part = part / np.hypot(slip_x, slip_y)
    return np.array([np.sum(part * slip_y), np.sum(part * (x * slip_y - y * slip_x)) / lever])


def table(a_over_b: float, poisson: float) -> Floats:
    """The map's table for one patch: (SIZES, ANGLES, 2)."""
    values = np.empty((SIZES, ANGLES, 2))
    for i, j in np.ndindex(SIZES, ANGLES):
        values[i, j] = node(a_over_b, poisson, i, j)
    return values


def node(a_over_b: float, poisson: float, i: int, j: int) -> Floats:
    """One row of the table: the i-th size and the j-th angle of creepage, (2,)."""
    scale = Scales(*map(float, scales(a_over_b, poisson)))
    u, alpha = (i + 1) / SIZES, j * math.pi / ANGLES
    if i == SIZES - 1:
        return full_slip(a_over_b, scale.lever, alpha)
    cosine, sine = math.cos(alpha), math.sin(alpha)
    rho = HALF * u / (1.0 - u)
    force, moment = solved(a_over_b, poisson, rho * cosine / scale.c22, rho * sine / (scale.c22 * scale.lever))
    linear = HALF * (1.0 - u) * np.array(linear_part(scale, cosine, sine))
    extra = resistance(a_over_b, poisson) * u * (1.0 - u) * sine
    return np.array([force, moment / scale.lever + u * extra]) / u - linear


def resistance(a_over_b: float, poisson: float) -> float:
    """Addition to the moment that keeps the interpolated friction of slender patches dissipative. [-]"""
    slender = max(math.log(a_over_b / SLENDER) / math.log(A_OVER_B[-1] / SLENDER), 0.0)
    return _RESISTANCE * poisson**2 * slender


if __name__ == "__main__":
    main()

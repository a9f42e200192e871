"""Coefficients of the creep law "exact" from the steady solver: ``python tools/fit_lateral_law.py``.

Computed curves are kept in a file, so that a run that was interrupted goes on where it stopped. The whole takes about a
minute on two cores.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import math
from collections.abc import Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from infinivar.contact import exact_law, kalker
from infinivar.contact.exact.grid import LONGEST, Floats
from infinivar.contact.exact.many import ORDER, extrapolated
from infinivar.contact.exact.patch import RollingPatch

FILE = Path(__file__).parents[1] / "src" / "infinivar" / "contact" / "data" / "lateral_law.toml"

CELLS = 10, 20
"""Cells in each row of the grids whose forces are extrapolated; twice as many where a patch has fewer rows than
cells in a row."""

SHAPES = tuple(np.geomspace(exact_law.NARROWEST, exact_law.WIDEST, 17).round(6).tolist())
POISSON = (0.0, 0.125, 0.25, 0.375, 0.5)
SHARES = (0.02, 0.06, 0.12, 0.18, 0.24, 0.3, 0.37, 0.44, 0.51, 0.58, 0.65, 0.72, 0.79, 0.85, 0.9, 0.94, 0.975)
"""a/b, Poisson's ratios, and creepages over that of full slip, at which the law is fitted."""

POWERS = 3, 5
"""Terms of the polynomials in Poisson's ratio and in ln(a/b)."""
BENDS = 3

_CALM = 0.03
"""Weight that holds c1 and c2 down: without it they follow the solver's errors, and the inverse needs more steps."""
_ROUNDS = 30


class Fitted(NamedTuple):
    """Outcome of `fit`.

    Attributes
    ----------
    coefficients : (3, 3, 5)   c0, c1, c2 by powers of Poisson's ratio and of ln(a/b)/ln 20.
    largest, rms : float       Error of the force ratio at the fitted points. [-]
    """

    coefficients: Floats
    largest: float
    rms: float


def force(a_over_b: float, poisson: float, share: float, cells: tuple[int, int] = CELLS) -> float:
    """Lateral force over mu N at a creepage, relative to that of full slip; extrapolated from two grids, nan if it fails."""
    c22 = kalker.coefficients(a_over_b, poisson).c22
    creepage = share * float(kalker.full_slip_creepage(a_over_b, poisson, c22) / c22)
    coarse, fine = (count * (2 if a_over_b > LONGEST else 1) for count in cells)
    patch = RollingPatch(a_over_b=a_over_b, poisson=poisson, cells=fine)
    return float(extrapolated(patch, (0.0, creepage, 0.0), coarse).forces[1])


def curve(shape: tuple[float, float]) -> list[float]:
    """Forces at `SHARES` for a/b and Poisson's ratio."""
    return [force(*shape, share) for share in SHARES]


def curves(kept: Path, processes: int) -> Iterator[tuple[int, int]]:
    """Compute what the file lacks and append it; yields how many shapes are done, and of how many."""
    shapes = [(a_over_b, poisson) for a_over_b in SHAPES for poisson in POISSON]
    done = read(kept)
    missing = [shape for shape in shapes if shape not in done]
    yield len(shapes) - len(missing), len(shapes)
    with contextlib.ExitStack() as stack:
        file = stack.enter_context(kept.open("a", encoding="utf-8"))
        spread = stack.enter_context(ProcessPoolExecutor(processes)).map if processes > 1 else map
        for number, (shape, forces) in enumerate(zip(missing, spread(curve, missing), strict=True), 1):
            file.write(json.dumps({"shape": shape, "shares": SHARES, "cells": CELLS, "forces": forces}) + "\n")
            file.flush()
            yield len(shapes) - len(missing) + number, len(shapes)


def read(kept: Path) -> dict[tuple[float, ...], list[float]]:
    """Curves in the file that were computed with the present settings, by shape; a line cut short does not count."""
    found = {}
    for line in kept.read_text("utf-8").splitlines() if kept.exists() else ():
        try:
            row = json.loads(line)
        except ValueError:
            continue
        if (tuple(row["shares"]), tuple(row["cells"])) == (SHARES, CELLS):
            found[tuple(row["shape"])] = row["forces"]
    return found


def fit(known: dict[tuple[float, ...], list[float]]) -> Fitted:
    """Coefficients with the smallest largest error, by least squares with weights that follow the errors (Lawson).

    Points at which the solver failed are left out.
    """
    a_over_b, poisson = np.array(list(known)).T
    forces = np.array(list(known.values()))
    full_slip = kalker.full_slip_creepage(a_over_b, poisson, kalker.coefficients(a_over_b, poisson).c22)
    shape, place = np.nonzero(np.isfinite(forces))
    force_ratio, share = forces[shape, place], np.array(SHARES)[place]

    s = 1.0 - (1.0 - np.minimum(force_ratio, 1.0)) ** 0.4
    q = 2.5 / full_slip[shape] - 1.0
    place_in = np.log(a_over_b) / math.log(exact_law.WIDEST)
    basis = np.stack([poisson**i * place_in**j for i in range(POWERS[0]) for j in range(POWERS[1])], axis=1)
    bent = np.concatenate([-((1.0 - s) * s ** (2 + i))[:, None] * basis[shape] for i in range(BENDS)], axis=1)
    straight = s * (1.0 + (1.0 - s) * q)
    calm = _CALM * np.kron(np.diag([0.0, 0.5, 1.0]), basis)

    steep = np.gradient(forces, SHARES, axis=1)[shape, place]
    first = np.where(np.isfinite(steep), np.maximum(steep, 0.02), 0.5)
    weight, best = first, Fitted(np.zeros(0), math.inf, math.inf)
    for _ in range(_ROUNDS):
        left = np.concatenate([bent * weight[:, None], calm])
        right = np.concatenate([(share - straight) * weight, np.zeros(len(calm))])
        numbers = np.linalg.lstsq(left, right, rcond=None)[0].reshape(BENDS, *POWERS)
        error = np.abs(_force(numbers, full_slip[shape], basis[shape], share) - force_ratio)
        if error.max() < best.largest:
            best = Fitted(numbers, float(error.max()), float(np.sqrt(np.mean(error**2))))
        weight = weight * (0.3 + error / error.max()) ** 0.25
        weight *= np.linalg.norm(first) / np.linalg.norm(weight)
    return best


def _force(numbers: Floats, full_slip: Floats, basis: Floats, share: Floats) -> Floats:
    """The law's force with trial coefficients, by bisection."""
    growth = exact_law.growth_of(full_slip, numbers.reshape(BENDS, -1) @ basis.T)
    low, high = np.zeros_like(share), np.ones_like(share)
    for _ in range(40):
        s = 0.5 * (low + high)
        over = sum(part * s**i for i, part in enumerate(growth, 1)) > share
        low, high = np.where(over, low, s), np.where(over, s, high)
    return 1.0 - (1.0 - high) ** 2.5


def text(found: Fitted) -> str:
    """The data file."""

    def numbers(values: Iterable[Any]) -> str:
        return f"[{', '.join(f'{value:.10g}' for value in values)}]"

    lines = [
        "# Creep law exact: c0, c1, c2 of `contact.exact_law`, written by python tools/fit_lateral_law.py.",
        "# Rows for powers 0, 1, 2 of Poisson's ratio, columns for powers 0 to 4 of ln(a/b)/ln 20.",
        'source = "kalker1990"',
        "",
        "[settings]",
        f"cells = {list(CELLS)}",
        f"order = {ORDER}",
        f"a_over_b = {numbers(SHAPES)}",
        f"poisson = {numbers(POISSON)}",
        f"share_of_full_slip = {numbers(SHARES)}",
        "",
        "[errors]  # of the force ratio, at the points above",
        f"largest = {found.largest:.5f}",
        f"rms = {found.rms:.5f}",
        "",
        "[coefficients]",
    ]
    for i, rows in enumerate(found.coefficients):
        lines += [f"c{i} = [", *(f"    {numbers(row)}," for row in rows), "]"]
    return "\n".join([*lines, ""])


def main(arguments: list[str] | None = None) -> None:
    """Compute the curves, fit the coefficients and write the data file."""
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    parser = argparse.ArgumentParser(prog="python tools/fit_lateral_law.py", description=__doc__)
    parser.add_argument("--processes", type=int, default=2, help="processes, each on one core (2)")
    parser.add_argument("--curves", type=Path, default=Path("lateral_law_curves.jsonl"), help="file of computed curves")
    parser.add_argument("--out", type=Path, default=FILE, help="data file to write (default: that of the package)")
    given = parser.parse_args(arguments)
    columns = TextColumn("{task.description}"), BarColumn(), TextColumn("{task.completed}/{task.total}")
    with Progress(*columns, TimeElapsedColumn()) as bar:
        task = bar.add_task("creep curves")
        for done, of in curves(given.curves, given.processes):
            bar.update(task, completed=done, total=of)
    found = fit(read(given.curves))
    given.out.write_text(text(found), "utf-8")
    print(f"{given.out}: largest error {found.largest:.5f}, rms {found.rms:.5f}")


if __name__ == "__main__":
    main()

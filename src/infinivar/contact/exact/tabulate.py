"""Compute the map of lateral creep with spin anew: ``python -m infinivar.contact.exact.tabulate``.

Ten minutes on two free cores. Each patch is stored as soon as it is done, and a second start goes on from there.
"""

from __future__ import annotations

import argparse
import itertools
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path

import numpy as np

from infinivar.contact.exact.spin_nodes import A_OVER_B, POISSON
from infinivar.contact.exact.spin_table import table

FILE = Path(__file__).parents[1] / "data" / "spin_map.npz"
_FOLDER = Path("spin_map_parts")


def main(arguments: list[str] | None = None) -> None:
    """Compute what the folder of parts lacks, and write the map once it lacks nothing."""
    parser = argparse.ArgumentParser(prog="python -m infinivar.contact.exact.tabulate", description=__doc__)
    parser.add_argument("--processes", type=int, default=2, help="processes at a time (default: 2)")
    parser.add_argument("--parts", type=Path, default=_FOLDER, help=f"folder of finished parts (default: {_FOLDER})")
    parser.add_argument("--to", type=Path, default=FILE, help="file to write (default: that of the package)")
    asked = parser.parse_args(arguments)
    asked.parts.mkdir(parents=True, exist_ok=True)
    wanted = list(itertools.product(range(len(A_OVER_B)), range(len(POISSON))))
    _compute([one for one in wanted if not _part(asked.parts, one).exists()], asked.parts, asked.processes)
    values = np.stack([np.load(_part(asked.parts, one)) for one in wanted])
    if not np.isfinite(values).all():
        raise SystemExit("the solver has not converged everywhere: no map is written")
    np.savez_compressed(
        asked.to,
        values=values.reshape(len(A_OVER_B), len(POISSON), *values.shape[1:]).astype(np.float32),
        a_over_b=np.array(A_OVER_B),
        poisson=np.array(POISSON),
    )
    print(f"{asked.to}: {asked.to.stat().st_size / 1024:.0f} kB")


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


if __name__ == "__main__":
    main()

"""A problem for sweeps that takes no time: a few thousand made-up designs in numbered chunks."""

import os
import signal
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from infinivar.sweeps.problem import Best, Chunk

TOP = 5


@dataclass(frozen=True, kw_only=True)
class Toy:
    """Designs with random mass and power; each chunk keeps its best and its front."""

    chunks: int = 6
    size: int = 40
    seed: int = 0
    pause: float = 0.0
    """Of each chunk; no part of the problem. [s]"""
    trace: Path | None = None
    """File to which each computed chunk adds a line: its number and the process."""
    fatal: int | None = None
    """Number of a chunk that kills its process unless the file `trace` tells that it did so before."""
    kind: str = "toys"
    title: str = "toys"

    @property
    def reducer(self):
        return Best(top=TOP, order=("value", "number"), front=("mass_kg", "power_W"))

    @property
    def identity(self) -> Mapping[str, object]:
        return {"seed": self.seed, "designs in a chunk": self.size}

    def every(self):
        """Number, mass and power of all designs."""
        mass, power = np.random.default_rng(self.seed).integers(0, 30, (2, self.chunks * self.size)) / 7.0
        return np.arange(self.chunks * self.size), mass, power

    def run(self, number):
        if self.trace is not None:
            before = self.trace.read_text("utf-8") if self.trace.exists() else ""
            with self.trace.open("a", encoding="utf-8") as file:
                file.write(f"{number} {os.getpid()}\n")
            if number == self.fatal and f"\n{number} " not in f"\n{before}":
                os.kill(os.getpid(), signal.SIGKILL)
        time.sleep(self.pause)
        place, mass, power = (column[number * self.size : (number + 1) * self.size] for column in self.every())
        every = np.arange(self.size)
        best = every[np.lexsort((place, power))][:TOP]
        beaten = (
            (mass[:, None] >= mass) & (power[:, None] >= power) & ((mass[:, None] > mass) | (power[:, None] > power))
        ).any(1)
        rows = np.concatenate([best, every[~beaten]])
        return Chunk(
            {
                "list": np.array(["top"] * len(best) + ["front"] * int((~beaten).sum())),
                "value": power[rows],
                "number": place[rows],
                "mass_kg": mass[rows],
                "power_W": power[rows],
                f"only in {number % 3}": np.ones(len(rows)),
            },
            {
                "candidates": self.size,
                "sums": {"mass": int(7 * mass.sum()), f"of {number % 2}": 1},
                "each": np.bincount(place % 3),
            },
        )

    def best(self, chunk):
        value = float(chunk.rows["value"].min())
        return value, f"best: {value:.3g} W"


def main():
    """Sweep a toy as the arguments say: a JSON object of fields of the toy, and one of options of `sweep`."""
    import json
    import sys

    from infinivar.console import run
    from infinivar.sweeps.sweep import sweep

    fields, options = map(json.loads, sys.argv[1:3])
    if "trace" in fields:
        fields["trace"] = Path(fields["trace"])
    # What a shell starts in the background ignores Ctrl-C.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    toy = Toy(**fields)
    print("ready", flush=True)
    run(lambda: sweep(toy, **options))

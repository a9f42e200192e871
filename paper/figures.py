"""Draw the figures of paper.md, beside it: ``python paper/figures.py``."""

from __future__ import annotations

from pathlib import Path

import numpy as np

import infinivar as iv
from infinivar.figures import measured, style

HERE = Path(__file__).parent


def maps() -> None:
    """Efficiency of the cobotic drive and of the geared one that covers the requirement, side by side."""
    study = iv.load_study("hand_controller")
    wanted = study.requirement
    speed, force = np.linspace(0.002, 1.3 * wanted.speed, 300), np.linspace(0.1, 1.5 * wanted.force, 300)
    edge = np.linspace(0.01, wanted.speed, 200)
    with style.styled():
        figure, axes = style.figure(7.4, 3.0, columns=2)
        for ax, name in zip(axes, ("cobotic", "motor2-gear4"), strict=True):
            found = iv.steady_map(study.drives[name], speed, force)
            drawn = ax.contourf(speed, force, 100 * found.efficiency.T, np.linspace(0.0, 80.0, 9), cmap="viridis")
            ax.plot(
                [0.0, *edge, wanted.speed], [wanted.force, *np.minimum(wanted.force, wanted.power / edge), 0.0], "--k"
            )
            ax.set(title=study.titles[name], xlabel="speed of the load [m/s]", ylabel="force on the load [N]")
        figure.colorbar(drawn, ax=axes, label="efficiency [%]")
        figure.savefig(HERE / "maps.png", dpi=200)


def residuals() -> None:
    """A measured set."""
    measured.draw_all(iv.calibration.measured_report("screws_and_worm")).savefig(HERE / "measured.png", dpi=150)


if __name__ == "__main__":
    maps()
    residuals()

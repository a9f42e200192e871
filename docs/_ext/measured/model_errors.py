"""What published measurements leave of the models of motor and gear, as default spreads: ``python -m measured.model_errors``."""

from __future__ import annotations

import math
from importlib import resources
from pathlib import Path

import numpy as np

from measured import gear_laws, motor_map

FILE = Path(str(resources.files("infinivar.study"))) / "data" / "model_errors.toml"

_HEAD = """\
# Model errors that published measurements support: standard deviations relative to the value, by field and model.
# Written by `python -m measured.model_errors` in docs/_ext; a test computes them again.
"""


def gear_loss(law: str) -> float:
    """Root mean square over the identified actuators of the share of their friction that a law leaves. [-]

    Each actuator counts once, with its own fit of the law.
    """
    shares = [gear_laws.compare(key).laws[law].share for key in gear_laws.actuators()]
    return math.sqrt(float(np.mean(np.square(shares))))


def resistance() -> float:
    """Error of the winding resistance that leaves as much loss as a measured motor map leaves of resistance and friction. [-]

    The noise of the map is subtracted from the residual of the input power; what is left is set against the copper loss.
    """
    data = motor_map.published()
    fit = motor_map.fit(data)
    copper = fit.values[0] * (data.torque + fit.values[1]) ** 2
    off = data.torque * data.speed + motor_map.loss(fit.values, (), data.speed, data.torque) - data.power_in
    left = np.mean((off**2 - motor_map.noise(data) ** 2)[data.loaded])
    return math.sqrt(max(float(left / np.mean(copper[data.loaded] ** 2)), 0.0))


def text() -> str:
    """Content of the file of model errors."""
    count = len(gear_laws.actuators())
    found = {
        "resistance": (
            resistance(),
            "parsons2019",
            "loss that resistance and constant friction leave of a motor map, without its noise",
        ),
        **{
            f"efficiency.{law}": (
                gear_loss(law),
                "duclusaud2025",
                f"friction that the law leaves of {count} geared actuators, of the loss",
            )
            for law in ("coulomb", "proportional")
        },
    }
    tables = [
        f'\n[{name}]\ndeviation = {value:.2g}\nsource = "{source}"\nwhere = "{where}"\n'
        for name, (value, source, where) in found.items()
    ]
    return _HEAD + "".join(tables)


if __name__ == "__main__":
    FILE.write_text(text(), "utf-8")

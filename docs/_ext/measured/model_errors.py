"""What published measurements leave of models, as default spreads: ``python -m measured.model_errors``."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from importlib import resources
from pathlib import Path

import numpy as np

from infinivar.calibration import measured_report
from infinivar.calibration.measured.sets import read_set
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


def no_load(form: str) -> float:
    """Share of the no-load current that one friction for three motors of a type leaves, "constant" or "viscous". [-]"""
    (whole,) = measured_report(replace(read_set("robot_motors"), by="")).parts
    return _left(whole.rows.read, next(one.rms[0] for one in whole.evidence if one.form == form))


def thread() -> float:
    """Share of the torque of screws and a worm that a friction independent of speed leaves; each counts once. [-]"""
    parts = measured_report("screws_and_worm").parts
    shares = [
        _left(one.rows.read, next(form.rms[0] for form in one.evidence if form.form == "constant")) for one in parts
    ]
    return math.sqrt(float(np.mean(np.square(shares))))


def heating() -> tuple[float, float]:
    """Shares of two rises, of the winding above the body and of the body above ambient, that are wrong in a run left out. [-]

    The model is that of `infinivar.parts.heat`: two masses, sensors without lag, and all power in the winding.
    """
    measured = read_set("motor_heating")
    form = "two nodes"
    law = replace(measured.law, forms={form: measured.law.forms[form]})
    one = next(part for part in measured_report(replace(measured, law=law)).parts if np.isfinite(part.predicted).all())
    (winding, body), off = one.rows.read.T, (one.rows.read - one.predicted).T
    ambient = one.rows.known_columns["ambient"]
    return _left(winding - body, _rms(off[0] - off[1])), _left(body - ambient, _rms(off[1]))


def _rms(values: np.ndarray) -> float:
    return math.sqrt(float(np.mean(values**2)))


def _left(read: np.ndarray, rms: float) -> float:
    return rms / _rms(read)


def _found() -> Iterator[tuple[str, float, str, str]]:
    """Yield field and model, deviation, source and what it is."""
    said = "loss that resistance and constant friction leave of a motor map, without its noise"
    yield "resistance", resistance(), "parsons2019", said
    for form, friction in (("constant", "one constant friction"), ("viscous", "one constant and viscous friction")):
        said = f"current that {friction} for three motors of a type leaves, of the current"
        yield f"no_load_current.{form}", no_load(form), "robotino2026", said
    inner, slow = heating()
    said = "rise of the winding above the body in a run left out of the fit, of the rise"
    yield "winding_to_housing", inner, "tassrv2026", said
    said = "rise of the body above ambient in a run left out of the fit, of the rise"
    yield "housing_time_constant", slow, "tassrv2026", said
    count = len(gear_laws.actuators())
    for law in ("coulomb", "proportional"):
        said = f"friction that the law leaves of {count} geared actuators, of the loss"
        yield f"efficiency.{law}", gear_loss(law), "duclusaud2025", said
    said = "torque that a friction independent of speed leaves of two screws and a worm, of the torque"
    yield "thread", thread(), "mablekos2021", said


def text() -> str:
    """Content of the file of model errors."""
    tables = [
        f'\n[{name}]\ndeviation = {value:.2g}\nsource = "{source}"\nwhere = "{where}"\n'
        for name, value, source, where in _found()
    ]
    return _HEAD + "".join(tables)


if __name__ == "__main__":
    FILE.write_text(text(), "utf-8")

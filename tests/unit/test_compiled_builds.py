"""Samples of drives evaluated by compiled code: the numbers of NumPy, on the requirement and in duty cycles."""

import functools
import sys
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import infinivar as iv
from all_part_kinds import DRIVES, JOINT, LINE, one_axis_studies
from infinivar import InputError, ParameterError
from internals import (
    Batch,
    evaluated,
    gradient,
    low_discrepancy,
    outcomes,
    quantities_of,
    sampling,
    values_of,
    verdicts,
)
from sampled import sampled

VARIED = ("motor.torque_constant", "motor.resistance", "transmission.friction", "transmission.preload")
STUDY = """
[requirement]
force = "30 N"
speed = "0.3 m/s"
quadrants = 4

[drives.geared]
type = "conventional"
[drives.geared.motor]
part = "dcx-32-l-24v"
rotor_inertia = "72.8 g cm^2"
[drives.geared.gearhead]
ratio = 12
efficiency = "85 %"
[drives.geared.pulley]
radius = "10 mm"

[duty.shake]
shape = "sinusoid"
distance = "30 mm"
frequency = "2 Hz"
load_mass = "1 kg"

[uncertainty]
draws = 64
[uncertainty.geared]
"motor.resistance" = "10 %"
"motor.torque_constant" = "5 %"
"gearhead.efficiency" = "5 %"
"""


SETTLED = 1e-9
"""Settled temperatures, and the energies that follow from them, solve for a fixed point: rounding grows up to a thousandfold."""


def samples(drive, count):
    paths = [path for path in VARIED if path in quantities_of(drive)]
    return paths, values_of(drive, paths) * (0.9 + 0.2 * low_discrepancy(32, len(paths))[:count])


def assert_same_in_cycle(drive, duty, count=24):
    """Energy, temperature and feasibility of samples, whose number no chunk divides."""
    paths, at = samples(drive, count)
    of = functools.partial(outcomes.worked, duty=duty, travel=0.5)
    fast, plain = (evaluated(of, drive, paths, at, width=3, engine=engine) for engine in ("jax", "numpy"))
    assert_allclose(fast, plain, rtol=SETTLED)
    assert np.isfinite(plain[:, 0]).any()
    assert fast.shape == (count, 3)


def shipped():
    for name, study in one_axis_studies():
        for drive in study.drives:
            if drive in ("cobotic-b", "cobotic-series") or (name, drive) == ("knee_walking", "cobotic"):
                continue  # the laws of others here
            yield name, drive


@sampled(("name", "drive"), shipped(), slow=5)
def test_cycles_of_shipped_drives(name, drive):
    pytest.importorskip("jax")
    study = iv.load_study(name)
    made = study.drives[drive]
    duty = next(iter(study.duty.values()), JOINT if made.axis.rotary else LINE)
    assert_same_in_cycle(made, duty)


@sampled("name", ["geared", "cobotic"], every=2)
def test_limits_are_those_of_duty_cycle(name):
    """Demands of one design by the public function, of a sample by its own."""
    study = iv.load_study("reach_and_hold")
    drive, duty = study.drives[name], next(iter(study.duty.values()))
    found, single = outcomes.in_cycle(drive, duty, 0.5), iv.duty_cycle(drive, duty, travel=0.5)
    assert set(found.limits) == set(single.demands)
    for limit, demand in zip(found.limits, found.demands, strict=True):
        # Settled in closed form here, by steps there: the resistance differs in the fifth digit.
        assert demand == pytest.approx(single.demands[limit], rel=1e-4), limit
    assert bool(found.able) == single.feasible
    assert float(found.energy) == pytest.approx(single.energy, rel=1e-4)


@sampled("name", DRIVES, slow=4)
def test_cycles_of_drives_with_every_part(name):
    pytest.importorskip("jax")
    assert_same_in_cycle(DRIVES[name], JOINT if DRIVES[name].axis.rotary else LINE)


@pytest.mark.slow
def test_runs_too():
    """Heat over a run, not settled."""
    pytest.importorskip("jax")
    time = np.linspace(0.0, 1.0, 101)
    run = iv.motion.Recording(file="log", time=time, position=0.05 * time**2 * (3.0 - 2.0 * time), closed=False)
    drive = iv.load_study("reach_and_hold").drives["geared"]
    assert_same_in_cycle(drive, iv.DutyCycle(motion=run, load_mass=1.0, start_temperature=320.0))


@pytest.mark.slow
def test_builds_are_those_of_numpy(load, monkeypatch):
    pytest.importorskip("jax")
    study = load(STUDY)
    drive = study.drives["geared"]
    axes = np.linspace(-0.4, 0.4, 5), np.linspace(-40.0, 40.0, 5)
    ask = functools.partial(
        verdicts.builds, drive, "geared", study.uncertainty, study.requirement, study.duty, axes, None
    )
    fast, plain, few = ask("jax"), ask("numpy"), ask()
    assert (fast.engine, plain.engine, few.engine) == ("jax", "numpy", "numpy")
    assert fast.to_dict()["engine"] == "jax"
    assert few == plain
    for one, other in ((fast, plain), (fast.duty["shake"], plain.duty["shake"])):
        for name in ("coverage", "margin", "loss", "energy", "temperature", "able"):
            if hasattr(one, name):
                assert_allclose(getattr(one, name), getattr(other, name), rtol=SETTLED, err_msg=name)
    assert_array_equal(fast.map.within, plain.map.within)
    assert_allclose(fast.map.efficiency, plain.map.efficiency, rtol=1e-12)
    assert 0.0 < fast.covering < 1.0 or fast.coverage.std() > 0.0
    monkeypatch.setitem(sys.modules, "jax", None)
    for module in (verdicts, sampling):
        monkeypatch.setattr(module, "WORTH_COMPILING", 1)
    assert ask() == plain
    with pytest.raises(InputError, match="engine jax needs jax"):
        ask("jax")
    with pytest.raises(ParameterError, match="engine must be auto, numpy or jax"):
        ask("cuda")


def test_what_cannot_be_compiled_is_computed_by_numpy():
    """Hysteresis of a series spring is followed branch by branch."""
    pytest.importorskip("jax")
    spring = iv.parts.Spring(stiffness=3e4, hysteresis=2.0)
    drive = replace(iv.load_study("reach_and_hold").drives["geared"], output=iv.Output(series_spring=spring))
    paths = ["output.series_spring.stiffness"]
    at = values_of(drive, paths) * np.linspace(0.9, 1.1, 4)[:, None]
    batch = Batch(functools.partial(outcomes.worked, duty=LINE, travel=None), drive, paths, width=3)
    assert batch.engine == "numpy"
    assert "hysteresis of a series spring" in batch.reason
    assert batch(at).shape == (4, 3)


def test_derivatives_leave_settings_alone():
    jax = pytest.importorskip("jax")
    drive = iv.load_study("reach_and_hold").drives["geared"]
    of = functools.partial(outcomes.loss, speed=0.1, force=10.0)
    with jax.enable_x64(False):
        found = gradient(of, drive, VARIED[:2], method="jax")
        assert not jax.config.jax_enable_x64
    for one, other in zip(found, gradient(of, drive, VARIED[:2]), strict=True):
        assert_allclose(one, other, rtol=1e-12)


@pytest.mark.slow
@pytest.mark.usefixtures("unrendered")
def test_the_engine_is_said_where_results_are_shown(load, tmp_path):
    pytest.importorskip("jax")
    study = load(STUDY)
    found = iv.compare(study, engine="jax")
    said = found.to_dict()
    assert (said["drives"]["geared"]["engine"], said["builds"]["geared"]["engine"]) == ("jax", "jax")
    plain = iv.compare(study)
    assert plain.to_dict()["drives"]["geared"]["engine"] == "numpy"
    assert found.equals(plain, rtol=1e-10, atol=1e-12)
    iv.save(found, tmp_path / "out")
    page = (tmp_path / "out" / "report.html").read_text("utf-8")
    assert page.count("<td>JAX, compiled</td>") == 2
    ranked = [iv.sensitivity(study, "geared", "loss", samples=64, engine=engine) for engine in ("jax", "auto")]
    assert [one.engine for one in ranked] == ["jax", "numpy"]
    assert "compiled" in ranked[0].remarks[-1]
    assert ranked[0].to_dict()["engine"] == "jax"
    assert_allclose(
        *([row.total for row in one.influences if row.total is not None] for one in ranked), rtol=1e-9, atol=1e-12
    )

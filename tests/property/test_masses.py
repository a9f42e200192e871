"""Masses of random designs: finite, positive, and rising with what must make them heavier."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import infinivar as iv
from infinivar.parts import Structure
from internals import Service, cobotic_bodies, own_mass
from made import loaded

KNEE = loaded("knee_walking")
COBOTIC, GEARED = KNEE.drives["cobotic"], KNEE.drives["geared"]


def drawn(count, seed):
    """Values of random cobotic designs as columns. (count, 1)"""
    random = np.random.default_rng(seed)

    def between(low, high):
        return np.exp(random.uniform(np.log(low), np.log(high), (count, 1)))

    return {
        "cylinder_radius": between(0.02, 0.1),
        "wheel_radius": between(0.012, 0.06),
        "preload": between(100.0, 8000.0),
        "crown_radius": between(0.006, 0.1),
        "travel": between(0.02, 0.3),
    }


def made(values, drive=COBOTIC):
    element = drive.transmission
    geometry = replace(element.geometry, crown_radius=values["crown_radius"])
    own = {name: values[name] for name in ("cylinder_radius", "wheel_radius", "preload")}
    drive = replace(drive, transmission=replace(element, geometry=geometry, **own), link_mass=None)
    return replace(drive, steering=replace(drive.steering, bell_inertia=None))


def weigh(values, drive=COBOTIC):
    """Masses by body, and their sum, of designs whose bearings are those of the study. (count,) each"""
    found = made(values, drive).bodies(Service(values["travel"], 100.0))
    count = len(values["preload"])
    each = {body.name: np.broadcast_to(np.ravel(body.mass), (count,)) for body in found if not body.chosen}
    return each, np.broadcast_to(np.ravel(own_mass(found)), (count,))


@pytest.mark.parametrize(
    ("count", "seed"), [(200, 0), *(pytest.param(2000, seed, marks=pytest.mark.full) for seed in range(1, 101))]
)
def test_random_designs_weigh_something(count, seed):
    """200 designs every day and 200,000 before a release; nan stands where no wall or rail carries the preload."""
    values = drawn(count, seed)
    each, whole = weigh(values)
    known = np.isfinite(whole)
    # The strongest rail carries 31 kN at the margin of 2; walls of hardened steel fail behind the smallest radii alone.
    assert known.mean() > 0.97
    assert np.all(values["cylinder_radius"][~known] < 0.035)
    for name, mass in each.items():
        assert np.all(mass[known] > 0.0), name
    drive = made(values)
    inertia, link = np.ravel(drive.steering.inertia_of_bell), np.ravel(drive.mass_of_link)
    assert np.all((inertia > 0.0) & np.isfinite(inertia) & (link > 0.0) & np.isfinite(link))
    assert np.all(link < np.where(known, whole, np.inf) + COBOTIC.steering.motor.mass)


@pytest.mark.parametrize(
    ("name", "bodies"),
    [
        ("travel", ("cylinder", "rail", "frame")),
        ("wheel_radius", ("wheel", "bell", "frame")),
        ("preload", ("cylinder", "frame", "preload spring")),
        ("cylinder_radius", ("frame",)),
    ],
)
def test_more_of_it_weighs_more(name, bodies):
    values = drawn(150, 7)
    before, _ = weigh(values)
    after, _ = weigh({**values, name: 1.1 * values[name]})
    for body in bodies:
        known = np.isfinite(before[body]) & np.isfinite(after[body])
        # A cylinder may have the least wall before and after.
        rises = after[body][known] >= before[body][known] * (1.0 - 1e-12)
        if body == "frame" and name == "preload":
            # A wider rail carries a lower bar: the step of a rail may outweigh the load.
            assert rises.mean() > 0.95
        else:
            assert np.all(rises), body


def test_many_designs_are_as_each_alone():
    """Columns of many designs against plain numbers, body by body.

    The wall of one tube is computed with fewer terms than that of many of different lengths: 2e-4 of the mass here.
    """
    values = drawn(20, 3)
    each, _ = weigh(values)
    for place in range(20):
        alone = {name: float(column[place, 0]) for name, column in values.items()}
        for body in cobotic_bodies(made(alone), Service(alone["travel"], 100.0)):
            if not body.chosen:
                mass = np.nan if body.mass is None else float(body.mass)
                tolerance = 1e-3 if body.name == "cylinder" else 1e-9
                assert_allclose(mass, each[body.name][place], rtol=tolerance, err_msg=body.name)


def test_stronger_factors_weigh_more():
    values = drawn(60, 5)
    _, before = weigh(values)
    for name, factor in (("strength_margin", 2.0), ("frame_deflection", 0.5), ("room", 2.0), ("rail_margin", 2.0)):
        changed = Structure(**{name: factor * getattr(COBOTIC.structure, name)})
        _, after = weigh(values, replace(COBOTIC, structure=changed))
        known = np.isfinite(before) & np.isfinite(after)
        assert known.mean() > 0.9
        assert np.mean(after[known] >= before[known] * (1.0 - 1e-12)) > (0.9 if name == "rail_margin" else 0.9999), name


def test_pulleys_and_screws_weigh_more_the_larger_they_are():
    radii = np.geomspace(0.002, 0.05, 50)
    service = Service(0.1, 200.0)
    pulleys = [own_mass(replace(GEARED, pulley=iv.parts.Pulley(radius=float(r))).bodies(service)) for r in radii]
    assert np.all(np.diff(pulleys) > 0.0)
    together = own_mass(replace(GEARED, pulley=iv.parts.Pulley(radius=radii)).bodies(service))
    assert_allclose(together, pulleys, rtol=1e-12)

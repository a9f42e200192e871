"""What a search may be for: space and price beside energy and mass; and what holds a pulley that becomes ever smaller."""

import itertools
import math
import re
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_array_equal

import infinivar as iv
from infinivar import Limit
from infinivar.parts import Belt
from internals import size_geared, sizing_figure, sizing_text
from made import loaded
from small_catalogue import SHELF, SLOW

KNEE = loaded("knee_walking")
WALKING = replace(KNEE.with_drives("geared"), requirement=None)
RADII = (0.003, 0.05)
BELT = Belt(pitch=0.003, teeth=16.0)
PRICES = {"motors": {"a": 70, "b": 95, "c": 60}, "gearheads": {"p5": 40, "p14": 55, "p35": 30, "p60": 20}}


def priced(text, without=()):
    """A set whose parts state prices."""
    for kind, some in PRICES.items():
        for key, price in some.items():
            if key not in without:
                text = text.replace(f"[{kind}.{key}]", f"[{kind}.{key}]\nprice = {price}")
    return text


@pytest.fixture(scope="module")
def dear(tmp_path_factory):
    path = tmp_path_factory.mktemp("sets") / "dear.toml"
    path.write_text(priced(SHELF), "utf-8")
    return path


def box(study, drive):
    space = drive.layout(study.service(drive)).space
    return float(space.length * space.width * space.height)


def feasible(study, drive):
    return all(iv.duty_cycle(drive, one).feasible for one in study.duty.values())


def shaft(study, drive):
    """Radius of the shaft in the pulley's bearings, as they are chosen by their load. [m]"""
    (load, *_) = drive.loads(study.service(drive))
    return 0.5 * next(one.bore for one in iv.bearings().values() if one.name == load.part)


def test_least_space_is_that_of_all_pairs_at_many_radii(dear):
    found = iv.size(WALKING, objective="space", sets=dear, radius=RADII)
    assert found.objective == ("space",)
    volumes = [one.volume for one in found.designs]
    assert volumes == sorted(volumes)
    least = math.inf
    for design, radius in itertools.product(found.designs, np.geomspace(*RADII, 200)):
        drive = replace(design.drive, pulley=replace(design.drive.pulley, radius=float(radius)))
        if radius >= shaft(WALKING, drive) and feasible(WALKING, drive):
            least = min(least, box(WALKING, drive))
    best = found.best
    assert best.volume == pytest.approx(box(WALKING, best.drive), rel=1e-12)
    assert best.volume <= least * (1.0 + 1e-9)
    assert best.volume == pytest.approx(least, rel=0.03)  # 200 radii are 1.4 % apart
    assert f"least space of {found.searched}: box around the drive {1e3 * best.volume:.3g} l: " in found.verdict
    assert found.to_dict()["designs"][0]["volume_m3"] == best.volume


@pytest.mark.parametrize(
    ("objective", "name", "scale", "label"),
    [
        ("space", "volume", 1e3, "box around the drive [l]"),
        ("price", "price", 1.0, "price of motors and gearheads"),
        ("mass", "power", 1.0, "mean power from the supply [W]"),
    ],
)
def test_the_figure_shows_what_was_made_small(dear, objective, name, scale, label):
    found = iv.size(WALKING, objective=objective, sets=dear, radius=RADII)
    numbers = sizing_figure.data(found)
    assert numbers["label"] == label
    assert_array_equal(numbers["designs"], [[one.mass, scale * getattr(one, name)] for one in found.designs])
    assert (len(numbers["cloud"]) > 0) == (name == "power")
    assert not len(numbers["front"])
    assert found.plot().axes[0].get_ylabel() == label


def test_assumed_lengths_are_shown_in_millimetres(dear):
    rows = iv.size(WALKING, objective="space", sets=dear, radius=RADII).hangs_on.rows
    (used,) = {row.used for row in rows if row.choice == "structure: room"}
    assert used == "5 mm"


def test_least_price_is_that_of_the_parts_and_each_must_state_one(dear, tmp_path):
    found = iv.size(WALKING, objective="price", sets=dear, radius=RADII)
    known = {
        (one.parts["motor"].key, one.parts["gearhead"].key): one.price
        for one in iv.size(WALKING, objective="energy", sets=dear, radius=RADII).designs
    }
    assert [one.price for one in found.designs] == sorted(known.values())
    for (motor, gearhead), price in known.items():
        assert price == PRICES["motors"][motor] + PRICES["gearheads"][gearhead]
    assert found.best.price == 90.0  # c with p35, whose mass is not stated
    assert "prices are those of motors and gearheads; the structure has none" in found.cautions
    path = tmp_path / "partly.toml"
    path.write_text(priced(SHELF, without={"c"}), "utf-8")
    partly = iv.size(WALKING, objective="price", sets=path, radius=RADII)
    assert partly.searches["geared"].excluded == {"motor price not stated": 3}
    assert partly.best.parts["motor"].key == "b"
    none = iv.size(WALKING, objective="price", sets="shipped")
    assert not none.feasible
    assert "motor price not stated" in none.verdict


def test_of_equal_prices_the_lighter_comes_first_and_what_has_none_is_noted(tmp_path):
    path = tmp_path / "ties.toml"
    path.write_text(re.sub(r"price = [0-9]+", "price = 50", priced(SHELF, without={"a"})), "utf-8")
    found = iv.size(WALKING, objective="price", sets=path, radius=RADII)
    assert {one.price for one in found.designs} == {100.0}
    masses = [math.inf if math.isnan(one.mass) else one.mass for one in found.designs]
    assert masses == sorted(masses)
    assert len({*masses}) > 2
    said = "objective = price: 2 candidates like geared were left out, whose price is not stated"
    assert said in found.cautions


def test_values_that_are_tried_are_listed_with_what_is_made_small(dear):
    study = replace(WALKING, drives={"geared": replace(WALKING.drives["geared"], pulley=None, belt=BELT)})
    found = iv.size(study, objective="space", sets=dear, tries={"drives.geared.belt.teeth": [16, 24]})
    head, *rows = [line for line in sizing_text(found) if line.startswith(("Belt teeth", "16", "24"))]
    assert head.split()[2:5] == ["space", "power", "mass"]
    assert all(" l " in row for row in rows)
    assert len(rows) == 2


def test_given_stages_are_ordered_by_space_and_price(dear):
    parts, drive = iv.load_parts(dear), WALKING.drives["geared"]
    tables = [{**parts.tables[kind].columns, "name": parts.tables[kind]["key"]} for kind in ("motors", "gearheads")]
    stages = [replace(drive.pulley, radius=radius) for radius in (0.006, 0.008)]
    for aim, name in (("space", "volume"), ("price", "price")):
        found = size_geared(drive, *tables, parts.pairs, objective=aim, duty=WALKING.duty, stages=stages)
        values = [getattr(one, name) for one in found.designs]
        assert len(values) > 2
        assert values == sorted(values)


@pytest.mark.slow
@pytest.mark.parametrize("aim", ["space", "price"])
def test_cobotic_drives_of_least_space_and_price(aim, tmp_path):
    path = tmp_path / "dear.toml"
    path.write_text(priced(SLOW), "utf-8")
    study = replace(KNEE, requirement=None)
    ask = {"sets": path, "generations": 6, "steering_ratios": (16.0,), "drive": "cobotic", "wheels": (1, 2)}
    found, by_mass = (iv.size(study, objective=one, **ask) for one in (aim, "mass"))
    best, name = found.best, {"space": "volume", "price": "price"}[aim]
    values = [getattr(one, name) for one in found.designs]
    assert values == sorted(values)
    assert getattr(best, name) <= getattr(by_mass.best, name)
    if aim == "space":
        assert best.volume == pytest.approx(box(study, best.drive), rel=1e-9)
    else:
        parts = (best.parts["motor"], best.parts["steering.motor"], best.parts["gearhead"])
        assert best.price == sum({**PRICES["motors"], **PRICES["gearheads"]}[one.key] for one in parts)
    assert feasible(study, best.drive)


def test_without_a_motion_the_steering_motor_of_the_template_has_a_price(tmp_path):
    path = tmp_path / "dear.toml"
    path.write_text(priced(SLOW), "utf-8")
    with pytest.raises(iv.InputError, match=r"steering\.motor\.price is missing: without a motion"):
        iv.size(replace(KNEE, duty={}), objective="price", sets=path, drive="cobotic", generations=1)


def test_objectives_that_cannot_be_combined_are_refused(dear):
    with pytest.raises(iv.InputError, match="objective must be energy, mass, space or price, or energy and mass"):
        iv.size(WALKING, objective=("energy", "space"), sets=dear)
    with pytest.raises(iv.InputError, match="carried needs both objectives"):
        iv.size(WALKING, objective="space", sets=dear, carried=1.0)


def test_no_pulley_is_thinner_than_its_shaft(dear):
    """The lightest drive has the smallest pulley: without this limit one of 4 mm stood on a shaft of 10 mm."""
    for aim in ("mass", "energy"):
        for design in iv.size(WALKING, objective=aim, sets=dear, radius=RADII).designs:
            radius, least = design.drive.pulley.radius, shaft(WALKING, design.drive)
            assert radius >= least * (1.0 - 1e-9)
            assert design.demands["structure", Limit.SHAFT, "pulley"] == pytest.approx(least / radius, rel=1e-9)
    held = iv.size(WALKING, objective="energy", sets=dear, radius=RADII).best
    assert held.tightest == ("structure", Limit.SHAFT, "pulley")
    assert "margin 1 (room for the shaft of the pulley)" in held.verdict
    none = iv.size(WALKING, objective="energy", sets=dear, radius=(0.003, 0.0045))
    assert not none.feasible
    assert "room for the shaft of the pulley" in none.verdict


def test_a_bearing_that_is_stated_says_how_thick_the_shaft_is(dear):
    drive = WALKING.drives["geared"]
    stated = iv.parts.PulleyBearings(friction_coefficient=0.002, bore=0.024, pull=300.0)
    pulley = replace(drive.pulley, bearings=stated, radius=0.013)
    study = replace(WALKING, drives={"geared": replace(drive, pulley=pulley)})
    best = iv.size(study, objective="mass", sets=dear, radius=RADII).best
    assert best.drive.pulley.radius == pytest.approx(0.012, rel=1e-6)

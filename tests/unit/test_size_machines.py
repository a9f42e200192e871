"""The search over machines: against every design of a small set, against random designs, and against `compare`."""

import itertools
from dataclasses import replace

import numpy as np
import pytest

import infinivar as iv
from internals import Prepared, power_and_margin, tasks_and_paths, with_values
from made import loaded
from small_catalogue import SLOW

LIMITED = {"generations": 3, "top": 4, "slip_margin": 1.0}
STUDIES = {"two_joint_arm": ("one-motor", "two-motors"), "six_leg_display": ("one-motor", "six-motors")}
"""With a shared motor, and with a motor for each link."""


@pytest.fixture(scope="module")
def slow(tmp_path_factory):
    path = tmp_path_factory.mktemp("sets") / "slow.toml"
    path.write_text(SLOW, "utf-8")
    return path


def parts_of(file, law):
    """Motors, gearheads and bearings of a set."""
    found = iv.load_parts(file)
    tables = [[getattr(found, kind).part(row) for row in range(len(getattr(found, kind)))] for kind in found.tables]
    named = dict(zip(found.tables, tables, strict=True))
    gearheads = [replace(one, loss_model=law) for one in named["gearheads"]]
    return named["motors"], gearheads, named["bearings"]


def judged(study, machine):
    """Mean power by the analysis that `compare` decides by, or inf where a limit is exceeded."""
    found = power_and_margin(machine, Prepared(machine, tasks_and_paths(study)))
    able = all(margin >= 1.0 for _, margin in found.values())
    return sum(share * found[key][0] for key, share in study.machine_shares.items()) if able else np.inf


def without_own_inertias(machine):
    return with_values(machine, {"leg.link_mass": None, "leg.steering.bell_inertia": None})


@pytest.mark.parametrize("study", STUDIES)
def test_best_of_separate_motors_is_that_of_all_designs(study, slow):
    given, name = loaded(study), STUDIES[study][1]
    own = given.drives[name].separate
    radius = 0.4 * own.pulley.radius
    found = iv.size(given, drive=name, sets=slow, radius=(radius, radius), top=100)
    motors, gearheads, _ = parts_of(slow, own.gearhead.loss_model)
    powers = {}
    for motor, gearhead in itertools.product(motors, gearheads):
        changed = {"separate.motor": motor, "separate.gearhead": gearhead, "separate.pulley.radius": radius}
        powers[motor.name, gearhead.name] = judged(given, with_values(given.drives[name], changed))
    able = sorted((power, pair) for pair, power in powers.items() if np.isfinite(power))
    assert 2 <= len(able) < len(powers)
    # The search also asks for room for the shaft of the pulley, which compare does not judge.
    assert [(one.power, names(one, "separate")) for one in found.designs] == [
        (pytest.approx(power, rel=1e-9), pair) for power, pair in able
    ]


def names(design, inner):
    return tuple(design.parts[f"{inner}.{role}"].name for role in ("motor", "gearhead"))


@pytest.mark.parametrize("study", STUDIES)
def test_best_of_legs_is_that_of_all_designs(study, slow):
    given, name = loaded(study), STUDIES[study][0]
    drive = without_own_inertias(given.drives[name])
    leg, element = drive.leg, drive.leg.transmission
    fixed = {
        "cylinder_radius": element.cylinder_radius,
        "cylinder_speed": leg.cylinder_speed,
        "wheel_radius": element.wheel_radius,
        "crown_radius": element.geometry.crown_radius,
        "preload": element.preload,
    }
    ratios = [0.7 * leg.steering.ratio, leg.steering.ratio]
    ranges = {key: (value, value) for key, value in fixed.items()}
    found = iv.size(given, drive=name, sets=slow, ranges=ranges, steering_ratios=ratios, objective="energy", **LIMITED)
    motors, gearheads, bearings = parts_of(slow, leg.gearhead.loss_model)
    bought = ("name", "series", "bore", "outside_diameter", "width", "dynamic_rating", "static_rating", "mass")
    bought += ("calculation_factor", "contact_angle", "seal_torque")
    axles, supports = (
        [own, *(replace(own, **{key: getattr(one, key) for key in bought}) for one in bearings)]
        for own in (element.geometry.axle_bearing, leg.cylinder_bearings.bearing)
    )
    best = np.inf
    for axle, support, steering, ratio in itertools.product(axles, supports, motors, ratios):
        changed = {
            "leg.transmission.geometry.axle_bearing": axle,
            "leg.cylinder_bearings.bearing": support,
            "leg.steering.motor": steering,
            "leg.steering.ratio": ratio,
        }
        made = with_values(drive, changed)
        for motor, gearhead in itertools.product(motors, gearheads):
            power = judged(given, with_values(made, {"leg.motor": motor, "leg.gearhead": gearhead}))
            best = min(best, power)
    assert np.isfinite(best)
    assert found.best.power == pytest.approx(best, rel=1e-9)

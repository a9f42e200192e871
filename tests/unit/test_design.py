"""Variants of a wheel's design, how losses follow them, and what holds the bell against steering."""

import math
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from infinivar import Limit
from infinivar.contact import hertz
from internals import SIZE_POWERS, Duty, elasticities, with_friction
from internals import SWEPT_QUANTITIES as SWEPT
from internals import swept_design as sweep


@pytest.fixture(scope="module")
def drive(study):
    return study.drives["cobotic"]


@pytest.fixture
def duty(element):
    return Duty(cylinder_speed=14.0, link_force=0.5 * element.slip_force, ratio=8.0)


def test_more_friction_takes_less_preload(element):
    """The slip force stays, as the link must hold the same load."""
    variant = with_friction(element, 0.24)
    assert variant.slip_force == pytest.approx(element.slip_force, rel=1e-12)
    assert variant.preload == pytest.approx(element.preload / 2, rel=1e-12)


@pytest.mark.parametrize(
    ("parameter", "loss", "exponent"),
    [
        ("preload", "rolling", 4 / 3),  # P a with a ~ P^(1/3)
        ("preload", "creep", -2 / 3),  # 1/(a b)
        ("preload", "bearing", 1.0),  # the simple rule
        ("friction", "rolling", -4 / 3),
        ("friction", "creep", 2 / 3),
        ("youngs_modulus", "creep", -1 / 3),  # G ~ E, a b ~ E^(-2/3)
        ("youngs_modulus", "rolling", -1 / 3),
        ("hysteresis_factor", "rolling", 1.0),
        ("axle_bore", "bearing", 1.0),
    ],
)
def test_losses_follow_known_powers(element, duty, parameter, loss, exponent):
    """Hertz's powers. The step of 1 % leaves 1e-4, and that more creep lets the wheel roll faster a little."""
    assert elasticities(element, parameter, duty)[loss] == pytest.approx(exponent, abs=0.005)


def test_a_larger_axle_has_a_larger_bearing(element, duty):
    """By the maker's model, in which friction depends on the ratings: against designs with both sizes, by differences."""
    geometry = element.geometry
    bearing = replace(geometry.axle_bearing, friction_model="skf")

    def loss(scale):
        sizes = {name: getattr(bearing, name) * scale**power for name, power in SIZE_POWERS.items()}
        sized = replace(element, geometry=replace(geometry, axle_bearing=replace(bearing, **sizes)))
        return float(duty.at(sized).losses["bearing"])

    own = replace(element, geometry=replace(geometry, axle_bearing=bearing))
    slope = (math.log(loss(1.0 + 1e-5)) - math.log(loss(1.0 - 1e-5))) / 2e-5
    assert elasticities(own, "axle_bore", duty)["bearing"] == pytest.approx(slope, rel=1e-4)


def test_total_is_the_weighted_mean_of_its_parts(element, duty):
    losses = duty.at(element).losses
    for parameter in SWEPT:
        slopes = elasticities(element, parameter, duty)
        mean = sum(slopes[name] * float(loss) for name, loss in losses.items()) / sum(map(float, losses.values()))
        assert slopes["total"] == pytest.approx(mean, abs=1e-12)


def test_sweep_names_what_binds(element, duty):
    """From a preload that slips over sound ones to one under which the contact yields."""
    (trend,) = sweep(element, "preload", np.array([300.0, 650.0, 1500.0]), [duty])
    assert trend.limit == (Limit.SLIP, Limit.OK, Limit.YIELD)
    assert np.isnan(trend.efficiency[0])
    assert trend.efficiency[1] == duty.at(element).efficiency
    (trend,) = sweep(element, "material", ["bearing-steel", "al-7075-t6"], [duty])
    assert trend.limit == (Limit.OK, Limit.YIELD)


def test_a_sweep_computes_its_variants_together(element, duty, monkeypatch):
    """One search for the largest shear stress serves all values, and each is as it would be alone."""
    values, searched = np.geomspace(0.004, 0.1, 7), []
    search = hertz.largest_shear
    monkeypatch.setattr(hertz, "largest_shear", lambda *patch: searched.append(patch) or search(*patch))
    (trend,) = sweep(element, "crown_radius", values, [duty])
    assert len(searched) <= len({material.poisson for material in element.geometry.bodies.values()})
    alone = [sweep(element, "crown_radius", [value], [duty])[0] for value in values]
    assert trend.limit == tuple(one.limit[0] for one in alone)
    assert_allclose(trend.efficiency, [one.efficiency[0] for one in alone], rtol=1e-12)


def test_measured_groups_have_no_design(element, duty):
    measured = replace(element, geometry=None, creep_stiffness=1e4, rolling_torque=0.0, bearing_torque=1e-3)
    with pytest.raises(ValueError, match="measured groups"):
        sweep(measured, "crown_radius", [0.01], [duty])


def test_bell_carries_the_preload_along_its_axis(drive):
    """The simple rule with the equivalent load Y Fa of a 6004: f0 Fa/C0 = 14 x 650/5000 = 1.82, Y about 1.36."""
    torque = drive.steering.friction_torques(drive.transmission)["bell"]
    y = 1.45 + (1.82 - 1.38) / (2.07 - 1.38) * (1.31 - 1.45)
    assert torque == pytest.approx(0.5 * 0.0015 * 0.020 * y * 650.0, rel=1e-9)


def test_patch_that_turns_on_the_spot(drive):
    """Nearly a circle of 0.33 mm: 3 pi/16 mu P a; with measured groups a uniform line, mu P b/2."""
    patch = drive.transmission.contact.patch
    mean = math.sqrt(patch.a * patch.b)
    torque = drive.steering.friction_torques(drive.transmission)["patch"]
    assert torque == pytest.approx(3 * math.pi / 16 * 0.15 * 650.0 * mean, rel=1e-3)
    measured = replace(drive.transmission, geometry=None, creep_stiffness=1e4, rolling_torque=0.0, bearing_torque=1e-3)
    plant = replace(drive.steering, patch_half_length=0.5e-3)
    assert plant.friction_torques(measured)["patch"] == pytest.approx(0.5 * 0.15 * 650.0 * 0.5e-3, rel=1e-12)


@pytest.mark.slow
def test_groups_are_asked_for_by_several_threads(element):
    """What is remembered for one speed may be dropped for another at any time."""
    wheel = replace(element)
    expected = {speed: wheel.groups(speed) for speed in (1.0, 2.0, 3.0)}
    with ThreadPoolExecutor(8) as pool:
        for speed, found in pool.map(lambda speed: (speed, wheel.groups(speed)), [1.0, 2.0, 3.0] * 300):
            assert found == expected[speed]

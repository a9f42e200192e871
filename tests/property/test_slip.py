"""Gross sliding is never within limits: slip by force or by creepage, whichever is nearer, for every law and quadrant."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import infinivar as iv
from infinivar import Limit, Scenario
from infinivar.contact import creep, kalker
from infinivar.motion import StepForce
from internals import MEASURED_FULL_SLIP, lateral_creep
from sampled import sampled

POINTS = 200_000


@pytest.fixture(scope="module")
def drawn():
    """Cylinder speed, steering angle, link force and link speed in all four quadrants, many near the locked wheel."""
    random = np.random.default_rng(15)
    near = random.choice([1.0, 0.1, 0.01], (2, POINTS))
    return (
        random.uniform(-20.0, 20.0, POINTS),
        random.uniform(-0.5 * np.pi, 0.5 * np.pi, POINTS) * near[0],
        random.uniform(-85.0, 85.0, POINTS),
        random.uniform(-3.0, 3.0, POINTS) * near[1],
    )


def three_ways(element, drawn):
    """The element with angle and force given, with angle and speed, and with speed and force."""
    turning, angle, force, speed = drawn
    return {
        "force": element.operate(cylinder_speed=turning, steering_angle=angle, link_force=force),
        "speed": element.operate(cylinder_speed=turning, steering_angle=angle, link_speed=speed),
        "both": element.deliver(cylinder_speed=turning, link_speed=speed, link_force=force),
    }


@sampled("law", creep.LAWS, every=3)
def test_no_point_within_limits_is_beyond_slip(element, drawn, law):
    bent = replace(element, creep_law=law)
    groups = bent.groups(14.0)
    most = float(groups.slip_creepage(creep.law(law)))
    for point in three_ways(bent, drawn).values():
        within = point.limit == Limit.OK
        steered = groups.steered(np.sin(point.steering_angle[within]) ** 2)
        creepage = steered.creep_group * np.abs(point.creep_speed[within] / point.rolling_speed[within])
        assert within.sum() > 1000
        assert np.all(creepage <= most * (1 + 2e-9))
        assert np.all(np.abs(point.lateral_force[within]) <= groups.slip_force)
        # The margin is the nearer of both.
        nearer = np.maximum(creepage / most, np.abs(point.lateral_force[within]) / groups.slip_force)
        assert_allclose(point.utilisation[Limit.SLIP][within], nearer, rtol=2e-9, atol=1e-12)


@pytest.mark.slow
def test_a_loss_never_enlarges_what_is_possible(element, drawn):
    """Eq 17 takes link speed away, or lets the link run away faster: points within its limits are within those of Eq 16."""
    linear = three_ways(element, drawn)
    for way, point in three_ways(replace(element, creep_law="faulring"), drawn).items():
        within = point.limit == Limit.OK
        assert within.any()
        assert np.all(linear[way].limit[within] == Limit.OK)


@pytest.mark.parametrize("law", creep.LAWS)
def test_gross_sliding_at_a_given_speed_is_slip(element, law):
    """At 0.3 rad and 5 m/s the creepage is some 6, thousands of times that of slip, whatever force the law gives it."""
    point = replace(element, creep_law=law).operate(cylinder_speed=14.0, steering_angle=0.3, link_speed=5.0)
    assert point.creep_speed / abs(point.rolling_speed) == pytest.approx(6.2, abs=0.1)
    assert point.limit == Limit.SLIP
    assert point.margin < 2e-3


def test_full_slip_is_where_exact_theory_saturates():
    """At that creepage exact rolling theory carries the slip force to 0.2 %, and at four fifths of it less by over 0.4 %.

    Its tabulated curves are good to 0.1 % of the slip force, and for a Poisson's ratio of 0.3 the last 0.1 % comes later.
    """
    for curve in lateral_creep():
        shape = curve["a_over_b"]
        full = float(kalker.full_slip_creepage(shape, 0.3, kalker.coefficients(shape, 0.3).c22)) / 3.0
        at = np.interp([0.8 * full, full], curve["scaled_creepage"], curve["force_ratio"])
        assert at[1] > 0.998
        assert at[0] < 0.996


def test_full_slip_of_a_circle():
    """By hand: the integrals over a circle are pi/2 and 3 pi/8."""
    for poisson in (0.0, 0.3, 0.5):
        c22 = kalker.coefficients(1.0, poisson).c22
        by_hand = 1.5 * c22 * (0.5 * (1.0 - poisson) + 0.375 * poisson)
        assert kalker.full_slip_creepage(1.0, poisson, c22) == pytest.approx(by_hand, rel=1e-12)
    assert pytest.approx(by_hand_for_steel(), rel=1e-3) == MEASURED_FULL_SLIP


def by_hand_for_steel():
    return 1.5 * float(kalker.coefficients(1.0, 0.3).c22) * (0.5 * 0.7 + 0.375 * 0.3)


def test_slip_in_time_is_by_creepage_too(study):
    """Polach's force only tends to the slip force: pushed with 0.98 of it, the wheel slides all the same."""
    drive = study.drives["cobotic"]
    drive = replace(drive, transmission=replace(drive.transmission, creep_law="polach"))
    run = iv.simulate(
        drive,
        Scenario(
            duration=0.3,
            steering="locked",
            load_mass=0.8,
            force=StepForce(size=-0.98 * drive.transmission.slip_force, start=0.05),
        ),
    )
    assert run.exceeded == ("wheel slip (wheel)",)
    assert run.trajectory.lost["slip"][-1] > 0

"""Step of the steering angle: relaxation lengths, two ways to the force, limits, what it refuses."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import infinivar as iv
from infinivar.analysis import steering_steps
from internals import RELAXED
from internals import steering_step_figure as steering_step
from made import parameter_study

STUDY = parameter_study("faulring2006")


CELLS = 10
"""Fewer than usual, which is quicker: what is tested here holds on every grid."""


@pytest.fixture(scope="module", autouse=True)
def coarse():
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr("infinivar.analysis.steering_step._CELLS", CELLS)
        yield


@pytest.fixture(scope="module")
def step(coarse):
    return steering_steps(STUDY, "cobotic")[0]


@pytest.mark.slow
def test_default_is_half_of_the_slip_limit(step):
    """The steady force is half of mu P, at the creepage that the shipped machine needs by exact theory."""
    assert_allclose(step.steady_force, 0.5 * step.slip_force, rtol=1e-6)
    assert_allclose(step.force[-1], step.steady_force, rtol=0.01)
    assert_allclose(step.creep_force[-1], step.steady_force, rtol=0.01)
    assert_allclose(step.moment[-1], step.steady_moment, rtol=0.01)
    # By the linear law the creepage is 0.5/K; exact theory has about 1.2 times that.
    linear = 0.5 / STUDY.drives["cobotic"].transmission.groups(14.0).creep_group
    assert 1.19 < np.tan(step.angle) / linear < 1.24


def test_relaxation_lengths(step):
    """The force has 63 % of its steady value there; the turn delays it, slip shortens it."""
    assert_allclose(np.interp(step.relaxation_length, step.distance, step.force), RELAXED * step.steady_force)
    alone = np.interp(step.creep_relaxation_length, step.creep_distance, step.creep_force)
    assert_allclose(alone, RELAXED * step.steady_force)
    assert step.creep_relaxation_length < step.linear_creep_relaxation_length < step.linear_relaxation_length
    assert step.creep_relaxation_length < step.relaxation_length < step.linear_relaxation_length
    assert_allclose(step.relaxation_time, step.relaxation_length / step.surface_speed)


def test_small_steps_are_steps_of_a_small_angle(step):
    """The linear theory does not depend on the angle."""
    (small,) = steering_steps(STUDY, "cobotic", angle=1e-6)
    assert_allclose(small.relaxation_length, small.linear_relaxation_length, rtol=1e-3)
    assert_allclose(small.linear_relaxation_length, step.linear_relaxation_length, rtol=1e-6)
    assert_allclose(small.creep_relaxation_length, small.linear_creep_relaxation_length, rtol=1e-3)


@pytest.mark.slow
def test_turn_as_the_derivative_of_spin():
    """Linear theory is superposition: a turn by an angle is that angle times the derivative of the response to spin.

    The steps are larger than those of the derivative, which smooths the force where the twisted material has left.
    """
    element = STUDY.drives["cobotic"].transmission
    (small,) = steering_steps(STUDY, "cobotic", angle=1e-5)
    contact = element.contact
    unit = np.sqrt(contact.patch.a * contact.patch.b)
    patch = iv.contact.RollingPatch(contact.axis_ratio, contact.poisson, cells=CELLS)
    distance, tiny = np.linspace(0.04, 4.0, 100), 1e-3
    creep = patch.transient(distance, lateral=tiny).fy / tiny
    spin = patch.transient(distance, spin=tiny).fy / tiny
    expected = (creep - np.gradient(spin, distance)) * contact.shear_modulus * unit**2 * 1e-5
    inner = slice(5, -5)
    assert_allclose(
        np.interp(distance[inner], small.distance / unit, small.force), expected[inner], atol=0.01 * small.steady_force
    )


@pytest.mark.slow
def test_steering_rate(step):
    """A slow turn takes the distance of its duration; at a high rate it is that at once."""
    (slow,) = steering_steps(STUDY, "cobotic", angle=1e-3, rate=1.0)
    turned = 1e-3 / 1.0 * slow.surface_speed
    assert_allclose(np.interp(0.5 * turned, slow.distance, slow.slip_angle), 0.5e-3)
    assert_allclose(np.interp(turned, slow.distance, slow.slip_angle), 1e-3)
    (quick,) = steering_steps(STUDY, "cobotic", angle=step.angle, rate=1e3)
    assert_allclose(quick.relaxation_length, step.relaxation_length, rtol=0.01)
    assert slow.relaxation_length > 1.3 * step.relaxation_length


def test_figure(step):
    """It draws the step's own numbers, in mm and mrad."""
    numbers = steering_step.data(step)
    assert_allclose(numbers["distance"], 1e3 * step.distance)
    assert_allclose(numbers["slip_angle"][-1], 1e3 * step.angle)
    assert_allclose(numbers["time_per_distance"] * numbers["relaxation_length"], 1e3 * step.relaxation_time)
    made = steering_step.draw_all(step)
    labels = [text.get_text() for text in made.axes[0].get_legend().get_texts()]
    assert labels[0] == f"step of the steering angle: 63 % at {1e3 * step.relaxation_length:.3g} mm"


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"angle": 0.0}, "angle must be > 0"),
        ({"angle": 0.3}, "angle must be > 0 and <= 0.2 rad, got 0.3"),
        ({"rate": -1.0}, "rate must be > 0 rad/s, got -1.0"),
    ],
)
def test_bad_arguments(options, said):
    with pytest.raises(iv.ParameterError, match=said):
        steering_steps(STUDY, "cobotic", **options)


@pytest.mark.slow
def test_figure_of_a_slow_turn():
    """Both curves go to the end of the axis, and the patch's name is right of the axis and clear of the curve."""
    (slow,) = steering_steps(STUDY, "cobotic", angle=0.01, rate=1.0)
    assert slow.creep_distance[-1] < 0.3 * slow.distance[-1]
    made = steering_step.draw_all(slow)
    above, below = made.axes[:2]
    end = 1e3 * slow.distance[-1]
    step, alone = [line for line in above.lines if len(line.get_xdata()) > 2]
    assert step.get_xdata()[-1] == pytest.approx(end)
    assert alone.get_xdata()[-1] == pytest.approx(end)
    assert alone.get_ydata()[-1] == slow.steady_force
    assert alone.get_ydata()[-2] == pytest.approx(slow.steady_force, rel=0.01)
    for size in ((6.4, 4.8), (4.2, 3.6)):
        made.set_size_inches(*size)
        made.draw_without_rendering()
        (name,) = below.texts
        box, axis = name.get_window_extent(), below.get_window_extent()
        assert box.x0 > axis.x0
        curve = below.transData.transform(below.lines[0].get_xydata())
        assert np.max(curve[:, 1]) < box.y0

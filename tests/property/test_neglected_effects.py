"""Effects that the element neglects are as small as the documentation states, by the solver of exact rolling contact."""

import math

import numpy as np
import pytest
from scipy.optimize import root

import infinivar as iv


def _wheel(name):
    drives = iv.load_study(name).drives.values()
    return next(drive for drive in drives if hasattr(drive, "transmission"))


def _creepages(rolling, longitudinal, lateral, spin=0.0):
    """Scaled creepages that cause two forces over the slip force."""

    def excess(creepage):
        found = rolling.steady(*creepage, spin, gradient=True)
        return found.forces[:2] - (longitudinal, lateral), found.gradient[:2, :2]

    found = root(excess, (0.25 * longitudinal, 0.3 * lateral), jac=True, tol=1e-10)
    assert found.success
    return found.x


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    ["hand_controller", *(pytest.param(one, marks=pytest.mark.slow) for one in ("knee_walking", "ankle_walking"))],
)
def test_longitudinal_creep_of_the_driven_wheel(name):
    """Rolling resistance changes the lateral creepage, and the part of its power lost by longitudinal creep, below 1e-4."""
    drive = _wheel(name)
    wheel, contact = drive.transmission, drive.transmission.contact
    groups = wheel.groups(drive.cylinder_speed)
    rolling = iv.contact.RollingPatch(contact.axis_ratio, contact.poisson, 0.0, 16)
    unit = groups.slip_force / (contact.shear_modulus * contact.patch.a * contact.patch.b)
    for load in (0.1, 0.5, 0.9):
        free, driven = _creepages(rolling, 0.0, load), _creepages(rolling, groups.rolling_group, load)
        assert free[0] == pytest.approx(0.0, abs=1e-9)
        assert 0.0 < driven[1] / free[1] - 1.0 < 1e-4
        assert 0.0 < unit * driven[0] < 1e-4


@pytest.mark.slow
def test_the_change_of_lateral_creep_grows_with_the_square_of_rolling_resistance():
    """It is below 1 % up to H = 0.08 at half the slip force, many times that of any shipped wheel."""
    rolling = iv.contact.RollingPatch(1.03, 0.3, 0.0, 16)
    free = _creepages(rolling, 0.0, 0.5)[1]
    shares = [_creepages(rolling, resistance, 0.5)[1] / free - 1.0 for resistance in (0.02, 0.04, 0.08)]
    assert shares[-1] < 0.01
    assert np.diff(np.log(shares)) / math.log(2.0) == pytest.approx([2.0, 2.0], abs=0.1)


@pytest.mark.slow
def test_tilting_changes_the_creepage_by_the_aligning_stiffness_over_the_tilting_stiffness():
    """Linear theory against the solver at a tenth of slip, where the patch is nearly linear."""
    wheel = _wheel("hand_controller").transmission
    contact, slip = wheel.contact, wheel.slip_force
    size = math.sqrt(contact.patch.a * contact.patch.b)
    unit = slip / (contact.shear_modulus * size**2)
    aligning = contact.coefficients.c23 * contact.shear_modulus * size**3
    rolling = iv.contact.RollingPatch(contact.axis_ratio, contact.poisson, 0.0, 16)
    for stiffness in (50.0 * aligning, 200.0 * aligning):
        spin = 0.1 * slip / stiffness * size / unit
        changed = _creepages(rolling, 0.0, 0.1, spin)[1] / _creepages(rolling, 0.0, 0.1)[1] - 1.0
        assert changed == pytest.approx(-aligning / stiffness, rel=0.05)

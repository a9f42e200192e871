"""The paper's claims on efficiency, asked of a sphere between rollers: against direct computation."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import infinivar as iv
from internals import SPHERE_PARTS as PARTS
from internals import as_sphere, efficiency_by_ratio, sphere_wheel

LAYOUTS = ("tetrahedral", "cubic")


@pytest.fixture(scope="module")
def found():
    return iv.sphere_claims(radius=(0.03,), preload=(400.0,), material=("bearing-steel",))


@pytest.fixture(scope="module")
def wheel():
    return sphere_wheel(0.03, 400.0, "bearing-steel")


def of(found, claim):
    return found.sphere[found.claims.index(claim)], found.wheel[found.claims.index(claim)]


def best(ivt, ratio, load):
    """Of both senses of rotation."""
    return np.fmax.reduce([efficiency_by_ratio(ivt, sense * ratio, load, sphere_speed=0.7 / 0.03) for sense in (1, -1)])


@pytest.mark.slow
@pytest.mark.parametrize("place", [0, 1])
def test_efficiencies_are_those_of_the_transmissions(found, wheel, place):
    ivt = as_sphere(wheel, LAYOUTS[place])
    for claim, ratio in (("E1", 100.0), ("E2", 8.0), ("E3", 1.0)):
        sphere, cylinder = of(found, claim)
        assert_allclose(sphere[place], best(ivt, ratio, 0.5), rtol=1e-6)
        point = wheel.deliver(cylinder_speed=0.7 / 0.03, link_speed=0.7 / ratio, link_force=0.5 * wheel.slip_force)
        assert_allclose(cylinder[place], point.efficiency, rtol=1e-12)
    assert of(found, "E4")[0][place] >= of(found, "E3")[0][place]
    assert_allclose(of(found, "B2")[0], 0.87 * 0.88 * of(found, "E4")[0], rtol=1e-12)
    assert_allclose(of(found, "E9")[0], of(found, "E2")[0] - of(found, "E1")[0], rtol=1e-6)
    largest = of(found, "E11")[0][place]
    assert np.isfinite(best(ivt, 8.0, largest))
    assert np.isnan(best(ivt, 8.0, largest + 0.1))


def test_kinematic_creep_is_what_spin_adds(found, wheel):
    """The parts add up to the whole loss; the wheel on a cylinder has no kinematic creep, as footnote 3 says."""
    for lost, claim in ((found.sphere_lost, of(found, "E2")[0]), (found.wheel_lost, of(found, "E2")[1])):
        assert tuple(lost) == PARTS
        assert_allclose(sum(lost.values()), 1.0 / claim - 1.0, rtol=1e-6)
        assert all(np.all(part >= 0.0) for part in lost.values())
    assert np.all(found.wheel_lost["kinematic creep"] == 0.0)
    for place, layout in enumerate(LAYOUTS):
        plain = as_sphere(wheel, layout, spins=False)
        without = efficiency_by_ratio(plain, [8.0, -8.0], 0.5, sphere_speed=0.7 / 0.03)
        total = sum(part[place] for part in found.sphere_lost.values())
        rest = total - found.sphere_lost["kinematic creep"][place]
        assert np.min(np.abs(rest - (1.0 / without - 1.0))) < 1e-6  # in the better sense with spin
    assert np.all(found.sphere_lost["kinematic creep"] > 10.0 * found.sphere_lost["elastic creep"])
    assert "kinematic creep +17.8 %" in found.why()
    assert found.why().endswith("The largest part is kinematic creep.")


def test_verdicts(found):
    """A claim holds in all cases, in none, or is undecidable."""
    verdicts = {claim: found.verdict(claim) for claim in found.claims}
    assert verdicts["E1"] == verdicts["E2"] == verdicts["E4"] == "does not hold"
    assert verdicts["B2"] == "holds"
    # Against all gears, and against those known with high confidence, which are planetary.
    sphere, wheel = of(found, "E8 high")
    assert np.all(of(found, "E8")[0] < -0.5)
    assert np.all(np.abs(wheel) < 0.15)
    assert np.all(sphere > of(found, "E8")[0])
    apart = np.array(found.sphere_holds)
    apart[found.claims.index("E8 high"), 0] = True
    assert replace(found, sphere_holds=apart).verdict("E8") == "undecidable"
    some = np.array(found.sphere_holds)
    some[0] = True, False
    assert replace(found, sphere_holds=some).verdict("E1") == "undecidable"
    assert [found.better(claim) for claim in ("E1", "E2", "E3", "E4")] == [0, 0, 0, 0]
    assert found.cases == tuple(f"{layout}, 30 mm, 400 N, bearing-steel" for layout in LAYOUTS)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"material": ("steel",)}, "material must be one of .*got 'steel'"),
        ({"radius": ()}, r"radius must be a row of values, got \(\)"),
        ({"preload": (0.0,)}, r"preload must be > 0 N, got 0.0"),
        ({"layout": ("flat",)}, "layout must be one of tetrahedral, cubic, got 'flat'"),
    ],
)
def test_messages(change, message):
    with pytest.raises(iv.InputError, match=message):
        iv.sphere_claims(**{"radius": (0.03,), "preload": (400.0,), "material": ("bearing-steel",)} | change)

"""Why a motion takes another energy when controllers follow it, in words."""

import pytest

from infinivar.analysis.forward import TwoWays

EXACT = {"prescribed": 2.0, "as_turning": 2.0, "followed": 2.3, "rms_error": 2.5e-4, "stays": False}


def two_ways(lost_prescribed, lost_followed, **changes):
    given = {**EXACT, "speed_ripple": 0.0, "stored": 0.0, "simulation": None, **changes}
    return TwoWays(lost_prescribed=lost_prescribed, lost_followed=lost_followed, **given)


def test_a_loss_that_one_way_does_not_have_counts_as_none_there():
    """The three largest changes of 2.3 J, and none of those below a thousandth of it: 0.4, -0.2 and 0.1 J by subtraction."""
    said = two_ways(
        {"winding": 1.0, "slip": 0.2, "guideway": 0.5},
        {"winding": 1.1, "pulley": 0.4, "guideway": 0.501},
    ).explanation
    assert said == (
        "+0.3 J (+15.0%), most of it in pulley +0.4 J, slip -0.2 J, winding +0.1 J; "
        "the load is 0.25 mm (RMS) from where it is wanted"
    )


@pytest.mark.parametrize(("change", "named"), [(0.0022, False), (0.0024, True)])
def test_losses_below_a_thousandth_are_not_named(change, named):
    said = two_ways({"winding": 1.0}, {"winding": 1.0 + change}).explanation
    assert ("winding" in said) == named


def test_what_the_cylinder_and_stays_do_is_said():
    """0.3 J in all, of which 0.25 J remain where the cylinder turns as it did."""
    said = two_ways({}, {}, as_turning=2.05, speed_ripple=0.031, stays=True).explanation
    assert said.startswith("+0.3 J (+15.0%); the load is")
    assert "swings by 3.1%" in said
    assert "with that speed prescribed the difference is +0.25 J" in said
    assert "before a stay the controllers bring it to rest first" in said
    assert two_ways({}, {}, prescribed=0.0, followed=0.0).explanation.startswith("+0 J; the load is")

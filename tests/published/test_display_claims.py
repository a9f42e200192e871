"""The paper's statements on dynamic range and low electrical power: verdicts, and against other ways to the same numbers."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import infinivar as iv
from internals import sampled_loop, varied_sessions
from made import loaded

pytestmark = pytest.mark.slow

DRIVES = loaded("hand_controller").drives
PAIR = iv.displays.DisplayPair(cobotic=DRIVES["cobotic"], conventional=DRIVES["motor2-gear4"])


@pytest.fixture(scope="module")
def found():
    return iv.paper.display_claims()


def test_verdicts(found):
    """Faulring et al. print no number; the conventional display is the threshold."""
    verdicts = {one.id: one.verdict for one in found.claims}
    assert {name for name, one in verdicts.items() if one == "holds"} == {"H1"}
    assert {name for name, one in verdicts.items() if one == "does not hold"} == {"H4"}
    assert {name for name, one in verdicts.items() if one == "undecidable"} == {
        "H2",
        "H3",
        "H5",
        "H6",
        "H7",
        "H8",
        "H9",
    }
    assert found.verdict == "holds: H1; undecidable: H2, H3, H5, H6, H7, H8, H9; does not hold: H4"
    assert len(found.lines) == 9
    assert json.loads(json.dumps(found.to_dict(), allow_nan=False))["claims"][0]["id"] == "H1"
    with pytest.raises(iv.InputError, match=r"^name must be one of H1, H2"):
        found.claim("E1")


def test_power_against_a_high_force(found):
    """By the comparison of shared motors, and by R (F r/(k N))^2."""
    shared = iv.analysis.share_motor(PAIR.cobotic, PAIR.conventional, force=[50.0], legs=(1, 6))
    for name, place in (("H1", 1), ("H2", 0)):
        assert_allclose(found.claim(name).computed, shared.turning[0, place, 0], rtol=5e-3)
    motor = PAIR.conventional.motor
    winding = 6.0 * motor.resistance * (50.0 * 0.005 / (4.0 * motor.torque_constant)) ** 2
    assert f"{winding:.2f} W" in found.claim("H1").threshold
    assert found.claim("H2").why.startswith("Holds as shown, but not with: friction of the conventional display helps")


def test_clutched_state_against_the_linear_drift(found):
    """Creep of a locked link, R omega F/C."""
    claim = found.claim("H5")
    assert claim.computed == 0.0
    creeping = next(one for one in claim.variants if one.verdict == "does not hold")
    element = PAIR.cobotic.transmission
    drift = 0.05 * 14.0 * 50.0 / float(element.groups(14.0).creep_stiffness)
    assert_allclose(creeping.computed, 1e3 * drift, rtol=1e-3)


def test_range_against_the_z_width(found):
    """At a low frequency the decades between both envelopes are those of stiffest wall over least mass."""
    arm = iv.motion.ArmModel.named("vanbeek2015")
    mine, other = (
        iv.displays.z_width(one, arm, frequency=[0.5, 1.0]) for one in (PAIR.admittance(1.0), PAIR.impedance())
    )
    assert_allclose(math.log10(found.claim("H7").computed), mine.decades[0] - other.decades[0], atol=0.03)
    assert_allclose(found.claim("H6").computed, mine.mass_felt[0], rtol=0.01)
    assert_allclose(found.comparison.stiffness[0, 0], mine.stiffness_felt[0], rtol=0.02)


def test_rivals_with_a_force_sensor(found):
    """H6 and H7 hang on the rival: its mass over 1 + gain by the growth of the sampled loop, and walls found by bisection."""
    arm = iv.motion.ArmModel.named("vanbeek2015")
    rival = replace(PAIR.impedance(), filter_frequency=PAIR.filter_frequency)

    def stable(display):
        return sampled_loop(display, arm).stable

    def largest(makes, low, high):
        """Largest value up to which the display is stable, by bisection."""
        for _ in range(50):
            middle = math.sqrt(low * high)
            low, high = (middle, high) if stable(makes(middle)) else (low, middle)
        return low

    gain = largest(lambda one: replace(rival, force_gain=one), 1e-3, 100.0) / 1.1
    mass = rival.reflected_mass / (1.0 + gain) + PAIR.handle_mass
    light = next(
        one for one in found.claim("H6").variants if one.assuming == "a conventional display with a force sensor"
    )
    assert light.threshold == f"below {mass:.2f} kg, of the conventional display"
    assert (light.verdict, found.claim("H6").verdict) == ("does not hold", "undecidable")
    ours = PAIR.admittance(found.claim("H6").computed - PAIR.handle_mass)
    walls = [
        max(
            largest(lambda one, made=made, b=b: replace(made, wall_stiffness=one, wall_damping=b), 1.0, 1e7)
            for b in (300.0, 1000.0)
        )
        for made in (ours, rival)
    ]
    ratio = walls[0] / found.claim("H6").computed / (walls[1] / mass)
    damped = next(
        one
        for one in found.claim("H7").variants
        if one.assuming.startswith("a conventional display with a force sensor, ")
    )
    assert_allclose(damped.computed, ratio, rtol=0.02)
    assert (damped.verdict, found.claim("H7").verdict) == ("does not hold", "undecidable")


def test_variants_beyond_the_requirement_do_not_count(found):
    names = {one.assuming for one in found.claim("H1").variants}
    assert "reconstruction B, preload / 1.5" not in names
    assert "reconstruction B, preload x 1.5" in names
    assert not np.all(found.comparison.feasible)


def test_sessions_are_varied():
    session = iv.displays.HandleSession(free=0.5, contact=0.3, hold=0.1, explore=0.0)
    varied = dict(varied_sessions(session, 1.5))
    assert "1.5 times as much free motion in the session" not in varied  # more than the whole time
    assert "1/1.5 as much free motion in the session" in varied
    assert not any("exploring in the session" in name for name in varied)
    assert all(one.hold_force <= 50.0 for one in varied.values())


def test_bad_input():
    for message, call in {
        "session must be a HandleSession": lambda: iv.paper.display_claims(20.0),
        "arm must be an ArmModel": lambda: iv.paper.display_claims(arm="me"),
        "factor must be > 1": lambda: iv.paper.display_claims(factor=1.0),
        "session must be one whose requirement the shipped machine meets": lambda: iv.paper.display_claims(
            replace(iv.displays.HandleSession(), required_force=70.0)
        ),
    }.items():
        with pytest.raises(iv.InputError) as caught:
            call()
        assert str(caught.value).startswith(message)

"""What is true of every session on both displays: more force or axes never cost less, and a round is the sum of its parts."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

import infinivar as iv
from internals import SESSION_PARTS as PARTS
from internals import cobotic_part, geared_part, round_of
from made import loaded
from sampled import examples

DRIVES = loaded("hand_controller").drives
PAIRS = [
    iv.displays.DisplayPair(cobotic=DRIVES[name], conventional=DRIVES["motor2-gear4"])
    for name in ("cobotic", "cobotic-b")
]
pairs = st.sampled_from(PAIRS)
forces = st.floats(0.0, 50.0)
few = examples(25)


@st.composite
def sessions(draw):
    """With shares of at most 1 together, and forces and speeds within the requirement."""
    weights = np.array(draw(st.lists(st.floats(0.01, 1.0), min_size=5, max_size=5)))
    free, contact, hold, explore, _ = (weights / weights.sum()).tolist()
    return iv.displays.HandleSession(
        round_time=draw(st.floats(1.0, 100.0)),
        free=free,
        contact=contact,
        hold=hold,
        explore=explore,
        contact_force=draw(forces),
        hold_force=draw(forces),
        explore_force=draw(st.floats(0.0, 20.0)),
    )


@few
@given(pairs, forces, forces, st.integers(1, 6))
def test_more_force_never_costs_less(pair, one, other, axes):
    low, high = (iv.displays.HandleSession(hold_force=force, contact_force=force) for force in sorted([one, other]))
    for part in ("hold", "contact"):
        for cost, drive in ((cobotic_part, pair.cobotic), (geared_part, pair.conventional)):
            less, more = (cost(drive, session, part, axes=axes, handle_mass=0.5) for session in (low, high))
            assert less.supply <= more.supply * (1.0 + 1e-12)
            assert less.heating <= more.heating * (1.0 + 1e-12)


@pytest.mark.slow
@few
@given(pairs, sessions())
def test_a_round_is_the_sum_of_its_parts(pair, session):
    counts = (1, 3, 6)
    found = round_of(pair, session, counts)
    assert_allclose(sum(session.shares.values()), 1.0)
    for row, (cost, drive) in {0: (cobotic_part, pair.cobotic), 3: (geared_part, pair.conventional)}.items():
        for place, axes in enumerate(counts):
            each = [cost(drive, session, part, axes=axes, handle_mass=pair.handle_mass).supply for part in PARTS]
            whole = session.round_time * sum(
                share * power for share, power in zip(session.shares.values(), each, strict=True)
            )
            assert_allclose(np.sum(found["energy"][row, place]), whole, rtol=1e-12)
    energy = found["energy"].sum(axis=-1)
    assert np.all(found["energy"] >= 0.0)
    assert np.all(np.diff(energy, axis=1) >= 0.0)
    assert_allclose(energy[3], energy[3, 0] * np.array(counts), rtol=1e-12)
    assert_allclose(found["user"][3], found["user"][3, 0] * np.array(counts), rtol=1e-12, atol=1e-12)
    # What a stop saves is the idling energy, and it costs one run-up.
    idle = found["energy"][0, :, PARTS.index("idle")]
    assert_allclose(energy[0] - energy[1], idle - found["energy"][1, :, -1], rtol=1e-9, atol=1e-9)
    # A stop pays from the time on that the run-up is worth.
    resting = session.round_time * session.shares["idle"]
    assert np.all((energy[1] < energy[0]) == (resting > found["stop"]))


@few
@given(pairs, sessions(), st.floats(0.5, 3.0))
def test_a_longer_round_costs_as_much_more(pair, session, scale):
    """But for the run-ups, of which there is one in a round however long."""
    one, other = (
        round_of(pair, replace(session, round_time=time), (2,))["energy"]
        for time in (session.round_time, scale * session.round_time)
    )
    assert_allclose(other[..., :-1], scale * one[..., :-1], rtol=1e-9)
    assert_allclose(other[..., -1], one[..., -1], rtol=1e-12)


@few
@given(pairs, st.floats(0.05, 0.5), st.floats(0.0, 1.0))
def test_friction_is_paid_by_the_user_or_the_motor(pair, speed, share):
    """What is fed forward saves the user its power, and heats the winding on top of it."""
    session = iv.displays.HandleSession(free_speed=speed)
    power = geared_part(pair.conventional, session, "free", axes=1, handle_mass=0.5, compensation=share)
    rubbing = sum(pair.motors.frictions)
    resistance = pair.conventional.motor.resistance
    by_motor = share * rubbing * speed * 2.0 / math.pi
    assert_allclose(power.user, (1.0 - share) * rubbing * speed * 2.0 / math.pi, rtol=1e-4, atol=1e-9)
    assert_allclose(
        power.supply, by_motor + resistance * (share * rubbing / pair.motors.gain) ** 2, rtol=1e-4, atol=1e-12
    )

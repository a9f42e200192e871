"""Counts, noise and friction of displays, virtual couplings, passivity controllers: conditions against cycles and runs."""

import math
from dataclasses import replace

import numpy as np
import pytest

import infinivar as iv
from internals import (
    general_required_damping,
    impedance,
    required_damping,
    required_friction,
    run_in_time,
    virtual_coupling,
)

ARM = iv.motion.ArmModel.named("vanbeek2015")
DRIVES = iv.load_study("hand_controller").drives
GEARED = iv.displays.ImpedanceDisplay(drive=DRIVES["motor2-gear4"], viscous_friction=2.0, handle_mass=0.5)
PERIOD = 1e-3


def _gained(stiffness, damping, viscous, friction, count, travels, late=0):
    """Largest energy that a cycle across the edge of a count gains, in and out between samples at constant speed. [J]"""
    found = []
    for travel in travels:
        # Just before an edge, for as long as a cycle lasts; late forces meet the motion after a pause.
        rest = [0.0] * late
        moves = [travel, *rest, -travel, *rest] * 3
        place = np.concatenate([[0.0], np.cumsum(moves)]) - 1e-12
        counted = count * np.floor(place / count)
        force = stiffness * counted + damping * np.diff(counted, prepend=counted[0]) / PERIOD
        held = np.concatenate([np.full(late, force[0]), force[:-1]])[: len(moves)]
        # Over the last cycle, which repeats.
        last = slice(-(2 + 2 * late), None)
        gained = -np.sum(np.array(moves)[last] * held[last])
        lost = 2.0 * (friction * travel + viscous * travel**2 / PERIOD)
        found.append(gained - lost)
    return max(found)


@pytest.mark.parametrize("late", [0, 1])
@pytest.mark.parametrize(("stiffness", "damping"), [(2000.0, 0.0), (500.0, 4.0)])
def test_friction_against_cycles_over_an_edge(stiffness, damping, late):
    """With little travel the counts decide: at 1.05 of the friction needed no cycle gains, at 0.95 one does."""
    count = 2e-5
    friction = required_friction(stiffness, damping, PERIOD, count)
    viscous = 1.05 * required_damping(stiffness, damping, PERIOD)
    travels = np.geomspace(1e-8, 0.1 * count, 40)
    assert _gained(stiffness, damping, viscous, 1.05 * friction, count, travels, late) < 0.0
    assert _gained(stiffness, damping, 0.0, 0.95 * friction, count, travels, late) > 0.0


def test_friction_and_damping_together_suffice():
    """Abbott and Okamura: K <= min(2 b/T, 2 f/Delta), for cycles of any travel."""
    count, viscous, friction = 1e-5, 1.2, 0.02
    most = min(2.0 * viscous / PERIOD, 2.0 * friction / count)
    travels = np.concatenate([np.geomspace(1e-9, 1e-2, 200), count * np.arange(1, 300)])
    assert _gained(0.95 * most, 0.0, viscous, friction, count, travels) < 0.0
    assert _gained(1.05 * most, 0.0, viscous, friction, count, travels) > 0.0


def test_passivity_knows_the_counts():
    at_once = replace(GEARED, samples_late=0, wall_stiffness=2000.0, encoder_resolution=1e-5)
    dry = iv.displays.passivity(at_once)
    assert dry.passive is False
    assert "encoder counts of 10 um need 0.01 N of friction, there is 0 N" in dry.verdict
    assert iv.displays.passivity(replace(at_once, coulomb_friction=0.0105)).passive
    assert iv.displays.passivity(replace(at_once, coulomb_friction=0.0095)).passive is False


def test_counts_make_a_wall_chatter():
    """A loop that is stable by its eigenvalues ends in a limit cycle without friction, and at rest with enough of it."""
    wall = replace(GEARED, wall_stiffness=3000.0, wall_damping=40.0, encoder_resolution=2e-5)
    assert iv.displays.stiffest_wall(wall, ARM) > 3000.0
    start = [5e-4, 0.0]

    def last(display):
        """Travel within the last half second, over a count."""
        run = run_in_time(display, ARM, start, 3000)
        return np.ptp(run.state[-4000:, 0]) / 2e-5

    friction = required_friction(3000.0, 40.0, PERIOD, 2e-5)
    assert last(replace(wall, encoder_resolution=0.0)) < 1e-3
    assert last(wall) > 0.1
    assert last(replace(wall, coulomb_friction=1.05 * friction)) < 1e-3


def test_noise_is_felt_as_force():
    """Its root mean square in a run at rest moves a virtual mass as white noise held over samples does."""
    display = iv.displays.AdmittanceDisplay(
        drive=DRIVES["cobotic"], virtual_mass=2.0, handle_mass=0.5, filter_frequency=100.0, force_noise=0.05
    )
    states = len(display.plant(ARM).states)
    quiet = run_in_time(replace(display, force_noise=0.0), ARM, np.zeros(states), 400)
    assert np.all(quiet.state == 0.0)
    one, other = (run_in_time(display, ARM, np.zeros(states), 400, seed=seed) for seed in (0, 1))
    assert np.any(one.state != other.state)
    louder = run_in_time(replace(display, force_noise=0.1), ARM, np.zeros(states), 400)
    np.testing.assert_allclose(louder.state, 2.0 * one.state, rtol=1e-9, atol=1e-15)
    width = iv.displays.z_width(display, ARM, [0.1, 1.0])
    assert width.least_force == 0.05
    assert "nothing is felt below 0.05 N" in width.verdict
    np.testing.assert_allclose(width.floor(0.01), np.maximum(np.abs(width.softest), 5.0))
    geared = replace(GEARED, coulomb_friction=9.13, encoder_resolution=1e-5, wall_damping=100.0)
    width = iv.displays.z_width(geared, ARM, [0.1, 1.0])
    assert width.least_force == 9.13
    assert required_friction(width.wall, width.counted, PERIOD, 1e-5) == pytest.approx(9.13)
    assert math.isinf(iv.displays.z_width(GEARED, ARM, [0.1, 1.0]).counted)


@pytest.mark.parametrize("late", [0, 1])
def test_a_virtual_coupling_and_any_passive_object(late):
    """Random passive objects of sampled data behind it; at 1.02 of its stiffness one is not passive."""
    damping = 2.0
    stiffness, damper = virtual_coupling(damping, PERIOD, late)
    draw = np.random.default_rng(8)

    def needed(scale, ratio, object_):
        def transfer(z):
            across = (1.0 - 1.0 / z) / PERIOD
            coupling = (scale * stiffness + ratio * damper * across) / across
            whole = coupling * object_(z, across) / (coupling + object_(z, across))
            return whole * across * z**-late

        return general_required_damping(transfer, PERIOD)[0]

    def some(b, k, m):
        """Damper, spring and mass with a trapezoidal rule, in parallel: passive."""

        def made(z, across):
            trapezoid = 0.5 * PERIOD * (z + 1.0) / (z - 1.0)
            return b + k * trapezoid + m / trapezoid

        return made

    worst = 0.0
    for _ in range(300):
        worst = max(worst, needed(1.0, 1.0, some(*(10.0 ** draw.uniform(-6.0, 8.0, 3)))))
    assert worst <= damping * (1.0 + 1e-9)
    angle = np.linspace(0.01, math.pi, 2000)
    k, a = 0.5 * stiffness * PERIOD, 0.5 * stiffness * PERIOD + damper
    half = np.sin(0.5 * angle) ** 2
    # The disc of all passive objects, angle by angle.
    disc = half * (4.0 * (1.0 - half) if late else 1.0) / half * (a**2 * half + k**2 * (1.0 - half)) / a
    assert np.max(disc) == pytest.approx(damping, rel=1e-3)
    # A spring alone, or another damper, has to be softer.
    if late:
        for b in (0.0, 0.5 * damper, 2.0 * damper):
            other = k + b
            disc = 4.0 * (1.0 - half) * (other**2 * half + k**2 * (1.0 - half)) / other
            assert np.max(disc) > damping


def test_an_observer_and_a_controller_of_passivity():
    """A wall beyond its stability grows; the controller holds it. Observed is the energy of the motor's force."""
    stiffest = iv.displays.stiffest_wall(GEARED, ARM)
    wall = replace(GEARED, wall_stiffness=3.0 * stiffest)
    start = [0.0, 0.05]
    wild = run_in_time(wall, ARM, start, 3000)
    held = run_in_time(wall, ARM, start, 3000, passivity_control=True)
    assert np.max(np.abs(wild.state[-800:, 0])) > 5.0 * np.max(np.abs(wild.state[:800, 0]))
    assert np.max(np.abs(held.state[-800:, 0])) < np.max(np.abs(held.state[:800, 0]))
    for run in (wild, held):
        force = GEARED.force_per_current * run.current[1:]
        taken = -np.cumsum(force * np.diff(run.state[:, 0]))[7::8]
        np.testing.assert_allclose(run.observed[1:], taken, rtol=1e-9, atol=1e-12)
    assert run.observed.min() > 0.05 * wild.observed.min()
    # A wall that never gives energy is left alone.
    soft = replace(GEARED, wall_stiffness=100.0, samples_late=0, wall_damping=1.0)
    one, other = (run_in_time(soft, ARM, start, 300, passivity_control=on) for on in (False, True))
    if one.observed.min() >= 0.0:
        np.testing.assert_array_equal(one.state, other.state)
    cobotic = iv.displays.AdmittanceDisplay(drive=DRIVES["cobotic"], virtual_mass=1.0)
    with pytest.raises(iv.InputError, match="passivity_control does not apply"):
        run_in_time(cobotic, ARM, np.zeros(4), 10, passivity_control=True)


def test_friction_stops_a_handle_as_it_does_a_block():
    """A push at 0.1 m/s against a constant force stops after m v^2/(2 f)."""
    free = replace(GEARED, coulomb_friction=2.0, viscous_friction=0.0)
    mass = free.drive_mass + 0.5
    run = run_in_time(free, "free", [0.0, 0.1], 400)
    assert run.state[-1, 0] == pytest.approx(mass * 0.1**2 / 4.0, rel=1e-2)
    assert run.state[-1, 1] == 0.0
    assert impedance(free, [1.0], ARM)[0] == impedance(replace(free, coulomb_friction=0.0), [1.0], ARM)[0]

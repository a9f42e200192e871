"""Displays whose handle hangs on structure and sensor: walls and masses against runs written anew, and closed forms."""

import math
from dataclasses import replace

import numpy as np
import pytest

import infinivar as iv
from internals import impedance, required_damping, run_in_time, sampled_loop

ARM = iv.motion.ArmModel.named("vanbeek2015")
DRIVES = iv.load_study("hand_controller").drives
SAME = {"handle_mass": 0.5, "filter_frequency": 100.0, "wall_damping": 100.0}
STRUCTURE = {"structure_stiffness": 1e5, "structure_damping": 20.0, "sensor_stiffness": 4e5}
COBOTIC = iv.displays.AdmittanceDisplay(drive=DRIVES["cobotic"], virtual_mass=1.1, **SAME)
GEARED = iv.displays.ImpedanceDisplay(drive=DRIVES["motor2-gear4"], viscous_friction=2.0, **SAME)
SERVOED = iv.displays.AdmittanceDisplay(drive=DRIVES["motor2-gear4"], virtual_mass=1.5, viscous_friction=2.0, **SAME)
RIVALS = iv.displays.usual_rivals(DRIVES["motor2-gear4"])
DISPLAYS = {
    "cobotic": COBOTIC,
    "geared": GEARED,
    "direct drive": replace(GEARED, drive=RIVALS["direct drive"].drive),
    "cable drive": replace(GEARED, drive=RIVALS["cable drive"].drive),
    "geared with a force sensor": SERVOED,
}
WITHIN = 2000
"""Explicit steps in a sample: the creep of the contact settles within microseconds."""


class Anew:
    """A display with its handle on a spring, in scalar equations with explicit Runge-Kutta steps."""

    def __init__(self, display, arm):
        self.display, self.arm, self.drive = display, arm, display.drive
        self.cobotic = self.drive is DRIVES["cobotic"]
        self.servoed = isinstance(display, iv.displays.AdmittanceDisplay)
        self.spring = 1.0 / (1.0 / display.structure_stiffness + 1.0 / display.sensor_stiffness)
        drive = self.drive
        if self.cobotic:
            groups = drive.transmission.groups(drive.cylinder_speed)
            self.surface = drive.transmission.cylinder_radius * drive.cylinder_speed
            self.creep = groups.creep_stiffness / self.surface
            self.rolling = (groups.rolling_torque + groups.bearing_torque) / drive.transmission.wheel_radius
            self.mass = drive.link_mass
            self.bell = drive.steering.bell_inertia + drive.steering.ratio**2 * drive.steering.motor.rotor_inertia
            self.pull = drive.steering.ratio * drive.steering.motor.torque_constant
        else:
            radius, ratio = drive.pulley.radius, drive.gearhead.ratio
            self.mass = (drive.motor.rotor_inertia * ratio**2 + drive.output_inertia) / radius**2
            self.pull = drive.motor.torque_constant * ratio / radius
        # Handle, drive, wheel, filtered force; the current held.
        basis, step = np.eye(9), 1e-3 / WITHIN
        k1 = self.rates(basis)
        k2 = self.rates(basis + 0.5 * step * k1)
        k3 = self.rates(basis + 0.5 * step * k2)
        k4 = self.rates(basis + step * k3)
        self.sample = np.linalg.matrix_power(basis + step / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4), WITHIN)

    def rates(self, state):
        x_h, v_h, x_d, v_d, phi, turning, force, rise, current = state
        between = self.spring * (x_h - x_d) + self.display.structure_damping * (v_h - v_d)
        if self.cobotic:
            push = -self.creep * (v_d + self.surface * phi) + self.rolling * phi
            bent = self.pull * current / self.bell
        else:
            push, bent = self.pull * current - self.display.viscous_friction * v_d, 0.0 * current
        hand = -self.arm.damping * v_h - self.arm.stiffness * x_h - between
        corner = 2.0 * math.pi * self.display.filter_frequency
        return np.array([
            v_h, hand / (self.display.handle_mass + self.arm.mass), v_d, (push + between) / self.mass, turning, bent,
            rise, corner**2 * (between - force) - math.sqrt(2.0) * corner * rise, 0.0 * current,
        ])  # fmt: skip

    def control(self, state):
        show, period = self.display, 1e-3
        _, _, x, v, phi, turning, force, _, _ = state
        if not self.servoed:
            speed, self.before = (x - self.before) / period, x
            return -(show.wall_stiffness * x + show.wall_damping * speed) / self.pull
        speed = (show.virtual_mass * self.before + period * (force - show.wall_stiffness * x)) / (
            show.virtual_mass + period * show.wall_damping
        )
        rise, self.before = (speed - self.before) / period, speed
        pole = 2.0 * math.pi * 25.0
        if self.cobotic:
            pull = pole**2 * (-speed / self.surface - phi) + 2.0 * pole * (-rise / self.surface - turning)
            return self.bell / self.pull * pull
        self.place += period * speed
        push = pole**2 * (self.place - x) + 2.0 * pole * (speed - v) + rise
        return (self.mass + show.handle_mass) / self.pull * push

    def grows(self, samples=6000):
        """Whether the motion after a push grows: its envelope in the last quarter against that of the quarter before."""
        self.before, self.place, waiting = 0.0, 0.0, 0.0
        state, found = np.zeros(9), np.empty(samples)
        state[1] = 1e-3
        for index in range(samples):
            state[8], waiting = waiting, self.control(state)
            state = self.sample @ state
            found[index] = abs(state[0]) + 1e-3 * abs(state[1])
            if not found[index] < 1e100:
                return True
        quarter = samples // 4
        return bool(found[-quarter:].max() > found[-2 * quarter : -quarter].max())


def _able(display):
    """With a virtual mass that is stable in free motion."""
    if isinstance(display, iv.displays.ImpedanceDisplay):
        return display
    return replace(display, virtual_mass=1.1 * iv.displays.least_stable_mass(display.softest(), ARM))


@pytest.mark.parametrize("structure", [STRUCTURE, {**STRUCTURE, "structure_stiffness": 2e4}], ids=["stiff", "soft"])
@pytest.mark.parametrize("name", DISPLAYS)
def test_stiffest_walls_against_runs_in_time(name, structure):
    """At 0.95 of the stiffest wall a run decays, at 1.05 it grows."""
    display = _able(replace(DISPLAYS[name], **structure))
    stiffest = iv.displays.stiffest_wall(display, ARM)
    assert 1e3 < stiffest < 1e6
    for share, grows in ((0.95, False), (1.05, True)):
        at = replace(display, wall_stiffness=share * stiffest)
        assert Anew(at, ARM).grows() is grows
        assert sampled_loop(at, ARM).stable is not grows


@pytest.mark.parametrize("name", ["cobotic", "geared with a force sensor"])
def test_least_masses_against_runs_in_time(name):
    display = replace(DISPLAYS[name], **STRUCTURE, wall_damping=0.0)
    least = iv.displays.least_stable_mass(display, ARM)
    for share, grows in ((0.95, True), (1.05, False)):
        assert Anew(replace(display, virtual_mass=share * least), ARM).grows() is grows


def test_equal_damping_gives_a_ratio_of_two_to_four():
    """B = 100 N s/m, no structure: 127 N/mm for the cobotic display over a margin of 1.1, 64 N/mm for the geared one."""

    def walls(**structure):
        found = [_able(replace(one, **structure)) for one in (COBOTIC, GEARED)]
        return [one.at_handle(iv.displays.stiffest_wall(one, ARM) / 1.1) for one in found]

    cobotic, geared = walls()
    assert cobotic == pytest.approx(127e3, rel=0.01)
    assert geared == pytest.approx(64e3, rel=0.01)
    # A structure of 100 N/mm takes the lead away.
    cobotic, geared = walls(structure_stiffness=1e5)
    assert cobotic / geared == pytest.approx(1.1, rel=0.02)


@pytest.mark.parametrize("name", DISPLAYS)
def test_a_wall_is_felt_in_series_with_structure_and_sensor(name):
    """At low frequency, by the response of the whole loop."""
    display = replace(DISPLAYS[name], **STRUCTURE, wall_damping=0.0, wall_stiffness=3000.0)
    omega = 2.0 * math.pi * 0.05
    felt = -complex(impedance(display, [0.05], ARM)[0]).imag * omega
    assert display.at_handle(3000.0) == pytest.approx(1.0 / (1.0 / 3000.0 + 1.0 / 1e5 + 1.0 / 4e5))
    assert felt == pytest.approx(display.at_handle(3000.0), rel=1e-3)
    assert display.at_handle(math.inf) == display.series_stiffness
    assert DISPLAYS[name].at_handle(3000.0) == 3000.0


@pytest.mark.parametrize("name", DISPLAYS)
def test_a_rigid_handle_is_the_limit_of_a_stiff_one(name):
    rigid = DISPLAYS[name]
    stiff = replace(rigid, structure_stiffness=1e10, structure_damping=1e4)
    assert iv.displays.stiffest_wall(stiff, ARM) == pytest.approx(iv.displays.stiffest_wall(rigid, ARM), rel=2e-3)
    frequency = [1.0, 30.0]
    np.testing.assert_allclose(impedance(stiff, frequency, ARM), impedance(rigid, frequency, ARM), rtol=1e-4)


def test_the_mode_of_structure_and_masses():
    """Without controller and hand, the drive and the handle swing at sqrt(k/m) of their reduced mass."""
    free = replace(GEARED.softest(), structure_stiffness=1e5, structure_damping=0.0, viscous_friction=0.0)
    plant = free.plant("free")
    mass = free.reflected_mass * 0.5 / (free.reflected_mass + 0.5)
    assert plant.states == ("x_m", "v_m_s", "x_drive_m", "v_drive_m_s")
    assert np.max(np.linalg.eigvals(plant.system).imag) == pytest.approx(math.sqrt(1e5 / mass), rel=1e-9)


def test_the_structure_of_a_drive_is_the_default():
    """Gearhead and stage in series at the output; a cobotic drive states none."""
    drive = DRIVES["motor2-gear4"]
    soft = replace(drive, gearhead=replace(drive.gearhead, stiffness=5.0))
    display = replace(GEARED, drive=soft)
    assert display.series_stiffness == pytest.approx(5.0 / drive.pulley.radius**2)
    mass = display.reflected_mass
    assert display.series_damping == pytest.approx(0.1 * math.sqrt(display.series_stiffness * mass))
    assert display.carried_by == "gearhead"
    stated = replace(display, structure_stiffness=1e4, structure_damping=3.0)
    assert (stated.series_stiffness, stated.series_damping, stated.carried_by) == (1e4, 3.0, "stated")
    assert (COBOTIC.series_stiffness, COBOTIC.carried_by) == (math.inf, "not stated, rigid")
    assert replace(COBOTIC, sensor_stiffness=3e5).series_stiffness == pytest.approx(3e5)


def test_a_handle_without_mass_cannot_hang_free():
    hung = replace(GEARED, handle_mass=0.0, structure_stiffness=1e5)
    assert sampled_loop(hung, ARM).growth > 0.0
    assert hung.plant("clamped").states == ("x_drive_m", "v_drive_m_s")
    with pytest.raises(iv.ParameterError, match="handle_mass must be > 0 kg, got 0: it hangs on structure"):
        hung.plant("free")


@pytest.mark.slow
@pytest.mark.parametrize("name", DISPLAYS)
def test_z_widths_against_sweeps_in_time(name):
    """Both envelopes at two frequencies, with structure and sensor."""
    display = _able(replace(DISPLAYS[name], **STRUCTURE))
    frequency = [4.0, 60.0]
    width = iv.displays.z_width(display, ARM, frequency)
    at = (
        display.softest() if math.isnan(width.least_mass) else replace(display.softest(), virtual_mass=width.least_mass)
    )
    wall = 1.0 / (1.0 / width.wall - 1.0 / display.series_stiffness)
    for made, known in ((at, width.softest), (replace(display, wall_stiffness=wall), width.stiffest)):
        for one, expected in zip(frequency, known, strict=True):
            assert abs(iv.displays.swept_impedance(made, ARM, one) - expected) < 2e-3 * abs(expected)


def _swings(display, arm, samples=20000):
    """Growth of the motion in a run in time: its envelope in the last eighth over that of the fifth eighth."""
    start = np.zeros(len(display.plant(arm).states))
    start[0] = 1e-3
    position = np.abs(run_in_time(display, arm, start, samples, within=4).state[:, 0])
    eighth = len(position) // 8
    return float(position[-eighth:].max() / position[4 * eighth : 5 * eighth].max())


@pytest.mark.slow
@pytest.mark.parametrize("name", ["geared", "direct drive", "cable drive"])
def test_passivity_in_time(name):
    """At 1.05 of the damping needed a heavy hand without damping comes to rest, at 0.95 it swings up."""
    display = replace(DISPLAYS[name], wall_damping=0.0, wall_stiffness=2000.0)
    heavy = replace(ARM, mass=50.0, damping=0.0, stiffness=0.0)
    for share, passive in ((1.05, True), (0.95, False)):
        at = replace(display, viscous_friction=share * required_damping(2000.0, 0.0, 1e-3, 1))
        assert iv.displays.passivity(at).passive is passive
        assert (_swings(at, heavy) < 1.0) is passive


@pytest.mark.slow
@pytest.mark.parametrize("name", ["cobotic", "geared with a force sensor"])
def test_a_passive_hand_finds_the_activity_of_a_virtual_mass(name):
    """Where the real part is negative, a hand without damping that takes up the rest of the impedance swings up."""
    display = replace(DISPLAYS[name], wall_damping=0.0, virtual_mass=3.0)
    found = iv.displays.passivity(display)
    assert found.passive is False
    frequency = np.linspace(2.0, 100.0, 400)
    each = impedance(display, frequency)
    place = int(np.argmin(np.where(each.imag > 0.0, each.real / np.abs(each), np.inf)))
    omega, shown = 2.0 * math.pi * frequency[place], complex(each[place])
    assert shown.real < 0.0 < shown.imag
    hand = replace(ARM, mass=0.1, damping=0.0, stiffness=omega * (shown.imag + omega * 0.1))
    assert _swings(display, hand, 1000) > 1.0


@pytest.mark.parametrize("name", ["geared", "geared with a force sensor"])
def test_passivity_beyond_a_structure(name):
    """A spring and a mass in front of a passive drive stay passive; elsewhere the real part of the impedance decides."""
    display = replace(DISPLAYS[name], wall_damping=0.0, wall_stiffness=1000.0, **STRUCTURE)
    found = iv.displays.passivity(display)
    real = np.real(impedance(display, np.geomspace(0.5, 490.0, 300)))
    if name == "geared":
        assert found.passive
        assert real.min() > 0.0
        for share, passive in ((1.05, True), (0.95, False)):
            at = replace(display, viscous_friction=share * required_damping(1000.0, 0.0, 1e-3, 1))
            assert iv.displays.passivity(at).passive is passive
        loose = replace(display, viscous_friction=0.0, structure_damping=0.0)
        assert iv.displays.passivity(loose).passive is False
        assert "negative" in iv.displays.passivity(loose).verdict
    else:
        assert found.passive is False
        assert real.min() < 0.0


def test_a_z_width_ends_at_the_structure():
    width = iv.displays.z_width(replace(GEARED, structure_stiffness=1e5), ARM, [0.1, 1.0])
    assert width.stiffness_felt[0] == pytest.approx(width.wall, rel=2e-3)
    assert width.wall < 1e5

"""Sampled loops of haptic displays against runs in time, continuous time, and closed forms."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import infinivar as iv
from internals import (
    general_required_damping,
    impedance,
    required_damping,
    run_in_time,
    sampled_loop,
    wall_transfer,
    with_values,
)

ARM = iv.motion.ArmModel.named("vanbeek2015")
WITHIN = 2000
"""Explicit steps in a sample: the creep of the contact settles within microseconds."""


@pytest.fixture(scope="module")
def drives():
    return iv.load_study("hand_controller").drives


class ByHand:
    """A display written anew from its equations, with explicit Runge-Kutta steps of 1 microsecond or less."""

    def __init__(self, display, arm):
        self.display, self.arm, drive = display, arm, display.drive
        self.period = 1.0 / drive.control.sample_rate
        self.geared = isinstance(display, iv.displays.ImpedanceDisplay)
        if self.geared:
            radius, motor, ratio = drive.pulley.radius, drive.motor, drive.gearhead.ratio
            turning = motor.rotor_inertia * ratio**2 + drive.output_inertia
            self.mass = turning / radius**2 + display.handle_mass + arm.mass
            self.pull = motor.torque_constant * ratio / radius
            self.order = 2
        else:
            element, steering = drive.transmission, drive.steering
            self.surface = element.cylinder_radius * drive.cylinder_speed
            groups = element.groups(drive.cylinder_speed)
            self.creep = groups.creep_stiffness / self.surface
            self.rolling = (groups.rolling_torque + groups.bearing_torque) / element.wheel_radius
            self.mass = drive.link_mass + display.handle_mass + arm.mass
            self.bell = steering.bell_inertia + steering.ratio**2 * steering.motor.rotor_inertia
            self.pull = steering.ratio * steering.motor.torque_constant
            self.order = 4 + (0 if display.filter_frequency is None else display.filter_order)
        step, move = self.period / WITHIN, np.eye(self.order + 1)
        basis = np.eye(self.order + 1)

        def rates(columns):
            return np.array([*self.rates(columns[:-1], columns[-1]), 0.0 * columns[-1]])

        k1 = rates(basis)
        k2 = rates(basis + 0.5 * step * k1)
        k3 = rates(basis + 0.5 * step * k2)
        k4 = rates(basis + step * k3)
        move = basis + step / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
        self.sample = np.linalg.matrix_power(move, WITHIN)

    def sensor(self, state):
        link = -self.creep * (state[1] + self.surface * state[2]) + self.rolling * state[2]
        acceleration = (link - self.arm.damping * state[1] - self.arm.stiffness * state[0]) / self.mass
        return self.display.drive.link_mass * acceleration - link, acceleration

    def rates(self, state, current):
        if self.geared:
            damping = self.arm.damping + self.display.viscous_friction
            return [state[1], (self.pull * current - damping * state[1] - self.arm.stiffness * state[0]) / self.mass]
        force, acceleration = self.sensor(state)
        moving = [state[1], acceleration, state[3], self.pull * current / self.bell]
        if self.order == 4:
            return moving
        corner = 2.0 * math.pi * self.display.filter_frequency
        if self.order == 5:
            return [*moving, corner * (force - state[4])]
        return [*moving, state[5], corner**2 * (force - state[4]) - math.sqrt(2.0) * corner * state[5]]

    def control(self, state):
        show = self.display
        if self.geared:
            speed = (state[0] - self.before) / self.period
            self.before = state[0]
            return -(show.wall_stiffness * state[0] + show.wall_damping * speed) / self.pull
        force = state[4] if self.order > 4 else self.sensor(state)[0]
        measured = show.wall == "measured"
        damping = show.virtual_damping + show.wall_damping
        # Implicit Euler: M (v - before)/T = force - B v - K x, with x the measured or the new virtual position.
        if measured:
            total = show.virtual_mass / self.period + damping
            pull = show.wall_stiffness * state[0]
        else:
            total = show.virtual_mass / self.period + damping + show.wall_stiffness * self.period
            pull = show.wall_stiffness * self.place
        speed = (show.virtual_mass / self.period * self.before + force - pull) / total
        target_acceleration, self.before = (speed - self.before) / self.period, speed
        if not measured:
            self.place += self.period * speed
            gain = 2.0 * math.pi * show.drive.control.link_bandwidth
            target, target_acceleration = (
                speed + gain * (self.place - state[0]),
                target_acceleration + gain * (speed - state[1]),
            )
        else:
            target = speed
        pole = 2.0 * math.pi * show.drive.control.steering_bandwidth
        rate = -target_acceleration / self.surface if show.rate_feedforward else 0.0
        error = -target / self.surface - state[2]
        return self.bell / self.pull * (pole**2 * error + 2.0 * pole * (rate - state[3]))

    def run(self, samples):
        """Norm of all states, in units that make them alike, after each sample."""
        self.before, self.place, waiting, found = 0.0, 0.0, 0.0, np.empty(samples)
        state = np.zeros(self.order)
        state[0] = 1e-3
        # Creep has settled by the first sample.
        for index in range(samples):
            current = self.control(state)
            acting, waiting = (waiting, current) if self.display.samples_late else (current, 0.0)
            state = self.sample[:-1, :-1] @ state + self.sample[:-1, -1] * acting
            found[index] = math.sqrt((100.0 * state[0]) ** 2 + state[1] ** 2 + self.before**2)
        return found


def _cases(drives):
    """20 displays with arms, each with the parameter whose boundary is looked for."""
    draw = np.random.default_rng(21)
    found = []
    for number in range(20):
        arm = iv.motion.ArmModel(
            name="drawn",
            mass=draw.uniform(0.2, 2.0),
            damping=draw.uniform(2.0, 15.0),
            stiffness=draw.uniform(50.0, 600.0),
        )
        rate = draw.uniform(800.0, 3000.0)
        if number % 5 == 4:
            drive = with_values(drives["motor2-gear4"], {"control.sample_rate": rate})
            display = iv.displays.ImpedanceDisplay(
                drive=drive,
                viscous_friction=draw.uniform(0.0, 5.0),
                wall_damping=draw.uniform(0.0, 5.0),
                samples_late=number % 2,
            )
            found.append((display, arm, "wall_stiffness"))
            continue
        drive = with_values(
            drives["cobotic" if number % 2 else "cobotic-b"],
            {"control.sample_rate": rate, "control.steering_bandwidth": draw.uniform(8.0, 40.0)},
        )
        display = iv.displays.AdmittanceDisplay(
            drive=drive,
            virtual_mass=8.0,
            virtual_damping=draw.uniform(20.0, 80.0) if number % 4 == 3 else 0.0,
            wall_stiffness=draw.uniform(0.0, 500.0) if number % 4 > 1 else 0.0,
            wall_damping=draw.uniform(0.0, 10.0) if number % 4 == 3 else 0.0,
            handle_mass=draw.uniform(0.0, 0.3),
            filter_frequency=None if number % 7 == 0 else draw.uniform(40.0, 200.0),
            filter_order=1 + number % 2,
            wall="virtual" if number % 4 == 2 else "measured",
            rate_feedforward=number % 6 != 5,
            samples_late=0 if number % 9 == 8 else 1,
        )
        found.append((display, arm, "wall_stiffness" if number % 4 == 3 else "virtual_mass"))
    return found


@pytest.mark.slow
def test_boundaries_are_those_of_runs_in_time(drives):
    """5 % inside of the boundary by eigenvalues a disturbance decays, 5 % outside it grows: 20 displays."""
    for number, (display, arm, name) in enumerate(_cases(drives)):
        if name == "virtual_mass":
            limit, inside = iv.displays.least_stable_mass(display, arm), 1.05
        else:
            limit, inside = iv.displays.stiffest_wall(display, arm), 0.95
        assert 1e-2 < limit < 1e7, (number, name)
        for factor, grows in ((inside, False), (2.0 - inside, True)):
            changed = replace(display, **{name: factor * limit})
            size = ByHand(changed, arm).run(3000)
            growth = sampled_loop(changed, arm).growth
            rate = math.log(size[2000:].max() / size[1000:2000].max()) / 1000.0
            assert (rate > 0.0) == grows == (growth > 1.0), (number, name, factor, rate, growth)
            if grows:
                assert rate == pytest.approx(math.log(growth), rel=0.03, abs=2e-4), (number, name)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["measured", "virtual", "impedance"])
def test_a_run_in_time_is_that_of_an_adaptive_solver(drives, kind):
    """The plant under a held current by an implicit solver with error control, sample by sample."""
    if kind == "impedance":
        display = iv.displays.ImpedanceDisplay(drive=drives["motor2-gear4"], wall_stiffness=2000.0, wall_damping=3.0)
    else:
        display = iv.displays.AdmittanceDisplay(
            drive=drives["cobotic"], virtual_mass=1.0, wall_stiffness=2000.0, wall=kind, filter_frequency=80.0
        )
    hand = ByHand(display, ARM)
    hand.before, hand.place, waiting = 0.0, 0.0, 0.0
    state = np.zeros(hand.order)
    state[0] = 1e-3
    states = [state]
    for _ in range(40):
        current = hand.control(state)
        acting, waiting = waiting, current
        state = solve_ivp(
            lambda _, now, acting=acting: hand.rates(now, acting),
            (0.0, hand.period),
            state,
            "Radau",
            rtol=1e-8,
            atol=1e-11,
        ).y[:, -1]
        states.append(state)
    run = run_in_time(display, ARM, states[0], 40, within=8)
    scale = np.max(np.abs(states), axis=0)
    np.testing.assert_allclose(run.state[::8] / scale, np.array(states) / scale, atol=2e-4)
    # The exact discretisation gives the same states.
    loop = sampled_loop(display, ARM)
    whole = np.zeros(len(loop.matrix))
    whole[: hand.order] = states[0]
    for expected in states[1:]:
        whole = loop.matrix @ whole
        np.testing.assert_allclose(whole[: hand.order] / scale, expected / scale, atol=2e-6)


def _continuous(display, arm):
    """Largest real part of an admittance display whose controller never samples."""
    hand, n = ByHand(display, arm), 7
    pole, corner = 2.0 * math.pi * display.drive.control.steering_bandwidth, 2.0 * math.pi * display.filter_frequency

    def rates(state):
        force, acceleration = hand.sensor(state)
        push = (
            state[4] - display.wall_stiffness * state[0] - display.virtual_damping * state[6]
        ) / display.virtual_mass
        torque = hand.bell * (
            pole**2 * (-state[6] / hand.surface - state[2]) + 2.0 * pole * (-push / hand.surface - state[3])
        )
        filtered = corner**2 * (force - state[4]) - math.sqrt(2.0) * corner * state[5]
        return np.array([state[1], acceleration, state[3], torque / hand.bell, state[5], filtered, push])

    return float(np.max(np.linalg.eigvals(rates(np.eye(n))).real))


def test_fast_sampling_is_continuous_time(drives):
    """The least mass tends to that of continuous time, in proportion to the period."""
    arm, off = ARM, []
    base = iv.displays.AdmittanceDisplay(
        drive=drives["cobotic"], virtual_mass=1.0, wall_stiffness=1000.0, filter_frequency=60.0
    )
    limit = brentq(lambda mass: _continuous(replace(base, virtual_mass=mass), arm), 0.05, 1.0, xtol=1e-14, rtol=1e-12)
    for rate in (2e4, 4e4, 8e4):
        display = with_values(base, {"drive.control.sample_rate": rate})
        off.append(iv.displays.least_stable_mass(display, arm, (0.05, 10.0)) - limit)
    assert off[0] / off[1] == pytest.approx(2.0, rel=0.02)
    assert off[1] / off[2] == pytest.approx(2.0, rel=0.01)
    assert (2.0 * off[2] - off[1]) / limit == pytest.approx(0.0, abs=2e-4)


def test_wall_of_a_mass_without_friction(drives):
    """Jury's criterion: k < 2 d (1 - d)/(1 + d) with k = K T^2/(2 m), d = B T/(2 m), for a wall that is not late."""
    for share in (0.02, 0.2, 0.5, 0.9):
        display = iv.displays.ImpedanceDisplay(drive=drives["motor1-gear3"], handle_mass=0.3, samples_late=0)
        mass, period = display.reflected_mass + 0.3, 1e-3
        display = replace(display, wall_damping=share * 2.0 * mass / period)
        limit = 2.0 * share * (1.0 - share) / (1.0 + share) * 2.0 * mass / period**2
        assert iv.displays.stiffest_wall(display, "free") == pytest.approx(limit, rel=1e-5)


@pytest.mark.parametrize("late", [0, 1])
def test_wall_of_a_heavy_mass(drives, late):
    """A wall that lags by half a sample, and one more if it is late, is damped by b and B less K times the lag."""
    display = iv.displays.ImpedanceDisplay(
        drive=drives["motor1-gear3"], handle_mass=300.0, viscous_friction=4.0, samples_late=late
    )
    limit = iv.displays.stiffest_wall(display, "free")
    assert limit == pytest.approx(4.0 / ((0.5 + late) * 1e-3), rel=2e-3)


def test_colgate_and_schenkel():
    """The closed form against the general condition, and what it adds for one sample late."""
    draw = np.random.default_rng(5)
    for number in range(200):
        late = number % 2
        period = 10.0 ** draw.uniform(-4.0, -2.0)
        stiffness = 10.0 ** draw.uniform(0.0, 5.0)
        damping = draw.normal() * stiffness * period
        closed = required_damping(stiffness, damping, period, late)
        general, _ = general_required_damping(wall_transfer(stiffness, damping, period, late), period)
        assert general == pytest.approx(closed, rel=1e-6, abs=1e-7 * stiffness * period)
        assert general <= closed * (1.0 + 1e-9) + 1e-12
    assert required_damping(1000.0, 3.0, 1e-3) == pytest.approx(3.5)
    assert required_damping(1000.0, -3.0, 1e-3) == pytest.approx(3.5)
    assert required_damping(1000.0, 0.0, 1e-3, 1) == pytest.approx(1.5)


@pytest.mark.parametrize("late", [0, 1])
def test_a_passive_display_is_stable_with_every_passive_arm(drives, late):
    """At 1.001 of the damping needed; at 0.98 a heavy hand without damping finds the instability."""
    draw = np.random.default_rng(6)
    base = iv.displays.ImpedanceDisplay(drive=drives["motor2-gear4"], samples_late=late)
    for number in range(40):
        wall = {
            "wall_stiffness": 10.0 ** draw.uniform(1.0, 4.0),
            "wall_damping": 0.0 if number % 2 else draw.uniform(0, 3.0),
        }
        needed = required_damping(*wall.values(), base.period, late)
        passive = replace(base, **wall, viscous_friction=1.001 * needed)
        assert iv.displays.passivity(passive).passive
        arm = iv.motion.ArmModel(
            name="any", mass=10.0 ** draw.uniform(-3, 3), damping=0.0, stiffness=10.0 ** draw.uniform(-1.0, 6.0)
        )
        assert sampled_loop(passive, arm).stable
        assert sampled_loop(passive, "free").stable
        other = replace(passive, viscous_friction=0.98 * needed)
        assert not iv.displays.passivity(other).passive
        if wall["wall_damping"] == 0.0:
            heavy = iv.motion.ArmModel(
                name="heavy", mass=max(1.0, 1e-3 * wall["wall_stiffness"]), damping=0.0, stiffness=0.0
            )
            assert not sampled_loop(other, heavy).stable


@pytest.mark.slow
def test_a_sweep_in_time_measures_the_impedance(drives):
    """Response of the sampled loop by matrices against a run of 2 to 5 s, at the fundamental."""
    admittance = iv.displays.AdmittanceDisplay(
        drive=drives["cobotic"], virtual_mass=1.0, wall_stiffness=3000.0, filter_frequency=100.0
    )
    geared = iv.displays.ImpedanceDisplay(
        drive=drives["motor2-gear4"], wall_stiffness=3000.0, viscous_friction=3.0, wall_damping=5.0
    )
    for display in (admittance, replace(admittance, wall="virtual", samples_late=0, filter_frequency=None), geared):
        for frequency in (8.0, 150.0):
            swept = iv.displays.swept_impedance(display, ARM, frequency)
            known = impedance(display, [frequency], ARM)[0]
            assert abs(swept - known) < 1e-4 * abs(known)
            # Aliases of the arm's reaction matter little.
            assert abs(impedance(display, [frequency])[0] - known) < 2e-2 * abs(known)


def test_the_least_mass_is_not_monotone_in_the_bandwidth_of_the_servo(drives):
    """With a slow filter of the force sensor, the mass is largest where servo and filter are about as fast."""
    display = iv.displays.AdmittanceDisplay(drive=drives["cobotic"], virtual_mass=1.0, filter_frequency=30.0)

    def least(bandwidth):
        return iv.displays.least_stable_mass(with_values(display, {"drive.control.steering_bandwidth": bandwidth}), ARM)

    slow, middle, fast = least(5.0), least(20.0), least(60.0)
    assert middle > 1.5 * slow
    assert middle > 1.5 * fast


def test_spin_of_the_contact_takes_energy(drives):
    """Linear theory with spin: the patch never gives energy, and steering makes a locked link creep."""
    from internals import DisplayContact

    drive = drives["cobotic"]
    element = replace(drive.transmission, creep_law=None)
    turning = replace(drive, transmission=element)
    assert element.turns_with_spin
    contact = DisplayContact.of(turning)
    draw = np.random.default_rng(3)
    speed, angle, rate = draw.normal(size=(3, 500)) * np.array([[1e-3], [1e-3], [1.0]])
    creep = speed + contact.surface * angle
    lateral = contact.viscous * (creep - contact.coupling * rate)
    assert np.all(lateral * creep + contact.moment(speed, angle, rate) * rate >= 0.0)
    # The same as the exact law for small creepages.
    from internals import spin_law

    groups = element.groups(turning.cylinder_speed)
    patch = spin_law.TurningPatch.of(element, groups)
    exact, moment = spin_law.law(1e-9 * creep, 1e-9 * rate, -contact.surface + 0.0 * rate, **patch._asdict())
    np.testing.assert_allclose(exact / 1e-9, lateral, rtol=1e-4, atol=1e-4 * np.max(np.abs(lateral)))
    np.testing.assert_allclose(
        moment / 1e-9, contact.moment(speed, angle, rate), rtol=1e-4, atol=1e-4 * np.max(np.abs(moment)) / 1e-9
    )
    with_spin, without = (
        iv.displays.AdmittanceDisplay(drive=one, virtual_mass=1.0, filter_frequency=100.0) for one in (turning, drive)
    )
    assert iv.displays.least_stable_mass(with_spin, ARM) == pytest.approx(
        iv.displays.least_stable_mass(without, ARM), rel=0.15
    )


def test_the_contact_is_that_of_the_transmission(drives):
    """Small link speeds and angles: the force of the linear contact against `operate`, with either sense of rotation."""
    from internals import DisplayContact

    draw = np.random.default_rng(9)
    for name in ("cobotic", "cobotic-b"):
        contact, drive = DisplayContact.of(drives[name]), drives[name]
        speed, angle = 1e-6 * draw.normal(size=(2, 50))
        for way in (1.0, -1.0):
            found = drive.transmission.operate(
                cylinder_speed=way * drive.cylinder_speed, steering_angle=way * angle, link_speed=speed
            )
            np.testing.assert_allclose(found.link_force, contact.link_force(speed, angle, 0.0), rtol=1e-6, atol=1e-9)

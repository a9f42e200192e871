"""A session on a cobotic and on a conventional display: closed forms, the session in time, properties, and malformed input."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import infinivar as iv
from internals import CONVENTIONAL_ROUND as CONVENTIONAL
from internals import DISPLAY_ROUNDS as DISPLAYS
from internals import RESTING, STOPPED, TURNING, cobotic_part, display_choices, geared_part, run_up_energy
from internals import SESSION_PARTS as PARTS
from internals import displays_figure as bars
from internals import shared_motor_figure as map_figure
from made import loaded
from sampled import sampled

DRIVES = loaded("hand_controller").drives
LEG, LEG_B, GEARED = (DRIVES[name] for name in ("cobotic", "cobotic-b", "motor2-gear4"))
PAIR = iv.displays.DisplayPair(cobotic=LEG, conventional=GEARED)
ONLY_HOLDING = {"free": 0.0, "contact": 0.0, "hold": 1.0, "explore": 0.0}
SESSION = iv.displays.HandleSession()


@pytest.fixture(scope="module")
def found():
    variants = {
        "B": replace(PAIR, cobotic=LEG_B),
        "friction of the conventional display compensated": replace(PAIR, compensation=1.0),
        "B, preload / 1.5": replace(PAIR, cobotic=LEG_B.pressed(550.0 / 1.5)),
    }
    return iv.displays.compare_displays(PAIR, axes=(1, 2, 4, 6), variants=variants)


@pytest.mark.parametrize("count", [1, 6])
@pytest.mark.parametrize("force", [10.0, 50.0])
def test_a_motor_holds_by_its_winding_alone(count, force):
    r"""R (F r/(k N))^2 for each axis; friction that helps takes its force off."""
    held = replace(SESSION, **ONLY_HOLDING, hold_force=force)
    per_current = GEARED.motor.torque_constant * 4.0 / 0.005
    power = geared_part(GEARED, held, "hold", axes=count, handle_mass=0.5)
    assert_allclose(power.supply, count * GEARED.motor.resistance * (force / per_current) ** 2, rtol=1e-12)
    assert_allclose(power.heating, (force / per_current / GEARED.motor.continuous_current) ** 2, rtol=1e-12)
    helped = geared_part(GEARED, held, "hold", axes=count, handle_mass=0.5, friction_helps=True)
    rubbing = sum(PAIR.motors.frictions)
    assert_allclose(helped.supply, count * GEARED.motor.resistance * ((force - rubbing) / per_current) ** 2, rtol=1e-12)


def test_the_mean_of_pushes_against_a_wall():
    """The square of (1 - cos)/2 has the mean 3/8."""
    contact = geared_part(GEARED, SESSION, "contact", axes=2, handle_mass=0.5)
    held = geared_part(GEARED, replace(SESSION, hold_force=30.0), "hold", axes=2, handle_mass=0.5)
    assert_allclose(contact.supply, 0.375 * held.supply, rtol=1e-9)


@pytest.mark.parametrize(("leg", "each", "common"), [(LEG, 0.2, 3.68), (LEG_B, 0.2, 1.12)])
def test_the_cylinder_idles_at_its_losses(leg, each, common):
    """By the machine of many legs, and near the closed sums of common part and legs."""
    for count in (1, 6):
        idle = cobotic_part(leg, SESSION, "idle", axes=count, handle_mass=0.5)
        machine = iv.machines.LeggedDrive.of(leg, count)
        still = np.zeros(count)
        point = machine.operate(iv.transmission.Configuration(jacobian=np.eye(count)), wrench=still, twist=still)
        assert_allclose(idle.supply, point.power_in, rtol=1e-9)
        assert_allclose(idle.supply, common + each * count, rtol=0.03)
        assert idle.steering == 0.0


@pytest.mark.parametrize("leg", [LEG, LEG_B])
def test_holding_agrees_with_the_comparison_of_shared_motors(leg):
    shared = iv.analysis.share_motor(leg, GEARED, force=[20.0, 50.0], legs=(1, 6))
    for row, count in enumerate((1, 6)):
        for column, force in enumerate((20.0, 50.0)):
            held = replace(SESSION, hold_force=force)
            mine = cobotic_part(leg, held, "hold", axes=count, handle_mass=0.5).supply
            # That comparison lets friction of the link's guideway help.
            assert_allclose(mine, shared.turning[0, row, column], rtol=5e-3)
            other = geared_part(GEARED, held, "hold", axes=count, handle_mass=0.5).supply
            assert_allclose(other, shared.separate[0, row, column], rtol=1e-9)


@pytest.mark.slow
@sampled(("leg", "tolerance"), [(LEG, 0.002), (LEG_B, 0.03)], every=2)
def test_free_motion_in_time(leg, tolerance):
    """A period with sampled servos. Of B most is steering, whose friction a servo feeds forward smoothly near rest."""
    quick = replace(SESSION, free_frequency=2.0, free_speed=0.1)
    pulse = 4.0 * math.pi
    run = iv.session(
        iv.machines.SlideMachine(leg=leg, masses=[0.5]),
        iv.motion.Caster(mass=2.0),
        user=lambda at: [2.0 * 0.1 * pulse * math.cos(pulse * at)],
        duration=0.5,
    )
    power = cobotic_part(leg, quick, "free", axes=1, handle_mass=0.5)
    assert_allclose(run.electrical_energy, 0.5 * power.supply, rtol=tolerance)
    assert_allclose(run.supplied["steering supply"][-1], 0.5 * power.steering, rtol=0.06)


def test_holding_in_time():
    """Wheels at the angle that locks them creep a little, so the cylinder has slightly less to do."""
    run = iv.session(
        iv.machines.SlideMachine(leg=LEG, masses=[0.5]),
        iv.motion.HoldingTask(stop_cylinder=False),
        user=[-40.0],
        duration=0.2,
    )
    power = cobotic_part(LEG, SESSION, "hold", axes=1, handle_mass=0.5)
    assert_allclose(run.electrical_energy, 0.2 * power.supply, rtol=0.02)
    stopped = iv.session(
        iv.machines.SlideMachine(leg=LEG, masses=[0.5]),
        iv.motion.HoldingTask(stop_cylinder=True),
        user=[-40.0],
        duration=0.05,
    )
    assert stopped.electrical_energy == 0.0


@pytest.mark.slow
def test_free_motion_of_a_geared_drive_in_time():
    """The user moves its mass and overcomes its friction."""
    power = geared_part(GEARED, SESSION, "free", axes=1, handle_mass=0.5)
    rubbing, pulse = sum(PAIR.motors.frictions), 2.0 * math.pi
    assert_allclose(power.user, rubbing * 0.2 * 2.0 / math.pi, rtol=1e-4)
    mass = PAIR.motors.moved_mass + 0.5

    def push(at):
        return [mass * 0.2 * pulse * math.cos(pulse * at) + rubbing * np.sign(math.sin(pulse * at))]

    run = iv.session(
        iv.machines.GearedSlideMachine(drive=GEARED, masses=[0.5]), iv.motion.Caster(), user=push, duration=0.5
    )
    assert_allclose(run.supplied["user"][-1], 0.5 * power.user, rtol=0.01)
    assert power.supply == run.electrical_energy == 0.0


@pytest.mark.slow
@sampled("leg", [LEG, LEG_B], every=2)
def test_exploring_in_time(leg):
    """Wheels that are steered for the speed alone creep under the force, which takes a little off what the cylinder does."""
    quick, pulse = replace(SESSION, explore_frequency=2.0), 4.0 * math.pi
    surface = leg.transmission.cylinder_radius * leg.cylinder_speed

    def law(measured):
        at = pulse * (measured.time + 1e-3)  # acts a sample late
        slope, rise = 0.1 * math.sin(at) / surface, 0.1 * pulse * math.cos(at) / surface
        return iv.machines.Commands(
            steering=np.array([-math.atan(slope)]),
            steering_rate=np.array([-rise / (1.0 + slope**2)]),
            speed=leg.cylinder_speed,
        )

    machine = iv.machines.SlideMachine(leg=leg, masses=[0.5])
    run = iv.session(machine, controller=law, user=[-15.0], duration=0.5)
    power = cobotic_part(leg, quick, "explore", axes=1, handle_mass=0.5)
    assert_allclose(run.electrical_energy, 0.5 * power.supply, rtol=0.03)
    assert_allclose(run.supplied["steering supply"][-1], 0.5 * power.steering, rtol=0.04)


@pytest.mark.slow
def test_exploring_with_a_geared_drive_in_time():
    quick, pulse = replace(SESSION, explore_frequency=2.0), 4.0 * math.pi
    mass, rubbing = PAIR.motors.moved_mass + 0.5, sum(PAIR.motors.frictions)

    def push(at):
        return [mass * 0.1 * pulse * math.cos(pulse * at) + math.copysign(rubbing, math.sin(pulse * at)) - 15.0]

    run = iv.session(
        iv.machines.GearedSlideMachine(drive=GEARED, masses=[0.5]),
        controller=lambda measured: iv.machines.Commands(currents=np.array([15.0 / PAIR.motors.gain])),
        user=push,
        duration=0.5,
    )
    power = geared_part(GEARED, quick, "explore", axes=1, handle_mass=0.5)
    assert_allclose(run.electrical_energy, 0.5 * power.supply, rtol=2e-3)
    assert_allclose(run.supplied["user"][-1], 0.5 * power.user, rtol=2e-3)


@pytest.mark.slow
def test_pushing_against_a_wall_in_time():
    """A servo that follows the slip angle is between wheels that rest and wheels that turn without pause."""

    class Wall:
        dimension = 1

        def distance(self, point):
            return np.asarray(point)[..., 0]

        def normal(self, point):
            return np.ones(np.shape(point))

    pulse = 2.0 * math.pi
    for leg in (LEG, LEG_B):
        run = iv.session(
            iv.machines.SlideMachine(leg=leg, masses=[0.5]),
            controller=iv.machines.AdmittanceGuide(mass=2.0, wall=Wall()),
            user=lambda at: [-15.0 * (1.0 - math.cos(pulse * at))],
            duration=1.0,
        )
        rest, moves = (
            cobotic_part(leg, SESSION, "contact", axes=1, handle_mass=0.5, slip_feedforward=follows)
            for follows in (False, True)
        )
        assert 0.99 * rest.supply < run.electrical_energy < moves.supply
        assert rest.steering == 0.0
        assert 0.05 < run.supplied["steering supply"][-1] / moves.steering < 0.2


@pytest.mark.slow
def test_energies_by_part(found):
    assert found.parts == (*PARTS, "run-up")
    assert found.energy.shape == (4, 4, 4, 6)
    turning, geared = found.energy[0, 0], found.energy[0, 3]
    assert_allclose(geared, np.array([1, 2, 4, 6])[:, None] * geared[0], rtol=1e-12)
    assert np.all(np.diff(turning[:, :5], axis=0) > 0.0)
    assert np.all(turning[:, 5] == 0.0)
    for row, parts in ((1, ["idle"]), (2, ["idle", "hold"])):
        for part in PARTS:
            place = PARTS.index(part)
            expected = 0.0 if part in parts else turning[:, place]
            assert_allclose(found.energy[0, row, :, place], expected)
        runs = [len(parts) * run_up_energy(iv.machines.LeggedDrive.of(LEG, int(count)), 1.5) for count in found.axes]
        assert_allclose(found.energy[0, row, :, 5], runs)
    idle = [cobotic_part(LEG, SESSION, "idle", axes=int(count), handle_mass=0.5).supply for count in found.axes]
    assert_allclose(
        found.stop[0],
        [
            run_up_energy(iv.machines.LeggedDrive.of(LEG, int(n)), 1.5) / p
            for n, p in zip(found.axes, idle, strict=True)
        ],
    )
    assert_allclose(found.user[0, :3], 0.0, atol=1e-9)
    assert np.all(found.user[0, 3] > 0.0)


@pytest.mark.parametrize("leg", [LEG, LEG_B])
def test_heat_of_the_hottest_motor(leg):
    """Of means over the round, of either motor: the steering motors of B, the power motor of a display at rest."""
    session = replace(SESSION, explore_force=20.0)
    found = iv.displays.compare_displays(replace(PAIR, cobotic=leg), session, axes=(3,))
    each = {part: cobotic_part(leg, session, part, axes=3, handle_mass=0.5) for part in PARTS}
    for values, kinds in ((found.winding[0, 0, 0], ("winding", "steering_winding")),
                          (found.heating[0, 0, 0] ** 2, ("heating", "steering_heating"))):  # fmt: skip
        means = [sum(session.shares[part] * getattr(each[part], kind) for part in PARTS) for kind in kinds]
        assert_allclose(values, max(means))
    friction = leg.steering.coulomb_torque(leg.transmission) / leg.steering.ratio
    motor = leg.steering.motor
    current = friction / motor.torque_constant + motor.no_load_current
    # Against friction alone; the inertia of motor and bell adds little.
    assert_allclose(each["explore"].steering_winding, motor.resistance * current**2, rtol=1e-3)


def test_measures(found):
    assert_allclose(found.largest_force[0], [78.0, PAIR.motors.gain * GEARED.motor.continuous_current])
    assert_allclose(found.least_force[:, 1], [9.13, 9.13, 0.0, 9.13], atol=0.01)
    free = PAIR.admittance(1.0).softest()
    least = iv.displays.least_stable_mass(free, iv.motion.ArmModel.named("vanbeek2015"))
    assert_allclose(found.least_mass[0], [1.1 * least + 0.5, PAIR.impedance().reflected_mass + 0.5])
    assert_allclose(found.margin[0, 0], 1.5 / least)
    arm = iv.motion.ArmModel.named("vanbeek2015")
    stiffest = [iv.displays.stiffest_wall(display, arm) for display in (PAIR.admittance(1.1 * least), PAIR.impedance())]
    assert_allclose(1.1 * found.stiffness[0], stiffest, rtol=1e-9)
    # With equal damping the ratio is two to four.
    assert_allclose(found.stiffness[0], [126.8e3, 64.1e3], rtol=2e-3)
    # A variant that cannot hold what is required does not count.
    assert not np.any(found.feasible[3, :3])
    assert np.all(found.feasible[3, 3])
    assert np.all(found.feasible[:3])


def test_verdicts(found):
    assert found.cheaper(TURNING)[0] == "conventional"
    assert found.cheaper(TURNING)[-1] == "undecidable"
    assert found.flips(TURNING, 6) == ("friction of the conventional display compensated",)
    assert found.flips(TURNING, 1) == ()
    assert found.verdict.startswith("Less energy in a round of 20 s: cylinder turning: conventional at 1 2")
    assert len(found.lines) == 9
    assert found.lines[-1].startswith("work of the user, 6 axes: cobotic 0 J (0 to 0), conventional 48.9 J")
    assert found.lines[0].startswith("1 axis: cylinder turning 80.3 J (")
    written = json.loads(json.dumps(found.to_dict(), allow_nan=False))
    assert written["energy_J"][0][0][0][0] == pytest.approx(found.energy[0, 0, 0, 0])
    assert written["largest_mass_kg"][0][0] is None
    heavy = iv.displays.compare_displays(PAIR, replace(SESSION, required_force=90.0), axes=(1,))
    assert heavy.cheaper(STOPPED) == ("neither",)
    firm = iv.displays.compare_displays(PAIR, replace(SESSION, required_force=65.0), axes=(1,))
    assert firm.cheaper(STOPPED) == ("cobotic alone",)
    assert "beyond a limit" in heavy.lines[0]
    light = iv.displays.compare_displays(PAIR, replace(SESSION, felt_mass=1.0), axes=(1,))
    assert light.margin[0, 0] < 1.0
    assert light.cheaper(RESTING) == ("conventional alone",)


@pytest.mark.slow
def test_where_each_side_wins():
    """Holding a large force with many axes against small forces, few axes and long idling."""
    hold = iv.displays.compare_displays(PAIR, replace(SESSION, **ONLY_HOLDING, hold_force=50.0), axes=(1, 6))
    assert hold.cheaper(TURNING) == ("cobotic", "cobotic")
    assert_allclose(hold.total[0, [0, 3], 1] / 20.0, [5.24, 28.35], rtol=5e-3)
    # A session that is nothing but holding at rest never runs up.
    assert hold.total[0, 2, 1] == 0.0
    weak = iv.displays.compare_displays(PAIR, replace(SESSION, **ONLY_HOLDING, hold_force=5.0), axes=(1, 6))
    assert weak.cheaper(TURNING) == ("conventional", "conventional")
    idle = iv.displays.compare_displays(
        PAIR, iv.displays.HandleSession(free=0.0, contact=0.0, hold=0.0, explore=0.0), axes=(6,)
    )
    assert_allclose(idle.total[0] / 20.0, [[4.91], [0.0], [0.0], [0.0]], atol=5e-3)


def test_assumed_variants():
    every = iv.displays.assumed_variants(PAIR, {"B": LEG_B})
    assert every["B"].cobotic is LEG_B
    assert every["preload x 1.5"].cobotic.transmission.preload == pytest.approx(975.0)
    rubbing = every["B, steering friction / 1.5"].cobotic
    friction, usual = (one.steering.friction_torques(one.transmission) for one in (rubbing, LEG_B))
    for name in usual:
        assert_allclose(friction[name], usual[name] / 1.5)
    assert every["drag of the conventional display x 1.5"].conventional.guideway.friction == pytest.approx(6.75)
    assert every["guideway friction x 1.5"].cobotic.guideway.coefficient == pytest.approx(0.0015)
    assert every["returned power stored"].conventional.amplifier.storage_efficiency == 1.0
    assert "as shown" not in every


def test_break_even_over_force_axes_and_duty():
    force, duty = np.linspace(0.0, 55.0, 12), [0.1, 0.5, 1.0]
    found = iv.displays.display_break_even(PAIR, force=force, axes=(1, 6), duty=duty)
    plain = iv.analysis.share_motor(LEG, GEARED, force=force, legs=(1, 6), duty=duty, period=20.0)
    assert_allclose(found.turning[2], plain.turning[2])
    free, idle = (
        [cobotic_part(LEG, SESSION, part, axes=count, handle_mass=0.5).supply for count in (1, 6)]
        for part in ("free", "idle")
    )
    share = 0.25 / 0.45
    for row in range(2):
        rest = share * free[row] + (1.0 - share) * idle[row]
        assert_allclose(found.turning[0, row], 0.1 * plain.turning[2, row] + 0.9 * rest, rtol=1e-9)
    assert_allclose(found.separate, plain.separate)  # without friction compensation free motion costs nothing
    idle_only = iv.displays.display_break_even(PAIR, replace(SESSION, free=0.0), force=force, axes=(1, 6), duty=duty)
    assert idle_only.equals(plain, rtol=1e-9)
    least = found.least_force()
    assert np.all(least[1:] <= least[:-1])
    assert np.all(least[:, 1] <= least[:, 0])
    areas = map_figure.regions(found)
    assert areas.shape == (2, 12, 3)
    assert np.all(areas[:, 0] == 0)  # no force: separate motors draw nothing
    assert areas[1, -2, -1] == 2
    assert len(map_figure.draw_map(found, ["A"]).axes) == 2


def test_bars(found):
    numbers = bars.data(found)
    assert_allclose(numbers["energy"].sum(axis=-1), found.total[0])
    assert np.all(numbers["low"] <= found.total[0])
    assert np.all(numbers["high"] >= found.total[0])
    assert len(found.plot().axes) == len(DISPLAYS)


def test_table(found):
    pytest.importorskip("pandas")
    table = found.to_dataframe()
    assert len(table) == 16
    assert table.loc[(6, CONVENTIONAL), "energy_J"] == pytest.approx(found.total[0, 3, 3])
    one = table.loc[(1, TURNING)]
    assert one["least_energy_J"] <= one["energy_J"] <= one["largest_energy_J"]


BAD = {
    "free must be at most 1 together with contact, hold and explore, got 0.6": lambda: iv.displays.HandleSession(
        free=0.6
    ),
    "free_speed must be > 0 m/s, got 0": lambda: iv.displays.HandleSession(free_speed=0.0),
    "hold_force must be >= 0 N, got -1": lambda: iv.displays.HandleSession(hold_force=-1.0),
    "hold_force must be": lambda: iv.displays.HandleSession(hold_force=math.nan),
    "round_time must be a real number": lambda: iv.displays.HandleSession(round_time=[1.0]),
    "cobotic must be a CoboticDrive": lambda: iv.displays.DisplayPair(cobotic=GEARED, conventional=GEARED),
    "conventional must be a ConventionalDrive": lambda: iv.displays.DisplayPair(cobotic=LEG, conventional=LEG),
    "cobotic.cylinder_inertia is missing": lambda: replace(PAIR, cobotic=replace(LEG, cylinder_inertia=None)),
    "cobotic.steering is missing": lambda: replace(PAIR, cobotic=replace(LEG, steering=None)),
    "handle_mass must be > 0 kg, got 0": lambda: replace(PAIR, handle_mass=0.0),
    "compensation must be": lambda: replace(PAIR, compensation=1.5),
    "friction_helps must be true or false": lambda: replace(PAIR, friction_helps=1),
    "pair must be a DisplayPair": lambda: iv.displays.compare_displays(LEG),
    "session must be a HandleSession": lambda: iv.displays.compare_displays(PAIR, 20.0),
    "arm must be an ArmModel, got": lambda: iv.displays.compare_displays(PAIR, arm="me"),
    "arm must be an ArmModel, got 3": lambda: iv.displays.compare_displays(PAIR, arm=3),
    "axes must be whole numbers from 1 on that rise": lambda: iv.displays.compare_displays(PAIR, axes=(2, 1)),
    "axes must be whole numbers from 1 on": lambda: iv.displays.compare_displays(PAIR, axes=(0, 1)),
    "variants must map texts to DisplayPair": lambda: iv.displays.compare_displays(PAIR, variants=[PAIR]),
    "variants.B must be a DisplayPair": lambda: iv.displays.compare_displays(PAIR, variants={"B": LEG_B}),
    "factor must be > 1": lambda: iv.displays.assumed_variants(PAIR, factor=1.0),
    "reconstructions.B must be a CoboticDrive": lambda: iv.displays.assumed_variants(PAIR, {"B": GEARED}),
    "duty must be between 0 and 1": lambda: iv.displays.display_break_even(PAIR, force=[1.0], duty=2.0),
    "legs must be whole numbers": lambda: iv.displays.display_break_even(PAIR, force=[1.0], axes=(0,), duty=1.0),
    "free_power must be given with a free_share": lambda: iv.analysis.share_motor(
        LEG, GEARED, force=[1.0], free_share=0.5
    ),
    "free_power must be 2 finite values": lambda: iv.analysis.share_motor(
        LEG, GEARED, force=[1.0], legs=(1, 2), free_share=0.5, free_power=([1.0], 0.0)
    ),
    "display must be one of cylinder turning": lambda: iv.displays.compare_displays(PAIR, axes=(1,)).cheaper(
        CONVENTIONAL
    ),
    "axes must be one of 1, got 2": lambda: iv.displays.compare_displays(PAIR, axes=(1,)).flips(TURNING, 2),
}


@pytest.mark.parametrize("message", BAD)
def test_bad_input(message):
    with pytest.raises(iv.InputError) as caught:
        BAD[message]()
    assert str(caught.value).startswith(message)
    assert "\n" not in str(caught.value)


CHOICES = display_choices(PAIR)


@pytest.fixture(scope="module")
def chosen():
    return iv.displays.compare_displays(PAIR, SESSION, axes=(1, 6), variants=CHOICES)


@pytest.mark.slow
def test_what_the_verdict_hangs_on(chosen):
    turning, stopped = chosen.hangs_on(TURNING, 6), chosen.hangs_on(STOPPED, 6)
    assert {row.choice for row in turning.flips} == {"gear friction", "cylinder speed"}
    assert {row.choice for row in stopped.flips} == {"steering model", "gear friction", "cylinder speed"}
    assert stopped.verdict.startswith("Undecidable: cobotic, stopped while idle wins with steering model: spin, ")
    assert chosen.hangs_on(TURNING, 1).decided
    rows = {(row.choice, row.instead): row for row in stopped.rows}
    # The same with the drive as another study would state it.
    spin = replace(PAIR.cobotic, transmission=replace(PAIR.cobotic.transmission, steering_model="spin"))
    alone = iv.displays.compare_displays(replace(PAIR, cobotic=spin), SESSION, axes=(6,))
    row = rows["steering model", "spin"]
    assert row.figures["cobotic"] == pytest.approx(alone.total[0, 1, 0], rel=1e-12)
    assert row.figures["cobotic"] < row.figures["conventional"] < stopped.used.figures["cobotic"]


@pytest.mark.slow
def test_standby_adds_a_watt_for_each_amplifier(chosen):
    place = chosen.assuming.index("standby per amplifier: 1 W each")
    more = chosen.total[place] - chosen.total[0]
    assert_allclose(more[:3], np.array([[2, 7]] * 3) * SESSION.round_time, rtol=1e-12)
    assert_allclose(more[3], np.array([1, 6]) * SESSION.round_time, rtol=1e-12)


@pytest.mark.slow
def test_a_cylinder_at_its_least_loss_in_each_part(chosen):
    place = chosen.assuming.index("cylinder speed: least loss in each part")
    # Of the whole round, one constant speed cannot be better but for the run-ups.
    for speed in (3.0, 5.0, 8.0, 14.0):
        slow = replace(PAIR, cobotic=replace(PAIR.cobotic, cylinder_speed=speed))
        constant = iv.displays.compare_displays(slow, SESSION, axes=(1, 6))
        run_ups = chosen.energy[place, 0, :, -1]
        enough = constant.feasible[0, 0]
        assert np.all((chosen.total[place, 0] - run_ups <= 1.02 * constant.total[0, 0]) | ~enough)
    assert chosen.total[place, 0, 0] < 0.3 * chosen.total[0, 0, 0]


@pytest.mark.slow
def test_damping_of_the_walls(chosen):
    stiff = {name: chosen.stiffness[place] for place, name in enumerate(chosen.assuming)}
    shown, damped, bare = (
        stiff[name] for name in ("as shown", *(f"damping of the walls: {b} N s/m" for b in (400, 0)))
    )
    assert 1.9 < shown[0] / shown[1] < 2.1
    assert bare[0] > 10.0 * bare[1]
    assert damped[0] < damped[1]
    # A soft structure makes all walls alike, and the cobotic display unable to move lightly.
    soft = stiff["structure of every display: 100 N/mm"]
    assert_allclose(soft[0] / soft[1], 1.1, rtol=0.02)
    place = chosen.assuming.index("structure of every display: 100 N/mm")
    assert chosen.limit[place, 0, 0] == "stability in free motion"
    assert chosen.least_mass[place, 0] > 4.0 * chosen.least_mass[place, 1]
    # Damping of a wall does not act in free motion.
    place = chosen.assuming.index("damping of the walls: 400 N s/m")
    assert_allclose(chosen.least_mass[place], chosen.least_mass[0], rtol=1e-12)


def test_force_and_speed_at_once_of_all_axes():
    both = iv.displays.compare_displays(PAIR, replace(SESSION, required_speed_at_force=0.1), axes=(1, 6))
    assert both.feasible[0, :, 0].all()
    assert both.feasible[0, :, 1].tolist() == [False, False, False, True]
    assert both.cheaper(TURNING) == ("conventional", "conventional alone")


def test_another_word_for_the_cylinder_is_refused():
    with pytest.raises(iv.ParameterError, match="cylinder"):
        replace(PAIR, cylinder="slow")


RIVALS = iv.displays.usual_rivals(GEARED)
WIDE = replace(PAIR, rivals=RIVALS)


@pytest.fixture(scope="module")
def many():
    return iv.displays.compare_displays(WIDE, axes=(1, 6))


def test_rivals_have_the_same_handle_sensor_damping_and_delay(many):
    assert many.names == ("cobotic", CONVENTIONAL, "direct drive", "cable drive", "with a force sensor")
    assert many.displays == (*DISPLAYS, *RIVALS)
    assert many.energy.shape[:2] == (1, 7)
    assert many.stiffness.shape == (1, 5)
    each = [PAIR.admittance(1.0), *(WIDE.rival(name, 1.0) for name in WIDE.conventionals)]
    for name in ("handle_mass", "wall_damping", "samples_late", "period"):
        assert len({getattr(one, name) for one in each}) == 1
    assert {one.filter_frequency for one in each if isinstance(one, iv.displays.AdmittanceDisplay)} == {100.0}
    assert WIDE.differences == (
        "structure of cable drive: 3500 N/m",
        "structure not stated, rigid: cobotic, conventional, direct drive, with a force sensor",
        "force sensor: cobotic, with a force sensor",
    )
    # What is there without rivals is the same with them.
    alone = iv.displays.compare_displays(PAIR, axes=(1, 6))
    assert_allclose(many.total[:, :4], alone.total, rtol=1e-12)
    assert_allclose(many.stiffness[:, :2], alone.stiffness, rtol=1e-12)


def test_rivals_push_as_hard_and_feel_otherwise(many):
    force, friction, mass = many.largest_force[0], many.least_force[0], many.least_mass[0]
    assert_allclose(force[1:], force[1], rtol=1e-9)
    # Four motors without gear have a quarter of the inertia of one through a gear of 4:1, which adds nothing else.
    motor = GEARED.motor.rotor_inertia * 4.0 + GEARED.output_inertia
    assert_allclose(mass[2], motor / GEARED.pulley.radius**2 + 0.5, rtol=1e-9)
    # The cable takes away gear loss and drag; friction of the motor remains.
    brush = GEARED.motor.friction_torque * 4.0 / GEARED.pulley.radius
    assert_allclose(friction[3], brush + 0.1, rtol=1e-9)
    assert friction[4] == friction[0] == 0.0
    arm = iv.motion.ArmModel.named("vanbeek2015")
    least = iv.displays.least_stable_mass(WIDE.rival("with a force sensor", 1.0).softest(), arm)
    assert_allclose(mass[4], 1.1 * least + 0.5, rtol=1e-9)
    cable = WIDE.rival("cable drive", 1.0)
    assert_allclose(many.stiffness[0, 3], cable.at_handle(iv.displays.stiffest_wall(cable, arm) / 1.1), rtol=1e-9)
    assert many.stiffness[0, 3] < 3500.0


def test_force_control_takes_the_work_from_the_user(many):
    """Its motor supplies friction and inertia of the drive, less the mass that the user is to feel."""
    held = {
        name: geared_part(GEARED, SESSION, "hold", axes=1, handle_mass=0.5, force_control=name)
        for name in (True, False)
    }
    assert held[True].supply == held[False].supply
    free = geared_part(GEARED, SESSION, "free", axes=2, handle_mass=0.5, force_control=True)
    assert_allclose(free.user, 0.0, atol=1e-9)
    motors = PAIR.motors
    pulse, angle = 2.0 * math.pi, 2.0 * math.pi * (np.arange(20000) + 0.5) / 20000
    speed, rise = 0.2 * np.sin(angle), 0.2 * pulse * np.cos(angle)
    force = (motors.moved_mass + 0.5 - 2.0) * rise + sum(motors.frictions) * np.sign(speed)
    current = force / motors.gain
    power = GEARED.motor.resistance * current**2 + force * speed
    assert_allclose(free.supply, 2.0 * np.mean(np.maximum(power, 0.0)), rtol=2e-3)
    assert_allclose(many.user[0, -1], 0.0, atol=1e-9)


def test_requirements_on_what_is_felt_name_their_limit():
    strict = replace(SESSION, largest_friction=1.0, largest_mass=2.0)
    found = iv.displays.compare_displays(WIDE, strict, axes=(1,))
    said = dict(zip(found.displays, found.limit[0, :, 0], strict=True))
    assert said[TURNING] == said["with a force sensor"] == ""
    assert said[CONVENTIONAL] == said["direct drive"] == "friction felt"
    assert said["cable drive"] == "friction felt"
    assert found.cheaper(TURNING) == ("cobotic alone",)
    heavy = iv.displays.compare_displays(WIDE, replace(SESSION, largest_mass=2.0), axes=(1,))
    assert heavy.limit[0, 3, 0] == "mass felt"
    assert found.to_dict()["limit"][0][3] == ["friction felt"]
    far = iv.displays.compare_displays(PAIR, replace(SESSION, required_force=65.0), axes=(1,))
    assert far.limit[0, :, 0].tolist() == ["", "", "", "largest force of an axis"]


def test_the_worst_of_several_grips_counts():
    """A user may grip as he likes: the largest least mass, and the softest wall at that mass."""
    arm = iv.motion.ArmModel.named("vanbeek2015")
    grips = [arm, replace(arm, name="firm", damping=10.0, stiffness=800.0), replace(arm, name="loose", mass=0.2)]
    found = iv.displays.compare_displays(WIDE, axes=(1,), arm=grips)
    each = [iv.displays.compare_displays(WIDE, axes=(1,), arm=grip) for grip in grips]
    assert_allclose(found.least_mass[0], np.max([one.least_mass[0] for one in each], axis=0))
    assert_allclose(found.margin[0], np.min([one.margin[0] for one in each], axis=0))
    # Without virtual mass the walls are those of each grip.
    assert_allclose(found.stiffness[0, 1:4], np.min([one.stiffness[0, 1:4] for one in each], axis=0))
    assert found.arm == "one subject of vanbeek2015, firm or loose"


def test_a_variant_has_the_rivals_of_the_pair():
    with pytest.raises(iv.InputError, match=r"variants.B.rivals must be those of the pair, got none"):
        iv.displays.compare_displays(WIDE, axes=(1,), variants={"B": PAIR})
    with pytest.raises(iv.InputError, match=r"rivals.x must be a Rival"):
        replace(PAIR, rivals={"x": GEARED})
    with pytest.raises(iv.InputError, match="rival must be one of conventional, direct drive"):
        iv.displays.compare_displays(WIDE, axes=(1,)).cheaper(TURNING, "hand")
    with pytest.raises(iv.InputError, match="force_control must be true or false"):
        iv.displays.Rival(drive=GEARED, force_control=1)
    every = iv.displays.assumed_variants(WIDE)
    assert all(tuple(one.rivals) == tuple(RIVALS) for one in every.values())

"""Strain-wave gears in a drive: their law by hand, limits, a joint by two ways and with its spring, messages."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import infinivar as iv
from infinivar import DutyCycle, Limit, Scenario, duty_cycle
from infinivar.analysis import two_ways
from infinivar.motion import Reaches
from internals import GEAR_LIMITS, shipped_study, strain_wave_friction

GEARED = shipped_study("faulring2006").drives["motor2-gear4"]
MOTOR = GEARED.motor
RATIO = 50.0
RATED = 0.6 * RATIO * MOTOR.continuous_torque

SAID = iv.parts.StrainWave(
    efficiency=0.75,
    rated_torque=RATED,
    starting_torque=0.06 * RATED / RATIO,
    running_torque=0.12 * RATED / RATIO,
    backdriving_torque=0.075 * RATED,
    momentary_torque=4.0 * RATED,
    ratcheting_torque=10.0 * RATED,
)
"""Of a small gear: torques without load over the rated one as of larger ones."""
GEAR = iv.parts.Gearhead(ratio=RATIO, loss_model="strain wave", strain_wave=SAID)
STIFFNESS = 60.0 * RATED


def joint(gear=GEAR):
    """A joint that the gear turns."""
    return iv.ConventionalDrive(
        motor=MOTOR, gearhead=gear, shaft=iv.parts.Shaft(), amplifier=GEARED.amplifier, output_inertia=1e-4
    )


def springy(corner=0.2):
    """The gear with a spring of three stiffnesses."""
    said = replace(
        SAID,
        torque_1=corner * RATED,
        stiffness_2=1.6 * STIFFNESS,
        torque_2=3.0 * corner * RATED,
        stiffness_3=1.9 * STIFFNESS,
    )
    return replace(GEAR, strain_wave=said, stiffness=STIFFNESS)


def efficiency(gear, share, speed, back=False):
    """Power out over power in at a share of the rated torque; `back` while the load drives."""
    torque = share * RATED
    point = gear.operate(output_torque=torque, output_speed=(-speed if back else speed) / RATIO, motor_rated_torque=1.0)
    motor, load = point.motor_torque * point.motor_speed, torque * speed / RATIO * (-1 if back else 1)
    return motor / load if back else load / motor


def test_what_the_catalogue_states_is_what_the_gear_does():
    """Rated efficiency, torques without load at standstill and rated speed, and the load that moves the motor."""
    law = GEAR.law()
    assert efficiency(GEAR, 1.0, SAID.rated_speed) == pytest.approx(0.75, rel=1e-12)
    assert float(law.friction_torque(SAID.rated_speed, 0.0)) == pytest.approx(SAID.running_torque, rel=1e-12)
    assert float(law.friction_torque(1e-9, 0.0)) == pytest.approx(SAID.starting_torque, rel=1e-6)
    torques = np.array([0.999, 1.001]) * SAID.backdriving_torque
    holding = GEAR.operate(output_torque=torques, output_speed=0.0, motor_rated_torque=1.0).motor_torque
    assert holding[0] == 0.0
    assert 0.0 < holding[1] < 1e-3 * SAID.starting_torque


def test_the_efficiency_falls_with_the_load_as_catalogues_compensate_it():
    """The coefficient at a share V of the rated torque, for a loss of which the part a/(a + k) does not depend on the load.

    Catalogues (harmonicdrive2014, p. 36) draw one curve through 1 at V = 1 that rises all the way, steeply at light loads. The
    form is stated there; no values are taken from it, so the band is wide: assumed, 0.3 to 0.6 at V = 0.1, 0.75 to 0.95 at 0.5.
    """
    shares = np.array([0.1, 0.2, 0.5, 0.8, 1.0])
    coefficient = np.array([efficiency(GEAR, share, SAID.rated_speed) for share in shares]) / 0.75
    free, load = 0.12, 1.0 / 0.75 - 1.0 - 0.12
    assert_allclose(coefficient, (1.0 + load + free) / (1.0 + load + free / shares), rtol=1e-12)
    assert np.all(np.diff(coefficient) > 0)
    assert 0.3 < coefficient[0] < 0.6
    assert 0.75 < coefficient[2] < 0.95


def test_it_returns_less_than_it_takes_and_nothing_at_light_load():
    assert 0.0 < efficiency(GEAR, 1.0, SAID.rated_speed, back=True) < 0.75
    light = GEAR.operate(output_torque=0.05 * RATED, output_speed=-SAID.rated_speed / RATIO, motor_rated_torque=1.0)
    assert light.motor_torque * light.motor_speed > 0.0  # the motor must help


def test_a_colder_lubricant_takes_more():
    cold = replace(GEAR, strain_wave=replace(SAID, temperature=273.15))
    ratio = cold.law().friction_torque(100.0, 0.0) / GEAR.law().friction_torque(100.0, 0.0)
    assert ratio == pytest.approx(np.exp(0.02 * 20.0), rel=1e-12)
    assert cold.law().load_factors == GEAR.law().load_factors


def test_its_limits_are_named():
    """Those of the gearhead, momentary torque and ratcheting, which names the limit where it is the tightest."""
    gear = replace(GEAR, continuous_torque=RATED, intermittent_torque=2.0 * RATED, max_input_speed=300.0)
    assert set(joint(gear).operate(speed=1.0, force=0.1).utilisation) >= {*GEAR_LIMITS}
    alone = {limit: float(demand) for limit, demand in GEAR.utilisation(11.0 * RATED, 0.0).items()}
    assert alone == {Limit.GEAR_MOMENTARY: pytest.approx(2.75), Limit.RATCHETING: pytest.approx(1.1)}
    only = replace(GEAR, strain_wave=replace(SAID, momentary_torque=None, ratcheting_torque=RATED))
    point = joint(only).operate(speed=1.0, force=2.0 * RATED)
    assert Limit(int(point.limit)).words == "gearhead ratcheting torque"


@pytest.mark.parametrize("moment", [0.5, -0.5])
def test_steady_map_and_simulation_agree(moment):
    """Current at constant speed, driving and driven, after the loops have settled."""
    drive, speed = joint(), 2.0
    run = iv.simulate(
        drive,
        Scenario(
            duration=0.6,
            motion=iv.motion.Cruise(angular_speed=speed),
            force=iv.motion.ConstantForce(moment=-moment * RATED),
            load_inertia=0.01,
        ),
    )
    steady = drive.operate(speed=speed, force=moment * RATED)
    assert run.columns["motor_current_A"][-1] == pytest.approx(float(steady.states["motor_current_A"]), rel=1e-3)


def check_both_ways(drive, sign, pause):
    """Energy, loss of the gear and position by inverse dynamics and in time; and the law at every instant of the simulation."""
    duty = DutyCycle(motion=Reaches(angle=1.0, time=0.6, pause=pause), moment=sign * 0.4 * RATED, load_inertia=0.02)
    both = two_ways(drive, duty)
    assert both.rms_error < 1e-3
    assert both.followed == pytest.approx(both.prescribed, rel=0.01)
    assert both.lost_followed["gearhead"] == pytest.approx(both.lost_prescribed["gearhead"], rel=0.01)
    run = both.simulation.trajectory
    friction, speed = run.at("gear_loss")
    given = {name: one.value for name, one in run.graph["gear_loss"].parameters.items()}
    law = strain_wave_friction(speed, run.signals["gear_torque"], **given)
    assert_allclose(friction, law, atol=1e-9 * np.abs(law).max())
    assert duty_cycle(drive, duty).closure < 1e-9
    assert run.closure < 1e-6


@pytest.mark.slow
@pytest.mark.parametrize(
    ("sign", "pause"),
    [(-1.0, 0.3), *(pytest.param(*one, marks=pytest.mark.slow) for one in ((1.0, 0.0), (-1.0, 0.0), (1.0, 0.6)))],
)
def test_motion_and_simulation_agree(sign, pause):
    """Lifting and lowering, without and with rests, in which part of the friction helps to hold."""
    check_both_ways(joint(), sign, pause)


@pytest.mark.slow
def test_motion_and_simulation_agree_on_the_spring():
    """Through both corners; energies close. The encoder is at the motor, so the load swings a little further than prescribed."""
    drive = joint(springy(0.05))
    inertia = 0.3 * RATED / (0.5 * (2 * np.pi * 0.8) ** 2)
    duty = DutyCycle(motion=iv.motion.Sinusoid(angle=0.5, frequency=0.8), load_inertia=inertia)
    both = two_ways(drive, duty)
    assert both.lost_followed["gearhead"] == pytest.approx(both.lost_prescribed["gearhead"], rel=0.02)
    run = both.simulation.trajectory
    torque, _ = run.at("gear_spring")
    assert np.abs(torque).max() > 0.25 * RATED
    assert run.closure < 1e-6
    assert duty_cycle(drive, duty).closure < 1e-9
    assert float(springy().torsion.twist(0.8 * RATED)) == pytest.approx(
        RATED / STIFFNESS * (0.2 + 0.4 / 1.6 + 0.2 / 1.9), rel=1e-12
    )


def test_a_fit_starts_from_the_law_while_the_motor_drives():
    """Measured friction in its place: the same driving; and no loss remains without friction."""
    measured = GEAR.with_measured(GEAR.measured_friction(1.0))
    torque, speed = np.linspace(0.0, RATED, 5), np.linspace(0.1, 4.0, 5)
    points = [one.operate(output_torque=torque, output_speed=speed, motor_rated_torque=1.0) for one in (GEAR, measured)]
    assert_allclose(points[1].motor_torque, points[0].motor_torque, rtol=1e-12)
    assert measured.strain_wave is None
    assert GEAR.without_friction().lossless


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"efficiency": 0.9}, r"strain_wave.efficiency must be <= 0.8929, which running_torque leaves at rated torque"),
        ({"backdriving_torque": 0.05 * RATED}, "strain_wave.backdriving_torque must be >= .*, ratio times starting"),
        ({"running_torque": 1e-9}, "running_torque must be >= starting_torque"),
        ({"stiffness_2": 1.0}, "torque_1 is missing: stiffness_2 needs it"),
        ({"torque_2": 1.0, "stiffness_3": 1.0}, "torque_1 is missing: torque_2 needs it"),
        ({"torque_1": 1.0, "stiffness_2": 1.0}, "stiffness is missing: corners of the torsional spring need it"),
        (
            {"torque_1": 1.0, "stiffness_2": 2.0, "torque_2": 2.0, "stiffness_3": 1.0},
            "stiffness_3 must be >= stiffness_2, 2 N m/rad, got 1",
        ),
        ({"momentary_torque": 0.5 * RATED}, "momentary_torque must be >= rated_torque"),
        ({"ratcheting_torque": 0.5 * RATED}, "ratcheting_torque must be >= rated_torque"),
        (
            {"momentary_torque": 4.0 * RATED, "ratcheting_torque": 3.0 * RATED},
            "ratcheting_torque must be >= momentary_torque",
        ),
    ],
)
def test_values_that_exclude_each_other_are_refused(changed, message):
    with pytest.raises(iv.InputError, match=message):
        replace(GEAR, strain_wave=replace(SAID, **changed))


def test_a_row_of_a_table_is_excluded_for_what_a_gear_is_refused_for():
    stated = {name: getattr(SAID, name) for name in ("efficiency", "rated_torque", "starting_torque", "running_torque")}
    stated |= {"momentary_torque": 0.5 * RATED, "ratcheting_torque": 0.4 * RATED}
    row = {"ratio": RATIO, **{f"strain_wave.{name}": value for name, value in stated.items()}}
    faults = type(GEAR.law()).contradictions(lambda name, otherwise=np.nan: np.array([row.get(name, otherwise)]))
    assert [why for why, bad in faults if bad[0]] == [
        "gearhead strain_wave.momentary_torque below its rated torque",
        "gearhead strain_wave.ratcheting_torque below its rated torque",
        "gearhead strain_wave.ratcheting_torque below its momentary torque",
    ]


def test_a_spring_that_softens_is_refused():
    with pytest.raises(iv.InputError, match=r"stiffness must be <= .* N m/rad, that beyond the first corner"):
        replace(springy(), stiffness=1.01 * springy().strain_wave.stiffness_2)


def test_a_table_without_its_loss_model_names_it():
    """The default, coulomb, would ask for an efficiency that a strain-wave gear states in its table."""
    with pytest.raises(iv.InputError, match=r"efficiency is missing: .*, or choose loss_model = 'strain wave'"):
        iv.parts.Gearhead(ratio=RATIO, strain_wave=SAID)


def test_backlash_beside_corners_is_refused():
    with pytest.raises(iv.InputError, match="backlash does not apply"):
        replace(springy(), backlash=0.01)


STUDY = """[requirement]
base = "faulring2006"
[drives.joint]
base = "faulring2006.motor2-gear4"
[drives.joint.gearhead]
loss_model = "strain wave"
ratio = 50
[drives.joint.gearhead.strain_wave]
kind = "assumed"
efficiency = 0.75
rated_torque = "2 N m"
starting_torque = "2.4 mN m"
running_torque = "4.8 mN m"
temperature = "0 °C"
ratcheting_torque = "30 N m"
"""


@pytest.mark.usefixtures("unrendered")
def test_a_study_states_it(tmp_path):
    """Over a base with an efficiency, which does not apply; saved and read again; in a report."""
    (tmp_path / "s.toml").write_text(STUDY, "utf-8")
    study = iv.load_study(tmp_path / "s.toml")
    gear = study.drives["joint"].gearhead
    assert (gear.efficiency, gear.loss_words) == (None, "strain wave")
    assert gear.strain_wave.temperature == pytest.approx(273.15)
    iv.save_study(study, tmp_path / "again.toml")
    assert iv.load_study(tmp_path / "again.toml").drives["joint"].gearhead == gear
    files = iv.save(iv.compare(study), tmp_path / "out")
    page = next(path for path in files if path.name == "report.html").read_text("utf-8")
    assert "50:1, strain wave" in page


def test_no_sample_is_a_gear_that_could_not_be(tmp_path):
    """A spread that reaches beyond what the friction without load leaves of the efficiency is refused, or truncated there."""
    study, gear = tmp_path / "s.toml", "[uncertainty.joint.gearhead.strain_wave]\n"
    study.write_text(STUDY, "utf-8")
    here = iv.load_study(study).drives["joint"].gearhead
    value = here.strain_wave.efficiency
    study.write_text(f"{STUDY}\n{gear}efficiency = {{ low = {value - 0.1}, high = 0.999 }}\n", "utf-8")
    with pytest.raises(
        iv.InputError, match=r"strain_wave\.efficiency.* reaches 0\.999, which the drive refuses: .* <= "
    ):
        iv.load_study(study)
    study.write_text(f"{STUDY}\n{gear}efficiency = {{ deviation = 0.2 }}\n", "utf-8")
    (spread,) = iv.load_study(study).uncertainty.spreads["joint"]
    replace(here, strain_wave=replace(here.strain_wave, efficiency=spread.high))
    with pytest.raises(iv.ParameterError):
        replace(here, strain_wave=replace(here.strain_wave, efficiency=spread.high + 1e-6))
    assert spread.low < value - 0.3

"""Why a motion takes another energy when controllers follow it, in words."""

from dataclasses import replace
from types import SimpleNamespace

import pytest

import infinivar as iv
from infinivar.analysis import sampled_springs
from infinivar.analysis.cycles.tracking import TwoWays
from infinivar.drivetrain.control import ConventionalControl

EXACT = {"prescribed": 2.0, "as_turning": 2.0, "followed": 2.3, "rms_error": 2.5e-4, "stays": False}


def two_ways(lost_prescribed, lost_followed, **changes):
    given = {**EXACT, "speed_ripple": 0.0, "stored": 0.0, "simulation": SimpleNamespace(warnings=()), **changes}
    return TwoWays(lost_prescribed=lost_prescribed, lost_followed=lost_followed, **given)


def test_a_loss_that_one_way_does_not_have_counts_as_none_there():
    """0.4, -0.2 and 0.1 J by subtraction, which add up to the difference; less than its last digit is not named."""
    said = two_ways(
        {"winding": 1.0, "slip": 0.2, "guideway": 0.5},
        {"winding": 1.1, "pulley": 0.4, "guideway": 0.501},
    ).explanation
    assert said == ("+0.30 J (+15.0 %): pulley +0.40 J, slip -0.20 J, winding +0.10 J; RMS position error 0.25 mm")


@pytest.mark.parametrize(("change", "named"), [(0.004, False), (0.006, True)])
def test_losses_below_the_last_digit_are_not_named(change, named):
    said = two_ways({"winding": 1.0}, {"winding": 1.0 + change}).explanation
    assert ("winding" in said) == named


def test_what_no_loss_explains_is_work_on_the_load_or_kept():
    """0.3 J, of which inertias keep 0.05 J and losses take 0.01 to 0.05 J: all of it is told."""
    lost = {"a": 0.05, "b": 0.04, "c": 0.02, "d": 0.01}
    said = two_ways({}, lost, stored=0.05).explanation
    assert "work on the load +0.13 J, " in said
    assert "stored in inertias +0.05 J" in said
    assert "other +0.03 J; " in said


def test_what_the_cylinder_and_stays_do_is_said():
    """0.3 J in all, of which 0.25 J remain where the cylinder turns as it did."""
    said = two_ways({}, {}, as_turning=2.05, speed_ripple=0.031, stays=True).explanation
    assert said.startswith("+0.30 J (+15.0 %): work on the load +0.30 J; RMS position error")
    assert "varies by 3.1 %" in said
    assert "with the simulated speed prescribed, the difference is +0.25 J" in said
    assert "before a standstill the controllers first bring the load to rest" in said
    assert two_ways({}, {}, prescribed=0.0, followed=0.0).explanation.startswith("+0 J; RMS position error")


def stiff_drive(stiffness, **changed):
    """Motor behind a series spring; reflected mass 2.51 kg."""
    motor = iv.Motor(
        voltage=48.0,
        resistance=0.6,
        torque_constant=0.05,
        no_load_current=0.15,
        continuous_torque=0.15,
        rotor_inertia=1e-5,
        inductance=1e-4,
    )
    return iv.ConventionalDrive(
        motor=motor,
        gearhead=iv.Gearhead(ratio=5, efficiency=0.9, loss_model="proportional"),
        pulley=iv.Pulley(radius=0.01),
        guideway=iv.Guideway(friction=1.0),
        output_inertia=1e-6,
        output=iv.Output(series_spring=iv.Spring(stiffness=stiffness)),
        **changed,
    )


# Free resonances 461, 595 and 1031 Hz at a sample rate of 1 kHz.
@pytest.mark.slow
@pytest.mark.parametrize(
    ("stiffness", "excites"),
    [(6e6, False), (1e7, True), (3e7, False)],
)
def test_a_resonance_that_the_sampled_controllers_excite_is_named(stiffness, excites):
    """The warning stands exactly where simulation and inverse dynamics part, in a motion that leaves it time to grow."""
    duty = iv.DutyCycle(motion=iv.Sinusoid(distance=0.01, frequency=1.0), load_mass=1.0, force=-20.0)
    two = iv.two_ways(stiff_drive(stiffness), duty)
    if excites:
        assert two.followed > 1.2 * two.prescribed
    else:
        assert two.followed == pytest.approx(two.prescribed, rel=0.01)
    for text in (two.explanation, two.simulation.verdict):
        assert ("the series spring resonates at 595 Hz (503 Hz with the motor locked)" in text) is excites
    assert len(two.simulation.warnings) == excites


def test_a_faster_controller_damps_the_resonance():
    scenario = iv.Scenario(duration=0.1, motion=iv.Sinusoid(distance=0.01, frequency=3.0), load_mass=1.0)
    assert sampled_springs.excited(stiff_drive(1e7), scenario)
    quick = stiff_drive(1e7, control=ConventionalControl(sample_rate=1200.0))
    assert sampled_springs.excited(quick, scenario) == ()
    assert sampled_springs.excited(stiff_drive(1e7), replace(scenario, load_mass=0.5)) != ()

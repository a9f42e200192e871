"""A battery that feeds a cart or a platform: its current, what it loses, how long it lasts, and messages."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import infinivar as iv
from infinivar import Limit
from internals import power_audit as audit
from made import loaded

BATTERY = iv.parts.Battery(
    voltage=24.0,
    energy=480.0 * 3600.0,
    resistance=0.04,
    largest_current=40.0,
    largest_charging_current=10.0,
    usable=0.8,
)
STUDY = loaded("driven_cart")


@pytest.mark.parametrize("resistance", [0.0, 0.04])
def test_power_at_the_terminals_is_that_of_the_cells_without_the_loss(resistance):
    power = np.linspace(-2000.0, 3500.0, 111)
    found = replace(BATTERY, resistance=resistance).supply(power)
    assert_allclose(found.power - found.loss, power, rtol=0, atol=1e-9)
    assert_allclose(found.power, 24.0 * found.current, rtol=1e-14)
    assert_allclose(found.loss, resistance * found.current**2, rtol=1e-12)
    drives = power > 0.0
    assert_allclose(found.utilisation[Limit.BATTERY][drives], found.current[drives] / 40.0)
    assert_allclose(found.utilisation[Limit.BATTERY][power < 0.0], -found.current[power < 0.0] / 10.0)


def test_largest_power_of_a_battery():
    """At U^2/4R half of the power is lost, at half the voltage; beyond it there is no current."""
    bare = iv.parts.Battery(voltage=24.0, energy=1.0, resistance=0.04)
    most = 24.0**2 / 0.16
    found = bare.supply(np.array([most, 0.99 * most, 1.01 * most]))
    assert found.current[0] == pytest.approx(300.0)
    assert found.loss[0] == pytest.approx(most)
    assert found.utilisation[Limit.BATTERY][0] == pytest.approx(1.0)
    assert found.utilisation[Limit.BATTERY][1] < 1.0
    assert np.isnan(found.current[2])
    assert found.utilisation[Limit.BATTERY][2] == np.inf


@pytest.mark.parametrize("name", STUDY.drives)
def test_a_machine_on_a_battery_draws_what_it_draws_without_and_the_loss(name):
    machine, task = STUDY.drives[name], STUDY.tasks["corner"]
    with_it, without = (iv.perform_task(one, task) for one in (machine, replace(machine, battery=None)))
    current = with_it.point.states["battery_current_A"]
    assert with_it.mean_power == pytest.approx(24.0 * current)
    assert with_it.mean_power - without.mean_power == pytest.approx(0.04 * current**2, rel=1e-9)
    assert with_it.losses["battery"] == pytest.approx(0.04 * current**2)
    assert with_it.point.demands[Limit.BATTERY, "battery"] == pytest.approx(current / 40.0)
    assert with_it.endurance.time == pytest.approx(0.8 * 480.0 * 3600.0 / with_it.mean_power)
    assert with_it.endurance.distance == pytest.approx(0.5 * with_it.endurance.time)
    assert np.isnan(with_it.endurance.share)
    assert without.endurance is None
    assert "endurance" not in without.to_dict()


@pytest.mark.parametrize("name", STUDY.drives)
def test_energy_of_pushing_a_load_over_a_way(name):
    """200 N over 50 m are 10 kJ: the battery gives these, all losses, and nothing that stays in motion."""
    found = iv.follow_path(STUDY.drives[name], STUDY.paths["there"])
    assert found.per == "over the run"
    assert found.pose[-1, 0] == pytest.approx(50.0, abs=1e-3)
    assert np.mean(found.point.power_out) * found.period == pytest.approx(10e3, rel=1e-6)
    lost = sum(found.losses.values()) * found.period
    assert found.energy == pytest.approx(10e3 + lost, rel=1e-4)
    assert (
        audit(found.point.power_in, found.point.power_out + sum(found.point.stored.values()), found.point.losses, name)
        < 1e-9
    )
    assert found.endurance.share == pytest.approx(found.energy / (0.8 * 480.0 * 3600.0), rel=1e-9)
    assert found.endurance.distance == pytest.approx(50.0 / found.endurance.share, rel=1e-3)
    assert f"{100.0 * found.endurance.share:.3g} % of the battery, which lasts" in found.battery_words


def test_driven_carts_and_omniwheels_compared():
    """All push the load; the cart of two motors needs the least; while it waits, its wheels stand across the load."""
    found = iv.compare(STUDY, quick=True)
    assert found.all_feasible
    assert found.best.name == "rear"
    for name in ("steered", "rear"):
        waiting = found.results[name].tasks["wait"]
        assert {key for key, loss in waiting.losses.items() if loss > 0.0} == {"amplifier", "battery"}
    assert found.results["omniwheels"].tasks["wait"].losses["winding"] > 0.0
    assert found.results["rear"].lacking == {}


def test_largest_speed_of_a_platform_is_that_of_its_fastest_wheel():
    machine = replace(STUDY.drives["omniwheels"], largest_speed=2.0)
    pose, twist = np.array([0.0, 0.0, 0.5]), np.array([0.4, 0.3, -1.0])
    found = machine.perform(pose=pose, twist=twist, wrench=np.zeros(3)).demands[
        Limit.OUTPUT_SPEED, "platform, largest_speed"
    ]
    spots = np.array([[np.cos(0.5), -np.sin(0.5)], [np.sin(0.5), np.cos(0.5)]]) @ np.array(machine.wheels.positions).T
    speeds = np.hypot(0.4 + spots[1], 0.3 - spots[0])
    assert found == pytest.approx(speeds.max() / 2.0)


def test_a_driven_cart_has_no_session_and_a_pushed_one_no_battery():
    cart = STUDY.drives["rear"]
    assert (cart.session, loaded("planar_cart").drives["two-wheels"].session) == ((), ("handle",))
    with pytest.raises(iv.ParameterError, match="battery does not apply without drive"):
        replace(cart, drive=None, driven_wheels=None)
    assert (cart.source, replace(cart, battery=None).source) == ("battery", "supply")
    assert loaded("planar_cart").drives["two-wheels"].source == "push"


@pytest.mark.parametrize("name", STUDY.drives)
def test_what_a_battery_cannot_give_is_infeasible(name):
    """Beyond U^2/4R there is no power, so that the machine neither does the task nor wins."""
    drive = STUDY.drives[name]
    weak = replace(drive, battery=replace(drive.battery, resistance=1.2, largest_current=None))
    found = iv.perform_task(weak, STUDY.tasks["corner"])
    assert (found.feasible, found.demand, found.margin) == (False, (Limit.BATTERY, "battery"), 0.0)
    assert 0.0 < found.bears < 1.0
    assert "no steady operation: battery" in found.tightest_words
    assert not iv.follow_path(weak, STUDY.paths["there"]).feasible


def test_a_largest_current_beyond_that_of_the_largest_power_is_refused():
    with pytest.raises(iv.ParameterError, match="largest_current must be <= 300 A"):
        iv.parts.Battery(voltage=24.0, energy=1.0, resistance=0.04, largest_current=301.0)


def test_power_that_an_amplifier_cannot_take_is_infeasible():
    drive = loaded("hand_controller").drives["motor2-gear4"]
    task = iv.motion.MachineTask(title="back", twist=iv.motion.Twist(x=0.3), wrench=iv.motion.Wrench(x=-20.0))
    closed = replace(drive, amplifier=replace(drive.amplifier, regeneration="none"))
    assert iv.perform_task(drive, task).feasible
    found = iv.perform_task(closed, task)
    assert (found.feasible, found.demand[0], found.margin) == (False, Limit.REGENERATION, 0.0)

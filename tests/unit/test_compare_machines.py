"""Machines compared in tasks and on paths, against the machines themselves and closed forms."""

import json
import tomllib
from dataclasses import replace

import numpy as np
import pytest

import infinivar as iv
from infinivar import Limit
from internals import compare_machines, machine_sensitivity, motor_mass, pose_map
from internals import tightest_of_drives as tightest_of
from machine_studies import ARM, EVERY, PLATFORM


@pytest.fixture(scope="module")
def studies(tmp_path_factory):
    folder, made = tmp_path_factory.mktemp("machines"), {}
    for name, text in EVERY.items():
        (folder / f"{name}.toml").write_text(text, "utf-8")
        made[name] = iv.load_study(folder / f"{name}.toml")
    return made


@pytest.mark.parametrize("name", EVERY)
def test_every_machine_goes_the_same_way(name, studies):
    found = iv.compare(studies[name])
    assert isinstance(found, iv.MachineComparison)
    assert found.feasible
    assert found.verdict
    for one in found.results.values():
        assert one.audit_residual < 1e-9
        for done in one.found.values():
            kept = sum(np.mean(power) for power in done.point.stored.values())
            spent = sum(done.losses.values()) + np.mean(done.point.power_out) + kept
            assert done.mean_power == pytest.approx(spent, rel=1e-9)
    said = json.loads(json.dumps(found.to_dict()))
    assert {*said["drives"]} == {*studies[name].drives}


def test_a_task_is_the_machine_at_its_point(studies):
    study = studies["platform"]
    done = iv.perform_task(study.drives["cobotic"], study.tasks["lift"])
    point = study.drives["cobotic"].perform(
        pose=study.drives["cobotic"].home, twist=[0, 0.1, 0.1, 0, 0, 0], wrench=[0, 20, 20, 0, 0, 0]
    )
    assert done.steady_power == float(point.power_in)
    assert len(done.corners) == 5


def test_tightest_margin_of_a_polytope_is_that_of_its_worst_corner(studies):
    study = studies["platform"]
    drive, task = study.drives["separate"], study.tasks["lift"]
    done = iv.perform_task(drive, task)
    each = []
    for x in (-5.0, 5.0):
        for rz in (-0.1, 0.1):
            wrench = replace(task.wrench, x=x, rz=rz)
            each.append(iv.perform_task(drive, replace(task, box=None, wrench=wrench)).margin)
    assert done.margin == min(each)
    rng = np.random.default_rng(5)
    inside = [
        iv.perform_task(
            drive, replace(task, box=None, wrench=replace(task.wrench, x=rng.uniform(-5, 5), rz=rng.uniform(-0.1, 0.1)))
        )
        for _ in range(30)
    ]
    assert all(one.margin >= done.margin for one in inside)


def test_path_is_the_mean_of_its_instants(studies):
    study = studies["platform"]
    drive, path = study.drives["separate"], study.paths["circle"]
    done = iv.follow_path(drive, path)
    at = path.instants(drive.coordinates, drive.home)
    few = range(0, len(at.time), 100)
    each = [float(drive.perform(pose=at.pose[i], twist=at.twist[i], wrench=at.wrench[i]).power_in) for i in few]
    assert np.allclose(np.asarray(done.steady.power_in)[list(few)], each, rtol=1e-12)
    assert done.energy == pytest.approx(done.mean_power * 1.0)
    thermal = max(value for (limit, _), value in done.demands.items() if limit is Limit.THERMAL)
    peak = max(np.max(value) for (limit, _), value in done.point.demands.items() if limit is Limit.THERMAL)
    assert 0.0 < thermal < peak


def test_work_on_a_lossless_round_trip_is_zero(studies):
    """A mass that goes round a circle takes no energy: what is spent is lost."""
    study = studies["platform"]
    for drive in study.drives.values():
        done = iv.follow_path(drive, study.paths["circle"])
        assert np.mean(done.point.power_out) == pytest.approx(0.0, abs=1e-12)


def test_mixed_use_weighs_by_shares_and_names_the_best(studies):
    found = compare_machines(studies["platform"])
    one = found.results["cobotic"]
    by_hand = (
        0.6 * one.tasks["lift"].mean_power + 0.2 * one.tasks["hold"].mean_power + 0.2 * one.paths["circle"].mean_power
    )
    assert one.mean_power == pytest.approx(by_hand, rel=1e-12)
    assert found.best.name == min(found.results, key=lambda name: found.results[name].mean_power)
    assert found.results["separate"].title in found.verdict


def test_share_motor_agrees_while_holding():
    """Holding the same force in each link is what `share_motor` compares."""
    study = iv.load_study("hand_controller")
    platform = iv.Study.from_dict(tomllib.loads(PLATFORM), name="p")
    drive = platform.drives["separate"]
    jacobian = drive.configuration(drive.home).jacobian
    wrench = jacobian.T @ np.full(6, 25.0)
    shared = iv.analysis.share_motor(study.drives["cobotic"], study.drives["motor2-gear4"], force=[25.0], legs=[6])
    rest = np.zeros(6)
    for name, power in (("cobotic", shared.turning), ("separate", shared.separate)):
        point = platform.drives[name].perform(pose=drive.home, twist=rest, wrench=wrench)
        assert float(point.power_in) == pytest.approx(power[0, 0, 0], rel=1e-6)
    assert motor_mass(platform.drives["cobotic"]) == pytest.approx(shared.shared_mass[0])
    assert motor_mass(drive) == pytest.approx(shared.separate_mass[0])


def test_a_drive_of_one_axis_performs_tasks_beside_a_machine():
    study = iv.Study.from_dict(
        {
            "drives": {"one": {"base": "faulring2006.cobotic"}, "two": {"base": "faulring2006.motor2-gear4"}},
            "tasks": {"push": {"twist": {"x": "0.3 m/s"}, "wrench": {"x": "20 N"}}},
        },
        name="line",
    )
    found = iv.compare(study)
    point = study.drives["one"].operate(speed=0.3, force=20.0)
    assert found.results["one"].tasks["push"].mean_power == float(point.power_in)


def test_slip_and_reach_lead_over_other_limits():
    demands = {(Limit.THERMAL, "motor"): 9.0, (Limit.SLIP, "leg 1"): 1.2, (Limit.SLIP, "leg 2"): float("nan")}
    assert tightest_of(demands) == ((Limit.SLIP, "leg 2"), 0.0)
    assert tightest_of({**demands, (Limit.LINKAGE, "geometry"): 1.5})[0][0] is Limit.LINKAGE
    assert tightest_of({(Limit.THERMAL, "motor"): 0.5}) == ((Limit.THERMAL, "motor"), 2.0)
    assert tightest_of({(Limit.THERMAL, "motor"): 0.0})[1] == float("inf")


def test_map_of_an_arm_covers_its_reach():
    study = iv.Study.from_dict(tomllib.loads(ARM), name="arm")
    drive = study.drives["cobotic"]
    found = pose_map(drive, study.tasks["push"], drive.span, points=41)
    radius = np.hypot(found.x[:, None], found.y[None, :])
    reaches = (radius < 0.55) & (radius > 0.05)
    assert np.array_equal(found.limit == Limit.LINKAGE, ~reaches)
    assert np.all(np.isfinite(found.loss[found.limit == Limit.OK]))


def test_result_has_a_figure_and_a_table(studies):
    found = iv.compare(studies["arm"])
    assert len(found.plot().axes) == 2
    table = found.to_dataframe()
    assert table.loc[("cobotic", "tasks.push"), "power_in_W"] == found.results["cobotic"].tasks["push"].mean_power


def test_contact_sheet_of_a_machine_is_that_of_its_leg(studies):
    (sheet,) = iv.contact_sheets(studies["platform"])
    (other,) = iv.contact_sheets(iv.load_study("hand_controller"), "cobotic")
    assert [line.value for line in sheet.lines] == [line.value for line in other.lines]
    assert "leg.transmission.preload" in {row.field for row in sheet.given}
    with pytest.raises(iv.InputError, match=r"drives\.separate is a machine"):
        iv.contact_sheets(studies["platform"], "separate")


def test_effects_are_those_of_closed_forms(studies):
    """Without a load, a cart loses its rolling resistance (tau_in + tau_wa) v/r; the margin of slip is mu P/F."""
    study = studies["planar"]
    free = replace(study, tasks={"free": replace(study.tasks["straight"], wrench=iv.motion.Wrench())})
    found = machine_sensitivity(free, "cart", "loss")
    effects = {one.path: one.elasticity for one in found.influences}
    assert effects == pytest.approx(
        {
            "wheel.wheel_radius": -1.0,
            "wheel.preload": 0.6 * 4.0 / 3.0 + 0.4,
            "wheel.rolling_torque": 0.6,
            "wheel.bearing_torque": 0.4,
        },
        rel=1e-5,
    )
    margin = {one.path: one.elasticity for one in machine_sensitivity(study, "cart", "margin").influences}
    assert margin["wheel.preload"] == pytest.approx(1.0, rel=2e-3)
    assert margin["wheel.friction"] == pytest.approx(1.0, rel=2e-3)


ONE_LEG = """
[leg]
base = "faulring2006.cobotic"
[leg.transmission]
creep_stiffness = "17 kN"
rolling_torque = "0.2 mN m"
bearing_torque = "2 mN m"
[leg.steering]
patch_half_length = "0.5 mm"
"""


@pytest.mark.slow
def test_effects_on_an_arm_of_one_joint_are_those_on_its_leg(tmp_path):
    """A pulley of 1 m makes the joint's torque the force; the complex step of one axis against differences here."""
    files = {
        "one": '[requirement]\nforce = "30 N"\nspeed = "0.5 m/s"\n' + ONE_LEG.replace("[leg", "[drives.a"),
        "arm": '[drives.a]\ntype = "arm"\nlengths = ["1 m"]\npulley_radius = "1 m"\n'
        + ONE_LEG.replace("[leg", "[drives.a.leg")
        + '[tasks.t]\ntwist = { angle = "0.3 rad/s" }\nwrench = { angle = "20 N m" }\n',
    }
    for name, text in files.items():
        (tmp_path / f"{name}.toml").write_text(text, "utf-8")
    one, arm = (iv.load_study(tmp_path / f"{name}.toml") for name in files)
    known = iv.sensitivity(one, "a", "loss", speed=0.3, force=20.0, samples=0).influences
    found = {effect.path: effect.elasticity for effect in machine_sensitivity(arm, "a", "loss").influences}
    for effect in known:
        assert found[f"leg.{effect.path}"] == pytest.approx(effect.elasticity, rel=1e-4, abs=1e-6)
    assert {"transmission.preload", "amplifier.efficiency"} <= {effect.path for effect in known}


@pytest.mark.slow
def test_effects_on_a_platform_agree_with_those_of_its_leg(studies):
    """Six locked legs at no load on one cylinder: the motor's effects are those of a drive with six times the friction."""
    study = studies["platform"]
    found = machine_sensitivity(study, "cobotic", "loss", task="hold")
    effects = {one.path: one.elasticity for one in found.influences}
    changed = replace(study.drives["cobotic"], leg=replace(study.drives["cobotic"].leg, cylinder_speed=14.0 * 1.01))
    ratio = iv.perform_task(changed, study.tasks["hold"]).mean_power / found.value
    assert effects["leg.cylinder_speed"] == pytest.approx((ratio - 1.0) / 0.01, rel=2e-2)
    assert not any(path.startswith("separate") for path in effects)


@pytest.mark.parametrize(("low", "high", "turned"), [(0.06, 0.06, 0.0), (0.08, 0.04, 0.0), (0.08, 0.04, 0.3)])
def test_a_singular_platform_is_said_to_be_so(low, high, turned, tmp_path):
    """Six rods on regular hexagons: upright, in planes through the axis, or as many rods twisted alike."""

    def hexagon(radius, turn):
        corners = [(radius * np.cos(one + turn), radius * np.sin(one + turn)) for one in np.arange(6) * np.pi / 3.0]
        return "[" + ", ".join(f'{{ x = "{x:.9f} m", y = "{y:.9f} m" }}' for x, y in corners) + "]"

    text = (
        f'[drives.p]\ntype = "platform"\n[drives.p.geometry]\nrod_length = "140 mm"\nguideways = {hexagon(low, 0.0)}\n'
    )
    text += f'joints = {hexagon(high, turned)}\n[drives.p.leg]\nbase = "faulring2006.cobotic"\n'
    (tmp_path / "p.toml").write_text(f'{text}[tasks.hold]\nwrench = {{ z = "20 N" }}\n', "utf-8")
    study = iv.load_study(tmp_path / "p.toml")
    found = iv.perform_task(study.drives["p"], study.tasks["hold"])
    assert not found.feasible
    assert found.tightest_words == "pose out of reach, or singular, where the links leave a motion of the machine free"
    platform = study.drives["p"].platform
    assert np.linalg.cond(platform.at([0.0, 0.0, platform.home]).jacobian) > 1e8


def test_of_limits_equal_but_for_rounding_the_first_is_told():
    """Legs placed alike have equal demands: which of them is larger by rounding differs between machines."""
    one, other, less = ((Limit.THERMAL, name) for name in ("leg 2", "leg 6", "leg 1"))
    assert tightest_of({less: 0.4, one: 0.5, other: 0.5 * (1 + 1e-15)}) == (one, pytest.approx(2.0))
    assert tightest_of({one: 0.5, other: 0.5001})[0] == other

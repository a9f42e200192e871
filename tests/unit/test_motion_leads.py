"""Studies whose motions lead: without a requirement, several cycles in one figure, and a requirement about a joint."""

import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import infinivar as iv
from infinivar import Limit, Output
from infinivar.parts import Linkage
from internals import LINEAR, MAP_REACH, ROTARY, StudyError, of_drives, of_study, study_from, words_of
from internals import least_loss_analysis as least
from internals import plane_path as path
from made import loaded

SHIPPED = loaded("reach_and_hold")
DRIVES = {name: SHIPPED.drives[name] for name in ("cobotic", "geared")}
ALONE = iv.DutyCycle(title="reach", motion=iv.motion.Reaches(distance=0.1, time=0.5), load_mass=0.8)
REACH = replace(ALONE, time_share=0.25)
HOLD = iv.DutyCycle(title="hold", motion=iv.motion.Hold(time=1.0), force=-20.0, time_share=0.75)
MOVING = iv.Study(name="moving", title="Moving", drives=DRIVES, duty={"reach": ALONE})
MIXED = replace(MOVING, duty={"reach": REACH, "hold": HOLD})


@pytest.fixture(scope="module")
def mixed():
    return iv.compare(MIXED, quick=True)


@pytest.mark.slow
def test_a_study_without_a_requirement_is_compared_on_its_motions():
    found = iv.compare(MOVING, quick=True)
    assert found.feasible
    assert found.best.name == found.duty["reach"].best.name
    assert found.verdict.startswith("reach: 2 of 2 drives are feasible; lowest energy: ")
    assert "requirement" not in found.verdict
    assert repr(found).splitlines()[1].startswith("  verdict: reach: 2 of 2")
    for name, drive in found.results.items():
        assert found.able(name)
        assert drive.tightest is None
        assert math.isnan(drive.coverage)
        assert not drive.corners
        assert 0.0 < drive.peak_efficiency < 1.0
    said = found.to_dict()
    assert said["drives"]["geared"]["tightest_margin"] is None
    assert said["feasible"] is True


def test_maps_without_a_requirement_span_the_motions():
    study = MOVING
    plane = of_drives(study)
    _, speed, force = path(ALONE)
    assert plane.speed == np.abs(speed).max() == pytest.approx(1.875 * 0.1 / 0.5, rel=1e-5)
    assert plane.force == np.abs(force).max()
    assert (plane.low, plane.high) == ((-1, -1), (1, 1))
    speeds, forces = plane.axes()
    assert_allclose([speeds.max(), forces.max()], np.multiply([plane.speed, plane.force], MAP_REACH), rtol=0.01)
    pulled = of_drives(replace(MOVING, duty={"hold": replace(HOLD, time_share=None)}))
    # A hold moves nothing: speeds reach as far as the fastest drive runs, forces from 0 to what is held.
    assert (pulled.low, pulled.high, pulled.force) == ((0, 0), (1, 1), 20.0)
    margins = [drive.operate(speed=pulled.speed, force=0.0).margin for drive in DRIVES.values()]
    assert max(margins) >= 1.0
    assert max(drive.operate(speed=1.1 * pulled.speed, force=0.0).margin for drive in DRIVES.values()) < 1.0


def test_the_plane_of_both_contains_both():
    study = replace(MOVING, duty={"reach": ALONE}, requirement=iv.Requirement(force=40.0, speed=0.1))
    both = of_study(study)
    assert both.force == 40.0
    assert both.speed == of_drives(replace(study, requirement=None)).speed
    assert both.low == (-1, -1)


@pytest.mark.slow
def test_the_requirement_counts_beside_the_motions():
    hard = replace(MOVING, duty={"reach": ALONE}, requirement=iv.Requirement(force=500.0, speed=1.0))
    found = iv.compare(hard, quick=True)
    assert all(done.feasible for done in found.duty["reach"].results.values())
    assert not found.feasible
    assert found.best is None
    assert found.verdict.endswith("None of the 2 drives covers the requirement.")
    soft = iv.compare(replace(hard, requirement=iv.Requirement(force=5.0, speed=0.1)), quick=True)
    assert soft.feasible
    assert soft.best is not None
    assert soft.able(soft.best.name)
    # A motion that no drive follows is not feasible, whatever the requirement.
    fast = replace(ALONE, motion=iv.motion.Reaches(distance=1.0, time=0.2))
    assert not iv.compare(replace(hard, duty={"fast": fast}), quick=True).feasible


def test_the_verdict_names_the_best_drive_that_does_all():
    """The drive that leads in motion may not cover the requirement: the sentence, the best and what decides agree."""

    def found_at(force, names=tuple(SHIPPED.drives)):
        drives = {name: SHIPPED.drives[name] for name in names}
        study = replace(
            SHIPPED, drives=drives, duty={"reach": ALONE}, requirement=iv.Requirement(force=force, speed=0.1)
        )
        return iv.compare(study, quick=True)

    # The geared drive needs the least energy for the reach; beyond 41 N, unlike the cobotic ones, its winding gets too hot.
    leading = found_at(40.0)
    assert leading.best.name == leading.duty["reach"].best.name == "geared"
    assert leading.verdict.endswith("3 of 3 drives cover the requirement.")
    other = found_at(60.0)
    assert other.duty["reach"].best.name == "geared"
    assert other.best.name == other.hangs_on.used.winner == "cobotic-b"
    said = f"of the 2 drives that are feasible in motion and cover it, {other.best.title} has the lowest energy"
    assert f"2 of 3 drives cover the requirement; {said}" in other.verdict
    pair = found_at(60.0, ("geared", "cobotic"))
    said = f"1 of 2 drives covers the requirement; only {pair.best.title} is feasible in motion and covers it"
    assert said in pair.verdict
    # With less preload the wheel slips at 31 N, and the geared drive, which does not, is too slow for the motion.
    light = SHIPPED.drives["cobotic"].transmission
    loose = replace(SHIPPED.drives["cobotic"], transmission=replace(light, preload=0.4 * light.preload))
    fast = replace(ALONE, motion=iv.motion.Reaches(distance=0.1, time=0.14), load_mass=0.3)
    drives = {"geared": SHIPPED.drives["geared"], "cobotic": loose}
    apart = replace(pair.study, drives=drives, duty={"reach": fast}, requirement=iv.Requirement(force=35.0, speed=0.1))
    neither = iv.compare(apart, quick=True)
    assert neither.best is None
    assert neither.duty["reach"].best.name == "cobotic"
    assert "1 of 2 drives covers the requirement; none of these is feasible in motion" in neither.verdict


@pytest.mark.slow
def test_shares_weigh_like_an_hour_of_mixed_use(mixed):
    """Three ways: the weighted mean, energies of whole cycles over an hour, and a concatenated timeline."""
    for name in DRIVES:
        done = {task: found.results[name] for task, found in mixed.duty.items()}
        hour = 3600.0
        whole = sum(hour * share / done[task].duty.period * done[task].energy for task, share in MIXED.shares.items())
        assert mixed.mixed.power[name] == pytest.approx(whole / hour, rel=1e-12)
        # 2 s of timeline: half a cycle of reaching cannot be, so 1 s (one cycle) of it and 3 s of holding.
        step = 1e-3
        drawn = [
            np.interp(
                (np.arange(round(seconds / step)) + 0.5) * step % found.duty.period,
                found.instants.time,
                found.point.power_in,
            )
            for seconds, found in ((1.0, done["reach"]), (3.0, done["hold"]))
        ]
        assert mixed.mixed.power[name] == pytest.approx(float(np.mean(np.concatenate(drawn))), rel=1e-3)
        assert mixed.mixed.watt_hours[name] == mixed.mixed.power[name]


def test_mixed_use_comes_first_and_decides(mixed):
    best = mixed.mixed.best
    assert mixed.best.name == best == min(mixed.mixed.power, key=lambda name: mixed.mixed.power[name])
    assert "Mixed use (25 % reach, 75 % hold): 2 of 2 drives are feasible; lowest energy: " in mixed.verdict
    said = mixed.to_dict()["mixed_use"]
    assert said["best"] == best
    assert set(said["drives"]) == set(DRIVES)
    for name, drive in said["drives"].items():
        margins = [found.results[name].tightest[1] for found in mixed.duty.values()]
        assert drive["tightest"]["margin"] == min(margins)


@pytest.mark.slow
def test_without_shares_the_best_must_lead_in_every_cycle():
    duty = {name: replace(cycle, time_share=None) for name, cycle in MIXED.duty.items()}
    found = iv.compare(replace(MIXED, duty=duty), quick=True)
    assert found.mixed is None
    leaders = {done.best.name for done in found.duty.values()}
    assert (found.best is None) == (len(leaders) > 1)
    assert len(found.verdict.split(". ")) >= 2


@pytest.mark.parametrize(
    ("shares", "said"),
    [
        ((0.5, None), "duty.hold.time_share is missing: duty.reach has one"),
        ((0.5, 0.4), "add up to 90 %, not to 100 %: duty.reach 50 %, duty.hold 40 %"),
    ],
)
def test_shares_must_be_all_and_whole(shares, said):
    duty = {
        name: replace(cycle, time_share=share) for (name, cycle), share in zip(MIXED.duty.items(), shares, strict=True)
    }
    with pytest.raises(iv.InputError, match="time_share") as caught:
        replace(MIXED, duty=duty)
    assert said in str(caught.value)


def test_rounded_percentages_are_divided_by_their_sum():
    duty = {str(place): replace(REACH, time_share=0.333) for place in range(3)}
    assert list(replace(MIXED, duty=duty).shares.values()) == pytest.approx([1 / 3] * 3, rel=1e-12)


def test_energy_per_kilogram_and_metre():
    walking = iv.load_study("knee_walking").duty["walking"]
    drive = iv.load_study("knee_walking").drives["geared"]
    found = iv.duty_cycle(drive, replace(walking, distance_per_cycle=1.4))
    assert found.energy_per_kilogram == found.energy / 75.0
    assert found.energy_per_metre == found.energy / 1.4
    assert f"{found.energy_per_kilogram:.3g} J/kg" in found.verdict
    assert f"{found.energy_per_metre:.3g} J/m" in found.verdict
    bare = iv.duty_cycle(drive, iv.DutyCycle(motion=iv.motion.Sinusoid(distance=0.02, frequency=1.0), force=-10.0))
    assert bare.energy_per_kilogram is bare.energy_per_metre is None
    assert "J/kg" not in bare.verdict


def test_peak_and_net_power_agree_with_the_energies():
    found = iv.duty_cycle(DRIVES["geared"], ALONE)
    powers = found.powers
    assert powers["power_to_load_net_W"] * found.duty.period == pytest.approx(found.delivered - found.absorbed)
    assert powers["power_from_supply_net_W"] == found.power_in < powers["power_from_supply_peak_W"]
    # Force times speed at its largest, on a grid of its own.
    _, speed, force = path(ALONE)
    assert powers["power_to_load_peak_W"] == pytest.approx(float((speed * force).max()), rel=1e-9)
    assert powers["power_of_load_peak_W"] == pytest.approx(float(-(speed * force).min()), rel=1e-9)


class TestLeastLoss:
    """The map of the least loss against a plain search point by point."""

    speed, force = np.linspace(-0.6, 0.6, 14), np.linspace(-60.0, 60.0, 12)
    found = iv.analysis.least_loss(MOVING, speed=speed, force=force)

    def test_each_point_by_itself(self):
        for row, speed in enumerate(self.speed):
            for column, force in enumerate(self.force):
                points = [drive.operate(speed=speed, force=force) for drive in DRIVES.values()]
                losses = sorted(
                    (float(point.power_in - point.power_out), place)
                    for place, point in enumerate(points)
                    if int(point.limit) == Limit.OK
                )
                best, saved = self.found.best[row, column], self.found.saved[row, column]
                assert (self.found.limit[row, column] == Limit.OK) == bool(losses)
                if not losses:
                    assert best == least.NONE
                    continue
                assert self.found.loss[row, column] == pytest.approx(losses[0][0], rel=1e-9)
                if len(losses) == 1:
                    assert best == losses[0][1]
                    assert math.isnan(saved)
                else:
                    assert saved == pytest.approx(losses[1][0] - losses[0][0], abs=1e-9)
                    assert best == (losses[0][1] if saved > 1e-6 * losses[0][0] else least.EQUAL)

    def test_drives_that_burn_all_of_a_brake_lose_the_same(self):
        """Without regeneration and standby power, each loses exactly the power of the load."""
        braking = self.found.best == least.EQUAL
        assert braking.any()
        shed = -(self.speed[:, None] * self.force[None, :])
        assert_allclose(self.found.loss[braking], shed[braking], rtol=1e-9)

    def test_ranks(self):
        losses = np.array([[1.0, 2.0, 3.0, 1.0], [2.0, 1.0, 1.0, 1.0]])
        feasible = np.array([[True, True, False, True], [True, True, False, True]])
        best, runner_up, loss, saved = least.ranked(losses, feasible)
        assert best.tolist() == [0, 1, least.NONE, least.EQUAL]
        assert runner_up.tolist()[:3] == [1, 0, least.NONE]
        assert_allclose(saved, [1.0, 1.0, np.nan, 0.0])
        assert_allclose(loss, [1.0, 1.0, np.nan, 1.0])

    def test_known_maps_are_used_only_on_the_same_axes(self):
        maps = {name: iv.steady_map(drive, self.speed, self.force) for name, drive in DRIVES.items()}
        assert iv.analysis.least_loss(MOVING, speed=self.speed, force=self.force, maps=maps) == self.found
        other = iv.analysis.least_loss(MOVING, speed=self.speed, force=0.5 * self.force, maps=maps)
        assert_allclose(other.force, 0.5 * self.force)
        assert other.loss[0, 0] != self.found.loss[0, 0]

    def test_data_and_figure(self):
        from internals import least_loss_figure as figure

        numbers = figure.data(iv.analysis.least_loss(MOVING))
        assert list(numbers["motions"]) == ["reach"]
        assert numbers["levels"][0] == 0.0
        assert not numbers["signs"]
        texts = [text.get_text() for text in iv.analysis.least_loss(MOVING).plot().axes[0].texts]
        assert any(title in texts for title in MOVING.titles.values())
        assert self.found.to_dict()["shares"].keys() == DRIVES.keys()

    def test_refuses(self):
        with pytest.raises(iv.InputError, match="takes two"):
            iv.analysis.least_loss(MOVING.with_drives("geared"))
        with pytest.raises(iv.InputError, match="both speed and force"):
            iv.analysis.least_loss(MOVING, speed=self.speed)

    def test_a_comparison_of_one_drive_has_none(self):
        assert iv.compare(MOVING.with_drives("geared"), quick=True).least_loss is None


JOINT = """
[requirement]
{requirement}
[drives.knee]
base = "faulring2006.motor2-gear4"
output = {{ linkage = {{ arm = "50 mm" }} }}
"""


def joint(requirement):
    import tomllib

    return study_from(tomllib.loads(JOINT.format(requirement=requirement)), name="joint", origin="test")


class TestAboutAJoint:
    """A requirement in moment and angular speed."""

    well = 'moment = "2 N m"\nangular_speed = "60 rpm"\npower = "6 W"\nload_inertia = "20 g m^2"\nangle = "90 deg"'

    def test_values_have_the_names_that_analyses_use(self):
        required = joint(self.well).requirement
        assert required.axis is ROTARY
        assert (required.force, required.speed, required.power) == (2.0, pytest.approx(2 * math.pi), 6.0)
        assert (required.load_mass, required.travel) == (0.02, pytest.approx(math.pi / 2))
        assert (
            required
            == iv.study.JointRequirement(
                moment=2.0, angular_speed=required.speed, power=6.0, load_inertia=0.02, angle=required.travel
            ).requirement
        )
        assert set(required.to_dict()) == {"moment", "angular_speed", "power", "load_inertia", "angle", "quadrants"}
        assert iv.Requirement(force=1.0, speed=1.0).axis is LINEAR

    def test_words_and_units_are_those_of_a_joint(self):
        from internals import labelled_arrays, operating_map
        from internals import losses_figure as losses

        found = iv.compare(joint(self.well))
        (drive,) = found.results.values()
        assert " N m, " in drive.verdict
        assert " rad/s" in drive.verdict
        assert " m/s" not in drive.verdict
        assert losses.data(found, "maximum force")["title"].startswith("maximum moment: 2 N m at 3 rad/s")
        axes = operating_map.draw_all(found).axes[0]
        assert axes.get_xlabel() == "moment on the load [N m]"
        assert axes.get_ylabel() == "angular speed of the load [rad/s]"
        coordinates = labelled_arrays(drive).coordinates
        assert coordinates["force"][2] == {"units": "N m", "long_name": "moment on the load"}
        assert coordinates["speed"][2]["units"] == "rad s-1"

    @pytest.mark.parametrize(
        ("requirement", "said"),
        [
            ('moment = "2 N m"\nspeed = "1 m/s"', "requirement.moment does not apply beside speed: write force, speed"),
            ('moment = "2 N m"', "requirement.angular_speed is missing (Largest angular speed of the load)"),
            ('moment = "2 N"\nangular_speed = "60 rpm"', 'requirement.moment = "2 N"'),
            ('moment = "-2 N m"\nangular_speed = "60 rpm"', "must be > 0 N m"),
            ('base = "faulring2006"\nmoment = "2 N m"', "requirement.moment does not apply beside force"),
        ],
    )
    def test_refuses(self, requirement, said):
        with pytest.raises(StudyError) as caught:
            joint(requirement)
        assert said in str(caught.value)

    def test_drives_and_requirement_have_one_axis(self):
        along = replace(joint(self.well), requirement=iv.Requirement(force=1.0, speed=1.0))
        with pytest.raises(
            iv.InputError, match=r"requirement\.force is along a line; drives\.knee moves a joint: write"
        ):
            iv.compare(along)
        drive = replace(along.drives["knee"], output=Output())
        with pytest.raises(
            iv.InputError, match=r"requirement.moment is about a joint; drives.knee moves along a line: give"
        ):
            iv.compare(replace(joint(self.well), drives={"knee": drive}))

    def test_a_motion_about_a_joint_leads(self):
        motion = iv.motion.Sinusoid(angle=0.5, frequency=0.5)
        swing = iv.DutyCycle(title="swing", motion=motion, moment=-0.2, load_inertia=0.005)
        given = joint(self.well)
        inertia = replace(given.drives["knee"], output_inertia=2e-6)
        study = iv.Study(
            name="swing", title="Swing", drives={"a": given.drives["knee"], "b": inertia}, duty={"swing": swing}
        )
        assert study.axis is ROTARY
        found = iv.compare(study, quick=True)
        assert found.least_loss.axis is ROTARY
        columns = found.duty["swing"].results["a"].columns
        assert {"angle_rad", "speed_rad_s", "moment_Nm"} < columns.keys()
        crossing = found.least_loss.motions["swing"]
        assert np.abs(crossing.speed).max() == pytest.approx(0.5 * np.pi, rel=1e-4)
        assert found.least_loss.plot().axes[0].get_xlabel() == "moment on the load [N m]"
        page = found.duty["swing"].plot()
        assert [ax.get_ylabel() for ax in page.axes][:2] == ["speed of\nload [rad/s]", "moment on\nload [N m]"]

    def test_a_drive_about_a_joint_has_a_map_with_its_axis(self):
        drive = replace(DRIVES["geared"], output=Output(linkage=Linkage(arm=0.05)))
        assert iv.steady_map(drive, [1.0, 2.0], [0.5, 1.0]).axis is ROTARY


def test_outcomes_say_what_they_need():
    for kind in ("coverage", "margin"):
        with pytest.raises(iv.InputError, match=rf"{kind}: the study has no requirement; add a table \[requirement\]"):
            iv.sensitivity(MOVING, "geared", kind)
    with pytest.raises(iv.InputError, match="loss without speed: the study has no requirement"):
        iv.sensitivity(MOVING, "geared", "loss", force=10.0)
    found = iv.sensitivity(MOVING, "geared", "loss", force=10.0, speed=0.2, samples=0)
    assert found.outcome.words == "loss at 10 N, 0.2 m/s"


def unshared(forces, drives=DRIVES):
    cycles = {f"h{k}": replace(HOLD, title=f"Hold {k}", force=force, time_share=None) for k, force in enumerate(forces)}
    return iv.compare(replace(MOVING, drives=drives, duty=cycles), quick=True)


def test_an_answer_of_no_names_the_closest_drive_and_its_limit():
    alone = iv.compare(replace(MOVING, duty={"hold": replace(HOLD, force=-900.0, time_share=None)}), quick=True)
    results = alone.duty["hold"].results
    closest = max(results.values(), key=lambda result: result.tightest[1])
    limit, margin = closest.tightest
    assert margin < 1.0
    said = f"none of the 2 drives is feasible; closest: {closest.title}, tightest limit: {words_of(limit)} (margin {margin:.2f})."
    assert alone.verdict == f"hold: {said}"
    one = unshared([-900.0], {"geared": DRIVES["geared"]})
    assert one.verdict.startswith(f"Hold 0: {one.results['geared'].title} is infeasible; tightest limit: ")


@pytest.mark.slow
def test_several_cycles_have_one_answer_first():
    both = unshared([-5.0, -900.0])
    assert not both.feasible
    first, *others = both.verdict.split(". Hold")
    assert first.startswith("None of the 2 drives is feasible in all 2 duty cycles; closest: ")
    assert first.endswith(" in Hold 1")
    assert len(others) == 2
    good = unshared([-5.0, -6.0])
    assert good.verdict.startswith("2 of 2 drives are feasible in all 2 duty cycles; lowest energy in each: ")
    assert good.results[good.best.name].title in good.verdict.split(".")[0]
    one = unshared([-5.0, -900.0], {"geared": DRIVES["geared"]})
    assert " is not feasible in all 2 duty cycles; tightest limit: " in one.verdict


@pytest.mark.slow
def test_many_cycles_have_a_short_answer():
    many = unshared([-1.0 - k for k in range(10)])
    assert many.verdict.startswith("2 of 2 drives are feasible in all 10 duty cycles; ")
    assert len(many.verdict) < 150


@pytest.mark.slow
def test_mixed_use_names_its_limit_and_the_energy_per_metre():
    walk, stand = replace(REACH, title="Walk", distance_per_cycle=1.4), replace(HOLD, title="Stand")
    found = iv.compare(replace(MIXED, duty={"walk": walk, "stand": stand}), quick=True)
    use = found.mixed
    metres = 0.25 * 3600.0 / found.duty["walk"].duty.period * 1.4
    for name in DRIVES:
        assert use.per_metre[name] == pytest.approx(use.power[name] * 3600.0 / metres)
        assert use.to_dict()["drives"][name]["energy_per_distance_J_m"] == use.per_metre[name]
        assert use.verdict_on(name).count(f"{use.power[name]:.3g} ") == 1
        assert "Wh" not in use.verdict_on(name)
    task, limit, margin = use.tightest[use.best]
    drawn = f"{use.power[use.best]:.3g} W on average, {use.per_metre[use.best]:.3g} J/m"
    assert use.verdict.endswith(f"{drawn}; tightest limit: {limit} in {use.cycles[task]} (margin {margin:.2f})")
    assert not iv.compare(MIXED, quick=True).mixed.per_metre
    hard = iv.compare(replace(MIXED, duty={"walk": walk, "stand": replace(stand, force=-900.0)}), quick=True)
    assert "none of the 2 drives is feasible; closest: " in hard.verdict
    assert " in Stand (margin 0." in hard.verdict


@pytest.mark.slow
def test_mixed_use_of_many_cycles_is_short():
    duty = {f"h{k}": replace(HOLD, title=f"Hold {k}", force=-1.0 - k, time_share=0.1) for k in range(10)}
    found = iv.compare(replace(MIXED, duty=duty), quick=True)
    assert found.verdict.startswith("Mixed use of 10 duty cycles: 2 of 2 drives are feasible; ")

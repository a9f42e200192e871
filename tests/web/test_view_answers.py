"""The answers behind the explorer's views: equal to the public functions, at every drive and machine that is shipped."""

from __future__ import annotations

import json
import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import infinivar as iv
from infinivar import InputError
from internals import RefusedError, is_machine, shipped_studies
from internals import contact_answer as contact
from internals import drawing_answer as drawing
from internals import motion_answer as motion
from internals import pictures_figure as pictures
from internals import places_answer as places
from internals import plain_answer as plain
from internals import point_answer as point
from internals import shapes_answer as shapes
from sampled import sampled


@pytest.fixture(scope="module")
def studies():
    return {name: iv.load_study(path) for name, path in shipped_studies().items() if name != "sphere_joint"}


@pytest.fixture(scope="module")
def hand(studies):
    return studies["hand_controller"]


def places_of(study):
    for name, drive in study.drives.items():
        if study.tasks:
            yield from ({"drive": name, "task": task} for task in study.tasks)
        elif is_machine(drive):
            yield {"drive": name}
        else:
            for speed, force in ((0.2, 20.0), (-0.3, 15.0), (0.0, -10.0), (0.1, 500.0)):
                yield {"drive": name, "speed": speed, "force": force}


@pytest.mark.slow
def test_every_view_answers_at_every_drive_and_machine(studies):
    for study in studies.values():
        for request in places_of(study):
            for answer in (point.point(study, request), drawing.drawing(study, request)):
                json.dumps(plain(answer), allow_nan=False)
            shown = contact.contact(study, request)
            json.dumps(plain(shown.header), allow_nan=False)
            shown.pack()


class TestPoint:
    @pytest.mark.parametrize(("speed", "force"), [(0.3, 40.0), (0.3, -40.0), (-0.3, 40.0), (-0.2, -30.0), (0.9, -3.0)])
    @pytest.mark.parametrize("drive", ["cobotic", "motor1-gear1", "motor2-gear4"])
    def test_equals_the_drive_and_flows_close(self, hand, drive, speed, force):
        found = point.point(hand, {"drive": drive, "speed": speed, "force": force})
        expected = hand.drives[drive].operate(speed=speed, force=force)
        assert found["power_in"] == expected.power_in
        assert found["power_out"] == expected.power_out
        losses = {flow["label"]: flow["watts"] for flow in found["flows"] if flow["kind"] == "loss"}
        assert losses == {name: float(loss) for name, loss in expected.losses.items()}
        assert found["efficiency"] == (None if math.isnan(expected.efficiency) else float(expected.efficiency))
        for stage in found["stages"][1:-1]:
            inward = sum(flow["watts"] for flow in found["flows"] if flow["to"] == stage)
            outward = sum(flow["watts"] for flow in found["flows"] if flow["from"] == stage)
            assert inward == pytest.approx(outward, abs=1e-9)
        ends = {"supply": expected.power_in, "load": -expected.power_out}
        for end, watts in ends.items():
            leaving = sum(
                flow["watts"] * (1 if flow["from"] == end else -1)
                for flow in found["flows"]
                if end in (flow["from"], flow["to"])
            )
            assert leaving == pytest.approx(watts, abs=1e-9)

    def test_power_flows_back_when_the_load_drives(self, hand):
        found = point.point(hand, {"drive": "motor1-gear1", "speed": 1.0, "force": -40.0})
        assert found["flows"][-1]["from"] == "load"
        assert found["power_out"] < 0

    def test_a_point_beyond_a_limit_names_it_and_by_how_much(self, hand):
        found = point.point(hand, {"drive": "motor1-gear1", "speed": 0.2, "force": 100.0})
        worst = float(hand.drives["motor1-gear1"].operate(speed=0.2, force=100.0).utilisation[iv.Limit.THERMAL])
        assert found["limit"] == {"limit": "THERMAL", "words": "motor continuous torque", "share": pytest.approx(worst)}
        assert found["verdict"].startswith("infeasible: motor continuous torque, ")
        assert found["utilisation"][0]["share"] == pytest.approx(worst)
        assert found["flows"]
        assert found["efficiency"] is None

    def test_a_wheel_that_slips_has_no_flows(self, hand):
        found = point.point(hand, {"drive": "cobotic", "speed": 0.2, "force": 200.0})
        assert found["limit"]["limit"] == "SLIP"
        assert found["flows"] == []
        assert found["power_in"] is None

    def test_a_machine_equals_the_comparison(self, studies):
        study = studies["six_leg_display"]
        for name, drive in study.drives.items():
            for task, one in study.tasks.items():
                expected = iv.perform_task(drive, one)
                found = point.point(study, {"drive": name, "task": task})
                assert found["power_in"] == pytest.approx(expected.mean_power, rel=1e-12)
                losses = {flow["label"]: flow["watts"] for flow in found["flows"] if flow["kind"] == "loss"}
                assert losses == pytest.approx(expected.losses, rel=1e-12)
                assert len(found["parts"]) == 6

    def test_what_no_page_sends_is_refused(self, hand):
        for wrong in (
            {"speed": "1"},
            {"speed": math.nan},
            {"speed": 1e300},
            {"force": -1e10},
            {"drive": 3, "speed": 1.0},
            {"speed": True},
            {"task": []},
        ):
            with pytest.raises(RefusedError):
                point.point(hand, {"drive": "cobotic", "force": 1.0, **wrong})
        for wrong in ({"drive": "nothing"}, {"task": "lift"}):
            with pytest.raises(InputError, match="the study has no"):
                point.point(hand, {"speed": 0.1, "force": 1.0, **wrong})


class TestContact:
    @pytest.mark.parametrize("name", ["hand_controller", "knee_walking", "ankle_walking"])
    def test_the_wheel_is_that_of_the_drive_and_lies_on_its_curve(self, studies, name):
        study = studies[name]
        drive = study.drives["cobotic"]
        for speed, force in ((0.1, 10.0), (-0.2, 12.0), (0.3, -9.0)):
            expected = replace(drive, cylinder_bearings=None).operate(speed=speed, force=force)
            element = contact.element_point(drive, speed, force)
            assert element.steering_tangent == expected.states["steering_tangent"]
            assert element.torque == expected.states["cylinder_torque_Nm"]
            found = contact.contact(study, {"drive": "cobotic", "speed": speed, "force": force})
            at = found.header["point"]
            curve = np.interp(at["creepage"], found.arrays["creepage"], found.arrays["force"])
            assert curve == pytest.approx(at["force"], rel=2e-3)
            assert at["force"] == pytest.approx(abs(float(element.lateral_force)), rel=1e-12)
            assert found.header["slip_demand"] == pytest.approx(float(expected.utilisation[iv.Limit.SLIP]), rel=1e-12)

    def test_the_patch_carries_the_force_and_the_preload(self, hand):
        for force in (10.0, 40.0, -60.0):
            found = contact.contact(hand, {"drive": "cobotic", "speed": 0.2, "force": force})
            patch, at = found.header["patch"], found.header["point"]
            assert abs(patch["force_share"]) == pytest.approx(at["force"] / found.header["slip_force"], abs=0.01)
            cells = found.arrays["patch/length"][:, None] * patch["width"] * np.ones_like(found.arrays["patch/x"])
            assert float(np.sum(1e3 * found.arrays["patch/pressure"] * cells)) == pytest.approx(650.0, rel=0.02)
            sticks = 1.0 - float(np.mean(found.arrays["patch/slides"]))
            assert sticks == pytest.approx(1.0 - patch["slip_share"], abs=0.05)

    def test_a_slipping_wheel_slides_everywhere(self, hand):
        found = contact.contact(hand, {"drive": "cobotic", "speed": 0.2, "force": 200.0})
        assert found.header["slips"]
        assert found.header["point"] is None
        assert found.arrays["patch/slides"].all()

    def test_the_leg_of_a_machine_equals_its_point(self, studies):
        study = studies["six_leg_display"]
        place = places.place_of(study, {"drive": "one-motor", "task": "push"})
        states = contact.rolling_states(place)
        # Of steady rolling, without what accelerates the links.
        steady = place.drive.perform(pose=place.pose, twist=place.twist, wrench=place.wrench)
        slip = [float(demand) for (limit, _), demand in steady.demands.items() if limit is iv.Limit.SLIP]
        assert [one.slip_demand for one in states] == pytest.approx(slip, rel=1e-9)
        third = contact.contact(study, {"drive": "one-motor", "task": "push", "part": 3})
        assert third.header["wheel"] == "leg 3"

    def test_a_cart_has_the_creep_of_its_wheels(self, studies):
        study = studies["planar_cart"]
        place = places.place_of(study, {"drive": "three-wheels", "task": "wall"})
        point_of = study.drives["three-wheels"].operated(place.twist, place.wrench)
        for one, creep, rolled in zip(
            contact.rolling_states(place), point_of.creep_speed, point_of.rolling_speed, strict=True
        ):
            assert one.creepage == pytest.approx(float(creep) / abs(float(rolled)))

    def test_geared_drives_say_that_nothing_rolls(self, hand):
        assert (
            "no rolling contact"
            in contact.contact(hand, {"drive": "motor1-gear1", "speed": 0.1, "force": 1.0}).header["reason"]
        )


class TestMotion:
    def test_equals_the_duty_cycle(self, studies):
        study = studies["reach_and_hold"]
        found = motion.motion(study, {})
        duty = study.duty["reach-and-hold"]
        for name in study.drives:
            expected = iv.duty_cycle(study.drives[name], duty, name=name, title=study.titles[name], travel=study.travel)
            row = found.header["drives"][name]
            assert row["energy"] == expected.energy
            assert row["verdict"] == expected.verdict
            assert found.arrays[f"{name}/energy"][-1] == pytest.approx(expected.energy, rel=1e-6)
            assert sum(one["joules"] for one in row["losses"]) == pytest.approx(
                sum(expected.losses.values()), rel=1e-12
            )
            for place, hot in enumerate(expected.heat.values()):
                assert hot is not None
                winding = found.arrays[f"{name}/heat/{place}/winding"]
                assert winding[-1] == pytest.approx(hot.winding_history[-1] - 273.15, rel=1e-6)

    def test_a_path_of_machines(self, studies):
        study = studies["two_joint_arm"]
        found = motion.motion(study, {"motion": "reach", "drives": ["one-motor"]})
        expected = iv.follow_path(study.drives["one-motor"], study.paths["reach"])
        assert found.header["drives"]["one-motor"]["energy"] == expected.energy
        assert found.arrays["one-motor/energy"][-1] == pytest.approx(expected.energy, rel=1e-6)
        assert list(found.header["drives"]) == ["one-motor"]

    def test_a_drive_without_inertia_says_so_and_the_others_have_numbers(self, studies):
        study = studies["reach_and_hold"]
        from dataclasses import replace

        bare = replace(study.drives["geared"], motor=replace(study.drives["geared"].motor, rotor_inertia=None))
        changed = replace(study, drives={**study.drives, "geared": bare}, provenance=())
        found = motion.motion(changed, {})
        assert (
            found.header["drives"]["geared"]["fault"]
            == "drives.geared: motor.rotor_inertia is missing: motion needs it"
        )
        assert found.header["drives"]["cobotic"]["energy"] > 0

    def test_a_study_without_motions_says_what_to_add(self, hand):
        with pytest.raises(InputError, match=r"the study has no motion: add a table \[duty.NAME\]"):
            motion.motion(hand, {})


class TestPlane:
    def test_equals_the_dynamic_map(self, hand):
        found = motion.plane(hand, {"drives": ["cobotic"]})
        expected = iv.analysis.dynamic_map(
            hand.drives["cobotic"],
            np.geomspace(motion.LOWEST, motion.HIGHEST, 2 * motion.FREQUENCIES + 1)[1::2],
            (np.arange(motion.FRACTIONS) + 0.5) / motion.FRACTIONS,
            power=12.0,
            load_mass=0.8,
            samples=motion.SAMPLES,
        )
        assert np.array_equal(
            found.arrays["cobotic/performance"], expected.performance.T.astype(np.float32), equal_nan=True
        )
        assert np.array_equal(found.arrays["cobotic/limit"], expected.binding.T)
        edge = found.arrays["cobotic/edge"]
        for column in range(0, motion.FREQUENCIES, 7):
            inside = found.arrays["power"] <= edge[column]
            assert np.all(expected.works[column, inside])

    def test_a_study_without_a_mass_says_what_to_state(self, studies):
        assert "load_inertia" in motion.plane(studies["ankle_walking"], {}).header["reason"]


class TestDrawing:
    def test_the_ellipse_lies_along_the_least_curvature(self):
        """The magnified ellipse is turned as the gap between wheel and cylinder says, whatever the angle."""
        for study in ("hand_controller", "knee_walking"):
            loaded = iv.load_study(shipped_studies()[study])
            for speed in (-0.3, 0.1, 0.3):
                found = drawing.drawing(loaded, {"drive": "cobotic", "speed": speed, "force": 10.0})
                edge = np.array(next(one for one in found["scenes"][2]["items"] if one["look"] == "contact")["points"])
                far = edge[np.argmax(np.linalg.norm(edge, axis=1))]
                element = loaded.drives["cobotic"].transmission
                angle = math.atan(
                    float(loaded.drives["cobotic"].operate(speed=speed, force=10.0).states["steering_tangent"])
                )
                heading, axle = (
                    np.array([math.sin(angle), math.cos(angle)]),
                    np.array([math.cos(angle), -math.sin(angle)]),
                )
                gap = (
                    np.outer(heading, heading) / element.wheel_radius
                    + np.outer(axle, axle) / element.geometry.crown_radius
                )
                gap += np.diag([0.0, 1.0 / element.cylinder_radius])
                _, ways = np.linalg.eigh(gap)
                assert abs(far @ ways[:, 0]) / np.linalg.norm(far) > 0.99

    def test_what_turns_and_slides_does_so_at_the_speeds_of_the_drive(self, hand):
        drive = hand.drives["cobotic"]
        found = drawing.drawing(hand, {"drive": "cobotic", "speed": 0.3, "force": 10.0})
        marks = [one for one in found["scenes"][0]["items"] if one["kind"] == "marks"]
        assert marks[0]["rate"] == drive.cylinder_speed
        surface, rim = 50.0 * marks[0]["rate"], 10.0 * marks[1]["rate"]
        assert found["slides"]["link"]["rate"] == pytest.approx(300.0)
        # Without creep the rim follows carrier and surface: the square of its speed is the sum of theirs.
        assert rim**2 == pytest.approx(surface**2 + 300.0**2, rel=1e-3)
        assert rim < 0  # the cylinder's top moves to positive y under a wheel that stays

    def test_a_pulley_rolls_its_cable(self, hand):
        found = drawing.drawing(hand, {"drive": "motor1-gear1", "speed": 0.3, "force": 10.0})
        items = found["scenes"][0]["items"]
        turning = next(one for one in items if one["kind"] == "marks")
        radius = 1e3 * hand.drives["motor1-gear1"].pulley.radius
        assert turning["rate"] * radius == pytest.approx(found["slides"]["load"]["rate"])

    @pytest.mark.parametrize("rate", [0.0, 0.4, 3.0, 47.0, 1e4, 1e-9])
    def test_the_slow_down_is_a_round_number(self, rate):
        items = [shapes.spokes((0.0, 0.0), 1.0, rate), shapes.box((-1.0, -1.0), (1.0, 1.0), "steel")]
        slow = shapes.slow_down([shapes.scene("", items)], [])
        assert slow >= 1.0
        assert rate / slow <= 9.0 + 1e-9
        assert f"{slow:.0e}"[0] in "125"

    def test_omniwheels_turn_as_their_rims_roll_and_their_legs_are_beside(self, studies):
        study = studies["omniwheel_platform"]
        task = next(name for name, one in study.tasks.items() if np.any(one.twist.row(("x", "y", "angle"))))
        drive = study.drives["one-motor"]
        found = drawing.drawing(study, {"drive": "one-motor", "task": task})
        marks = [one["rate"] for one in found["scenes"][0]["items"] if one["kind"] == "marks"]
        rims = drive.part_speeds(np.zeros(3), study.tasks[task].twist.row(("x", "y", "angle")))
        np.testing.assert_allclose(marks, rims / drive.wheel_radius, atol=1e-12)
        wheels = [one for one in found["scenes"][1]["items"] if one["look"] == "wheel"]
        assert len(wheels) == drive.links
        assert next(one["text"] for one in found["scenes"][0]["items"] if one["kind"] == "text").startswith("wheel 1: ")

    def test_a_machine_out_of_reach_says_so(self, studies):
        study = studies["two_joint_arm"]
        from dataclasses import replace

        far = replace(study.tasks["push"], pose=iv.motion.Pose(x=2.0, y=0.0), time_share=None)
        found = drawing.drawing(replace(study, tasks={"push": far}, paths={}), {"drive": "one-motor", "task": "push"})
        assert "does not reach" in found["reason"]


@sampled("name", sorted(shipped_studies()), every=4)
def test_every_stroke_of_a_drawing_has_a_look_on_the_page_and_in_figures(name):
    """A page without a rule for a look would paint it as any other line; a figure would fail."""
    page = Path(iv.__file__).parent / "web" / "page"
    rules = set(re.findall(r"\.m\.([a-z-]+)", (page / "views.css").read_text("utf-8")))
    study = iv.load_study(name)
    for request in places_of(study):
        found = drawing.drawing(study, request)
        assert {item["look"] for scene in found["scenes"] for item in scene["items"]} <= rules | {"number"}
        drive = study.drive(request["drive"])
        if is_machine(drive) and found["reason"] is None:
            place = places.place_of(study, request)
            picture = drive.picture(place.point(), place.pose, place.twist, place.wrench)
            assert len(pictures.draw_all(picture).axes) == 1


@pytest.mark.slow
def test_a_sphere_between_rollers_rolls_without_slip():
    study = iv.load_study(shipped_studies()["sphere_joint"])
    request = {"drive": "tetrahedral", "task": "fast"}
    found = drawing.drawing(study, request)
    marks = [one for one in found["scenes"][0]["items"] if one["kind"] == "marks"]
    expected = point.point(study, request)
    assert expected["power_in"] == pytest.approx(
        iv.perform_task(study.drives["tetrahedral"], study.tasks["fast"]).mean_power
    )
    rates = sorted(abs(one["rate"]) for one in marks)
    # Shafts turn as fast as their rollers: 40 rad/s in, 50 rad/s out, but for creep.
    assert any(rate == pytest.approx(40.0, rel=5e-3) for rate in rates)
    assert any(rate == pytest.approx(50.0, rel=5e-3) for rate in rates)
    shown = contact.contact(study, request)
    assert shown.header["patch"]["force_share"] == pytest.approx(shown.header["slip_demand"], abs=0.01)

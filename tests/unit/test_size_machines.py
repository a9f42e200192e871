"""The search over machines: against every design of a small set, against random designs, and against `compare`."""

import itertools
from dataclasses import replace

import numpy as np
import pytest

import infinivar as iv
from internals import (
    MachineWork,
    Prepared,
    Service,
    pool_of_parts,
    power_and_margin,
    tasks_and_paths,
    value_at,
    with_values,
)
from made import kept, loaded
from small_catalogue import SLOW

LIMITED = {"generations": 3, "top": 4, "slip_margin": 1.0}
STUDIES = {"two_joint_arm": ("one-motor", "two-motors"), "six_leg_display": ("one-motor", "six-motors")}
"""With a shared motor, and with a motor for each link."""
MORE = {**STUDIES, "omniwheel_platform": ("one-motor", "three-motors")}


@pytest.fixture(scope="module")
def slow(tmp_path_factory):
    path = tmp_path_factory.mktemp("sets") / "slow.toml"
    path.write_text(SLOW, "utf-8")
    return path


def parts_of(file, law):
    """Motors, gearheads and bearings of a set."""
    found = iv.load_parts(file)
    tables = [[getattr(found, kind).part(row) for row in range(len(getattr(found, kind)))] for kind in found.tables]
    named = dict(zip(found.tables, tables, strict=True))
    gearheads = [replace(one, loss_model=law) for one in named["gearheads"]]
    return named["motors"], gearheads, named["bearings"]


def judged(study, machine, prepared=None):
    """Mean power by the analysis that `compare` decides by, or inf where a limit is exceeded."""
    found = power_and_margin(machine, prepared or Prepared(machine, tasks_and_paths(study)))
    able = all(margin >= 1.0 for _, margin in found.values())
    return sum(share * found[key][0] for key, share in study.machine_shares.items()) if able else np.inf


def without_own_inertias(machine):
    return with_values(machine, {"leg.link_mass": None, "leg.steering.bell_inertia": None})


@pytest.mark.parametrize("study", STUDIES)
def test_best_of_separate_motors_is_that_of_all_designs(study, slow):
    given, name = loaded(study), STUDIES[study][1]
    own = given.drives[name].separate
    radius = 0.4 * own.pulley.radius
    found = iv.size(given, drive=name, sets=slow, radius=(radius, radius), top=100)
    motors, gearheads, _ = parts_of(slow, own.gearhead.loss_model)
    powers = {}
    for motor, gearhead in itertools.product(motors, gearheads):
        changed = {"separate.motor": motor, "separate.gearhead": gearhead, "separate.pulley.radius": radius}
        powers[motor.name, gearhead.name] = judged(given, with_values(given.drives[name], changed))
    able = sorted((power, pair) for pair, power in powers.items() if np.isfinite(power))
    assert 2 <= len(able) < len(powers)
    # The search also asks for room for the shaft of the pulley, which compare does not judge.
    assert [(one.power, names(one, "separate")) for one in found.designs] == [
        (pytest.approx(power, rel=1e-9), pair) for power, pair in able
    ]


def names(design, inner):
    return tuple(design.parts[f"{inner}.{role}"].name for role in ("motor", "gearhead"))


@pytest.mark.parametrize("study", STUDIES)
def test_best_of_legs_is_that_of_all_designs(study, slow):
    given, name = loaded(study), STUDIES[study][0]
    drive = without_own_inertias(given.drives[name])
    leg, element = drive.leg, drive.leg.transmission
    fixed = {
        "cylinder_radius": element.cylinder_radius,
        "cylinder_speed": leg.cylinder_speed,
        "wheel_radius": element.wheel_radius,
        "crown_radius": element.geometry.crown_radius,
        "preload": element.preload,
    }
    ratios = [0.7 * leg.steering.ratio, leg.steering.ratio]
    ranges = {key: (value, value) for key, value in fixed.items()}
    found = iv.size(given, drive=name, sets=slow, ranges=ranges, steering_ratios=ratios, objective="energy", **LIMITED)
    motors, gearheads, bearings = parts_of(slow, leg.gearhead.loss_model)
    bought = ("name", "series", "bore", "outside_diameter", "width", "dynamic_rating", "static_rating", "mass")
    bought += ("calculation_factor", "contact_angle", "seal_torque")
    axles, supports = (
        [own, *(replace(own, **{key: getattr(one, key) for key in bought}) for one in bearings)]
        for own in (element.geometry.axle_bearing, leg.cylinder_bearings.bearing)
    )
    best = np.inf
    for axle, support, steering, ratio in itertools.product(axles, supports, motors, ratios):
        changed = {
            "leg.transmission.geometry.axle_bearing": axle,
            "leg.cylinder_bearings.bearing": support,
            "leg.steering.motor": steering,
            "leg.steering.ratio": ratio,
        }
        made = with_values(drive, changed)
        for motor, gearhead in itertools.product(motors, gearheads):
            power = judged(given, with_values(made, {"leg.motor": motor, "leg.gearhead": gearhead}))
            best = min(best, power)
    assert np.isfinite(best)
    assert found.best.power == pytest.approx(best, rel=1e-9)


@pytest.fixture(scope="module")
def found(slow):
    """Searches of a moment for an arm, by template."""
    return iv.size(loaded("two_joint_arm"), sets=slow, **LIMITED)


def test_each_design_as_a_study_compares_alike(found, tmp_path):
    assert set(found.best_of) == set(STUDIES["two_joint_arm"])
    for name, design in found.best_of.items():
        again = iv.load_study(found.study_of(design, "again").save(tmp_path / f"{name}.toml"))
        there = iv.compare(again).results[name]
        assert there.feasible
        assert there.mean_power == pytest.approx(design.power, rel=1e-9)
        assert {path: value_at(again.drives[name], path) for path in design.free} == {
            path: free.value for path, free in design.free.items()
        }


def test_front_is_not_beaten_and_a_search_is_repeated_by_its_seed(found, slow):
    values = np.array([(one.mass, one.power) for one in (*found.designs, *found.front)])
    for mass, power in [(one.mass, one.power) for one in found.front]:
        assert not ((values <= [mass, power]).all(axis=1) & (values < [mass, power]).any(axis=1)).any()
    again = iv.size(loaded("two_joint_arm"), sets=slow, **LIMITED)
    assert [one.power for one in again.designs] == [one.power for one in found.designs]


def test_whole_mass_counts_every_link_and_one_cylinder(found):
    study = loaded("two_joint_arm")
    shared, own = (found.best_of[name] for name in STUDIES["two_joint_arm"])
    travel, force = MachineWork.of(study, "one-motor").service[:2]
    one = Service(travel, force)
    assert own.mass == pytest.approx(2 * sum(body.mass for body in own.drive.separate.bodies(one)), rel=1e-12)
    bodies = {body.name: body.mass for body in shared.drive.leg.bodies(one)}
    single = ("cylinder motor", "gearhead", "cylinder", "cylinder bearings")
    assert shared.mass == pytest.approx(2 * sum(bodies.values()) - sum(bodies[name] for name in single), rel=1e-12)
    # The links move with the rims of the pulleys, as far as the angles of the joints in all tasks and on the path.
    arm = study.drives["one-motor"]
    path = study.paths["reach"].instants(arm.coordinates, arm.home)
    poses = [*path.pose, [0.35, 0.2], [0.3, 0.25]]
    assert travel == pytest.approx(0.06 * np.max(np.ptp(arm.angles(np.array(poses)), axis=0)), rel=1e-4)


def test_shares_are_equal_where_a_study_states_none(slow):
    study = loaded("two_joint_arm")
    tasks = {name: replace(one, time_share=None) for name, one in study.tasks.items()}
    bare = replace(study, tasks=tasks, paths={})
    found = iv.size(bare, drive="two-motors", sets=slow, objective="energy")
    compared = iv.compare(found.study_of(found.best)).results["two-motors"]
    assert found.best.power == pytest.approx(np.mean([one.mean_power for one in compared.found.values()]), rel=1e-9)


@pytest.mark.parametrize("name", STUDIES["two_joint_arm"])
def test_nearest_miss_says_what_is_exceeded_and_what_would_do(name, slow):
    study = loaded("two_joint_arm")
    heavy = replace(study.tasks["hold"], wrench=replace(study.tasks["hold"].wrench, y=400.0))
    few = {"generations": 2} if name == "one-motor" else {}
    asked = replace(study, tasks={**study.tasks, "hold": heavy})
    found = iv.size(asked, drive=name, sets=slow, objective="energy", **few)
    assert not found.feasible
    assert found.nearest.margin < 1.0
    assert "nearest miss" in found.verdict
    assert any(key[0] == "hold" for key in found.nearest.exceeded)
    assert any(note.startswith(f"the nearest miss like {name}") for note in found.notes)


@pytest.mark.parametrize(
    ("study", "options", "message"),
    [
        (
            "planar_cart",
            {},
            "drives.three-wheels was not searched: .* type planar .* geometry is missing: measured values",
        ),
        ("sphere_joint", {"objective": "mass"}, "what a machine of type sphere weighs is not known; use energy"),
        ("two_joint_arm", {"objective": "space"}, "the space of machines is not known"),
        ("two_joint_arm", {"life": 1e6}, "life: bearings of machines are not searched by their life"),
        ("two_joint_arm", {"wheels": [2]}, "wheels: each leg has one wheel"),
        ("two_joint_arm", {"tries": {"drives.one-motor.leg.transmission.preload": [300.0]}}, "as ranges says"),
        ("two_joint_arm", {"tries": {"drives.one-motor.leg.motor.voltage": [12.0]}}, "itself chooses the motor"),
        ("two_joint_arm", {"tries": {"drives.two-motors.motor.scale": [2.0]}}, "has no such value"),
        ("sphere_joint", {"tries": {"drives.tetrahedral.input_speed": [20.0]}}, "as ranges says"),
        (
            "two_joint_arm",
            {"drive": "two-motors", "ranges": {"preload": (1.0, 2.0)}},
            "ranges: for machines with a leg",
        ),
        ("two_joint_arm", {"drive": "one-motor", "radius": (0.01, 0.02)}, "radius: for machines with separate drives"),
        ("guided_cart", {"objective": "energy"}, "needs a motion"),
        ("guided_cart", {}, "add a table"),
        ("sphere_joint", {"drive": "geared"}, "drives.geared cannot be a template: .* this is a drive of one axis"),
    ],
)
def test_what_is_not_searched_is_refused_by_name(study, options, message):
    with pytest.raises(iv.InputError, match=message):
        iv.size(loaded(study), **options)


def test_sphere_of_fixed_values_has_the_best_of_all_motors(slow):
    study = loaded("sphere_joint")
    drive = study.drives["tetrahedral"]
    fixed = {"preload": 420.0, "wheel_radius": 0.025, "crown_radius": 0.008, "input_speed": 40.0}
    found = iv.size(study, drive="tetrahedral", sets=slow, ranges={key: (one, one) for key, one in fixed.items()})
    motors, gearheads, _ = parts_of(slow, drive.gearhead.loss_model)
    values = {"roller.preload": 420.0, "input_speed": 40.0}
    powers = [
        judged(study, with_values(drive, {**values, "motor": motor, "gearhead": gearhead}))
        for motor, gearhead in itertools.product(motors, gearheads)
    ]
    assert sum(map(np.isfinite, powers)) >= 2
    assert found.best.power == pytest.approx(min(powers), rel=1e-9)
    assert np.isnan(found.best.mass)


@kept
def sized(study, name):
    """The whole search over machines like one of a study, among the shipped parts."""
    slip = {"slip_margin": 1.0} if name == "one-motor" else {}
    return iv.size(loaded(study), drive=name, objective="energy", sets="shipped", **slip)


@pytest.mark.slow
@pytest.mark.parametrize(("study", "name"), [(study, name) for study, names in MORE.items() for name in names])
def test_winner_is_not_beaten_by_a_thousand_random_designs(study, name):
    given, found, random = loaded(study), sized(study, name), np.random.default_rng(7)
    inner = "leg" if name == "one-motor" else "separate"
    drive = without_own_inertias(given.drives[name]) if inner == "leg" else given.drives[name]
    parts, shipped = pool_of_parts(["shipped"]), iv.load_parts("shipped")
    law = value_at(drive, inner).gearhead.loss_model
    ranges, powers = found.searches[name].ranges, []
    prepared = Prepared(drive, tasks_and_paths(given))
    for _ in range(1000):
        first, second = map(int, parts.pairs[random.integers(len(parts.pairs))])
        changed = {path: float(np.exp(random.uniform(*np.log(ends)))) for path, ends in ranges.items()}
        changed[f"{inner}.motor"] = shipped.motors.part(first)
        changed[f"{inner}.gearhead"] = replace(shipped.gearheads.part(second), loss_model=law)
        if inner == "leg":
            changed["leg.steering.motor"] = shipped.motors.part(int(random.integers(len(shipped.motors))))
            changed["leg.steering.ratio"] = float(random.choice(found.searches[name].steering_ratios))
            for path in ("leg.transmission.geometry.axle_bearing", "leg.cylinder_bearings.bearing"):
                some = parts.bearings_like(value_at(drive, path))
                changed[path] = some[random.integers(len(some))][1]
        powers.append(judged(given, with_values(drive, changed), prepared))
    assert sum(map(np.isfinite, powers)) >= 5
    assert found.best.power <= min(powers)


def test_values_of_a_machine_are_tried_each_with_the_whole_search(slow):
    study, path = loaded("two_joint_arm"), "drives.two-motors.pulley_radius"
    options = {"drive": "two-motors", "sets": slow, "objective": "energy"}
    found = iv.size(study, tries={path: [0.04, 0.06, 0.08]}, **options)
    apart = {}
    for one in found.searches["two-motors"].tried:
        changed = with_values(study.drives["two-motors"], {"pulley_radius": one.value})
        there = iv.size(replace(study, drives={"two-motors": changed}), **options).best
        apart[one.value] = there.power
        assert one.power == pytest.approx(there.power, rel=1e-12)
    assert found.best.power == min(apart.values())
    assert apart[found.best.free["pulley_radius"].value] == found.best.power
    again = found.study_of(found.best).drives["two-motors"]
    assert again.pulley_radius == found.best.free["pulley_radius"].value


@pytest.mark.slow
def test_carts_on_wheels_of_known_geometry_are_sized(slow):
    """Pushed or driven, by preload and radii of the wheels; random designs are not better."""
    roller = loaded("sphere_joint").drives["tetrahedral"].roller
    pushed, driven = loaded("planar_cart"), loaded("driven_cart")
    light = replace(driven.tasks["corner"], wrench=iv.motion.Wrench(x=20.0), box=None, time_share=1.0)
    carts = {
        "two-wheels": replace(pushed, drives={"two-wheels": replace(pushed.drives["two-wheels"], wheel=roller)}),
        "rear": replace(
            driven, drives={"rear": replace(driven.drives["rear"], wheel=roller)}, tasks={"corner": light}, paths={}
        ),
    }
    ranges = {"preload": (300.0, 2000.0), "wheel_radius": (0.02, 0.04), "crown_radius": (0.008, 0.016)}
    random = np.random.default_rng(5)
    for name, study in carts.items():
        found = iv.size(study, drive=name, ranges=ranges, generations=8, objective="energy")
        assert found.best.power == pytest.approx(judged(study, found.best.drive), rel=1e-9)
        tried = [
            {f"wheel.{key}": random.uniform(*ends) for key, ends in ranges.items() if key != "crown_radius"}
            for _ in range(60)
        ]
        assert found.best.power <= min(judged(study, with_values(study.drives[name], one)) for one in tried)

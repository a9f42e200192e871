"""Builds of the designs of a search: against single drives made by hand, and closed forms of one limit."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.special import ndtr

import infinivar as iv
from infinivar import Uncertainty, doubt
from internals import (
    FRICTION,
    TORQUE_CONSTANT,
    ChosenPart,
    SizedDrive,
    decisive,
    default_spread_rules,
    judged_designs,
    tasks_of,
    value_at,
    varied_of,
)
from internals import GearedLaws as Laws
from internals import builds_interval as interval
from internals import built_rows as built
from internals import compiled_structure as structure
from internals import draw_builds as draw
from internals import judge_builds as judge
from made import loaded
from sampled import sampled

SLIDE = {
    "duty": {
        "shake": {"shape": "sinusoid", "distance": "60 mm", "frequency": "3 Hz", "load_mass": "1 kg"},
        "slow": {"shape": "sinusoid", "distance": "30 mm", "frequency": "2 Hz", "load_mass": "2 kg"},
    },
    "requirement": {"force": "20 N", "speed": "0.3 m/s"},
    "drives": {
        "geared": {
            "type": "conventional",
            "output_inertia": "0.02 g m^2",
            "motor": {"part": "dcx-32-l-24v"},
            "gearhead": {"part": "gpx-32-up-16", "loss_model": "coulomb"},
            "pulley": {"radius": "8 mm"},
            "guideway": {"friction": "2 N"},
        }
    },
}
KNEE = loaded("knee_walking")
WALKING = replace(KNEE, requirement=None)


def study_with(**more):
    return iv.Study.from_dict({**SLIDE, **more}, name="slide")


def sized(study, name, **parts):
    """A drive of a study as if a search had found it; parts by role, as names."""
    chosen = {role.replace("_", "."): ChosenPart(set="s", key=key, name=key) for role, key in parts.items()}
    power = np.mean([iv.duty_cycle(study.drives[name], one).power_in for one in study.duty.values()])
    return SizedDrive(
        template=name,
        parts=chosen,
        free={},
        drive=study.drives[name],
        mass=1.0,
        power=power,
        volume=math.nan,
        price=None,
        demands={},
        unchecked=(),
    )


@pytest.fixture(scope="module")
def sizing(shelf):
    return iv.size(study_with(), sets=shelf, radius=(0.003, 0.03))


@pytest.fixture(scope="module")
def doubted(sizing):
    return doubt(sizing, builds=256)


def tasks_for(study, drive):
    return tasks_of(drive, study.duty, study.requirement, travel=study.travel, samples=None)


@pytest.mark.slow
def test_the_nominal_build_has_the_numbers_of_the_design(sizing):
    shares = {"shake": 0.5, "slow": 0.5}
    for design in (*sizing.designs, *sizing.front):
        motor, gear = design.drive.motor, design.drive.gearhead
        as_stated = {
            "motor.torque_constant": np.array([[motor.torque_constant]]),
            "motor.resistance": np.array([[motor.resistance]]),
            "gearhead.efficiency": np.array([[gear.efficiency]]),
        }
        for values in ({}, as_stated):
            tasks = decisive(design.drive, tasks_for(sizing.study, design.drive), values)
            found = judge(Laws(built(design.drive, values), 1), tasks, shares)
            assert found.power[0] == pytest.approx(design.power, rel=1e-9)
            assert found.feasible[0]
            for key, demand in design.demands.items():
                if key[0] == "structure":  # the same in every build
                    continue
                assert found.demands[key][0] == pytest.approx(demand, rel=1e-9)


def test_a_specimen_keeps_friction_heat_and_peak_current():
    faulhaber = iv.parts.Motor(
        voltage=24.0,
        resistance=2.0,
        torque_constant=0.024,
        no_load_current=0.05,
        viscous_friction=4e-7,
        continuous_torque=0.03,
        peak_torque=0.1,
    )
    dc = replace(faulhaber, viscous_friction=None)
    for motor in (faulhaber, dc):
        same = motor.specimen(torque_constant=motor.torque_constant, resistance=motor.resistance)
        for name in ("no_load_current", "continuous_torque", "peak_torque"):
            assert getattr(same, name) == pytest.approx(getattr(motor, name), rel=1e-12)
        weak = motor.specimen(torque_constant=0.02, resistance=2.5)
        assert weak.friction_torque == pytest.approx(motor.friction_torque, rel=1e-12)
        assert weak.resistance * weak.continuous_current**2 == pytest.approx(
            motor.resistance * motor.continuous_current**2, rel=1e-12
        )
        peak = motor.peak_torque / motor.torque_constant + motor.no_load_current
        assert weak.peak_torque / weak.torque_constant + weak.no_load_current == pytest.approx(peak, rel=1e-12)
        assert weak.continuous_torque < motor.continuous_torque
        # The no-load speed needs just the no-load current.
        idle = weak.operate(torque=0.0, speed=weak.no_load_speed)
        assert idle.voltage == pytest.approx(weak.voltage, rel=1e-12)
        assert idle.current == pytest.approx(weak.no_load_current, rel=1e-12)


def by_hand(drive, values):
    """A build of a geared drive with thermal data, part by part."""
    others = ("no_load_current", "winding_to_housing", "housing_time_constant")
    motor, gear = replace(drive.motor, **{name: values[f"motor.{name}"] for name in others}), drive.gearhead
    constant, ohms = values["motor.torque_constant"], values["motor.resistance"]
    friction = motor.torque_constant * motor.no_load_current
    current = motor.continuous_torque / motor.torque_constant + motor.no_load_current
    made = replace(
        motor,
        torque_constant=constant,
        resistance=ohms,
        no_load_current=friction / constant,
        continuous_torque=constant * current * (motor.resistance / ohms) ** 0.5 - friction,
    )
    geared = replace(gear, efficiency=values["gearhead.efficiency"], rated_torque=motor.continuous_torque)
    return replace(drive, motor=made, gearhead=geared, **{"guideway": values.get("guideway", drive.guideway)})


@pytest.mark.slow
def test_geared_builds_are_those_of_duty_cycle():
    """Some builds exceed the continuous torque, some the voltage; temperatures of windings count."""
    tables = {"geared": {**SLIDE["drives"]["geared"], "pulley": {"radius": "22 mm"}}}
    duty = {"shake": {**SLIDE["duty"]["shake"], "load_mass": "1 kg"}}
    study = study_with(duty=duty, drives=tables, uncertainty={"geared": {"guideway.friction": "20 %"}})
    study = replace(study, requirement=None)
    design = sized(study, "geared", motor="m", gearhead="g")
    count = 256
    found = judged_designs(study, {"one": design}, builds=count).designs[0]
    values = draw([design], study.uncertainty, count).values[0]
    of_motor = {"torque_constant", "resistance", "no_load_current", "winding_to_housing", "housing_time_constant"}
    assert set(values) == {*(f"motor.{name}" for name in of_motor), "gearhead.efficiency", "guideway.friction"}
    duty = study.duty["shake"]
    feasible, power = [], []
    for place in range(200):
        one = {path: float(column[place]) for path, column in values.items()}
        one["guideway"] = replace(design.drive.guideway, friction=one.pop("guideway.friction"))
        cycle = iv.duty_cycle(by_hand(design.drive, one), duty)
        feasible.append(cycle.feasible)
        power.append(cycle.power_in)
    assert 20 < sum(feasible) < 180
    np.testing.assert_array_equal(found.feasible[:200], feasible)
    np.testing.assert_allclose(found.power[:200], power, rtol=1e-9)


@pytest.mark.slow
def test_cobotic_builds_are_those_of_duty_cycle():
    """Both motors, the gearhead and the friction coefficient, at a preload near slip."""
    drive = KNEE.drives["cobotic"]
    study = replace(WALKING, drives={"cobotic": replace(drive, transmission=drive.transmission.pressed(1450.0))})
    design = sized(study, "cobotic", motor="m", gearhead="g", steering_motor="m")
    count, duty = 16, study.duty["walking"]
    found = judged_designs(study, {"one": design}, builds=count).designs[0]
    values = draw([design], study.uncertainty, count).values[0]
    assert len(values) == 12
    # The same type of motor, but not the same motor.
    ohms = [values[f"{path}.resistance"] / value_at(drive, path).resistance for path in ("motor", "steering.motor")]
    assert np.all(ohms[0] != ohms[1])
    feasible, power = [], []
    for place in range(count):
        one = {path: float(column[place]) for path, column in values.items()}
        made = by_hand(study.drives["cobotic"], one)
        of_steering = {
            path.removeprefix("steering."): value for path, value in one.items() if path.startswith("steering.")
        }
        steering = by_hand(
            replace(made, motor=made.steering.motor), {**of_steering, "gearhead.efficiency": one["gearhead.efficiency"]}
        ).motor
        made = replace(
            made,
            steering=replace(made.steering, motor=steering),
            transmission=replace(made.transmission, friction=one["transmission.friction"]),
        )
        cycle = iv.duty_cycle(made, duty)
        feasible.append(cycle.feasible)
        power.append(cycle.power_in)
    assert 2 < sum(feasible) < 14
    np.testing.assert_array_equal(found.feasible, feasible)
    np.testing.assert_allclose(found.power, power, rtol=1e-9)


def test_a_gear_of_another_efficiency_loses_more_in_both_directions():
    """Losses of both directions stay in proportion, as one friction causes them."""
    drive = KNEE.drives["geared"]
    gear = replace(drive.gearhead, loss_model="proportional", efficiency=0.8, backdriving_efficiency=0.7)
    efficiencies = np.array([[0.8], [0.76], [0.9], [0.2]])
    made = built(replace(drive, gearhead=gear), {"gearhead.efficiency": efficiencies})
    np.testing.assert_allclose(np.ravel(made.gearhead.backdriving_efficiency), [0.7, 0.64, 0.85, 0.0], rtol=1e-12)


@pytest.mark.slow
def test_share_of_one_limit_is_that_of_its_distribution():
    """Continuous torque with a lossless gear: the demand is D0 (K0/K) sqrt(R/R0), a function of two independent values."""
    motor = {
        "voltage": "48 V",
        "resistance": "2 ohm",
        "torque_constant": "30 mN m/A",
        "no_load_current": "0 A",
        "continuous_torque": "30 mN m",
        "rotor_inertia": "10 g cm^2",
    }
    geared = {**SLIDE["drives"]["geared"], "motor": motor, "gearhead": {"ratio": 5, "efficiency": 1.0}}
    for mass in ("0.5 kg", "0.56 kg"):
        duty = {"shake": {**SLIDE["duty"]["shake"], "load_mass": mass}}
        study = replace(study_with(duty=duty, drives={"geared": geared}), requirement=None)
        design = sized(study, "geared", motor="m", gearhead="g")
        found = judged_designs(study, {"one": design}, builds=4096)
        (weakest,) = found.designs[0].exceeded
        assert weakest[1] is iv.Limit.THERMAL
        demand = next(
            value
            for key, value in iv.duty_cycle(design.drive, study.duty["shake"]).demands.items()
            if key[0] == weakest[1]
        )
        # P(R/R0 <= (K/(K0 D0))^2) over K, which is uniform; R is normal.
        ratio = np.linspace(1.0 - TORQUE_CONSTANT, 1.0 + TORQUE_CONSTANT, 20001)
        below = ndtr(((ratio / demand) ** 2 - 1.0) / default_spread_rules()["resistance"].size)
        exact = np.trapezoid(below, ratio) / (ratio[-1] - ratio[0])
        assert 0.05 < exact < 0.95
        low, high = found.designs[0].interval
        assert low < exact < high
        assert found.designs[0].share == pytest.approx(exact, abs=0.002)


@pytest.mark.slow
def test_share_of_slipping_wheels_is_that_of_the_friction_coefficient():
    """Slip alone, found by bisection over the friction coefficient, and the distribution function there."""
    drive = KNEE.drives["cobotic"]
    study = replace(WALKING, drives={"cobotic": replace(drive, transmission=drive.transmission.pressed(1450.0))})
    design = sized(study, "cobotic", motor="m", gearhead="g", steering_motor="s")
    duty, drive = study.duty["walking"], design.drive

    def slips(friction):
        made = replace(drive, transmission=replace(drive.transmission, friction=friction))
        return iv.duty_cycle(made, duty, samples=500).demands[iv.Limit.SLIP, "wheel"] > 1.0

    nominal = drive.transmission.friction
    low, high = nominal * (1.0 - FRICTION), nominal * (1.0 + FRICTION)
    assert slips(low)
    assert not slips(high)
    ends = [low, high]
    for _ in range(14):
        middle = 0.5 * sum(ends)
        ends[0 if slips(middle) else 1] = middle
    share = (high - ends[1]) / (high - low)
    at = draw([design], study.uncertainty, 64).values[0]["transmission.friction"]
    tasks = tasks_of(drive, study.duty, None, travel=None, samples=500)
    found = judge(Laws(built(drive, {"transmission.friction": at[:, None]}), 64), tasks, {"walking": 1.0})
    beyond = found.exceeded["walking", iv.Limit.SLIP, "wheel"]
    np.testing.assert_array_equal(beyond, at < ends[1])
    assert 0.1 < share < 0.9
    assert np.mean(~beyond) == pytest.approx(share, abs=0.03)
    # Beyond slip there is no steady rolling: what motors would need has no value, and is no second fault.
    assert np.mean(np.isnan(found.power[beyond])) > 0.8
    assert np.isfinite(found.power[~beyond]).all()
    assert not any((one & beyond).any() for key, one in found.exceeded.items() if key[1] is iv.Limit.THERMAL)


@pytest.mark.slow
def test_the_region_is_decided_by_few_points(sizing):
    knee = replace(KNEE, duty={})
    cases = [
        (sizing.study, sizing.designs[0]),
        (knee, sized(KNEE, "cobotic", motor="m", gearhead="g", steering_motor="s")),
    ]
    for study, design in cases:
        region = tasks_for(replace(study, duty={}), design.drive)
        values = draw([design], study.uncertainty, 16).values[0]
        fewer = decisive(design.drive, region, values)
        assert len(fewer[0].speed) < 0.05 * len(region[0].speed)
        for place in (0, 11):
            one = built(design.drive, {path: float(column[place]) for path, column in values.items()})
            some, every = (judge(Laws(one, 1), tasks, {}).demands for tasks in (fewer, region))
            assert {*some} == {*every}
            for key, demand in every.items():
                np.testing.assert_allclose(some[key], demand, rtol=1e-9)


@pytest.mark.slow
def test_designs_with_one_part_share_its_samples(sizing):
    draws = draw(sizing.designs, sizing.study.uncertainty, 64)
    owners = {owner for owner, _ in draws.varied}
    assert owners == {f"{role} {part.part}" for one in sizing.designs for role, part in one.parts.items()}
    seen = {}
    for design, values in zip(sizing.designs, draws.values, strict=True):
        for role, path in (("motor", "motor.resistance"), ("gearhead", "gearhead.efficiency")):
            relative = values[path] / value_at(design.drive, path)
            other = seen.setdefault(design.parts[role].part, relative)
            np.testing.assert_array_equal(relative, other)
    unlike = [np.round(one, 12).tolist() for one in seen.values()]
    assert len({tuple(one) for one in unlike}) == len(unlike)
    again = draw(sizing.designs, sizing.study.uncertainty, 64)
    np.testing.assert_array_equal(again.values[0]["motor.resistance"], draws.values[0]["motor.resistance"])


def test_spreads_of_the_study_come_first_and_carry_over_to_other_parts(sizing):
    spread = {
        "motor": {"torque_constant": "2 %", "resistance": {"deviation": "3 %"}},
        "gearhead.efficiency": {"low": 0.70, "high": 0.80},
        "pulley.radius": "1 %",
        "guideway.friction": "0.5 N",
    }
    tables = {**SLIDE["drives"]["geared"], "gearhead": {"ratio": 16, "efficiency": 0.75, "mass": "0.1 kg"}}
    study = study_with(
        drives={"geared": tables},
        uncertainty={"geared": spread},
        correlations=[{"drive": "geared", "between": ["motor.torque_constant", "guideway.friction"], "value": 0.8}],
    )
    design = sizing.designs[0]
    assert {*design.free} == {"pulley.radius"}
    rows = {one.spread.path: one for one in varied_of(design, study.uncertainty)}
    assert {path for path, one in rows.items() if one.assumed} == {"motor.no_load_current"}
    motor, gear = design.drive.motor, design.drive.gearhead
    constant = rows["motor.torque_constant"].spread
    assert (constant.low, constant.high) == pytest.approx((0.98 * motor.torque_constant, 1.02 * motor.torque_constant))
    assert rows["motor.resistance"].spread.deviation == pytest.approx(0.03 * motor.resistance)
    lost = 1.0 - gear.efficiency
    ends = rows["gearhead.efficiency"].spread
    assert (1.0 - ends.low, 1.0 - ends.high) == pytest.approx((1.2 * lost, 0.8 * lost))
    assert rows["pulley.radius"].owner == rows["guideway.friction"].owner == "geared"
    assert rows["guideway.friction"].spread.low == pytest.approx(1.5)
    assert rows["pulley.radius"].spread.high == pytest.approx(1.01 * design.drive.pulley.radius)
    values = draw([design, *sizing.designs[1:]], study.uncertainty, 1024).values
    found = np.corrcoef(values[0]["motor.torque_constant"], values[0]["guideway.friction"])[0, 1]
    assert found == pytest.approx(0.8, abs=0.03)
    for one in values[1:]:
        np.testing.assert_array_equal(one["guideway.friction"], values[0]["guideway.friction"])


def test_default_spreads_are_those_of_the_rules(sizing):
    rules = default_spread_rules()
    rows = varied_of(sizing.designs[0], Uncertainty())
    assert all(one.assumed for one in rows)
    found = {one.spread.path: one.spread for one in rows}
    constant, resistance, loss = (
        found[name] for name in ("motor.torque_constant", "motor.resistance", "gearhead.efficiency")
    )
    assert constant.high / constant.value - 1.0 == pytest.approx(TORQUE_CONSTANT)
    assert resistance.deviation == pytest.approx(rules["resistance"].size * resistance.value)
    law = sizing.designs[0].drive.gearhead.loss_model
    assert loss.deviation == pytest.approx(rules[f"efficiency.{law}"].size * (1.0 - loss.value))
    assert loss.high <= 1.0
    assert [one.kind for one in (constant, resistance, loss)] == ["assumed", "derived", "derived"]
    assert "parsons2019" in resistance.where
    assert "duclusaud2025" in loss.where


def test_the_best_of_each_build_is_the_best_of_the_feasible(sizing, doubted):
    power = np.stack([np.where(one.feasible, one.power, np.inf) for one in doubted.designs])
    best = np.where(np.isinf(power.min(axis=0)), -1, power.argmin(axis=0))
    assert [one.best for one in doubted.designs] == [np.sum(best == place) for place in range(len(power))]
    assert doubted.none == np.sum(best == -1)
    assert sum(one.best for one in doubted.designs) + doubted.none == doubted.count == 256
    assert [one.best for one in doubted.runners_up] == sorted(
        (one.best for one in doubted.designs[1:] if one.best), reverse=True
    )
    assert [one.name for one in doubted.designs[:2]] == ["design-01", "design-02"]
    by_mass = judged_designs(
        sizing.study, {one.title: one for one in sizing.designs[::-1]}, objective="mass", builds=64
    )
    masses = [one.mass for one in sizing.designs[::-1]]
    feasible = np.stack([one.feasible for one in by_mass.designs])
    rank = np.where(feasible, np.where(np.isnan(masses), np.inf, masses)[:, None], np.inf)
    first = np.where(feasible.any(axis=0), rank.argmin(axis=0), -1)
    assert [one.best for one in by_mass.designs] == [np.sum(first == place) for place in range(len(masses))]


def test_one_design_in_both_lists_is_judged_once(sizing, doubted):
    for design, one in zip(sizing.front[:5], doubted.front, strict=True):  # so many are judged
        for other, same in zip(sizing.designs, doubted.designs, strict=True):
            if other.parts == design.parts and other.free["pulley.radius"].value == design.free["pulley.radius"].value:
                np.testing.assert_array_equal(one.power, same.power)


@sampled("name", ["geared", "cobotic"], slow=2)
def test_compiled_builds_are_the_same(name):
    """Designs that differ in all that a search chooses are computed by one compiled function."""
    pytest.importorskip("jax")
    drive = KNEE.drives[name]
    other = replace(drive, motor=replace(drive.motor, resistance=1.1 * drive.motor.resistance, max_speed=2000.0))
    if name == "cobotic":
        element = drive.transmission
        axle = replace(
            element.geometry.axle_bearing, name="larger", bore=0.012, outside_diameter=0.028, static_rating=2360.0
        )
        geometry = replace(element.geometry, axle_bearing=axle, crown_radius=0.9 * element.geometry.crown_radius)
        other = replace(
            other,
            cylinder_speed=1.02 * drive.cylinder_speed,
            transmission=replace(element, geometry=geometry, preload=1.1 * element.preload, wheel_radius=0.02),
        )
    else:
        other = replace(other, pulley=replace(drive.pulley, radius=1.1 * drive.pulley.radius))
    assert structure(drive) == structure(other)
    parts = {"motor": "m", "gearhead": "g", **({"steering_motor": "s"} if name == "cobotic" else {})}
    designs = {
        f"m{place}": sized(replace(WALKING, drives={name: one}), name, **{**parts, "motor": f"m{place}"})
        for place, one in enumerate((drive, other))
    }
    plain, fast = (judged_designs(WALKING, designs, builds=128, compiled=compiled) for compiled in (False, True))
    assert plain.designs[0].nominal != plain.designs[1].nominal
    for one, same in zip(plain.designs, fast.designs, strict=True):
        np.testing.assert_allclose(same.power, one.power, rtol=1e-11)
        np.testing.assert_array_equal(same.feasible, one.feasible)
        assert same.exceeded == one.exceeded


def test_interval_is_the_exact_binomial_one():
    from scipy.stats import binomtest

    for number, count in ((0, 64), (64, 64), (13, 256), (250, 256)):
        exact = binomtest(number, count).proportion_ci(0.95, method="exact")
        assert interval(number, count) == pytest.approx((exact.low, exact.high), abs=1e-12)


def test_words_and_numbers_of_the_result(doubted, sizing):
    winner = doubted.designs[0]
    assert doubted.verdict.startswith(f"{sizing.best.title}: feasible in ")
    assert "least energy of" in doubted.verdict
    assert replace(doubted, none=64).verdict.endswith("; no design is feasible in 25 %")
    assert "no design" not in replace(doubted, none=0).verdict
    assert "no design" not in replace(doubted, none=64, designs=doubted.designs[:1]).verdict
    table = doubted.to_dict()
    assert table["builds"] == 256
    assert table["designs"][0]["feasible"] == winner.share
    assert table["designs"][0]["power_W"]["nominal"] == sizing.best.power
    assert winner.band["low"] < sizing.best.power < winner.band["high"]
    assert doubted.assumed == (
        "winding resistance ± 12 % (95 %, parsons2019)",
        "torque constant ± 5 %",
        "no-load current with constant friction ± 29 % (95 %, robotino2026)",
        "coulomb gear loss ± 78 % (95 %, duclusaud2025)",
    )
    assert doubted.stated == ()
    assert "verdict" in repr(doubted)
    rows = doubted.to_dataframe()
    assert list(rows["feasible"]) == [one.share for one in (*doubted.designs, *doubted.front)]
    counts = list(winner.exceeded.values())
    assert counts == sorted(counts, reverse=True)


def test_wrong_arguments_are_refused(sizing):
    for builds in (100, 8, True, 2**21):
        with pytest.raises(iv.ParameterError, match="builds must be a power of two from 16 to 1048576"):
            doubt(sizing, builds=builds)
    with pytest.raises(iv.InputError, match="nothing to judge"):
        doubt(replace(sizing, designs=()))
    designs = {"one": sizing.best}
    with pytest.raises(iv.InputError, match="needs a motion"):
        judged_designs(replace(sizing.study, duty={}), designs)
    with pytest.raises(iv.ParameterError, match="objective must be energy, mass, space or price"):
        judged_designs(sizing.study, designs, objective="speed")


def test_a_value_without_spread_is_constant(sizing):
    design = sizing.designs[0]
    lossless = replace(design, drive=replace(design.drive, gearhead=replace(design.drive.gearhead, efficiency=1.0)))
    assert "gearhead.efficiency" not in {one.spread.path for one in varied_of(lossless, Uncertainty())}

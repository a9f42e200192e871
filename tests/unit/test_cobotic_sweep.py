"""The search over cobotic drives from many starts: the best of what each start finds alone."""

import re
from dataclasses import replace

import numpy as np
import pytest

import infinivar as iv
from internals import CoboticRequest, size_cobotic
from made import loaded
from part_tables import part_tables

pytestmark = pytest.mark.slow

KNEE = loaded("knee_walking")
DRIVE = KNEE.drives["cobotic"]
AXLE = DRIVE.transmission.geometry.axle_bearing
AXLES = (AXLE, replace(AXLE, name="6001", bore=0.012, dynamic_rating=5400.0, static_rating=2360.0))
STARTS = 2


def arguments():
    motors, gears, pairs = part_tables(1, 4, 3)
    gears = {**gears, "ratio": np.linspace(25.0, 80.0, 3)}
    gears |= {name: 4.0 * gears[name] for name in ("continuous_torque", "intermittent_torque")}
    return {
        "motors": motors,
        "gearheads": gears,
        "pairs": pairs,
        "steering_motors": part_tables(2, 3)[0],
        "steering_ratios": (8.0, 16.0),
        "bearings": AXLES,
        "duty": KNEE.duty,
        "samples": 40,
        "population": 5,
        "generations": 2,
    }


def prepared(starts=STARTS, **change):
    """The sweep over the drives of a study, but with smaller tables."""
    given = {**arguments(), **change}
    problem = iv.sweeps.cobotic_study_sweep(KNEE, starts=starts, sets="shipped", generations=given["generations"])
    return replace(problem, request=CoboticRequest(template=DRIVE, ranges={}, top=50, **given))


@pytest.fixture(scope="module")
def problem():
    return prepared()


@pytest.fixture(scope="module")
def swept(problem, tmp_path_factory):
    return iv.sweep(problem, tmp_path_factory.mktemp("swept") / "s")


@pytest.fixture(scope="module")
def alone():
    return [size_cobotic(DRIVE, **arguments(), seed=seed, top=50) for seed in range(STARTS)]


def parts_of(one):
    return one.pair, one.bearing, one.wheels, one.steering, one.ratio


def test_designs_are_the_best_of_each_start(problem, swept, alone):
    found = problem.result(swept)
    expected = {}
    for one in sorted((one for start in alone for one in start.designs), key=lambda one: one.power):
        expected.setdefault(parts_of(one), one)
    assert len({one.power for start in alone for one in start.designs[:1]}) == STARTS
    assert [parts_of(one) for one in found.designs] == list(expected)
    for one, other in zip(found.designs, expected.values(), strict=True):
        assert (one.mass, one.power) == pytest.approx((other.mass, other.power), rel=1e-12)
        assert one.values == pytest.approx(other.values, rel=1e-12)
        assert one.demands == pytest.approx(other.demands, rel=1e-9)
        assert one.drive.motor == other.drive.motor
        assert (one.motor, one.gearhead) == (other.motor, other.gearhead)
        assert one.drive.steering.motor == other.drive.steering.motor
    assert swept.candidates == sum(start.drives for start in alone)
    assert swept.counts["wheels"] == sum(start.wheels for start in alone)


def test_designs_are_made_from_what_the_chunks_keep(problem, swept, monkeypatch):
    """No start runs again, and each design is the drive that was judged: its power is that of `duty_cycle`."""

    def again(*arguments, **options):
        raise AssertionError("searched again")

    monkeypatch.setattr("infinivar.sweeps.cobotic.best_cobotic", again)
    found = problem.result(swept)
    rows = swept.list("top")
    assert len(found.designs) == len(rows["list"]) > 1
    np.testing.assert_array_equal(rows["power_W"], [one.power for one in found.designs])
    for one in found.designs[:3]:
        cycle = iv.duty_cycle(one.drive, KNEE.duty["walking"], samples=40)
        assert cycle.feasible
        assert cycle.power_in == pytest.approx(one.power, rel=1e-9)
        for key, demand in cycle.demands.items():
            assert one.demands["walking", *key] == pytest.approx(demand, rel=1e-6)
    files = sorted(swept.folder.glob("chunk-*.parquet"))
    assert len(files) == STARTS
    assert max(file.stat().st_size for file in files) < 30_000


def test_no_design_of_the_front_is_beaten_by_any_start(problem, swept, alone):
    found = problem.result(swept)
    known = np.array([(one.mass, one.power) for start in alone for one in start.front])
    mine = np.array([(one.mass, one.power) for one in found.front])
    for mass, power in mine:
        assert not ((known <= [mass * (1 - 1e-9), power * (1 - 1e-9)]).all(axis=1)).any()
    for mass, power in known:
        # Of designs within 3 % of the mass of another one the front lists one.
        assert ((mine <= [1.07 * mass, 1.02 * power]).all(axis=1)).any()


def test_designs_and_counts_are_in_words_with_units(problem, swept):
    """Each value of the best row is told with its unit, each limit in words."""
    best, (verdict, *lines) = swept.list("top"), list(swept.lines(1))
    said = lines[1]
    assert problem.verdict(swept) == f"least energy from {STARTS} starts: {said.removeprefix('  1. ')}"
    for name, unit, scale in (("cylinder_radius", "mm", 1e3), ("preload", "N", 1.0), ("cylinder_speed", "rad/s", 1.0)):
        (value,) = re.findall(rf"{name.replace('_', ' ')} (\S+) {unit};", said)
        assert float(value) == pytest.approx(scale * best[name][0], rel=1e-3)
    assert f"{swept.candidates:,} candidates" in verdict
    assert "infeasible wheel designs by their tightest limit:" in lines
    blocked = swept.counts["blocked"]
    counted = [
        line for line in lines if re.match(r"  (wheel slip|contact yield|bearing|axle|clearance|cylinder)", line)
    ]
    assert [int(line.rpartition(": ")[2].replace(",", "")) for line in counted] == list(blocked.values())
    assert not re.search(r"demand|YIELD|SLIP|_", "".join(lines))


def test_more_starts_or_other_values_do_not_continue_a_sweep(swept):
    for starts, change, message in (
        (3, {}, "chunks: 2 there, 3 here"),
        (STARTS, {"generations": 3}, "options: the content differs"),
        (STARTS, {"bearings": AXLES[:1]}, "parts: the content differs"),
    ):
        other = prepared(starts, **change)
        with pytest.raises(iv.InputError, match=message):
            iv.sweep(other, swept.folder, resume=True)


def test_a_sweep_has_a_start():
    with pytest.raises(iv.ParameterError, match="starts must be >= 1, got 0"):
        iv.sweeps.cobotic_study_sweep(KNEE, starts=0)


def test_a_study_is_searched_with_the_arguments_of_size(tmp_path):
    problem = iv.sweeps.cobotic_study_sweep(KNEE, starts=2, sets="shipped", generations=3)
    assert problem.title == "knee_walking, cobotic drives like cobotic"
    assert problem.request.template == DRIVE
    given = problem.request
    assert given.duty == KNEE.duty
    assert given.slip_margin == 1.1
    assert given.generations == 3
    assert len(given.steering_ratios) == 5
    assert len(given.bearings) > 5
    chosen = {"ranges": {"preload": (800.0, 3000.0)}, "steering_ratios": (8.0, 12.0), "slip_margin": 1.3, "life": 3.6e6}
    given = iv.sweeps.cobotic_study_sweep(KNEE, starts=2, sets="shipped", **chosen).request
    assert {name: getattr(given, name) for name in chosen} == chosen
    for wrong, message in (
        ({"ranges": {"preloads": (1.0, 2.0)}}, r"unknown entry 'preloads' \(did you mean 'preload'\?\)"),
        ({"ranges": {"preload": (2.0, 1.0)}}, r"ranges\['preload'\] must be a range above 0"),
        ({"steering_ratios": (8.0, 8.0)}, "steering_ratios must be one ratio or several different ones"),
    ):
        with pytest.raises((iv.InputError, iv.ParameterError), match=message):
            iv.sweeps.cobotic_study_sweep(KNEE, starts=2, sets="shipped", **wrong)
    with pytest.raises(iv.InputError, match=r"no cobotic drive that can be a template: drives\.geared is not one"):
        iv.sweeps.cobotic_study_sweep(KNEE, starts=2, drive="geared")

"""What would have to change for another drive to win: against the public analyses at the values found."""

import math
import re
from dataclasses import replace
from html import unescape

import numpy as np
import pytest

import infinivar as iv
from infinivar import Limit
from internals import (
    STEERING_MOTOR,
    SizedDrive,
    change_words,
    exceeded_words,
    levers,
    parse,
    value_at,
    what_if,
    with_rated_gear,
    with_values,
)
from internals import sizing_html as html
from internals import sizing_text as text
from made import loaded
from sampled import sampled
from small_catalogue import SHELF

KNEE = loaded("knee_walking")
WALKING = replace(KNEE, requirement=None)
WALK = KNEE.duty["walking"]


_FIELDS = {"continuous_torque": "motor continuous torque", "voltage": "supply voltage"}


def sized(name, mass=0.3, drive=None):
    """A drive of the study as if a search had found it."""
    drive = KNEE.drives[name] if drive is None else drive
    cycle = iv.duty_cycle(drive, WALK, travel=KNEE.travel)
    return SizedDrive(
        template=name,
        parts={},
        free={},
        drive=drive,
        mass=mass,
        volume=math.nan,
        price=None,
        power=cycle.power_in,
        demands={("walking", *key): demand for key, demand in cycle.demands.items()},
        unchecked=(),
    )


def remedies(loser, winner, aim="energy", study=WALKING):
    return what_if(study, aim, {"geared": loser, "cobotic": winner}, {}, 1.0)


@pytest.mark.slow
def test_at_the_value_found_the_loser_draws_what_the_winner_does():
    """Each change that is enough, by `duty_cycle` of the drive with that value; one that is not at the end of its range."""
    loser, winner = sized("geared"), sized("cobotic")
    assert loser.power > winner.power
    (one,) = remedies(loser, winner).values()
    assert one.template == "geared"
    assert (one.target, one.present) == (winner.power, loser.power)
    by_words = {lever.words: lever for lever in levers(loser, "energy")}
    assert set(by_words) == {change.words for change in one.changes}
    enough = [change for change in one.changes if change.enough]
    assert len(enough) >= 3
    for change in one.changes:
        made = by_words[change.words].made
        if change.enough:
            assert iv.duty_cycle(made(loser.drive, change.needed), WALK).power_in == pytest.approx(
                winner.power, rel=1e-4
            )
            before = change.needed + 0.01 * (change.start - change.needed)
            assert iv.duty_cycle(made(loser.drive, before), WALK).power_in > winner.power
        else:
            cycle = iv.duty_cycle(made(loser.drive, change.end), WALK, travel=KNEE.travel)
            assert cycle.power_in > winner.power or not cycle.feasible
            assert math.isnan(change.best) or winner.power < change.best <= loser.power * (1.0 + 1e-9)


@pytest.mark.slow
def test_a_factor_from_the_parts_of_the_energy():
    """Power that is returned comes from the supply no more: the share follows from what the brake resistor burns."""
    loser = sized("geared")
    point = iv.duty_cycle(loser.drive, WALK).point
    burnt = float(np.mean(point.losses["amplifier"]))
    target = replace(loser, template="cobotic", power=loser.power - 0.3 * burnt)
    change = next(one for one in remedies(loser, target)["geared"].changes if one.words.startswith("share of braking"))
    assert change.needed == pytest.approx(0.3, rel=1e-4)
    assert math.isnan(change.factor)


@pytest.mark.full
def test_changes_of_a_cobotic_drive():
    loser, winner = sized("cobotic"), replace(sized("geared"), power=0.93 * sized("cobotic").power)
    (one,) = what_if(WALKING, "energy", {"cobotic": loser, "geared": winner}, {}, 1.0).values()
    assert one.template == "cobotic"
    by_words = {lever.words: lever for lever in levers(loser, "energy")}
    enough = [change for change in one.changes if change.enough]
    assert any("preload lowered" in change.words for change in enough)
    assert any("axle bearings" in change.words for change in enough)
    for change in enough:
        drive = by_words[change.words].made(loser.drive, change.needed)
        cycle = iv.duty_cycle(drive, WALK, travel=KNEE.travel)
        assert cycle.feasible
        assert cycle.power_in == pytest.approx(winner.power, rel=1e-4)


def test_what_is_asked_of_an_output_is_found_once(monkeypatch):
    """The values looked at are of motors and gears; a series spring would be another output."""
    asked, find = [], type(WALKING).service
    monkeypatch.setattr(type(WALKING), "service", lambda study, drive: asked.append(drive) or find(study, drive))
    remedies(sized("geared"), sized("cobotic"))
    outputs = {(one.output, one.structure.travel) for one in asked}
    assert 0 < len(asked) == len(outputs)


@pytest.mark.slow
def test_limits_are_kept_at_the_value_found():
    """More torque constant saves current but needs voltage: the supply decides, and the value is refused."""
    drive = KNEE.drives["geared"]
    tight = replace(drive, motor=replace(drive.motor, voltage=17.7))
    loser = sized("geared", drive=tight)
    assert loser.margin >= 1.0
    target = replace(loser, template="cobotic", power=0.97 * loser.power)
    change = next(one for one in remedies(loser, target)["geared"].changes if one.words.startswith("motor torque"))
    lever = next(one for one in levers(loser, "energy") if one.words == change.words)
    free = replace(loser, drive=replace(tight, motor=replace(tight.motor, voltage=100.0)))
    unlimited = next(one for one in remedies(free, target)["geared"].changes if one.words == change.words)
    assert unlimited.enough
    assert not change.enough or change.needed > unlimited.needed
    broken = iv.duty_cycle(lever.made(tight, unlimited.needed), WALK)
    assert broken.demands[Limit.VOLTAGE, "motor"] > 1.0


def test_masses_needed():
    drive = KNEE.drives["geared"]
    heavy = replace(drive, motor=replace(drive.motor, mass=0.3), gearhead=replace(drive.gearhead, mass=0.1))
    loser = replace(sized("geared", mass=0.4, drive=heavy), parts={"motor": None, "gearhead": None})
    one = remedies(loser, sized("cobotic", mass=0.25), "mass")["geared"]
    needed = {change.words: change.needed for change in one.changes}
    assert needed["mass of the motor"] == pytest.approx(0.15, rel=1e-5)
    assert needed["all these masses together"] == pytest.approx(0.25, rel=1e-5)
    assert math.isnan(needed["mass of the gearhead"])
    assert one.lines[0].startswith("all these masses together 0.25 kg instead of 0.4 kg (0.625 times)")


@pytest.mark.slow
def test_what_would_make_the_nearest_miss_feasible():
    """Allowances that are just enough together, and none of which may be less, by `duty_cycle`."""
    drive = KNEE.drives["geared"]
    weak = with_rated_gear(replace(drive, motor=replace(drive.motor, continuous_torque=0.018, voltage=9.0)))
    miss = sized("geared", drive=weak)
    cycle = iv.duty_cycle(weak, WALK)
    (one,) = what_if(WALKING, "energy", {}, {"geared": miss}, 1.0).values()
    assert one.goal == "feasible"
    assert one.present == pytest.approx(max(cycle.demands.values()), rel=1e-9)
    found = {change.words: change for change in one.allowances}
    assert set(found) == {"motor continuous torque", "supply voltage"}
    values = {name: found[words].needed for name, words in _FIELDS.items()}
    together = iv.duty_cycle(replace(weak, motor=replace(weak.motor, **values)), WALK)
    assert one.together
    assert max(together.demands.values()) == pytest.approx(1.0, rel=1e-4)
    for name, value in values.items():
        less = {**values, name: 0.99 * value}
        assert not iv.duty_cycle(replace(weak, motor=replace(weak.motor, **less)), WALK).feasible
    assert one.lines[0].startswith("enough together: ")
    for change in one.changes:
        if change.enough:
            lever = next(lever for lever in levers(miss, "feasible") if lever.words == change.words)
            assert iv.duty_cycle(lever.made(weak, change.needed * (1.0 - 1e-9)), WALK).feasible


_ENOUGH = re.compile(
    r"(motor continuous torque|supply voltage) (\S+) (N m|V) instead of (\S+) (?:N m|V) \((\S+) times\)"
)


@pytest.mark.slow
@sampled("torque", [0.0181, 0.0187, 0.0193], every=3)
@pytest.mark.parametrize("voltage", [9.0, 9.3])
def test_the_text_states_values_that_are_enough(torque, voltage):
    """Values and factors, as printed, by `duty_cycle`: with more of each, and never with what the drive has."""
    drive = KNEE.drives["geared"]
    weak = with_rated_gear(replace(drive, motor=replace(drive.motor, continuous_torque=torque, voltage=voltage)))
    (one,) = what_if(WALKING, "energy", {}, {"geared": sized("geared", drive=weak)}, 1.0).values()
    found = _ENOUGH.findall(one.lines[0])
    assert [words for words, *_ in found] == [change.words for change in one.allowances]
    fields = {words: name for name, words in _FIELDS.items()}
    stated = {fields[words]: parse(f"{value} {unit}", unit) for words, value, unit, _, _ in found}
    factors = {fields[words]: float(times) for words, _, _, _, times in found}
    for values in (stated, {name: factor * getattr(weak.motor, name) for name, factor in factors.items()}):
        assert iv.duty_cycle(replace(weak, motor=replace(weak.motor, **values)), WALK).feasible
        assert all(
            value <= 1.011 * change.needed for value, change in zip(values.values(), one.allowances, strict=True)
        )
    alone = [change_words(change) for change in one.changes if change.enough]
    for said, change in zip(alone, one.changes, strict=False):
        lever = next(lever for lever in levers(sized("geared", drive=weak), "feasible") if lever.words == change.words)
        value = parse(said.removeprefix(change.words).split(" instead")[0].strip(), change.unit)
        assert iv.duty_cycle(lever.made(weak, value), WALK).feasible


@pytest.mark.slow
def test_more_continuous_torque_leaves_the_gear_as_it_is():
    """A gear of constant friction is rated at the motor's torque unless it states another: its friction stays."""
    drive = KNEE.drives["geared"]
    assert (drive.gearhead.loss_model, drive.gearhead.rated_torque) == ("coulomb", None)
    weak = replace(drive, motor=replace(drive.motor, continuous_torque=0.018))
    (one,) = what_if(WALKING, "energy", {}, {"geared": sized("geared", drive=weak)}, 1.0).values()
    (change,) = one.allowances
    assert one.together
    before, (after, less) = (
        iv.duty_cycle(weak, WALK),
        (
            iv.duty_cycle(with_values(with_rated_gear(weak), {"motor.continuous_torque": value}), WALK)
            for value in (change.stated, 0.999 * change.needed)
        ),
    )
    assert after.power_in == pytest.approx(before.power_in, rel=1e-12)
    assert after.feasible
    assert not less.feasible
    # The current asked for stays; a motor that may carry it also carries its no-load current.
    motor, demand = weak.motor, before.demands[Limit.THERMAL, "motor"]
    idle = motor.no_load_current * motor.torque_constant
    assert change.needed == pytest.approx(demand * (motor.continuous_torque + idle) - idle, rel=1e-4)


@pytest.mark.slow
def test_limits_that_no_allowance_mends_are_named():
    """A travel that is too short is of the study, and no value of the drive changes it."""
    drive = KNEE.drives["geared"]
    weak = replace(drive, motor=replace(drive.motor, continuous_torque=0.018))
    travel = 0.5 * float(np.ptp(WALK.instants().position))
    short = replace(WALKING, requirement=iv.Requirement(force=1.0, speed=0.01, travel=travel))
    cycle = iv.duty_cycle(weak, WALK, travel=travel)
    miss = replace(sized("geared", drive=weak), demands={("walking", *key): one for key, one in cycle.demands.items()})
    (one,) = what_if(short, "energy", {}, {"geared": miss}, 1.0).values()
    assert not one.together
    assert dict(one.remaining) == {("walking", Limit.TRAVEL, "load"): pytest.approx(2.0, rel=1e-9)}
    assert one.lines[0].startswith("not enough together: motor continuous torque ")
    assert one.lines[0].endswith("; still exceeded: travel, walking: 2 times the allowance")
    assert one.to_dict()["remaining"] == [
        {"task": "walking", "limit": "TRAVEL", "part": "load", "demand_over_allowance": pytest.approx(2.0, rel=1e-9)}
    ]
    (alone,) = what_if(short, "energy", {}, {"geared": replace(miss, drive=drive)}, 1.0).values()
    assert "travel, walking: 2 times the allowance" in alone.lines[0]


def _accepting_none(drive, **values):
    amplifier = replace(drive.amplifier, regeneration="none", storage_efficiency=None)
    return with_rated_gear(replace(drive, amplifier=amplifier, motor=replace(drive.motor, **values)))


@sampled(("voltage", "travel"), [(24.0, None), (9.0, None), (24.0, 0.5), (9.0, 0.5)], every=2)
def test_where_no_power_may_return_an_amplifier_that_absorbs_it_is_asked_for(voltage, travel):
    """The power that returns, by current and voltage of the motor; what else is exceeded, as if the amplifier burnt it."""
    drive = _accepting_none(KNEE.drives["geared"], voltage=voltage)
    burning = replace(drive, amplifier=replace(drive.amplifier, regeneration="burn"))
    study, length = WALKING, None
    if travel is not None:
        length = travel * float(np.ptp(WALK.instants().position))
        study = replace(WALKING, requirement=iv.Requirement(force=1.0, speed=0.01, travel=length))
    cycle = iv.duty_cycle(drive, WALK, travel=length)
    miss = replace(sized("geared", drive=drive), demands={("walking", *key): one for key, one in cycle.demands.items()})
    (one,) = what_if(study, "energy", {}, {"geared": miss}, 1.0).values()
    point = cycle.point
    power = np.asarray(point.states["motor_current_A"]) * np.asarray(point.states["motor_voltage_V"])
    assert one.absorbed == pytest.approx(-power.min(), rel=1e-9)
    assert one.absorbed > 0.0
    assert not one.slips
    after = iv.duty_cycle(burning, WALK, travel=length)
    assert one.present == pytest.approx(max(after.demands.values()), rel=1e-9)
    assert {change.words for change in one.allowances} == ({"supply voltage"} if voltage < 24.0 else set())
    for change in one.allowances:
        enough = replace(burning, motor=replace(burning.motor, voltage=change.stated))
        assert iv.duty_cycle(enough, WALK).feasible
    assert one.together == (travel is None)
    assert [limit for _, limit, _ in one.remaining] == ([] if travel is None else [Limit.TRAVEL])
    said, *others = one.lines
    both = " together" if voltage < 24.0 else ""
    outcome = f"enough{both}: " if travel is None else f"not enough{both}: "
    words = f"{outcome}an amplifier that absorbs the power returned, at most "
    assert said.startswith(words)
    assert one.absorbed <= float(said.removeprefix(words).split()[0]) <= 1.01 * one.absorbed
    assert 'regeneration = "burn" or "store" instead of "none"' in said
    assert ("; still exceeded: travel, walking: 2 times the allowance" in said) == (travel is not None)
    assert bool(others) == (not after.feasible)  # nothing else is asked for if that is enough
    stated = one.to_dict()
    assert (stated["absorbed"], stated["slips"]) == (one.absorbed, False)


def test_a_drive_that_returns_power_has_no_margin():
    drive = _accepting_none(KNEE.drives["geared"])
    miss = sized("geared", drive=drive)
    returned = "regeneration, walking: the motor returns power, and the amplifier accepts none"
    assert exceeded_words(miss) == returned
    assert miss.results[-1] == f"infeasible ({returned})"
    assert miss.verdict.endswith(f"infeasible ({returned})")
    slips = replace(miss, demands={("walking", Limit.SLIP, "wheel"): math.inf})
    assert slips.results[-1] == "infeasible (wheel slip, walking: no steady rolling)"
    lost = replace(miss, demands={("walking", Limit.LINKAGE, "linkage"): math.nan})
    assert lost.results[-1] == f"infeasible ({exceeded_words(lost)})"
    assert lost.results[-1].endswith(": out of reach)")


@pytest.mark.slow
def test_a_search_among_drives_that_all_return_power_says_what_would_do(shelf):
    drive = _accepting_none(KNEE.drives["geared"])
    study = replace(WALKING, drives={"geared": drive})
    made = iv.size(study, sets=shelf, radius=(0.003, 0.05), objective="energy")
    assert not made.feasible
    one = made.what_if["geared"]
    assert one.together
    assert not one.allowances
    burning = replace(made.nearest.drive, amplifier=replace(drive.amplifier, regeneration="burn"))
    assert iv.duty_cycle(burning, WALK).feasible
    assert "margin 0" not in "".join(text(made))
    page = page_words(made)
    assert f"Enough: {one.amplifier_words}." in page
    assert "margin 0" not in page
    assert "quantity" not in page  # nothing else is asked for, so that there is no table


def page_words(made):
    """The report as plain text."""
    return " ".join(
        unescape(re.sub(r"<style.*?</style>|<[^>]*>", " ", html(made, {}, "", {}), flags=re.DOTALL)).split()
    )


@pytest.mark.slow
@sampled("torque", [None, 0.018], every=2)
def test_the_report_names_the_limits_that_remain(shelf, torque):
    """As the console does: with allowances that are not enough, and where none is known."""
    drive = KNEE.drives["geared"]
    travel = 0.5 * float(np.ptp(WALK.instants().position))
    short = replace(WALKING, requirement=iv.Requirement(force=1.0, speed=0.01, travel=travel))
    made = iv.size(short.with_drives("geared"), sets=shelf, radius=(0.003, 0.05), objective="energy", top=1)
    weak = drive if torque is None else replace(drive, motor=replace(drive.motor, continuous_torque=torque))
    cycle = iv.duty_cycle(weak, WALK, travel=travel)
    miss = replace(sized("geared", drive=weak), demands={("walking", *key): one for key, one in cycle.demands.items()})
    asked_of = what_if(short, "energy", {}, {"geared": miss}, 1.0)
    lines = "\n".join(asked_of["geared"].lines)
    page = page_words(replace(made, what_if=asked_of))
    if torque is None:
        assert "no allowance looked at changes travel, walking: 2 times the allowance" in lines
        assert "No allowance looked at changes travel, walking: 2 times the allowance." in page
    else:
        assert "still exceeded: travel, walking: 2 times the allowance" in lines
        assert "The allowance named first is not enough for all limits." in page
        assert "Still exceeded: travel, walking: 2 times the allowance." in page
    assert "are kept with the allowances named first" not in page


@pytest.mark.slow
def test_a_drive_that_fails_by_little_does_not_read_as_kept():
    """Demand, margin and what is needed are told from 1, and from what there is."""
    drive = KNEE.drives["geared"]
    least = iv.duty_cycle(drive, WALK).demands[Limit.VOLTAGE, "motor"] * drive.motor.voltage
    for off, words in ((4e-4, "1.0004 times"), (3e-5, "1.00003 times"), (1e-7, "just over 1 times")):
        weak = replace(drive, motor=replace(drive.motor, voltage=least / (1.0 + off)))
        miss = sized("geared", drive=weak)
        assert exceeded_words(miss) == f"supply voltage, walking: {words} the allowance"
        assert "margin 1 " not in miss.verdict
        assert f"supply voltage, {words} the allowance" in iv.duty_cycle(weak, WALK).verdict
        assert "(margin 1.00)" not in iv.duty_cycle(weak, WALK).tightest_words
        (one,) = what_if(WALKING, "energy", {}, {"geared": miss}, 1.0).values()
        ((_, value, _, start, times),) = _ENOUGH.findall(one.lines[0])
        assert float(value) >= least > float(start)
        assert float(times) > 1.0


@pytest.mark.slow
def test_the_search_says_what_would_have_to_change(tmp_path):
    (tmp_path / "shelf.toml").write_text(SHELF.replace('"24 V"', '"7 V"'), "utf-8")
    made = iv.size(
        KNEE.with_drives("geared"), sets=tmp_path / "shelf.toml", radius=(0.003, 0.05), objective="energy", top=1
    )
    assert not made.feasible
    assert made.what_if["geared"].allowances
    assert made.to_dict()["what_if"]["geared"]["goal"] == "feasible"
    assert value_at(made.nearest.drive, "motor.voltage") == 7.0
    assert STEERING_MOTOR not in made.nearest.parts

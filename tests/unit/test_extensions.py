"""Laws, parts, drives, limits and motions of other packages: given as values, and asked for by word in study files."""

import copy
import dataclasses
import json
import math
import pickle
import sys
from dataclasses import dataclass, replace
from importlib import metadata

import numpy as np
import pytest
from annotated_types import Gt

import infinivar as iv
import plugin_package
from infinivar.contact import creep
from infinivar.drivetrain import Drive
from internals import (
    MovingDrive,
    binding,
    binding_demand,
    check_flow,
    check_law,
    check_motion,
    extended_schema,
    json_schema,
    plugins,
    words_of,
)
from internals import labelled_arrays as labelled_map
from rendering import rendered

MINE = """
[requirement]
force = "40 N"
speed = "0.5 m/s"

[drives.coil]
type = "voice-coil"
constant = { value = "18 N/A", kind = "catalogue", where = "data sheet" }
resistance = "1.4 ohm"
coil_mass = "300 g"
largest_force = "60 N"

[drives.wheel]
base = "faulring2006.cobotic"

[drives.wheel.transmission]
creep_law = "soft"

[drives.geared]
base = "faulring2006.motor1-gear1"

[drives.geared.gearhead]
variant = "oiled"
drag = "2e-6 N m s"

[duty.tones]
shape = "two-tones"
distance = "20 mm"
ripple = "2 mm"
frequency = "1.5 Hz"
"""

MINE_TABLES = {
    "requirement": {"force": "40 N", "speed": "0.5 m/s"},
    "drives": {
        "coil": {
            "type": "voice-coil",
            "constant": "18 N/A",
            "resistance": "1.4 ohm",
            "coil_mass": "0.3 kg",
            "largest_force": "60 N",
        }
    },
}


@pytest.fixture
def installed(tmp_path, monkeypatch):
    """Somebody's package, installed; returns its module."""
    folder = tmp_path / "site"
    folder.mkdir()
    plugin_package.install(folder, monkeypatch)
    import mylab

    yield mylab
    sys.modules.pop("mylab", None)


def test_a_study_asks_for_what_a_package_registers(installed, load, tmp_path):
    study = load(MINE)
    coil, wheel, geared = study.drives.values()
    assert type(coil) is installed.VoiceCoil
    assert coil.constant == 18.0
    assert wheel.transmission.creep_law is installed.SOFT
    assert type(geared.gearhead) is installed.OiledGearhead
    assert geared.gearhead.drag == 2e-6
    assert geared.gearhead.ratio == iv.load_study("hand_controller").drives["motor1-gear1"].gearhead.ratio
    assert type(study.duty["tones"].motion) is installed.TwoTones
    (row,) = [row for row in study.provenance if (row.owner, row.field) == ("coil", "constant")]
    assert (row.written, row.kind, row.where) == ("18 N/A", "catalogue", "data sheet")
    again = iv.load_study(study.save(tmp_path / "again.toml"))
    assert again == study


@pytest.mark.slow
@pytest.mark.usefixtures("unrendered")
def test_the_whole_way_through_a_comparison_and_its_report(installed, load, tmp_path):
    comparison = iv.compare(load(MINE), quick=True)
    assert all(result.audit_residual < 1e-9 for result in comparison.results.values())
    assert all(found.closure < 1e-9 for found in comparison.duty["tones"].results.values())
    assert "demagnetisation" in comparison.results["coil"].verdict
    with rendered(("svg",)):
        (page, *_) = iv.save(comparison, tmp_path / "out")
    text = page.read_text("utf-8")
    missing = [word for word in ("demagnetisation", "soft", "data sheet") if word not in text]
    assert missing == []
    stored = json.loads((tmp_path / "out" / "results.json").read_text("utf-8"))
    assert stored["drives"]["coil"]["tightest_margin"]["limit"] == "MAGNETS"


def test_the_schema_lists_what_is_installed(installed):
    schema, plain = extended_schema(), json_schema()
    definitions = schema["$defs"]
    assert {"$ref": "#/$defs/VoiceCoil"} in schema["properties"]["drives"]["additionalProperties"]["anyOf"]
    assert definitions["VoiceCoil"]["properties"]["type"] == {"const": "voice-coil"}
    assert "two-tones" in json.dumps(definitions["DutyCycle"]["properties"]["shape"])
    assert "ripple" in definitions["DutyCycle"]["properties"]
    assert "once" not in json.dumps(definitions["DutyCycle"]["properties"]["shape"])
    assert "once" in json.dumps(definitions["Motion"]["properties"]["shape"])
    assert "soft" in json.dumps(definitions["RotaryLinearIVT"]["properties"]["creep_law"])
    assert definitions["Gearhead"]["properties"]["variant"]["enum"] == ["oiled"]
    assert "drag" in definitions["Gearhead"]["properties"]
    assert "variant" not in json.dumps(plain)


def test_without_packages_the_schema_is_that_of_the_program():
    if not any(plugins.registered(group) for group in plugins.GROUPS):
        assert extended_schema() == json_schema()


def test_packages_are_asked_only_for_unknown_words(monkeypatch, load):
    groups = []
    monkeypatch.setattr(metadata, "entry_points", lambda **said: groups.append(said) or ())
    plugins._found.cache_clear()
    iv.load_study("hand_controller")
    iv.load_study("knee_walking")
    assert groups == []
    with pytest.raises(iv.InputError, match="must be one of cobotic, conventional"):
        load(MINE)
    assert {said["group"] for said in groups} == {
        "infinivar.creep_laws",
        "infinivar.drives",
        "infinivar.motions",
        "infinivar.parts",
    }
    plugins._found.cache_clear()


@pytest.mark.parametrize(
    ("words", "text", "message"),
    [
        (
            "[infinivar.creep_laws]\nsoft = {0}:NONE",
            MINE,
            r"creep law 'soft' \({0}:NONE of {0} 1.2\) cannot be loaded: AttributeError",
        ),
        (
            "[infinivar.creep_laws]\nsoft = nowhere_at_all:LAW",
            MINE,
            r"creep law 'soft' \(nowhere_at_all:LAW of {0} 1.2\) cannot be loaded: ModuleNotFoundError",
        ),
        ("[infinivar.creep_laws]\nsoft = {0}:K", MINE, r"creep law 'soft' .* must be a CreepLaw, got a float"),
        (
            "[infinivar.drives]\nvoice-coil = {0}:VoiceCoil\n[infinivar.creep_laws]\nsofter = {0}:SOFT",
            MINE,
            r"creep_law = .soft. must be one of linear, .* exact, softer \(did you mean 'softer'\?\)",
        ),
        (
            "[infinivar.drives]\nvoice-coils = {0}:VoiceCoil",
            MINE,
            r"type = .voice-coil. must be one of cobotic, .*, voice-coils \(did you mean 'voice-coils'\?\)",
        ),
        (
            "[infinivar.drives]\nvoice-coil = {0}:SOFT",
            MINE,
            r"'voice-coil' .* must be a class that is a dataclass, got a CreepLaw",
        ),
        (
            "[infinivar.drives]\nvoice-coil = {0}:TwoTones",
            MINE,
            r"'voice-coil' .* must be a dataclass with operate \(it has no operate\), got the class TwoTones",
        ),
        (
            "[infinivar.drives]\nvoice-coil = {0}:Bare",
            MINE,
            r"must be a dataclass whose fields are made with infinivar.quantity or infinivar.component \(not x\)",
        ),
        (
            "[infinivar.motions]\ntwo-tones = {0}:Once",
            MINE,
            r"duty.tones.shape: 'two-tones' is a Once, which does not repeat",
        ),
        (
            "[infinivar.parts]\noiled = {0}:VoiceCoil",
            MINE,
            r"drives.geared.gearhead.variant = 'oiled' is a VoiceCoil, which is no Gearhead",
        ),
        (
            "[infinivar.parts]\nwet = {0}:OiledGearhead",
            MINE,
            r"drives.geared.gearhead.variant = 'oiled' must be one of wet",
        ),
        ("", MINE, r"drives.geared.gearhead.variant = 'oiled' must be removed: no package registers parts"),
        ("", MINE, r"duty.tones.shape = \"two-tones\" must be one of hold"),
    ],
)
def test_what_is_wrong_with_a_package_is_said(words, text, message, tmp_path, monkeypatch, load):
    folder = tmp_path / "site"
    folder.mkdir()
    plugin_package.install(folder, monkeypatch, words, package="badlab")
    with pytest.raises(iv.InputError, match=message.replace("{0}", "badlab")) as found:
        load(text)
    assert "mine.toml: " in str(found.value)
    sys.modules.pop("badlab", None)


def test_a_faulty_package_is_in_nobodys_way(tmp_path, monkeypatch, load):
    """Words that cannot be used, beside those that can: they matter only to a study that asks for them."""
    faults = """
[infinivar.creep_laws]
linear = {0}:SOFT
other = nowhere_at_all:LAW

[infinivar.drives]
aa-broken = {0}:TwoTones
ab-missing = nowhere_at_all:Drive
conventional = {0}:VoiceCoil

[infinivar.motions]
aa-broken = {0}:Once
ab-missing = nowhere_at_all:Motion

[infinivar.parts]
aa-broken = nowhere_at_all:Part

[infinivar.limits]
aa-broken = nowhere_at_all:LIMIT
"""
    for package, words in (("badlab", faults), ("mylab", plugin_package.WORDS)):
        folder = tmp_path / package
        folder.mkdir()
        plugin_package.install(folder, monkeypatch, words, package=package)
    for study in (load(MINE), iv.load_study("hand_controller")):
        path = study.save(tmp_path / f"{study.name}-again.toml")
        assert iv.load_study(path) == study
    assert iv.Limit(100).name == "MAGNETS"
    with pytest.raises(iv.InputError, match=r"'other' .* cannot be loaded: ModuleNotFoundError"):
        load(MINE.replace('creep_law = "soft"', 'creep_law = "other"'))
    for package in ("badlab", "mylab"):
        sys.modules.pop(package, None)


def test_two_packages_with_one_word(tmp_path, monkeypatch, load):
    for package in ("onelab", "twolab"):
        folder = tmp_path / package
        folder.mkdir()
        plugin_package.install(folder, monkeypatch, package=package)
    with pytest.raises(
        iv.InputError, match=r"'soft' is registered by (one|two)lab 1.2 and (one|two)lab 1.2; remove one"
    ):
        load(MINE)
    for package in ("onelab", "twolab"):
        sys.modules.pop(package, None)


def test_the_command_line_names_a_broken_package(tmp_path, monkeypatch):
    from run_cli import run

    folder = tmp_path / "site"
    folder.mkdir()
    words = "[infinivar.creep_laws]\nlinear = {0}:SOFT\nsoft = {0}:SOFT\n[infinivar.parts]\nwet = nowhere_at_all:Wet\n"
    plugin_package.install(folder, monkeypatch, words, package="badlab")
    outcome = run("schema", folder=tmp_path)
    assert outcome.code == 0
    assert "left out: the creep law 'linear' (badlab:SOFT of badlab 1.2) has the name of a built-in one" in outcome.err
    assert "left out: the part 'wet' (nowhere_at_all:Wet of badlab 1.2) cannot be loaded" in outcome.err
    assert outcome.err.count("left out") == 2
    assert '"soft"' in outcome.out
    assert '"wet"' not in outcome.out
    json.loads(outcome.out)
    sys.modules.pop("badlab", None)


# Values given in Python


@pytest.mark.slow
def test_a_creep_law_in_all_analyses(installed, study):
    drive = study.drives["cobotic"]
    drive = replace(drive, transmission=replace(drive.transmission, creep_law=installed.SOFT))
    x = np.linspace(-1.0, 1.0, 201)
    assert installed.SOFT.force(installed.SOFT.creepage(x)) == pytest.approx(x, abs=1e-14)
    assert iv.steady_map(drive, [-0.3, 0.1, 0.3], [-40.0, 5.0, 40.0]).audit_residual < 1e-9
    two = iv.analysis.two_ways(
        drive, iv.DutyCycle(motion=iv.motion.Sinusoid(distance=0.02, frequency=2.0), load_mass=0.8)
    )
    assert two.as_turning == pytest.approx(two.followed, rel=0.02)
    assert two.lost_prescribed["creep"] == pytest.approx(two.lost_followed["creep"], rel=0.02)
    linear = study.drives["cobotic"].operate(speed=0.2, force=40.0)
    assert float(drive.operate(speed=0.2, force=40.0).losses["creep"]) > float(linear.losses["creep"])


def odd(function):
    return lambda x: np.sign(x) * function(np.abs(x))


LAWS = {
    "creates energy": ({"creepage": lambda x: -x, "slope": lambda x: -1.0, "force": lambda x: -x}, "creepage .* sign"),
    "not odd": (
        {"creepage": lambda x: x + 0.2 * x**2, "slope": lambda x: 1.0 + 0.4 * x, "slip_creepage": 1.2},
        "creepage must be odd in the force ratio, got -0.77568 at the force ratio -0.96",
    ),
    "twice as soft": (
        {
            "creepage": lambda x: 2.0 * x,
            "slope": lambda x: 2.0,
            "force": lambda x: x / 2.0,
            "slip_creepage": 2.0,
        },
        "slope must be 1, got 2 at the force ratio 0 instead of 1",
    ),
    "wrong slope": (
        {"creepage": lambda x: x + 0.2 * x**3, "slope": lambda x: 1.0, "slip_creepage": 1.2},
        "slope must be the derivative of creepage, got 1 at the force ratio -0.96",
    ),
    "falling": (
        {
            "creepage": odd(lambda x: x - 0.9 * x**2),
            "slope": lambda x: 1.0 - 1.8 * np.abs(x),
            "slip_creepage": 1.5,
        },
        "slope must be >= 0, got",
    ),
    "wrong inverse": (
        {"creepage": lambda x: x + 0.2 * x**3, "slope": lambda x: 1.0 + 0.6 * x**2, "slip_creepage": 1.2},
        "force must be the inverse of creepage, got -1 at the scaled creepage -1.137 instead of -0.96",
    ),
    "early slip": (
        {"slip_creepage": 0.5},
        "creepage must be at most slip_creepage, got -0.96 at the force ratio -0.96",
    ),
    "late slip": (
        {"slip_creepage": 1.5, "force": lambda xi: np.clip(xi, -1.0, 1.0) * np.where(np.abs(xi) > 1.2, 0.9, 1.0)},
        r"force must be \+-1 at slip_creepage, got -0.9",
    ),
    "not straight": (
        {
            "creepage": odd(lambda x: x + 0.1 * x * (1.0 - x)),
            "slope": lambda x: 1.0 + 0.1 - 0.2 * np.abs(x),
        },
        "creepage must be equal to the force ratio, as slip_creepage is 1",
    ),
    "nan": ({"creepage": lambda x: np.nan * x}, "creepage must be odd in the force ratio, got nan"),
    "of one number": (
        {"force": lambda x: max(-1.0, min(1.0, x))},
        "force must be a function of a NumPy array of floats",
    ),
    "taken name": (
        {"name": "linear", "slope": lambda x: 1.0},
        "name must be another than that of a built-in .* 'linear'",
    ),
    "creating flow": ({"flow_factor": lambda x: (1.0 + x * x, 2.0 * x)}, "flow_factor must be from 0 to 1, got 1.9216"),
}


@pytest.mark.parametrize("fault", LAWS)
def test_a_law_that_cannot_be_is_refused_when_given(fault):
    change, message = LAWS[fault]
    right = {
        "name": "mine",
        "creepage": lambda x: x,
        "slope": lambda x: 1.0,
        "force": lambda x: np.clip(x, -1.0, 1.0),
        "slip_creepage": 1.0,
    }
    assert iv.contact.CreepLaw(**right).straight
    with pytest.raises(iv.ParameterError, match=message):
        iv.contact.CreepLaw(**{**right, **change})


@pytest.mark.parametrize("law", creep.LAWS.values(), ids=str)
def test_the_laws_of_the_program_pass_the_probe(law):
    check_law(law.creepage, law.slope, law.force, law.slip_creepage)
    if law.flow_factor is not None:
        check_flow(law.flow_factor)
    renamed = replace(law, name="mine")
    assert (renamed.straight, renamed.slip_creepage) == (law.straight, law.slip_creepage)
    assert replace(law) == law


def test_a_part_takes_the_place_of_a_shipped_one(installed, study):
    drive = study.drives["motor1-gear1"]
    gear = drive.gearhead
    dry = installed.OiledGearhead(**{field.name: getattr(gear, field.name) for field in dataclasses.fields(gear)})
    same = replace(drive, gearhead=dry)
    oiled = replace(drive, gearhead=replace(dry, drag=2e-6))
    speed, force = np.linspace(-0.4, 0.4, 9)[:, None], np.linspace(-30.0, 30.0, 7)
    assert np.array_equal(
        same.operate(speed=speed, force=force).power_in, drive.operate(speed=speed, force=force).power_in
    )
    more = (
        oiled.operate(speed=speed, force=force).losses["gearhead"]
        - drive.operate(speed=speed, force=force).losses["gearhead"]
    )
    motor = speed / drive.pulley.radius * gear.ratio
    assert more == pytest.approx(np.broadcast_to(2e-6 * motor**2, more.shape), rel=1e-9, abs=1e-15)
    assert iv.steady_map(oiled, speed.ravel(), force).audit_residual < 1e-9
    with pytest.raises(iv.ParameterError, match="gearhead is of type OiledGearhead, whose law is in no bond graph"):
        iv.simulate(oiled, iv.Scenario(duration=0.1))
    with pytest.raises(iv.ParameterError, match="gearhead is of type OiledGearhead"):
        iv.plant_graph(oiled)


@dataclass(frozen=True)
class Worm:
    """What a drive uses of its gearhead, without its class; self-locking is left to others."""

    name: str = "worm"
    ratio: float = 30.0
    inertia: float | None = None
    stiffness: float | None = None

    def operate(self, *, output_torque, output_speed, motor_rated_torque):
        gear = iv.parts.Gearhead(
            ratio=self.ratio, efficiency=0.5, loss_model="proportional", backdriving_efficiency=0.0
        )
        return gear.operate(
            output_torque=output_torque, output_speed=output_speed, motor_rated_torque=motor_rated_torque
        )

    def without_friction(self):
        return iv.parts.Gearhead(ratio=self.ratio, efficiency=1.0)


@pytest.mark.usefixtures("unrendered")
def test_a_part_by_its_methods_alone(study, tmp_path):
    drive = replace(study.drives["motor1-gear1"], gearhead=Worm())
    mine = iv.Study(
        name="mine",
        requirement=iv.Requirement(force=20.0, speed=0.05, quadrants=4),
        drives={"worm": drive},
        duty={"push": iv.DutyCycle(motion=iv.motion.Sinusoid(distance=0.005, frequency=0.5), load_mass=1.0)},
    )
    comparison = iv.compare(mine, quick=True)
    assert comparison.results["worm"].audit_residual < 1e-9
    with rendered(("svg",)):
        (page, *_) = iv.save(comparison, tmp_path)
    assert "30:1" in page.read_text("utf-8")
    with pytest.raises(iv.InputError, match=r"drives.worm.gearhead is a Worm, which a study file cannot state"):
        mine.to_toml()


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        (3.0, "gearhead must be a Gearhead, got 3.0"),
        (iv.parts.Gearhead, "gearhead must be a Gearhead, got <class"),
        (iv.parts.Guideway(), "gearhead must be a Gearhead or have name, ratio, .* but a Guideway has no name"),
        (None, "gearhead must be a Gearhead, got None"),
    ],
)
def test_what_takes_no_part_is_refused(study, wrong, message):
    with pytest.raises(iv.ParameterError, match=message):
        replace(study.drives["motor1-gear1"], gearhead=wrong)
    with pytest.raises(iv.ParameterError, match=message):
        replace(study.drives["cobotic"], gearhead=wrong)


def coil_of(module):
    return module.VoiceCoil(constant=18.0, resistance=1.4, coil_mass=0.3, largest_force=60.0)


def test_a_drive_by_its_methods_alone(installed):
    coil = coil_of(installed)
    assert isinstance(coil, Drive)
    assert isinstance(coil, MovingDrive)
    size, frequency, mass = 0.02, 3.0, 1.0
    duty = iv.DutyCycle(motion=iv.motion.Sinusoid(distance=size, frequency=frequency), load_mass=mass)
    found = iv.duty_cycle(coil, duty)
    # Closed form: force amplitude F = (m + m_c) d w^2; the winding takes F^2 R/(2 k^2) on average.
    turn = 2.0 * math.pi * frequency
    amplitude = (mass + coil.coil_mass) * size * turn**2
    winding = 0.5 * (amplitude / coil.constant) ** 2 * coil.resistance
    assert found.losses["winding"] * frequency == pytest.approx(winding, rel=1e-9)
    assert found.demands[installed.MAGNETS, "coil"] == pytest.approx(amplitude / coil.largest_force, rel=1e-5)
    assert found.heat == {}
    assert found.without_help is None
    assert found.closure < 1e-9
    assert found.power_in == pytest.approx(winding + found.losses["amplifier"] * frequency, rel=1e-9)


@pytest.mark.parametrize(
    ("change", "error", "message"),
    [
        (
            lambda point: replace(point, power_in=0.9 * point.power_in),
            iv.AuditError,
            "power balance has a relative residual",
        ),
        (
            lambda point: replace(point, losses={**point.losses, "winding": -point.losses["winding"]}),
            iv.AuditError,
            "the winding loss is negative",
        ),
        (
            lambda point: replace(
                point, power_out=0.9 * point.power_out, power_in=point.power_in - 0.1 * point.power_out
            ),
            iv.AuditError,
            r"Faulty.operate: power_out differs from force times speed by up to",
        ),
        (lambda point: replace(point, power_in=np.nan * point.power_in), iv.AuditError, "nan"),
        (lambda point: point.power_in, iv.ParameterError, r"Faulty.operate must return a DrivePoint, got a ndarray"),
    ],
)
def test_the_audit_covers_a_drive_of_others(installed, change, error, message):
    coil = coil_of(installed)

    class Faulty:
        def operate(self, *, speed, force):
            return change(coil.operate(speed=speed, force=force))

    with pytest.raises(error, match=message):
        iv.steady_map(Faulty(), [0.1, 0.2], [5.0, 10.0])


STRIDE = iv.DutyCycle(motion=iv.motion.Sinusoid(distance=0.02, frequency=3.0), load_mass=1.0, title="stride")


@pytest.mark.parametrize(
    ("change", "error", "message"),
    [
        (
            lambda point: replace(point, power_in=point.power_in - 1.0, losses={**point.losses, "magic": -1.0}),
            iv.AuditError,
            "Faulty.follow: the magic loss is negative, down to -1 W",
        ),
        (
            lambda point: replace(
                point, power_in=point.power_in - 1.0, stored={**point.stored, "tank": -np.ones(point.power_in.shape)}
            ),
            iv.AuditError,
            "Faulty.follow in stride: tank returns 1 W on average, cycle after cycle",
        ),
        (
            lambda point: replace(point, power_in=np.nan * point.power_in),
            iv.AuditError,
            "Faulty.follow: power_in is not finite although the wheel does not slip",
        ),
        (
            lambda point: replace(point, losses={**point.losses, "winding": np.nan}),
            iv.AuditError,
            "the winding loss is not finite",
        ),
        (
            # Wrong at each instant, right on average.
            lambda point: replace(point, power_in=point.power_in + np.resize([0.1, -0.1], point.power_in.shape)),
            iv.AuditError,
            "Faulty.follow: power_in differs from power_out, losses and stored powers together by up to 0.1 W",
        ),
        (
            lambda point: replace(point, utilisation={iv.Limit.SPEED: 0.5}),
            iv.ParameterError,
            r"each key of utilisation must be a Limit and the name of a part, such as \(Limit.SPEED, 'motor'\), got <Limit",
        ),
        (
            lambda point: replace(point, utilisation={"force": 0.5}),
            iv.ParameterError,
            "must be a Limit and the name of a part, .* got 'force'",
        ),
    ],
)
def test_the_audit_covers_each_instant_of_a_drive_of_others(installed, change, error, message):
    class Faulty(installed.VoiceCoil):
        def follow(self, course, *, load_mass=0.0):
            return change(installed.VoiceCoil.follow(self, course, load_mass=load_mass))

    coil = Faulty(constant=18.0, resistance=1.4, coil_mass=0.3, largest_force=60.0)
    with pytest.raises(error, match=message):
        iv.duty_cycle(coil, STRIDE)
    mine = iv.Study(name="mine", drives={"coil": coil}, duty={"stride": STRIDE})
    with pytest.raises(error, match=message):
        iv.compare(mine, quick=True)


def test_slip_excuses_powers_that_are_not_known(installed):
    class Slippery(installed.VoiceCoil):
        def follow(self, course, *, load_mass=0.0):
            point = installed.VoiceCoil.follow(self, course, load_mass=load_mass)
            lost = np.where(point.power_in > np.max(point.power_in) / 2.0, np.nan, 1.0)
            slips = {(iv.Limit.SLIP, "roller"): np.where(np.isnan(lost), 2.0, 0.5)}
            return replace(point, power_in=lost * point.power_in, utilisation=slips)

    found = iv.duty_cycle(Slippery(constant=18.0, resistance=1.4, coil_mass=0.3, largest_force=60.0), STRIDE)
    assert math.isnan(found.energy)
    assert found.verdict.startswith("infeasible: roller: wheel slip, 2 times the allowance")


def test_a_part_of_others_that_creates_energy_is_found_in_a_cycle(installed, study):
    @dataclass(frozen=True, slots=True, kw_only=True)
    class Source(iv.parts.Gearhead):
        def operate(self, *, output_torque, output_speed, motor_rated_torque):
            true = iv.parts.Gearhead.operate(
                self, output_torque=output_torque, output_speed=output_speed, motor_rated_torque=motor_rated_torque
            )
            gained = 2.0 * true.loss + 0.01 * abs(true.motor_speed)
            torque = true.motor_torque - gained / np.where(true.motor_speed == 0, np.inf, true.motor_speed)
            return replace(true, motor_torque=torque, loss=true.loss - gained)

    drive = study.drives["motor1-gear1"]
    drive = replace(drive, gearhead=Source(ratio=drive.gearhead.ratio, efficiency=0.9))
    with pytest.raises(iv.AuditError, match="the gearhead loss is negative"):
        iv.duty_cycle(drive, STRIDE)


def test_the_keys_of_a_steady_point_are_limits(installed):
    class Faulty(installed.VoiceCoil):
        def operate(self, *, speed, force):
            point = installed.VoiceCoil.operate(self, speed=speed, force=force)
            return replace(point, utilisation={"force": 0.5})

    coil = Faulty(constant=18.0, resistance=1.4, coil_mass=0.3, largest_force=60.0)
    with pytest.raises(
        iv.ParameterError, match=r"Faulty.operate: each key of utilisation must be a Limit, got 'force'"
    ):
        iv.steady_map(coil, [0.1], [5.0])


def test_a_drive_without_limits_in_a_cycle(installed):
    class Strong(installed.VoiceCoil):
        def follow(self, course, *, load_mass=0.0):
            return replace(installed.VoiceCoil.follow(self, course, load_mass=load_mass), utilisation={})

    coil = Strong(constant=18.0, resistance=1.4, coil_mass=0.3, largest_force=60.0)
    found = iv.duty_cycle(coil, STRIDE)
    assert found.tightest == ((iv.Limit.OK, "load"), math.inf)
    assert found.verdict.startswith("feasible; no limit is loaded; ")
    compared = iv.compare(iv.Study(name="mine", drives={"coil": coil}, duty={"stride": STRIDE}), quick=True)
    assert "no limit is loaded" in compared.duty["stride"].verdict


def test_what_a_drive_lacks_is_named(installed, study):
    class Steady:
        def operate(self, *, speed, force):
            return coil_of(installed).operate(speed=speed, force=force)

    with pytest.raises(iv.ParameterError, match="drive must be a drive, got a dict, which has no method operate"):
        iv.steady_map({}, [0.1], [5.0])
    with pytest.raises(iv.ParameterError, match="drive must be a drive, got the class Steady, not an instance of it"):
        iv.steady_map(Steady, [0.1], [5.0])
    with pytest.raises(iv.ParameterError, match="drive must be a drive, got a Steady, which has no method follow"):
        iv.duty_cycle(Steady(), iv.DutyCycle(motion=iv.motion.Hold(time=1.0)))
    mine = iv.Study(name="mine", requirement=iv.Requirement(force=40.0, speed=0.5), drives={"coil": Steady()})
    assert iv.compare(mine, quick=True).results["coil"].covers
    duty = replace(mine, duty={"hold": iv.DutyCycle(motion=iv.motion.Hold(time=1.0), force=5.0)})
    with pytest.raises(iv.InputError, match=r"drives.coil must be a drive, .* no method follow, for duty.hold"):
        iv.compare(duty)
    with pytest.raises(iv.ParameterError, match="a drive of type Steady has no bond graph"):
        iv.simulate(Steady(), iv.Scenario(duration=1.0))


def test_analyses_that_need_more_of_a_drive_say_so(installed, study):
    coil = coil_of(installed)
    with pytest.raises(iv.ParameterError, match="a drive of type VoiceCoil has no amplifier"):
        iv.analysis.dynamic_map(coil, [1.0], [0.5], power=5.0, load_mass=1.0)
    with pytest.raises(iv.ParameterError, match="a drive of type VoiceCoil has no bond graph"):
        iv.plant_graph(coil)
    with pytest.raises(iv.ParameterError, match="a drive of type VoiceCoil has no bond graph"):
        iv.analysis.two_ways(coil, iv.DutyCycle(motion=iv.motion.Sinusoid(distance=0.01, frequency=1.0), load_mass=1.0))
    mine = iv.Study(
        name="mine",
        requirement=iv.Requirement(force=40.0, speed=0.5),
        drives={"coil": coil, "geared": study.drives["motor1-gear1"]},
    )
    with pytest.raises(iv.InputError, match="sensitivity is not defined for a drive of type VoiceCoil"):
        iv.sensitivity(mine, "coil", "efficiency", force=20.0, speed=0.1)
    spread = iv.Study.from_dict({**MINE_TABLES, "uncertainty": {"coil": {"resistance": "5 %"}}}, name="mine")
    with pytest.raises(iv.InputError, match=r"uncertainty.coil: builds of a drive of type VoiceCoil cannot be sampled"):
        iv.compare(spread)

    class Mine(iv.ConventionalDrive):
        pass

    drive = study.drives["motor1-gear1"]
    mine = Mine(**{field.name: getattr(drive, field.name) for field in dataclasses.fields(drive) if field.init})
    assert iv.steady_map(mine, [0.1], [5.0]).audit_residual < 1e-9
    with pytest.raises(iv.ParameterError, match="a drive of type Mine has no bond graph"):
        iv.simulate(mine, iv.Scenario(duration=0.1))


def test_a_study_takes_only_what_it_can_use(study):
    good = {"name": "mine", "requirement": iv.Requirement(force=40.0, speed=0.5), "drives": study.drives}
    for wrong, message in (
        ({"drives": {"a": 3}}, "drives.a must be a drive, got a int, which has no method operate"),
        ({"drives": {"a": iv.parts.Motor}}, "drives.a must be a drive, got the class Motor"),
        ({"duty": {"a": iv.motion.Hold(time=1.0)}}, "duty.a must be a DutyCycle"),
        ({"scenarios": {"a": 1}}, "scenarios.a must be a Scenario, got 1"),
        ({"rig": 2}, "rig must be a Rig, got 2"),
        ({"requirement": "x"}, "requirement must be a Requirement, got 'x'"),
        ({"name": ""}, "name must be text that is not empty"),
    ):
        with pytest.raises(iv.ParameterError, match=message):
            iv.Study(**{**good, **wrong})


def test_a_drive_without_limits(installed):
    class Strong:
        def operate(self, *, speed, force):
            point = coil_of(installed).operate(speed=speed, force=force)
            return replace(point, utilisation={})

    mine = iv.Study(name="mine", requirement=iv.Requirement(force=400.0, speed=0.5), drives={"strong": Strong()})
    result = iv.compare(mine, quick=True).results["strong"]
    assert result.covers
    assert result.tightest.value == math.inf


# Limits


def test_a_limit_of_others_is_a_limit(installed, tmp_path):
    magnets = installed.MAGNETS
    assert isinstance(magnets, iv.Limit)
    assert magnets == 100
    assert magnets.name == "MAGNETS"
    assert iv.Limit(100) is magnets
    assert copy.deepcopy(magnets) is magnets
    assert pickle.loads(pickle.dumps(magnets)) is magnets
    assert pickle.loads(pickle.dumps(iv.Limit.SLIP)) is iv.Limit.SLIP
    assert words_of((magnets, "coil")) == "coil: demagnetisation"
    code, margin = binding({iv.Limit.THERMAL: np.array([0.5, 2.0]), magnets: np.array([1.5, 1.0])})
    assert code.tolist() == [100, 2]
    assert code.dtype == np.int8
    assert margin == pytest.approx([1 / 1.5, 0.5])
    assert binding_demand({(magnets, "coil"): np.array(2.0)})[0] == 1
    steady = iv.steady_map(coil_of(installed), [0.1, 0.2], [30.0, 90.0])
    assert steady.limit.tolist() == [[0, 100], [0, 100]]
    assert steady.plot() is not None
    labels = labelled_map(steady).data["limit"][2]
    meanings = dict(zip(labels["flag_meanings"].split(), labels["flag_values"].tolist(), strict=True))
    assert meanings["MAGNETS"] == 100
    assert meanings["SLIP"] == 1
    from scipy.io import netcdf_file

    steady.to_netcdf(tmp_path / "map.nc")
    with netcdf_file(tmp_path / "map.nc", mmap=False) as file:
        stored = file.variables["limit"]
        assert stored[:].tolist() == [[0, 100], [0, 100]]
        assert b"MAGNETS" in stored.flag_meanings


def test_a_code_is_looked_up_among_the_packages(tmp_path, monkeypatch):
    code = 'import infinivar as iv\nROPE = iv.Limit.own("ROPE", 101, "rope strength")\n'
    folder = tmp_path / "site"
    folder.mkdir()
    plugin_package.install(folder, monkeypatch, "[infinivar.limits]\nrope = {0}:ROPE\n", code, "ropelab")
    assert "ropelab" not in sys.modules
    assert iv.Limit(101).words == "rope strength"
    with pytest.raises(ValueError, match="126 is not the code of a limit"):
        iv.Limit(126)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("MAGNETS", 102, "demagnetisation"), "MAGNETS with code 102 .* clashes with MAGNETS with code 100"),
        (("OTHER", 100, "other"), "OTHER with code 100 .* clashes with MAGNETS"),
        (("SLIP", 103, "slip"), "clashes with SLIP with code 1"),
        (("low", 103, "low"), "name must be in capitals"),
        (("LOW", 3, "low"), "code must be from 100 to 127, got 3"),
        (("LOW", True, "low"), "code must be from 100 to 127, got True"),
        (("LOW", 103, " "), "words must be text that is not empty"),
    ],
)
def test_limits_that_cannot_be(installed, arguments, message):
    with pytest.raises(iv.ParameterError, match=message):
        iv.Limit.own(*arguments)


# Motions


@pytest.mark.slow
def test_a_motion_of_others_in_both_ways(installed, study):
    tones = installed.TwoTones(distance=0.02, ripple=0.002, frequency=1.5)
    time = np.linspace(0.0, tones.period, 50)
    step = 1e-4
    for order in range(4):
        rate = (tones.derivatives(time + step, 4)[order] - tones.derivatives(time - step, 4)[order]) / (2.0 * step)
        exact = tones.derivatives(time, 4)[order + 1]
        assert rate == pytest.approx(exact, abs=1e-4 * np.abs(exact).max())
    two = iv.analysis.two_ways(study.drives["cobotic"], iv.DutyCycle(motion=tones, load_mass=0.8))
    assert two.as_turning == pytest.approx(two.followed, rel=0.02)
    run = iv.simulate(study.drives["cobotic"], iv.Scenario(duration=0.2, motion=tones, load_mass=0.8))
    assert np.max(np.abs(run.position_error)) < 1e-3


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"period": -1.0}, "Wrong.period must be > 0 s, got -1.0"),
        ({"period": math.nan}, "Wrong.period must be > 0 s, got nan"),
        ({"made": lambda time, made: made[:2]}, "Wrong.derivatives must return 5 values for 4 orders, .* got 2"),
        (
            {"made": lambda time, made: [made[0], 2.0 * made[1], *made[2:]]},
            "Wrong.derivatives: order 1 must be the time derivative of order 0; at .* instead of",
        ),
        (
            {"made": lambda time, made: [*made[:3], -made[3], made[4]]},
            "Wrong.derivatives: order 3 must be the time derivative of order 2",
        ),
        (
            {"made": lambda time, made: [np.nan * made[0], *made[1:]]},
            "Wrong.derivatives: order 0 must be finite, got nan",
        ),
        (
            {"made": lambda time, made: [made[0] + time, made[1] + 1.0, *made[2:]]},
            "Wrong: a motion that repeats must end where it began, but its position is 0 at 0 s and 0.6",
        ),
        ({"made": lambda time, made: [made[0] + 0.1 * (time > 0.3), *made[1:]]}, "its position is 0 at 0 s and 0.1"),
        ({"push": lambda time: [time, time, time]}, "Wrong.push: order 1 must be the time derivative of order 0"),
    ],
)
def test_a_motion_that_cannot_be_is_refused_when_given(installed, change, message):
    tones = {"distance": 0.02, "ripple": 0.002, "frequency": 1.5}

    class Wrong(installed.TwoTones):
        @property
        def period(self):
            return change.get("period", 1.0 / self.frequency)

        def derivatives(self, time, orders):
            made = installed.TwoTones.derivatives(self, time, orders)
            return change["made"](time, made) if "made" in change else made

        def push(self, time, orders):
            if "push" in change:
                return change["push"](time)
            return installed.TwoTones.push(self, time, orders)

    with pytest.raises(iv.ParameterError, match=message):
        iv.DutyCycle(motion=Wrong(**tones), load_mass=1.0)
    with pytest.raises(iv.ParameterError, match=message):
        iv.Scenario(duration=1.0, motion=Wrong(**tones))


MOTIONS = [
    iv.motion.Sinusoid(distance=0.02, frequency=3.0),
    iv.motion.Reaches(distance=0.1, time=0.3, pause=0.4),
    iv.motion.Reaches(distance=0.1, time=0.3, profile="smooth"),
    iv.motion.Tremor(distance=0.001, low_frequency=8.0, high_frequency=12.0),
    iv.motion.Walking(joint="knee", body_mass=70.0, stride_time=1.1),
    iv.motion.Hold(time=1.0),
]


@pytest.mark.parametrize("motion", MOTIONS, ids=lambda motion: type(motion).__name__)
def test_the_motions_of_the_program_pass_the_probe(motion):
    check_motion(motion)


def test_a_field_of_an_own_class_is_checked(installed):
    with pytest.raises(iv.ParameterError, match="constant must be > 0"):
        replace(coil_of(installed), constant=-1.0)


def test_an_own_class_may_have_any_unit():
    @dataclass(frozen=True, kw_only=True)
    class Odd:
        jolt: float = iv.quantity("N s^2", Gt(0), "Something")

        def __post_init__(self):
            iv.check_fields(self)

    with pytest.raises(iv.ParameterError, match="jolt must be > 0"):
        Odd(jolt=0.0)

"""Studies that extend another, describe a rig, and say how far values may be off."""

import math
import re

import numpy as np
import pytest
from numpy.testing import assert_allclose

import infinivar as iv

HEAD = """
[requirement]
base = "faulring2006"
[drives.cobotic]
base = "faulring2006.cobotic"
[drives.geared]
base = "faulring2006.motor2-gear4"
"""


def loaded(tmp_path, text, **files):
    for name, content in files.items():
        (tmp_path / f"{name}.toml").write_text(content, "utf-8")
    (tmp_path / "study.toml").write_text(text, "utf-8")
    return iv.load_study(tmp_path / "study.toml")


def test_a_study_takes_from_another_what_it_does_not_say(tmp_path):
    below = HEAD + '[drives.cobotic.guideway]\ncoefficient = 0.002\n[duty.shake]\nbase = "faulring2006.shake"\n'
    above = 'extends = "base.toml"\ntitle = "Above"\n[drives.cobotic.guideway]\nfriction = "1 N"\n[requirement]\nforce = "40 N"\n'
    study = loaded(tmp_path, above, base=below)
    assert (study.title, study.name) == ("Above", "study")
    assert (study.requirement.force, study.requirement.speed) == (40.0, 1.05)
    guideway = study.drives["cobotic"].guideway
    assert (guideway.coefficient, guideway.friction) == (0.002, 1.0)
    assert list(study.drives) == ["cobotic", "geared"]
    assert list(study.duty) == ["shake"]
    sources = {row.field: row.where for row in study.provenance if row.owner == "cobotic"}
    assert sources["guideway.coefficient"] == "base.toml"
    assert sources["guideway.friction"] == "study.toml"
    assert sources["transmission.preload"] == "reconstruction A"


def test_measured_groups_take_the_place_of_geometry_in_the_file_below(tmp_path):
    groups = 'creep_stiffness = "3e4 N"\nrolling_torque = "0.4 mN m"\nbearing_torque = "2 mN m"\n'
    below = HEAD + '[drives.cobotic.transmission.geometry]\ncrown_radius = "9 mm"\n'
    above = f'extends = "base.toml"\n[drives.cobotic.transmission]\n{groups}'
    above += '[drives.cobotic.steering]\npatch_half_length = "0.3 mm"\n'
    element = loaded(tmp_path, above, base=below).drives["cobotic"].transmission
    assert element.geometry is None
    assert element.creep_stiffness == 3e4


def test_spreads_of_two_files(tmp_path):
    """What is stated anew is new whole, and leaves its correlations; what the drive no longer has is gone with its spread."""
    spreads = (
        "[uncertainty]\ndraws = 128\n"
        '[uncertainty.cobotic.transmission]\npreload = "5 %"\nfriction = { low = 0.1, high = 0.14 }\n'
        'wheel_radius = "1 %"\n[uncertainty.cobotic.transmission.geometry]\ncrown_radius = "2 %"\n'
        '[uncertainty.cobotic.guideway]\ncoefficient = "10 %"\n'
    )
    pairs = (("preload", "friction"), ("preload", "wheel_radius"), ("wheel_radius", "geometry.crown_radius"))
    for one, other in pairs:
        spreads += '[[correlations]]\ndrive = "cobotic"\nvalue = 0.3\n'
        spreads += f'between = ["transmission.{one}", "transmission.{other}"]\n'
    above = (
        'extends = "base.toml"\n[uncertainty.cobotic.transmission]\nfriction = { deviation = 0.01, kind = "fitted" }\n'
        '[drives.cobotic.transmission]\ncreep_stiffness = "3e4 N"\nrolling_torque = "0.4 mN m"\nbearing_torque = "2 mN m"\n'
        '[drives.cobotic.steering]\npatch_half_length = "0.3 mm"\n'
        '[[correlations]]\ndrive = "cobotic"\nvalue = 0.1\nbetween = ["transmission.friction", "guideway.coefficient"]\n'
    )
    found = loaded(tmp_path, above, base=HEAD + spreads).uncertainty
    assert found.draws == 128
    known = {spread.path: spread for spread in found.spreads["cobotic"]}
    assert known.keys() == {
        *(f"transmission.{name}" for name in ("preload", "friction", "wheel_radius")),
        "guideway.coefficient",
    }
    assert (known["transmission.friction"].deviation, known["transmission.friction"].kind) == (0.01, "fitted")
    assert dict(found.correlations) == {
        ("cobotic", "transmission.preload", "transmission.wheel_radius"): 0.3,
        ("cobotic", "transmission.friction", "guideway.coefficient"): 0.1,
    }


def test_files_are_found_from_the_study_that_names_them(tmp_path):
    inner = tmp_path / "inner"
    inner.mkdir()
    (inner / "motion.csv").write_text(
        "time [s],position [mm]\n" + "".join(f"{t / 20},{math.sin(math.pi * t / 10)}\n" for t in range(21))
    )
    (inner / "base.toml").write_text(HEAD + '[duty.recorded]\nshape = "file"\nfile = "motion.csv"\n', "utf-8")
    study = loaded(tmp_path, 'extends = "inner/base.toml"\n')
    assert study.duty["recorded"].period == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("below", "said"),
    [
        ('titel = "1"', "study.toml: below.toml: titel is not a known key (did you mean 'title'?)"),
        ('extends = "nosuch"', 'study.toml: below.toml: extends = "nosuch" is neither a file beside this one nor'),
        ('extends = "no.toml"', 'study.toml: below.toml: extends = "no.toml": '),
        (
            "format = 2",
            "study.toml: below.toml: format = 2 must be 1; the file is for a newer infinivar: pip install --upgrade",
        ),
    ],
)
def test_a_fault_of_an_extended_study_names_its_file(tmp_path, below, said):
    with pytest.raises(iv.InputError, match=re.escape(said)):
        loaded(tmp_path, 'extends = "below.toml"\n', below=below)


@pytest.mark.parametrize("number", ["0", "1.0", "true", '"1"'])
def test_a_study_states_the_format_it_has(tmp_path, number):
    assert loaded(tmp_path, 'format = 1\nextends = "below.toml"\n', below="format = 1\n" + HEAD).name == "study"
    with pytest.raises(iv.InputError, match=f"study.toml: format = {re.escape(number)} must be 1$"):
        loaded(tmp_path, f"format = {number}\n" + HEAD)


def test_a_shipped_study_goes_by_its_name_unless_a_file_has_it(tmp_path):
    study = loaded(tmp_path, 'extends = "hand_controller"\n[requirement]\nforce = "40 N"\n')
    assert study.requirement.force == 40.0
    assert study.drives == iv.load_study("hand_controller").drives
    (tmp_path / "knee_walking").mkdir()
    assert loaded(tmp_path, 'extends = "knee_walking"\n').drives == iv.load_study("knee_walking").drives
    (tmp_path / "hand_controller").write_text(HEAD, "utf-8")
    assert len(loaded(tmp_path, 'extends = "hand_controller"\n').drives) == 2


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('extends = "nothing.toml"', 'extends = "nothing.toml": nothing.toml: no such file'),
        ("extends = 3", "extends = 3 must be the path of a study file, or the name of a shipped study"),
        ('extends = ""', 'extends = "" must be the path of a study file'),
        (
            'extends = "knee_waking"',
            "extends = \"knee_waking\" is neither a file beside this one nor a shipped study (did you mean 'knee_walking'?); "
            "shipped studies: ankle_walking, ",
        ),
        ('extends = "study.toml"', "check for a circle"),
        ("rig = 3\n" + HEAD, "rig = 3 must be a table [rig]"),
        (HEAD + '[rig]\ntravel = "3 kg"\n', "rig.travel"),
        (HEAD + '[rig]\ncurrent_nois = "3 mA"\n', "did you mean 'current_noise'?"),
        ("uncertainty = 3\n" + HEAD, "uncertainty = 3 must be tables"),
        (HEAD + "[uncertainty]\ndraws = 1000\n", "uncertainty.draws = 1000 must be a power of two"),
        (HEAD + "[uncertainty.cobotc.motor]\nresistance = 0.1\n", "uncertainty.cobotc: the study has no such drive"),
        (HEAD + '[uncertainty.cobotic.motor]\nresistence = "5 %"\n', "did you mean 'motor.resistance'?"),
        (HEAD + '[uncertainty.cobotic.motor]\nresistance = "5 N"\n', "has the unit 'N' where ohm is needed"),
        (HEAD + '[uncertainty.cobotic.motor]\nresistance = "-5 %"\n', "must have a tolerance above zero"),
        (
            HEAD + '[uncertainty.cobotic.motor]\nresistance = "150 %"\n',
            "reaches -1.07 ohm, but the value must be > 0",
        ),
        (
            HEAD + '[uncertainty.cobotic.gearhead]\nefficiency = "20 %"\n',
            "reaches 1.056, but the value must be > 0 and <= 1",
        ),
        (HEAD + '[uncertainty.cobotic.motor]\nresistance = { low = "2 ohm" }\n', "must be stated in exactly one way"),
        (HEAD + '[uncertainty.cobotic.motor]\nresistance = { low = "3 ohm", high = "2 ohm" }\n', "low below high"),
        (
            HEAD + '[uncertainty.cobotic.motor]\nresistance = { low = "3 ohm", high = "4 ohm" }\n',
            "resistance must include the value itself, 2.14 ohm",
        ),
        (
            HEAD + '[uncertainty.cobotic.motor]\nresistance = { tolerance = "5 %", kind = "guessed" }\n',
            "must have one of stated, ",
        ),
        (
            HEAD + '[uncertainty.cobotic.motor]\nresistance = { tolerance = "5 %", deviaton = 3 }\n',
            "did you mean 'deviation'?",
        ),
        (HEAD + '[uncertainty.cobotic.control]\nlink_bandwidth = "5 %"\n', "has no effect: neither steady operation"),
        (HEAD + '[[correlations]]\ndrive = "cobotic"\n', "must have drive, between and value"),
        (
            HEAD + '[[correlations]]\ndrive = "cobotic"\nbetween = ["a", "b"]\nvalue = 0.5\n',
            'drive = "cobotic" must be a drive with a table [uncertainty.DRIVE]',
        ),
        (
            HEAD
            + '[uncertainty.cobotic.motor]\nresistance = "5 %"\ntorque_constant = "5 %"\n'
            + '[[correlations]]\ndrive = "cobotic"\nbetween = ["motor.resistance", "motor.torque_constant"]\nvalue = 1.0\n',
            "must be above -1 and below 1",
        ),
    ],
)
def test_faults_are_named(tmp_path, infinivar, write, text, said):
    outcome = infinivar("compare", write(text))
    assert outcome.code == 2
    assert said in outcome.err
    assert "study.toml: " in outcome.err


def test_spreads_are_read_as_written(tmp_path):
    study = loaded(
        tmp_path,
        HEAD
        + """
        [uncertainty]
        draws = 64
        [uncertainty.cobotic.motor]
        kind = "catalogue"
        where = "data sheet"
        resistance = "10 %"
        torque_constant = { deviation = "3 %" }
        [uncertainty.cobotic.transmission]
        friction = { low = 0.1, high = 0.16, kind = "assumed", where = "dry steel" }
        preload = { tolerance = "20 N" }
        [[correlations]]
        drive = "cobotic"
        between = ["motor.torque_constant", "motor.resistance"]
        value = -0.5
        """,
    )
    assert study.uncertainty.draws == 64
    resistance, constant, friction, preload = study.uncertainty.spreads["cobotic"]
    assert_allclose((resistance.low, resistance.high), (0.9 * 2.14, 1.1 * 2.14))
    assert (resistance.kind, resistance.where) == ("catalogue", "data sheet")
    assert constant.deviation == pytest.approx(0.03 * 0.0256)
    assert (friction.low, friction.high, friction.where) == (0.1, 0.16, "dry steel")
    assert (preload.low, preload.high) == (630.0, 670.0)
    matrix = study.uncertainty.correlation("cobotic")
    assert matrix[0, 1] == matrix[1, 0] == -0.5
    # Quantiles: of the uniform, and of the normal cut off at zero.
    assert_allclose(friction.at([0.0, 0.5, 1.0]), [0.1, 0.13, 0.16])
    assert_allclose(constant.at([0.5, 0.975]), [0.0256, 0.0256 * (1 + 0.03 * 1.959964)], rtol=1e-6)
    assert np.all(constant.at(np.linspace(0, 1, 9)[1:-1]) > 0)


def test_a_wide_normal_spread_keeps_to_what_is_permitted(tmp_path):
    study = loaded(tmp_path, HEAD + '[uncertainty.cobotic.gearhead]\nefficiency = { deviation = "30 %" }\n')
    (spread,) = study.uncertainty.spreads["cobotic"]
    drawn = spread.at(np.linspace(0.001, 0.999, 999))
    assert np.all((drawn > 0) & (drawn <= 1))
    assert np.all(np.diff(drawn) > 0)


def test_the_rig_is_part_of_the_study(tmp_path):
    study = loaded(tmp_path, HEAD + '[rig]\ntravel = "50 mm"\ngravity = "9.79 m/s^2"\n')
    assert (study.rig.travel, study.rig.gravity) == (0.05, 9.79)
    assert study.rig.current_noise == 0.02

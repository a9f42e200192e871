"""Where sets of parts are found, and studies that name parts of them."""

import sys

import pytest

import infinivar as iv
import partfiles
import plugin_package
from internals import extended_schema, importing, stores

STUDY = """
[requirement]
force = "5 N"
speed = "0.1 m/s"

[drives.geared]
type = "conventional"

[drives.geared.motor]
part = "{motor}"
mass = "0.5 kg"

[drives.geared.gearhead]
part = "{gearhead}"

[drives.geared.pulley]
radius = "10 mm"
"""
T1 = STUDY.format(motor="mine:t1", gearhead="mine:h1")
OTHER = (
    '[motors.t1]\nvoltage = "48 V"\nresistance = "1 ohm"\ntorque_constant = "0.1 N m/A"\nno_load_current = "0.1 A"\n'
)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A user's folder of sets."""
    monkeypatch.setenv("INFINIVAR_PARTS", str(tmp_path / "home"))
    (tmp_path / "home").mkdir()
    return tmp_path


def write_study(folder, text=T1, name="study.toml"):
    folder.mkdir(exist_ok=True)
    return partfiles.write(folder, name, text)


def test_a_study_uses_parts_of_the_users_folder(folder):
    partfiles.write(folder / "home", "mine.toml", partfiles.TOML)
    study = iv.load_study(write_study(folder))
    motor = study.drives["geared"].motor
    assert motor == iv.parts.Motor(
        name="T 1",
        voltage=24.0,
        resistance=0.5,
        torque_constant=0.03,
        no_load_current=0.1,
        continuous_torque=0.09,
        mass=0.5,
    )
    rows = {row.field: row for row in study.provenance}
    assert rows["motor.torque_constant"].written == "0.03 N m/A"
    assert rows["motor.torque_constant"].kind == "catalogue"
    # Set and key, manufacturer and order number, source and date.
    assert rows["motor.torque_constant"].where == "mine:t1, Made Up 4711, data sheet 7, 2024-05"
    assert (rows["motor.mass"].kind, rows["motor.mass"].where) == ("assumed", "study.toml")
    assert study.drives["geared"].gearhead.ratio == 4.0
    # What is saved needs the set no more.
    (folder / "home" / "mine.toml").unlink()
    assert iv.load_study(study.save(folder / "again.toml")) == study


def test_a_stored_part_is_the_same_to_the_last_digit(folder):
    made = iv.import_parts(partfiles.write_mgdb(folder), name="made")
    importing.write(made.parts, folder / "home" / "made.npz")
    study = iv.load_study(write_study(folder, STUDY.format(motor="made:XX_B2", gearhead="made:XX_G16_R16:1")))
    motor, gearhead = study.drives["geared"].motor, study.drives["geared"].gearhead
    expected = made.parts.motors.part("XX_B2")
    for name in ("viscous_friction", "continuous_torque", "rotor_inertia", "no_load_current", "max_speed"):
        assert getattr(motor, name) == getattr(expected, name), name
    assert gearhead == made.parts.gearheads.part("XX_G16_R16:1")
    kinds = {row.field: (row.kind, row.where.partition(",")[0]) for row in study.provenance}
    assert kinds["motor.continuous_torque"] == ("derived", "made:XX_B2")
    assert kinds["motor.resistance"] == ("catalogue", "made:XX_B2")


def test_measured_friction_of_a_set_reaches_the_drive(folder):
    partfiles.write(folder / "home", "mine.toml", partfiles.TOML)
    study = iv.load_study(write_study(folder, STUDY.format(motor="shipped:re-40-24v", gearhead="mine:h2")))
    assert study.drives["geared"].gearhead.friction.friction == 5.0
    assert study.drives["geared"].motor.resistance == iv.motors()["re-40-24v"].resistance


def test_sets_beside_the_study_come_first(folder):
    partfiles.write(folder / "home", "mine.toml", OTHER)
    with pytest.raises(iv.InputError, match="'mine:h1' is not among the gearheads of mine"):
        iv.load_study(write_study(folder))
    (folder / "parts").mkdir()
    partfiles.write(folder / "parts", "mine.toml", partfiles.TOML)
    assert iv.load_study(write_study(folder)).drives["geared"].motor.voltage == 24.0
    # The same from tables in Python, with the folder named.
    tables = {"requirement": {"force": "5 N", "speed": "0.1 m/s"}, "drives": {"a": {"type": "conventional"}}}
    tables["drives"]["a"] |= {
        "motor": {"part": "mine:t1"},
        "gearhead": {"part": "mine:h1"},
        "pulley": {"radius": "1 cm"},
    }
    assert iv.Study.from_dict(tables, name="x", folder=folder).drives["a"].motor.mass == 0.3


@pytest.mark.slow
def test_a_study_names_files_and_folders_of_sets(folder):
    (folder / "shelf").mkdir()
    partfiles.write(folder / "shelf", "mine.toml", partfiles.TOML)
    for named in ('"shelf"', '"shelf/mine.toml"', '["parts", "shelf"]'):
        study = iv.load_study(write_study(folder, f"parts = {named}\n{T1}"))
        assert study.drives["geared"].motor.voltage == 24.0
    with pytest.raises(iv.InputError, match=r'parts = "shelv": no such file or folder'):
        iv.load_study(write_study(folder, f'parts = "shelv"\n{T1}'))
    with pytest.raises(iv.InputError, match="parts = 3 must be the path of a file or folder"):
        iv.load_study(write_study(folder, f"parts = 3\n{T1}"))
    assert "parts" in extended_schema()["properties"]


def test_a_study_that_extends_another_finds_its_parts(folder):
    write_study(folder / "base")
    (folder / "base" / "parts").mkdir()
    partfiles.write(folder / "base" / "parts", "mine.toml", partfiles.TOML)
    above = 'extends = "../base/study.toml"\n[drives.geared.pulley]\nradius = "20 mm"\n'
    study = iv.load_study(write_study(folder / "over", above))
    assert study.drives["geared"].motor.voltage == 24.0
    assert study.drives["geared"].pulley.radius == 0.02


@pytest.mark.parametrize(
    ("motor", "message"),
    [
        ("mine:t11", r"'mine:t11' is not among the motors of mine \(did you mean 't1'\?\)"),
        ("mine:h1", "'mine:h1' is not among the motors of mine"),
        ("mine:t2", "'mine:t2' was refused: mine.toml:16: t2: resistance = '0.5 ohm m' has the unit"),
        ("mien:t1", r"'mien' is not a set of parts \(did you mean 'mine'\?\); sets: shipped, mine"),
        ("shipped:re-40", r"'re-40' is not in the catalogue of motors \(did you mean 're-40-24v'\?\)"),
    ],
)
def test_parts_that_are_not_there(folder, motor, message):
    partfiles.write(folder / "home", "mine.toml", partfiles.TOML)
    with pytest.raises(iv.InputError, match=message):
        iv.load_study(write_study(folder, STUDY.format(motor=motor, gearhead="mine:h1")))


def test_an_incomplete_part_can_be_completed_in_the_study(folder):
    made = iv.import_parts(partfiles.write_mgdb(folder), name="made")
    importing.write(made.parts, folder / "home" / "made.npz")
    text = STUDY.format(motor="made:XX_C3", gearhead="made:XX_G22_R5:1")
    with pytest.raises(iv.InputError, match=r"motor\.no_load_current is missing"):
        iv.load_study(write_study(folder, text))
    text = text.replace('mass = "0.5 kg"', 'no_load_current = "0.2 A"\ncontinuous_torque = "0.4 N m"')
    text = text.replace('part = "made:XX_G22_R5:1"', 'part = "made:XX_G22_R5:1"\nefficiency = 0.8')
    assert iv.load_study(write_study(folder, text)).drives["geared"].motor.resistance == 0.9


def test_places_are_listed_in_their_order(folder):
    partfiles.write(folder / "home", "mine.toml", partfiles.TOML)
    partfiles.write(folder / "home", "notes.txt", "no set")
    partfiles.write(folder / "home", "bad name.toml", partfiles.TOML)
    importing.write(
        iv.import_parts(partfiles.write(folder, "mine.toml", partfiles.TOML)).parts, folder / "home" / "two.npz"
    )
    assert [place.name for place in stores.places()] == ["shipped", "two", "mine"]
    beside = stores.places([folder / "mine.toml"])
    assert [(place.name, place.path) for place in beside[:2]] == [("shipped", None), ("mine", folder / "mine.toml")]
    assert [place.name for place in beside] == ["shipped", "mine", "two"]


def test_load_parts(folder):
    path = partfiles.write(folder, "mine.toml", partfiles.TOML)
    with pytest.raises(iv.InputError, match=r"mine\.toml:16: t2: resistance"):
        iv.load_parts(path)
    partfiles.write(folder / "home", "plain.toml", OTHER)
    assert iv.load_parts("plain").motors["voltage"].tolist() == [48.0]
    # A file that changes is read again.
    partfiles.write(folder / "home", "plain.toml", OTHER.replace("48 V", "480 V"))
    assert iv.load_parts("plain").motors["voltage"].tolist() == [480.0]
    assert iv.load_parts() is iv.load_parts("shipped")
    with pytest.raises(iv.InputError, match="'nonsense' is not a set of parts"):
        iv.load_parts("nonsense")


def test_the_users_folder_follows_the_platform(monkeypatch):
    import platformdirs

    monkeypatch.delenv("INFINIVAR_PARTS")
    assert stores.users_folder() == platformdirs.user_data_path("infinivar", appauthor=False) / "parts"


PACKAGE = """
from pathlib import Path

import infinivar as iv

FILE = Path(__file__).parent / "mine.toml"


def made():
    return iv.import_parts(FILE).parts


def nothing():
    return 3


def boom():
    raise RuntimeError("boom")
"""


@pytest.fixture
def installed(folder, monkeypatch):
    """A package that registers sets in every way there is."""
    site = folder / "site"
    site.mkdir()
    partfiles.write(site, "mine.toml", partfiles.TOML)
    points = {"filed": "FILE", "made": "made", "empty": "nothing", "gone": "none", "boom": "boom", "shipped": "made"}
    words = "".join(f"{name} = shelf:{value}\n" for name, value in points.items())
    plugin_package.install(site, monkeypatch, f"[infinivar.catalogues]\n{words}", PACKAGE, "shelf")
    yield
    sys.modules.pop("shelf", None)


def test_packages_add_sets(installed, folder):
    assert [place.name for place in stores.places()] == ["shipped", "filed", "made", "empty", "gone", "boom"]
    for name in ("filed", "made"):
        study = iv.load_study(write_study(folder, STUDY.format(motor=f"{name}:t1", gearhead=f"{name}:h1")))
        assert study.drives["geared"].motor.voltage == 24.0
        assert stores.find(name).parts.name == name
    with pytest.raises(iv.InputError, match="'empty' must be a PartSet or the path of a file, got a int"):
        stores.find("empty")
    with pytest.raises(
        iv.InputError,
        match=r"the set of parts 'boom' \(shelf:boom of shelf 1.2\) fails when it is called: RuntimeError: boom",
    ):
        stores.find("boom")
    with pytest.raises(iv.InputError, match=r"the set of parts 'gone' \(shelf:none of shelf 1.2\) cannot be loaded"):
        stores.find("gone")


def test_sets_that_cannot_be_read_are_left_out_where_none_is_named(installed, folder):
    partfiles.write(folder / "home", "mine.toml", partfiles.TOML)
    (folder / "home" / "bad.npz").write_bytes(b"PK nonsense")
    found, problems = stores.readable()
    assert [one.parts.name for one in found] == ["shipped", "mine", "filed", "made"]
    assert [line.partition(",")[0] for line in problems] == [
        f"the set {name} was left out" for name in ("bad", "empty", "gone", "boom")
    ]
    assert "bad.npz: is no set of parts" in problems[0]


@pytest.mark.parametrize("model", ["", 'loss_model = "coulomb"', 'loss_model = "proportional"'])
def test_a_study_uses_the_backdriving_efficiency_of_a_set_where_it_applies(folder, model):
    partfiles.write(folder / "home", "mine.toml", partfiles.TOML + '\n[gearheads.b]\nratio = 4\nefficiency = 0.9\n'
                    "backdriving_efficiency = 0.7\n")  # fmt: skip
    text = STUDY.format(motor="mine:t1", gearhead="mine:b").replace('"mine:b"', f'"mine:b"\n{model}')
    gearhead = iv.load_study(write_study(folder, text)).drives["geared"].gearhead
    assert gearhead.backdriving_efficiency == (0.7 if "proportional" in model else None)
    own = text.replace('"mine:b"', '"mine:b"\nbackdriving_efficiency = 0.6')
    if "proportional" in model:
        assert iv.load_study(write_study(folder, own)).drives["geared"].gearhead.backdriving_efficiency == 0.6
    else:  # the study itself states what does not apply
        with pytest.raises(iv.InputError, match="backdriving_efficiency does not apply"):
            iv.load_study(write_study(folder, own))


def test_bearings_and_materials_of_a_set_reach_the_transmission(folder):
    text = """
[bearings.x8]
series = "60"
bore = "8 mm"
outside_diameter = "22 mm"
dynamic_rating = "3.3 kN"
static_rating = "1.3 kN"
[materials.steel]
youngs_modulus = "205 GPa"
poisson = 0.29
"""
    partfiles.write(folder / "home", "mine.toml", text)
    study = """
[requirement]
force = "20 N"
speed = "0.5 m/s"
[drives.cobotic]
base = "faulring2006.cobotic"
[drives.cobotic.transmission.geometry.axle_bearing]
part = "mine:x8"
[drives.cobotic.transmission.geometry.wheel_material]
part = "mine:steel"
"""
    geometry = iv.load_study(write_study(folder, study)).drives["cobotic"].transmission.geometry
    assert geometry.axle_bearing == iv.load_parts("mine").bearings.part("x8")
    assert geometry.wheel_material.youngs_modulus == 205e9

"""A cobotic drive described part by part, and the mistakes that are made in it: one clear line, exit 2, nothing written."""

import math

import pytest

import infinivar as iv
from infinivar import contact_sheets
from wheels import GOOD

GEOMETRY = "drives.arm.transmission.geometry"
BEARING = f"{GEOMETRY}.axle_bearing"
WITHOUT_GEOMETRY = GOOD.partition(f"[{GEOMETRY}]")[0]


def put(old, new):
    assert old in GOOD
    return GOOD.replace(old, new)


def beside(line, addition):
    return put(line, f"{addition}\n{line}")


FAULTS = {
    "wrong unit": (
        put('crown_radius = "12 mm"', 'crown_radius = "12 N"'),
        f'{GEOMETRY}.crown_radius = "12 N" has the unit',
    ),
    "no unit": (put('crown_radius = "12 mm"', "crown_radius = 12"), f"{GEOMETRY}.crown_radius = 12 needs a unit"),
    "negative": (put('crown_radius = "12 mm"', 'crown_radius = "-12 mm"'), "must be > 0 m, such as 10 mm"),
    "misspelt in geometry": (put("crown_radius", "crown_radus"), "(did you mean 'crown_radius'?)"),
    "misspelt in a bearing": (put("viscosity", "viscocity"), f"{BEARING}.viscocity = "),
    "misspelt in a material": (put('"440c" }', '"440c", poison = 0.3 }'), "(did you mean 'poisson'?)"),
    "unknown part": (put('"440c"', '"440d"'), "'440d' is not in the catalogue of materials (did you mean '440c'?)"),
    "part of another catalogue": (put('part = "608"', 'part = "440c"'), "'440c' is not in the catalogue of bearings"),
    "impossible material": (put('"440c" }', '"440c", poisson = 0.7 }'), "poisson = 0.7 must be >= 0 and <= 0.5"),
    "material left out": (
        put('wheel_material = { part = "440c" }\n', ""),
        "wheel_material is missing (Material of the wheel)",
    ),
    "material by name": (
        put('{ part = "440c" }', '"440c"'),
        "must be a table [drives.arm.transmission.geometry.wheel_material]",
    ),
    "geometry and groups": (
        beside("creep_law", 'creep_stiffness = "17 kN"'),
        "creep_stiffness and geometry exclude each other",
    ),
    "one group": (WITHOUT_GEOMETRY + 'creep_stiffness = "17 kN"\n', "transmission.rolling_torque is missing: give"),
    "no contact": (WITHOUT_GEOMETRY, "transmission.creep_stiffness is missing: give"),
    "two bells": (
        beside("sliding_friction", 'bell_friction = "1 mm"'),
        "bell_friction and bell_bearing exclude each other",
    ),
    "no bell": (
        GOOD.partition("[drives.arm.steering.bell_bearing]")[0],
        "steering.bell_friction is missing: give it, or",
    ),
    "patch twice": (beside("sliding_friction", 'patch_half_length = "1 mm"'), "exclude each other"),
    "model without constants": (
        beside('viscosity = "50', 'type = "needle"'),
        f"{BEARING}.friction_model must be coefficient",
    ),
    "bearing that cannot": (
        beside('viscosity = "50', 'type = "thrust_ball"'),
        f"{BEARING}.type must be deep_groove",
    ),
    "bell that cannot": (
        GOOD + 'type = "needle"\nfriction_model = "coefficient"\n',
        "steering.bell_bearing.type must be deep_groove, angular_contact or thrust_ball",
    ),
    "unknown type": (beside('viscosity = "50', 'type = "ball"'), 'type = "ball" must be one of deep_groove'),
    "bore of another": (beside('viscosity = "50', 'bore = "30 mm"'), f"{BEARING}.outside_diameter must be > bore"),
    "oil bath without level": (
        beside('viscosity = "50', 'lubrication = "oil_bath"'),
        f"{BEARING}.oil_level must be set if",
    ),
    "friction that falls": (beside("bearing_span", "fast_friction_ratio = 0.5"), "friction_decay_speed is missing"),
    "misspelt law": (put('"fastsim"', '"fastsym"'), 'creep_law = "fastsym" must be one of linear'),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_faults(infinivar, write, tmp_path, fault):
    text, said = FAULTS[fault]
    done = infinivar("contact", write(text), "--out", "result")
    assert done.code == 2
    assert said in done.err
    assert all(
        line.startswith(("study.toml: ", "infinivar: study.toml: drives.arm.")) for line in done.err.splitlines()
    )
    assert done.err.count("study.toml: study.toml") == 0
    assert done.out == ""
    assert not (tmp_path / "result").exists()


@pytest.mark.slow
def test_a_drive_of_its_own(infinivar, write):
    """From the sheet to a comparison."""
    done = infinivar("contact", write(GOOD), "--out", "result")
    assert (done.code, done.err) == (0, "")
    assert "–" not in done.out
    # By hand: SKF's formulas in mm, N and r/min for 225.7 N with 30 N axial and for 174.3 N, 397.9 r/min, 50 mm2/s.
    assert "bearing torque             tau_wa      4.425 mN m   two 608, SKF model, lateral force 30 N" in done.out
    # By scipy's elliptic integrals and a root finder.
    assert "peak pressure              p0            2.16 GPa" in done.out
    assert infinivar("compare", "study.toml", "--out", "result").code == 0


@pytest.mark.parametrize("law", ["linear", "faulring", "vermeulen-johnson", "polach"])
def test_every_law_by_name(write, tmp_path, law):
    (sheet,) = contact_sheets(iv.load_study(tmp_path / write(put('"fastsim"', f'"{law}"'))))
    assert sheet.drive.transmission.creep_law.name == law
    missing = [(line.name, line.how) for line in sheet.lines if not math.isfinite(line.value)]
    # At 1:1 half the slip force is 0.71 of it sideways: there the loss of Eq 17 already means a creepage beyond full slip.
    slips = ("at 1:1", "surface speed : link speed; the wheel slips, or the rolling loss exceeds the transmitted power")
    assert missing == ([slips] if law == "faulring" else [])


@pytest.mark.parametrize(
    "table",
    [
        'viscosity = "200 mm^2/s"',
        'part = "608"',
        'part = "6004"\nfriction_model = "coefficient"',
        'type = "angular_contact"',
    ],
)
def test_parts_of_a_base_can_be_changed(write, tmp_path, table):
    base = '[requirement]\nbase = "faulring2006"\n[drives.arm]\nbase = "faulring2006.cobotic"\n'
    (sheet,) = contact_sheets(iv.load_study(tmp_path / write(f"{base}[{BEARING}]\n{table}\n")))
    assert all(math.isfinite(line.value) for line in sheet.lines)


@pytest.mark.slow
@pytest.mark.parametrize("preload", ["1e-9 N", "1e6 N"])
@pytest.mark.renders("svg")
def test_the_absurd_has_a_sheet_too(infinivar, write, preload):
    """No nan, no traceback: where nothing moves the sheet has a dash and says why."""
    done = infinivar("contact", write(put('"400 N"', f'"{preload}"')), "--out", "result")
    assert done.code == (1 if preload == "1e6 N" else 0)
    assert " nan" not in done.out
    assert "–   surface speed : link speed; the wheel slips" in done.out

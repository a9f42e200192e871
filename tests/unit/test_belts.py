"""Belts of the catalogue: by name in a study, and chosen by their pitch for the mass of a stage."""

import tomllib
from dataclasses import replace

import numpy as np
import pytest

import infinivar as iv
from infinivar.parts import Belt, Structure
from internals import Service
from made import loaded

KNEE = loaded("knee_walking")
GEARED = KNEE.drives["geared"]
SERVICE = Service(0.3, 75.0)


def stage(belt, service=SERVICE, **structure):
    """The body with pulleys and belt."""
    drive = replace(GEARED, pulley=None, belt=belt, structure=Structure(**structure))
    return next(body for body in drive.bodies(service) if body.name == "belt")


def test_every_row_can_be_chosen_and_a_type_scales_with_its_width():
    types = {}
    for belt in iv.belts().values():
        assert None not in (belt.width, belt.belt_density, belt.permissible_force), belt.name
        types.setdefault(belt.name.split(",")[0], []).append(belt)
    assert len(iv.belts()) > 50
    for name, found in types.items():
        density = np.array([one.belt_density / one.width for one in found])
        assert np.ptp(density) < 0.15 * density.mean(), name
        assert 1.0 <= density.min() <= density.max() < 7.5, name  # kg/m over m is g/m over mm
        force = [one.permissible_force for one in sorted(found, key=lambda one: one.width)]
        assert force == sorted(force), name


def test_a_study_names_a_belt_of_the_catalogue():
    raw = tomllib.loads(KNEE.to_toml())
    del raw["drives"]["geared"]["pulley"]
    raw["drives"]["geared"]["belt"] = {"part": "elatech-t5-16", "teeth": 16}
    study = iv.Study.from_dict(raw, name="belted")
    belt = study.drives["geared"].belt
    assert (belt.pitch, belt.permissible_force, belt.specific_stiffness) == pytest.approx((5e-3, 570.0, 142.5e3))
    assert belt.stiffness is None  # without a span
    kinds = {row.field: (row.kind, row.where) for row in study.provenance if row.owner == "geared"}
    assert kinds["belt.permissible_force"] == ("catalogue", "elatech2012, through a copy of a dealer")
    again = iv.Study.from_dict(tomllib.loads(study.to_toml()), name="again")
    assert again.drives["geared"].belt == belt
    raw["drives"]["geared"]["belt"] |= {"span": "0.5 m", "permissible_force": "400 N"}
    belt = iv.Study.from_dict(raw, name="belted").drives["geared"].belt
    assert (belt.stiffness, belt.permissible_force) == pytest.approx((142.5e3 / 0.5, 400.0))
    raw["drives"]["geared"]["belt"]["part"] = "elatech-t5-17"
    with pytest.raises(iv.InputError, match=r"'elatech-t5-17' is not in the catalogue of belts.*elatech-t5-1"):
        iv.Study.from_dict(raw, name="belted")


def test_the_lightest_belt_of_the_pitch_that_carries_the_taut_span_is_weighed():
    belt = Belt(pitch=5e-3, teeth=20)
    taut = 0.5 * (2.5 * 75.0 + 75.0)
    carrying = [one for one in iv.belts().values() if one.pitch == 5e-3 and one.permissible_force >= taut]
    chosen = min(carrying, key=lambda one: one.belt_density)
    made = stage(belt)
    assert chosen.name in made.basis
    stated = stage(replace(belt, width=chosen.width, belt_density=chosen.belt_density))
    assert made.mass == pytest.approx(stated.mass, rel=1e-12)
    assert stage(belt, Service(0.3, 1000.0)).mass > made.mass
    assert stage(belt, pull_ratio=20.0).mass > made.mass


def test_a_belt_that_the_catalogue_does_not_have_follows_the_assumed_factors():
    belt = Belt(pitch=8e-3, teeth=20)
    made = stage(belt)
    assert made.basis.endswith("belt or cable")
    assert stage(belt, pulley_width=0.02, belt_density=0.06).mass == pytest.approx(2.0 * made.mass, rel=1e-12)
    assert stage(Belt(pitch=5e-3, teeth=20), pulley_width=0.02, belt_density=0.06) == stage(Belt(pitch=5e-3, teeth=20))


def test_many_designs_weigh_as_each_alone():
    teeth, force = np.array([16.0, 20.0, 40.0, 20.0]), np.array([20.0, 75.0, 800.0, 1e4])
    made = stage(Belt(pitch=5e-3, teeth=teeth), Service(0.3, force)).mass
    alone = [
        stage(Belt(pitch=5e-3, teeth=float(n)), Service(0.3, float(f))).mass for n, f in zip(teeth, force, strict=True)
    ]
    assert [None if np.isnan(one) else one for one in made] == pytest.approx(alone, rel=1e-12)

"""Friction of a guideway: as stated, or that of its rail by the maker's model."""

import tomllib
from dataclasses import replace

import numpy as np
import pytest

import infinivar as iv
from infinivar.motion import ConstantForce
from infinivar.parts import Guideway
from made import loaded
from rigs import session

KNEE = loaded("knee_walking")
RAIL = iv.rails()["hgh15ca"]
OF_RAIL = Guideway(friction_model="rail", rail=RAIL)
STATED = Guideway(friction=2.36, coefficient=0.004, rail=RAIL)
"""Two end seals of 1.18 N and 0.004: hiwin2018."""


def with_guideway(name, guideway):
    return replace(KNEE.drives[name], guideway=guideway)


def test_the_maker_model_is_seals_and_a_share_of_the_load():
    assert OF_RAIL.friction_force(2200.0) == pytest.approx(2.36 + 0.004 * 2200.0, rel=1e-12)
    assert OF_RAIL.friction_force() == pytest.approx(2.36, rel=1e-12)
    assert OF_RAIL.follows(2200.0) == pytest.approx(STATED.follows(2200.0), rel=1e-12)
    assert {name for name, rail in iv.rails().items() if rail.seal_friction is None} == {
        name for name in iv.rails() if name.startswith("mg")
    }


@pytest.mark.parametrize("name", ["cobotic", "geared"])
def test_stated_and_from_the_rail_agree_steady_in_motion_and_in_time(name):
    ways = [with_guideway(name, guideway) for guideway in (OF_RAIL, STATED)]
    speed, force = np.array([-0.2, 0.1, 0.2]), np.array([50.0, 50.0, -80.0])
    maps = [iv.steady_map(drive, speed, force) for drive in ways]
    np.testing.assert_allclose(maps[0].power_in, maps[1].power_in, rtol=1e-12)
    np.testing.assert_allclose(maps[0].losses["guideway"], maps[1].losses["guideway"], rtol=1e-12)
    motion = KNEE.duty["walking"]
    energies = [iv.duty_cycle(drive, motion).energy for drive in ways]
    assert energies[0] == pytest.approx(energies[1], rel=1e-12)
    assert energies[0] > iv.duty_cycle(with_guideway(name, Guideway()), motion).energy
    scenario = iv.Scenario(
        duration=0.05, motion=iv.motion.Hold(time=1.0), load_mass=1.0, force=ConstantForce(size=30.0)
    )
    lost = [iv.simulate(drive, scenario).history.lost for drive in ways]
    assert {name: energy[-1] for name, energy in lost[0].items()} == pytest.approx(
        {name: energy[-1] for name, energy in lost[1].items()}, rel=1e-9
    )


def test_a_study_takes_the_friction_of_a_catalogue_rail():
    raw = tomllib.loads(KNEE.to_toml())
    raw["drives"]["geared"]["guideway"] = {"friction_model": "rail", "rail": {"part": "hgh15ca"}}
    study = iv.Study.from_dict(raw, name="railed")
    assert study.drives["geared"].guideway == OF_RAIL
    again = iv.Study.from_dict(tomllib.loads(study.to_toml()), name="again")
    assert again.drives["geared"].guideway == OF_RAIL


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"rail": None}, r'rail is missing: friction_model = "rail" needs it'),
        ({"rail": iv.rails()["mgn9c"]}, r'rail\.seal_friction is missing: friction_model = "rail" needs it'),
        (
            {"friction": 1.0},
            r'friction must be 0 with friction_model = "rail", also where a base states another, got 1',
        ),
        ({"coefficient": 0.01}, r'coefficient must be 0 with friction_model = "rail", also .* got 0\.01'),
        ({"friction_model": "maker"}, "friction_model must be one of stated, rail, got 'maker'"),
    ],
)
def test_a_rail_that_cannot_give_the_friction_is_refused(values, message):
    with pytest.raises(iv.ParameterError, match=message):
        replace(OF_RAIL, **values)


def test_the_coefficient_of_the_maker_turns_the_verdict_of_the_knee_study():
    motion = KNEE.duty["walking"]
    guideway = Guideway(friction_model="rail", rail=replace(iv.rails()["mgn12h"], seal_friction=0.0))
    energies = [
        iv.duty_cycle(drive, motion).energy for drive in (*KNEE.drives.values(), with_guideway("cobotic", guideway))
    ]
    assert energies == pytest.approx([5.70, 5.79, 6.20], abs=0.005)


def test_a_calibration_fits_the_values_of_the_rail(study):
    raw = tomllib.loads(study.to_toml())
    raw["drives"]["cobotic"]["guideway"] = {"friction_model": "rail", "rail": {"part": "hgh15ca"}}
    study = iv.Study.from_dict(raw, name="railed")
    found = iv.calibrate(study, "cobotic", session(study.drives["cobotic"], 4))
    made, preload = found.calibrated.guideway, study.drives["cobotic"].transmission.preload
    assert made.friction_model == "rail"
    assert made.friction_force(preload) == pytest.approx(found.fit.values["guideway_friction"], rel=1e-12)
    assert made.follows(preload) == pytest.approx(OF_RAIL.follows(preload), rel=1e-9)


def test_backing_rollers_leave_no_load_on_the_rail():
    bearings = iv.parts.CylinderBearings(bearing=iv.bearings()["6004"], backing_rollers=1)
    with pytest.raises(
        iv.ParameterError, match=r"guideway\.rail\.friction_coefficient must be 0 with cylinder_bearings"
    ):
        replace(with_guideway("cobotic", OF_RAIL), cylinder_bearings=bearings)

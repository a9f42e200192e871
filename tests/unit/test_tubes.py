"""A cylinder whose wall is stated: its inertia in the drive, its strength as a limit, its lines on the sheet."""

from dataclasses import replace

import numpy as np
import pytest

import infinivar as iv
from infinivar import Limit
from made import loaded

KNEE = loaded("knee_walking")
DRIVE = KNEE.drives["cobotic"]
TUBE = {"cylinder_wall": 0.003, "cylinder_length": 0.1, "cylinder_end_plate": 0.005}


def with_tube(drive=DRIVE, **changed):
    return replace(drive, transmission=replace(drive.transmission, **{**TUBE, **changed}))


def test_a_stated_inertia_wins_over_that_of_the_tube():
    drive = with_tube()
    assert drive.inertia_of_cylinder == DRIVE.cylinder_inertia
    derived = replace(drive, cylinder_inertia=None)
    assert derived.inertia_of_cylinder == drive.transmission.tube.inertia
    assert derived.turning_inertia == pytest.approx(
        drive.turning_inertia - DRIVE.cylinder_inertia + drive.transmission.tube.inertia
    )
    # A motion needs it: without wall and inertia it is asked for.
    unknown = replace(DRIVE, cylinder_inertia=None)
    with pytest.raises(iv.InputError, match="cylinder_inertia is missing"):
        assert unknown.turning_inertia


def test_the_energy_of_a_cycle_is_that_of_the_same_inertia_stated():
    cycle = KNEE.duty["walking"]
    derived = replace(with_tube(), cylinder_inertia=None)
    stated = replace(DRIVE, cylinder_inertia=derived.transmission.tube.inertia)
    assert iv.duty_cycle(derived, cycle).energy == pytest.approx(iv.duty_cycle(stated, cycle).energy, rel=1e-12)


def test_the_wall_is_a_limit_of_the_preload():
    thick, thin = with_tube(), with_tube(cylinder_wall=0.001)
    contact = thick.transmission.contact
    area = (contact.patch.a * contact.patch.b) ** 0.5
    expected = thick.transmission.preload * thick.transmission.tube.tension(0.05, area) / 2000e6
    assert thick.transmission.utilisation[Limit.WALL] == pytest.approx(expected, rel=1e-12)
    assert thin.transmission.utilisation[Limit.WALL] > 1.0
    assert Limit.WALL not in DRIVE.transmission.utilisation


def test_without_a_yield_strength_there_is_no_limit_and_without_a_density_no_mass():
    geometry = DRIVE.transmission.geometry
    soft = replace(geometry.cylinder_material, yield_strength=None, density=None)
    element = replace(DRIVE.transmission, geometry=replace(geometry, cylinder_material=soft), **TUBE)
    assert Limit.WALL not in element.utilisation
    assert (element.tube.mass, element.tube.inertia, element.tube.first_mode) == (None, None, None)
    study = replace(KNEE, drives={"cobotic": replace(DRIVE, transmission=element)})
    sheet = iv.contact_sheets(study)[0]
    assert sheet.value("mass") != sheet.value("mass")
    assert next(line.how for line in sheet.lines if line.name == "tension in the wall").endswith(
        "yield strength unknown"
    )


def test_of_many_designs_those_whose_wall_does_not_fit_are_beyond_the_limit():
    element = DRIVE.transmission
    many = replace(element, cylinder_radius=np.array([0.002, 0.02, 0.05, 0.9]), **{**TUBE, "cylinder_length": 0.2})
    demand = many.utilisation[Limit.WALL]
    assert np.isinf(demand).tolist() == [True, False, False, True]
    assert np.all(demand > 0.0)


def test_the_sheet_states_it():
    study = replace(KNEE, drives={"cobotic": with_tube()})
    sheet = iv.contact_sheets(study)[0]
    tube = study.drives["cobotic"].transmission.tube
    assert sheet.value("mass") == tube.mass
    assert sheet.value("ovalisation") == pytest.approx(2200.0 * tube.ovalisation(0.05))
    assert Limit.WALL in sheet.utilisation
    lines = {line.name: line.how for line in sheet.lines}
    assert lines["inertia"] == "about its axis; the drive states 2.6 g m^2, which is used"
    assert "estimate" not in lines["ovalisation"]
    thick = iv.contact_sheets(replace(KNEE, drives={"cobotic": with_tube(cylinder_wall=0.01)}))[0]
    assert next(line.how for line in thick.lines if line.name == "ovalisation").endswith(
        "; an estimate, as R/t = 4.5 is below 10"
    )
    thin = iv.contact_sheets(replace(KNEE, drives={"cobotic": with_tube(cylinder_wall=0.001)}))[0]
    assert thin.verdict.startswith("OVER-STRESSED: cylinder wall, ")


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        (
            {"cylinder_wall": 0.05},
            "cylinder_wall must be 0.25 mm to 45 mm, 0.005 to 0.9 times cylinder_radius, got 50 mm",
        ),
        ({"cylinder_wall": 1e-9}, "cylinder_wall must be 0.25 mm to 45 mm, .* got 1e-6 mm"),
        ({"cylinder_length": 1e-9}, "cylinder_length must be 25 mm to 1000 mm, 0.5 to 20 times cylinder_radius"),
        ({"cylinder_length": 10.0}, "cylinder_length must be 25 mm to 1000 mm"),
        ({"cylinder_end_plate": 1.0}, "cylinder_end_plate must be 0 mm to 50 mm"),
        ({"cylinder_length": None}, "cylinder_length is missing: cylinder_wall needs it"),
        ({"cylinder_wall": None, "cylinder_end_plate": 0.0}, "cylinder_wall is missing: cylinder_length is of a tube"),
        ({"cylinder_wall": None, "cylinder_length": None}, "cylinder_wall is missing: cylinder_end_plate is of a tube"),
        ({"cylinder_wall": -0.001}, "cylinder_wall must be > 0 m, got -0.001"),
    ],
)
def test_what_cannot_be_is_refused(changed, said):
    with pytest.raises(iv.errors.ParameterError, match=said):
        with_tube(**changed)


def test_measured_contacts_have_no_material():
    measured = loaded("hand_controller").drives["cobotic"].transmission
    if measured.geometry is None:
        with pytest.raises(iv.errors.ParameterError, match="geometry is missing: it states the material"):
            replace(measured, **TUBE)

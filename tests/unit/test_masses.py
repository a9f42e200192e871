"""What drives weigh: stated values win, missing ones are named, and derived masses move in motion and in searches."""

import tomllib
from contextlib import nullcontext
from dataclasses import replace

import numpy as np
import pytest

import infinivar as iv
from infinivar.analysis import whole_mass
from infinivar.parts import Guideway, PulleyBearings, Structure
from internals import MASS_DOUBT as DOUBT
from internals import Service, own_mass, service_of, thinnest, total, with_tube
from made import loaded

KNEE = loaded("knee_walking")
ANKLE = loaded("ankle_walking")
COBOTIC, GEARED = KNEE.drives["cobotic"], KNEE.drives["geared"]
SERVICE = Service(0.06, 175.0)


def masses(drive, service=SERVICE):
    return {body.name: body.mass for body in drive.bodies(service)}


def free(drive):
    """The drive with what its geometry determines left open."""
    return replace(drive, link_mass=None, cylinder_inertia=None, steering=replace(drive.steering, bell_inertia=None))


@pytest.mark.parametrize("drive", [COBOTIC, GEARED], ids=["cobotic", "geared"])
def test_a_stated_mass_replaces_what_is_derived(drive):
    keys = {"cylinder": "cylinder", "wheel": "wheel", "bell": "bell", "pulley": "stage", "frame": "frame"}
    keys |= {"cylinder bearings": "bearings", "pulley bearings": "bearings", "rail": "rail", "carriage": "carriage"}
    before = {body.name: body for body in drive.bodies(SERVICE)}
    stated = {keys[name]: 0.1234 for name in before if name in keys}
    assert len(stated) >= 5
    heavy = replace(drive, structure=Structure(**{f"{key}_mass": mass for key, mass in stated.items()}))
    for body in heavy.bodies(SERVICE):
        if body.name in keys:
            assert (body.mass, body.kind) == (0.1234, "stated")
        else:
            assert body == before[body.name]


def test_what_is_not_known_is_named_and_never_zero():
    steel = replace(COBOTIC.transmission.geometry.wheel_material, density=None)
    geometry = replace(COBOTIC.transmission.geometry, wheel_material=steel)
    bare = replace(COBOTIC, transmission=replace(COBOTIC.transmission, geometry=geometry))
    assert masses(bare)["wheel"] is None
    assert np.isnan(total(bare.bodies(SERVICE)))
    unknown = {body.name: body.basis for body in COBOTIC.bodies(Service(None, None)) if body.mass is None}
    assert {*unknown} == {"gearhead", "cylinder", "rail", "frame"}
    assert "travel is missing" in unknown["rail"]
    assert np.isnan(total(GEARED.bodies(Service(None, 175.0))))
    found = whole_mass(KNEE, "cobotic")
    assert found.open == ("gearhead (cylinder gearing, 57:1: the mass is not stated)",)
    assert found.words.startswith("more than 2.")


def test_a_measured_contact_leaves_the_link_mass_open():
    """Of a wheel without geometry nothing is known but its groups: the steering motor alone is no link."""
    measured = {"geometry": None, "creep_stiffness": 6e4, "rolling_torque": 1e-3, "bearing_torque": 1e-3}
    bare = replace(
        COBOTIC,
        transmission=replace(COBOTIC.transmission, **measured),
        steering=replace(COBOTIC.steering, patch_half_length=1e-3),
        link_mass=None,
    )
    assert bare.mass_of_link is None
    assert replace(bare, steering=None).mass_of_link is None
    with pytest.raises(iv.ParameterError, match="link_mass is missing"):
        iv.duty_cycle(bare, KNEE.duty["walking"])


def test_a_search_for_mass_needs_the_travel():
    region = iv.Requirement(force=60.0, speed=0.2, power=6.0)
    study = replace(KNEE.with_drives("geared"), duty={}, requirement=region)
    with pytest.raises(
        iv.ParameterError, match=r"whole masses are not known: travel is missing: state it in \[requirement\]"
    ):
        iv.size(study, sets="shipped", top=1)


def test_moving_masses_follow_from_the_geometry():
    """Link, bell and cylinder in motion, in the energy of a cycle and in the controller, as if their masses were stated."""
    own = free(with_tube(COBOTIC, SERVICE))
    moving = [body.mass for body in own.bodies(SERVICE) if body.moving]
    assert own.mass_of_link == pytest.approx(sum(moving), rel=1e-12)
    assert 0.2 < own.mass_of_link < 0.8
    bell = own.steering.inertia_of_bell
    assert 1e-5 < bell < 1e-4
    stated = replace(
        own,
        link_mass=own.mass_of_link,
        cylinder_inertia=own.inertia_of_cylinder,
        steering=replace(own.steering, bell_inertia=bell, derived_inertia=None),
    )
    walking = KNEE.duty["walking"]
    one, other = (iv.duty_cycle(drive, walking) for drive in (own, stated))
    assert one.energy == pytest.approx(other.energy, rel=1e-12)
    heavier = replace(own, structure=Structure(bell_mass=0.5, wheel_mass=0.5))
    assert heavier.mass_of_link > own.mass_of_link + 0.5
    assert heavier.steering.inertia_of_bell > 2.0 * bell
    larger = replace(own, transmission=replace(own.transmission, wheel_radius=0.03))
    assert larger.steering.inertia_of_bell > 2.0 * bell
    assert iv.duty_cycle(heavier, walking).energy != one.energy


def test_the_energy_audit_closes_with_derived_masses():
    """A simulated reach with all of them derived: what goes in comes out."""
    study = loaded("hand_controller")
    drive = free(with_tube(study.drives["cobotic"], Service(0.1, 50.0)))
    run = iv.simulate(drive, study.scenarios["reach"])
    assert np.abs(run.trajectory.residual).max() < 1e-6


def test_the_thinnest_wall_carries_just_that():
    made = with_tube(COBOTIC, SERVICE).transmission
    assert made.tube is not None
    margin = COBOTIC.structure.strength_margin
    assert made.utilisation[iv.Limit.WALL] == pytest.approx(1.0 / margin, rel=1e-9)
    again = thinnest(made.tube, made.preload, (made.contact.patch.a * made.contact.patch.b) ** 0.5, margin)
    assert float(again) == pytest.approx(made.cylinder_wall, rel=1e-12)
    assert np.isnan(thinnest(made.tube, 1e7, 1e-3, margin))
    own = with_tube(replace(COBOTIC, transmission=made), SERVICE)
    assert own.transmission is made


def test_a_service_is_what_motions_and_region_ask_of_the_drive_itself():
    geared = service_of(ANKLE.drives["geared"], ANKLE.duty)
    cobotic = service_of(ANKLE.drives["cobotic"], ANKLE.duty)
    # The moment of the ankle on arms of about 50 and of 100 mm; the pulley's travel is its arm times the angle.
    assert geared.force == pytest.approx(2.0 * cobotic.force, rel=0.05)
    angle = np.ptp(ANKLE.duty["walking"].instants().position)
    assert cobotic.travel == pytest.approx(0.1 * angle, rel=1e-6)
    series = service_of(ANKLE.drives["geared-series"], ANKLE.duty)
    stiffness = ANKLE.drives["geared-series"].output.series_spring.stiffness
    # The force reaches zero in the cycle, so that the largest energy is that of the largest force.
    assert series.energies["series spring"] == pytest.approx(0.5 * series.force**2 / stiffness, rel=0.02)
    region = iv.Requirement(force=300.0, speed=0.1, travel=0.2)
    assert service_of(GEARED, KNEE.duty, region, 0.2)[:2] == (0.2, 300.0)
    assert service_of(GEARED, {}).travel is None
    assert service_of(replace(GEARED, structure=Structure(travel=0.07)), {}).travel == 0.07


def test_factors_change_the_mass_by_what_they_say():
    found = whole_mass(KNEE, "geared")
    assert found.total == pytest.approx(sum(body.mass for body in found.bodies), rel=1e-12)
    assert found.motors == pytest.approx(0.55, rel=1e-9)
    for name, (low, high) in found.factors.items():
        for end, by in ((low, 1.0 / DOUBT), (high, DOUBT)):
            changed = Structure(**{name: by * getattr(GEARED.structure, name)})
            assert total(replace(GEARED, structure=changed).bodies(found.service)) == pytest.approx(end, rel=1e-12)
    assert {"frame_deflection", "room"} <= {*found.factors}
    least, most = found.range
    assert least < found.total < most
    assert 0.0 < whole_mass(KNEE, "cobotic").moving < whole_mass(KNEE, "cobotic").known


def test_compare_states_what_drives_weigh():
    made = iv.compare(KNEE, quick=True)
    assert made.masses["geared"] == whole_mass(KNEE, "geared")
    stated = made.to_dict()["masses"]["geared"]
    assert stated["total_kg"] == pytest.approx(made.masses["geared"].total)
    assert {row["kind"] for row in stated["bodies"]} == {"catalogue", "derived"}


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        (lambda: Structure(strength_margin=0.0), "strength_margin must be > 0 and <= 100, got 0"),
        (lambda: Structure(frame_mass=-1.0), "frame_mass must be > 0 kg"),
        (
            lambda: replace(COBOTIC, guideway=Guideway(rail=iv.rails()["mgn5c-o"])),
            r"guideway\.rail\.static_rating must be >= transmission\.preload, 2200 N",
        ),
        (lambda: replace(iv.rails()["mgn9c"], width=0.0), "width must be > 0 m"),
        (lambda: iv.parts.Rail(static_rating=1.0), "missing"),
    ],
)
def test_what_cannot_be_is_refused(wrong, message):
    with pytest.raises((iv.ParameterError, TypeError), match=message):
        wrong()


def test_a_load_that_no_part_carries_is_said():
    """Never a nan: bearings of the catalogue end at 11 kN, rails at 72 kN."""
    heavy = replace(COBOTIC, cylinder_bearings=None, transmission=COBOTIC.transmission.pressed(40e3))
    found = {body.name: body for body in heavy.bodies(SERVICE)}
    assert found["cylinder bearings"].basis == "no bearing of the catalogue carries 40000 N"
    assert found["carriage"].basis == "no rail of the catalogue carries 80000 N"
    assert all(body.mass is None or body.mass > 0.0 for body in found.values())
    assert {"cylinder bearings", "carriage", "rail", "frame"} <= {
        name for name, body in found.items() if body.mass is None
    }
    crushed = replace(heavy, transmission=replace(heavy.transmission, preload=4e6))
    assert {body.name: body.basis for body in crushed.bodies(SERVICE)}["cylinder"] == "no wall carries 4000000 N"


def geometry(**changes):
    element = COBOTIC.transmission
    return replace(COBOTIC, transmission=replace(element, geometry=replace(element.geometry, **changes)))


def test_what_does_not_go_together_is_named_with_its_file(load, tmp_path):
    with pytest.raises(iv.InputError, match=r"mine\.toml: drives\.cobotic\.transmission\.geometry\.axle_bearing\.bore"):
        load('extends = "knee_walking"\n[drives.cobotic.transmission]\nwheel_radius = "5 mm"\n')


@pytest.mark.parametrize(
    ("made", "message"),
    [
        (
            lambda: replace(COBOTIC, transmission=replace(COBOTIC.transmission, wheel_radius=0.005)),
            r"geometry\.axle_bearing\.bore must be < 10 mm, the wheel's diameter, got 10 mm",
        ),
        (lambda: geometry(crown_radius=0.016, wheel_width=0.032), r"geometry\.wheel_width must be less"),
        (lambda: geometry(bearing_span=0.005), r"geometry\.bearing_span must be > 10 mm, the wheel's width, got 5 mm"),
        (lambda: replace(COBOTIC, structure=Structure(least_wall=0.05)), r"structure\.least_wall must be <= 45 mm"),
        (
            lambda: replace(
                COBOTIC, transmission=replace(COBOTIC.transmission, cylinder_wall=0.005, cylinder_length=0.06)
            ),
            r"transmission\.cylinder_length must be > 80 mm, the travel, got 60 mm",
        ),
    ],
)
def test_what_does_not_fit_is_refused_by_the_study(made, message):
    with pytest.raises(
        iv.ParameterError, match=rf"^drives\.cobotic\.{'' if 'structure' in message else '.*'}{message}"
    ):
        replace(KNEE, drives={**KNEE.drives, "cobotic": made()})


def test_a_rail_weaker_than_the_load_of_a_geared_drive_is_refused():
    weak = replace(iv.rails()["mgn9c"], static_rating=100.0)
    bare = replace(GEARED, guideway=replace(GEARED.guideway, rail=weak))
    with pytest.raises(iv.ParameterError, match=r"drives\.geared\.guideway\.rail\.static_rating must be >= 175 N"):
        replace(KNEE, drives={**KNEE.drives, "geared": bare})


def test_bearings_of_a_pulley_that_are_wider_than_the_pulley_are_refused():
    for held, path in (
        (PulleyBearings(friction_coefficient=0.002, bore=0.02, pull=300.0), "bore"),
        (PulleyBearings(bearing=iv.bearings()["6004"], pull=300.0), r"bearing\.bore"),
    ):
        wide = replace(GEARED, pulley=replace(GEARED.pulley, radius=0.0099, bearings=held))
        message = rf"drives\.geared\.pulley\.bearings\.{path} must be <= 19.8 mm, the diameter of the pulley, got 20 mm"
        with pytest.raises(iv.ParameterError, match=message):
            replace(KNEE, drives={**KNEE.drives, "geared": wide})
        fits = replace(wide, pulley=replace(wide.pulley, radius=0.0101))
        replace(KNEE, drives={**KNEE.drives, "geared": fits})


@pytest.mark.parametrize(
    ("drive", "name"),
    [(COBOTIC, "stage"), (COBOTIC, "linkage"), (COBOTIC, "springs"), (GEARED, "bell"), (GEARED, "springs")],
)
def test_a_mass_of_what_a_drive_has_not_is_refused(drive, name):
    with pytest.raises(iv.ParameterError, match=rf"structure\.{name}_mass does not apply: the drive has no {name}"):
        replace(drive, structure=Structure(**{f"{name}_mass": 1.0}))


def test_the_angle_of_a_joint_is_travel_behind_its_lever():
    lever = ANKLE.drives["cobotic"]
    stated = iv.study.JointRequirement(moment=100.0, angular_speed=1.0, angle=0.6).requirement
    found = service_of(lever, {}, stated, 0.6)
    assert found.travel == pytest.approx(0.1 * 0.6, rel=1e-12)
    assert found.force == pytest.approx(100.0 / 0.1, rel=1e-12)


def test_limits_of_axle_and_clearance():
    """A thin axle and large bearings beside a small wheel are exceeded limits of the contact."""
    element = COBOTIC.transmission
    bearings = iv.bearings()
    small = replace(element.geometry, axle_bearing=replace(bearings["624"], friction_model="coefficient"))
    assert replace(element, geometry=small).utilisation[iv.Limit.AXLE] > 1.0
    wide = replace(element.geometry, axle_bearing=replace(bearings["6206"], friction_model="coefficient"))
    assert replace(element, geometry=wide).utilisation[iv.Limit.CLEARANCE] == pytest.approx(31.0 / 20.0)
    assert element.utilisation[iv.Limit.AXLE] < 1.0


@pytest.mark.slow
def test_a_sized_design_weighs_the_same_as_a_study():
    """Whole mass of a design by the search, of its drive, and by `compare` of its study."""
    found = iv.size(KNEE, generations=4, top=2)
    axle = found.best_of["cobotic"].drive.transmission.geometry.axle_bearing
    known = iv.bearings()[axle.name]
    assert (axle.width, axle.mass, axle.bore) == (known.width, known.mass, known.bore)
    for design in found.best_of.values():
        study = found.study_of(design)
        (name,) = study.drives
        assert whole_mass(study, name).total == pytest.approx(design.mass, rel=1e-9)
        again = iv.Study.from_dict(tomllib.loads(study.to_toml()), name="again")
        assert whole_mass(again, name).total == pytest.approx(design.mass, rel=1e-9)
        assert own_mass(design.drive.bodies(service_of(design.drive, KNEE.duty, KNEE.requirement, KNEE.travel))) > 0.1


@pytest.mark.parametrize("crown", [0.0055, 0.007])
def test_the_rim_of_a_wheel_is_above_its_axle(crown):
    """The smallest wheel by the limit is the one below which a study is refused: 10 mm wide, on bearings smaller than its rim."""
    geometry = COBOTIC.transmission.geometry
    bearing = replace(geometry.axle_bearing, bore=0.008, outside_diameter=0.009)
    narrow = replace(geometry, crown_radius=crown, axle_bearing=bearing)
    least = float(narrow.least_wheel)
    assert least == pytest.approx(0.004 + crown - np.sqrt(crown**2 - 0.005**2), rel=1e-12)
    for factor, fits in ((0.999, False), (1.001, True)):
        element = replace(COBOTIC.transmission, geometry=narrow, wheel_radius=factor * least)
        assert (element.utilisation[iv.Limit.CLEARANCE] <= 1.0) == fits
        refused = pytest.raises(iv.ParameterError, match="the rim falls below the axle")
        with nullcontext() if fits else refused:
            replace(KNEE, drives={"cobotic": replace(COBOTIC, transmission=element)})

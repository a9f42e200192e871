"""The sheet of a drive: views to scale, masses, and loads on bearings and rail."""

import math
import sys
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import infinivar as iv
from infinivar.analysis import whole_mass
from internals import Service, save_step, sheet_figure
from made import loaded

KNEE = loaded("knee_walking")
ANKLE = loaded("ankle_walking")
COBOTIC, GEARED = KNEE.drives["cobotic"], KNEE.drives["geared"]
SERVICE = Service(0.06, 175.0)


def loads(drive, service=SERVICE):
    return {one.body: one for one in drive.loads(service)}


@pytest.mark.parametrize("name", ["cobotic", "geared"])
def test_views_and_tables_are_those_of_the_drive(name):
    mass = whole_mass(KNEE, name)
    drive = KNEE.drives[name]
    found = sheet_figure.data(mass, drive.loads(KNEE.service(drive)))
    space = mass.layout.space
    for view, along in (("side", space.length), ("front", space.width)):
        left = min(row[2] for row in found[view])
        right = max(row[2] + row[4] for row in found[view])
        assert_allclose(right - left, 1e3 * float(along), rtol=1e-12)
        assert_allclose(found["sizes"]["height"], 1e3 * float(space.height), rtol=1e-12)
    assert_allclose(sum(row[1] for row in found["masses"] if row[1] is not None), 1e3 * mass.known, rtol=1e-12)
    assert_allclose(sum(row[2] for row in found["masses"]), 1.0, rtol=1e-12)
    drawn = sheet_figure.draw_all(mass, drive.loads(KNEE.service(drive)), name)
    assert drawn.axes[0].get_title() == "side view [mm]"


def test_a_wheel_is_round_from_the_side_that_it_rolls_to():
    found = sheet_figure.data(whole_mass(KNEE, "cobotic"), ())
    forms = {view: {row[0]: row[1] for row in found[view]} for view in ("side", "front")}
    assert (forms["side"]["wheel"], forms["front"]["wheel"]) == ("box", "round")
    assert forms["front"]["cylinder"] == "round"


def test_loads_are_in_balance_with_preload_and_force():
    """The axle carries the preload, the bell passes it on, and the cylinder's bearings react it wherever the wheel stands."""
    found, element = loads(COBOTIC), COBOTIC.transmission
    axle = [found[f"axle bearing, {place}"] for place in ("first", "second")]
    assert_allclose(sum(one.radial for one in axle), element.preload, rtol=1e-12)
    assert found["bell bearing"].axial == element.preload
    support = COBOTIC.cylinder_bearings
    begin = 0.5 * support.span if support.wheel_position is None else support.wheel_position
    arm = element.cylinder_radius * SERVICE.force / support.span
    near = [(begin + end) / support.span for end in (-0.5 * SERVICE.travel, 0.5 * SERVICE.travel)]
    first = max(element.preload * (1.0 - share) for share in near) + arm
    second = max(element.preload * share for share in near) + arm
    assert_allclose(found["cylinder bearing, first"].radial, first, rtol=1e-12)
    assert_allclose(found["cylinder bearing, second"].radial, second, rtol=1e-12)
    assert found["cylinder bearing, first"].axial == SERVICE.force
    assert found["carriage"].radial == element.preload


def test_the_sheet_has_the_wheel_where_the_motion_takes_it():
    """The knee's link moves from -53 to 0 mm: each bearing's largest load over the motion is at most that of the sheet."""
    drive = KNEE.drives["cobotic"]
    (duty,) = KNEE.duty.values()
    course = iv.duty_cycle(drive, duty).instants.course
    rolled = drive.roll(course, load_mass=duty.moved_mass)
    real = drive.held(rolled.wheel_torque, rolled.force, course.position)
    found = loads(drive, KNEE.service(drive))
    for place, (radial, _) in zip(("first", "second"), real, strict=True):
        shown = found[f"cylinder bearing, {place}"].radial
        assert 0.85 * shown < np.max(radial) <= 1.001 * shown


def test_the_sheet_bounds_the_limit_over_a_motion():
    """Two ways: the largest load at any instant of the motion, and that of the sheet, at the ends of the travel."""
    drive = ANKLE.drives["cobotic"]
    (duty,) = ANKLE.duty.values()
    demand = iv.duty_cycle(drive, duty, travel=ANKLE.travel).demands[iv.Limit.SUPPORT, "cylinder"]
    found = loads(drive, ANKLE.service(drive))
    least = min(found[f"cylinder bearing, {place}"].margin for place in ("first", "second"))
    assert demand <= 1.0 / least * (1.0 + 1e-3)  # the motion is not loaded most at its ends; tangential force is small
    assert demand > 0.9 / least
    weak = replace(
        drive,
        cylinder_bearings=replace(
            drive.cylinder_bearings, bearing=replace(drive.cylinder_bearings.bearing, static_rating=5000.0)
        ),
    )
    assert not iv.duty_cycle(weak, duty, travel=ANKLE.travel).feasible


def test_without_a_span_a_bearing_carries_the_whole_preload():
    bare = replace(COBOTIC, cylinder_bearings=None)
    assert loads(bare)["cylinder bearing, second"].radial == COBOTIC.transmission.preload
    assert loads(bare)["cylinder bearing, second"].margin >= 1.0  # the lightest of the catalogue that carries it


def test_margins_are_ratings_over_loads():
    for drive in (COBOTIC, GEARED):
        for one in drive.loads(SERVICE):
            if one.axial == 0.0:
                assert_allclose(one.margin, one.static_rating / one.radial, rtol=1e-12)
            assert math.isfinite(one.margin)
    assert loads(GEARED)["carriage"].radial == SERVICE.force
    assert_allclose(loads(GEARED)["pulley bearing"].radial, 0.5 * GEARED.pulley.bearings.pull, rtol=1e-12)
    assert loads(GEARED, Service(0.06, None)) == {}


def test_preloads_that_cancel_load_no_bearing():
    """Two opposed wheels leave nothing across the cylinder but the tilt of the link's force, which is none of rounding."""
    element = replace(COBOTIC.transmission, wheels=2)
    loads = {one.body: one for one in replace(COBOTIC, transmission=element).loads(KNEE.service(COBOTIC))}
    assert loads["cylinder bearing, second"].radial == 0.0
    assert loads["cylinder bearing, second"].margin == math.inf
    assert loads["cylinder bearing, first"].axial > 0.0


@pytest.mark.parametrize("name", ["cobotic", "geared"])
def test_solids_for_cad_are_those_of_the_layout(name, tmp_path):
    """Read back by the library: volumes, names and the box around them."""
    pytest.importorskip("OCP", reason="the extra cad is not installed")
    from OCP.Bnd import Bnd_Box
    from OCP.BRepBndLib import BRepBndLib
    from OCP.BRepGProp import BRepGProp
    from OCP.GProp import GProp_GProps
    from OCP.STEPControl import STEPControl_Reader
    from OCP.TopAbs import TopAbs_ShapeEnum
    from OCP.TopExp import TopExp_Explorer

    layout = KNEE.drives[name].layout(SERVICE)
    path = save_step(layout.solids, tmp_path / "knee.step", f"Knee, {name}")
    text = path.read_text("ascii")
    for solid in layout.solids:
        assert f"'{solid.body}'" in text
    assert f"PRODUCT('Knee, {name}'" in text
    reader = STEPControl_Reader()
    reader.ReadFile(str(path))
    reader.TransferRoots()
    whole, found, box = reader.OneShape(), [], Bnd_Box()
    walk = TopExp_Explorer(whole, TopAbs_ShapeEnum.TopAbs_SOLID)
    while walk.More():
        properties = GProp_GProps()
        BRepGProp.VolumeProperties_s(walk.Current(), properties)
        found.append(properties.Mass())
        walk.Next()
    expected = []
    for solid in layout.solids:
        sides = [1e3 * float(end - start) for start, end in (solid.x, solid.y, solid.z)]
        expected.append(math.prod(sides) * (1.0 if solid.form == "box" else 0.25 * math.pi))
    assert_allclose(sorted(found), sorted(expected), rtol=1e-9)
    BRepBndLib.AddOptimal_s(whole, box)
    low, high = ([getattr(end, axis)() for axis in "XYZ"] for end in (box.CornerMin(), box.CornerMax()))
    spans = np.subtract(high, low)
    assert_allclose(spans, [1e3 * float(one) for one in layout.space], rtol=1e-4)


def test_without_the_library_it_is_said_how_to_install_it(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "OCP", None)
    with pytest.raises(iv.InputError, match=r"a STEP file needs OCP; install it with: pip install 'infinivar\[cad\]'"):
        save_step(COBOTIC.layout(SERVICE).solids, tmp_path / "a.step", "a")

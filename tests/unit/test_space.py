"""The space that drives fill: boxes around their bodies, envelopes of studies, and searches that keep within them."""

import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import infinivar as iv
from infinivar.analysis import whole_mass
from infinivar.parts import Belt, Rack, Structure
from internals import Envelope, Service, estimated_size, mass_of
from made import loaded

KNEE = loaded("knee_walking")
ANKLE = loaded("ankle_walking")
COBOTIC, GEARED = KNEE.drives["cobotic"], KNEE.drives["geared"]
SERVICE = Service(0.06, 175.0)


def by_body(drive, service=SERVICE):
    found = {}
    for solid in drive.layout(service).solids:
        found.setdefault(solid.body, []).append(solid)
    return found


def volume(solid):
    sides = [float(end - start) for start, end in (solid.x, solid.y, solid.z)]
    return math.prod(sides) * (1.0 if solid.form == "box" else 0.25 * math.pi)


def within(one, other):
    return all(
        low >= least - 1e-12 and high <= most + 1e-12 for (low, high), (least, most) in zip(one, other, strict=True)
    )


@pytest.mark.parametrize("drive", [COBOTIC, GEARED, ANKLE.drives["geared"], ANKLE.drives["cobotic"]], ids=range(4))
def test_every_body_with_a_mass_is_placed(drive):
    placed = set(by_body(drive))
    weighed = {body.name for body in drive.bodies(SERVICE) if body.mass is not None}
    assert weighed - placed <= {"preload spring", "springs", "linkage"}  # which the docstring names
    assert not placed - {body.name for body in drive.bodies(SERVICE)}


def test_solids_have_the_volumes_that_weigh():
    """Two ways to a mass: by its law, and by the solid drawn for it, where a body is solid and of one piece."""
    mass = {body.name: body.mass for body in COBOTIC.bodies(SERVICE)}
    solids = by_body(COBOTIC)
    aluminium, steel = 2810.0, COBOTIC.transmission.geometry.wheel_material.density
    assert_allclose(sum(map(volume, solids["frame"])) * aluminium, mass["frame"], rtol=1e-9)
    assert 0.9 < sum(map(volume, solids["wheel"])) * steel / mass["wheel"] < 1.1  # the crown off, the axle on
    assert mass["bell"] < sum(map(volume, solids["bell"])) * aluminium  # hollow
    assert_allclose(
        sum(map(volume, by_body(GEARED)["frame"])) * aluminium,
        {body.name: body.mass for body in GEARED.bodies(SERVICE)}["frame"],
        rtol=1e-9,
    )
    motor = solids["steering motor"][0]
    assert_allclose(volume(motor) * Structure().motor_density, COBOTIC.steering.motor.mass, rtol=1e-9)


@pytest.mark.parametrize("drive", [COBOTIC, ANKLE.drives["cobotic"]], ids=["knee", "ankle"])
def test_moving_bodies_do_not_touch_what_stands(drive):
    """At both ends of the travel, too: the wheel rolls on the cylinder, and carriage and rail slide."""
    solids = by_body(drive)
    (cylinder,), (bell,), (carriage,) = solids["cylinder"], solids["bell"], solids["carriage"]
    top = cylinder.z[1]
    assert_allclose(solids["wheel"][0].z[0], top, rtol=1e-12)
    assert bell.z[0] > top
    assert within(solids["wheel"][0][2:4], bell[2:4])
    assert solids["wheel"][0].z[1] < bell.z[1] <= carriage.z[0] + 1e-12
    plates = [one for one in solids["frame"] if one.x[1] - one.x[0] < 0.05]
    assert len(plates) == 2
    for side in (-1.0, 1.0):
        end = 0.5 * side * SERVICE.travel
        for moving in (carriage, bell, solids["bell bearing"][0], solids["wheel"][0]):
            ends = [float(one + end) for one in moving.x]
            assert max(map(abs, ends)) < min(abs(float(one)) for plate in plates for one in plate.x)


def meet(one, other, shift):
    """Whether the boxes of two solids meet, the first moved along x."""
    moved = [end + shift for end in one.x]
    return all(
        max(float(a[0]), float(b[0])) < min(float(a[1]), float(b[1])) - 1e-9
        for a, b in ((moved, other.x), (one.y, other.y), (one.z, other.z))
    )


STAGES = {
    "pulley": GEARED,
    "belt": replace(GEARED, pulley=None, belt=Belt(pitch=5e-3, teeth=20)),
    "rack": replace(GEARED, pulley=None, rack=Rack(module=1e-3, teeth=16)),
    "screw": ANKLE.drives["geared"],
}


@pytest.mark.parametrize("drive", [*STAGES.values(), COBOTIC, ANKLE.drives["cobotic"]], ids=[*STAGES, "knee", "ankle"])
def test_what_moves_meets_no_plate_or_bar_on_its_way(drive):
    solids = by_body(drive)
    moving = [one for body in ("carriage", "bell", "wheel") for one in solids.get(body, ())]
    standing = [one for body, some in solids.items() if body in ("frame", "rail") or "motor" in body for one in some]
    assert moving
    assert standing
    for one in moving:
        for other in standing:
            if other.body != "steering motor":  # which moves along
                for shift in np.linspace(-0.5, 0.5, 11) * SERVICE.travel:
                    assert not meet(one, other, shift), (one.body, other)


def test_a_nut_passes_between_the_plates_and_under_the_carriage():
    solids = by_body(STAGES["screw"])
    nut = max(solids["screw"], key=lambda one: float(one.z[1]))
    for other in (*solids["frame"], *solids["rail"], *solids["carriage"]):
        for shift in np.linspace(-0.5, 0.5, 11) * SERVICE.travel:
            assert other.body == "carriage" or not meet(nut, other, shift)
    assert nut.z[1] <= solids["carriage"][0].z[0] + 1e-12


@pytest.mark.parametrize("drive", [COBOTIC, ANKLE.drives["cobotic"]], ids=["knee", "ankle"])
def test_what_is_around_a_wheel_does_not_meet(drive):
    solids = by_body(drive)
    (motor,), (bell,), (bearing,), (wheel,) = (
        solids[name] for name in ("steering motor", "bell", "bell bearing", "wheel")
    )
    for one, other in ((motor, bell), (motor, wheel), (motor, bearing), (bearing, wheel), (bearing, bell)):
        assert not meet(one, other, 0.0)


def test_a_rack_counts_with_its_sweep():
    rack = STAGES["rack"].layout(SERVICE)
    longest = max(float(one.x[1] - one.x[0]) for one in rack.solids if one.body == "frame")
    assert_allclose(rack.space.length, longest + SERVICE.travel, rtol=1e-12)


def test_large_pulleys_do_not_meet():
    wide = replace(GEARED, pulley=replace(GEARED.pulley, radius=0.1))
    round_ = [one for one in by_body(wide)["pulley"] if one.form == "y"]
    assert len(round_) == 2
    assert not meet(*round_, 0.0)


def test_a_drive_of_which_nothing_is_placed_does_not_fit():
    mass = mass_of(COBOTIC, Service(None, None))
    assert not mass.within(Envelope(length=100.0))
    assert "not known whether" in mass.words_on(Envelope(length=100.0))
    assert mass.within(Envelope(mass=100.0))
    lost = KNEE.with_drives("geared")
    lost = replace(lost, requirement=replace(lost.requirement, travel=None), duty={}, envelope=Envelope(length=100.0))
    found = iv.compare(lost, quick=True)
    assert not found.feasible
    assert "No drive is known to be within the envelope." in found.verdict


def test_the_box_holds_every_solid_and_is_no_larger():
    for drive in (COBOTIC, GEARED):
        made = drive.layout(SERVICE)
        for axis, side in zip("xyz", made.space, strict=True):
            ends = np.array([getattr(one, axis) for one in made.solids], dtype=float)
            assert_allclose(side, ends[:, 1].max() - ends[:, 0].min(), rtol=1e-12)
        assert_allclose(made.space.diameter, np.hypot(made.space.width, made.space.height), rtol=1e-12)


@pytest.mark.parametrize("name", ["length", "diameter"])
def test_a_stated_size_of_a_motor_counts(name):
    longer = replace(COBOTIC, motor=replace(COBOTIC.motor, **{name: 0.15}))
    before, after = COBOTIC.layout(SERVICE).space, longer.layout(SERVICE).space
    if name == "length":
        own, _ = estimated_size(0.12, 0.026, None, Structure())
        assert_allclose(after.length - before.length, 0.15 - own, rtol=1e-9)
    else:
        assert after.width > before.width


def test_many_designs_at_once_are_as_one_by_one():
    radii = np.array([0.03, 0.05, 0.08])[:, None]
    many = replace(COBOTIC, transmission=replace(COBOTIC.transmission, cylinder_radius=radii)).layout(SERVICE).space
    for place, radius in enumerate(radii[:, 0]):
        one = replace(COBOTIC, transmission=replace(COBOTIC.transmission, cylinder_radius=float(radius)))
        for side, alone in zip(many, one.layout(SERVICE).space, strict=True):
            assert_allclose(np.broadcast_to(side, (3, 1))[place, 0], alone, rtol=1e-9)


def test_what_is_not_known_is_named():
    bare = replace(COBOTIC, motor=replace(COBOTIC.motor, mass=None))
    assert any(one.startswith("cylinder motor (neither") for one in bare.layout(SERVICE).open)
    nothing = COBOTIC.layout(Service(None, None))
    assert nothing.open[0].startswith("cylinder, wheel and frame")
    assert np.isnan(nothing.space.length)


def test_an_envelope_may_be_turned_about_its_length():
    space = COBOTIC.layout(SERVICE).space
    width, height = float(space.width), float(space.height)
    for one, other in ((width, height), (height, width)):
        key = iv.Limit.SPACE, "width and height"
        assert_allclose(Envelope(width=one, height=other).demands(space)[key], 1.0, rtol=1e-12)
    assert_allclose(Envelope(width=min(width, height)).demands(space)[key], 1.0, rtol=1e-12)
    assert Envelope(width=0.9 * width, height=height).demands(space)[key] > 1.0


def test_a_comparison_judges_the_envelope():
    light = whole_mass(KNEE, "geared").total
    found = iv.compare(replace(KNEE, envelope=Envelope(mass=1.01 * light)), quick=True)
    assert not found.able("cobotic")  # more than 2 kg, although its gearhead is not known
    assert found.able("geared")
    assert found.best.name == "geared"
    assert "Within the envelope: Geared, DCX 32 L; best of those" in found.verdict
    heavy = found.masses["cobotic"]
    assert_allclose(
        heavy.exceeded(found.study.envelope)[iv.Limit.MASS, "mass"], heavy.known / (1.01 * light), rtol=1e-12
    )
    free = iv.compare(replace(KNEE, envelope=Envelope(mass=100.0)), quick=True)
    assert free.best.name == iv.compare(KNEE, quick=True).best.name


def test_a_verdict_hangs_on_factors_that_decide_what_fits():
    """Just too heavy as assumed: a factor that makes it lighter is a row of its own."""
    study = KNEE.with_drives("geared")
    weighs = whole_mass(study, "geared").total
    found = iv.compare(replace(study, envelope=Envelope(mass=weighs * (1.0 - 1e-4))), quick=True)
    assert not found.feasible
    rows = {row.choice for row in found.hangs_on.rows if any(row.able.values())}
    assert "structure: frame deflection" in rows


@pytest.fixture(scope="module")
def searched():
    """A search without an envelope, and one within that is tighter than the best designs."""
    free = iv.size(KNEE, generations=6, top=3)
    best = free.best_of["cobotic"]
    space = best.drive.layout(KNEE.service(best.drive)).space
    narrow = Envelope(length=0.97 * float(space.length), mass=0.9 * best.mass)
    study = replace(KNEE, envelope=narrow)
    return free, study, iv.size(study, generations=6, top=3)


@pytest.mark.slow
def test_a_search_keeps_within_the_envelope(searched):
    """Two ways: the demand that the search judged by, and the space of the design as a drive."""
    free, study, found = searched
    drive = free.best_of["cobotic"].drive
    beyond = study.envelope.demands(drive.layout(study.service(drive)).space, free.best_of["cobotic"].mass)
    assert max(beyond.values()) > 1.0  # what is found without it does not fit
    for one in (*found.designs, *found.front, *found.best_of.values()):
        space = one.drive.layout(study.service(one.drive)).space
        demands = {key[1:]: demand for key, demand in one.demands.items() if key[0] == "envelope"}
        expected = study.envelope.demands(space, one.mass)
        assert demands.keys() == expected.keys()
        for key, demand in expected.items():
            assert_allclose(demands[key], demand, rtol=1e-9)
            assert demand <= 1.0 + 1e-9


@pytest.mark.slow
def test_a_geared_search_within_an_envelope_is_that_of_every_candidate(shelf):
    """The radii are cut at the largest that fits: the same as judging every candidate at every radius."""
    study = KNEE.with_drives("geared")
    study = replace(study, requirement=replace(study.requirement, force=0.7 * study.requirement.force))
    free = iv.size(study, sets=shelf, top=1, objective="energy").best
    radius = free.free["pulley.radius"]
    between = math.sqrt(radius.low * radius.value)
    smaller = replace(free.drive, pulley=replace(free.drive.pulley, radius=between))
    most = mass_of(smaller, study.service(smaller)).total
    assert most < free.mass * (1.0 - 1e-4)
    one = replace(study, envelope=Envelope(mass=most))
    found = iv.size(one, sets=shelf, top=1, objective="energy")
    assert found.best.mass <= most * (1.0 + 1e-9)
    radii = np.geomspace(0.4 * radius.low, 2.5 * radius.value, 45)
    least = math.inf
    for radius in radii:
        fixed = iv.size(one, sets=shelf, top=1, objective="energy", radius=(float(radius), float(radius)))
        least = min(least, fixed.best.power if fixed.feasible else math.inf)
    assert found.best.power <= least * (1.0 + 1e-6)
    assert_allclose(found.best.power, least, rtol=0.05)  # of 45 radii, one is near


@pytest.mark.slow
def test_an_envelope_that_nothing_fits_is_named(shelf):
    study = replace(KNEE.with_drives("geared"), envelope=Envelope(length=0.05))
    found = iv.size(study, sets=shelf, top=1, objective="energy")
    assert not found.feasible
    nearest = found.nearest.drive
    times = float(nearest.layout(study.service(nearest)).space.length) / 0.05
    assert f"length of the envelope: {times:.3g} times the allowance" in found.verdict

"""Any machine of rolling contacts: passive, balanced, and equal to the wheel on a cylinder where it is one."""

from dataclasses import replace

import numpy as np
import pytest
from designs import elements, states
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

import infinivar as iv
from infinivar import Limit
from infinivar.transmission import Mechanism, RollingContact
from internals import slopes
from made import loaded

LAWS = ("linear", "vermeulen-johnson", "polach", "fastsim", "exact")
QUADRANTS = [(1, 1), (-1, 1), (-1, -1), (1, -1)]
seeds = st.integers(0, 2**32 - 1)

HARD = loaded("hand_controller").drives["cobotic"].transmission
GEOMETRY = HARD.geometry


def measured(law="linear", **changes):
    values = {"wheel_radius": 0.012, "preload": 300.0, "friction": 0.2, "creep_stiffness": 9000.0}
    return RollingContact(**values | {"rolling_torque": 4e-3, "bearing_torque": 2e-3, "creep_law": law} | changes)


def pressed(law="exact", surface="plane", radius=None, **changes):
    values = {"wheel_radius": 0.012, "preload": 300.0, "friction": 0.2, "geometry": GEOMETRY}
    return RollingContact(**values | {"surface": surface, "surface_radius": radius, "creep_law": law} | changes)


def random_machine(random, contacts, coordinates, spin):
    k = len(contacts)
    return Mechanism(
        contacts=contacts,
        jacobian=random.normal(size=(k, 2, coordinates)),
        spin=random.normal(size=(k, coordinates)) * 30 if spin else None,
    )


def off_balance(point):
    """Residual of the balance of powers over the largest powers that pass the contacts."""
    given = point.steering_power.sum(axis=-1) - point.power.sum(axis=-1)
    return np.abs(given - sum(point.losses.values())) / np.abs(point.power).sum(axis=-1)


def assert_passive(point):
    scale = np.abs(point.power).sum(axis=-1, keepdims=True)
    for name, loss in point.wheel_losses.items():
        assert np.all(loss >= -1e-12 * scale), name


@pytest.mark.parametrize(("surface", "radius", "curved"), [("plane", None, 0.0), ("sphere", 0.03, 1 / 0.03)])
def test_a_wheel_with_equal_radii_has_a_round_patch(surface, radius, curved):
    """The closed form of Hertz for two spheres: a^3 = 3 P R/(4 E*)."""
    geometry = replace(GEOMETRY, crown_radius=0.012)
    contact = pressed(surface=surface, radius=radius, geometry=geometry).contact
    compliance = sum(body.plane_strain_compliance for body in geometry.bodies.values())
    expected = (0.75 * 300.0 / (1 / 0.012 + curved) * compliance) ** (1 / 3)
    assert_allclose([contact.patch.a, contact.patch.b], expected, rtol=1e-9)
    assert contact.rotation == 0.0


def test_a_cylinder_presses_as_under_the_transmission():
    own, known = pressed(surface="cylinder", radius=HARD.cylinder_radius), replace(HARD, preload=300.0)
    known = replace(known, wheel_radius=0.012)
    assert own.contact == known.contact
    assert known.wheel.surface == "cylinder"
    # Across the cylinder, the patch of a wheel that rolls along the axis is another.
    assert own.at((1.0, 0.0), (1.0, 0.0))[2].creep_stiffness != own.at((0.0, 1.0), (0.0, 1.0))[2].creep_stiffness
    flat = pressed()
    assert flat.at((1.0, 0.0), (1.0, 0.0))[2].creep_stiffness == flat.at((0.0, 1.0), (0.0, 1.0))[2].creep_stiffness


@pytest.mark.parametrize("law", [*LAWS, "spin"])
@pytest.mark.parametrize("way", [1.0, -1.0])
def test_creepage_is_the_inverse_of_the_force(law, way):
    contact = pressed() if law == "spin" else measured(law)
    force = np.linspace(-0.9, 0.9, 13) * contact.slip_force
    spin = 6.0 if law == "spin" else None
    creepage = contact.creepage(force, spin=spin, rolling_speed=way)
    again = contact.act((way + 0.0 * force, creepage), (1.0, 0.0), spin=spin)
    assert_allclose(again.lateral_force, force, rtol=0, atol=1e-7 * contact.slip_force)
    assert np.isnan(contact.creepage(1.01 * contact.slip_force, spin=spin, rolling_speed=way))


@given(st.sampled_from(LAWS), st.integers(1, 6), st.integers(1, 7), seeds)
def test_any_machine_is_passive_and_balanced(law, wheels, coordinates, seed):
    """Random headings, so that most wheels slide, and near those of pure rolling, where they creep."""
    random = np.random.default_rng(seed)
    contacts = [measured(law, preload=random.uniform(10, 900)) for _ in range(wheels)]
    machine = random_machine(random, contacts, coordinates, spin=False)
    rates = random.normal(size=(200, coordinates))
    rolling = np.arctan2(*machine.steer(rates=rates)[::-1])
    heading = rolling + random.choice([1e-3, 1e-2, 1.0], size=(200, 1)) * random.normal(size=(200, wheels))
    point = machine.operate(rates=rates, heading=heading)
    assert off_balance(point).max() < 1e-12
    assert_passive(point)
    assert np.all(np.abs(point.lateral_force) <= [one.slip_force * (1 + 1e-12) for one in contacts])
    assert {Limit.OK, Limit.SLIP} >= set(np.unique(point.limit))
    both = point.power_out - point.power_in
    assert_allclose(both, point.power.sum(axis=-1), rtol=0, atol=1e-12 * np.abs(point.power).sum(axis=-1).max())


@given(st.integers(1, 4), st.integers(1, 6), seeds)
def test_contacts_with_spin_are_passive_and_balanced(wheels, coordinates, seed):
    random = np.random.default_rng(seed)
    shapes = [("plane", None), ("sphere", 0.03), ("cylinder", 0.02)]
    contacts = [pressed(surface=shape, radius=radius) for shape, radius in shapes * 2][:wheels]
    machine = random_machine(random, contacts, coordinates, spin=True)
    rates = random.normal(size=(100, coordinates))
    rolling = np.arctan2(*machine.steer(rates=rates)[::-1])
    heading = rolling + 1e-2 * random.normal(size=(100, wheels))
    point = machine.operate(rates=rates, heading=heading, steering_rate=random.normal(size=(100, wheels)))
    assert off_balance(point).max() < 1e-10
    total = sum(point.wheel_losses.values())
    assert np.all(total >= -1e-12 * np.abs(point.power).sum(axis=-1, keepdims=True))
    assert np.any(point.losses["spin"] > 0.0)


@pytest.mark.slow
@pytest.mark.parametrize("quadrant", QUADRANTS)
@pytest.mark.parametrize("law", LAWS)
def test_power_closure_at_many_points(law, quadrant):
    """100,000 points of a machine with three wheels and three coordinates per law and quadrant of the first two rates."""
    random = np.random.default_rng(5)
    contacts = [measured(law, preload=one) for one in (100.0, 300.0, 700.0)]
    machine = random_machine(random, contacts, 3, spin=False)
    rates = np.abs(random.normal(size=(100_000, 3))) * [*quadrant, 1]
    rolling = np.arctan2(*machine.steer(rates=rates)[::-1])
    point = machine.operate(rates=rates, heading=rolling + 3e-3 * random.normal(size=rolling.shape))
    assert off_balance(point).max() < 1e-9
    assert_passive(point)
    assert 0.05 < np.mean(point.limit == Limit.SLIP) < 0.95


def as_heading(angle):
    """Heading (sin phi, cos phi) of the wheel on a cylinder."""
    return np.sin(angle)[:, None], np.cos(angle)[:, None]


@given(elements(law=st.sampled_from(LAWS)), seeds)
def test_wheel_on_a_cylinder_at_prescribed_speed(element, seed):
    speed, angle, _ = states(element, seed)
    random = np.random.default_rng(seed)
    link = -element.cylinder_radius * speed * (np.tan(angle) + random.normal(0, 0.01, len(speed)))
    known = element.operate(cylinder_speed=speed, steering_angle=angle, link_speed=link)
    point = element.mechanism.operate(rates={"link": link, "cylinder": speed}, heading=as_heading(angle))
    force, torque = element.slip_force, element.slip_force * element.cylinder_radius
    assert_allclose(point.applied[:, 0], known.link_force, rtol=0, atol=1e-13 * force)
    assert_allclose(point.applied[:, 1], -known.torque, rtol=0, atol=1e-13 * torque)
    assert_array_equal(point.limit, known.limit)
    for name, loss in known.losses.items():
        assert_allclose(point.losses[name], loss, rtol=1e-12, atol=1e-300)


@given(elements(law=st.sampled_from(LAWS)), seeds)
def test_wheel_on_a_cylinder_at_prescribed_force(element, seed):
    speed, angle, force = states(element, seed, largest_angle=1.4)
    known = element.operate(cylinder_speed=speed, steering_angle=angle, link_force=force)
    machine = element.mechanism
    point = machine.solve(heading=as_heading(angle), rates={"cylinder": speed}, applied={"link": force})
    found, ok = ~np.isnan(point.rates[:, 0]), known.limit == Limit.OK
    assert np.mean(found[ok]) > 0.99  # within a thousandth of slip the iteration may not end
    assert np.all(point.limit[~found] == Limit.SLIP)
    scale = element.cylinder_radius * np.abs(speed) + np.abs(known.link_speed)
    both = found & ok
    # A prescribed force is met to 1e-9 of slip; the creep that it needs is 1/K of the rolling speed, more near slip.
    assert_allclose((point.rates[:, 0] / scale)[both], (known.link_speed / scale)[both], rtol=0, atol=1e-8)
    assert_allclose(point.applied[both, 1], -known.torque[both], rtol=0, atol=2e-8 * machine.reference_force)
    assert off_balance(point)[both].max() < 1e-9


@given(elements(law=st.sampled_from(LAWS)), seeds)
def test_headings_of_the_wheel_on_a_cylinder(element, seed):
    speed, angle, force = states(element, seed, largest_angle=1.2)
    link = element.operate(cylinder_speed=speed, steering_angle=angle, link_force=force).link_speed
    known = element.steer(cylinder_speed=speed, link_speed=link, link_force=force)
    found = element.mechanism.steer(rates={"link": link, "cylinder": speed}, applied={"link": force})
    again = np.arctan(found[0] / found[1])[:, 0]
    assert_allclose(again[~np.isnan(again)], known[~np.isnan(again)], rtol=0, atol=1e-8)
    assert np.mean(np.isnan(again) != np.isnan(known)) < 0.01  # at slip itself


@pytest.mark.parametrize("law", LAWS)
def test_wheel_with_geometry_is_the_same_machine(law):
    """Bearings and a friction limit that depend on speed follow the surface of the cylinder."""
    element = replace(
        HARD, creep_law=law, geometry=replace(GEOMETRY, fast_friction_ratio=0.7, friction_decay_speed=0.4)
    )
    speed, angle, force = states(element, 3, largest_angle=1.4)
    force = 0.6 * force
    known = element.operate(cylinder_speed=speed, steering_angle=angle, link_force=force)
    point = element.mechanism.solve(heading=as_heading(angle), rates={"cylinder": speed}, applied={"link": force})
    assert_array_equal(point.limit, known.limit)
    ok = known.limit == Limit.OK
    assert ok.mean() > 0.9
    assert_allclose(point.rates[ok, 0], known.link_speed[ok], rtol=1e-9, atol=1e-12)
    for name, loss in known.losses.items():
        assert_allclose(point.losses[name][ok], loss[ok], rtol=1e-6, atol=1e-12)
    assert set(point.utilisation) == {Limit.SLIP, *element.utilisation}


@given(st.sampled_from(LAWS), seeds)
def test_solve_finds_the_motion_of_known_forces(law, seed):
    """A machine with more wheels than coordinates, rolling with creep and internal forces."""
    random = np.random.default_rng(seed)
    contacts = [measured(law, preload=one, creep_stiffness=20 * one) for one in (200.0, 300.0, 400.0, 500.0)]
    machine = random_machine(random, contacts, 3, spin=False)
    rates = random.normal(size=(100, 3))
    rolling = np.arctan2(*machine.steer(rates=rates)[::-1])
    heading = rolling + 2e-3 * random.normal(size=rolling.shape)
    point = machine.operate(rates=rates, heading=heading)
    names = machine.coordinates
    again = machine.solve(
        heading=heading,
        rates={names[0]: rates[:, 0]},
        applied={name: point.applied[:, place] for place, name in enumerate(names) if place},
    )
    found = ~np.isnan(again.rates[:, 0])
    assert np.mean(found) > 0.9
    assert_allclose(again.applied[found, 1:], point.applied[found, 1:], rtol=0, atol=1e-7 * machine.reference_force)
    same = np.abs(again.rates - rates)[found].max(axis=-1) < 1e-6
    assert np.mean(same) > 0.9  # two motions can need the same forces


@given(st.sampled_from(LAWS), seeds)
def test_steer_finds_headings_for_a_motion_and_forces(law, seed):
    random = np.random.default_rng(seed)
    machine = random_machine(random, [measured(law) for _ in range(4)], 3, spin=False)
    rates, force = random.normal(size=(100, 3)), 20.0 * random.normal(size=(100, 2))
    heading = machine.steer(rates=rates, applied={"q1": force[:, 0], "q3": force[:, 1]})
    found = ~np.isnan(heading[0][:, 0])
    assert np.mean(found) > 0.4  # the others slip under these loads
    point = machine.operate(rates=rates[found], heading=tuple(part[found] for part in heading))
    assert_allclose(point.applied[:, [0, 2]], force[found], rtol=0, atol=1e-7 * machine.reference_force)
    assert np.all(point.limit == Limit.OK)


def test_steer_with_spin_finds_headings():
    random = np.random.default_rng(2)
    machine = random_machine(random, [pressed() for _ in range(3)], 3, spin=True)
    rates = random.normal(size=(50, 3))
    heading = machine.steer(rates=rates, applied={"q2": 5.0})
    found = ~np.isnan(heading[0][:, 0])
    assert np.mean(found) > 0.5
    point = machine.operate(rates=rates[found], heading=tuple(part[found] for part in heading))
    assert_allclose(point.applied[:, 1], 5.0, rtol=0, atol=1e-6)


def test_solve_counts_the_spin():
    """Three wheels whose forces follow the spin of the body that they carry."""
    random = np.random.default_rng(12)
    contact = pressed(wheel_radius=0.02)
    points = random.normal(size=(3, 2))
    jacobian = np.stack([[[1.0, 0.0, -y], [0.0, 1.0, x]] for x, y in points])
    machine = Mechanism(contacts=contact, jacobian=jacobian, spin=[[0.0, 0.0, 1.0]] * 3)
    rates = random.normal(size=(40, 3)) * [1.0, 0.3, 2.0]
    heading = np.arctan2(*machine.steer(rates=rates)[::-1]) + 1e-4 * random.normal(size=(40, 3))
    point = machine.operate(rates=rates, heading=heading)
    again = machine.solve(
        heading=heading, rates={"q1": rates[:, 0]}, applied={"q2": point.applied[:, 1], "q3": point.applied[:, 2]}
    )
    ok = point.limit == Limit.OK
    assert ok.sum() > 10
    close = np.abs(again.rates - rates).max(axis=-1) < 1e-6
    assert np.mean(close[ok]) > 0.9


@pytest.mark.parametrize("law", [*LAWS, "spin"])
def test_slopes_of_a_contact(law):
    """Against central differences of its forces."""
    random = np.random.default_rng(9)
    contact = pressed() if law == "spin" else measured(law)
    u, v = 1e-3 * random.normal(size=50), random.choice([-1, 1], 50) * random.uniform(0.5, 1, 50)
    spin = 3.0 * random.normal(size=50) if law == "spin" else None
    groups = contact.groups(0.0)

    def forces(creep, rolling, turning):
        found = contact.act((rolling, creep), (1.0 + 0.0 * creep, 0.0 * creep), spin=turning)
        return np.stack([found.lateral_force, found.moment])

    found = slopes(contact, groups, u, v, spin)
    for place, size in enumerate((1e-7, 1e-5, 1e-5)):
        if place == 2 and spin is None:
            assert_array_equal(found[2], 0.0)
            continue
        step = size * np.eye(3)[place]
        turned = [spin if spin is None else spin + sign * step[2] for sign in (1, -1)]
        high, low = (forces(u + s * step[0], v + s * step[1], t) for s, t in zip((1, -1), turned, strict=True))
        for expected, got in zip((high - low) / (2 * size), (found[place], found[3 + place]), strict=True):
            assert_allclose(got, expected, rtol=1e-3, atol=1e-4 * np.abs(expected).max() + 1e-12)


def test_slopes_of_a_patch_that_turns_on_the_spot():
    """The limit of no rolling speed, as of a roller that locks while its patch spins."""
    contact = pressed()
    groups = contact.groups(0.0)
    slow = slopes(contact, groups, np.array([1e-5]), np.array([1e-9]), np.array([5.0]))
    spot = slopes(contact, groups, np.array([1e-5]), np.array([0.0]), np.array([5.0]))
    assert_allclose(spot.force_by_creep, slow.force_by_creep, rtol=1e-3)
    assert spot.force_by_creep > 0.0
    step = 1e-8
    forces = [contact.act((0.0, 1e-5 + way * step), (1.0, 0.0), spin=5.0).lateral_force for way in (1, -1)]
    assert_allclose(spot.force_by_creep, (forces[0] - forces[1]) / (2 * step), rtol=1e-3)


def test_rest_and_motion_mix_in_one_batch():
    machine = replace(HARD, creep_law="exact").mechanism
    speed, force = np.array([0.0, 2.0, 0.0]), np.array([5.0, 5.0, 1e4])
    point = machine.solve(heading=as_heading(np.full(3, 0.3)), rates={"cylinder": speed}, applied={"link": force})
    assert_array_equal(point.limit, [Limit.OK, Limit.OK, Limit.SLIP])
    assert_array_equal(point.rates[[0, 2]], 0.0)
    assert point.rates[1, 0] < 0.0
    assert_array_equal(np.isnan(point.applied), [[False, True], [False, False], [False, True]])


def test_forces_do_not_depend_on_speed():
    random = np.random.default_rng(8)
    machine = random_machine(random, [measured("exact") for _ in range(3)], 3, spin=False)
    rates = random.normal(size=(50, 3))
    rolling = np.arctan2(*machine.steer(rates=rates)[::-1]) + 1e-3
    slow, fast = (machine.operate(rates=size * rates, heading=rolling) for size in (1e-6, 1e3))
    assert_allclose(slow.applied, fast.applied, rtol=1e-9, atol=1e-9)


def test_one_point_is_a_batch_of_one():
    element = replace(HARD, creep_law="exact")
    machine = element.mechanism
    heading = (np.array([0.3]), np.array([np.sqrt(1 - 0.09)]))
    one = machine.solve(heading=heading, rates={"cylinder": 3.0}, applied={"link": 10.0})
    many = machine.solve(heading=heading, rates={"cylinder": np.full((2, 3), 3.0)}, applied={"link": 10.0})
    assert one.rates.shape == (2,)
    assert many.rates.shape == (2, 3, 2)
    assert_allclose(many.rates, np.broadcast_to(one.rates, (2, 3, 2)), rtol=1e-12)
    assert float(one.power_in) > 0.0
    assert one.heading.shape == (1,)


# ---- at rest


def test_a_wheel_at_rest_has_no_determined_force():
    machine = replace(HARD, creep_law="exact").mechanism
    point = machine.operate(rates=[0.0, 0.0], heading=[0.3])
    assert np.all(np.isnan(point.applied))


@pytest.mark.parametrize("angle", [0.0, 0.4, -1.2])
def test_static_friction_holds_the_link_until_slip(angle):
    """A standing cylinder whose torque is free: the wheel holds the link up to its slip limit."""
    element = replace(HARD, creep_law="exact")
    forces = np.array([0.5, 0.99, 1.01, 3.0]) * element.slip_force * np.cos(angle)
    known = element.operate(cylinder_speed=0.0, steering_angle=angle, link_force=forces)
    point = element.mechanism.solve(
        heading=(np.sin([angle]), np.cos([angle])), rates={"cylinder": np.zeros(4)}, applied={"link": forces}
    )
    best = (element.slip_force * np.cos(angle) + element.groups(0.0).rolling_force * abs(np.sin(angle))) / forces
    assert_allclose(1.0 / point.utilisation[Limit.SLIP], best, rtol=1e-6)
    held = np.array([True, True, False, False])
    assert_array_equal(point.limit == Limit.OK, held)
    if angle == 0.0:
        assert_array_equal(known.limit, point.limit)
    assert_array_equal(point.rates, np.zeros((4, 2)))
    assert np.all(np.isnan(point.lateral_force))


def test_a_force_that_no_wheel_can_balance_gives_no_motion():
    """One wheel on a carriage that no wheel guides along the third coordinate."""
    machine = Mechanism(contacts=measured(), jacobian=[[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]])
    point = machine.solve(heading=[0.1], rates={"q1": 1.0}, applied={"q2": 0.0, "q3": 1.0})
    assert np.all(np.isnan(point.rates))
    assert point.limit == Limit.SLIP
    at_rest = machine.solve(heading=[0.1], rates={"q1": 0.0}, applied={"q2": 0.0, "q3": 1.0})
    assert at_rest.limit == Limit.SLIP


# ---- messages


BAD = {
    "jacobian must be of shape (..., wheels, 2, coordinates), got shape (2, 2)": {"jacobian": np.eye(2)},
    "jacobian must be of shape (..., wheels, 2, coordinates), got shape (1, 3, 2)": {"jacobian": np.ones((1, 3, 2))},
    "spin must be of shape (..., 1, 2), got shape (1, 3)": {"spin": np.ones((1, 3))},
    "surface must be of shape (..., 1, 2), got shape (2, 2)": {"surface": np.ones((2, 2))},
    "coordinates must be 2 different names, got ('x',)": {"coordinates": ("x",)},
    "coordinates must be 2 different names, got ('x', 'x')": {"coordinates": ("x", "x")},
    "contacts must be 1, one for each wheel of the jacobian, got 2": {"contacts": [measured(), measured()]},
    "contacts must be RollingContact, got 3": {"contacts": [3]},
    "creep_law must be one without a flow loss, got 'faulring'": {"contacts": measured("faulring")},
}


@pytest.mark.parametrize("message", BAD)
def test_wrong_machines_are_refused(message):
    good = {"contacts": measured(), "jacobian": np.ones((1, 2, 2))}
    with pytest.raises(iv.ParameterError) as caught:
        Mechanism(**good | BAD[message])
    assert message in str(caught.value)


CONTACTS = {
    "preload must be > 0 N, got 0.0": {"preload": 0.0},
    "surface must be one of cylinder, sphere, plane, got 'cone'": {"surface": "cone"},
    "creep_stiffness is missing: give creep_stiffness, rolling_torque, bearing_torque, or geometry": {
        "creep_stiffness": None
    },
    "creep_stiffness and geometry exclude each other": {"geometry": GEOMETRY},
}


@pytest.mark.parametrize("message", CONTACTS)
def test_wrong_contacts_are_refused(message):
    with pytest.raises(iv.ParameterError) as caught:
        measured(**CONTACTS[message])
    assert message in str(caught.value)


def test_a_round_surface_needs_its_radius():
    with pytest.raises(iv.ParameterError, match="surface_radius is missing: surface = 'sphere' needs it"):
        pressed(surface="sphere")
    with pytest.raises(iv.ParameterError, match="surface_radius is of a cylinder or sphere, but surface is 'plane'"):
        pressed(radius=0.1)


def test_wrong_questions_are_refused():
    machine = Mechanism(contacts=measured(), jacobian=np.ones((1, 2, 2)), coordinates=("link", "shaft"))
    with pytest.raises(iv.ParameterError, match=r"unknown coordinate 'lonk' \(did you mean 'link'\?\)"):
        machine.operate(rates={"lonk": 1.0, "shaft": 1.0}, heading=[0.0])
    with pytest.raises(iv.ParameterError, match="rates of shaft is missing"):
        machine.operate(rates={"link": 1.0}, heading=[0.0])
    with pytest.raises(
        iv.ParameterError, match="give either the rate of shaft or the force applied to it, got neither"
    ):
        machine.solve(heading=[0.0], rates={"link": 1.0}, applied={})
    with pytest.raises(iv.ParameterError, match="rates is empty: forces alone leave the speed"):
        machine.solve(heading=[0.0], rates={}, applied={"link": 1.0, "shaft": 1.0})
    with pytest.raises(iv.ParameterError, match="applied has 2 forces, but 1 headings"):
        machine.steer(rates=[1.0, 1.0], applied={"link": 1.0, "shaft": 1.0})
    shapes = {
        r"heading must be of shape \(..., 1\), one for each wheel, got shape \(2,\)": ([0.0, 0.1], [1.0, 1.0]),
        r"heading must be of shape \(..., 1\), one for each wheel, got shape \(\)": (0.0, [1.0, 1.0]),
        r"rates must be of shape \(..., 2\), one for each coordinate, got shape \(3,\)": ([0.0], [1.0, 1.0, 1.0]),
    }
    for message, (heading, rates) in shapes.items():
        with pytest.raises(iv.ParameterError, match=message):
            machine.operate(rates=rates, heading=heading)

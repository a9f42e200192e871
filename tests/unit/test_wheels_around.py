"""Several equal wheels on one cylinder: they share the link's force, and hold each other."""

import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import infinivar as iv
from infinivar import ParameterError, power
from infinivar.analysis import two_ways
from infinivar.parts import CylinderBearings
from internals import Service, WheelLoad, built_part, spread
from made import loaded

KNEE = loaded("knee_walking")
LEG = KNEE.drives["cobotic"]
EXACT = LEG.transmission
LINEAR = iv.RotaryLinearIVT(
    cylinder_radius=0.05,
    wheel_radius=0.01,
    preload=2000.0,
    friction=0.12,
    creep_stiffness=3e5,
    rolling_torque=2e-3,
    bearing_torque=3e-3,
)
MANY = (2, 3)
BEARING = built_part(iv.parts.Bearing, "6004")
SERVICE = Service(0.06, 175.0)
TOTALS = ("torque", "lateral_force", "link_force")


def around(drive, wheels):
    """A drive with several wheels, and all that follows from its geometry derived."""
    steering = replace(drive.steering, bell_inertia=None)
    transmission = replace(drive.transmission, wheels=wheels)
    return replace(drive, transmission=transmission, steering=steering, link_mass=None, cylinder_inertia=None)


@pytest.mark.parametrize("element", [EXACT, LINEAR], ids=["exact", "linear"])
@pytest.mark.parametrize("wheels", MANY)
@pytest.mark.parametrize("way", ["operate", "at speed", "deliver"])
def test_n_wheels_equal_one_with_its_share_n_times(element, wheels, way):
    rng = np.random.default_rng(wheels)
    omega, angle, speed = rng.uniform([[-20.0], [-1.2], [-0.4]], [[20.0], [1.2], [0.4]], (3, 500))
    force = rng.uniform(-0.9, 0.9, 500) * element.slip_force
    many = replace(element, wheels=wheels)
    if way == "operate":
        given = {"cylinder_speed": omega, "steering_angle": angle}
        one, all_ = (at.operate(**given, link_force=load) for at, load in ((element, force), (many, wheels * force)))
    elif way == "at speed":
        given = {"cylinder_speed": omega, "steering_angle": angle, "link_speed": speed}
        one, all_ = (at.operate(**given) for at in (element, many))
    else:
        given = {"cylinder_speed": omega, "link_speed": speed}
        one, all_ = (at.deliver(**given, link_force=load) for at, load in ((element, force), (many, wheels * force)))
        angles = [at.steer(**given, link_force=load) for at, load in ((element, force), (many, wheels * force))]
        assert_allclose(angles[1], angles[0], rtol=1e-9, atol=1e-12)
    for name in TOTALS:
        assert_allclose(getattr(all_, name), wheels * getattr(one, name), rtol=1e-9, atol=1e-9)
    for name in ("link_speed", "creep_speed", "rolling_speed", "steering_tangent"):
        assert_allclose(getattr(all_, name), getattr(one, name), rtol=1e-9, atol=1e-12)
    for name, loss in one.losses.items():
        assert_allclose(all_.losses[name], wheels * loss, rtol=1e-9, atol=1e-9)
    assert_allclose(all_.utilisation[iv.Limit.SLIP], one.utilisation[iv.Limit.SLIP], rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("wheels", MANY)
def test_limits_of_the_contact_are_those_of_one_wheel(wheels):
    many = replace(EXACT, wheels=wheels)
    assert many.slip_force == wheels * EXACT.slip_force
    assert many.wheel == EXACT.wheel
    assert {one: many.utilisation[one] for one in EXACT.wheel.utilisation} == EXACT.wheel.utilisation


@pytest.mark.parametrize("wheels", MANY)
def test_the_mechanism_is_the_same_machine(wheels):
    many, angle = replace(LINEAR, wheels=wheels), 0.3
    point = many.operate(cylinder_speed=10.0, steering_angle=angle, link_speed=-0.15)
    headings = np.full(wheels, 0.5 * math.pi - angle)
    found = many.mechanism.operate(rates=np.array([-0.15, 10.0]), heading=headings)
    assert_allclose(found.applied, [point.link_force, -point.torque], rtol=1e-9)


@pytest.mark.parametrize("wheels", [0, 4, 2.5, True])
def test_other_numbers_are_refused(wheels):
    with pytest.raises(ParameterError, match=rf"wheels must be 1, 2 .* got {wheels!r}"):
        replace(LINEAR, wheels=wheels)


def test_backing_rollers_and_legs_are_refused():
    rollers = CylinderBearings(bearing=BEARING, backing_rollers=1)
    free = replace(around(LEG, 2), guideway=iv.parts.Guideway())
    with pytest.raises(
        ParameterError, match=r"cylinder_bearings\.backing_rollers must be 0 with transmission\.wheels > 1"
    ):
        replace(free, cylinder_bearings=rollers)
    with pytest.raises(ParameterError, match=r"transmission\.wheels must be 1 in a machine of legs"):
        iv.transmission.Legs(transmission=replace(LINEAR, wheels=2), count=3)


@pytest.mark.parametrize("wheels", MANY)
def test_the_cylinder_carries_the_thrust_alone(wheels):
    bearings = CylinderBearings(bearing=BEARING, span=0.14, wheel_position=0.05)
    load = WheelLoad(preload=2200.0, torque=4.0, force=150.0, radius=0.05)
    found = bearings.reactions(spread(load, wheels))
    assert_allclose([found.first[0], found.second[0]], 0.0, atol=1e-9)
    assert_allclose(found.first[1], 150.0, rtol=1e-12)


@pytest.mark.parametrize("wheels", MANY)
def test_steering_turns_all_bells_and_the_guideway_carries_no_preload(wheels):
    one, many = around(LEG, 1), around(LEG, wheels)
    assert_allclose(many.steering.inertia_of_bell, wheels * one.steering.inertia_of_bell, rtol=1e-12)
    before = one.steering.friction_torques(one.transmission)
    for name, torque in many.steering.friction_torques(many.transmission).items():
        assert_allclose(torque, wheels * before[name], rtol=1e-12)
    assert many.transmission.unbalanced_preload == 0.0
    point = many.operate(speed=np.array([0.1, -0.1, 0.1]), force=np.array([100.0, 100.0, -100.0]))
    assert np.max(power.residual(point.power_in, point.power_out, point.losses)) < 1e-12


def test_prescribed_and_simulated_losses_agree():
    held = replace(around(LEG, 2), cylinder_bearings=CylinderBearings(bearing=BEARING, span=0.14))
    held = replace(held, link_mass=LEG.link_mass, cylinder_inertia=LEG.cylinder_inertia)
    found = two_ways(held, KNEE.duty["walking"])
    for name in ("rolling", "bearing", "cylinder bearings", "gearhead"):
        assert_allclose(found.lost_followed[name], found.lost_prescribed[name], rtol=3e-3)
    assert_allclose(found.followed, found.as_resting, rtol=0.02)


@pytest.mark.parametrize("wheels", MANY)
def test_masses_are_those_of_all_wheels(wheels):
    one, many = ({body.name: body for body in around(LEG, n).bodies(SERVICE)} for n in (1, wheels))
    for name in ("wheel", "axle bearings", "bell", "bell bearing", "preload spring"):
        assert_allclose(many[name].mass, wheels * one[name].mass, rtol=1e-12)
    assert many["carriage ring"].mass > 0.0
    assert many["carriage ring"].moving
    assert "carriage ring" not in one
    assert many["frame"].mass < one["frame"].mass
    space = around(LEG, wheels).layout(SERVICE)
    assert {solid.body for solid in space.solids} >= {"carriage ring", "wheel"}
    assert sum(solid.body == "wheel" for solid in space.solids) == wheels

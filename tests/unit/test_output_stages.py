"""Output stages of a geared drive: screws, belts, racks and shafts against closed forms; their limits; studies with them."""

import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import infinivar as iv
from infinivar import Limit
from infinivar.motion import Course
from infinivar.parts import belt, screw
from internals import beams, performance, quantities_of, with_values

DRIVE = iv.ConventionalDrive(
    motor=iv.parts.Motor(
        voltage=24.0,
        resistance=2.0,
        torque_constant=0.025,
        no_load_current=0.0,
        continuous_torque=0.03,
        rotor_inertia=1.5e-6,
    ),
    gearhead=iv.parts.Gearhead(ratio=2.0, efficiency=1.0),
    pulley=iv.parts.Pulley(radius=0.01),
    output_inertia=1e-6,
)
SCREW = iv.parts.Screw(lead=2e-3, diameter=9e-3, friction_angle=0.1)


def with_stage(**stage):
    return replace(DRIVE, pulley=None, **stage)


def at_friction_angle(share):
    """A screw whose friction angle is a multiple of its lead angle."""
    return replace(SCREW, friction_angle=share * float(SCREW.lead_angle))


@pytest.mark.parametrize(("share", "locks"), [(0.999, False), (1.0, True), (1.001, True), (3.0, True)])
def test_a_screw_locks_itself_exactly_at_its_lead_angle(share, locks):
    """From rho = lambda on it holds any load without current; below, the current that F d/2 tan(lambda - rho) needs."""
    drive = with_stage(screw=at_friction_angle(share))
    assert drive.screw.self_locking is locks
    for force in (-300.0, 1.0, 300.0):
        current = float(drive.operate(speed=0.0, force=force).states["motor_current_A"])
        angle = max(float(SCREW.lead_angle) * (1.0 - share), 0.0)
        torque = force * 9e-3 / 2.0 * math.tan(angle)
        assert current == pytest.approx(torque / (2.0 * 0.025), rel=1e-9, abs=1e-15)


def test_screw_torques_are_those_of_the_inclined_plane():
    """Wedge of the lead angle with friction mu, moved by a horizontal force: balance of forces without any tangent rule."""
    lead, diameter, mu, load = 5e-3, 16e-3, 0.12, 800.0
    part = iv.parts.Screw(lead=lead, diameter=diameter, friction_coefficient=mu)
    slope = lead / (math.pi * diameter)
    norm = math.hypot(1.0, slope)
    sine, cosine = slope / norm, 1.0 / norm
    for way, speed in ((1.0, 0.1), (-1.0, -0.1)):
        # Vertical: N cos - way mu N sin = W; horizontal: P = N sin + way mu N cos.
        normal = load / (cosine - way * mu * sine)
        push = normal * (sine + way * mu * cosine)
        torque, turning, loss = part.operate(force=load, speed=speed)
        assert torque == pytest.approx(push * diameter / 2.0, rel=1e-12)
        assert loss == pytest.approx(torque * turning - load * speed, rel=1e-12)
        # Friction force times sliding speed on the flank.
        assert loss == pytest.approx(mu * normal * abs(turning) * diameter / 2.0 / cosine, rel=1e-12)


def test_flank_angle_raises_friction_as_shown_for_acme_threads():
    """Square and trapezoidal thread: mu is divided by the cosine of half the thread angle."""
    flat = iv.parts.Screw(lead=4e-3, diameter=18e-3, friction_coefficient=0.1 / math.cos(math.radians(15.0)))
    steep = replace(flat, friction_coefficient=0.1, flank_angle=math.radians(15.0))
    assert_allclose(flat.efficiencies, steep.efficiencies, rtol=1e-14)


def test_efficiency_limits():
    """Lossless at no friction; no self-locking screw exceeds 50 %; a stated efficiency gives the friction angle it needs."""
    assert_allclose(screw.screw_efficiencies(0.2, 0.0), (1.0, 1.0), rtol=1e-15)
    angles = np.linspace(0.01, 0.7, 50)
    forward, backward = screw.screw_efficiencies(angles, angles)
    assert_allclose(backward, 0.0)
    assert_allclose(forward, 0.5 * (1.0 - np.tan(angles) ** 2), rtol=1e-12)
    stated = iv.parts.Screw(shape="ball", lead=5e-3, diameter=16e-3, efficiency=0.9)
    assert_allclose(screw.screw_efficiencies(stated.lead_angle, stated.angle)[0], 0.9, rtol=1e-14)
    # For small angles the efficiency while the load drives tends to 2 - 1/eta.
    fine = iv.parts.Screw(shape="ball", lead=1e-5, diameter=16e-3, efficiency=0.9)
    assert fine.efficiencies[1] == pytest.approx(2.0 - 1.0 / 0.9, rel=1e-6)
    assert replace(stated, backdriving_efficiency=0.8).efficiencies == (0.9, 0.8)


@pytest.mark.parametrize(
    ("ends", "boundary"),
    [
        ("fixed-free", lambda k: math.cos(k)),
        ("supported-supported", lambda k: math.sin(k)),
        ("fixed-supported", lambda k: math.sin(k) - k * math.cos(k)),
        ("fixed-fixed", lambda k: 2.0 - 2.0 * math.cos(k) - k * math.sin(k)),
    ],
)
def test_euler_loads_are_eigenvalues_of_the_column(ends, boundary):
    """F = (k/L)^2 E I, with the first k at which the bent column meets its end conditions."""
    from scipy.optimize import brentq, minimize_scalar

    diameter, length, modulus = 12e-3, 1.1, 206e9
    found = screw.buckling_load(diameter, length, ends, modulus)
    inertia = math.pi * diameter**4 / 64.0
    k = math.sqrt(found * length**2 / (modulus * inertia))
    if ends == "fixed-fixed":  # a double root
        root = minimize_scalar(
            lambda x: abs(boundary(x)), bounds=(5.5, 7.0), method="bounded", options={"xatol": 1e-9}
        ).x
    else:
        root = brentq(boundary, 0.8 * k, 1.2 * k)
    assert k == pytest.approx(root, rel=1e-5)


def test_short_columns_follow_johnson():
    """Both curves meet with one slope at half the yield strength; a very short column yields."""
    strength, diameter = 400e6, 12e-3
    area = math.pi * diameter**2 / 4.0
    meeting = math.pi * diameter / 4.0 * math.sqrt(2.0 * 206e9 / strength)
    just = [meeting * (1.0 + shift) for shift in (-1e-6, 0.0, 1e-6)]
    loads = [screw.buckling_load(diameter, length, "supported-supported", 206e9, strength) for length in just]
    assert loads[1] == pytest.approx(0.5 * strength * area, rel=1e-9)
    assert loads[0] - loads[1] == pytest.approx(loads[1] - loads[2], rel=1e-4)
    assert screw.buckling_load(diameter, 1e-4, "fixed-fixed", 206e9, strength) == pytest.approx(
        strength * area, rel=1e-6
    )


@pytest.mark.parametrize("ends", beams.BENDING)
def test_critical_speed_against_finite_differences(ends):
    """Eigenvalues of a uniform beam by Hermite finite elements: an independent way to the same speed."""
    from scipy.linalg import eigh

    diameter, length, modulus, density, count = 10e-3, 0.8, 206e9, 7850.0, 12
    bending = modulus * math.pi * diameter**4 / 64.0
    mass = density * math.pi * diameter**2 / 4.0
    h = length / count
    stiff = bending / h**3 * np.array([[12, 6 * h, -12, 6 * h], [6 * h, 4 * h * h, -6 * h, 2 * h * h],
                                       [-12, -6 * h, 12, -6 * h], [6 * h, 2 * h * h, -6 * h, 4 * h * h]])  # fmt: skip
    heavy = mass * h / 420 * np.array([[156, 22 * h, 54, -13 * h], [22 * h, 4 * h * h, 13 * h, -3 * h * h],
                                       [54, 13 * h, 156, -22 * h], [-13 * h, -3 * h * h, -22 * h, 4 * h * h]])  # fmt: skip
    size = 2 * (count + 1)
    whole, inertia = np.zeros((size, size)), np.zeros((size, size))
    for place in range(count):
        at = slice(2 * place, 2 * place + 4)
        whole[at, at] += stiff
        inertia[at, at] += heavy
    near, far = ends.split("-")
    fixed = [{"fixed": [0, 1], "supported": [0]}[near], {"fixed": [-2, -1], "supported": [-2], "free": []}[far]]
    kept = sorted(set(range(size)) - {place % size for side in fixed for place in side})
    lowest = eigh(whole[np.ix_(kept, kept)], inertia[np.ix_(kept, kept)], eigvals_only=True)[0]
    assert screw.critical_speed(diameter, length, ends, modulus, density) == pytest.approx(math.sqrt(lowest), rel=1e-4)


def test_two_spans_of_a_belt_act_in_parallel():
    """Energy of both strained spans at a displacement x, k x^2/2, and the series of unit lengths of one span."""
    specific, near, far, x = 4e5, 0.3, 1.2, 1e-4
    energy = 0.5 * specific * ((x / near) ** 2 * near + (x / far) ** 2 * far)
    assert belt.belt_stiffness(specific, near, far) == pytest.approx(2.0 * energy / x**2, rel=1e-14)
    assert 1.0 / belt.belt_stiffness(specific, near) == pytest.approx(near / specific)
    part = iv.parts.Belt(pitch=3e-3, teeth=20, specific_stiffness=specific, span=near, other_span=far)
    assert part.stiffness == belt.belt_stiffness(specific, near, far)
    assert iv.parts.Belt(pitch=3e-3, teeth=20).stiffness is None


def test_travel_per_turn():
    """One turn moves the load by the lead, by the teeth of a belt's wheel, by the pinion's circumference."""
    turn = 2.0 * math.pi
    assert SCREW.travel_per_radian * turn == pytest.approx(2e-3)
    assert iv.parts.Belt(pitch=3e-3, teeth=20).travel_per_radian * turn == pytest.approx(60e-3)
    assert iv.parts.Rack(module=1e-3, teeth=20).travel_per_radian == pytest.approx(10e-3)
    assert iv.parts.Shaft().travel_per_radian == 1.0


def test_limits_of_a_screw():
    """Each demand is 1 where force or speed reaches the closed form."""
    part = iv.parts.Screw(
        shape="ball", lead=5e-3, diameter=16e-3, efficiency=0.9, length=1.0, root_diameter=12.5e-3, ends="fixed-fixed",
        max_speed=500.0, permissible_force=9000.0, dynamic_load=8000.0, life=3.6e7,
    )  # fmt: skip
    per_radian = part.travel_per_radian
    demand = part.utilisation(force=-part.buckling_load / 2.0, speed=-0.8 * part.critical_speed * per_radian)
    assert demand[Limit.BUCKLING] == pytest.approx(1.0)
    assert demand[Limit.CRITICAL_SPEED] == pytest.approx(1.0)
    assert part.utilisation(force=9000.0, speed=500.0 * per_radian)[Limit.OUTPUT_FORCE] == pytest.approx(1.0)
    assert part.utilisation(force=9000.0, speed=500.0 * per_radian)[Limit.OUTPUT_SPEED] == pytest.approx(1.0)
    # 1e6 (C/F)^3 revolutions at 20 revolutions a second.
    force, rate = 2000.0, 20.0
    lasts = 1e6 * (8000.0 / force) ** 3 / rate
    found = replace(part, life=lasts).utilisation(force=force, speed=rate * 5e-3)
    assert found[Limit.LIFE] == pytest.approx(1.0, rel=1e-12)
    assert part.utilisation(force=force, speed=0.0)[Limit.LIFE] == 0.0
    assert set(SCREW.utilisation(force=1.0, speed=1.0)) == set()


def test_life_does_not_depend_on_directions():
    forces, speeds = np.array([[2000.0], [-2000.0]]), np.array([3.0, -3.0, 0.0])
    demand = screw.life_demand(forces, speeds, 8000.0, 1e7)
    assert_allclose(demand, np.full((2, 3), [demand[0, 0], demand[0, 0], 0.0]))
    assert demand[0, 0] > 0.0


def test_life_over_a_cycle_is_that_of_the_cubic_mean_load():
    """Half the travel at 3 kN, half at 1 kN, at different speeds: damage adds up by revolutions (Palmgren and Miner)."""
    part = iv.parts.Screw(shape="ball", lead=5e-3, diameter=16e-3, efficiency=0.9, dynamic_load=8000.0, life=1e7)
    drive = replace(with_stage(screw=part))
    force, speed = np.repeat([3000.0, 1000.0], [30, 10]), np.repeat([0.05, 0.15], [30, 10])
    point = drive.follow(Course(speed=speed, acceleration=0.0 * speed, force=-force))
    demand = performance.demands(point)[Limit.LIFE, "screw"]
    mean_load = ((3000.0**3 + 1000.0**3) / 2.0) ** (1.0 / 3.0)
    lasts = 1e6 * (8000.0 / mean_load) ** 3 / (speed.mean() / 5e-3)
    assert demand == pytest.approx((1e7 / lasts) ** (1.0 / 3.0), rel=1e-12)


def test_force_limits_of_belt_rack_and_shaft():
    parts = [
        iv.parts.Belt(pitch=3e-3, teeth=20, permissible_force=200.0),
        iv.parts.Rack(module=1e-3, teeth=20, permissible_force=200.0),
        iv.parts.Shaft(permissible_torque=200.0),
    ]
    for part in parts:
        point = with_stage(**{part.title: part}).operate(speed=0.01, force=np.array([-300.0, 100.0]))
        assert_allclose(point.utilisation[Limit.OUTPUT_FORCE], [1.5, 0.5])


def test_a_shaft_turns_a_joint():
    drive = with_stage(shaft=iv.parts.Shaft(friction_torque=0.02))
    assert drive.axis.rotary
    assert not DRIVE.axis.rotary
    point = drive.operate(speed=3.0, force=0.1)
    assert point.states["motor_speed_rad_s"] == 6.0
    assert point.states["motor_current_A"] == pytest.approx(0.12 / (2.0 * 0.025))


def test_inertia_of_a_screw_adds_to_that_of_the_gear_output():
    heavy = with_stage(screw=replace(SCREW, inertia=3e-6))
    assert heavy.gear_output_inertia == pytest.approx(4e-6)
    assert replace(heavy, output_inertia=None).gear_output_inertia == 3e-6
    assert with_stage(screw=SCREW, output_inertia=None).gear_output_inertia == 0.0


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({}, "friction_coefficient is missing: state the friction of the thread as one of"),
        ({"friction_angle": 0.1, "efficiency": 0.4}, "friction_angle and efficiency are given"),
        ({"efficiency": 0.4, "flank_angle": 0.2}, "flank_angle does not apply with efficiency"),
        ({"friction_angle": 0.1, "shape": "ball", "flank_angle": 0.1}, "flank_angle does not apply"),
        ({"friction_angle": 0.1, "life": 1e6, "dynamic_load": 1e3}, "dynamic_load does not apply with shape = 'lead'"),
        ({"friction_angle": 0.1, "shape": "ball", "life": 1e6}, "dynamic_load is missing: life needs it"),
        ({"friction_angle": 0.1, "length": 1.0}, "root_diameter is missing: length needs it"),
        ({"friction_angle": 0.1, "length": 1.0, "root_diameter": 10e-3}, "root_diameter must be <= diameter = .* m, got 0.01"),
        ({"friction_angle": 1.49, "lead": 40e-3}, "friction_angle must be less"),
        ({"friction_angle": 0.1, "backdriving_efficiency": 1.1}, "backdriving_efficiency must be <= 1"),
    ],
)  # fmt: skip
def test_faults_of_a_screw_are_named(values, words):
    with pytest.raises(iv.ParameterError, match=words):
        iv.parts.Screw(**{"lead": 2e-3, "diameter": 9e-3, **values})


def test_a_belt_needs_its_span_to_stretch():
    assert iv.parts.Belt(pitch=3e-3, teeth=20, specific_stiffness=1e5).stiffness is None
    with pytest.raises(iv.ParameterError, match="specific_stiffness is missing"):
        iv.parts.Belt(pitch=3e-3, teeth=20, span=0.1)


def test_friction_of_the_guideway_stretches_a_belt():
    """The friction acts at the load: d = (m x'' + f sgn x')/k, and the motor's travel contains it; lost is f |x'|."""
    part = iv.parts.Belt(pitch=3e-3, teeth=20, specific_stiffness=2e4, span=1.0)
    drive = replace(with_stage(belt=part), guideway=iv.parts.Guideway(friction=50.0))
    duty = iv.DutyCycle(motion=iv.motion.Sinusoid(distance=0.05, frequency=0.2), load_mass=1.0)
    found = iv.duty_cycle(drive, duty)
    course = found.instants.course
    force = course.acceleration + 50.0 * np.sign(course.speed)
    columns = found.columns
    assert_allclose(columns["belt_stretch_deflection_m"], force / 2e4, rtol=1e-12, atol=1e-15)
    assert_allclose(columns["drive_position_m"], course.position + force / 2e4, rtol=1e-12, atol=1e-15)
    assert found.losses["guideway"] == pytest.approx(4 * 0.05 * 50.0, rel=1e-6)
    assert_allclose(columns["gear_output_torque_Nm"][:5] / part.travel_per_radian, force[:5], rtol=1e-2)
    held = drive.operate(speed=np.array([0.1, -0.1, 0.0]), force=20.0).states
    assert_allclose(held["belt_stretch_deflection_m"], np.array([70.0, -30.0, 0.0]) / 2e4, atol=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize(("friction", "specific"), [(50.0, 2e4), (100.0, 2e5)])
def test_friction_stretches_a_belt_in_simulation_as_well(friction, specific):
    """The motor makes up for the stretch, to a tenth of it; both ways spend the same energy within 2 %."""
    drive = iv.ConventionalDrive(
        motor=iv.motors()["dcx-32-l-24v"],
        gearhead=iv.parts.Gearhead(ratio=5.0, efficiency=0.95),
        belt=iv.parts.Belt(pitch=3e-3, teeth=20, specific_stiffness=specific, span=1.0),
        guideway=iv.parts.Guideway(friction=friction),
    )
    found = iv.analysis.two_ways(
        drive, iv.DutyCycle(motion=iv.motion.Sinusoid(distance=0.05, frequency=0.2), load_mass=1.0)
    )
    assert found.followed == pytest.approx(found.prescribed, rel=0.02)
    assert found.rms_error < 0.1 * friction / specific


@pytest.mark.parametrize(
    ("stages", "words"), [({}, "pulley is missing"), ({"screw": SCREW, "belt": None}, "and screw are given")]
)
def test_a_drive_has_one_stage(stages, words):
    with pytest.raises(iv.ParameterError, match=f"{words}.*exactly one of pulley, screw, belt, rack, shaft"):
        replace(DRIVE, **(stages or {"pulley": None}))


STUDY = """
[requirement]
force = "40 N"
speed = "50 mm/s"
[drives.lift]
type = "conventional"
output_inertia = "2 g cm^2"
[drives.lift.motor]
voltage = "24 V"
resistance = "2 ohm"
torque_constant = "25 mN m/A"
no_load_current = "50 mA"
continuous_torque = "30 mN m"
[drives.lift.gearhead]
ratio = 2
efficiency = 0.9
"""


def test_stages_in_studies(load):
    text = STUDY
    study = load(
        text + '[drives.lift.screw]\nlead = "2 mm"\ndiameter = "9 mm"\nfriction_coefficient = 0.12\nflank_angle = "15 deg"\n'
        '[uncertainty.lift.screw]\nfriction_coefficient = { low = 0.08, high = 0.2 }\n',
    )  # fmt: skip
    drive = study.drives["lift"]
    expected = iv.parts.Screw(lead=2e-3, diameter=9e-3, friction_coefficient=0.12, flank_angle=math.radians(15))
    assert drive.stage.efficiencies == pytest.approx(expected.efficiencies)
    assert {row.field for row in study.provenance} >= {"screw.lead", "screw.shape", "screw.flank_angle"}
    assert "screw.friction_coefficient" in quantities_of(drive)
    assert with_values(drive, {"screw.lead": 3e-3}).screw.lead == 3e-3
    (spread,) = study.uncertainty.spreads["lift"]
    assert spread.high == 0.2
    for table, words in (
        ("", r"drives.lift needs one of pulley, .*\[drives.lift.screw\]"),
        ('[drives.lift.pulley]\nradius = "1 cm"\n[drives.lift.rack]\nmodule = "1 mm"\nteeth = 20\n', "rack does not apply"),
        ('[drives.lift.belt]\npitch = "3 mm"\n', "drives.lift.belt.teeth is missing"),
    ):  # fmt: skip
        with pytest.raises(iv.InputError, match=words):
            load(text + table)


def test_a_study_replaces_the_stage_of_its_base(load, tmp_path):
    """The base has a pulley; a study that states a belt has no pulley any more."""
    study = load(
        'requirement = { base = "faulring2006" }\n'
        '[drives.mine]\nbase = "faulring2006.motor2-gear4"\n[drives.mine.belt]\npitch = "3 mm"\nteeth = 12\n',
    )
    assert study.drives["mine"].pulley is None
    assert study.drives["mine"].belt.teeth == 12
    (tmp_path / "under.toml").write_bytes((tmp_path / "mine.toml").read_bytes())
    over = load('extends = "under.toml"\n[drives.mine.rack]\nmodule = "1 mm"\nteeth = 12\n')
    assert over.drives["mine"].stage == iv.parts.Rack(module=1e-3, teeth=12)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: iv.parts.Belt(pitch=3e-3, teeth=20.5, efficiency=0.9), "teeth must be a whole number, got 20.5"),
        (lambda: iv.parts.Rack(module=1e-3, teeth=2.5, efficiency=0.9), "teeth must be a whole number, got 2.5"),
        (
            lambda: iv.parts.Screw(lead=5e-3, diameter=0.016),
            "friction_coefficient is missing: state the friction of the thread as one of",
        ),
        (
            lambda: iv.parts.Screw(lead=5e-3, diameter=0.016, efficiency=0.9, root_diameter=0.02, length=0.3),
            r"root_diameter must be <= diameter = 0.016 m, got 0.02",
        ),
        (
            lambda: iv.parts.Screw(lead=5e-3, diameter=0.016, efficiency=0.9, buckling_safety=0.5),
            "buckling_safety must be >= 1",
        ),
        (
            lambda: iv.Output(series_spring=iv.parts.Spring(stiffness=1e3, at="drive")),
            "series_spring.at does not apply: only a parallel spring has a side",
        ),
    ],
)
def test_what_no_stage_can_have_is_refused(make, message):
    with pytest.raises(iv.ParameterError, match=message):
        make()


WRITTEN = """
[requirement]
force = "50 N"
speed = "0.1 m/s"
[drives.lift]
type = "conventional"
motor = {{ part = "dcx-32-l-24v" }}
gearhead = {{ ratio = 2, efficiency = 0.9, loss_model = "proportional" }}
{stage}
"""


@pytest.mark.parametrize("written", ['"5 mm"', '"5 mm/rev"', '"5 mm / rev"', '{ value = 5, unit = "mm/rev" }'])
def test_a_lead_may_be_written_per_revolution(tmp_path, written):
    path = tmp_path / "study.toml"
    path.write_text(WRITTEN.format(stage=f'screw = {{ lead = {written}, diameter = "16 mm", efficiency = 0.9 }}'))
    assert iv.load_study(path).drives["lift"].screw.lead == pytest.approx(5e-3, rel=1e-15)


@pytest.mark.parametrize(
    "stage",
    [
        'screw = { lead = "5 mm/rad", diameter = "16 mm", efficiency = 0.9 }',
        'screw = { lead = "5 mm", diameter = "16 mm/rev", efficiency = 0.9 }',
        'belt = { pitch = "3 mm/rev", teeth = 20 }',
        'rack = { module = "1 mm/rev", teeth = 20 }',
        'pulley = { radius = "8 mm/rev" }',
    ],
)
def test_other_lengths_are_not_per_angle(tmp_path, stage):
    path = tmp_path / "study.toml"
    path.write_text(WRITTEN.format(stage=stage))
    with pytest.raises(iv.InputError, match="which names an angle, where a length is needed"):
        iv.load_study(path)


def test_a_shaft_has_no_guideway():
    """Its friction is a torque; that of a guideway, in N, would be taken for N m."""
    with pytest.raises(iv.ParameterError, match=r"guideway does not apply.*shaft\.friction_torque, in N m"):
        replace(with_stage(shaft=iv.parts.Shaft()), guideway=iv.parts.Guideway(friction=2.0))


@pytest.mark.parametrize(
    ("elastic", "named"),
    [
        ({"output": iv.Output(series_spring=iv.parts.Spring(stiffness=2e3))}, "behind its series spring"),
        ({"belt": iv.parts.Belt(pitch=3e-3, teeth=20, specific_stiffness=800.0, span=0.4)}, "behind its belt stretch"),
        ({"gearhead": iv.parts.Gearhead(ratio=2.0, efficiency=1.0, stiffness=1.0)}, "behind its elastic gearhead"),
    ],
)
def test_a_jerk_that_jumps_is_refused_before_every_compliance(elastic, named):
    """With any of them the motor's speed would jump; with a smooth reach it changes by no more than the sampling resolves."""
    drive = replace(DRIVE, **elastic, **({"pulley": None} if "belt" in elastic else {}))
    rough, smooth = (
        iv.DutyCycle(motion=iv.motion.Reaches(distance=0.1, time=0.4, pause=0.2, profile=profile), load_mass=2.0)
        for profile in ("minimum-jerk", "smooth")
    )
    with pytest.raises(iv.ParameterError, match=f"the jerk of this motion jumps.*{named}.*set profile = 'smooth'"):
        iv.duty_cycle(drive, rough)
    speed = iv.duty_cycle(drive, smooth).point.states["motor_speed_rad_s"]
    assert np.max(np.abs(np.diff(speed))) < 0.05 * np.max(np.abs(speed))


def test_behind_spring_and_elastic_gear_the_fifth_derivative_counts():
    output = iv.Output(series_spring=iv.parts.Spring(stiffness=2e3))
    drive = replace(DRIVE, output=output, gearhead=iv.parts.Gearhead(ratio=2.0, efficiency=1.0, stiffness=1.0))
    reaches = iv.motion.Reaches(distance=0.1, time=0.4, pause=0.2, profile="smooth")
    with pytest.raises(iv.ParameterError, match=r"the fifth derivative.*its series spring and its elastic gearhead"):
        iv.duty_cycle(drive, iv.DutyCycle(motion=reaches, load_mass=2.0))
    waves = iv.motion.Sinusoid(distance=0.1, frequency=1.0)
    assert iv.duty_cycle(drive, iv.DutyCycle(motion=waves, load_mass=2.0)).energy > 0
    assert iv.duty_cycle(drive, iv.DutyCycle(motion=reaches, force=-5.0)).energy > 0

"""Requirement, limits, power accounting and the steady map, case by case."""

import dataclasses
import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import infinivar as iv
from infinivar import AuditError, InputError, Limit, power
from internals import best_efficiency, binding, of_drives
from sampled import sampled

RECTANGLE = iv.Requirement(force=50.0, speed=1.05)
CAPPED = iv.Requirement(force=50.0, speed=1.05, power=12.0)


def test_region_area():
    """Area under the power hyperbola by closed form: P (1 + ln(F v/P))."""
    speed, force, weight = CAPPED.sample(401)
    assert weight.sum() == pytest.approx(1.0, rel=1e-12)
    assert np.all((force <= 50.0) & (speed <= 1.05) & (force * speed <= 12.0 * (1 + 1e-12)))
    area = 12.0 * (1.0 + math.log(50.0 * 1.05 / 12.0))
    # Share of the region below a force, exactly: F v/area up to the corner. The trapezoidal rule is second order.
    below = weight[force <= 12.0 / 1.05].sum()
    assert below == pytest.approx(12.0 / area, rel=5e-3)


def test_region_without_power_is_a_rectangle():
    _, _, weight = RECTANGLE.sample(11)
    assert weight.max() / weight.min() == pytest.approx(4.0)  # inner cell over corner cell
    assert RECTANGLE.corners() == {"maximum force": (1.05, 50.0)}


def test_region_corners_are_sampled():
    speed, force, _ = CAPPED.sample(50)
    for corner in CAPPED.corners().values():
        assert np.any((np.abs(speed - corner[0]) < 1e-12) & (np.abs(force - corner[1]) < 1e-12))


@pytest.mark.parametrize(
    ("quadrants", "signs"),
    [(1, {(1, 1)}), (2, {(1, 1), (1, -1)}), (4, {(1, 1), (1, -1), (-1, 1), (-1, -1)})],
)
def test_quadrants(quadrants, signs):
    speed, force, weight = replace(CAPPED, quadrants=quadrants).sample(21)
    moving = (speed != 0) & (force != 0)
    assert set(zip(np.sign(speed[moving]), np.sign(force[moving]), strict=True)) == signs
    assert weight.sum() == pytest.approx(1.0)


def test_requirement_refuses():
    with pytest.raises(ValueError, match="force must be > 0 N, got 0"):
        replace(CAPPED, force=0.0)
    with pytest.raises(ValueError, match="quadrants must be one of 1, 2, 4, got 3"):
        replace(CAPPED, quadrants=3)


def test_binding_names_the_tightest_limit():
    limit, margin = binding(
        {Limit.VOLTAGE: np.array([0.5, 2.0, np.inf, 0.0]), Limit.THERMAL: np.array([0.8, 3.0, np.nan, 0.0])}
    )
    assert list(limit) == [Limit.OK, Limit.THERMAL, Limit.VOLTAGE, Limit.OK]
    assert_allclose(margin, [1.25, 1 / 3, 0.0, np.inf])


def test_slip_comes_before_all_others():
    """Where the wheel slips the other demands are not those of a real motion."""
    limit, margin = binding({Limit.SLIP: np.array([1.05, 0.9]), Limit.SPEED: np.array([1.3, 1.3])})
    assert list(limit) == [Limit.SLIP, Limit.SPEED]
    assert_allclose(margin, [1 / 1.05, 1 / 1.3])


def test_exactly_at_a_limit_is_within():
    limit, margin = binding({Limit.VOLTAGE: np.array([1.0, np.nextafter(1.0, 2.0)])})
    assert list(limit) == [Limit.OK, Limit.VOLTAGE]
    assert margin[0] == 1.0


@pytest.mark.parametrize(
    ("power_in", "power_out", "expected"),
    [
        (10.0, 5.0, 0.5),
        (10.0, 0.0, 0.0),  # spent, and none comes out
        (-4.0, -8.0, 0.5),  # the load drives the source
        (0.0, -8.0, 0.0),  # the load drives, and nothing comes back
        (3.0, -5.0, math.nan),  # both feed the losses
        (0.0, 0.0, math.nan),
        (math.nan, 1.0, math.nan),
    ],
)
def test_efficiency(power_in, power_out, expected):
    found = power.efficiency(np.float64(power_in), np.float64(power_out))
    assert found == pytest.approx(expected, nan_ok=True)
    assert not (found == 0 and math.copysign(1.0, found) < 0)


def test_audit_refuses_a_leak():
    assert power.audit(np.array([10.0]), np.array([9.0]), {"loss": np.array([1.0])}, "test") == 0.0
    with pytest.raises(AuditError, match="test: the power balance has a relative residual of"):
        power.audit(np.array([10.0]), np.array([9.0]), {"loss": np.array([1.0 + 1e-7])}, "test")


@dataclasses.dataclass(frozen=True)
class LeakyDrive:
    """A drive that mislays a share of its power, or forgets to say that it cannot move."""

    inner: iv.ConventionalDrive
    leak: float = 0.0
    hole: bool = False

    @property
    def motors(self):
        return self.inner.motors

    @property
    def gearhead(self):
        return self.inner.gearhead

    def operate(self, *, speed, force):
        point = self.inner.operate(speed=speed, force=force)
        wrong = np.where(force > 20.0, np.nan, 1.0) if self.hole else 1.0 + self.leak
        return replace(point, power_in=point.power_in * wrong)


def test_audit_refuses_a_negative_loss():
    """Two wrongs can add up to a closed balance; a loss below zero gives them away."""
    with pytest.raises(AuditError, match="the creep loss is negative, down to -1 W"):
        power.audit(np.array([10.0]), np.array([9.0]), {"creep": np.array([-1.0]), "gear": np.array([2.0])}, "test")


def test_a_wrong_steering_angle_is_found(study, monkeypatch):
    """Prescribed motion closes its balance by construction; the angle itself must be checked."""
    tangent = iv.RotaryLinearIVT._tangent

    def off(self, *arguments):
        found, usable = tangent(self, *arguments)
        return 0.9999 * found, usable

    monkeypatch.setattr(iv.RotaryLinearIVT, "_tangent", off)
    with pytest.raises(AuditError, match="steering angle"):
        study.drives["cobotic"].operate(speed=0.3, force=20.0)


@pytest.mark.parametrize("name", ["cobotic", "motor2-gear4"])
def test_points_must_be_finite(study, name):
    with pytest.raises(ValueError, match="speed must be finite, got nan"):
        study.drives[name].operate(speed=[0.1, math.nan], force=10.0)
    with pytest.raises(ValueError, match="force must be finite, got inf"):
        study.drives[name].operate(speed=0.1, force=math.inf)


def test_braking_corners():
    assert set(replace(CAPPED, quadrants=2).corners()) == {
        "maximum force",
        "maximum speed",
        "braking at maximum force",
        "braking at maximum speed",
    }
    speed, force = replace(CAPPED, quadrants=4).corners()["braking at maximum force"]
    assert (speed, force) == (12.0 / 50.0, -50.0)


def test_every_map_is_audited(study):
    drive = study.drives["motor2-gear4"]
    axes = np.linspace(0.1, 1.0, 5), np.linspace(1.0, 40.0, 7)
    assert iv.steady_map(LeakyDrive(drive), *axes).audit_residual < 1e-12
    with pytest.raises(AuditError, match="power balance"):
        iv.steady_map(LeakyDrive(drive, leak=1e-8), *axes)
    with pytest.raises(AuditError, match="nan although"):
        iv.steady_map(LeakyDrive(drive, hole=True), *axes)


@pytest.mark.parametrize("axis", [[[1.0, 2.0]], [], [1.0, math.nan], [math.inf]])
def test_map_refuses_bad_axes(study, axis):
    with pytest.raises(InputError, match="speed must be"):
        iv.steady_map(study.drives["cobotic"], axis, [1.0])


def test_map_tiles_long_axes(study):
    """Wider than a tile in one direction, taller in the other."""
    drive = study.drives["cobotic"]
    wide = iv.steady_map(drive, [0.1, 0.2], np.linspace(0, 100, 40_000))
    tall = iv.steady_map(drive, np.linspace(0, 2, 40_000), [10.0, 20.0])
    assert wide.power_in[1, 4000] == drive.operate(speed=0.2, force=wide.force[4000]).power_in
    assert tall.power_in[30_000, 0] == drive.operate(speed=tall.speed[30_000], force=10.0).power_in


def test_map_is_the_same_on_threads(study, monkeypatch):
    """Many small tiles, done side by side, and progress that rises to 1."""
    axes = np.linspace(-1, 2, 60), np.linspace(-100, 100, 70)
    whole = iv.steady_map(study.drives["cobotic"], *axes)
    monkeypatch.setattr("infinivar.analysis.steady_map._TILE", 64)
    shares: list[float] = []
    tiled = iv.steady_map(study.drives["cobotic"], *axes, progress=shares.append)
    assert len(shares) == 60 * 2
    assert shares == sorted(shares)
    assert shares[-1] == 1.0
    assert_array_equal(tiled.limit, whole.limit)
    # Vector and scalar instructions round differently, and a tile may need one Newton step less.
    for field in ("power_in", "power_out", "efficiency", "margin"):
        assert_allclose(getattr(tiled, field), getattr(whole, field), rtol=1e-12, atol=1e-12)
    for name, loss in whole.losses.items():
        assert_allclose(tiled.losses[name], loss, rtol=1e-12, atol=1e-12)


def test_map_as_labelled_data(study, tmp_path):
    import xarray

    steady = iv.steady_map(study.drives["cobotic"], np.linspace(0, 1, 6), np.linspace(0, 100, 9))
    path = tmp_path / "map.nc"
    steady.to_netcdf(path)
    with xarray.open_dataset(path) as data:
        assert {variable.attrs["units"] for variable in data.variables.values()} == {"W", "1", "m s-1", "N"}
        assert_array_equal(data["power_in"].values, steady.power_in)
        assert_array_equal(data["limit"].values, steady.limit)
        losses = sum(data[name] for name in data if str(name).startswith("loss_"))
        moving = np.isfinite(steady.power_in)
        assert_allclose((data["power_out"] + losses).values[moving], steady.power_in[moving], rtol=1e-9)
        assert "SLIP" in data["limit"].attrs["flag_meanings"]
        xarray.testing.assert_identical(data.load(), steady.to_xarray())


def test_regeneration_policies(study):
    """A lowered load: burnt, stored in part, or refused, and each adds up."""
    drive = study.drives["motor1-gear1"]
    point = {"speed": 0.3, "force": -40.0}
    burnt = drive.operate(**point)
    stored = replace(drive, amplifier=iv.parts.Amplifier(regeneration="store", storage_efficiency=0.5)).operate(**point)
    refused = replace(drive, amplifier=iv.parts.Amplifier(regeneration="none")).operate(**point)
    assert burnt.power_in == 0.0
    assert burnt.losses["amplifier"] > 0
    assert stored.power_in == pytest.approx(-0.5 * burnt.losses["amplifier"])
    assert refused.limit == Limit.REGENERATION
    assert np.isnan(refused.efficiency)
    with pytest.raises(ValueError, match="storage_efficiency must be set"):
        iv.parts.Amplifier(regeneration="store")


def test_ratings_of_motor_and_gear_are_limits(study):
    drive = study.drives["motor2-gear4"]
    slow = replace(drive, motor=replace(drive.motor, max_speed=100.0))
    assert slow.operate(speed=0.5, force=1.0).limit == Limit.SPEED
    weak = replace(drive, gearhead=replace(drive.gearhead, continuous_torque=0.1))
    assert weak.operate(speed=0.1, force=40.0).limit == Limit.GEAR
    brief = replace(drive, gearhead=replace(drive.gearhead, intermittent_torque=0.1))
    fast = replace(drive, gearhead=replace(drive.gearhead, max_input_speed=100.0))
    for sign in (1.0, -1.0):
        point = brief.operate(speed=0.1, force=40.0 * sign)
        assert point.limit == Limit.GEAR_PEAK
        assert point.margin == pytest.approx(0.1 / (0.005 * (40.0 + sign * drive.guideway.friction_force())), rel=1e-12)
        turning = fast.operate(speed=0.5 * sign, force=1.0)
        assert turning.limit == Limit.GEAR_SPEED
        assert turning.margin == pytest.approx(100.0 / (0.5 / 0.005 * drive.gearhead.ratio), rel=1e-12)


def test_conventional_drive_by_hand(study):
    """One operating point of Motor 2 on its gear, worked through with the data sheet."""
    point = study.drives["motor2-gear4"].operate(speed=0.24, force=50.0)
    torque = (50.0 + 4.5) * 0.005 / 4 + 0.03 * 2.7 * 0.0263
    current = torque / 0.0256 + 2.7 * 0.053
    turning = 0.24 / 0.005 * 4
    voltage = current * 2.14 / 2.7 + 0.0256 * turning
    assert point.power_in == pytest.approx(current * voltage, rel=1e-12)
    assert point.losses["winding"] == pytest.approx(current**2 * 2.14 / 2.7, rel=1e-12)
    assert point.states["motor_current_A"] == pytest.approx(current, rel=1e-12)
    assert point.margin == pytest.approx((2.7 * (0.0263 / 0.0256 + 0.053)) / current, rel=1e-12)


def test_corner_and_verdict(comparison):
    result = comparison.results["motor2-gear4"]
    corner = result.corners["maximum force"]
    assert sum(corner.losses.values()) == pytest.approx(corner.power_in - corner.speed * corner.force, rel=1e-12)
    assert result.verdict.startswith(
        "covers 100 % of the required region; tightest limit: motor continuous torque (margin 1.01"
    )
    assert comparison.results["motor1-gear3"].verdict.startswith("covers 53.7 %")
    assert comparison.best.name == "cobotic-b"


@pytest.mark.parametrize("share", [0.15, 1.0, 1000.0])
def test_best_efficiency_without_other_losses_is_that_of_the_motor(share):
    """Closed form of the peak of a DC motor, which is searched over force and speed from far and near."""
    motor = iv.load_study("hand_controller").drives["motor1-gear1"].motor
    drive = iv.ConventionalDrive(
        motor=motor, gearhead=iv.parts.Gearhead(ratio=1.0, efficiency=1.0), pulley=iv.parts.Pulley(radius=0.01)
    )
    speed, force = 0.01 * motor.no_load_speed, motor.continuous_torque / 0.01
    found, residual = best_efficiency(drive, share * speed, share * force, (-1.0, 1.0), "drive")
    assert found == pytest.approx(motor.peak_efficiency, abs=2e-4)  # along the limit of voltage it is flat
    assert residual < 1e-12


@sampled("study", ["hand_controller", "knee_walking", "reach_and_hold", "ankle_walking"], every=2)
def test_no_point_of_a_grid_is_more_efficient_than_the_best(study):
    """Its best points lie where limits meet, where the finest of these grids comes no nearer than half a percent."""
    loaded = iv.load_study(study)
    plane = of_drives(loaded)
    signs = (1.0,) if plane.one_quadrant else (-1.0, 1.0)
    reach = np.concatenate([sign * np.geomspace(1e-5, 10.0, 240) for sign in signs])
    for name, drive in loaded.drives.items():
        grid = iv.steady_map(drive, reach * plane.speed, reach * plane.force).efficiency
        best, _ = best_efficiency(drive, plane.speed, plane.force, signs, name)
        assert -1e-6 <= best - np.nanmax(grid) < 0.02, name

"""Derivatives, Sobol's indices, builds within tolerances: against closed forms, against one another, against single runs."""

import contextlib
import math
from dataclasses import dataclass, replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import infinivar as iv
from infinivar import DutyCycle, InputError, duty_cycle, quantity, sensitivity
from infinivar.motion import Reaches, Sinusoid
from infinivar.parts import heat
from internals import DERIVATIVE_METHODS as METHODS
from internals import VERDICT_BAND as BAND
from internals import (
    Batch,
    Mapper,
    Spread,
    complex_step,
    designs,
    foremost,
    gradient,
    index_values,
    low_discrepancy,
    outcomes,
    percent,
    quantities_of,
    sobol,
    value_at,
    values_of,
    varied,
    with_values,
)
from internals import draw_samples as draw
from internals import sobol_indices as indices
from internals import verdict_band as band
from sampled import sampled

SHAKE = DutyCycle(motion=Sinusoid(distance=0.03, frequency=2.0), load_mass=0.8)

SHORT = DutyCycle(motion=Reaches(distance=0.03, time=0.3), load_mass=0.8)

PATHS = (
    "transmission.preload",
    "transmission.friction",
    "transmission.wheel_radius",
    "transmission.geometry.crown_radius",
    "transmission.geometry.wheel_material.youngs_modulus",
    "transmission.geometry.axle_bearing.bore",
    "motor.resistance",
    "gearhead.efficiency",
    "guideway.coefficient",
    "steering.bell_inertia",
    "cylinder_speed",
)


@pytest.fixture(scope="module")
def drive(study):
    return study.drives["cobotic"]


@pytest.fixture(scope="module")
def thousand(drive):
    """A thousand random designs about the shipped one."""
    random = np.random.default_rng(1)
    return values_of(drive, PATHS) * random.uniform(0.85, 1.12, (1000, len(PATHS)))


def measured_twin(drive):
    """The drive with its losses given as measured ones."""
    element = drive.transmission
    groups = element.groups(drive.cylinder_speed)
    names = ("creep_stiffness", "rolling_torque", "bearing_torque")
    return replace(
        drive,
        transmission=replace(element, geometry=None, **{name: float(getattr(groups, name)) for name in names}),
        steering=replace(drive.steering, patch_half_length=float(element.contact.patch.b)),
    )


@dataclass(frozen=True)
class Thing:
    a: float = quantity("1", "> 0", "", default=1.5)
    b: float = quantity("1", "> 0", "", default=0.7)


class TestDerivatives:
    @sampled("name", ["loss", "efficiency", "temperature"], slow=3)  # JAX compiles for some seconds
    def test_three_ways_agree_at_a_thousand_designs(self, drive, thousand, name):
        """Complex step and JAX are exact to rounding; differences with a step of 2e-3, thrice extrapolated, to 1e-8."""
        function = {
            "efficiency": lambda d: outcomes.efficiency(d, 0.3, 20.0),
            "loss": lambda d: outcomes.loss(d, 0.3, 20.0),
            "temperature": lambda d: outcomes.temperature(d, replace(SHAKE)),
        }[name]
        at = thousand if name != "temperature" else thousand[:2]
        found = {method: gradient(function, drive, PATHS, at=at, method=method) for method in METHODS}
        value, _ = found["complex"]
        assert np.isfinite(value).all()
        elasticity = {method: slope * at / value[:, None] for method, (_, slope) in found.items()}
        assert np.abs(elasticity["complex"]).max() > 0.1
        assert_allclose(elasticity["jax"], elasticity["complex"], rtol=1e-9, atol=1e-12)
        assert_allclose(elasticity["difference"], elasticity["complex"], atol=1e-8)

    @pytest.mark.full
    def test_coverage_by_jax_and_complex_step(self, drive, study, thousand):
        expected = replace(study.requirement, power=18.0)  # more than the drive can do
        found = [
            gradient(lambda d: outcomes.coverage(d, expected), drive, PATHS, at=thousand[:4], method=method)[1]
            for method in ("complex", "jax")
        ]
        assert np.abs(found[0]).max() > 0
        assert_allclose(*found, rtol=1e-7, atol=1e-12 * np.abs(found[0]).max())

    def test_one_design_or_many_is_the_same(self, drive, thousand):
        def function(d):
            return outcomes.loss(d, 0.3, 20.0)

        many = gradient(function, drive, PATHS, at=thousand[:3])
        for row in range(3):
            one = gradient(function, drive, PATHS, at=thousand[row])
            assert_allclose(one[0], many[0][row], rtol=1e-12)
            # Some have no influence, and derivatives that are rounding.
            assert_allclose(one[1], many[1][row], rtol=1e-9, atol=1e-12 * np.abs(many[1][row] * thousand[row]).max())

    @pytest.mark.parametrize("method", METHODS)
    def test_elasticities_of_closed_forms(self, method):
        """A motor alone: all power goes into the winding, (F r / (n K))^2 R."""
        alone = iv.ConventionalDrive(
            motor=iv.parts.Motor(
                voltage=24.0, resistance=2.0, torque_constant=0.03, no_load_current=0.0, continuous_torque=0.05
            ),
            gearhead=iv.parts.Gearhead(ratio=5.0, efficiency=1.0),
            pulley=iv.parts.Pulley(radius=0.01),
        )
        exponents = {
            "motor.resistance": 1.0, "motor.torque_constant": -2.0, "gearhead.ratio": -2.0, "pulley.radius": 2.0,
            "motor.voltage": 0.0,
        }  # fmt: skip
        value, slopes = gradient(lambda d: outcomes.loss(d, 0.2, 10.0), alone, list(exponents), method=method)
        assert_allclose(value, (10.0 * 0.01 / (5.0 * 0.03)) ** 2 * 2.0)
        elasticities = slopes * values_of(alone, list(exponents)) / value
        assert_allclose(elasticities, list(exponents.values()), atol=1e-9)

    @pytest.mark.parametrize(
        "formula",
        [
            lambda xp, a, b: a**3.3 * b ** (-1.0 / 3.0) + 2.0**a,
            lambda xp, a, b: xp.sqrt(a) * xp.exp(-b) / xp.log(a + 2.0) - xp.log1p(b) * xp.expm1(a),
            lambda xp, a, b: (
                xp.sin(a) + xp.cos(b) * xp.tan(a * b) + xp.atan(a / b) + xp.asin(0.3 * a) * xp.acos(0.4 * b)
            ),
            lambda xp, a, b: xp.maximum(a, b) * xp.minimum(a, b) + xp.abs(b - a) + xp.clip(a, 0.0, 1.2) * xp.sign(b),
            lambda xp, a, b: xp.where(a > b, a * a, b) + (1.0 - a) / (2.0 - b) - a * xp.where(b < 0, 1.0, b),
            lambda xp, a, b: xp.sum(xp.concat([a, b, a * b]), axis=0) + xp.mean(a, axis=0) + xp.max(a + b, axis=-1),
        ],
    )
    def test_functions_that_carry_derivatives(self, formula):
        def function(thing):
            from infinivar import array_namespace as namespace

            xp = namespace(thing)
            return formula(xp, *(xp.reshape(xp.asarray(v, dtype=xp.float64), (-1,)) for v in (thing.a, thing.b)))

        at = np.array([1.5, 0.7])
        found = []
        for place, name in enumerate("ab"):

            def moved(x, name=name):
                return function(with_values(Thing(), {name: x}))

            value, slope = complex_step.derivative(moved, at[place])
            step = 1e-5
            high, low = (moved(np.asarray(at[place] + way * step)) for way in (1, -1))
            assert_allclose(slope.ravel()[0], np.ravel((high - low) / (2 * step))[0], rtol=1e-8)
            assert_allclose(np.ravel(value)[0], np.ravel(moved(at[place]))[0])
            found.append(slope)

    def test_what_carries_no_derivative_says_so(self):
        with pytest.raises(NotImplementedError, match="sinh carries no derivative"):
            complex_step.NAMESPACE.sinh(complex_step.Stepped(1.0))

    def test_methods_that_there_are_not(self, drive):
        with pytest.raises(InputError, match="complex, jax, difference, got 'adjoint'"):
            gradient(lambda d: outcomes.loss(d, 0.3, 20.0), drive, PATHS, method="adjoint")


class TestOutcomes:
    def test_those_of_a_region_are_those_of_a_comparison(self, study, comparison):
        """On a fifth of the lines, but with limits between points, where the comparison counts whole cells."""
        for name, result in comparison.results.items():
            found = float(outcomes.coverage(result.drive, study.requirement))
            assert_allclose(found, result.coverage, atol=0.006)
            assert_allclose(outcomes.margin(result.drive, study.requirement), result.tightest.value, rtol=1e-3)
            assert name in study.drives

    def test_those_of_a_point_are_those_of_the_drive(self, drive):
        point = drive.operate(speed=0.3, force=20.0)
        assert_allclose(outcomes.efficiency(drive, 0.3, 20.0), point.efficiency)
        assert_allclose(outcomes.loss(drive, 0.3, 20.0), point.power_in - point.power_out)

    @pytest.mark.slow
    def test_those_of_a_cycle_are_those_of_the_duty_cycle(self):
        """The closed form holds the housing and the winding's resistance at their means."""
        knee = iv.load_study("studies/knee_walking.toml")
        for name, drive in knee.drives.items():
            whole = duty_cycle(drive, knee.duty["walking"], name=name)
            assert_allclose(outcomes.energy(drive, knee.duty["walking"]), whole.energy, rtol=1e-5)
            hottest = max(found.winding for found in whole.heat.values())
            warmer = outcomes.temperature(drive, knee.duty["walking"]) + knee.duty["walking"].ambient
            assert_allclose(warmer, hottest, atol=0.1)
            one = designs(drive, ["motor.resistance"], np.array([[drive.motor.resistance]]))
            energy, temperature, able = outcomes.worked(one, knee.duty["walking"], 0.08)[0]
            assert_allclose((energy, temperature), (whole.energy, hottest), rtol=1e-3)
            assert able == 1.0

    @pytest.mark.slow
    @pytest.mark.parametrize("kind", outcomes.KINDS)
    def test_more_friction_is_worse_by_every_outcome(self, kind):
        """A guideway that drags three times as much does nothing good: which way is better is not a matter of convention.

        Under the straight creep law: with a curved one the steering motor, the hottest, runs 0.2 mK cooler.
        """
        knee = iv.load_study("studies/knee_walking.toml")
        objective = outcomes.outcome(knee, kind)
        cobotic = knee.drives["cobotic"]
        straight = replace(cobotic, transmission=replace(cobotic.transmission, creep_law="linear"))
        for drive in (straight, knee.drives["geared"]):
            guide = drive.guideway
            rough = iv.parts.Guideway(friction=3.0 * guide.friction + 3.0, coefficient=3.0 * guide.coefficient)
            change = objective.better * float(objective.of(replace(drive, guideway=rough)) - objective.of(drive))
            assert change < 0 or (kind == "coverage" and change == 0)

    @pytest.mark.parametrize("period", [0.3, 3.0, 40.0])
    def test_settled_temperature_in_closed_form(self, drive, period):
        """Half the cycle at twice the continuous current, half without: the ripple is largest for long cycles."""
        current = np.where(np.arange(2000) < 1000, 1.2 * drive.motor.continuous_current, 0.0)
        friction = np.full(2000, 0.3)
        whole = heat.heat(drive.motor, current, friction, period)
        highest, mean = heat.settled(drive.motor, current, friction, period)
        rise = whole.winding - whole.ambient
        assert_allclose(mean[0], whole.mean_winding, atol=0.02 * rise)
        assert_allclose(highest[0], whole.winding, atol=0.03 * rise)

    def test_a_motor_that_never_settles(self, drive):
        highest, mean = heat.settled(drive.motor, np.full(10, 20.0), np.zeros(10), 1.0)
        assert highest[0] == mean[0] == math.inf


class TestSobol:
    def test_indices_of_the_ishigami_function(self):
        """sin x1 + 7 sin^2 x2 + 0.1 x3^4 sin x1 on (-pi, pi): closed forms of its variances."""
        count, a, b = 2**13, 7.0, 0.1
        first, second = (math.pi * (2.0 * part - 1.0) for part in np.split(low_discrepancy(count, 6), 2, axis=1))

        def ishigami(x):
            return np.sin(x[..., 0]) + a * np.sin(x[..., 1]) ** 2 + b * x[..., 2] ** 4 * np.sin(x[..., 0])

        mixed = np.stack([np.where(np.arange(3) == place, second, first) for place in range(3)])
        own, total = sobol(ishigami(first), ishigami(second), ishigami(mixed))
        v1, v2, v13 = 0.5 * (1 + b * math.pi**4 / 5) ** 2, a**2 / 8, b**2 * math.pi**8 * (1 / 18 - 1 / 50)
        whole = v1 + v2 + v13
        assert_allclose(own, [v1 / whole, v2 / whole, 0.0], atol=5e-3)
        assert_allclose(total, [(v1 + v13) / whole, v2 / whole, v13 / whole], atol=5e-3)

    @pytest.mark.parametrize(("better", "own"), [(1, [5 / 13, 4 / 13]), (-1, [5 / 7, 1 / 7])])
    def test_what_cannot_be_done_counts_as_the_worst(self, drive, better, own):
        """y^2 while x is below a half, else nothing, x and y even on (0, 1). With the worst there, 0 where more is better and
        1 where less is: means and variances over x and y by hand; what x and y do not do alone they do together. The
        jump leaves 1e-2 with 4096 samples."""

        def objective(design):
            x, y = design.motor.resistance - 1.0, design.motor.inductance / 1e-3 - 1.0
            return np.where(x < 0.5, y**2, np.nan)[..., 0]

        spreads = [
            Spread(owner="cobotic", path=path, unit="", value=low, low=low, high=2.0 * low, deviation=None,
                   kind="stated", where="test")
            for path, low in (("motor.resistance", 1.0), ("motor.inductance", 1e-3))
        ]  # fmt: skip
        outcome = outcomes.Outcome(name="y", unit="1", words="y", better=better, of=objective)
        batch = Batch(objective, drive, [spread.path for spread in spreads])
        first, total, lost = indices(outcome, index_values(batch, spreads, 2**12))
        assert_allclose(first, own, atol=0.015)
        assert_allclose(total, [1.0 - own[1], 1.0 - own[0]], atol=0.015)
        assert lost == pytest.approx(0.5, abs=1e-3)

    def test_what_does_not_vary_has_none(self):
        own, total = sobol(np.ones(64), np.ones(64), np.ones((2, 64)))
        assert np.isnan(own).all()
        assert np.isnan(total).all()


class TestSensitivity:
    def test_ranks_by_swing_and_says_where_ranges_come_from(self, study):
        stated = Spread(
            owner="cobotic", path="motor.resistance", unit="ohm", value=2.14, low=1.07, high=4.28, deviation=None,
            kind="stated", where="test",
        )  # fmt: skip
        uncertainty = replace(study.uncertainty, spreads={"cobotic": (stated,)})
        found = sensitivity(replace(study, uncertainty=uncertainty), "cobotic", "loss", samples=64)
        swings = [row.swing for row in found.influences]
        assert swings == sorted(swings, reverse=True)
        (row,) = [row for row in found.influences if row.stated]
        assert (row.low, row.high) == (1.07, 4.28)
        drive = study.drives["cobotic"]
        at = [float(outcomes.loss(with_values(drive, {"motor.resistance": r}), 0.24, 50.0)) for r in (1.07, 4.28)]
        assert_allclose((row.at_low, row.at_high), at, rtol=1e-12)
        assert any("without a range in the study" in said for said in found.remarks)
        indices = [row.total for row in found.influences if row.total is not None]
        assert len(indices) == 8
        assert 0.9 < sum(indices) < 1.2

    def test_no_range_leaves_what_is_permitted(self, study):
        found = sensitivity(study, "cobotic", "efficiency", samples=0)
        for row in found.influences:
            assert row.high <= 1.0 or row.path != "amplifier.efficiency"
            assert row.low < row.high

    def test_what_sobols_indices_leave_out_is_said(self, study):
        found = sensitivity(study, "cobotic", "efficiency", samples=0)
        assert not any("Sobol" in said for said in found.remarks)
        correlated = {
            owner: replace(study, uncertainty=replace(study.uncertainty, correlations={(owner, "one", "other"): 0.5}))
            for owner in ("cobotic", "motor2-gear4")
        }
        some = replace(found, impossible=0.125, engine="jax", study=correlated["cobotic"])
        assert some.remarks[-3:] == (
            "The samples of Sobol's indices were computed by compiled code (JAX).",
            "12 % of the samples are infeasible; Sobol's indices count them as the worst feasible sample.",
            "Sobol's indices treat the parameters as independent and ignore the study's correlations.",
        )
        assert not any("Sobol" in said for said in replace(found, study=correlated["motor2-gear4"]).remarks)

    def test_what_the_paper_recommends(self, study):
        """Each of section VII's recommendations helps the loss at a corner, or has no effect in steady operation."""
        found = {row.words: row for row in sensitivity(study, "cobotic", "loss", samples=0).conclusions}
        assert len(found) == 7
        for words in ("higher friction, less preload", "less hysteresis", "smaller axle bearings"):
            assert found[words].verdict == "helps"
            assert found[words].elasticity < 0
        for words in ("smaller bell bearing", "less steering inertia", "lighter link"):
            assert found[words].verdict == "no effect"
        assert sensitivity(study, "motor2-gear4", "loss", samples=0).conclusions == ()

    @pytest.mark.slow
    @pytest.mark.parametrize("kind", ["loss", "margin"])
    def test_a_duty_cycle_that_a_result_does_not_use_is_refused(self, study, kind):
        with pytest.raises(iv.InputError, match=f"duty applies to energy and temperature; {kind} is no result"):
            iv.sensitivity(study, "cobotic", kind, duty="shake")

    @pytest.mark.slow
    def test_what_nothing_changes_is_said(self, study, tmp_path):
        small = replace(study.requirement, force=5.0, speed=0.1, power=0.4)
        found = sensitivity(replace(study, requirement=small), "cobotic", "coverage", samples=64)
        assert found.value == pytest.approx(1.0)
        assert found.influences == ()
        assert found.remarks == (found.answer,) == ("No parameter affects the outcome over its range.",)
        page, *_ = iv.save(replace(found, beyond="wheel slip"), tmp_path)
        text = page.read_text("utf-8")
        assert f'<p class="headline">{found.answer}</p>' in text
        assert text.count(found.answer) == 1
        assert "The drive exceeds its limits: wheel slip." in text

    def test_a_recommendation_is_a_change_of_design(self, study):
        """Followed by a thousandth: friction up with the preload down."""
        drive = study.drives["cobotic"]
        row = sensitivity(study, "cobotic", "loss", samples=0).conclusions[0]
        element = drive.transmission
        moved = replace(
            drive, transmission=replace(element, friction=1.001 * element.friction, preload=element.preload / 1.001)
        )
        after, before = (float(outcomes.loss(one, 0.24, 50.0)) for one in (moved, drive))
        assert_allclose(1000.0 * (after / before - 1.0), row.elasticity, rtol=2e-3)

    @pytest.mark.parametrize("method", ["complex", "difference", pytest.param("jax", marks=pytest.mark.full)])
    def test_measured_losses_follow_the_preload(self, drive, method):
        """A drive with the losses that follow from its geometry answers a change of preload as the geometry does."""
        measured, at = measured_twin(drive), np.array([[600.0], [650.0], [700.0]])
        (value, slope), (same, alike) = (
            gradient(lambda d: outcomes.loss(d, 0.24, 50.0), one, ["transmission.preload"], at=at, method=method)
            for one in (drive, measured)
        )
        # All powers are exact: Hertz's, and bearings with a constant coefficient of friction.
        assert_allclose(same, value, rtol=1e-12)
        assert_allclose(alike, slope, rtol=1e-8)
        for part in ("patch", "bell"):
            less, more, less_too, more_too = (
                one.pressed(preload).steering.friction_torques(one.pressed(preload).transmission)[part]
                for one in (drive, measured)
                for preload in (600.0, 700.0)
            )
            assert_allclose(more_too / less_too, more / less, rtol=1e-12)

    def test_every_field_with_a_value_can_be_moved(self, drive):
        fields = quantities_of(drive)
        assert "transmission.geometry.axle_bearing.bore" in fields
        assert "transmission.creep_stiffness" not in fields  # not given
        same = with_values(drive, dict(zip(fields, values_of(drive, list(fields)).tolist(), strict=True)))
        assert same == drive

    @sampled(("variant", "every"), [("conventional", 4), ("conventional", 1), ("shipped", 3), ("detailed", 1)], slow=4)
    def test_many_designs_at_once_are_the_designs_one_by_one(self, study, variant, every):
        """By every field that a drive has, or every fourth, in all branches that a study can choose."""
        drive = study.drives["motor2-gear4" if variant == "conventional" else "cobotic"]
        if variant == "detailed":
            geometry = drive.transmission.geometry
            bearing = replace(geometry.axle_bearing, friction_model="skf")
            detailed = replace(
                geometry, bearing_span=0.02, fast_friction_ratio=0.6, friction_decay_speed=2.0, axle_bearing=bearing
            )
            drive = replace(
                drive,
                transmission=replace(drive.transmission, steering_range=1.2, creep_law="polach", geometry=detailed),
                gearhead=replace(drive.gearhead, rated_torque=0.03, continuous_torque=5.0, inertia=1e-7),
            )
        functions = (
            lambda d: outcomes.loss(d, 0.2, 20.0),
            lambda d: outcomes.margin(d, study.requirement),
            lambda d: outcomes.energy(d, SHORT),
        )
        unchanged = [float(function(drive)) for function in functions]
        for path in list(quantities_of(drive))[::every]:
            value = value_at(drive, path)
            if path.startswith("control.") or value == 0:
                continue
            if path.endswith("fast_friction_ratio") and variant == "shipped":
                continue  # it does not apply without a decay speed
            less = 0.98 * value
            for function, nominal in zip(functions, unchanged, strict=True):
                found = np.broadcast_to(function(designs(drive, [path], np.array([[less], [value]]))), (2,))
                assert_allclose(found, [float(function(varied(drive, {path: less}))), nominal], rtol=1e-9)


def spread(path, value, **options):
    made = {"low": value * 0.9, "high": value * 1.1, "deviation": None, **options}
    return Spread(owner="x", path=path, unit="1", value=value, kind="assumed", where="", **made)


class TestBuilds:
    def test_draws_have_the_distribution_and_the_correlation(self):
        spreads = [
            spread("a", 1.0),
            spread("b", 5.0, low=-math.inf, high=math.inf, deviation=0.5),
            spread("c", 2.0, low=0.0, high=math.inf, deviation=0.1),
        ]
        correlation = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, -0.7], [0.0, -0.7, 1.0]])
        drawn = draw(spreads, correlation, 2**13)
        assert drawn[:, 0].min() >= 0.9
        assert drawn[:, 0].max() <= 1.1
        assert_allclose(drawn.mean(axis=0), [1.0, 5.0, 2.0], rtol=1e-3)
        assert_allclose(drawn.std(axis=0), [0.2 / math.sqrt(12), 0.5, 0.1], rtol=5e-3)
        assert_allclose(np.corrcoef(drawn.T), correlation, atol=5e-3)

    @pytest.mark.slow
    def test_maps_of_builds_are_those_of_single_drives(self, drive):
        paths = ["transmission.preload", "motor.resistance", "gearhead.efficiency"]
        at = values_of(drive, paths) * np.random.default_rng(2).uniform(0.8, 1.1, (5, 3))
        speed, force = np.linspace(0.02, 1.4, 7), np.linspace(1.0, 75.0, 9)
        single = [
            iv.steady_map(with_values(drive, dict(zip(paths, row.tolist(), strict=True))), speed, force) for row in at
        ]
        within = np.mean([one.limit == 0 for one in single], axis=0)
        known = np.sum([np.isfinite(one.efficiency) for one in single], axis=0)
        efficiency = np.nansum([one.efficiency for one in single], axis=0) / np.where(known > 0, known, np.nan)
        for method in ("numpy", "jax"):
            found = Mapper(drive, paths, speed, force, method=method)(at)
            assert_allclose(found.within, within)
            assert_allclose(found.efficiency, efficiency, rtol=1e-12)
            slip = np.mean([one.limit == iv.Limit.SLIP for one in single], axis=0)
            assert_allclose(found.limits[iv.Limit.SLIP], slip)
        assert 0 < within.mean() < 1

    @pytest.mark.slow
    def test_share_of_builds_that_cover_in_closed_form(self, tmp_path):
        """The continuous torque of a gearless drive alone is uncertain, and must be at least force times radius."""
        (tmp_path / "study.toml").write_text(
            """
            [requirement]
            force = "20 N"
            speed = "0.1 m/s"
            [drives.direct]
            type = "conventional"
            [drives.direct.motor]
            voltage = "48 V"
            resistance = "1 ohm"
            torque_constant = "0.05 N m/A"
            no_load_current = "0 A"
            continuous_torque = "0.21 N m"
            [drives.direct.gearhead]
            ratio = 1
            efficiency = 1
            [drives.direct.pulley]
            radius = "10 mm"
            [uncertainty.direct.motor]
            continuous_torque = "0.03 N m"
            """,
            "utf-8",
        )
        found = iv.compare(iv.load_study(tmp_path / "study.toml"))
        builds = found.builds["direct"]
        # Torques from 0.18 to 0.24 N m are as likely, and 0.2 is needed.
        assert_allclose(builds.covering, 2.0 / 3.0, atol=2e-3)
        assert "covers the requirement in 66." in builds.verdict
        low, high = (0.18 + 0.06 * share for share in BAND)
        assert_allclose(band(builds.margin)["low"], low / 0.2, rtol=1e-3)
        assert_allclose(band(builds.margin)["high"], high / 0.2, rtol=1e-3)
        assert found.to_dict()["builds"]["direct"]["covering"] == builds.covering
        again = iv.compare(iv.load_study(tmp_path / "study.toml"))
        assert np.array_equal(again.builds["direct"].values, builds.values)

    def test_shares_in_words(self):
        assert [percent(share, 1024) for share in (1.0, 1023 / 1024, 0.934, 1 / 1024, 0.0)] == [
            "100 %",
            "99.9 %",
            "93.4 %",
            "0.1 %",
            "0 %",
        ]
        assert percent(63 / 64, 64) == "98 %"


def test_builds_whose_winding_never_settles_count_as_the_hottest():
    """Left out, half of the builds would have told a range of the other half."""
    found = band(np.array([300.0, 320.0, math.inf, math.inf, math.nan]))
    assert found == {"low": 300.0, "median": 320.0, "high": math.inf}
    assert band(np.array([math.nan])) == {"low": None, "median": None, "high": None}


@pytest.mark.parametrize("name", ["cobotic", "motor2-gear4"])
def test_no_value_left_out_of_the_foremost_matters_twice_as_much_as_one_of_them(study, name):
    """Against differences of the mean loss and of the tightest margin in the whole required region."""
    drive, (speed, force, weight) = study.drives[name], study.requirement.sample(25)

    def both(made):
        point = made.operate(speed=speed, force=force)
        margins = [np.max(one) for one in point.utilisation.values()]
        return np.array([np.sum((point.power_in - point.power_out) * weight), 1.0 / np.max(margins)])

    found = foremost(study, name)
    effects = dict.fromkeys(found, 0.0)
    for path in quantities_of(drive):
        value = value_at(drive, path)
        if value and path != "transmission.cylinder_tube.bore":
            with contextlib.suppress(iv.ParameterError):  # at an end of what is permitted
                ends = [both(varied(drive, {path: value * (1.0 + step)})) for step in (-1e-3, 1e-3)]
                effects[path] = np.max(np.abs((ends[1] - ends[0]) / 2e-3 / both(drive)))
    listed = [effects[path] for path in found[:8] if effects[path]]
    others = [one for path, one in effects.items() if path not in found[:8]]
    assert len(listed) >= 5
    assert max(others) < 2.0 * min(listed)


def test_values_are_ranked_for_motions_and_refused_for_machines():
    ankle = iv.load_study("ankle_walking")
    assert ankle.requirement is None
    assert {"gearhead.ratio", "screw.lead"} <= set(foremost(ankle, "geared")[:8])
    cart = iv.load_study("planar_cart")
    with pytest.raises(InputError, match="machine"):
        foremost(cart, next(iter(cart.drives)))

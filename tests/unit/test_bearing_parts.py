"""Bearings: what is refused, what a type cannot carry, and the catalogue's rows."""

import dataclasses
import math
import typing

import numpy as np
import pytest

from infinivar import units
from infinivar.parts import Bearing
from internals import COEFFICIENTS, BearingPair, BearingType, Lubrication, catalogue
from internals import BearingSeries as Series

SIZE = {"bore": 0.008, "outside_diameter": 0.022, "dynamic_rating": 3450.0, "static_rating": 1370.0}
ROWS = catalogue.entries("bearings")


def read(key):
    """A bearing of the catalogue, its values as a study file would read them."""
    fields = {field.name: field for field in dataclasses.fields(Bearing)}
    values = {name: value for name, value in ROWS[key].items() if name not in ("kind", "where")}
    return Bearing(
        **{
            name: units.parse(value, fields[name].metadata["unit"]) if "unit" in fields[name].metadata else value
            for name, value in values.items()
        }
    )


@pytest.mark.parametrize("key", ROWS)
def test_catalogue_rows_are_sound(key):
    bearing, row = read(key), ROWS[key]
    assert bearing.name == key
    assert row["kind"] == "catalogue"
    assert {"skf2018", "skf2006"} & {*row["where"].replace(",", " ").split()}
    # Series of the designation: 60x and 62x by two digits, 618xx by three, 60xx by two; SKF calls a 688 a 628/8.
    assert bearing.series == ("628" if key == "688" else key[:3] if key.startswith("61") else key[:2])
    # Of thin bearings of large bore the static rating is the larger one.
    assert (
        bearing.static_rating < (1.0 if key < "61807" or not key.startswith("618") else 1.01) * bearing.dynamic_rating
    )
    # Load ratings follow from the size of the balls, and so from the room between the rings, within a factor.
    room = (bearing.outside_diameter - bearing.bore) * (bearing.outside_diameter + bearing.bore)
    assert 3.9e6 < bearing.dynamic_rating / room < 12e6
    # At a tenth of the rating the full model comes near the simple rule; a wrong unit would be far off.
    load = 0.1 * bearing.dynamic_rating
    assert 0.5 < float(bearing.moment(load, 0.0, 20.0).total) / (0.5 * 0.0015 * load * bearing.bore) < 3


def test_catalogue_has_the_608_as_the_tests_of_numbers_do():
    assert read("608") == Bearing(**SIZE, name="608", series="60", calculation_factor=12, width=0.007, mass=0.012)


def test_unknown_part_names_the_nearest():
    with pytest.raises(Exception, match="did you mean '6000'"):
        catalogue.entry("bearings", "60000")


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"bore": 0.0}, "bore must be > 0 m, got 0.0"),
        ({"viscosity": -1e-6}, r"viscosity must be > 0 m\^2/s"),
        ({"outside_diameter": 0.008}, r"outside_diameter must be > bore \(0.008 m\), got 0.008"),
        ({"type": "magnetic"}, "type must be one of deep_groove, angular_contact"),
        ({"series": "99"}, "series must be one of other, 2, 3"),
        (
            {"series": "other"},
            "series must be the series of the deep groove bearing, which the skf model requires, got other",
        ),
        ({"friction_model": "none"}, "friction_model must be one of skf, coefficient"),
        ({"lubrication": "water"}, "lubrication must be one of grease, oil_air, oil_bath"),
        ({"type": "needle"}, "friction_model must be coefficient for a needle bearing .*no confirmed constants"),
        ({"type": "cylindrical"}, "friction_model must be coefficient for a cylindrical bearing"),
        (
            {"lubrication": "oil_bath", "drag_factor": 1e-4},
            "oil_level must be set if, and only if, lubrication = oil_bath",
        ),
        (
            {"lubrication": "oil_bath", "oil_level": 1e-3},
            "drag_factor must be set if, and only if, lubrication = oil_bath",
        ),
        ({"oil_level": 1e-3}, "oil_level must be set if, and only if, lubrication = oil_bath"),
    ],
)
def test_what_is_refused(changes, message):
    with pytest.raises(ValueError, match=message):
        Bearing(**{**SIZE, "series": "60", **changes})


def test_pair_refuses_bearings_without_radial_load():
    with pytest.raises(ValueError, match="bearing must be a type that carries radial load, got thrust_ball"):
        BearingPair(bearing=Bearing(**SIZE, type="thrust_ball"))
    with pytest.raises(ValueError, match="span must be > 0 m"):
        BearingPair(bearing=Bearing(**SIZE, series="60"), span=0.0)


def test_every_type_has_a_coefficient():
    assert set(COEFFICIENTS) == set(typing.get_args(BearingType))
    for kind in COEFFICIENTS:
        bearing = Bearing(**SIZE, type=kind, friction_model="coefficient")
        load = (0.0, 100.0) if kind == "thrust_ball" else (100.0, 0.0)
        assert float(bearing.moment(*load, 5.0).total) == pytest.approx(0.5 * COEFFICIENTS[kind] * 100.0 * 0.008)


@pytest.mark.parametrize("lubrication", typing.get_args(Lubrication))
def test_every_series_and_lubrication_has_constants(lubrication):
    bath = {"oil_level": 0.004, "drag_factor": 1e-4} if lubrication == "oil_bath" else {}
    for series in typing.get_args(Series)[1:]:
        moment = Bearing(**SIZE, series=series, lubrication=lubrication, **bath).moment(200.0, 20.0, 30.0)
        assert float(moment.rolling) > 0
        assert float(moment.sliding) > 0
        assert (float(moment.drag) > 0) == (lubrication == "oil_bath")


@pytest.mark.parametrize("kind", ["thrust_ball", "cylindrical", "needle"])
def test_loads_that_a_type_cannot_carry(kind):
    bearing = Bearing(**SIZE, type=kind, friction_model="coefficient")
    right, wrong = ((0.0, 100.0), (1e-6, 100.0)) if kind == "thrust_ball" else ((100.0, 0.0), (100.0, 1e-6))
    exponent = 3 if kind == "thrust_ball" else 10 / 3
    assert float(bearing.life(*right)) == pytest.approx(1e6 * 34.5**exponent)
    assert float(bearing.static_safety(*right)) == pytest.approx(13.7)
    assert bearing.life(*wrong) == 0
    assert bearing.static_safety(*wrong) == 0
    assert float(bearing.moment(*wrong, 1.0).total) == pytest.approx(float(bearing.moment(*right, 1.0).total))


def test_roller_pair_cannot_hold_a_lateral_force():
    pair = BearingPair(bearing=Bearing(**SIZE, type="needle", friction_model="coefficient"), span=0.02)
    assert pair.life(500.0, 1.0, 0.03) == 0
    assert pair.static_safety(500.0, 1.0, 0.03) == 0
    assert pair.life(500.0, 0.0, 0.03) > 0


def test_loads_of_a_pair():
    bearing = Bearing(**SIZE, series="60")
    pair = BearingPair(bearing=bearing, span=0.02)
    # 100 N at 30 mm tilt the axle with 3 N m: 150 N more on one bearing, 150 N less on the other.
    assert np.allclose(pair.loads(500.0, 100.0, 0.03), [(400.0, 100.0), (100.0, 0.0)])
    assert np.allclose(pair.loads(500.0, -100.0, 0.03), [(100.0, 0.0), (400.0, 100.0)])
    # 200 N lift the second bearing off: it carries 50 N the other way.
    assert np.allclose(pair.loads(500.0, 200.0, 0.03), [(550.0, 200.0), (50.0, 0.0)])
    level = BearingPair(bearing=bearing)
    assert np.allclose(level.loads(500.0, 200.0, 0.03), [(250.0, 200.0), (250.0, 0.0)])
    moment = pair.moment(500.0, 100.0, 0.03, 20.0)
    assert float(moment.total) == pytest.approx(float(moment.first.total + moment.second.total))
    assert float(pair.starting_moment(500.0, 100.0, 0.03)) == float(pair.moment(500.0, 100.0, 0.03, 0.0).total)


def test_angular_contact_bearing_by_its_angle():
    """iso2007 and iso2006 at 40 and 25 deg, and halfway between 35 and 40 deg."""
    for angle, x, y, y0 in ((40, 0.35, 0.57, 0.26), (25, 0.41, 0.87, 0.38), (37.5, 0.36, 0.615, 0.275)):
        bearing = Bearing(**SIZE, type="angular_contact", contact_angle=math.radians(angle))
        load = x * 100 + y * 900
        assert float(bearing.life(100.0, 900.0)) == pytest.approx(1e6 * (3450 / load) ** 3)
        assert float(bearing.static_safety(100.0, 900.0)) == pytest.approx(1370 / (50 + y0 * 900))


def test_shapes_broadcast():
    bearing = Bearing(**SIZE, series="60", seal_torque=0.001)
    moment = bearing.moment(np.ones((4, 1)), 2.0, np.arange(3.0))
    assert {getattr(moment, name).shape for name in ("rolling", "sliding", "seal", "drag", "total")} == {(4, 3)}
    assert bearing.life(np.ones(5), 1.0).shape == (5,)
    # A series of bearings in one array of sizes is one bearing to the formulas.
    many = Bearing(**{**SIZE, "bore": np.array([0.006, 0.008])}, series="60")
    assert many.moment(100.0, 0.0, 10.0).total.shape == (2,)


def test_a_vanishing_axial_load_is_none():
    """Denormal loads would underflow in the powers of the model."""
    bearing = read("608")
    for axial in (5e-324, 1e-200):
        assert bearing.moment(100.0, axial, 10.0).total == bearing.moment(100.0, 0.0, 10.0).total
    assert bearing.moment(100.0, 1e-6, 10.0).total > bearing.moment(100.0, 0.0, 10.0).total

"""Springs and tubes of the catalogue: by name in a study, as limits, and in the mass of a drive."""

import tomllib
from dataclasses import replace

import numpy as np
import pytest

import infinivar as iv
from infinivar import Limit
from infinivar.parts import Spring, StockSpring, StockTube, Structure
from internals import Service
from made import loaded

KNEE, ANKLE = loaded("knee_walking"), loaded("ankle_walking")
COBOTIC, GEARED = KNEE.drives["cobotic"], KNEE.drives["geared"]
SERVICE = Service(0.3, 75.0)


def pressing(preload=2200.0, wheels=1, **structure):
    """The body that presses the wheels on the cylinder."""
    element = replace(COBOTIC.transmission, preload=preload, wheels=wheels)
    drive = replace(COBOTIC, transmission=element, structure=Structure(**structure))
    return next(body for body in drive.bodies(SERVICE) if body.name == "preload spring")


def sprung(**fields):
    """A study whose geared drive has a series spring."""
    raw = tomllib.loads(KNEE.to_toml())
    raw["drives"]["geared"]["output"] = {"series_spring": fields}
    return iv.Study.from_dict(raw, name="sprung")


def test_every_spring_can_be_chosen_and_weighed():
    assert len(iv.springs()) == 52
    for spring in iv.springs().values():
        needed = (spring.stiffness, spring.permissible_force, spring.wire_diameter, spring.outer_diameter)
        assert None not in (*needed, spring.free_length, spring.permissible_length), spring.name
        assert 0.0 < spring.weight < 2.0, spring.name
        shorter = spring.permissible_length < spring.free_length
        assert shorter == (spring.made_for == "compression"), spring.name
    assert len({spring.name for spring in iv.springs().values()}) == 52


def test_a_study_names_a_spring_of_the_catalogue():
    study = sprung(part="z-161i")
    spring = study.drives["geared"].output.series_spring
    assert (spring.stiffness, spring.permissible_force, spring.mass) == pytest.approx((8316.0, 324.5, 0.04001))
    kinds = {row.field: (row.kind, row.where) for row in study.provenance if row.owner == "geared"}
    expected = ("catalogue", "gutekunst2026, through a public transcription")
    assert kinds["output.series_spring.stiffness"] == expected
    again = iv.Study.from_dict(tomllib.loads(study.to_toml()), name="again")
    assert again.drives["geared"].output == study.drives["geared"].output
    own = sprung(part="z-161i", stiffness="5 N/mm", hysteresis="2 N").drives["geared"].output.series_spring
    assert (own.stiffness, own.hysteresis, own.permissible_force) == pytest.approx((5000.0, 2.0, 324.5))


@pytest.mark.parametrize(
    ("fields", "words"),
    [
        ({"part": "z-161j"}, r"series_spring\.part = 'z-161j' is not in the catalogue of springs.*did you mean"),
        (
            {"part": "z-161i", "outer_diameter": "5 mm"},
            "outer_diameter must be > 5 mm, twice wire_diameter, got 5 mm",
        ),
        (
            {"part": "d-077", "initial_tension": "1 N"},
            'initial_tension is of an extension spring: set made_for = "exte',
        ),
        ({"part": "d-077", "permissible_force": "0 N"}, r'permissible_force = "0 N" must be > 0 N, such as 50 N'),
        ({"part": "z-161i", "body_length": "2 mm"}, r"body_length must be > 2\.5 mm, wire_diameter, got 2 mm"),
        ({"part": "d-077", "made_for": "torsion"}, "made_for.*torsion.*compression"),
    ],
)
def test_faults_of_springs_are_named(fields, words):
    with pytest.raises(iv.InputError, match=words):
        sprung(**fields)


def test_a_spring_of_the_joint_is_none_of_the_catalogue():
    raw = tomllib.loads(ANKLE.to_toml())
    raw["drives"]["geared"]["output"]["series_torsion_spring"] = {"part": "d-077"}
    with pytest.raises(iv.InputError, match=r'series_torsion_spring\.part = "d-077" must be removed'):
        iv.Study.from_dict(raw, name="x")


@pytest.mark.parametrize("place", ["series_spring", "parallel_spring"])
def test_the_permissible_force_is_a_limit_on_both_sides_of_rest(place):
    """Of a series spring the force of the load, of a parallel one its own, over what is permitted."""
    spring = Spring(stiffness=2000.0, permissible_force=50.0, preload=3.0)
    drive = replace(GEARED, output=iv.Output(**{place: spring}))
    cycle = KNEE.duty["walking"]
    found = iv.duty_cycle(drive, cycle)
    force = found.columns["force_N"]
    if place == "parallel_spring":
        force = 3.0 + 2000.0 * found.columns["position_m"]
    key = (Limit.SPRING, place.replace("_", " "))
    assert found.demands[key] == pytest.approx(np.max(np.abs(force)) / 50.0, rel=1e-9)
    assert not found.feasible
    free = iv.duty_cycle(replace(drive, output=iv.Output(**{place: replace(spring, permissible_force=None)})), cycle)
    assert free.demands.get(key, 0.0) == 0.0
    assert free.energy == found.energy


def test_a_simulated_spring_has_the_same_limit():
    """The event is at the largest force of the spring, k times its deflection."""
    drive = loaded("hand_controller").drives["motor2-gear4"]
    spring = Spring(stiffness=2500.0, permissible_force=5.0)
    push = iv.Scenario(duration=0.3, load_mass=1.0, force=iv.motion.SinusoidalForce(size=8.0, frequency=2.0))
    found = iv.simulate(replace(drive, output=iv.Output(series_spring=spring)), push)
    event = next(one for one in found.events if one.limit == Limit.SPRING)
    largest = 2500.0 * np.abs(found.columns["series_spring_deflection_m"]).max()
    assert event.what == "series spring"
    assert event.worst == pytest.approx(largest / 5.0, rel=3e-6)
    assert event.worst > 1.0


def test_the_table_and_the_permissible_force_limit_a_progressive_spring_alike():
    table = {"shape": "progressive", "deflections": (-0.01, 0.0, 0.02), "forces": (-10.0, 0.0, 30.0)}
    spring = Spring(**table, permissible_force=20.0)
    x = np.array([-0.02, -0.01, 0.0, 0.005, 0.02])
    own = np.abs(spring.force(x)) / 20.0
    assert spring.demand(x) == pytest.approx(np.maximum(own, Spring(**table).demand(x)))


def test_springs_from_stock_weigh_what_is_stated_and_others_the_wire_that_stores_their_energy():
    stock = replace(GEARED, output=iv.Output(series_spring=sprung(part="z-161i").drives["geared"].output.series_spring))
    body = next(one for one in stock.bodies(SERVICE) if one.name == "springs")
    assert (body.mass, body.kind, body.basis) == (pytest.approx(0.04001), "catalogue", iv.springs()["z-161i"].name)
    both = replace(stock.output, parallel_spring=Spring(stiffness=1000.0))
    service = SERVICE._replace(energies={"parallel spring": 0.5})
    body = next(one for one in replace(stock, output=both).bodies(service) if one.name == "springs")
    alone = replace(stock, output=replace(both, series_spring=None))
    wire = next(one for one in alone.bodies(service) if one.name == "springs")
    assert body.mass == pytest.approx(wire.mass + 0.04001)
    assert body.kind == wire.kind == "derived"
    assert body.basis.endswith(" and wire for the energy stored")


def test_the_preload_spring_from_stock_is_the_lightest_that_carries_the_preload():
    for preload in (10.0, 100.0, 500.0, 2200.0):
        found = pressing(preload, stock_springs=True)
        carrying = [
            one
            for one in iv.springs().values()
            if one.permissible_force >= preload and (preload - (one.initial_tension or 0.0)) / one.stiffness >= 1e-3
        ]
        chosen = min(carrying, key=lambda one: one.weight)
        assert (found.mass, found.kind, found.basis) == (pytest.approx(chosen.weight), "catalogue", chosen.name)
        assert found.mass > pressing(preload).mass  # wire made to measure, without ends
    assert pressing(500.0, 3, stock_springs=True).mass == pytest.approx(3 * pressing(500.0, stock_springs=True).mass)
    soft = pressing(30.0, stock_springs=True, spring_deflection=0.03)
    assert soft.mass > pressing(30.0, stock_springs=True).mass
    none = pressing(3000.0, stock_springs=True)
    assert (none.mass, none.basis) == (None, "no spring of the catalogue carries 3000 N and gives way by 1 mm")


def test_many_designs_press_as_each_alone():
    preloads = np.array([10.0, 500.0, 2200.0, 5000.0])
    many = pressing(preloads, stock_springs=True).mass
    alone = [pressing(float(one), stock_springs=True).mass for one in preloads]
    assert [None if np.isnan(one) else one for one in many] == pytest.approx(alone)


def test_a_stated_preload_spring():
    spring = iv.springs()["z-381i"]
    assert pressing(preload_spring=spring).mass == pytest.approx(1.533958)
    weak = pressing(preload_spring=iv.springs()["z-350hi"])
    assert (weak.mass, weak.basis) == (
        None,
        "Z-350HI, extension spring of 7 mm permits 1760 N, and the preload is 2200 N",
    )
    stiff = pressing(preload_spring=StockSpring(stiffness=1e7, mass=0.1))
    assert stiff.basis == "spring gives way by 0.22 mm under the preload, less than structure.spring_deflection, 1 mm"
    unknown = pressing(preload_spring=StockSpring(name="mine"))
    assert (unknown.mass, unknown.basis) == (None, "mine: the mass is not stated")
    with pytest.raises(iv.ParameterError, match="stock_springs must be false with a preload_spring"):
        Structure(preload_spring=spring, stock_springs=True)


def test_a_study_names_preload_spring_and_tube():
    raw = tomllib.loads(KNEE.to_toml())
    drive = raw["drives"]["cobotic"]
    drive["structure"] = {**drive.get("structure", {}), "preload_spring": {"part": "z-380hi"}}
    drive["transmission"] |= {"cylinder_tube": {"part": "al-2014-100x1.2"}, "cylinder_length": "0.1 m"}
    drive["transmission"]["geometry"]["cylinder_material"] = {"part": "al-7075-t6"}
    study = iv.Study.from_dict(raw, name="stock")
    element = study.drives["cobotic"].transmission
    assert (element.tube.wall, element.tube.length) == pytest.approx((1.2e-3, 0.1))
    kinds = {row.field: row.where for row in study.provenance if row.owner == "cobotic"}
    assert kinds["transmission.cylinder_tube.wall"] == "thyssenkrupp2026, metric sizes"
    assert study.drives["cobotic"].structure.preload_spring == iv.springs()["z-380hi"]
    again = iv.Study.from_dict(tomllib.loads(study.to_toml()), name="again")
    assert again.drives == study.drives


STEEL = StockTube(name="mine", outer_diameter=0.102, wall=4e-3, tube_density=9.668)


def turned(**changed):
    return replace(COBOTIC.transmission, **{"cylinder_tube": STEEL, "cylinder_length": 0.1, **changed})


def test_a_cylinder_is_turned_from_its_tube():
    """The bore stays: of a tube of 102 mm, 3 mm of 4 mm are left at 50 mm."""
    element = turned()
    stated = turned(cylinder_tube=None, cylinder_wall=3e-3)
    assert element.tube.wall == pytest.approx(3e-3)
    assert element.tube.mass == pytest.approx(stated.tube.mass)
    assert element.utilisation[Limit.WALL] == pytest.approx(stated.utilisation[Limit.WALL])
    whole = turned(cylinder_radius=0.051)
    assert whole.tube.wall == pytest.approx(4e-3)
    # 7810 kg/m^3 of bearing steel, where the row says 9.668 kg/m.
    assert whole.tube.mass == pytest.approx(0.1 * 9.668 * 7810.0 / 7850.0, rel=1e-3)


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        (
            {"cylinder_radius": 0.0512},
            r"cylinder_radius must be > 47 mm and <= 51 mm, within the wall .*, got 51\.2 mm",
        ),
        ({"cylinder_radius": 0.047}, r"cylinder_radius must be > 47 mm and <= 51 mm"),
        ({"cylinder_wall": 3e-3}, "cylinder_wall must be removed: it follows from cylinder_tube and cylinder_radius"),
        ({"cylinder_length": None}, "cylinder_length is missing: cylinder_tube needs it"),
        (
            {"cylinder_tube": iv.tubes()["al-2014-100x1.2"]},
            r"cylinder_material must have a density within 5 % of 2800 kg/m\^3, that of cylinder_tube .*, got 7810 kg/m\^3",
        ),
    ],
)
def test_faults_of_tubes_are_named(changed, words):
    with pytest.raises(iv.ParameterError, match=words):
        turned(**changed)
    with pytest.raises(iv.ParameterError, match="wall must be < 5 mm, half of outer_diameter, got 6 mm"):
        StockTube(outer_diameter=0.01, wall=0.006)


def test_a_row_without_mass_is_weighed_by_its_metal():
    bare = StockTube(outer_diameter=0.02, wall=1e-3)
    assert bare.weight == pytest.approx(7850.0 * np.pi * 0.019 * 1e-3)
    assert replace(bare, metal="aluminium").weight == pytest.approx(2700.0 / 7850.0 * bare.weight)
    assert replace(bare, density=8000.0).weight == pytest.approx(8000.0 / 7850.0 * bare.weight)
    assert replace(bare, tube_density=0.5).weight == 0.5
    assert StockSpring().weight == np.inf


def test_a_stated_preload_spring_of_many_designs():
    preloads, spring = np.array([100.0, 300.5, 2000.0, 2600.0]), iv.springs()["z-380hi"]
    many = pressing(preloads, preload_spring=spring).mass
    alone = [pressing(float(one), preload_spring=spring).mass for one in preloads]
    assert [None if np.isnan(one) else one for one in many] == alone == [None, None, spring.mass, None]


def test_springs_and_tubes_are_imported_by_their_columns(tmp_path):
    """A file of each kind; its rows are those of the parts, and bad ones are named with line, field, value and what is right."""
    springs, tubes = tmp_path / "springs.csv", tmp_path / "tubes.csv"
    springs.write_text(
        "key,made_for,stiffness [N/mm],permissible_force [N],wire_diameter [mm],outer_diameter [mm],coils\n"
        "a,compression,1.809,10.33,0.5,4.5,5.5\nb,torsion,1.8,10,0.5,4.5,5\nc,extension,1.8,-3,0.5,4.5,5\n"
    )
    tubes.write_text("key,outer_diameter [mm],wall [mm],tube_density [kg/m]\na,30,2,1.381\nb,30,0,1\n")
    found = iv.import_parts([springs, tubes], name="mine")
    spring, tube = found.parts.springs.part("a"), found.parts.tubes.part("a")
    assert (spring.stiffness, spring.weight) == pytest.approx((1809.0, iv.springs()["d-077"].weight))
    assert tube == replace(iv.tubes()["e235n-30x2"], name="a")
    assert [str(fault) for fault in found.faults] == [
        "springs.csv:3: b: made_for = 'torsion' must be one of compression, extension (did you mean 'compression'?)",
        "springs.csv:4: c: permissible_force must be > 0 N, got -3.0",
        "tubes.csv:3: b: wall must be > 0 m, got 0.0, written as 0 mm",
    ]
    assert iv.search_parts(found.parts, "springs", "stiffness < 2 N/mm").count == 1
    assert iv.check_parts(found.parts).consistent


def test_a_tube_keeps_the_search_to_what_it_can_be_turned_to():
    element = turned()
    study = replace(KNEE, drives={"cobotic": replace(COBOTIC, transmission=element)})
    with pytest.raises(
        iv.InputError, match=r"ranges\['cylinder_radius'\] must be within 47\.24 mm to 51 mm, .* got 20 mm to 60 mm"
    ):
        iv.size(study, drive="cobotic", ranges={"cylinder_radius": (0.02, 0.06)})
    found = iv.size(study, drive="cobotic", generations=1, top=1)
    assert 0.047 < found.designs[0].drive.transmission.cylinder_radius <= 0.051


def test_the_sensitivity_to_the_radius_of_a_cylinder_turned_from_a_tube():
    """By the complex step, and by central differences, whose error is of the order of the step squared, 1e-6. The range of the
    radius ends where the tube does, and the sizes of the tube itself are nominal."""
    drive = replace(COBOTIC, cylinder_inertia=None, transmission=turned(cylinder_radius=0.049))

    def energy(radius):
        made = replace(drive, transmission=replace(drive.transmission, cylinder_radius=radius))
        return iv.duty_cycle(made, KNEE.duty["walking"]).energy

    found = iv.sensitivity(replace(KNEE, drives={"cobotic": drive}), "cobotic", "energy", samples=0)
    rows = {row.path: row for row in found.influences}
    row = rows["transmission.cylinder_radius"]
    step = 1e-3 * 0.049
    slope = (energy(0.049 + step) - energy(0.049 - step)) / (2.0 * step)
    assert row.elasticity == pytest.approx(slope * 0.049 / energy(0.049), rel=1e-3)
    assert (row.low, row.high) == pytest.approx((0.047 / 0.995, 0.051))
    assert not [path for path in rows if "cylinder_tube" in path]


def test_a_spring_from_stock_has_the_sensitivity_of_its_stiffness():
    study = sprung(part="z-161i")
    found = iv.sensitivity(study, "geared", "energy", samples=0)
    rows = {row.path: row.elasticity for row in found.influences if "series_spring" in row.path}
    assert set(rows) == {"output.series_spring.stiffness"}
    drive = study.drives["geared"]
    energy = [
        iv.duty_cycle(
            replace(drive, output=iv.Output(series_spring=Spring(stiffness=8316.0 * (1.0 + step)))),
            KNEE.duty["walking"],
        ).energy
        for step in (-1e-3, 0.0, 1e-3)
    ]
    assert rows["output.series_spring.stiffness"] == pytest.approx(
        (energy[2] - energy[0]) / (2e-3 * energy[1]), rel=1e-3
    )


def test_a_mass_that_is_derived_from_the_wire_says_so():
    study = sprung(part="d-313j-02")
    body = next(one for one in study.drives["geared"].bodies(SERVICE) if one.name == "springs")
    spring = iv.springs()["d-313j-02"]
    assert (body.mass, body.kind, body.basis) == (pytest.approx(spring.weight), "derived", spring.name)
    assert pressing(300.0, preload_spring=spring).kind == "derived"

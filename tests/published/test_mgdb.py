"""The importer on the public MGDB files, where they are present: they have no licence and are not part of the project.

Counts are those of the files themselves. Source: the MGDB files of 2020 (maxon, Faulhaber, Allied Motion).
"""

import csv
from pathlib import Path

import numpy as np
import pytest

import infinivar as iv
from internals import importing, shipped

FOLDER = Path(__file__).parents[3] / "shared" / "reference" / "mgdb"
pytestmark = pytest.mark.skipif(not FOLDER.is_dir(), reason="needs the MGDB files, which are not part of the project")


def files(maker):
    return sorted(FOLDER.glob(f"{maker}_*.csv"))


@pytest.fixture(scope="module")
def imported():
    return {maker: iv.import_parts(files(maker), name=maker) for maker in ("maxon", "faulhaber", "allied_motion")}


@pytest.mark.parametrize(
    ("maker", "motors", "gearheads", "pairs"), [("maxon", 640, 1897, 60_143), ("faulhaber", 237, 644, 24_646)]
)
def test_every_row_and_pair_is_read(imported, maker, motors, gearheads, pairs):
    parts = imported[maker].parts
    assert (len(parts.motors), len(parts.gearheads), len(parts.pairs)) == (motors, gearheads, pairs)
    assert imported[maker].faults == ()  # among them: no key without a match
    assert len(np.unique(parts.pairs, axis=0)) == pairs


def test_what_is_not_stated(imported):
    maxon, faulhaber = imported["maxon"].parts, imported["faulhaber"].parts
    # Every intermittent torque of a motor is infinite: no peak torque is stated.
    assert np.isnan(maxon.motors["peak_torque"]).all()
    assert np.isnan(faulhaber.motors["peak_torque"]).all()
    assert int(np.isnan(faulhaber.gearheads["efficiency"]).sum()) == 31
    assert not np.isnan(maxon.gearheads["efficiency"]).any()
    lacks = np.isnan(faulhaber.motors["winding_to_housing"]) & np.isnan(faulhaber.motors["housing_to_ambient"])
    assert int(lacks.sum()) == 9
    assert imported["faulhaber"].unstated["motors"]["winding_to_housing"] == 9
    infinite = "max_int_torque is infinite, read as not stated"
    counts = [
        len(one.lines) for maker in ("maxon", "faulhaber") for one in imported[maker].remarks if one.text == infinite
    ]
    assert sum(counts) == 877
    assert imported["maxon"].incomplete == {}
    assert imported["faulhaber"].incomplete == {"gearheads": {"efficiency": 31}}


def test_a_row_that_is_no_number_is_refused_and_the_others_kept(imported):
    allied = imported["allied_motion"]
    assert [str(fault) for fault in allied.faults] == [
        "allied_motion_motors.csv:148: AM_HT01002-A00: column 'L': must be a finite number, got '0.85-3'"
    ]
    # No no-load current is stated, so that none can be used in a drive.
    assert allied.incomplete["motors"]["no_load_current"] == len(allied.parts.motors) == 147


@pytest.mark.slow
def test_contradictions(imported):
    found = {maker: iv.check_parts(one.parts) for maker, one in imported.items()}
    speeds = [one for one in found["maxon"].contradictions if one.relation == "no-load speed"]
    assert len(speeds) == 4
    assert speeds[0].deviation == pytest.approx(1.09, abs=0.005)
    # The constants would allow more: all four state a round speed, 6000 or 4500 rpm, below their permissible one.
    motors = imported["maxon"].parts.motors
    rows = [motors.row(one.key) for one in speeds]
    stated = motors["stated_no_load_speed"][rows] * 30.0 / np.pi
    np.testing.assert_allclose(stated, [6000.0, 6000.0, 6000.0, 4500.0], rtol=1e-9)
    assert all(one.deviation > 0 for one in speeds)
    assert (motors["max_speed"][rows] * 30.0 / np.pi > stated).all()
    assert [one.unusable for one in found.values()] == [(), (), ()]
    assert found["maxon"].tested["motor: no-load speed"] == 640
    assert [one for one in found["faulhaber"].contradictions if one.relation == "no-load speed"] == []
    assert len({one.key for one in found["maxon"].contradictions if one.kind == "gearheads"}) == 12


@pytest.mark.slow
def test_values_survive_import_and_storage(imported, tmp_path):
    parts = imported["maxon"].parts
    assert importing.read(importing.write(parts, tmp_path / "maxon.npz")) == parts
    with (FOLDER / "maxon_motors.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    for ours, theirs in (
        ("voltage", "V"),
        ("resistance", "R"),
        ("torque_constant", "k_t"),
        ("rotor_inertia", "inertia"),
    ):
        np.testing.assert_array_equal(parts.motors[ours], [float(row[theirs]) for row in rows])
    # Every row is a part.
    assert all(parts.motors.part(row).voltage > 0 for row in range(len(parts.motors)))
    assert all(parts.gearheads.part(row).ratio > 1 for row in range(len(parts.gearheads)))


def test_shipped_parts_agree_with_the_files(imported):
    """Two transcriptions of one catalogue: order numbers that both have, to the digits of the catalogue."""
    for kind, columns in (
        ("motors", ("voltage", "resistance", "torque_constant", "rotor_inertia", "mass")),
        ("gearheads", ("continuous_torque", "mass")),
    ):
        mine, theirs = shipped().tables[kind], imported["maxon"].parts.tables[kind]
        known = {number: row for row, number in enumerate(theirs["order_number"].tolist())}
        both = [(row, known[number]) for row, number in enumerate(mine["order_number"].tolist()) if number in known]
        assert len(both) >= 10
        ours, others = map(list, zip(*both, strict=True))
        for column in columns:
            np.testing.assert_allclose(mine[column][ours], theirs[column][others], rtol=1e-12, err_msg=column)
        if kind == "motors":
            # The torque derived from the current, and that of the catalogue: equal to three digits with brushes. That of flat
            # brushless motors exceeds even K I, so that the derived one is on the safe side.
            derived = theirs["continuous_torque"][others] / mine["continuous_torque"][ours]
            brushed = theirs["type"][others] == "DC"
            np.testing.assert_allclose(derived[brushed], 1.0, atol=0.01)
            assert brushed.sum() >= 5
            assert ((derived[~brushed] > 0.84) & (derived[~brushed] < 0.99)).all()

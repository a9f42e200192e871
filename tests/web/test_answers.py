"""The answers equal what the public interface gives; faults stand at their fields; only files of the study are read."""

import copy
import io
import json
import tomllib
import zipfile

import numpy as np
import pytest

import infinivar as iv
from infinivar.analysis import whole_mass
from internals import ANSWERS, Answer, Envelope, RefusedError, function_of, shipped_studies
from internals import answered_request as answered
from internals import document_answer as document
from internals import plain_answer as plain
from internals import unpack_answer as unpack
from sampled import sampled
from serving import unpacked


@pytest.fixture(autouse=True)
def begun():
    document.begin()


@pytest.fixture
def opened_study():
    return copy.deepcopy(answered("start", {}).header["study"])


def faults(name, payload):
    return answered(name, payload).header["faults"]


def value(fields, owner, path):
    return next(one for one in fields if one["owner"] == owner and one["path"] == path)


def test_packed_answers_survive():
    arrays = {
        "one": np.arange(5, dtype=np.uint8),
        "a/b": np.array([[1.5, np.nan], [np.inf, -0.0]], np.float32),
        "none": np.empty((0, 3), np.float64),
    }
    packed = Answer(
        header={"text": "µ – \ud800", "nan": float("nan"), "deep": [{"a": np.float64(2)}]}, arrays=arrays
    ).pack()
    header, found = unpacked(packed)
    assert header["text"] == "µ – \ud800"
    assert header["nan"] is None
    assert header["deep"] == [{"a": 2.0}]
    for name, array in arrays.items():
        np.testing.assert_array_equal(found[name], array)
        np.testing.assert_array_equal(unpack(packed).arrays[name], array)


def test_every_answer_can_be_loaded():
    for name in ANSWERS:
        assert callable(function_of(name)), name


@pytest.mark.parametrize("name", ["cobotic", "motor1-gear2"])
def test_maps_are_those_of_the_interface(opened_study, name):
    found = answered("maps", {**opened_study, "count": 24, "drives": [name]})
    study = iv.load_study("hand_controller")
    header, arrays = found.header["drives"][name], found.arrays
    steady = iv.steady_map(study.drives[name], arrays["speed"], arrays["force"])
    np.testing.assert_array_equal(arrays[f"{name}/efficiency"], steady.efficiency.T.astype(np.float32))
    codes = np.array([iv.Limit[one] for one in header["limit_names"]])
    np.testing.assert_array_equal(codes[arrays[f"{name}/limit"]], steady.limit.T)
    np.testing.assert_allclose(arrays[f"{name}/margin"], np.minimum(steady.margin.T, 2.0), rtol=1e-6)
    assert header["limits"] == [iv.Limit(code).words for code in codes]
    low, high = found.header["plane"]["force"]
    np.testing.assert_allclose(np.diff(arrays["force"]), (high - low) / 24)
    assert arrays["force"][0] - low == pytest.approx((high - low) / 48)


@pytest.mark.parametrize(("most", "shown"), [(1, ["cobotic"]), (2, ["cobotic", "motor2-gear4"])])
def test_the_page_begins_with_the_maps_that_it_would_ask_for(opened_study, most, shown):
    begun = answered("start", {"count": 24, "most": most})
    maps = answered("maps", {**opened_study, "count": 24, "drives": shown})
    assert list(begun.header["maps"]["drives"]) == shown
    assert plain(begun.header["maps"]) == plain(maps.header)
    assert begun.arrays.keys() == maps.arrays.keys()
    for name, array in maps.arrays.items():
        np.testing.assert_array_equal(begun.arrays[name], array)


@pytest.mark.parametrize("wrong", [{"count": 7}, {"count": "60"}, {"count": 24, "most": 3}])
def test_the_page_begins_with_a_sensible_number_of_maps(wrong):
    with pytest.raises(RefusedError):
        answered("start", wrong)


def test_losses_stand_where_the_load_drives(opened_study):
    shipped = answered("shipped", {"which": "knee_walking"}).header
    found = answered("maps", {**shipped, "count": 16})
    study = iv.load_study("knee_walking")
    steady = iv.steady_map(study.drives["geared"], found.arrays["speed"], found.arrays["force"])
    loss = found.arrays["geared/loss"]
    there = np.isfinite(loss)
    assert 0 < there.sum() < there.size
    np.testing.assert_allclose(loss[there], (steady.power_in - steady.power_out).T[there], rtol=1e-6)
    assert np.isnan(found.arrays["geared/efficiency"][there]).all()


def test_verdicts_are_those_of_the_comparison(opened_study):
    found = answered("judge", opened_study).header["drives"]
    compared = iv.compare(iv.load_study("hand_controller"), quick=True)
    for name, result in compared.results.items():
        assert found[name]["coverage"] == result.coverage
        assert found[name]["verdict"] == result.verdict
        assert found[name]["mean_loss"] == result.mean_loss
        assert found[name]["tightest"]["margin"] == result.tightest.value
    maps = answered("maps", {**opened_study, "count": 8}).header["drives"]
    assert maps["cobotic"]["requirement"] == found["cobotic"]


def test_the_size_stands_beside_the_verdict(opened_study):
    """As `compare` states them, also of an envelope."""
    study = iv.load_study("hand_controller")
    tables = {**opened_study, "tables": {**opened_study["tables"], "envelope": {"mass": "1 kg"}}}
    for sent, envelope in ((opened_study, None), (tables, Envelope(mass=1.0))):
        for name, one in answered("judge", sent).header["drives"].items():
            mass = whole_mass(study, name)
            assert one["fits"] == mass.within(envelope)
            assert one["size"].startswith(mass.space_words)
            assert ("exceeds the envelope" in one["size"]) == (not one["fits"])


@pytest.mark.parametrize("name", ["hand_controller", "knee_walking", "planar_cart"])
def test_the_glance_is_that_of_the_comparison(name):
    """Winner, figures and margins come from the results of each drive and motion, not from the table that the page shows."""
    found = answered("glance", answered("shipped", {"which": name}).header).header
    compared = iv.compare(iv.load_study(name), quick=True)
    rows = {row["name"]: row for row in found["rows"]}
    assert found["verdict"] == compared.verdict
    assert [row["name"] for row in found["rows"] if row["best"]] == [compared.best.name]
    assert found["headline"].startswith(f"{compared.best.title}: ")
    assert (
        found["decided"]
        == ("Undecidable" not in compared.verdict)
        == (not found["turned_by"].startswith("Not decided"))
    )
    for one, result in compared.results.items():
        row = rows[one]
        if name == "planar_cart":
            assert (row["able"], row["figure"]) == (result.feasible, pytest.approx(result.mean_power, rel=1e-12))
            assert row["margin"] == min(task.margin for task in result.found.values())
            continue
        cycles = [duty.results[one] for duty in compared.duty.values()]
        figure = sum(cycle.energy for cycle in cycles) if cycles else result.mean_loss
        assert (row["able"], row["figure"]) == (compared.able(one), pytest.approx(figure, rel=1e-12))
        assert row["margin"] == min([result.tightest.value, *(cycle.tightest[1] for cycle in cycles)])
        assert row["weighs"] == whole_mass(compared.study, one).known_words


def test_the_glance_says_when_none_leads(opened_study):
    tables = opened_study["tables"]
    for force, said in (
        ("5 kN", "None meets all that is required."),
        ("50 N", "Cobotic, Motor 1 (reconstruction B): mean loss"),
    ):
        tables["requirement"]["force"] = force
        assert answered("glance", opened_study).header["headline"].startswith(said)
    tables["drives"] = {"cobotic": tables["drives"]["cobotic"]}
    assert answered("glance", opened_study).header["headline"].endswith("W, meets all that is required.")
    sessions = answered("shipped", {"which": "guided_cart"}).header
    assert answered("glance", sessions).header["rows"] == []


def changed(sent, changes):
    """A request with other values in its tables."""
    made = copy.deepcopy(sent)
    for one in changes:
        inside = made["tables"]
        for key in one["at"][:-1]:
            inside = inside.setdefault(key, {})
        inside[one["at"][-1]] = one["value"]
    return made


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "drive", "stated"),
    [
        ("hand_controller", "motor1-gear1", {}),
        ("hand_controller", "motor1-gear2", {}),
        ("hand_controller", "motor1-gear3", {}),
        ("hand_controller", "motor2-gear4", {"requirement": {"force": "80 N"}}),
        ("hand_controller", "cobotic", {"requirement": {"power": "20 W"}}),
        ("ankle_walking", "geared", {}),
        ("knee_walking", "geared", {"requirement": {"force": "260 N"}}),
        ("reach_and_hold", "geared", {"requirement": {"force": "60 N"}}),
        ("sphere_joint", "geared", {}),
        (
            "planar_cart",
            "two-wheels",
            {"tasks": {"park": {"wrench": {"x": "80 N", "y": "80 N"}, "time_share": "20 %"}}},
        ),
        ("two_joint_arm", "two-motors", {"tasks": {"push": {"wrench": {"x": "30 N"}, "time_share": "25 %"}}}),
    ],
)
def test_what_would_mend_a_drive_does(name, drive, stated):
    """The whole comparison of the changed tables finds the drive able, which the search does not ask."""
    sent = answered("shipped", {"which": name}).header
    for table, values in stated.items():
        sent["tables"][table] = {**sent["tables"].get(table, {}), **values}

    def able(request):
        return next(row["able"] for row in answered("glance", request).header["rows"] if row["name"] == drive)

    assert not able(sent)
    rows = answered("mend", {**sent, "drive": drive}).header["rows"]
    assert rows
    assert len({json.dumps(row) for row in rows}) == len(rows)
    for changes in rows[:3]:
        assert able(changed(sent, changes))
        if len(changes) == 1:
            continue
        # None of several changes is idle.
        for left in changes:
            assert not able(changed(sent, [one for one in changes if one is not left]))


def test_the_torque_that_mends_a_geared_drive_is_that_of_its_limit(opened_study):
    (changes,) = answered("mend", {**opened_study, "drive": "motor1-gear3"}).header["rows"]
    limit = iv.compare(iv.load_study("hand_controller"), quick=True).results["motor1-gear3"].tightest
    (torque,) = changes
    assert torque["label"] == "Motor › Continuous torque"
    assert float(torque["text"].split()[0]) == pytest.approx(
        26.3 / limit.value, rel=0.06
    )  # friction grows with rated torque


def test_what_would_mend_a_point(opened_study):
    sent = {**opened_study, "drive": "motor2-gear4", "speed": 0.3, "force": 60.0}
    rows = answered("mend", sent).header["rows"]
    for changes in rows:
        point = answered("point", changed(sent, changes)).header
        assert point["feasible"]
    assert not answered("point", sent).header["feasible"]
    assert answered("mend", {**sent, "force": 20.0}).header["reason"] == "Nothing: it is within all limits."
    machine = answered("shipped", {"which": "planar_cart"}).header
    name = next(iter(machine["tables"]["drives"]))
    assert answered("mend", {**machine, "drive": name}).header["reason"] == "Nothing: it is within all limits."


def test_tasks_are_those_of_the_comparison():
    shipped = answered("shipped", {"which": "two_joint_arm"}).header
    found = answered("tasks", shipped).header
    compared = iv.compare(iv.load_study("two_joint_arm"))
    assert found["verdict"] == compared.verdict
    for name, result in compared.results.items():
        for row in found["machines"][name]["tasks"]:
            assert row["power"] == result.found[row["key"]].mean_power
            assert row["margin"] == result.found[row["key"]].margin


def test_only_the_changed_drive_is_computed_and_sent(opened_study):
    first = answered("maps", {**opened_study, "count": 12})
    known = {name: one["tag"] for name, one in first.header["drives"].items()}
    opened_study["tables"]["drives"]["cobotic"]["transmission"] = {"preload": "600 N"}
    second = answered("maps", {**opened_study, "count": 12, "known": known})
    changed = [name for name, one in second.header["drives"].items() if not one["same"]]
    assert changed == ["cobotic"]
    assert {name.partition("/")[0] for name in second.arrays} == {"speed", "force", "cobotic"}
    # The requirement and the number of cells belong to the map as well.
    opened_study["tables"]["requirement"] = {"base": "faulring2006", "force": "40 N"}
    assert not any(
        one["same"] for one in answered("maps", {**opened_study, "count": 12, "known": known}).header["drives"].values()
    )
    assert not any(
        one["same"] for one in answered("maps", {**opened_study, "count": 13, "known": known}).header["drives"].values()
    )


def test_a_map_builds_only_what_it_needs(opened_study):
    """The map of one drive needs neither the others nor runs, except those that the drive is like; its tag is the same."""
    drives = opened_study["tables"]["drives"]
    drives["mine"] = {"like": "cobotic", "transmission": {"preload": "600 N"}}
    everything = answered("maps", {**opened_study, "count": 8})
    one = answered("maps", {**opened_study, "count": 8, "drives": ["mine"]})
    assert list(one.header["drives"]) == ["mine"]
    assert one.header["drives"]["mine"] == everything.header["drives"]["mine"]
    np.testing.assert_array_equal(one.arrays["mine/efficiency"], everything.arrays["mine/efficiency"])
    np.testing.assert_array_equal(one.arrays["force"], everything.arrays["force"])
    drives["motor1-gear1"]["efficiency"] = "nonsense"  # of another drive: the study says so, the map is drawn
    assert not answered("maps", {**opened_study, "count": 8, "drives": ["mine"]}).header.get("faults")
    assert faults("study", opened_study)
    drives["cobotic"]["base"] = "nonsense"
    assert faults("maps", {**opened_study, "count": 8, "drives": ["mine"]})


def test_a_tag_does_not_depend_on_what_was_computed(opened_study):
    first = answered("maps", {**opened_study, "count": 8}).header["drives"]
    document._studies.clear()
    answered("judge", opened_study)
    second = answered("maps", {**opened_study, "count": 8}).header["drives"]
    assert [one["tag"] for one in first.values()] == [one["tag"] for one in second.values()]


@sampled("which", list(shipped_studies()), every=6)
def test_fields_are_the_values_of_the_study(which):
    shipped = answered("shipped", {"which": which}).header
    found = answered("study", shipped).header
    study = iv.load_study(which)
    assert found["title"] == study.title
    assert [one["name"] for one in found["drives"]] == list(study.drives)
    rows = {(row.owner, row.field): row for row in study.provenance}
    stated = {(one["owner"], one["path"]): one for one in found["fields"]}
    for key, row in rows.items():
        if key not in stated:
            # The name of a part of the catalogue stands at the part.
            assert key[1].endswith("name"), key
            continue
        one = stated[key]
        assert one["kind"] == row.kind, key
        assert one["written"] == row.written, key
        if one["type"] == "quantity":
            assert one["value"] == row.value, key
            assert one["unit"] == row.unit, key
        assert one["kind"] in ("stated", "catalogue", "derived", "fitted", "assumed")
    for one in found["fields"]:
        assert one["label"], one
        if one["type"] == "quantity":
            low, high = one["minimum"], one["maximum"]
            assert low is None or one["value"] >= low
            assert high is None or one["value"] <= high
            if one["slider"]:
                assert one["slider"]["low"] < one["slider"]["high"]
                assert one["slider"]["low"] <= one["value"] <= one["slider"]["high"], one
            if one["shown"]:
                shown = one["shown"]
                si = shown["number"] * shown["factor"] + shown["offset"]
                assert si == pytest.approx(one["value"], rel=1e-9, abs=1e-12), one
        if one["type"] == "choice":
            assert one["value"] in one["choices"], one
        if one["type"] == "part":
            assert one["part_kind"] in ("motors", "gearheads", "bearings", "springs", "tubes", "materials")


def put(tables, field, stated):
    """Set a value as a page does."""
    for key in field["at"][:-1]:
        tables = tables.setdefault(key, {})
    tables[field["at"][-1]] = stated


@sampled("which", list(shipped_studies()), every=6)
def test_every_field_can_be_set_to_its_own_value(which):
    """Setting the key of a field to what it says, through `at`, is accepted and keeps the value."""
    shipped = answered("shipped", {"which": which}).header
    fields = answered("study", shipped).header["fields"]
    set_anew = [one for one in fields if one["type"] not in ("row", "list", "part")]
    for one in set_anew:
        bare = one["type"] != "quantity" or one["unit"] == "1"
        put(shipped["tables"], one, one["value"] if bare else f"{one['value']!r} {one['unit']}")
    found = answered("study", shipped).header
    assert not found["faults"]
    for one in set_anew:
        same = value(found["fields"], one["owner"], one["path"])["value"]
        assert same == pytest.approx(one["value"]) if one["type"] == "quantity" else same == one["value"], one


@pytest.mark.parametrize("end", ["low", "high"])
def test_a_slider_stays_within_what_is_permitted(opened_study, end):
    fields = answered("study", opened_study).header["fields"]
    for one in fields:
        if one["slider"]:
            number = one["slider"][end]
            put(opened_study["tables"], one, number if one["unit"] == "1" else f"{number!r} {one['unit']}")
    # Values may exclude each other; none is outside the range of its own field, which is found first.
    stated = [fault["message"] for fault in answered("study", opened_study).header["faults"]]
    for one in fields:
        assert not one["bounds"] or not any(f"must be {one['bounds']}, such as" in line for line in stated), stated


def test_a_part_is_picked(opened_study):
    field = value(answered("study", opened_study).header["fields"], "cobotic", "motor")
    assert field["part_kind"] == "motors"
    put(opened_study["tables"], field, "dc-max-26-s-24v-low-friction")
    found = answered("study", opened_study).header
    assert value(found["fields"], "cobotic", "motor")["written"] == "DC-max 26 S, 24 V, low friction"


def test_faults_stand_at_their_fields(opened_study):
    opened_study["tables"]["drives"]["cobotic"]["transmission"] = {"preload": "-3 N", "friktion": 0.1}
    opened_study["tables"]["requirement"]["force"] = "50 kg"
    found = {one["at"]: one["message"] for one in faults("study", opened_study)}
    assert set(found) == {
        "requirement.force",
        "drives.cobotic.transmission.preload",
        "drives.cobotic.transmission.friktion",
    }
    with pytest.raises(iv.InputError) as problem:
        iv.Study.from_dict(opened_study["tables"], name=opened_study["name"])
    for message in found.values():
        assert f"{opened_study['name']}: {message}" in str(problem.value).split("\n")


@pytest.mark.parametrize(
    ("tables", "at"),
    [
        ({"extends": "/etc/passwd"}, "extends"),
        ({"parts": "/etc"}, "parts"),
        ({"parts": ["../.."]}, "parts"),
        ({"duty": {"walk": {"motion": {"shape": "file", "file": "/etc/passwd"}}}}, "duty.walk.motion.file"),
        ({"duty": {"walk": {"file": {"value": "/etc/passwd", "kind": "stated"}}}}, "duty.walk.file"),
        ({"duty": {"walk": {"force_file": "/etc/passwd"}}}, "duty.walk.force_file"),
        ({"tasks": {"wall": {"surface": {"file": "../secret.stl"}}}}, "tasks.wall.surface.file"),
        ({"tasks": {"wall": {"user": [{"x": {"file": "a.csv"}}]}}}, "tasks.wall.user.x.file"),
        ({"paths": {"a": {"x": {"shape": "file", "file": "x.csv"}}}}, "paths.a.x.file"),
        ({"drives": {"cobotic": {"type": "robot", "model": "/etc/robot.urdf"}}}, "drives.cobotic.model"),
        ({"drives": {"cobotic": {"motor": {"part": "/etc/motors.toml:x"}}}}, "drives.cobotic.motor.part"),
        ({"drives": {"cobotic": {"motor": {"part": "../set.csv:x"}}}}, "drives.cobotic.motor.part"),
    ],
)
def test_no_file_that_the_page_names_is_opened(opened_study, tables, at, monkeypatch):
    from internals import study_loading as loading

    def refuse(*_, **__):
        raise AssertionError("the study was built")

    monkeypatch.setattr("infinivar.web.answers.document.study_from_dict", refuse)
    assert loading.study_from_dict is not refuse
    for name in ("study", "maps", "toml"):
        found = faults(name, {**opened_study, "tables": {**opened_study["tables"], **tables}})
        assert [one["at"] for one in found] == [at]
        assert "it was started with" in found[0]["message"] or "must be named" in found[0]["message"]


def test_files_of_the_study_itself_are_opened(tmp_path):
    time = np.linspace(0, 1, 101)
    rows = "\n".join(f"{t},{0.01 * np.sin(2 * np.pi * t)}" for t in time)
    (tmp_path / "walk.csv").write_text(f"time [s],position [m]\n{rows}\n")
    (tmp_path / "other.csv").write_text(f"time [s],position [m]\n{rows}\n")
    text = """
        [drives.cobotic]
        base = "faulring2006.cobotic"
        [duty.walk]
        shape = "file"
        file = "walk.csv"
        load_mass = "1 kg"
    """
    (tmp_path / "mine.toml").write_text(text)
    document.begin(str(tmp_path / "mine.toml"))
    opened_study = answered("start", {}).header["study"]
    assert opened_study["name"] == "mine"
    assert not faults("study", opened_study)
    opened_study["tables"]["duty"]["walk"]["file"] = "other.csv"
    (fault,) = faults("study", opened_study)
    assert fault["at"] == "duty.walk.file"
    opened_study["tables"]["duty"]["walk"]["file"] = str(tmp_path / "walk.csv")
    assert faults("study", opened_study)


def test_both_files_of_a_recording_are_opened(tmp_path):
    """A change of either on disk is a change of the study."""
    time = np.linspace(0, 1, 101)
    turn = 2 * np.pi * time
    for name, heading, values in (
        ("x", "position [m]", 0.01 * np.sin(turn)),
        ("f", "force [N]", np.cos(turn)),
        ("other", "force [N]", turn),
    ):
        rows = "\n".join(f"{t},{value}" for t, value in zip(time, values, strict=True))
        (tmp_path / f"{name}.csv").write_text(f"time [s],{heading}\n{rows}\n")
    (tmp_path / "mine.toml").write_text(
        '[drives.cobotic]\nbase = "faulring2006.cobotic"\n[duty.walk]\nshape = "file"\nload_mass = "1 kg"\n'
        'file = "x.csv"\nforce_file = "f.csv"\n'
    )
    document.begin(str(tmp_path / "mine.toml"))
    opened_study = answered("start", {}).header["study"]
    assert not faults("study", opened_study)
    before = document.stamp()
    (tmp_path / "f.csv").write_text((tmp_path / "f.csv").read_text() + "\n")
    assert document.stamp() != before
    opened_study["tables"]["duty"]["walk"]["force_file"] = "other.csv"
    (fault,) = faults("study", opened_study)
    assert fault["at"] == "duty.walk.force_file"


def test_a_study_that_extends_another_is_one_document(tmp_path):
    below = "title = 'below'\n[requirement]\nbase = 'faulring2006'\n[drives.cobotic]\nbase = 'faulring2006.cobotic'\n"
    (tmp_path / "below.toml").write_text(below)
    (tmp_path / "mine.toml").write_text("extends = 'below.toml'\ntitle = 'mine'\n[requirement]\nforce = '40 N'\n")
    document.begin(str(tmp_path / "mine.toml"))
    opened_study = answered("start", {}).header["study"]
    found = answered("study", opened_study).header
    assert found["title"] == "mine"
    assert value(found["fields"], "requirement", "force")["value"] == 40.0
    assert (
        iv.Study.from_dict(opened_study["tables"], name="mine").drives == iv.load_study(tmp_path / "mine.toml").drives
    )


def test_text_and_tables(opened_study):
    written = answered("toml", opened_study).header
    assert tomllib.loads(written["text"]) == opened_study["tables"]
    opened = answered("open", {"name": "hand_controller.toml", "text": written["text"]}).header
    assert opened["tables"] == opened_study["tables"]
    assert opened["name"] == "hand_controller"
    text = "name = 'mine'  # of the rig\n" + written["text"]
    named = answered("open", {"name": "other.toml", "text": text}).header
    assert answered("toml", named).header["text"] == text
    (fault,) = faults("open", {"name": "x.toml", "text": "title = "})
    assert "is not valid TOML" in fault["message"]
    text = written["text"] + "\n[drives.cobotic.motor]\nvoltage = '-1 V'\n"
    (fault,) = faults("open", {"name": "x.toml", "text": text})
    assert fault["at"] == "drives.cobotic.motor.voltage"


def test_catalogue_search_is_that_of_the_interface():
    found = answered("parts", {"kind": "motors", "query": "maxon, mass < 100 g"}).header
    expected = iv.search_parts(iv.load_parts("shipped"), "motors", ["mass < 100 g", "manufacturer ~ maxon"])
    assert {row["part"] for row in found["rows"]} >= {hit.part for hit in expected.hits}
    assert found["count"] >= expected.count > 0
    assert answered("parts", {"kind": "motors", "query": "no such motor"}).header["rows"] == []
    assert "no column" in faults("parts", {"kind": "motors", "query": "nonsense < 3"})[0]["message"]


def test_data_as_csv(opened_study):
    answer = answered("export", {**opened_study, "what": "csv", "drive": "motor1-gear1", "count": 9})
    lines = answer.arrays["content"].tobytes().decode().splitlines()
    assert answer.header["file"] == "hand_controller-motor1-gear1-map.csv"
    assert len(lines) == 1 + 81
    heads, row = lines[0].split(","), lines[41].split(",")
    numbers = dict(zip(heads, row, strict=True))
    drive = iv.load_study("hand_controller").drives["motor1-gear1"]
    speed, force = float(numbers["speed_m_s"]), float(numbers["force_N"])
    steady = iv.steady_map(drive, [speed], [force])
    assert float(numbers["power_in_W"]) == steady.power_in[0, 0]
    assert numbers["limit"] == iv.Limit(int(steady.limit[0, 0])).words


SMALL = {
    "name": "small",
    "tables": {
        "requirement": {"base": "faulring2006"},
        "drives": {"geared": {"base": "faulring2006.motor1-gear1"}},
    },
}


@pytest.mark.slow
def test_figures():
    figure = answered("export", {**SMALL, "what": "figure", "format": "svg"})
    assert figure.arrays["content"].tobytes().startswith(b"<?xml")


@pytest.mark.slow
def test_reports():
    report = answered("export", {**SMALL, "what": "report"})
    with zipfile.ZipFile(io.BytesIO(report.arrays["content"].tobytes())) as archive:
        names = archive.namelist()
        assert any(name.endswith(".html") for name in names)
        again = tomllib.loads(archive.read("small.toml").decode())
    assert iv.Study.from_dict(again, name="small").drives == iv.Study.from_dict(SMALL["tables"], name="small").drives


@pytest.mark.slow
def test_long_computations():
    from internals import worked_job as worked

    opened_study = SMALL
    progress = []
    found = worked({**opened_study, "job": "compare"}, lambda share, words: progress.append((share, words))).header
    study = iv.Study.from_dict(opened_study["tables"], name="small")
    assert found["verdict"] == iv.compare(study).verdict
    assert progress
    assert next(one["title"] for one in found["figures"]) == "Maps"
    assert all(one["image"].startswith("data:image/svg+xml;base64,") for one in found["figures"])
    sized = worked(
        {**opened_study, "job": "size", "options": {"top": 3}}, lambda share, words: progress.append((share, words))
    ).header
    assert sized["designs"][0]["title"] == iv.size(study, top=3, sets="shipped").designs[0].title
    assert next(one["title"] for one in sized["figures"]) == "Designs"
    with pytest.raises(RefusedError):
        worked({**opened_study, "job": "mine"}, lambda share, words: None)


@pytest.mark.parametrize(
    ("name", "change"),
    [
        ("maps", {"count": 401}),
        ("maps", {"count": 7}),
        ("maps", {"count": True}),
        ("maps", {"count": "60"}),
        ("maps", {"drives": "cobotic"}),
        ("maps", {"known": {"cobotic": 3}}),
        ("maps", {"tables": []}),
        ("study", {"name": 3}),
        ("export", {"what": "passwd"}),
        ("export", {"what": "csv", "count": 10**9}),
        ("parts", {"kind": "screws"}),
        ("parts", {"kind": "motors", "limit": 10**6}),
        ("shipped", {"which": "../../secret"}),
        ("open", {"text": "x" * 10**6}),
        ("no", {}),
    ],
)
def test_what_no_page_asks_is_refused(opened_study, name, change):
    with pytest.raises(RefusedError):
        answered(name, {**opened_study, **change})


def test_headers_are_strict_json(opened_study):
    for name in ("start", "study", "judge"):
        header, _ = unpacked(answered(name, opened_study).pack())
        json.dumps(header, allow_nan=False)

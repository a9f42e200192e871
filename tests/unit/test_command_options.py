"""Options of commands are described once: the command line, the explorer and the reports read them from their fields."""

import dataclasses
import inspect

import pytest
import typer

import infinivar as iv
from infinivar import InputError
from infinivar.cli import app
from internals import (
    DERIVATIVE_METHODS,
    CalibrateOptions,
    CompareOptions,
    MotionOptions,
    RefusedError,
    RigOptions,
    SensitivityOptions,
    SizeOptions,
    StepOptions,
    answered_request,
    engine,
    job_options,
    virtual_rig,
)

KINDS = {
    CompareOptions: iv.compare,
    SizeOptions: iv.size,
    SensitivityOptions: iv.sensitivity,
    StepOptions: iv.analysis.steering_steps,
    MotionOptions: iv.inspect_motion,
    RigOptions: virtual_rig.protocol,
    CalibrateOptions: iv.calibrate,
}
OTHERWISE = {"builds"}
"""Options whose default on the command line is another one than in Python: builds take time, and a script asks for them."""


@pytest.mark.parametrize("kind", KINDS)
def test_python_takes_the_same_options_with_the_same_defaults(kind):
    taken = inspect.signature(KINDS[kind]).parameters
    for field in dataclasses.fields(kind):
        assert field.name in taken, field.name
        if field.name not in OTHERWISE:
            assert taken[field.name].default == field.default, field.name


@pytest.mark.parametrize("kind", KINDS)
def test_the_command_line_has_every_option(kind):
    command = typer.main.get_command(app).commands[kind.command]
    found = {one.name: one for one in command.params}
    for name, known in kind.described().items():
        assert found[name].opts == [f"--{(known.name or name).replace('_', '-')}"]
        assert known.help in found[name].help


def test_choices_are_those_of_the_program():
    assert CompareOptions.described()["engine"].choices == engine.ENGINES
    assert SensitivityOptions.described()["method"].choices == DERIVATIVE_METHODS


def test_what_is_stated_is_read_in_si():
    read = SizeOptions.read(
        {
            "objective": "mass, energy",
            "radius": ("3 mm", "5 cm"),
            "tries": ["drives.a.screw.lead=2 mm, 5 mm", "drives.a.belt.teeth = 10..20"],
            "ranges": ["preload=800 N..3 kN"],
            "steering_ratios": "8,16",
            "life": "2 h",
            "seed": None,
        }
    )
    assert read.objective == ("mass", "energy")
    assert read.radius == pytest.approx((3e-3, 5e-2))
    assert read.tries == {"drives.a.screw.lead": "2 mm, 5 mm", "drives.a.belt.teeth": "10..20"}
    assert read.ranges == {"preload": (800.0, 3000.0)}
    assert read.steering_ratios == (8.0, 16.0)
    assert read.life == 7200.0
    assert (read.seed, read.top) == (None, 20)
    shown = {row.name: row.value for row in read.rows()}
    assert shown["radius"] == "0.003 m, 0.05 m"
    assert shown["ranges"] == "preload from 800 N to 3000 N"
    assert shown["tries"] == "drives.a.screw.lead = 2 mm, 5 mm; drives.a.belt.teeth = 10..20"
    assert shown["seed"] == "0"
    assert shown["life"] == "7200 s"
    assert shown["builds"] == "128"


@pytest.mark.parametrize(
    ("name", "said", "message"),
    [
        ("objective", "power", "--it 'power' must be energy, mass, space or price"),
        ("radius", ("5 mm", "3 mm"), "--it '5 mm' '3 mm' must be a range above 0"),
        ("life", "2 N", "--it '2 N' "),
        ("tries", ["drives.a.screw.lead"], "must be PATH=VALUES"),
        ("tries", ["drives.a.b=1", "drives.a.b=2"], "names drives.a.b twice"),
        ("steering_ratios", "a", "must be numbers separated by commas"),
        ("ranges", ["preload"], "must be NAME=LOW..HIGH"),
        ("ranges", ["preload=1 N..2 N", "preload=1 N..2 N"], "names a value twice"),
    ],
)
def test_what_cannot_be_read_is_said_with_its_name(name, said, message):
    with pytest.raises(InputError) as found:
        SizeOptions.read({name: said}, lambda name: "--it")
    assert message in str(found.value)


def test_the_page_offers_what_the_fields_say():
    rows = answered_request("options", {}).header["jobs"]
    assert [row["name"] for row in rows["compare"]] == list(CompareOptions.described())
    offered = {row["name"]: row for row in rows["size"]}
    assert {*SizeOptions.described()} - {*offered} == {"sets", "builds"}
    for name, row in offered.items():
        known = SizeOptions.described()[name]
        assert (row["help"], row["least"], row["usual"]) == (known.help, known.least, SizeOptions.usual(name))
    assert (offered["top"]["type"], offered["slip_margin"]["type"], offered["radius"]["type"]) == (
        "whole",
        "number",
        "text",
    )
    assert rows["compare"][1]["choices"] == list(engine.ENGINES)


def test_what_a_page_states_becomes_arguments():
    stated = {
        "top": 3,
        "radius": "3 mm, 50 mm",
        "tries": "drives.a.screw.lead=2 mm, 5 mm, drives.a.belt.teeth=9",
        "ranges": "preload=1 kN..2 kN",
        "slip_margin": 1.2,
    }
    read = job_options(SizeOptions, {"options": stated})
    assert read == {
        **SizeOptions().arguments(),
        "top": 3,
        "radius": (3e-3, 50e-3),
        "tries": {"drives.a.screw.lead": "2 mm, 5 mm", "drives.a.belt.teeth": "9"},
        "ranges": {"preload": (1000.0, 2000.0)},
        "slip_margin": 1.2,
        "builds": 0,
    }
    usual = {"quick": False, "engine": "auto", "default_spreads": False}
    assert job_options(CompareOptions, {"options": {"quick": True}}) == {**usual, "quick": True}
    assert job_options(CompareOptions, {}) == usual


@pytest.mark.parametrize(
    "stated",
    [
        {"sets": "/etc/passwd"},
        {"builds": 10**9},
        {"top": 51},
        {"top": 0},
        {"top": True},
        {"generations": 101},
        {"seed": -1},
        {"seed": 10**12},
        {"slip_margin": 0.5},
        {"slip_margin": "2"},
        {"objective": 3},
        {"life": "1" * 1000},
        {"file": "x"},
        [],
    ],
)
def test_what_the_form_does_not_give_is_refused(stated):
    with pytest.raises(RefusedError):
        job_options(SizeOptions, {"options": stated})


@pytest.mark.slow
@pytest.mark.usefixtures("unrendered")
def test_results_keep_their_options_and_reports_state_them(tmp_path):
    tables = {"requirement": {"base": "faulring2006"}, "drives": {"mine": {"base": "faulring2006.motor1-gear1"}}}
    study = iv.Study.from_dict(tables, name="mine")
    found = iv.compare(study, quick=True, engine="numpy")
    assert found.options == CompareOptions(quick=True, engine="numpy")
    assert found == iv.compare(study, quick=True)
    assert "options" not in repr(found)
    iv.save(found, tmp_path)
    page = (tmp_path / "report.html").read_text("utf-8")
    assert "Options of infinivar compare" in page
    for name, known in CompareOptions.described().items():
        assert f"<td>{name.replace('_', ' ')}</td>" in page
        assert known.help in page

"""`infinivar sweep`: a search in chunks from the command line."""

import json
import re
from pathlib import Path

import pytest

import infinivar as iv
from small_catalogue import SLIDE, SLOW, slides


@pytest.fixture
def folder(tmp_path):
    return slides(tmp_path)


def sweep(infinivar, study, *options):
    return infinivar("sweep", "size", study, "--set", "shelf.toml", "--folder", "s", *options)


GRID = ("--radius", "8 mm", "16 mm", "--radii", "2", "--pairs", "7")


@pytest.mark.slow
def test_a_search_in_chunks_continues_shows_and_reports(infinivar, folder):
    done = sweep(infinivar, "slide.toml", *GRID, "--objective", "mass")
    assert (done.code, done.err) == (0, "")
    assert done.out.startswith("Least mass of 14 candidates (7 pairs with 2 radii each) of shelf: ")
    assert "finished; 14 candidates" in done.out
    again = sweep(infinivar, "slide.toml", *GRID, "--objective", "mass")
    assert again.code == 2
    assert "2 of 2 chunks done; continue with --resume" in again.err
    other = sweep(infinivar, "slide.toml", *GRID, "--objective", "energy", "--resume")
    assert other.code == 2
    assert "objective: mass there, energy here" in other.err

    for number in (0, 1):
        (folder / "s" / f"chunk-0000000{number}.parquet").write_bytes(b"")
    shown = infinivar("sweep", "show", "s")
    assert shown.code == 1
    assert shown.out.splitlines()[1].startswith(
        "Chunks 0 and 1 are damaged and do not count: the command of the sweep with --resume"
    )
    assert sweep(infinivar, "slide.toml", *GRID, "--objective", "mass", "--resume").code == 0
    (folder / "s" / "chunk-00000001.parquet").unlink()
    shown = infinivar("sweep", "show", "s")
    assert shown.code == 1
    assert "1 of 2 chunks done; 7 candidates" in shown.out
    resumed = sweep(infinivar, "slide.toml", *GRID, "--objective", "mass", "--resume", "--out", "out", "--json")
    assert resumed.code == 0
    report = json.loads(resumed.out)
    assert report["sweep"]["finished"]
    assert report["designs"][0]["parts"]["motor"]["part"].startswith("shelf:")
    assert (folder / "out" / "sizing.html").is_file()
    assert (folder / "out" / "design-01.toml").is_file()
    shown = infinivar("sweep", "show", "s", "--json", "--top", "2")
    assert shown.code == 0
    lists = json.loads(shown.out)["lists"]
    assert list(lists) == ["top"]
    assert [row["mass_kg"] for row in lists["top"]] == [one["mass_kg"] for one in report["designs"][:2]]
    text = infinivar("sweep", "show", "s").out
    assert re.search(r"^Best, \d+ designs:\n  1\. shelf:\w+; shelf:\w+; radius \d+ mm; .*; margin ", text, re.MULTILINE)
    assert "  motor peak torque: 12" in text  # two of the 14 state no mass
    assert not re.search(r"demand|_|[A-Z]{3}", text.partition("Best, ")[2])  # no names of columns


@pytest.mark.slow
def test_nothing_feasible_ends_with_code_1(infinivar, folder):
    done = sweep(infinivar, "heavy.toml", "--objective", "mass", "--radius", "7 mm", "9 mm", "--radii", "2")
    assert done.code == 1
    assert done.out.startswith("None of 14 candidates (7 pairs with 2 radii each) of shelf is feasible")


@pytest.mark.slow
def test_one_radius_is_no_range_of_radii(infinivar, folder):
    done = sweep(infinivar, "slide.toml", "--radius", "9 mm", "9 mm", "--radii", "5")
    said = (
        "radii: 5 radii need a range, but both ends of radius are 9 mm; leave out radii to search at this radius, or "
    )
    assert (done.code, done.err) == (2, f"infinivar: slide.toml: {said}state a wider range\n")
    assert not (folder / "s").exists()
    done = sweep(infinivar, "slide.toml", "--radius", "9 mm", "9 mm", "--objective", "mass")
    assert (done.code, done.err) == (0, "")
    assert done.out.startswith("Least mass of 7 pairs of shelf: ")


@pytest.mark.parametrize("kind", [("size",), ("cobotic", "--starts", "1")])
def test_a_report_goes_elsewhere_than_the_sweep(infinivar, folder, kind):
    done = infinivar("sweep", *kind, "slide.toml", "--set", "shelf.toml", "--folder", "s", "--out", "./s")
    said = "--out s: this is the folder of the sweep; state another one for the report"
    assert (done.code, done.err) == (2, f"infinivar: {said}\n")
    assert not (folder / "s").exists()


def test_an_interruption_tells_how_to_continue(infinivar, folder, monkeypatch):
    def interrupted(*arguments, **options):
        raise KeyboardInterrupt

    monkeypatch.setattr("infinivar.sweeps.sweep.sweep", interrupted)
    done = sweep(infinivar, "slide.toml")
    assert done.code == 130
    assert "s: stopped; the chunks that are done are kept: continue with --resume" in done.err


@pytest.mark.slow
def test_a_cluster_that_does_not_answer_is_named(infinivar, folder, monkeypatch):
    monkeypatch.setattr("infinivar.sweeps.workers._PATIENCE", 0.5)
    done = sweep(infinivar, "slide.toml", "--dask", "tcp://127.0.0.1:9")
    assert done.code == 2
    assert "no scheduler of a cluster answers at tcp://127.0.0.1:9" in done.err
    assert not (folder / "s").exists()


SPREADS = """
[uncertainty.geared.motor]
resistance = "5 %"
"""


@pytest.mark.slow
def test_samples_in_chunks(infinivar, folder):
    (folder / "spread.toml").write_text(SLIDE + SPREADS, "utf-8")
    command = ("sweep", "builds", "spread.toml", "--folder", "b", "--draws", "64", "--size", "32")
    done = infinivar(*command)
    assert (done.code, done.err) == (0, "")
    assert done.out.startswith("64 samples; no region is required\nshake: feasible in 0 % of samples; ")
    low, high = map(float, re.findall(r"(\S+) to (\S+) J per cycle", done.out)[0])
    study = iv.load_study(folder / "slide.toml")
    assert 0.99 * low <= iv.duty_cycle(study.drives["geared"], study.duty["shake"]).energy <= 1.01 * high < 1.05 * low
    report = json.loads(infinivar(*command, "--resume", "--json").out)
    assert report["builds"] == report["sweep"]["candidates"] == 64
    assert report["sweep"]["finished"]
    assert infinivar("sweep", "builds", "slide.toml", "--folder", "c").code == 2
    assert "64 candidates" in infinivar("sweep", "show", "b").out


@pytest.mark.slow
def test_indices_in_chunks(infinivar, folder):
    (folder / "spread.toml").write_text(SLIDE + SPREADS, "utf-8")
    command = (
        "sweep",
        "sensitivity",
        "spread.toml",
        "--of",
        "energy",
        "--samples",
        "16",
        "--size",
        "16",
        "--folder",
        "i",
    )
    done = infinivar(*command)
    assert (done.code, done.err) == (0, "")
    assert done.out.startswith("1. ")
    assert "of the variance" in done.out
    report = json.loads(infinivar(*command, "--resume", "--json").out)
    assert report["sweep"]["chunks"] == 1
    assert report["parameters"][0]["sobol_total"] > 0.0


@pytest.mark.slow
def test_starts_of_a_cobotic_search_are_reported(infinivar, tmp_path, monkeypatch):
    """Report and study files as of `size`; a sweep that is done is reported again without searching."""
    monkeypatch.setattr("infinivar.sizing.of_cobotic.POPULATION", 5)
    (tmp_path / "slow.toml").write_text(SLOW, "utf-8")
    text = Path(iv.load_study("knee_walking").path).read_text("utf-8")
    (tmp_path / "walk.toml").write_text(text[: text.index("[requirement]")] + text[text.index("[drives.") :], "utf-8")
    command = ("sweep", "cobotic", "walk.toml", "--set", "slow.toml", "--folder", "c", "--starts", "1", "--generations")
    options = ("2", "--objective", "energy", "--range", "preload=1.8 kN..2.6 kN", "--steering-ratios", "16")
    plain = infinivar(*command, *options)
    assert (plain.code, plain.err) == (0, "")

    def again(*arguments, **others):
        raise AssertionError("searched again")

    monkeypatch.setattr("infinivar.sweeps.cobotic.best_cobotic", again)
    done = infinivar(*command, *options, "--resume", "--out", "out")
    assert (done.code, done.err) == (0, "")
    assert done.out == f"{plain.out}Report: out/sizing.html\n"
    report = json.loads(infinivar(*command, *options, "--resume", "--out", "out", "--json").out)
    assert {Path(one).name for one in report["files"]} >= {"sizing.html", "sizing.json", "design-01.toml"}
    best = json.loads((tmp_path / "out" / "sizing.json").read_text("utf-8"))["designs"][0]
    assert best["power_W"] == report["lists"]["top"][0]["power_W"]


def test_a_study_without_a_cobotic_drive_has_no_such_sweep(infinivar, folder):
    done = infinivar("sweep", "cobotic", "slide.toml", "--starts", "2", "--folder", "c")
    assert done.code == 2
    assert "the study has no cobotic drive that can be a template: drives.geared is not one" in done.err


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--range", "preload=2 N..1 N"), "--range 'preload=2 N..1 N' must be a range above 0, the least first"),
        (("--range", "preload=1 N..2 N", "--range", "preload=1 N..3 N"), "--range names a value twice"),
        (("--steering-ratios", "8;9"), "--steering-ratios '8;9' must be numbers separated by commas"),
        (("--steering-ratios", "8,8"), "steering_ratios must be one ratio or several different ones"),
        (("--slip-margin", "0.9"), "slip-margin"),
        (("--life", "5 mm"), "--life '5 mm'"),
    ],
)
def test_options_of_cobotic_sweeps_are_those_of_size(infinivar, tmp_path, options, message):
    done = infinivar("sweep", "cobotic", "knee_walking", "--starts", "2", "--folder", "c", *options)
    assert done.code == 2
    assert message in done.err
    assert not (tmp_path / "c").exists()

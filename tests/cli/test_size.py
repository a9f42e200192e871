"""`infinivar size`: what it prints and writes, and that its study files run in the other commands."""

import json
import math
import re
from pathlib import Path

import pytest

import infinivar as iv
from folders import results
from pages import Links, pages
from small_catalogue import SHELF, SLIDE, slides


@pytest.fixture
def folder(tmp_path):
    return slides(tmp_path)


@pytest.mark.slow
def test_winners_run_in_the_other_commands(infinivar, folder):
    done = infinivar(
        "size", "slide.toml", "--set", "shelf.toml", "--top", "2", "--objective", "mass, energy", "--out", "out"
    )
    assert (done.code, done.err) == (0, "")
    lines = done.out.splitlines()
    assert lines[0].startswith("Least mass of 7 pairs of shelf: ")
    assert re.match(r"mean power +[\d.]+ W$", lines[3])
    assert lines[lines.index("") + 1].split() == ["geared"]
    table = next(place for place, line in enumerate(lines) if line.startswith("Least mass  "))
    assert lines[table + 1].startswith("design-01 ")
    assert any(line.startswith("What this verdict hangs on") for line in lines[table:])
    assert max(map(len, lines[1 : table + 3])) <= 100
    assert re.search(
        r"^Template geared: 7 pairs, pulley radius 1\.6 to 40 mm; \d left by closed forms, ", done.out, re.MULTILINE
    )
    assert "as its data sheets state no value: motor peak torque" in done.out
    files = results(folder / "out")
    assert {"sizing.html", "sizing.json", "design-01.toml", "design-02.toml", "front-01.toml", "motion-shake.csv"} <= {
        *files
    }

    stated = json.loads((folder / "out" / "sizing.json").read_text("utf-8"))
    compared = infinivar("compare", "out/front-01.toml", "--quick", "--json")
    assert compared.code == 0
    drawn = json.loads(compared.out)["duty"]["shake"]["drives"]["geared"]["power_from_supply_net_W"]
    assert drawn == pytest.approx(stated["front"][0]["power_W"], rel=1e-9)
    run = infinivar("simulate", "out/front-01.toml", "--scenario", "shake", "--out", "run", "--json")
    assert run.code == 0, run.out + run.err

    page = (folder / "out" / "sizing.html").read_text("utf-8")
    links = Links(page)
    assert not links.scripts
    assert not links.open
    assert all(one.startswith("data:") for one in links.fetched)
    assert not pages(folder / "out")["sizing.html"].loose
    named = set(re.findall(r'href="([a-z]+-\d+\.toml)"', page))
    assert named == {name for name in files if re.fullmatch(r"(design|front)-\d+\.toml", name)}
    assert "Made Up 10" in page
    assert "data sheet 7" in page


@pytest.mark.slow
def test_values_to_try_have_a_table(infinivar, folder):
    path = "drives.geared.output_inertia"
    tries = ("--try", f"{path}=50 g cm^2, 0.4 g m^2", "--try", "drives.geared.motor.scale=1,2")
    done = infinivar("size", "slide.toml", "--set", "shelf.toml", "--builds", "0", *tries, "--out", "out")
    assert (done.code, done.err) == (0, "")
    lines = done.out.splitlines()
    assert "28 candidates (7 pairs with 4 combinations of values each) of shelf" in lines[0]
    for head, values in (
        ("Output inertia", ("5e-6 kg m^2", "0.0004 kg m^2")),
        ("Motors on one shaft", ("1", "2")),
    ):
        place = next(place for place, line in enumerate(lines) if line.startswith(head))
        assert lines[place].removeprefix(head).split()[:3] == ["power", "mass", "margin"]
        assert all(line.startswith(value) for line, value in zip(lines[place + 1 :], values, strict=False))
        assert lines[place + 3].startswith("  best ")
    assert "  best with a single motor" in lines
    assert "output inertia of the best design is at an end of the values tried" in done.out
    page = (folder / "out" / "sizing.html").read_text("utf-8")
    assert "Best design at each output inertia" in page
    stated = json.loads((folder / "out" / "sizing.json").read_text("utf-8"))["searches"]["geared"]["tried"]
    assert (stated[0]["path"], stated[0]["value"]) == ("output_inertia", pytest.approx(5e-6))
    assert "search over parts, tried: " in (folder / "out" / "design-01.toml").read_text("utf-8")


@pytest.mark.slow
def test_margins_of_many_designs_are_in_tables_that_fit_a_page(infinivar, folder):
    """At most eight designs beside each other, each margin under the name of its design, and what was not checked once."""
    lines = (f"[gearheads.q{k}]\nratio = {8 + 0.5 * k}\nefficiency = 0.8\nmass = '90 g'\n" for k in range(13))
    motor = SHELF[SHELF.index("[motors.c]") :].split("\n[", 1)[0]
    rated = "[gearheads.rated]\nratio = 9\nefficiency = 0.8\ncontinuous_torque = '9 N m'\nmass = '90 g'\n"
    (folder / "one.toml").write_text(f"{motor}\n{''.join(lines)}{rated}", "utf-8")
    done = infinivar("size", "slide.toml", "--set", "one.toml", "--objective", "mass", "--out", "out", "--json")
    assert done.code == 0, done.err
    designs = json.loads(done.out)["designs"]
    assert len(designs) == 14
    section = (folder / "out" / "sizing.html").read_text("utf-8").partition("<h3>Margins")[2].partition("<h2>")[0]
    shown = {}
    for table in section.split("<table")[1:]:
        _, heading, *rows = table.split("<tr>")
        names = re.findall(r'<th scope="col" class="number">(.*?)</th>', heading)
        assert len(names) <= 8
        for row in rows:
            (limit,) = re.findall(r"<td>(.*?)</td>", row)
            cells = re.findall(r'<td class="number" data-label="(.*?)">(.*?)</td>', row)
            assert [name for name, _ in cells] == names
            shown |= {(name, limit): text for name, text in cells}
    assert {name for name, _ in shown} == {f"design-{place:02d}" for place in range(1, 15)}
    for place, design in enumerate(designs, 1):
        margin = shown[f"design-{place:02d}", design["tightest"]]
        assert float(margin) == pytest.approx(design["margin"], rel=5e-3)
    own = next(place for place, one in enumerate(designs, 1) if one["parts"]["gearhead"]["part"].endswith("rated"))
    assert {name for (name, limit), text in shown.items() if "gearhead continuous" in limit and text != "–"} == {
        f"design-{own:02d}"
    }
    unchecked = section.partition("Not stated, not checked: ")[2].partition(".</p>")[0].split("; ")
    assert "motor peak torque" in unchecked
    (others,) = [words for words in unchecked if words.startswith("gearhead continuous torque (")]
    assert others.count("design-") == 13
    assert f"design-{own:02d}" not in others


@pytest.mark.slow
def test_no_feasible_design(infinivar, folder):
    (folder / "shelf.toml").write_text(SHELF.replace('resistance = "2 ohm"', 'resistance = "-2 ohm"'), "utf-8")
    done = infinivar("size", "heavy.toml", "--set", "shelf.toml", "--out", "out")
    assert done.code == 1
    assert "resistance" in done.err  # the row that was refused
    assert results(folder / "out") == ["sizing.html", "sizing.json"]
    found = json.loads((folder / "out" / "sizing.json").read_text("utf-8"))
    assert not found["feasible"]
    assert not found["designs"]
    search = found["searches"]["geared"]
    assert sum(one["first"] for one in search["limits"]) == 5
    ruling = re.findall(r"^  (.+), \S+: rules out (\d+) of (\d+) on its own", done.out, re.MULTILINE)
    counted = [one for one in search["limits"] if one["exceeded"] or one["first"]]
    assert [tuple(map(int, one[1:])) for one in ruling] == [(one["exceeded"], one["checked"]) for one in counted]
    assert min(one["first"] for one in counted) == 0
    assert ", none in addition to the limits above" in done.out
    nearest = search["nearest"]
    assert nearest["margin"] < 1.0
    assert done.out.startswith(f"None of 5 pairs of shelf is feasible; nearest miss: {nearest['title']}, ")
    (searched,) = found["sets"]
    assert searched["pairs"] == 5
    assert any("resistance" in one for one in searched["refused"])
    assert "times the allowance" in found["verdict"]
    assert re.search(r"^  nearest miss: .*margin 0\.", done.out, re.MULTILINE)
    page = (folder / "out" / "sizing.html").read_text("utf-8")
    assert found["verdict"][1:] in page
    assert "all else stays as it is, and a search" in page  # there is no winner to speak of


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (
            ("--objective", "speed"),
            "--objective 'speed' must be energy, mass, space or price, or energy and mass together",
        ),
        (("--objective", "mass,mass"), "--objective 'mass,mass' must be"),
        (("--radius", "5 mm", "2 mm"), "--radius '5 mm' '2 mm' must be a range above 0"),
        (("--radius", "5 s", "2 mm"), "--radius '5 s'"),
        (("--set", "nosuch"), "slide.toml: 'nosuch' is not a set of parts"),
        (("--drive", "gears"), "slide.toml: the study has no drive 'gears'"),
        (("--range", "preload"), "--range 'preload' must be NAME=LOW..HIGH"),
        (("--range", "preloads=1 N..2 N"), "'preloads' is not searched (did you mean 'preload'?)"),
        (("--range", "preload=2 N..1 N"), "--range 'preload=2 N..1 N' must be a range above 0"),
        (("--range", "preload=2 mm..3 N"), "--range preload '2 mm'"),
        (
            ("--range", "preload=1 N..2 N"),
            "slide.toml: ranges: for cobotic drives only; no cobotic drive is searched",
        ),
        (("--slip-margin", "1.1"), "slip_margin: for cobotic drives only"),
        (("--life", "5 h", "--seed", "0"), "life, seed: for cobotic drives only"),
        (("--generations", "40"), "generations: for cobotic drives only"),
        (("--try", "drives.geared"), "--try 'drives.geared' must be PATH=VALUES"),
        (("--try", "drives.geared.pulley.radius=5 mm"), "pulley.radius: the search itself chooses it, as radius says"),
        (("--try", "drives.geared.output_inertia=1 g"), "output_inertia = '1 g' has the unit 'g' where"),
        (("--steering-ratios", "8;9"), "--steering-ratios '8;9' must be numbers separated by commas"),
        (("--life", "5 mm"), "--life '5 mm'"),
    ],
)
def test_bad_options_exit_with_2(infinivar, folder, options, message):
    done = infinivar("size", "slide.toml", *options)
    assert done.code == 2
    assert message in done.err
    assert done.err.count("\n") == 1
    assert not (folder / "out").exists()


@pytest.mark.slow
def test_a_recording_is_named_from_the_new_folder(infinivar, folder):
    rows = "\n".join(f"{0.01 * k},{0.03 * (1 - math.cos(2 * math.pi * k / 100))}" for k in range(100))
    (folder / "made").mkdir()
    (folder / "made" / "log.csv").write_text(f"time [s],position [m]\n{rows}\n", "utf-8")
    text = SLIDE[: SLIDE.index("[duty.shake]")] + '[duty.log]\nshape = "file"\nfile = "log.csv"\nload_mass = "3 kg"\n'
    (folder / "made" / "log.toml").write_text(text, "utf-8")
    done = infinivar(
        "size", "made/log.toml", "--set", "shelf.toml", "--top", "1", "--objective", "energy", "--out", "far/out"
    )
    assert done.code == 0, done.err
    study = iv.load_study(folder / "far" / "out" / "design-01.toml")
    assert study.duty["log"].motion == iv.load_study(folder / "made" / "log.toml").duty["log"].motion
    assert 'file = "motion-log.csv"' in (folder / "far" / "out" / "design-01.toml").read_text("utf-8")


LOGGED = SLIDE[: SLIDE.index("[duty.shake]")] + '[duty.log]\nshape = "file"\nfile = "{}"\nload_mass = "3 kg"\n'


@pytest.mark.slow
@pytest.mark.parametrize(
    ("files", "options", "said"),
    [
        ({"design-01.toml": SLIDE}, ("design-01.toml",), "design-01.toml: is the study itself"),
        ({"best-geared.toml": SLIDE}, ("best-geared.toml",), "best-geared.toml: is the study itself"),
        (
            {"front-02.toml": SLIDE, "over.toml": 'extends = "front-02.toml"\n'},
            ("over.toml",),
            "front-02.toml: is a study that it extends",
        ),
        ({"design-07.toml": SHELF}, ("slide.toml", "--set", "design-07.toml"), "design-07.toml: is a set of parts"),
        (
            {"design-07.toml": SHELF, "named.toml": 'parts = "design-07.toml"\n' + SLIDE},
            ("named.toml", "--set", "shelf.toml"),
            "design-07.toml: is a set of parts",
        ),
        ({"motion-log.csv": "", "log.toml": LOGGED.format("motion-log.csv")}, ("log.toml",), "is a recording"),
        (
            {"old.toml": SLIDE, ".infinivar.json": '{"size": ["old.toml"]}'},
            ("old.toml",),
            "old.toml: is the study itself",
        ),
    ],
)
def test_no_input_is_replaced(infinivar, folder, files, options, said):
    rows = "\n".join(f"{0.01 * k},{0.03 * (1 - math.cos(2 * math.pi * k / 100))}" for k in range(100))
    for name, content in files.items():
        (folder / name).write_text(content or f"time [s],position [m]\n{rows}\n", "utf-8")
    before = {file.name: file.read_bytes() for file in folder.iterdir()}
    for command in (("size",), ("sweep", "size", "--folder", "s")):
        done = infinivar(*command, *options, "--out", ".")
        assert done.code == 2
        assert said in done.err
        assert "the results in . would replace it; choose another folder" in done.err
        assert done.err.count("\n") == 1
        assert {file.name: file.read_bytes() for file in folder.iterdir()} == before
    if "design-01.toml" in files:
        (folder / "far").mkdir()
        (folder / "far" / "design-01.toml").symlink_to(folder / "slide.toml")
        assert infinivar("size", "far/design-01.toml", "--out", "far").code == 2
        (folder / "link.toml").symlink_to(folder / "design-01.toml")
        assert infinivar("size", "link.toml", "--out", ".").code == 2
        found = iv.size(iv.load_study(folder / "design-01.toml"), sets=str(folder / "shelf.toml"), top=1)
        with pytest.raises(iv.InputError, match="is the study itself"):
            iv.save(found, folder)
        assert (folder / "design-01.toml").read_bytes() == before["design-01.toml"]


@pytest.mark.slow
def test_both_architectures(infinivar, folder):
    """Winners of both kinds run in the other commands, and the report sets them side by side."""
    options = ("--generations", "4", "--steering-ratios", "16", "--range", "wheel_radius=18 mm..3 cm", "--top", "2")
    slow = SHELF[: SHELF.index("[pairs]")].replace("ratio = 35", "ratio = 60")
    (folder / "shelf.toml").write_text(slow, "utf-8")
    text = (Path(__file__).parents[2] / "studies" / "knee_walking.toml").read_text("utf-8")
    walking = text[: text.index("[requirement]")] + text[text.index("[drives.cobotic]") :]
    (folder / "walking.toml").write_text(walking, "utf-8")
    done = infinivar("size", "walking.toml", "--set", "shelf.toml", *options, "--out", "out")
    assert done.code == 0, done.err
    assert ["geared", "cobotic"] in [line.split() for line in done.out.splitlines()[:5]]
    assert re.search(r"^study file +best-geared\.toml +best-cobotic\.toml$", done.out, re.MULTILINE)
    assert "What would have to change for geared to win" in done.out
    assert "wheel radius 18 to 30 mm" in done.out
    files = results(folder / "out")
    assert {"best-geared.toml", "best-cobotic.toml", "design-01.toml", "motion-walking.csv"} <= {*files}
    stated = json.loads((folder / "out" / "sizing.json").read_text("utf-8"))
    for name in ("geared", "cobotic"):
        compared = infinivar("compare", f"out/best-{name}.toml", "--quick", "--json")
        assert compared.code == 0
        found = json.loads(compared.out)
        drawn = found["duty"]["walking"]["drives"][name]["power_from_supply_net_W"]
        assert drawn == pytest.approx(stated["best_of"][name]["power_W"], rel=1e-9)
    run = infinivar("simulate", "out/best-cobotic.toml", "--scenario", "walking", "--out", "run", "--json")
    assert run.code == 0, run.out + run.err
    page = (folder / "out" / "sizing.html").read_text("utf-8")
    links = Links(page)
    assert not links.open
    assert not pages(folder / "out")["sizing.html"].loose
    named = set(re.findall(r'href="([a-z]+-[a-z0-9]+\.toml)"', page))
    assert named == {name for name in files if name.endswith(".toml")}
    assert "side by side" in page
    assert "all else stays as it is, the winner too, and a search" in page
    power = stated["best_of"]["cobotic"]["power_W"]
    assert f"<td>{float(f'{power:.3g}'):g}\xa0W</td>" in page  # three significant digits
    assert "axle bearing" in page
    chosen = [*stated["designs"], *stated["front"], *stated["best_of"].values()]
    roles = {role for one in chosen for role in one["parts"]}
    assert ("of the template" in page) == bool(roles - {*stated["best_of"]["cobotic"]["parts"]})
    assert stated["what_if"]["geared"]["goal"] == "energy"


@pytest.mark.slow
def test_counts_in_words(infinivar, folder):
    """One motor is no "motors"; thousands are separated; what is not there has no heading."""
    gear = "[gearheads.q{}]\nratio = {}\nefficiency = 0.8\nmass = '90 g'\n"
    lines = (gear.format(k, 8 + 0.1 * k if k < 5 else 1e4) for k in range(1200))  # the others turn the motor too fast
    motor = SHELF[SHELF.index("[motors.c]") :].split("\n[", 1)[0]
    (folder / "one.toml").write_text(f"{motor}\n{''.join(lines)}", "utf-8")
    done = infinivar("size", "slide.toml", "--set", "one.toml", "--top", "2", "--objective", "mass", "--out", "out")
    assert done.code == 0, done.err
    assert done.out.startswith("Least mass of 1,200 pairs of one: ")
    assert "Template geared: 1,200 pairs, " in done.out
    page = (folder / "out" / "sizing.html").read_text("utf-8")
    assert "one: 1 motor, 1,200 gearheads, 1,200 pairs." in page
    assert "<p>1,200 pairs, pulley radius " in page
    assert "Parts of the designs above" in page
    best = page[page.index('<div class="headline">') :].split("</div>")[0]
    assert "<li>motor: c</li><li>gearhead: q" in best
    assert "<li>pulley radius: " in best
    row = page[page.index("<h2>Designs of least mass</h2>") :].split("<tr>")[1]
    headings = re.findall(r"<th[^>]*>([^<]*)</th>", row)
    assert headings == ["study file", "mean power", "mass", "margin", "tightest limit", "parts", "free values"]

    (folder / "one.toml").write_text(f"{motor}\n[gearheads.q]\nratio = 8\nefficiency = 0.8\n", "utf-8")
    done = infinivar("size", "heavy.toml", "--set", "one.toml", "--objective", "energy", "--out", "none")
    assert done.code == 1
    assert done.out.startswith("None of 1 pair of one is feasible; ")
    page = (folder / "none" / "sizing.html").read_text("utf-8")
    assert "one: 1 motor, 1 gearhead, 1 pair." in page
    assert "<p>1 pair, pulley radius " in page
    assert "Parts of the designs" not in page

"""What a motion takes of a drive, as C for its controller: compiled, it gives what the program gives, in double and in float."""

import ctypes
import re
import subprocess

import numpy as np
import pytest

import infinivar as iv
from infinivar.motion import Course
from internals import compiler, law_files, laws
from made import loaded

DRIVES = [
    (study, name)
    for study in ("hand_controller", "knee_walking", "ankle_walking", "reach_and_hold")
    for name in loaded(study).drives
]
STRICT = ["-std=c99", "-O1", "-Wall", "-Wextra", "-Werror", "-Wconversion", "-pedantic"]

pytestmark = pytest.mark.skipif(compiler() is None, reason="no C compiler: the program then writes sources only")


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    def write(study, name):
        folder = tmp_path_factory.mktemp(name)
        files = law_files(loaded(study).drives[name], re.sub(r"\W", "_", name))
        for file, text in files.items():
            (folder / file).write_text(text, "utf-8")
        return folder, next(iter(files)).removesuffix(".h")

    return write


def built(folder, real, *options):
    done = subprocess.run(
        [*compiler(), *STRICT, f"-DREAL={real}", *options, "-lm"], cwd=folder, capture_output=True, text=True
    )
    assert not done.returncode, done.stderr


@pytest.mark.slow
@pytest.mark.parametrize(("study", "name"), DRIVES)
@pytest.mark.parametrize("real", ["double", "float"])
def test_the_test_that_comes_with_it_passes(written, study, name, real):
    """Strict C99; 1e-9 of the largest value in double, 1e-3 in float, at 24 instants of a motion."""
    folder, base = written(study, name)
    built(folder, real, f"{base}.c", f"{base}_test.c", "-o", "compared")
    done = subprocess.run(["./compared"], cwd=folder, capture_output=True, text=True)
    assert not done.returncode, done.stdout


def test_the_test_that_comes_with_it_can_fail(written):
    folder, base = written("hand_controller", "motor1-gear1")
    text = (folder / f"{base}_test.c").read_text("utf-8")
    (line,) = [one for one in text.split("\n") if one.startswith("static const double steady_y")]
    begin = text.index("{", text.index(line) + len(line))
    (folder / "wrong.c").write_text(text[: begin + 1] + "1.5 + " + text[begin + 1 :], "utf-8")
    built(folder, "double", f"{base}.c", "wrong.c", "-o", "wrong")
    assert subprocess.run(["./wrong"], cwd=folder, capture_output=True).returncode == 1


@pytest.mark.parametrize(("study", "name"), [("hand_controller", "cobotic"), ("ankle_walking", "geared-series")])
def test_random_points_in_all_quadrants_are_those_of_the_program(written, study, name):
    """Beyond limits and slip as well, where both are nan; the last digits may differ by the library's functions."""
    folder, base = written(study, name)
    built(folder, "double", "-shared", "-fPIC", f"{base}.c", "-o", "laws.so")
    library, drive = ctypes.CDLL(str(folder / "laws.so")), loaded(study).drives[name]
    random = np.random.default_rng(5)
    for law in laws(drive):
        count = 300
        given = {one: 10.0 ** random.uniform(-2.0, 1.5) * random.standard_normal(count) for one in law.inputs}
        given |= {"position": random.uniform(-0.3, 0.3, count)}
        given |= {"load_mass": np.asarray(2.0)} if "load_mass" in law.inputs else {}
        given["speed"][:20] = 0.0
        wanted = {key: np.broadcast_to(value, count) for key, value in law.evaluate(**given).items()}
        found = np.empty((count, len(wanted)))
        function = getattr(library, f"{base}_{law.name}")
        for bad in (np.nan, np.inf, -np.inf):
            u, y = np.full(len(law.inputs), bad), np.zeros(len(wanted))
            u[1:] = 0.0
            function(u.ctypes.data_as(ctypes.c_void_p), y.ctypes.data_as(ctypes.c_void_p))
            assert np.isnan(y).all()
        for place in range(count):
            row = np.array([float(np.broadcast_to(given[one], count)[place]) for one in law.inputs])
            function(row.ctypes.data_as(ctypes.c_void_p), found[place].ctypes.data_as(ctypes.c_void_p))
        for column, (key, value) in enumerate(wanted.items()):
            scale = np.nanmax(np.abs(value[np.isfinite(value)]), initial=1e-9)
            np.testing.assert_allclose(
                found[:, column], value, rtol=1e-9, atol=1e-12 * scale, err_msg=f"{law.name} {key}"
            )


def test_the_laws_of_two_drives_go_into_one_program(written, tmp_path):
    for name in ("cobotic", "motor1-gear1"):
        folder, base = written("hand_controller", name)
        for end in (".h", ".c"):
            (tmp_path / f"{base}{end}").write_text((folder / f"{base}{end}").read_text("utf-8"), "utf-8")
    calls = "cobotic_steady(u, y); motor1_gear1_steady(u, y);"
    text = f'#include "cobotic.h"\n#include "motor1_gear1.h"\nint main(void) {{ real u[9] = {{0}}, y[99]; {calls} return 0; }}\n'
    (tmp_path / "both.c").write_text(text, "utf-8")
    built(tmp_path, "float", "both.c", "cobotic.c", "motor1_gear1.c", "-o", "both")
    assert subprocess.run(["./both"], cwd=tmp_path).returncode == 0


def test_the_same_drive_gives_the_same_bytes():
    one, other = (law_files(loaded("hand_controller").drives["cobotic"], "cobotic") for _ in range(2))
    assert one == other
    assert "malloc" not in one["cobotic.c"]


def test_feed_forward_of_the_header_is_in_its_units(written):
    """About a joint, speeds are in rad/s and the load in kg m^2."""
    ankle, _ = written("ankle_walking", "geared")
    header = (ankle / "geared.h").read_text("utf-8")
    assert "GEARED_FOLLOW_SPEED, /* rad/s */" in header
    assert "GEARED_FOLLOW_FORCE, /* N m */" in header
    assert "GEARED_FOLLOW_FORCE_RATE, /* N m/s */" in header
    assert "GEARED_FOLLOW_LOAD_MASS, /* kg m^2 */" in header
    course = Course(speed=0.1, acceleration=0.0, position=0.0)
    assert set(iv.load_study("ankle_walking").drives["geared"].follow(course).states) >= {"motor_current_A"}

"""Shared by all tests: the shipped study, loaded once, and hypothesis settings."""

import atexit
import gc
import os
import shutil
import tempfile
from pathlib import Path

import hypothesis
import hypothesis.strategies
import pytest

import infinivar as iv
import made
from rendering import rendered
from sampled import MOST
from small_catalogue import SHELF

# Workers that run on all cores have one thread each; NumPy is not imported yet.
os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
# Tests run on all processors already.
os.environ.setdefault("INFINIVAR_PROCESSES", "1")
# Compilation is most of the time of a test with JAX, and values equal to rounding need no optimised code. Before a release, CI
# runs with JAX_DISABLE_MOST_OPTIMIZATIONS=0: the code that users get.
os.environ.setdefault("JAX_DISABLE_MOST_OPTIMIZATIONS", "1")
# Equations that tests derive stay out of the user's cache; the workers of one run derive each model once.
if "INFINIVAR_TESTS_CACHE" not in os.environ:
    os.environ["INFINIVAR_TESTS_CACHE"] = tempfile.mkdtemp(prefix="infinivar-tests-")
    atexit.register(shutil.rmtree, os.environ["INFINIVAR_TESTS_CACHE"], ignore_errors=True)
# zig's own libraries of each platform, which it builds once, for minutes.
os.environ.setdefault(
    "ZIG_GLOBAL_CACHE_DIR", str(Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache")) / "zig")
)
os.environ["XDG_CACHE_HOME"] = os.environ["INFINIVAR_TESTS_CACHE"]
# Sets of parts of whoever runs the tests must not matter.
os.environ["INFINIVAR_PARTS"] = str(Path(os.environ["INFINIVAR_TESTS_CACHE"]) / "parts")

ROOT = Path(__file__).parents[1]
STUDY = ROOT / "studies" / "hand_controller.toml"

# Each example evaluates hundreds of points; a fixed seed keeps a failure of one machine a failure of all.
hypothesis.settings.register_profile("project", max_examples=MOST, deadline=None, derandomize=True)
hypothesis.settings.register_profile("everyday", hypothesis.settings.get_profile("project"), max_examples=12)


def pytest_configure(config):
    """Fewer examples of each property in the everyday run; all of them in other runs.

    What `made` keeps lies in pytest's cache, which outlives the run, or with the equations where there is none.
    """
    if made.PLACE not in os.environ:
        cache = getattr(config, "cache", None)
        place = cache.mkdir("made") if cache is not None else Path(os.environ["INFINIVAR_TESTS_CACHE"]) / "made"
        os.environ[made.PLACE] = str(place)
    hypothesis.settings.load_profile("everyday" if "not slow" in config.option.markexpr else "project")


LONG = (
    "cli/test_duty.py",
    "cli/test_compare.py",
    "cli/test_reproduce.py",
    "unit/test_results.py",
    "cli/test_calibrate.py",
    "unit/test_calibration_laws.py",
    "unit/test_calibration.py",
)
"""Files that take longest. They come first, so that no worker is left alone with one at the end."""


def _file(nodeid):
    return nodeid.partition("::")[0].removeprefix("tests/")


def pytest_collection_modifyitems(items):
    items.sort(key=lambda item: LONG.index(_file(item.nodeid)) if _file(item.nodeid) in LONG else len(LONG))


def pytest_collection_finish():
    """Thousands of collected tests live as long as the run: who looks for garbage need not go through them each time."""
    # Hypothesis makes its own random numbers with its first example, and must see who refers to them.
    hypothesis.find(hypothesis.strategies.none(), lambda _: True)
    gc.collect()
    gc.freeze()
    gc.set_threshold(50_000, 20, 50)


@pytest.fixture(scope="session")
def study():
    return made.loaded(STUDY)


@pytest.fixture
def load(tmp_path):
    """Write a study as mine.toml into the test's folder and load it."""

    def write_and_load(text):
        path = tmp_path / "mine.toml"
        path.write_text(text, "utf-8")
        return iv.load_study(path)

    return write_and_load


@pytest.fixture(scope="session")
def shelf(tmp_path_factory):
    """A set of made-up parts, as a file."""
    path = tmp_path_factory.mktemp("sets") / "shelf.toml"
    path.write_text(SHELF, "utf-8")
    return path


@pytest.fixture
def unrendered():
    """Figures are drawn, but their files are blank: rendering takes most of the time."""
    with rendered(()):
        yield


@pytest.fixture(scope="session")
def element(study):
    return study.drives["cobotic"].transmission


@pytest.fixture(scope="session")
def comparison():
    return made.made("compare", "hand_controller")

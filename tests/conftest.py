"""Shared by all tests: the shipped study, loaded once, and hypothesis settings."""

import atexit
import os
import shutil
import tempfile
from pathlib import Path

import hypothesis
import pytest

import infinivar as iv

# Workers that run on all cores have one thread each; NumPy is not imported yet.
os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
# Compilation is most of the time of a test with JAX, and values equal to rounding need no optimised code. The slow tests run
# in CI with JAX_DISABLE_MOST_OPTIMIZATIONS=0: the code that users get.
os.environ.setdefault("JAX_DISABLE_MOST_OPTIMIZATIONS", "1")
# Equations that tests derive stay out of the user's cache; the workers of one run derive each model once.
if "INFINIVAR_TESTS_CACHE" not in os.environ:
    os.environ["INFINIVAR_TESTS_CACHE"] = tempfile.mkdtemp(prefix="infinivar-tests-")
    atexit.register(shutil.rmtree, os.environ["INFINIVAR_TESTS_CACHE"], ignore_errors=True)
os.environ["XDG_CACHE_HOME"] = os.environ["INFINIVAR_TESTS_CACHE"]

ROOT = Path(__file__).parents[1]
STUDY = ROOT / "studies" / "hand_controller.toml"

# Each example evaluates hundreds of points; a fixed seed keeps a failure of one machine a failure of all.
hypothesis.settings.register_profile("project", max_examples=40, deadline=None, derandomize=True)
hypothesis.settings.load_profile("project")


SHARED = {"test_compare.py", "test_duty.py", "test_pages.py", "test_reproduce.py"}
"""Files of tests/cli that read the same results of slow commands."""


@pytest.hookimpl(tryfirst=True)  # before xdist reads the groups
def pytest_collection_modifyitems(items):
    """Each file goes to one worker, whose fixtures it shares; files that read the same results of commands go together."""
    for item in items:
        file = item.path.relative_to(ROOT / "tests")
        shared = file.parent.name == "cli" and file.name in SHARED
        item.add_marker(pytest.mark.xdist_group("shared results" if shared else file.as_posix()))


@pytest.fixture(scope="session")
def study():
    return iv.load_study(STUDY)


@pytest.fixture(scope="session")
def element(study):
    return study.drives["cobotic"].transmission


@pytest.fixture(scope="session")
def comparison(study):
    return iv.compare(study)

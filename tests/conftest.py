"""Shared by all tests: the shipped study, loaded once, and hypothesis settings."""

import os
import tempfile
from pathlib import Path

import hypothesis
import pytest

import infinivar as iv

# Workers that run on all cores have one thread each; NumPy is not imported yet.
os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
# Equations that tests derive stay out of the user's cache.
os.environ["XDG_CACHE_HOME"] = tempfile.mkdtemp(prefix="infinivar-tests-")

ROOT = Path(__file__).parents[1]
STUDY = ROOT / "studies" / "hand_controller.toml"

# Each example evaluates hundreds of points; a fixed seed keeps a failure of one machine a failure of all.
hypothesis.settings.register_profile("project", max_examples=40, deadline=None, derandomize=True)
hypothesis.settings.load_profile("project")


@pytest.fixture(scope="session")
def study():
    return iv.load_study(STUDY)


@pytest.fixture(scope="session")
def element(study):
    return study.drives["cobotic"].transmission


@pytest.fixture(scope="session")
def comparison(study):
    return iv.compare(study)

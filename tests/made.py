"""Results that are made once and looked at many times, by all workers and, while nothing changes, by later runs.

``made("compare", "knee_walking")`` is a result of a shipped study, ``made_run("compare", "knee_walking")`` what a command
printed and wrote, and ``@kept`` keeps what any function returns. Kept is what can be pickled, under a hash of the program, the
studies, these helpers, the function's file and the versions of Python and of all libraries: a change of any makes all anew. A
lock keeps two workers from making the same. Nobody may write into a folder of a run.
"""

import functools
import hashlib
import importlib.metadata
import inspect
import os
import pickle
import platform
import shutil
import sys
from pathlib import Path

import filelock
import pytest

import infinivar as iv

ROOT = Path(__file__).parents[1]
PLACE = "INFINIVAR_TESTS_MADE"
"""Environment variable: the folder, which `conftest` chooses unless it is set."""
RECENT = 3
"""Hashes whose results stay, for whoever goes to and fro between branches."""
SETTINGS = ("JAX_DISABLE_MOST_OPTIMIZATIONS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS")


def sources():
    """Files that results depend on."""
    package = Path(iv.__file__).parent
    yield from sorted(path for path in package.rglob("*") if path.is_file() and path.suffix != ".pyc")
    yield from sorted(path for path in (ROOT / "studies").rglob("*") if path.is_file())
    helpers = (path for path in (ROOT / "tests").rglob("*") if path.suffix in (".py", ".pyi"))
    yield from sorted(path for path in helpers if not path.name.startswith("test_"))


def named(known):
    """A short name of a hash. It has letters only, so that a path that a command prints holds no number."""
    return known.hexdigest()[:24].translate(str.maketrans("0123456789", "ghijklmnop"))


@functools.cache
def fingerprint():
    """Hash of all that every result depends on."""
    libraries = sorted(f"{one.name} {one.version}" for one in importlib.metadata.distributions())
    settings = [f"{name}={os.environ.get(name)}" for name in SETTINGS]
    known = hashlib.sha256("\n".join([sys.version, platform.platform(), *libraries, *settings]).encode())
    for path in sources():
        known.update(f"\n{path} {path.stat().st_size}\n".encode())
        known.update(path.read_bytes())
    return named(known)


@functools.cache
def folder():
    """Folder of what is kept under the present hash; older ones go."""
    place = Path(os.environ[PLACE])
    own = place / fingerprint()
    own.mkdir(parents=True, exist_ok=True)
    own.touch()
    others = sorted((path for path in place.iterdir() if path != own), key=lambda path: path.stat().st_mtime)
    for path in others[: -RECENT + 1]:
        shutil.rmtree(path, ignore_errors=True)
    return own


def kept(function):
    """What a function returns for its arguments, made once: the decorator of functions of simple arguments."""
    file = Path(inspect.getfile(function))

    @functools.cache
    def once(*arguments, **options):
        identity = repr((file.stem, function.__qualname__, arguments, sorted(options.items()), file.read_bytes()))
        path = folder() / f"{function.__name__}-{named(hashlib.sha256(identity.encode()))}"
        with filelock.FileLock(f"{path}.lock"):
            if path.exists():
                return pickle.loads(path.read_bytes())
            found = function(*arguments, **options)
            part = path.with_suffix(".part")
            part.write_bytes(pickle.dumps(found))
            part.replace(path)
            return found

    return functools.wraps(function)(once)


@functools.cache
def loaded(name):
    """A shipped study, loaded once in a process: cheaper than to keep it."""
    return iv.load_study(name)


@functools.cache
def parameter_study(name):
    """The study of a whole shipped parameter set."""
    from internals import shipped_study  # loads NumPy, which must see what conftest sets

    return shipped_study(name)


WAYS = {
    "compare": lambda study, _, options: iv.compare(study, **options),
    "simulate": lambda study, names, options: iv.simulate(study.drives[names[0]], study.scenarios[names[1]], **options),
    "duty_cycle": lambda study, names, options: iv.duty_cycle(study.drives[names[0]], study.duty[names[1]], **options),
    "session": lambda study, names, options: iv.study_session(study, *names, **options),
    "size": lambda study, _, options: iv.size(study, **options),
    "reproduce": lambda _, names, options: iv.reproduce(*names, **options),
}
"""How results of a study are made, from the study, names in it and options."""


@kept
def made(what, place="", **options):
    """A result of a shipped study: `made("simulate", "hand_controller/cobotic/step")`."""
    name, *names = place.split("/") if place else [None]
    return WAYS[what](None if name is None else loaded(name), names, options)


@kept
def made_run(*arguments, files=None, figures=None, simulated=True):
    """Outcome of a command with `--out`, and its folder, in which `files` lie before; figures are rendered in these formats.

    Half of the time of a comparison over a cycle is its simulation, which is left out unless `simulated`.
    """
    from rendering import rendered  # these load NumPy, which must see what conftest sets
    from run_cli import run

    path = folder() / f"run-{named(hashlib.sha256(repr((arguments, files, figures, simulated)).encode()))}"
    shutil.rmtree(path, ignore_errors=True)  # of a run that was stopped
    path.mkdir()
    for name, text in files or ():
        (path / name).write_text(text, "utf-8")
    with rendered(("png", "svg") if figures is None else figures), pytest.MonkeyPatch.context() as patch:
        if not simulated:
            patch.setattr("infinivar.analysis.cycles.tracking.LONGEST", 0.0)
        outcome = run(*arguments, "--out", path, folder=path)
    return outcome, path

"""Tests reach the package's inside through one list, so that moving a file changes a line there and no test."""

import ast
import functools
from pathlib import Path
from types import ModuleType

import pytest

import infinivar
import internals
from public_names import public_names

TESTS = Path(__file__).parents[1]
GROUPS = {value.__name__ for value in public_names().values() if isinstance(value, ModuleType)}
PUBLIC = {"infinivar", "infinivar.cli", *(name for name in GROUPS if name.count(".") == 1)}
"""Packages whose names users import."""
LEAVES = {path.stem for path in Path(infinivar.__file__).parent.glob("*.py")}
PUBLIC_NAMES = {"__version__", *LEAVES, *(name.rpartition(".")[2] for name in public_names())}


@functools.cache
def imports():
    """File, module and name of each import of a name in the tests."""
    return tuple(_imports())


def _imports():
    for path in TESTS.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text("utf-8"))):
            if isinstance(node, ast.ImportFrom):
                yield from ((path, node.module or "", each.name) for each in node.names)
            elif isinstance(node, ast.Import):
                yield from ((path, each.name, "") for each in node.names)


@pytest.mark.slow
def test_what_is_listed_exists_and_is_used():
    used = {name for _, module, name in imports() if module == "internals" and name}
    assert used == set(internals.places())
    for name in used:
        assert getattr(internals, name) is not None


@pytest.mark.slow
def test_nothing_else_of_the_inside_is_imported():
    inside = [(path.name, module) for path, module, _ in imports() if module.startswith("infinivar.")]
    assert [one for one in inside if one[1] not in PUBLIC] == []
    own = [(path.name, name) for path, module, name in imports() if module in PUBLIC - {"infinivar.cli"}]
    assert [(file, name) for file, name in own if name and name not in PUBLIC_NAMES] == []

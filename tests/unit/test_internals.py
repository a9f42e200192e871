"""Tests reach the package's inside through one list, so that moving a file changes a line there and no test."""

import ast
import functools
from pathlib import Path

import internals

TESTS = Path(__file__).parents[1]
PUBLIC = ("infinivar", "infinivar.bondgraph", "infinivar.cli", "infinivar.contact", "infinivar.parts")
"""Packages whose names users import."""


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


def test_what_is_listed_exists_and_is_used():
    used = {name for _, module, name in imports() if module == "internals" and name}
    assert used == set(internals.places())
    for name in used:
        assert getattr(internals, name) is not None


def test_nothing_else_of_the_inside_is_imported():
    inside = [
        (path.name, module) for path, module, _ in imports() if module.startswith("infinivar.") and module not in PUBLIC
    ]
    assert inside == []

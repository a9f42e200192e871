"""What the gallery's examples and the list of public names keep to, without building the documentation."""

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
EXAMPLES = sorted((ROOT / "examples").glob("*.py"))
MODULES = {
    "infinivar.analysis.cycles.cylinder_policy",
    "infinivar.bondgraph",
    "infinivar.calibration",
    "infinivar.contact",
}
"""Modules whose names are no names of the package itself."""


def test_there_are_examples_on_many_jobs():
    assert len(EXAMPLES) >= 12
    titles = {ast.get_docstring(ast.parse(path.read_text("utf-8"))).partition("\n")[0] for path in EXAMPLES}
    assert len(titles) == len(EXAMPLES)


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_an_example_uses_public_names_and_draws(path):
    text = path.read_text("utf-8")
    for node in ast.walk(ast.parse(text)):
        imported = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
        if isinstance(node, ast.ImportFrom):
            imported = [node.module]
        for name in imported:
            assert name in MODULES | {"infinivar"} or name.partition(".")[0] != "infinivar", name
            assert name.partition(".")[0] in {"dataclasses", "infinivar", "matplotlib", "numpy", "pathlib"}, name
    assert "plt.show()" in text
    assert not re.search(r"\b_[a-z]+\(|\._[a-z]", text)

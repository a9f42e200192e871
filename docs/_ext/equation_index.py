"""Index of the paper's equations and figures: which function implements each, and which tests check it.

A function cites the source of its law in its docstring, ``Source: faulring2006, Eq 12; johnson1985, section 9.4.``, with
single equations, so that a search for one finds the law. A marker names what a test checks,
``@pytest.mark.source("faulring2006", "Eq 12")``; a test that uses the module of a figure checks that figure. The index is
read from the source text: nothing is imported or run.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

PAPER = "faulring2006"
ROOT = Path(__file__).parents[2]

EQUATIONS = {
    1: "speed ratio without losses",
    2: "force ratio without losses",
    3: "creep velocity of the wheel",
    4: "rolling velocity of the wheel",
    5: "cylinder torque from the contact forces",
    6: "link force from the contact forces",
    7: "lateral force from the creepage",
    8: "power lost to creep",
    9: "creep stiffness from a locked run",
    10: "strain work of rolling",
    11: "strain work lost to hysteresis",
    12: "torque of rolling friction",
    13: "power lost to rolling friction",
    14: "power lost in the axle bearings",
    15: "efficiency of the element",
    16: "efficiency in closed form, from load and steering angle",
    17: "correction above 70 % of the slip force",
    18: "efficiency from measurements",
}

FIGURES = {
    1: "the wheel on its cylinder at several steering angles",
    2: "bond graph of the lossless transmission",
    3: "velocities at the contact",
    4: "forces at the contact",
    5: "creep curve",
    6: "bond graph of the transmission with its losses",
    7: "efficiency of the element against reduction ratio",
    8: "the element against gears on the market",
    9: "both architectures",
    10: "bond graph of the cobotic system",
    11: "bond graph of the steering plant",
    12: "bond graph of the cylinder plant",
    13: "bond graph of the link plant",
    14: "bond graph of the conventional system",
    15: "operating ranges of the conventional drives",
    16: "operating range of the cobotic drive",
    17: "performance when shaking a mass, over frequency and power",
}

_SOURCE = re.compile(r"^[ \t]*Source: (.*?)(?=\n[ \t]*\n|\Z)", re.DOTALL | re.MULTILINE)
_PLACE = re.compile(r"\b(?:Eq|Fig) \d+\b")


class Entry(NamedTuple):
    """A function, class or module that cites the paper, or a test that checks an equation or a figure."""

    place: str
    """``Eq 12`` or ``Fig 7``."""
    name: str
    """Dotted name, or ``tests/.../test_x.py::test_name``."""
    summary: str
    """First line of the docstring."""


def _functions(tree: ast.Module) -> Iterator[tuple[str, ast.AST]]:
    """Dotted names and nodes of a module and all its classes, functions and methods."""

    def within(node: ast.AST, prefix: str) -> Iterator[tuple[str, ast.AST]]:
        for child in ast.iter_child_nodes(node):
            if isinstance(child, (ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)):
                yield f"{prefix}.{child.name}", child
                yield from within(child, f"{prefix}.{child.name}")

    yield "", tree
    yield from within(tree, "")


def places(docstring: str) -> list[str]:
    """Single equations and figures of the paper that a docstring cites as its source, in order."""
    cited = [clause for source in _SOURCE.findall(docstring) for clause in source.split(";")]
    return [place for clause in cited if PAPER in clause for place in _PLACE.findall(clause)]


def implementations(package: Path = ROOT / "src" / "infinivar") -> list[Entry]:
    """All places where the package implements an equation or draws a figure."""
    found = []
    for path in sorted(package.rglob("*.py")):
        module = ".".join((package.name, *path.relative_to(package).with_suffix("").parts)).removesuffix(".__init__")
        for name, node in _functions(ast.parse(path.read_text("utf-8"))):
            text = ast.get_docstring(node) or ""
            cited = places(text)
            found += [Entry(place, module + name, text.partition("\n")[0]) for place in dict.fromkeys(cited)]
    return found


def checks(tests: Path = ROOT / "tests") -> list[Entry]:
    """All tests that have a source marker."""
    found = []
    for path in sorted(tests.rglob("test_*.py")):
        for node in ast.parse(path.read_text("utf-8")).body:
            if not (isinstance(node, ast.FunctionDef) and node.name.startswith("test_")):
                continue
            where = f"{path.relative_to(tests.parent).as_posix()}::{node.name}"
            summary = (ast.get_docstring(node) or "").partition("\n")[0]
            found += [Entry(place, where, summary) for place in dict.fromkeys(_marked(node))]
    return found


def _marked(test: ast.FunctionDef) -> list[str]:
    """Equations and figures in the ``source`` markers of a test."""
    found = []
    for mark in test.decorator_list:
        if isinstance(mark, ast.Call) and ast.unparse(mark.func) == "pytest.mark.source":
            paper, *named = (ast.literal_eval(argument) for argument in mark.args)
            found += named if paper == PAPER else []
    return found


def _documented(package: Path = ROOT / "src" / "infinivar") -> dict[str, str]:
    """Public name of each object by the place of its definition, from the list of public names."""
    tree = ast.parse((package / "__init__.pyi").read_text("utf-8"))
    imports = [node for node in tree.body if isinstance(node, ast.ImportFrom) and node.level == 1 and node.module]
    return {
        f"{package.name}.{node.module}.{alias.name}": f"{package.name}.{alias.asname or alias.name}"
        for node in imports
        for alias in node.names
    }


def _shown(name: str, documented: dict[str, str]) -> str:
    """A function as a link to its page; a private function, which has none, by its name."""
    parts = name.split(".")
    module = next(
        place for place in range(len(parts), 0, -1) if ROOT.joinpath("src", *parts[:place]).with_suffix(".py").exists()
    )
    short = ".".join(parts[module - 1 :])
    if any(part.startswith("_") for part in parts):
        return f"`{short}`"
    owner = next((defined for defined in documented if name == defined or name.startswith(f"{defined}.")), None)
    target = name if owner is None else documented[owner] + name.removeprefix(owner)
    return f"{{py:obj}}`{short} <{target}>`"


def _table(kind: str, meanings: dict[int, str]) -> str:
    """Markdown table of all equations or all figures: meaning, implementation and tests."""
    code, tests, documented = implementations(), checks(), _documented()
    lines = ["| | what it is | implemented by | checked by |", "| --- | --- | --- | --- |"]
    for number, meaning in meanings.items():
        place = f"{kind} {number}"
        functions = [_shown(entry.name, documented) for entry in code if entry.place == place]
        marked = [f"`{entry.name.partition('::')[2]}`" for entry in tests if entry.place == place]
        cells = (place.replace(" ", "\N{NO-BREAK SPACE}"), meaning, "<br>".join(functions), "<br>".join(marked))
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


def write(app) -> None:
    """Write both tables to the files that the page includes."""
    folder = Path(app.srcdir) / "reference" / "generated"
    folder.mkdir(parents=True, exist_ok=True)
    for name, kind, meanings in (("equations", "Eq", EQUATIONS), ("paper_figures", "Fig", FIGURES)):
        path, text = folder / f"{name}.md", _table(kind, meanings)
        if not path.exists() or path.read_text("utf-8") != text:
            path.write_text(text, "utf-8")


def setup(app):
    app.connect("builder-inited", write)
    return {"parallel_read_safe": True}

"""Files of a bond graph: its picture and its equations."""

from __future__ import annotations

from pathlib import Path

from infinivar.bondgraph.graph import BondGraph
from infinivar.errors import InputError
from infinivar.figures import style
from infinivar.report.output import check_file


def save(graph: BondGraph, picture: Path, equations: Path | None = None) -> None:
    """Write the picture of a graph and, if requested, its equations.

    Parameters
    ----------
    graph : BondGraph
    picture : Path     Ends in .svg, .pdf or .png.
    equations : Path   Ends in .tex (LaTeX) or .txt.

    Raises
    ------
    InputError
        If a name ends otherwise, or cannot be written to.
    """
    from infinivar.figures.bond_graph import draw_all

    kind = picture.suffix[1:].lower()
    if kind not in style.FORMATS:
        raise InputError(f"--out {picture}: must end in {', '.join(f'.{known}' for known in style.FORMATS)}")
    if equations is not None and equations.suffix.lower() not in (".tex", ".txt"):
        raise InputError(f"--equations {equations}: must end in .tex or .txt")
    for path in filter(None, (picture, equations)):
        check_file(path)
    written = _described(graph, equations) if equations is not None else ""
    made = draw_all(graph)
    style.write(made, picture.with_suffix(""), (kind,))
    if equations is not None:
        equations.write_text(written, "utf-8")


def _described(graph: BondGraph, path: Path) -> str:
    from infinivar.bondgraph import describe
    from infinivar.bondgraph.equations import derive

    equations = derive(graph)
    return describe.latex(equations) if path.suffix.lower() == ".tex" else describe.text(equations)

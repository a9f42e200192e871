"""Where the figure, the table and the report of a type of result are made: by name, so that results import none of it.

Results stand below figures and reports. The one place where the arrow turns round is here: a result asks for the function
of its type by name, and only then the module that holds it is imported. `infinivar.report.presenters` lists them.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import Any, Literal

from infinivar._core.imported import imported

Kind = Literal["plot", "save", "dataset", "table", "animation", "video", "scene", "notebook"]
"""A matplotlib figure; files in a directory; labelled arrays (`infinivar._core.netcdf.Arrays`); a `pandas.DataFrame`; an
animation of matplotlib; a file of it; files for MuJoCo; HTML that a notebook shows above the figure."""

_TABLE = "infinivar.report.presenters"
_PRESENTERS: dict[str, dict[Kind, str]] = {}


def register(result_type: str, **functions: str) -> None:
    """Name the functions, "module:function", that present results of a type, given by its qualified name."""
    _PRESENTERS.setdefault(result_type, {}).update(functions)  # type: ignore[arg-type]


def presenter(result_type: type, kind: Kind) -> Callable[..., Any] | None:
    """The function that presents results of a type in one way; None if there is none."""
    import_module(_TABLE)
    where = _PRESENTERS.get(_name(result_type), {}).get(kind)
    if where is None:
        return None
    return imported(where)


def presented(kind: Kind) -> list[str]:
    """Names of the types that are presented in one way."""
    import_module(_TABLE)
    return sorted(name.rpartition(".")[2] for name, functions in _PRESENTERS.items() if kind in functions)


def _name(result_type: type) -> str:
    return f"{result_type.__module__}.{result_type.__qualname__}"

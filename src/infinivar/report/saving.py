"""Save a result as a report: the module that writes each type of result."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import Any

# Report modules are named, not imported: saving one result loads the report of that result only.
_WRITERS: dict[str, str] = {
    "infinivar.analysis.compare.Comparison": "infinivar.report.comparison",
    "infinivar.analysis.simulate.Simulation": "infinivar.report.simulation",
    "infinivar.analysis.robustness.sensitivity.Sensitivity": "infinivar.report.sensitivity",
    "infinivar.analysis.contact_sheet.ContactSheet": "infinivar.report.contact",
    "infinivar.calibration.calibrate.Calibration": "infinivar.report.calibration",
}


def register(result_type: str, module: str) -> None:
    """Let the function `save` of a module write results of a type, given by its qualified name."""
    _WRITERS[result_type] = module


def save(result: Any, directory: str | Path, **options: Any) -> list[Path]:
    """Write the report of a result, with its figures and data, into a directory.

    Files of the same names are replaced and others are left alone; nothing is replaced unless all files could be made.

    Parameters
    ----------
    result : Comparison, Simulation, Sensitivity, Calibration, Reproduction, ContactSheet or a sequence of ContactSheet
    directory : path           Created if there is none.
    **options                  A simulation has `name`, the stem of its files, and `reconstruction`, sentences on what is
                               assumed about the machine; a reproduction has `figure`, to draw only that figure.

    Returns
    -------
    list of Path               Files written, the report first.

    Raises
    ------
    InputError
        If the directory cannot be written to; nothing is changed then.
    TypeError
        If there is no report for the type of the result.
    """
    kind = type(next(iter(result), None) if isinstance(result, list | tuple) else result)
    module = _WRITERS.get(f"{kind.__module__}.{kind.__qualname__}")
    if module is None:
        known = ", ".join(sorted(name.rpartition(".")[2] for name in _WRITERS))
        raise TypeError(f"a report exists for {known}, got {kind.__name__}")
    return import_module(module).save(result, Path(directory), **options)

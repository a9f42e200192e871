"""Write the report of a result: the module that writes each type of result."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from infinivar._core.presentation import presented, presenter


def save(result: Any, directory: str | Path, **options: Any) -> list[Path]:
    """Write the report of a result, with its figures and data, into a directory.

    Files of the same names are replaced and others are left alone; nothing is replaced unless all files could be made.

    Parameters
    ----------
    result : Comparison, Simulation, MachineRun, Sensitivity, Calibration, Reproduction, ContactSheet, SteeringStep or a
        sequence of one of the last two
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
    kind = one_type(result)
    write = presenter(kind, "save")
    if write is None:
        raise TypeError(f"a report exists for {', '.join(presented('save'))}, got {kind.__name__}")
    return write(result, Path(directory), **options)


def one_type(result: Any) -> type:
    """Type of a result, or of all in a sequence.

    Raises
    ------
    TypeError
        If a sequence is empty or of several types.
    """
    several = isinstance(result, list | tuple) and not hasattr(result, "_fields")
    kinds = {type(one) for one in result} if several else {type(result)}
    if len(kinds) != 1:
        named = ", ".join(sorted(kind.__name__ for kind in kinds)) or "an empty sequence"
        raise TypeError(f"result must be one result or a sequence of one type, got {named}")
    return kinds.pop()

"""Libraries that the core does without: loaded where they are used, with the command that installs them if they are missing."""

from __future__ import annotations

import importlib
from typing import Any

from infinivar.errors import InputError


def load(library: str, extra: str, what: str) -> Any:
    """A library of one of the package's extras.

    Parameters
    ----------
    library : str   Name of the module.
    extra : str     Extra that installs it.
    what : str      What needs it, for the message.

    Raises
    ------
    InputError
        If it is not installed; the message says how to install it.
    """
    try:
        return importlib.import_module(library)
    except ModuleNotFoundError as problem:
        if problem.name is None or problem.name.partition(".")[0] != library:
            raise
        raise InputError(f"{what} needs {library}; install it with: pip install 'infinivar[{extra}]'") from None

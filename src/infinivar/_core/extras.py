"""Libraries that the core does without: loaded where they are used, with the command that installs them if they are missing."""

from __future__ import annotations

import importlib
import importlib.util
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
        raise InputError(_missing(library, extra, what)) from None


def there(library: str) -> bool:
    """Whether a library is installed, without importing it."""
    return importlib.util.find_spec(library) is not None


def check(library: str, extra: str, what: str) -> None:
    """Raise the error of `load` if a library is missing, without importing it."""
    if not there(library):
        raise InputError(_missing(library, extra, what))


def _missing(library: str, extra: str, what: str) -> str:
    return f"{what} needs {library}; install it with: pip install 'infinivar[{extra}]'"

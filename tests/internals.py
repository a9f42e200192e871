"""What tests need of the package's inside: laws, helpers and tables that are no public names.

``internals.pyi`` lists where each lies, and nothing is imported before it is used: whoever moves a name changes one line there
and no test. Public names come from ``infinivar``.
"""

import ast
import functools
import importlib
from pathlib import Path


@functools.cache
def places():
    """Module and name within it, by the name that tests import."""
    stub = ast.parse(Path(__file__).with_suffix(".pyi").read_text("utf-8"))
    listed = [(line.module, each) for line in stub.body if isinstance(line, ast.ImportFrom) for each in line.names]
    return {each.asname or each.name: (module, each.name) for module, each in listed}


def __getattr__(name):
    if name not in places():
        raise AttributeError(f"internals.pyi lists no {name}")
    module, within = places()[name]
    try:
        return getattr(importlib.import_module(module), within)
    except AttributeError:
        return importlib.import_module(f"{module}.{within}")

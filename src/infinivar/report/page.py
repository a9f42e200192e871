"""Rendering of templates, JSON and CSV files."""

from __future__ import annotations

import csv
import functools
import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from infinivar import __version__, references
from infinivar.report.numbers import FILTERS, bound

_PACKAGE = "infinivar.report"


@functools.cache
def _environment(package: str) -> Any:
    import jinja2

    packages = dict.fromkeys((package, _PACKAGE))
    environment = jinja2.Environment(
        loader=jinja2.ChoiceLoader([jinja2.PackageLoader(name) for name in packages]),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
    )
    environment.filters.update(FILTERS)
    environment.globals.update(version=__version__, cite=references.cite)
    return environment


def render(template: str, *, package: str = _PACKAGE, **values: Any) -> str:
    """Render a template with the values; numbers are bound to their units.

    `package` has the folder `templates` with the template, which may extend those of this package.
    """
    return bound(_environment(package).get_template(template).render(**values))


def write_csv(columns: Mapping[str, Any], path: Path) -> None:
    """Write columns of numbers under their names as CSV."""
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(columns)
        writer.writerows([f"{value:.9g}" for value in row] for row in zip(*columns.values(), strict=True))


def to_json(value: Any) -> str:
    """JSON text with nan as null, since JSON has no nan."""
    return json.dumps(_without_nan(value), indent=2, allow_nan=False) + "\n"


def _without_nan(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _without_nan(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_without_nan(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value

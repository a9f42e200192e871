"""Rendering of templates, JSON and CSV files."""

from __future__ import annotations

import csv
import functools
import html
import json
import math
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from infinivar import __version__, references
from infinivar.figures.style import loss_colour
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
    environment.filters.update(FILTERS, loss_colour=loss_colour)
    environment.globals.update(version=__version__, cite=references.cite)
    return environment


def render(template: str, *, package: str = _PACKAGE, **values: Any) -> str:
    """Render a template with the values; numbers are bound to their units, and the page is finished as by `finished`.

    `package` has the folder `templates` with the template, which may extend those of this package.
    """
    return finished(bound(_environment(package).get_template(template).render(**values)))


_HEADING = re.compile(r"<(h1|h2|h3|summary)\b[^>]*>(.*?)</\1>", re.DOTALL)
_SCROLL = '<div class="scroll">'
_HEAD = re.compile(r"(<table\b[^>]*>\s*)(<tr>(?:\s*<th\b(?:(?!</th>).)*</th>)+\s*</tr>)", re.DOTALL)
_PLACES = re.compile(f"{_HEADING.pattern}|{_SCROLL}", re.DOTALL)


def finished(page: str) -> str:
    """A page whose first row of headings heads its table on each sheet, and whose parts that scroll can be reached and are named.

    A keyboard scrolls only what it can reach, and a screen reader announces it by its name: that of the heading above.
    """
    heading = ""

    def named(found: re.Match[str]) -> str:
        nonlocal heading
        if found[1] is not None:
            heading = " ".join(re.sub(r"<[^>]*>", " ", found[2]).split())
            return found[0]
        label = html.escape(html.unescape(heading))
        return f'<div class="scroll" tabindex="0" role="region" aria-label="{label}">'

    def headed(found: re.Match[str]) -> str:
        row = found[2].replace("<th", '<th scope="col"')
        return f"{found[1]}<thead>{row}</thead>"

    return _PLACES.sub(named, _HEAD.sub(headed, page))


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

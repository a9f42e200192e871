"""Convert the docstrings of this project for napoleon, and list dataclass fields from their metadata.

The source keeps ``name : type   Meaning. [unit]`` on one line and ends with ``Source: key, place.``. NumPy style expects
the meaning on the next line and reads a trailing paragraph as another return value. Bars denote absolute values, but
reStructuredText reads them as substitutions.
"""

import dataclasses
import re

from docutils import nodes
from sphinx import addnodes
from sphinx.ext.autosummary import autosummary_toc

from infinivar._core.bounds import words
from infinivar._core.result import Frozen

_HEADER = re.compile(r"^\s*-{3,}$")
_ONE_LINE = re.compile(r"^(?P<indent>\s*)(?P<name>\S.*?)\s{2,}(?P<meaning>\S.*)$")
_LONG_NAME = re.compile(r"^(?P<indent>\s*)(?P<name>[a-z_]+) (?P<meaning>[A-Z].*)$")
_LITERAL_OR_BAR = re.compile(r"(``.*?``|`.*?`)|(?<!\\)\|")
_LISTS = ("Parameters", "Returns", "Attributes")


def split_lines(lines: list[str]) -> list[str]:
    """Put each meaning on its own line, and turn the source into a section."""
    result: list[str] = []
    section, indent = "", 0
    for number, line in enumerate(lines):
        follows = lines[number + 1] if number + 1 < len(lines) else ""
        if _HEADER.match(follows):
            section, indent = line.strip(), len(line) - len(line.lstrip())
            if section == "Attributes":
                # Napoleon splits comma-separated names in "Attributes"; a custom section keeps them as written.
                line = line.replace("Attributes", "Fields")
        elif line.strip() and not _HEADER.match(line):
            source = re.match(r"^\s*Source: (.*)$", line)
            if source is not None:
                section, margin = "Source", " " * (len(line) - len(line.lstrip()))
                result += [f"{margin}Source", f"{margin}------", f"{margin}{source[1]}"]
                continue
            pair = _ONE_LINE.match(line) or _LONG_NAME.match(line)
            if section in _LISTS and pair is not None and len(pair["indent"]) == indent:
                result += [f"{pair['indent']}{pair['name']}", f"{pair['indent']}    {pair['meaning']}"]
                continue
        result.append(line)
    return result


def escape_bars(lines: list[str]) -> list[str]:
    """Escape bars in plain text; bars in literals and formulas stay as they are."""
    result: list[str] = []
    formula: int | None = None  # indent of the current math directive
    for line in lines:
        indent = len(line) - len(line.lstrip())
        if line.strip() and formula is not None and indent <= formula:
            formula = None
        if line.lstrip().startswith(".. math::"):
            formula = indent
        result.append(line if formula is not None else _LITERAL_OR_BAR.sub(lambda hit: hit[1] or "\\|", line))
    return result


def describe_fields(part: type) -> list[str]:
    """Section that lists the dataclass fields whose metadata hold a meaning."""
    described = [field for field in dataclasses.fields(part) if "meaning" in field.metadata]
    lines = ["", "Fields", "------"] if described else []
    for field in described:
        unit, bound = field.metadata.get("unit", ""), field.metadata.get("bound")
        limits = f", {words(bound)}" if bound else ""
        shown = "" if not unit else " [-]" if unit == "1" else f" [{unit}]"
        if field.default is None:
            limits += ", optional"
        elif field.default is not dataclasses.MISSING:
            shown_default = f"{field.default:.4g}" if isinstance(field.default, float) else repr(field.default)
            limits += f", default {shown_default}"
        lines += [f"{field.name} : {limits.lstrip(', ')}", f"    {field.metadata['meaning']}.{shown}"]
    return lines


def rewrite(app, what: str, name: str, obj: object, options: object, lines: list[str]) -> None:
    lines[:] = split_lines(escape_bars(lines))
    if what == "property" and lines:
        # Napoleon reads text before a colon as the type of the property.
        lines[0] = lines[0].replace(": ", "; ")
    if what == "class" and isinstance(obj, type) and dataclasses.is_dataclass(obj):
        listed = issubclass(obj, Frozen) and "Fields" in lines  # in the docstring of a result
        lines += [] if listed else describe_fields(obj)


def unlink_common_words(app, doctree: nodes.document) -> None:
    """Types refer to classes: ``float or row`` is no reference to a method that happens to be called row."""
    for reference in list(doctree.findall(addnodes.pending_xref)):
        if reference["refdomain"] == "py" and reference["reftype"] == "class" and reference["reftarget"].islower():
            reference.replace_self(reference.children)


def leave_out_of_contents(app, doctree: nodes.document) -> None:
    """Pages of objects are reached from the lists on the page on Python: hundreds of them in the contents beside every page,
    which nobody reads, take most of the time of a build.
    """
    for contents in list(doctree.findall(autosummary_toc)):
        contents.parent.remove(contents)


def setup(app):
    # Run before napoleon, which has the default priority of 500.
    app.connect("autodoc-process-docstring", rewrite, priority=400)
    app.connect("doctree-read", unlink_common_words)
    # Before Sphinx collects the contents, with the default priority of 500.
    app.connect("doctree-read", leave_out_of_contents, priority=400)
    return {"parallel_read_safe": True}

"""Style shared by all figures, and writing figures to files."""

from __future__ import annotations

import functools
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from typing import TYPE_CHECKING, Any

from infinivar._core.processes import apart
from infinivar.axis import Axis
from infinivar.drivetrain.conventional import STAGES
from infinivar.limits import Limit

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# Okabe and Ito's palette: distinguishable for colour-blind readers and in print.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000", "#999999")

LOSS_COLOURS = {
    "winding": "#D55E00",
    "motor friction": "#E69F00",
    "motor iron": "#B5651D",
    "gearhead": "#0072B2",
    "creep": "#009E73",
    "spin": "#332288",
    "rolling": "#B8A800",
    "bearing": "#56B4E9",
    "wheels": "#8A8A00",
    "rollers": "#4E7D2D",
    "cylinder bearings": "#1B7F79",
    "backing rollers": "#A5A552",
    "guideway": "#CC79A7",
    **dict.fromkeys(STAGES, "#8B6BB1"),
    "gearhead damping": "#66A3D2",
    "belt damping": "#B8A5D6",
    "amplifier": "#999999",
    "battery": "#5C4B8A",
    "slip": "#882255",
    "arm": "#661100",
    "steering winding": "#EE9977",
    "steering motor friction": "#F5C77A",
    "steering motor iron": "#D9B08C",
    "steering bearing": "#A9D8F2",
    "steering patch": "#7FCDBB",
}
"""One colour per loss, the same for areas, lines and marks in every figure, table and page; each is dark enough on white."""

_OTHER_LOSS = "#BBBBBB"

SOURCE_COLOURS = {
    "motor supply": "#3D4B66",
    "steering supply": "#8497B0",
    "external work": "#7A5230",
    "work of the user": "#B8895A",
}
"""One colour per source of energy, the same in every figure."""


def colour(place: int) -> str:
    """Colour of one of several things of a kind, by its place; after the last colour, the first comes again."""
    return COLOURS[place % len(COLOURS)]


def loss_colour(name: str) -> str:
    """Colour of a loss by its name; a light grey for those of other packages."""
    return LOSS_COLOURS.get(name, _OTHER_LOSS)


BLANK = {"boxstyle": "round,pad=0.15", "facecolor": "white", "edgecolor": "none", "alpha": 0.85}
"""Box behind words that may stand on lines."""

FORMATS = ("png", "svg", "pdf")

_written: ContextVar[tuple[str, ...]] = ContextVar("formats", default=FORMATS[:2])
"""Formats of the figures of reports."""

_SETTINGS: dict[Any, Any] = {
    "font.family": "DejaVu Sans",
    "font.size": 9,
    "axes.titlesize": 10,
    "axes.labelsize": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": False,
    "legend.fontsize": 8,
    "legend.frameon": False,
    "lines.linewidth": 1.6,
    "svg.hashsalt": "infinivar",  # equal figures give equal files
    "savefig.dpi": 200,
}


@contextmanager
def styled() -> Iterator[None]:
    """Context in which figures have the style of the project."""
    import matplotlib

    with matplotlib.rc_context(), warnings.catch_warnings():
        matplotlib.rcdefaults()  # ignore the user's matplotlibrc
        matplotlib.rcParams.update(_SETTINGS)
        # Characters that the font lacks are drawn as boxes.
        warnings.filterwarnings("ignore", message="Glyph .* missing from font")
        yield


def figure(width: float, height: float, rows: int = 1, columns: int = 1, **options: Any) -> tuple[Figure, Any]:
    """New figure and its axes, outside any interactive session. [inch]"""
    from matplotlib.figure import Figure

    made = Figure(figsize=(width, height), layout="constrained")
    return made, made.subplots(rows, columns, **options)


def arrow(
    ax: Any, tail: Any, head: Any, colour: str, *, lw: float = 1.8, size: float = 11.0, gap: float = 0.0, **options: Any
) -> None:
    """Draw an arrow from a point (2,) to another, or a gap before it, with a head of a size."""
    drawn = {"arrowstyle": "-|>", "color": colour, "lw": lw, "shrinkA": 0, "shrinkB": gap, "mutation_scale": size}
    ax.annotate("", xy=tuple(head), xytext=tuple(tail), arrowprops=drawn, **{"zorder": 4, **options})


def stack(names: Sequence[str], width: float, height: float, **options: Any) -> tuple[Figure, dict[str, Any]]:
    """New figure, with axes by name one above the other over a common axis. [inch]"""
    made, axes = figure(width, height, len(names), 1, sharex=True, squeeze=False, **options)
    return made, dict(zip(names, axes[:, 0], strict=True))


def curves(ax: Any, along: Any, values: Mapping[str, Any], label: str, colours: Any = None, line: str = "-") -> None:
    """Plot curves over an axis, by the names that a legend beside it has, in the colours of names and places, and label them."""
    for place, (name, one) in enumerate(values.items()):
        shown = colour(place) if colours is None else colours(name, place)
        ax.plot(along, one, line, color=shown, label=name)
    ax.set_ylabel(label)
    name_beside(ax)


def name_beside(ax: Any, **options: Any) -> None:
    """Name what is plotted to the right of the axes."""
    if ax.get_legend_handles_labels()[0]:
        ax.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), **{"fontsize": 7, **options})


def label_plane(ax: Any, axis: Axis) -> None:
    """Label the axes of a force-speed plane."""
    ax.set_xlabel(f"{axis.force} on the load [{axis.force_unit}]")
    ax.set_ylabel(f"{axis.speed} of the load [{axis.speed_unit}]")


def formats() -> tuple[str, ...]:
    """Formats in which figures of reports are written here."""
    return _written.get()


@contextmanager
def written_as(*kinds: str) -> Iterator[None]:
    """Context in which the figures of reports are written in these formats, SVG among them."""
    before = _written.set(kinds)
    try:
        yield
    finally:
        _written.reset(before)


def write(made: Figure, path: Path, kinds: Sequence[str] = ()) -> list[Path]:
    """Write a figure in several formats, by default those of reports, laid out once for all; returns the files."""
    layout = made.get_layout_engine()
    with styled():
        files = [_write_one(made, path.with_suffix(f".{kind}"), kind) for kind in kinds or formats()]
        made.set_layout_engine(layout)
    return files


def write_all(
    folder: Path, drawings: Mapping[str, tuple[Callable[[Any], Figure | None], Any]]
) -> dict[str, list[Path]]:
    """Draw and write figures in the formats of reports, in processes where a command has opened some.

    Parameters
    ----------
    folder : Path
    drawings : mapping   A function of a module that draws, and what it draws, by the name of the files.

    Returns
    -------
    dict of list of Path   Files by name; none of a figure that shows nothing.
    """
    files = apart(functools.partial(_drawn, folder, formats()), list(drawings.items()))
    return dict(zip(drawings, files, strict=True))


def _drawn(
    folder: Path, kinds: Sequence[str], drawing: tuple[str, tuple[Callable[[Any], Figure | None], Any]]
) -> list[Path]:
    name, (draw, shown) = drawing
    made = draw(shown)
    return [] if made is None else write(made, folder / name, kinds)


def _write_one(made: Figure, path: Path, kind: str) -> Path:
    dates = {"png": {}, "svg": {"Date": None}, "pdf": {"CreationDate": None}}[kind]
    layout, dpi = made.get_layout_engine(), made.dpi
    if layout is not None:  # the first of the formats
        made.dpi = _SETTINGS["savefig.dpi"]
        layout.execute(made)
        made.set(dpi=dpi, layout_engine=None)
    made.savefig(path, format=kind, metadata=dates)
    return path


def inline_svg(files: Sequence[Path]) -> str:
    """The SVG among the files as a data URL for embedding in a page."""
    import base64

    drawing = next(file for file in files if file.suffix == ".svg")
    return "data:image/svg+xml;base64," + base64.b64encode(drawing.read_bytes()).decode()


def name_limits(ax: Any, values: Any, limits: Sequence[Limit], where: str) -> None:
    """Shade the intervals of the x axis in which a limit is exceeded, labelled at the "top" or "bottom"."""
    height = {"top": 0.98, "bottom": 0.02}[where]
    start = 0
    for index in range(1, len(limits) + 1):
        if index < len(limits) and limits[index] == limits[start]:
            continue
        if limits[start] != Limit.OK:
            left = values[start] if start == 0 else 0.5 * (values[start - 1] + values[start])
            right = values[-1] if index == len(limits) else 0.5 * (values[index - 1] + values[index])
            ax.axvspan(left, right, color="#eeeeee", zorder=0)
            middle = (left * right) ** 0.5 if ax.get_xscale() == "log" else 0.5 * (left + right)
            ax.text(
                middle,
                height,
                limits[start].words,
                transform=ax.get_xaxis_transform(),
                rotation=90,
                ha="center",
                va=where,
                fontsize=8,
            )
        start = index


def plain_log_ticks(ax: Any) -> None:
    """Label a logarithmic x axis of less than two decades with plain numbers instead of powers of ten."""
    from matplotlib.ticker import LogLocator, NullFormatter, StrMethodFormatter

    ax.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    ax.xaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
    ax.xaxis.set_minor_formatter(NullFormatter())

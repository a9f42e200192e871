"""A machine in motion: frames of a session at its handle, or of a simulated run, in real time or slower."""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from annotated_types import Gt

from infinivar._core.fields import check_number
from infinivar.analysis.machine_run import MachineRun
from infinivar.analysis.moving_parts import parts_of
from infinivar.analysis.sessions.guides import guides_of
from infinivar.analysis.sessions.session_result import Session
from infinivar.errors import InputError
from infinivar.figures import moving_flat, moving_platform, pictures, style
from infinivar.machines.pictures.slides import Slides
from infinivar.machines.pictures.strokes import bounds
from infinivar.units import plain

if TYPE_CHECKING:
    from matplotlib.animation import FuncAnimation
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MOST_FRAMES = 5000
"""Of one animation."""

_WIDTH, _DPI, _PAD = 5.2, 100, 0.08
"""Of the figure [inch], its resolution, and the room around its axes. [inch]"""


def check_frames(duration: float, speed: float, frame_rate: float) -> None:
    """Raise an error early if a motion cannot be shown in frames; arguments as in `instants`.

    Raises
    ------
    ParameterError
        If a value is out of range.
    InputError
        If there would be too many frames.
    """
    check_number("speed", speed, "1", Gt(0))
    check_number("frame_rate", frame_rate, "1/s", Gt(0))
    count = duration * frame_rate / speed
    if count > MOST_FRAMES:
        raise InputError(
            f"{plain(duration)} s at speed {speed:g} and {frame_rate:g} frames per second are {count:.3g} frames, over "
            f"{MOST_FRAMES}: raise speed, or lower frame_rate"
        )


def instants(run: Session | MachineRun, speed: float = 1.0, frame_rate: float = 25.0) -> np.ndarray:
    """Times of the frames: evenly spaced from the start, the last at the end. (t,) [s]

    Parameters
    ----------
    run : Session or MachineRun
    speed : float        Of the motion shown over that of the machine, > 0: 0.1 is ten times slower. [-]
    frame_rate : float   > 0. [s^-1]

    Raises
    ------
    InputError
        As `check_frames`.
    """
    start, end = float(run.time[0]), float(run.time[-1])
    check_frames(end - start, speed, frame_rate)
    steps = max(int(np.ceil((end - start) * frame_rate / speed - 1e-9)), 1)
    return np.append(start + np.arange(steps) * speed / frame_rate, end)


def data(run: Session | MachineRun, time: np.ndarray) -> dict[str, Any]:
    """Numbers of the frames at times (t,).

    Returns
    -------
    dict
        title; time (t,) [s]; kind: "above", "space" or "slide"; known (r,): times of all results [s]; force (t,) or
        None: size of the user's [N]; slips: whether a wheel slips in any frame; machine, and plane or None: numbers of
        `moving_flat` and `moving_platform`; frame: strokes of the machine at a place, or None of a slide.
    """
    parts, shapes = parts_of(run, time), guides_of(run)
    trace = parts_of(run).handle
    numbers: dict[str, Any] = {
        "title": run.title,
        "time": parts.time,
        "kind": parts.outline.seen,
        "known": run.time,
        "force": None if parts.force is None else np.linalg.norm(parts.force, axis=1),
        "slips": bool(np.any(parts.sliding)),
        "guided": bool(shapes),
        "plane": None,
    }
    outline, pair = parts.outline, _widest(trace) if len(parts.axes) > 1 else None
    flat, frame = np.zeros((0, 2)), None
    if isinstance(outline, Slides):
        machine = moving_flat.slide(parts, outline.drum, shapes)
        machine |= {"time": parts.time, "known": run.time, "history": 1e3 * trace}
    else:
        frame = outline.frames(parts.configuration, parts.steering, parts.sliding, parts.cylinder_angle)
        corners = 1e3 * np.array([bounds(frame(place)) for place in range(len(parts.time))])
        if numbers["kind"] == "space":
            machine = moving_platform.data(parts, shapes, corners.min(axis=(0, 1)), corners.max(axis=(0, 1)))
        else:
            machine, flat, pair = {}, corners, [0, 1]
    if pair is not None:
        numbers["plane"] = moving_flat.in_plane(run, parts, trace, pair, flat, shapes)
    return {**numbers, "machine": machine, "frame": frame}


def _widest(trace: np.ndarray) -> list[int]:
    """Places of the two axes with the most motion, in order."""
    extent = np.ptp(trace, axis=0)
    return sorted(np.argsort(-extent, kind="stable")[:2].tolist())


def draw(axes: Mapping[str, Axes], numbers: Mapping[str, Any], place: int) -> None:
    """Draw one frame into the axes of `panels`."""
    upto = int(np.searchsorted(numbers["known"], numbers["time"][place], side="right"))
    machine = numbers["machine"]
    for name, ax in axes.items():
        ax.clear()
        if name in ("above", "space"):
            pictures.paint(ax, numbers["frame"](place), scale=1e3)
        if name in ("above", "plane"):
            moving_flat.draw_plane(ax, numbers["plane"], place, upto)
        elif name == "space":
            moving_platform.draw(ax, machine, place)
        elif name == "history":
            moving_flat.draw_history(ax, machine, place, upto)
        else:
            moving_flat.draw_slide(ax, machine, place, int(name.removeprefix("slide ")))
        # Ticks are made when a frame is drawn, perhaps in another style.
        ax.tick_params(labelsize=9)
    words = f"t = {numbers['time'][place]:.3f} s"
    if numbers["force"] is not None and np.any(numbers["force"]):
        words += f",  user's force {numbers['force'][place]:.1f} N"
    lines = textwrap.wrap(numbers["title"], 60)
    next(iter(axes.values())).set_title("\n".join([*lines, words]), loc="left", fontsize=9)


def panels(numbers: Mapping[str, Any]) -> dict[str, float]:
    """Names of the axes from the top, with the height of each over its width."""

    def shape(corners: tuple[np.ndarray, np.ndarray]) -> float:
        width, height = corners[1] - corners[0]
        return float(height / width)

    machine, plane = numbers["machine"], numbers["plane"]
    if numbers["kind"] == "above":
        return {"above": shape(plane["bounds"])}
    if numbers["kind"] == "space":
        return {"space": shape(machine["bounds"]), "plane": shape(plane["bounds"])}
    low, high = machine["range"]
    across = 2.15 * machine["cylinder_radius"] + 3.0 * machine["wheel_radius"]
    found = {f"slide {place}": across / (high - low) for place in range(len(machine["axes"]))}
    return {**found, "history": 0.35, **({} if plane is None else {"plane": shape(plane["bounds"])})}


class Film(NamedTuple):
    """A figure that shows one frame after another."""

    figure: Figure
    show: Callable[[int], None]
    """Draw a frame."""
    time: np.ndarray
    """Of the frames. (t,) [s]"""


def film(run: Session | MachineRun, speed: float = 1.0, frame_rate: float = 25.0) -> Film:
    """Frames of a run, for an animation or a file; arguments and errors as in `instants`."""
    numbers = data(run, instants(run, speed, frame_rate))
    shapes = panels(numbers)
    tallest = 4.6 if len(shapes) == 1 else 2.6 if numbers["kind"] == "slide" else 3.8
    several = numbers["kind"] == "slide" and len(shapes) > 2
    caps = [1.3 if several and name.startswith("slide") else tallest for name in shapes]
    heights = [min(max((_WIDTH - 0.9) * one, 0.9), cap) for one, cap in zip(shapes.values(), caps, strict=True)]
    with style.styled():
        rows = 1 if numbers["force"] is None else 2
        figure, axes = style.figure(_WIDTH, sum(heights) + 0.75 * len(heights) + 0.4 * rows, len(heights), 1,
                                    squeeze=False, height_ratios=heights)  # fmt: skip
        figure.set_dpi(_DPI)
        figure.get_layout_engine().set(w_pad=_PAD, h_pad=_PAD)  # type: ignore[union-attr]
        named = dict(zip(shapes, axes.ravel(), strict=True))
        draw(named, numbers, 0)
        _key(figure, numbers, speed)
        # The layout of the first frame is kept, so that nothing jumps.
        for _ in range(2):  # with the tick labels of the first layout
            figure.draw_without_rendering()
        figure.set_layout_engine("none")

    def show(place: int) -> None:
        with style.styled():
            draw(named, numbers, place)

    return Film(figure, show, numbers["time"])


def _key(figure: Figure, numbers: Mapping[str, Any], speed: float) -> None:
    """Name what is drawn, below."""
    from matplotlib.lines import Line2D

    key: list[Any] = [Line2D([], [], color=moving_flat.HANDLE, marker="o", mec="white", lw=1.4, label="handle")]
    if numbers["force"] is not None and np.any(numbers["force"]):
        most = plain(float(np.max(numbers["force"])), 2)
        key.append(Line2D([], [], color=moving_flat.FORCE, lw=2.0, label=f"user's force, up to {most} N"))
    if numbers["guided"]:
        key.append(Line2D([], [], color=moving_flat.GUIDE, lw=1.4, ls="--", label="what guides it"))
    if numbers["slips"]:
        key.append(Line2D([], [], color=pictures.SLIPS, lw=4.0, label="wheel that slips"))
    if speed != 1.0:
        key.append(Line2D([], [], ls="none", label=f"shown at {speed:g} times real time"))
    figure.legend(handles=key, loc="outside lower center", ncols=2, fontsize=8)


def animation(run: Session | MachineRun, *, speed: float = 1.0, frame_rate: float = 25.0) -> FuncAnimation:
    """Animation of a run with matplotlib."""
    from matplotlib.animation import FuncAnimation

    made = film(run, speed, frame_rate)
    return FuncAnimation(
        made.figure, lambda place: made.show(place), frames=len(made.time), interval=1e3 / frame_rate, repeat=False
    )

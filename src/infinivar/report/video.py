"""Videos of machines in motion: GIF files through Pillow, MP4 files through ffmpeg."""

from __future__ import annotations

import contextlib
import shutil
import subprocess
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from infinivar._core import extras
from infinivar.errors import InputError, ParameterError, printable, require
from infinivar.figures import moving_machine
from infinivar.report.output import all_files_or_none

_ENDINGS = (".gif", ".mp4")

_COLOURS = 128
"""Of each frame of a GIF."""

_LOWEST = 100
"""Frame rates of a GIF divide this. [s^-1]"""


def check_video(path: Path, frame_rate: float = 25.0) -> None:
    """Raise an error early if no video of this name and frame rate can be made.

    Raises
    ------
    InputError
        If the ending is of no known format, ffmpeg is not found for an MP4 file, or a GIF file cannot have the frame rate.
    """
    kind = path.suffix.lower()
    if kind not in _ENDINGS:
        raise InputError(f"{printable(path)}: a video must end in .gif or .mp4")
    if kind == ".mp4" and _ffmpeg() is None:
        raise InputError(
            f"{printable(path)}: an MP4 file needs ffmpeg, which is not found: install it, such as with "
            "pip install 'infinivar[robots]', or write a .gif file"
        )
    if kind == ".gif":
        hundredths = _LOWEST / frame_rate if frame_rate > 0 else 0.0
        whole = hundredths >= 1.0 and abs(hundredths - round(hundredths)) < 1e-9
        require(
            whole,
            "frame_rate",
            f"{frame_rate:g}",
            "100 over a whole number for a GIF file, such as 20, 25 or 50",
            "1/s",
        )


def _ffmpeg() -> str | None:
    """Program on the path, or that of the package imageio-ffmpeg."""
    found = shutil.which("ffmpeg")
    if found is None and extras.there("imageio_ffmpeg"):
        import imageio_ffmpeg

        try:
            found = imageio_ffmpeg.get_ffmpeg_exe()
        except RuntimeError:  # the package without the program
            return None
    return found


def save(
    run: Any,
    path: Path,
    *,
    speed: float = 1.0,
    frame_rate: float = 25.0,
    renderer: str = "drawing",
    progress: Callable[[float], None] | None = None,
) -> Path:
    """Write the video of a session or run; see `infinivar.analysis.animated.Animated.save_video`."""
    require(renderer in ("drawing", "mujoco"), "renderer", repr(renderer), "drawing or mujoco")
    time = moving_machine.instants(run, speed, frame_rate)
    check_video(path, frame_rate)
    with all_files_or_none(path) as (made,):
        if renderer == "mujoco":
            from infinivar.report.scene.render import frames

            shown: Iterable[np.ndarray] = frames(run, time)
        else:
            shown = _drawn(run, speed, frame_rate)
        write(made, _counted(shown, len(time), progress or (lambda share: None)), frame_rate)
    return path


def _drawn(run: Any, speed: float, frame_rate: float) -> Iterator[np.ndarray]:
    """Frames as images (h, w, 3)."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    film = moving_machine.film(run, speed, frame_rate)
    canvas = FigureCanvasAgg(film.figure)
    for place in range(len(film.time)):
        film.show(place)
        canvas.draw()
        yield np.asarray(canvas.buffer_rgba())[..., :3].copy()


def _counted(frames: Iterable[np.ndarray], count: int, progress: Callable[[float], None]) -> Iterator[np.ndarray]:
    for place, frame in enumerate(frames, 1):
        yield frame
        progress(place / count)


def write(path: Path, frames: Iterator[np.ndarray], frame_rate: float) -> None:
    """Write frames, images (h, w, 3) of bytes, one after another.

    Raises
    ------
    InputError
        If ffmpeg fails.
    """
    if path.suffix.lower() == ".gif":
        _write_gif(path, frames, frame_rate)
    else:
        _write_mp4(path, frames, frame_rate)


def _write_gif(path: Path, frames: Iterator[np.ndarray], frame_rate: float) -> None:
    from PIL import Image

    def coloured(frame: np.ndarray) -> Any:
        image = Image.fromarray(frame)
        return image.quantize(_COLOURS, method=Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE)

    first = coloured(next(frames))
    rest = (coloured(frame) for frame in frames)
    with path.open("wb") as file:  # closed here, if a frame cannot be drawn
        first.save(
            file, "gif", save_all=True, append_images=rest, duration=round(1e3 / frame_rate), loop=0, optimize=False
        )


def _write_mp4(path: Path, frames: Iterator[np.ndarray], frame_rate: float) -> None:
    program = _ffmpeg()
    if program is None:
        raise ParameterError("path must not end in .mp4 without ffmpeg")
    first = next(frames)
    height, width, _ = first.shape
    taken = ["-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{width}x{height}", "-r", f"{frame_rate:g}", "-i", "-"]
    # Players need even sides and this order of colours.
    made = ["-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-pix_fmt", "yuv420p", "-movflags", "+faststart", str(path)]
    command = [program, "-loglevel", "error", *taken, *made]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL) as running:
        assert running.stdin is not None
        assert running.stderr is not None
        try:
            running.stdin.write(first.tobytes())
            for frame in frames:
                running.stdin.write(frame.tobytes())
        except BrokenPipeError:
            pass  # what it says tells why
        except BaseException:
            running.kill()
            raise
        finally:
            with contextlib.suppress(BrokenPipeError):
                running.stdin.close()
        said = running.stderr.read().decode("utf-8", "replace").strip()
    if running.returncode != 0 or not path.is_file():
        raise InputError(f"{path.name}: ffmpeg failed: {said.splitlines()[-1] if said else 'no message'}")

"""What results of machines in motion have in common: an animation, a video, and a scene for MuJoCo."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

if TYPE_CHECKING:
    from matplotlib.animation import FuncAnimation


class Animated:
    """Base of results with the motion of a planar cobot, slide, platform, arm or robot; no other machine is drawn in motion."""

    __slots__ = ()
    _presenter: Callable[..., Any]

    def animation(self, *, speed: float = 1.0, frame_rate: float = 25.0) -> FuncAnimation:
        """The machine in motion, in real time or slower, as an animation of matplotlib.

        Parameters
        ----------
        speed : float        Of the motion shown over that of the machine, > 0: 0.1 is ten times slower. [-]
        frame_rate : float   > 0. [s^-1]

        Raises
        ------
        InputError
            If a value is out of range, there would be too many frames, or the machine has no handle.
        """
        return self._presenter("animation")(self, speed=speed, frame_rate=frame_rate)

    def save_video(
        self,
        path: str | Path,
        *,
        speed: float = 1.0,
        frame_rate: float = 25.0,
        renderer: Literal["drawing", "mujoco"] = "drawing",
        progress: Callable[[float], None] | None = None,
    ) -> Path:
        """Write a video of the machine in motion.

        Parameters
        ----------
        path : path              Ends in .gif, or in .mp4 where ffmpeg is found.
        speed, frame_rate        As in `animation`. A GIF shows each frame for a whole number of hundredths of a second.
        renderer : str           "drawing": frames of `animation`; "mujoco": the scene of `to_mujoco`, with the extra ``robots``.
        progress : callable      Called with the share done.

        Returns
        -------
        Path   The file.

        Raises
        ------
        InputError
            As for `animation`; or if the file has another ending or cannot be written, ffmpeg is not found, or MuJoCo cannot
            draw without a display. Then nothing is written.
        """
        options: dict[str, Any] = {"speed": speed, "frame_rate": frame_rate, "renderer": renderer}
        return self._presenter("video")(self, Path(path), progress=progress, **options)

    def to_mujoco(self, path: str | Path) -> list[Path]:
        """Write the machine as a scene for MuJoCo, and its motion beside it; MuJoCo itself is not needed.

        Bodies have the masses and moments of inertia of the machine, walls, paths and fixtures are translucent. The scene is
        for looking at the motion: friction, motors and control are not in it.

        Parameters
        ----------
        path : path   Of the scene, ends in .xml. The motion is beside it, ends in .npz, and has `time`, `qpos` in the order of
            the joints, `handle` and `force`.

        Returns
        -------
        list of Path   Scene and motion.

        Raises
        ------
        InputError
            If the machine has no handle, or a file has another ending or cannot be written.
        """
        return self._presenter("scene")(self, Path(path))

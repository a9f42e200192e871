"""Rules for the examples in the gallery: no warnings, a limited processor time, animations as GIF files."""

import time
import warnings
import weakref
from pathlib import Path
from typing import Any

from sphinx.util.logging import getLogger

LONGEST = 40.0
"""Longest processor time of an example, on a slow machine. [s]"""

LOOKS = {
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.prop_cycle": "cycler('color', ['0072B2', 'D55E00', '009E73', 'CC79A7', 'E69F00', '56B4E9'])",
    "font.size": 9,
    "legend.fontsize": 8,
    "legend.frameon": False,
}

LARGEST = 500_000
"""Largest file of an animation. [byte]"""

_saved: weakref.WeakSet = weakref.WeakSet()
"""Animations of figures that are not pyplot's, and are never closed."""

_running: dict[str, tuple[float, warnings.catch_warnings]] = {}


def reset(gallery_conf: dict, example: str, when: str) -> None:
    """Run before and after each example; a warning that it logs fails a build with ``-W``."""
    if when == "before":
        import matplotlib

        matplotlib.rcParams.update(LOOKS)
        filters = warnings.catch_warnings()
        filters.__enter__()
        warnings.simplefilter("error")
        _running[example] = time.process_time(), filters
        return
    started, filters = _running.pop(example)
    filters.__exit__(None, None, None)
    spent = time.process_time() - started
    if spent > LONGEST:
        getLogger(__name__).warning("%s takes %.1f s, more than %g s", example, spent, LONGEST)


def _get_sg_image_scraper():  # the name by which sphinx-gallery asks a module
    return animations


def animations(block: tuple, block_vars: dict, gallery_conf: dict) -> str:
    """Save the animations of a block's open figures, before its other figures are saved, and close theirs."""
    import matplotlib.pyplot as plt
    from matplotlib.animation import Animation
    from sphinx_gallery.scrapers import figure_rst

    files = []
    for found in block_vars["example_globals"].values():
        if not isinstance(found, Animation) or not _is_new(found):
            continue
        path = Path(block_vars["image_path_iterator"].next()).with_suffix(".gif")
        found.save(path, writer="pillow")
        plt.close(found._fig)  # does nothing to a figure that is not pyplot's
        files.append(str(path))
        if path.stat().st_size > LARGEST:
            getLogger(__name__).warning("%s has more than %d bytes", path.name, LARGEST)
    return figure_rst(files, gallery_conf["src_dir"], "Animation")


def _is_new(found: Any) -> bool:
    """Whether an animation has not been saved before."""
    import matplotlib.pyplot as plt

    number = getattr(found._fig, "number", None)
    if number is not None:
        return plt.fignum_exists(number)
    new = found not in _saved
    _saved.add(found)
    return new

"""Rules for the examples in the gallery: no warnings, and at most ten seconds of processor time."""

import time
import warnings

from sphinx.util.logging import getLogger

LONGEST = 10.0
"""Longest processor time of an example. [s]"""

LOOKS = {
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.prop_cycle": "cycler('color', ['0072B2', 'D55E00', '009E73', 'CC79A7', 'E69F00', '56B4E9'])",
    "font.size": 9,
    "legend.fontsize": 8,
    "legend.frameon": False,
}

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

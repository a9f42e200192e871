"""Exact rolling theory, tabulated: what the creep laws are held against."""

from __future__ import annotations

import tomllib
from importlib import resources
from typing import Any


def lateral_creep() -> list[dict[str, Any]]:
    """Curves of steady lateral creep, one for each shape of the contact patch.

    Returns
    -------
    list of dict
        ``a_over_b``, float, rolling over lateral semi-axis; ``scaled_creepage`` k and ``force_ratio`` fu/(mu P), (n,)
        float; the linear law is force_ratio = 3 k. Poisson ratio 0.3, error about 0.001 of the force ratio. [-]

    Source: kalker1990 (theory); computed with an independent program.
    """
    import numpy as np

    text = (resources.files("infinivar.contact") / "data" / "lateral_creep_exact.toml").read_text("utf-8")
    return [{name: np.asarray(value) for name, value in curve.items()} for curve in tomllib.loads(text)["curve"]]

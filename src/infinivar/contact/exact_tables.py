"""Tables of exact rolling theory, the reference for the creep laws."""

from __future__ import annotations

from typing import Any

from infinivar._core import files


def lateral_creep() -> list[dict[str, Any]]:
    """Curves of steady lateral creep, one for each shape of the contact patch.

    Returns
    -------
    list of dict
        ``a_over_b``, float, rolling over lateral semi-axis; ``scaled_creepage`` k and ``force_ratio`` fu/(mu P), (n,)
        float; the linear law is force_ratio = 3 k. Poisson ratio 0.3, error about 0.001 of the force ratio. [-]

    Source: kalker1990 (theory); computed with an independent program.
    """
    return _curves("lateral_creep_exact", "curve")


def spin_creep() -> list[dict[str, Any]]:
    """Curves of steady lateral creep with spin, one for each shape of the contact patch and value of spin.

    Returns
    -------
    list of dict
        ``a_over_b`` and ``spin`` psi = C23 G (a b)^1.5 phi/(mu N), float; ``scaled_creepage`` k, ``lateral_force`` over
        mu N and ``moment`` over mu N sqrt(a b), (n,) float; a positive creepage causes a positive force. Poisson ratio
        0.3, error about 0.002. [-]

    Source: kalker1990 (theory); computed with an independent program.
    """
    return _curves("rolling_exact", "spin")


def combined_creep() -> list[dict[str, Any]]:
    """Curves of steady combined creep, one for each shape of the contact patch and direction of creep.

    Returns
    -------
    list of dict
        ``a_over_b``, float; ``direction``, float, 0 longitudinal, 90 lateral [deg]; ``scaled_creepage`` k, of which
        k cos(direction) is C11 G a b ux/(3 mu N) and k sin(direction) is C22 G a b uy/(3 mu N); ``longitudinal_force``
        and ``lateral_force`` over mu N, ``moment`` over mu N sqrt(a b), (n,) float; a positive creepage causes a positive
        force. Poisson ratio 0.3, error about 0.001. [-]

    Source: kalker1990 (theory); computed with an independent program.
    """
    return _curves("rolling_exact", "combined")


def _curves(file: str, table: str) -> list[dict[str, Any]]:
    import numpy as np

    curves = files.shipped("contact", file)[table]
    return [{name: np.asarray(value) for name, value in curve.items()} for curve in curves]

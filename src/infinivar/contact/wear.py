"""Wear of the dry contact by Archard's law; an order-of-magnitude estimate."""

from __future__ import annotations

import math

from infinivar._core.array_namespace import Array, namespace, safe_divide


def rolling_distance(
    depth: Array,
    track_radius: Array,
    track_width: Array,
    lateral_force: Array,
    creepage: Array,
    friction: Array,
    hardness: Array,
    wear_coefficient: Array,
) -> Array:
    r"""Rolling distance after which the track has worn to a given depth.

    Archard's volume per load and sliding distance, k/H, is related to the friction work: where the patch slides, the
    traction is mu p, so the volume worn per metre of rolling is the creep work over mu, times k/H.

    .. math:: V' = \frac{k}{H} \frac{f_u \upsilon}{\mu}, \qquad s = \frac{h \, 2 \pi r \, w}{V'}

    Parameters
    ----------
    depth : (...,) float              h. [m]
    track_radius : (...,) float       r of the wearing body. [m]
    track_width : (...,) float        w of the worn track: the lateral width of the patch. [m]
    lateral_force : (...,) float      fu. [N]
    creepage : (...,) float           u/abs(v), with the sign of the force. [-]
    friction : (...,) float           mu. [-]
    hardness : (...,) float           H of the softer body. [Pa]
    wear_coefficient : (...,) float   Archard's dimensionless k: 1e-3 to 1e-4 for similar dry metals, 1e-6 and less if
        lubricated. Measured values for one material pair scatter by a factor of ten. [-]

    Returns
    -------
    (...,) float   inf without force or wear. [m]

    Source: archard1953.
    """
    xp = namespace(depth, track_radius, track_width, lateral_force, creepage, friction, hardness, wear_coefficient)
    volume_per_distance = wear_coefficient / hardness * lateral_force * creepage / friction
    volume = depth * 2.0 * math.pi * track_radius * track_width
    return safe_divide(xp, volume, xp.asarray(volume_per_distance), math.inf)

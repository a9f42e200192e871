r"""Rate-independent friction that follows a deflection: hysteresis of springs and belts.

.. math:: \dot z = \sigma\,\dot x \left(1 - \mathrm{sgn}(\dot x)\,z/F_c\right), \qquad \sigma = F_c/x_s

z is the friction force, positive where it opposes a growing deflection x; F_c is its largest value and x_s the presliding
deflection. With the stored energy z^2/(2 sigma), the power lost is ``|x'| z^2/F_c >= 0``: the law never creates energy.

Source: dahl1968, with exponent 1.
"""

from __future__ import annotations

from infinivar._core.array_namespace import Array, namespace


def after(force: Array, travel: Array, largest: Array, presliding: Array) -> Array:
    """Friction force after a one-way change of the deflection.

    Parameters
    ----------
    force : (...,) float        z before, of magnitude <= `largest`. [N] or [N m]
    travel : (...,) float       Change of the deflection, without reversal. [m] or [rad]
    largest : (...,) float      F_c, > 0. [N] or [N m]
    presliding : (...,) float   x_s, > 0. [m] or [rad]

    Returns
    -------
    (...,) float   z after it; inputs broadcast.

    Source: dahl1968, integrated along x.
    """
    xp = namespace(force, travel, largest, presliding)
    bound = largest * xp.sign(travel)
    return bound + (force - bound) * xp.exp(-xp.abs(travel) / presliding)


def slope(force: Array, direction: Array, largest: Array, presliding: Array) -> Array:
    """Slope dz/dx of the friction force by the deflection, >= 0.

    Parameters
    ----------
    force : (...,) float       z, of magnitude <= `largest`. [N] or [N m]
    direction : (...,) float   Sign of the deflection's speed, or the speed. At rest the slope is that of a reversal from z = 0.
    largest, presliding        As in `after`.

    Returns
    -------
    (...,) float   [N m^-1] or [N m rad^-1]

    Source: dahl1968.
    """
    xp = namespace(force, direction, largest, presliding)
    return (largest - xp.sign(direction) * force) / presliding


def derivatives(force: Array, direction: Array, largest: Array, presliding: Array, orders: int) -> list[Array]:
    """z and its derivatives by the deflection between reversals, up to an order.

    Source: dahl1968, differentiated.
    """
    xp = namespace(force, direction, largest, presliding)
    found = [force, slope(force, direction, largest, presliding)]
    for _ in range(orders - 1):
        found.append(-xp.sign(direction) * found[-1] / presliding)
    return found[: orders + 1]


def loss(force: Array, speed: Array, largest: Array) -> Array:
    """Power lost, ``|x'| z^2/F_c >= 0``. [W]

    Source: dahl1968; the remainder of ``z x'`` after the change of ``z^2/(2 sigma)``.
    """
    xp = namespace(force, speed, largest)
    return xp.abs(speed) * force * force / largest


def stored(force: Array, speed: Array, largest: Array, presliding: Array) -> Array:
    """Power into the stored energy ``z^2/(2 sigma)``: ``z z'/sigma``. [W]

    Source: dahl1968.
    """
    return force * slope(force, speed, largest, presliding) * speed * presliding / largest


def energy(force: Array, largest: Array, presliding: Array) -> Array:
    """Stored energy ``z^2/(2 sigma)``. [J]

    Source: dahl1968.
    """
    return 0.5 * force * force * presliding / largest

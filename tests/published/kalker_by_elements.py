r"""Linear rolling-contact coefficients from first principles, to hold the tabulated ones against.

Two equal half-spaces stick together in an ellipse through which they roll steadily towards +x. Without slip the
difference u of their surface displacements grows along the rolling direction as the rigid creepages say::

    du_x/dx = upsilon_x - phi y,    du_y/dx = upsilon_y + phi x,

and by Boussinesq and Cerruti a traction p on the one and -p on the other half-space causes, with r the distance,

    u_x = 1/(pi G) int [((1-nu)/r + nu dx^2/r^3) p_x + nu dx dy/r^3 p_y] dA,  and u_y likewise.

Traction must vanish where material enters. The ellipse is cut into strips along x, finer towards the tips, each strip
into cells of equal length. Rectangles of constant traction lie a quarter of a cell behind the cells; the equations,
differences of u over one length, are centred a quarter ahead of the middles of the cells, the last one in front of the
last rectangle. That leaves the leading edge unloaded, and keeps C32 = C23 on every grid.
"""

import numpy as np


def linear_coefficients(a_over_b, poisson, cells):
    """C11, C22, C23, C32 (which is C23 by reciprocity) and C33, extrapolated in the size of the elements.

    Parameters
    ----------
    a_over_b, poisson : float
    cells : (int, int)   Rectangles along x, and strips on one side of the x axis, of the coarsest of three grids.

    Returns
    -------
    (5,) float   The error starts with the first and second power of the element size; both are eliminated.
    """
    coarse, middle, fine = (on_grid(a_over_b, poisson, cells[0] * n, cells[1] * n) for n in (1, 2, 4))
    return (8 * fine - 6 * middle + coarse) / 3


def on_grid(a_over_b, poisson, along, strips):
    """The five coefficients on one grid, for G = 1 and a b = 1."""
    a, b = np.sqrt(a_over_b), 1 / np.sqrt(a_over_b)
    angle = np.linspace(0, np.pi / 2, strips + 1)
    edges = b * np.sin(angle)
    widths = np.diff(edges)
    # Rectangles of the area of their strip.
    lengths = np.diff(a * b * (angle + np.sin(angle) * np.cos(angle))) / widths / along
    middles = np.arange(along) + 0.5 - along / 2
    length, width, y = (np.repeat(values, along) for values in (lengths, widths, (edges[1:] + edges[:-1]) / 2))
    x = np.tile(middles, strips) * length
    load_x, equation_x = x - length / 4, x + length / 4
    areas = 2 * length * width  # with the mirror image

    def gradient(side):
        """du/dx at the equations by unit tractions on the rectangles of one side of the x axis."""
        ahead, behind = (
            displacements(x[:, None] - load_x, y[:, None] - side * y, length, width, poisson)
            for x in (equation_x + length / 2, equation_x - length / 2)
        )
        return [(front - back) / length[:, None] for front, back in zip(ahead, behind, strict=True)]

    def resultants(parity, creeps):
        """Fx, Fy, Mz for creeps whose p_x is even (1) or odd (-1) in y, and p_y the other way."""
        (xx, xy, yy), (mirror_xx, mirror_xy, mirror_yy) = gradient(1), gradient(-1)
        matrix = np.block(
            [
                [xx + parity * mirror_xx, xy - parity * mirror_xy],
                [xy + parity * mirror_xy, yy - parity * mirror_yy],
            ]
        )
        tractions = np.linalg.solve(matrix / np.pi, np.array(creeps).reshape(len(creeps), -1).T)
        p_x, p_y = tractions[: len(x)], tractions[len(x) :]
        return areas @ p_x, areas @ p_y, areas @ (load_x[:, None] * p_y - y[:, None] * p_x)

    none, one = np.zeros(len(x)), np.ones(len(x))
    fx, _, _ = resultants(1, [(one, none)])
    _, fy, mz = resultants(-1, [(none, one), (-y, equation_x)])
    return np.array([-fx[0], -fy[0], -fy[1], mz[0], -mz[1]])


def displacements(x, y, length, width, poisson):
    """pi G times u_x by p_x, u_x by p_y (or u_y by p_x), u_y by p_y of unit tractions on rectangles centred at the origin."""
    along, across, mixed = 0.0, 0.0, 0.0
    for sign_x in (1, -1):
        for sign_y in (1, -1):
            right, up = x + sign_x * length / 2, y + sign_y * width / 2
            sign = sign_x * sign_y
            along = along + sign * right * np.arcsinh(up / np.abs(right))  # int y^2/r^3
            across = across + sign * up * np.arcsinh(right / np.abs(up))  # int x^2/r^3
            mixed = mixed - sign * np.hypot(right, up)
    return (1 - poisson) * along + across, poisson * mixed, along + (1 - poisson) * across

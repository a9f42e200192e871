"""Roots within a bracket: functions that fall towards its ends, with NumPy and compiled."""

import numpy as np
import pytest

from internals import rising_root

SHIFT = np.linspace(-1.0, 1.0, 21)


def root_of(xp, shift, inward):
    """Zero of sin(x - shift), which falls beyond a quarter turn: at x = shift alone it rises."""

    def rises(x):
        return xp.sin(x - shift), xp.cos(x - shift)

    edge = 5.0 + 0.0 * shift
    return rising_root(xp, rises, -edge, edge, 60, 0.8 * shift, inward)


@pytest.mark.parametrize("library", ["numpy", pytest.param("jax", marks=pytest.mark.slow)])
def test_ends_move_inward_to_where_the_function_rises(library):
    if library == "numpy":
        found = root_of(np, SHIFT, 4)
    else:
        jax = pytest.importorskip("jax")
        from internals import local_engine as local

        with local(jax):
            found = np.asarray(jax.jit(lambda shift: root_of(jax.numpy, shift, 4))(SHIFT))
            slopes = np.asarray(jax.vmap(jax.grad(lambda shift: root_of(jax.numpy, shift, 4)))(SHIFT))
        np.testing.assert_allclose(slopes, 1.0, rtol=1e-9)
    np.testing.assert_allclose(found, SHIFT, atol=1e-12)
    assert not np.allclose(root_of(np, SHIFT, 0), SHIFT, atol=1e-3)

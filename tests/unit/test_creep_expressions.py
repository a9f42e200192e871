"""The public creep laws on CasADi expressions."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from infinivar import ParameterError
from infinivar.contact import creep

casadi = pytest.importorskip("casadi")

pytestmark = pytest.mark.filterwarnings("ignore::FutureWarning")  # CasADi says once that it takes NumPy's functions
SIZES = np.array([-2.0, -0.9, -0.3, 0.0, 1e-6, 0.4, 0.7, 0.99, 1.0, 1.5])


@pytest.mark.parametrize("law", creep.LAWS)
@pytest.mark.parametrize("kind", ["SX", "MX"])
@pytest.mark.parametrize("function", [creep.lateral_force, creep.lateral_creep])
def test_expressions_have_the_values_of_numbers(law, kind, function):
    x = getattr(casadi, kind).sym("x")
    made = casadi.Function("made", [x], [function(law, x, 0.6, 0.28)])
    assert_allclose([float(made(size)) for size in SIZES], function(law, SIZES, 0.6, 0.28), rtol=1e-12, atol=1e-15)


@pytest.mark.parametrize("kind", ["SX", "MX"])
def test_derivatives_and_columns(kind):
    x = getattr(casadi, kind).sym("x", 3)
    force = creep.lateral_force("exact", x)
    slope = casadi.Function("slope", [x], [casadi.jacobian(force, x)])
    at, step = np.array([-0.5, 0.1, 0.6]), 1e-6
    straight = (creep.lateral_force("exact", at + step) - creep.lateral_force("exact", at - step)) / (2.0 * step)
    assert_allclose(np.array(slope(at)), np.diag(straight), rtol=1e-6, atol=1e-9)


@pytest.mark.parametrize("function", [creep.lateral_force, creep.lateral_creep])
def test_the_patch_is_of_numbers(function):
    x = casadi.SX.sym("x")
    with pytest.raises(ParameterError, match="a_over_b must be a number, got a CasADi expression"):
        function("exact", 0.3, x)
    with pytest.raises(ParameterError, match=r"poisson must be a number for a CasADi expression, got \[0.2, 0.3\]"):
        function("exact", x, 1.0, [0.2, 0.3])

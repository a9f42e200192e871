"""Laws that depend on each other in an algebraic loop, such as the friction of a gear and of a screw in one drive."""

import itertools

import numpy as np
import pytest
import sympy

from infinivar.bondgraph import BondGraphError
from internals import LawValue
from internals import ordered_loops as ordered
from sampled import sampled


def laws(matrix, constant, slopes):
    """Laws ``f_i = k_i T_i`` with another slope on each side of zero, and ``T = a + G f``."""
    symbols = sympy.symbols(f"f0:{len(constant)}", real=True)
    made = []
    for place, symbol in enumerate(symbols):
        argument = sympy.Dummy(real=True)
        above, below = map(sympy.Float, slopes[place])
        formula = sympy.Piecewise((above * argument, argument > 0), (below * argument, True), evaluate=False)
        row = zip(matrix[place], symbols, strict=True)
        value = sympy.Float(constant[place]) + sum(sympy.Float(gain) * other for gain, other in row)
        made.append(LawValue(symbol, f"law{place}", ((argument, value),), formula, formula.xreplace({argument: value})))
    return made


def bent(made, curvature):
    """The first of the laws, in its place ``f = 0.3 T + c T^2``, and its solution ``f = 0.3 (a + g f) + c (a + g f)^2``."""
    (argument, value), gain = made[0].arguments[0], sympy.Dummy(real=True)
    # The smaller root of c g^2 f^2 + (0.3 g + 2 c a g - 1) f + 0.3 a + c a^2 = 0, which tends to the law without gain.
    half = (1 - 0.3 * gain - 2 * curvature * argument * gain) / 2
    free = 0.3 * argument + curvature * argument**2
    root = free / (half + sympy.sqrt(half**2 - curvature * gain**2 * free))
    formula = 0.3 * argument + curvature * argument**2
    law = LawValue(
        made[0].symbol, "bent", ((argument, value),), formula, formula.xreplace({argument: value}), (gain, root)
    )
    return [law, *made[1:]]


def evaluated(found):
    known = {}
    for law in found:
        known[law.symbol] = law.value.xreplace(known)
    return known


@sampled("size", [2, 3], every=4)
@pytest.mark.parametrize("seed", [0, 1, *(pytest.param(one, marks=pytest.mark.slow) for one in range(2, 6))])
def test_the_solution_is_that_of_its_signs(size, seed):
    """Against the one consistent combination found by trying all, for weakly coupled laws, which have one solution."""
    random = np.random.default_rng(seed)
    matrix = random.uniform(-0.3, 0.3, (size, size))
    constant, slopes = random.uniform(-1, 1, size), random.uniform(-1, 1, (size, 2))
    made = laws(matrix, constant, slopes)
    found = evaluated(ordered("graph", made))
    consistent = []
    for sides in itertools.product((0, 1), repeat=size):
        slope = np.array([slopes[place][side] for place, side in enumerate(sides)])
        argument = np.linalg.solve(np.eye(size) - matrix * slope, constant)
        if all((value < 0) == bool(side) for value, side in zip(argument, sides, strict=True)):
            consistent.append(slope * argument)
    assert len(consistent) == 1
    assert [float(found[law.symbol]) for law in made] == pytest.approx(consistent[0].tolist(), rel=1e-12)


@sampled("size", [2, 3], every=3)
@pytest.mark.parametrize("seed", range(4))
def test_one_law_of_another_form_joins_the_loop(size, seed):
    """All laws agree with their own values, whichever signs the others have."""
    random = np.random.default_rng(seed)
    matrix, constant = random.uniform(-0.3, 0.3, (size, size)), random.uniform(-1, 1, size)
    slopes = random.uniform(-1, 1, (size, 2))
    found = evaluated(ordered("graph", bent(laws(matrix, constant, slopes), 0.2)))
    value = np.array([float(found[sympy.Symbol(f"f{place}", real=True)]) for place in range(size)])
    argument = constant + matrix @ value
    expected = [slopes[place][int(argument[place] < 0)] * argument[place] for place in range(size)]
    expected[0] = 0.3 * argument[0] + 0.2 * argument[0] ** 2
    assert value.tolist() == pytest.approx(expected, rel=1e-12)


def test_laws_that_wait_for_a_loop_come_after_it():
    """A fourth law needs the loop, the loop does not need it."""
    made = laws(np.full((2, 2), 0.2), [0.5, -0.4], [[0.5, 0.2], [0.3, 0.9]])
    last = sympy.Symbol("g", real=True)
    value = made[0].symbol + made[1].symbol
    found = ordered("graph", [LawValue(last, "last", (), value, value), *made])
    assert found[-1].symbol == last
    assert not evaluated(found)[last].free_symbols


def test_two_laws_of_another_form_are_named():
    made = laws(np.full((2, 2), 0.2), [0.5, -0.4], [[0.5, 0.2], [0.3, 0.9]])
    both = [bent([law, *made], 0.2)[0] for law in made]
    with pytest.raises(BondGraphError, match="depend on each other in an algebraic loop"):
        ordered("graph", both)


def test_laws_without_proportion_are_named():
    made = laws(np.full((2, 2), 0.2), [0.5, -0.4], [[0.5, 0.2], [0.3, 0.9]])
    argument, value = made[0].arguments[0]
    curved = LawValue(made[0].symbol, "curved", made[0].arguments, argument**2, value**2)
    with pytest.raises(BondGraphError, match="the laws of curved, law1 depend on each other in an algebraic loop"):
        ordered("graph", [curved, made[1]])

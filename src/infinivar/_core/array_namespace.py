"""Array namespaces: each formula is written once and runs on NumPy, JAX and other array libraries."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

from infinivar.errors import ParameterError

SETTLED = 1e-12
"""Relative step below which a Newton iteration has converged."""

_USUAL_STEPS = 2
"""Number of steps after which the iterations here have nearly always converged."""

_LEAST_MOVE = 1e-7
"""Step below which a bracketed iteration ends, relative to the width of the bracket. One step of Newton's method follows."""

_Bracket = tuple[Any, Any, Any, Any]
"""Lower and upper end, place, and size of the last move."""

_PLAIN = {float, int, str, bool, type(None)}
"""Types of no array library, and those of NumPy as they are met: most fields of a part are of these."""

Array = Any
"""A float, or an array of any library that follows the Python array API standard."""


def namespace(*arguments: Array) -> Any:
    """Array namespace of the arguments; NumPy for plain numbers. For a part (dataclass) its fields decide.

    Raises
    ------
    TypeError
        If arguments of two array libraries are mixed.
    """
    for argument in arguments:
        if type(argument) not in _PLAIN:
            break
    else:
        import numpy

        return numpy
    found = None
    rest = list(arguments)
    while rest:
        argument = rest.pop()
        kind = type(argument)
        if kind in _PLAIN:
            continue
        # Constants are NumPy arrays, so that these mix with those of any other library.
        if kind.__module__ == "numpy":
            _PLAIN.add(kind)
            continue
        names = getattr(kind, "__dataclass_fields__", None)
        if names is not None:
            rest += [getattr(argument, name) for name in names]
            continue
        get = getattr(argument, "__array_namespace__", None)
        if get is None:
            continue
        candidate = get()
        if found is None or found.__name__ == "numpy":
            found = candidate
        elif candidate.__name__ not in (found.__name__, "numpy"):
            raise TypeError(f"arrays of {found.__name__} and {candidate.__name__} are mixed")
    if found is None:
        import numpy as found
    return found


array_namespace = namespace
"""The public name of `namespace`, for formulas of other packages."""


def recorded(function: Callable[..., Array]) -> Callable[..., Array]:
    """Decorate a function of the package that is too long to trace: generated code calls it by its name.

    It receives scalars: floats, elements of arrays, CasADi expressions, or whole arrays.
    """

    @functools.wraps(function)
    def called(*arguments: Array) -> Array:
        # A simulation calls it with floats, a hundred thousand times.
        for argument in arguments:
            if type(argument) is not float:
                break
        else:
            return function(*arguments)
        record = getattr(namespace(*arguments), "call", None)
        return function(*arguments) if record is None else record(function.__module__, function.__name__, *arguments)

    return called


def as_floats(xp: Any, *values: Array) -> tuple[Array, ...]:
    """Each value as a float64 array of `xp`; accepts integers and lists."""
    return tuple(xp.asarray(value, dtype=xp.float64) for value in values)


def is_number(value: Array) -> bool:
    """Whether a value is one plain number, of Python or NumPy, not many and none of another array library."""
    return namespace(value).__name__ == "numpy" and getattr(value, "ndim", 0) == 0


def plain(value: Array) -> Any:
    """A NumPy scalar as a float, which every array library accepts; any other value unchanged."""
    return float(value) if is_number(value) else value


def finite_floats(xp: Any, **named: Array) -> tuple[Array, ...]:
    """As `as_floats`, for finite values that broadcast to one shape. Values that are being traced are not checked.

    Raises
    ------
    ParameterError
        If a value is not a finite number, or shapes do not broadcast; the message names the argument.
    """
    if xp.__name__ != "numpy":
        return as_floats(xp, *named.values())
    values = common_floats(xp, **named)
    for name, value in zip(named, values, strict=True):
        if not xp.all(xp.isfinite(value)):
            raise ParameterError(f"{name} must be finite, got {value[~xp.isfinite(value)].ravel()[0]}")
    return values


def common_floats(xp: Any, **named: Array) -> tuple[Array, ...]:
    """NumPy arrays of real numbers that broadcast to one shape.

    Raises
    ------
    ParameterError
        If a value is no real number, or shapes do not broadcast; the message names the argument.
    """
    from infinivar._core.arrays import real_array

    values = tuple(real_array(name, value) for name, value in named.items())
    check_broadcast(**{name: value.shape for name, value in zip(named, values, strict=True)})
    return values


def named_floats(xp: Any, **named: Array) -> tuple[Array, ...]:
    """As `as_floats`, of values of any shapes.

    Raises
    ------
    ParameterError
        If a value is no real number; the message names the argument. Values that are being traced are not checked.
    """
    if xp.__name__ != "numpy":
        return as_floats(xp, *named.values())
    from infinivar._core.arrays import real_array

    return tuple(real_array(name, value) for name, value in named.items())


def check_broadcast(**shapes: tuple[int, ...]) -> tuple[int, ...]:
    """The shape to which shapes broadcast, such as those of many points.

    Raises
    ------
    ParameterError
        If there is none; the message names the arguments.
    """
    import numpy as np

    try:
        return np.broadcast_shapes(*shapes.values())
    except ValueError:
        said = {name: shape for name, shape in shapes.items() if shape}
        raise ParameterError(
            f"{' and '.join(said)} must broadcast to one shape, got shapes {' and '.join(map(str, said.values()))}"
        ) from None


def signed_infinity(xp: Any, value: Array) -> Array:
    """Infinity with the sign of `value`; 0 where `value` is 0."""
    infinite = xp.full_like(value, xp.inf)
    return xp.where(value > 0, infinite, xp.where(value < 0, -infinite, 0.0))


def safe_divide(xp: Any, numerator: Array, denominator: Array, otherwise: float) -> Array:
    """Quotient, or `otherwise` where the denominator is zero; gradients stay finite."""
    zero = denominator == 0
    return xp.where(zero, otherwise, numerator / xp.where(zero, 1.0, denominator))


def _repeat(xp: Any, function: Callable[[Any], Any], value: Any, steps: int) -> Any:
    """Apply `function` to `value` `steps` times; in JAX as a loop, since unrolled it takes minutes to compile."""
    if xp.__name__ == "jax.numpy":
        from jax.lax import fori_loop

        return fori_loop(0, steps, lambda _, state: function(state), value)
    if xp.__name__ == "tape":
        return xp.loop(lambda *state: (function(state), False), value, steps)
    for _ in range(steps):
        value = function(value)
    return value


def accumulated(
    xp: Any, combine: Callable[[Any, tuple[Array, ...], tuple[Array, ...]], tuple[Array, ...]], parts: tuple[Array, ...]
) -> tuple[Array, ...]:
    """What the first places along the last axis, up to each, combine to.

    Pairs of places first, then, by themselves, those up to the end of each pair: in as many operations as the axis has binary
    digits. In JAX one place after the other, since unrolled they take minutes to compile.

    Parameters
    ----------
    combine : callable            Of the namespace, parts before and parts after; associative.
    parts : tuple of (..., n)
    """
    if xp.__name__ == "jax.numpy":
        from jax.lax import scan

        def step(held: Any, row: Any) -> Any:
            return (found := combine(xp, held, row)), found

        rows = tuple(xp.moveaxis(xp.asarray(part), -1, 0) for part in parts)
        first = tuple(row[0] for row in rows)
        later = scan(step, first, tuple(row[1:] for row in rows))[1]
        joined = (xp.concat([one[None], rest]) for one, rest in zip(first, later, strict=True))
        return tuple(xp.moveaxis(one, 0, -1) for one in joined)
    count = parts[0].shape[-1]
    if count == 1:
        return parts
    before, after = (tuple(part[..., place : 2 * (count // 2) : 2] for part in parts) for place in (0, 1))
    even = accumulated(xp, combine, combine(xp, before, after))
    odd = combine(xp, tuple(part[..., : (count - 1) // 2] for part in even), tuple(part[..., 2::2] for part in parts))
    found = []
    for part, to_odd, to_even in zip(parts, odd, even, strict=True):
        to_odd = xp.concat([part[..., :1], to_odd], axis=-1)
        pairs = xp.stack([to_odd[..., : count // 2], to_even], axis=-1)
        whole = xp.reshape(pairs, (*pairs.shape[:-2], 2 * (count // 2)))
        found.append(xp.concat([whole, to_odd[..., count // 2 :]], axis=-1))
    return tuple(found)


def newton(xp: Any, step: Callable[[Array], Array], start: Array, steps: int) -> Array:
    """Repeat `step` until it converges, at most `steps` times.

    The iteration stops when every finite element has converged. `step` returns nan for elements without a solution, and
    they stay nan. Elements that have not converged at the end become nan as well. Convergence is quadratic, so a step
    below `SETTLED` leaves an error of about its square.

    The last step carries the derivatives: at a root, the derivative of a Newton step with respect to its start is zero,
    and with respect to any other variable it equals that of the root.
    """
    value, settled = start, False
    if xp.__name__ == "jax.numpy":
        value, steps = _settled_in_jax(xp, step, start, steps - 1), 1
    if xp.__name__ == "tape":

        def again(value: Array) -> tuple[tuple[Array], Array]:
            new = step(value)
            return (new,), _settled(xp, new, value) | xp.isnan(new)

        (value,), steps = xp.loop(again, (start,), steps - 1), 1
    for _ in range(steps):
        new = step(value)
        settled = _settled(xp, new, value)
        value = new
        if steps > 1 and (xp.all(settled) or xp.all(settled | xp.isnan(value))):
            break
    return xp.where(settled, value, xp.nan)


def reached(xp: Any, tolerance: float) -> Array:
    """A tolerance of what an iteration has reached, as wide as a namespace of less precision needs it."""
    return xp.maximum(tolerance, 100.0 * xp.settled) if hasattr(xp, "settled") else tolerance


def _settled(xp: Any, new: Array, value: Array) -> Array:
    return xp.abs(new - value) <= getattr(xp, "settled", SETTLED) * (1.0 + xp.abs(new))


def _settled_in_jax(xp: Any, step: Callable[[Array], Array], start: Array, steps: int) -> Array:
    """Converged value, excluded from differentiation: `newton` takes the derivative from its last step."""
    import jax

    start = jax.lax.stop_gradient(start)
    pure, held = jax.closure_convert(step, start)
    held = [jax.lax.stop_gradient(part) for part in held]

    def goes_on(state: tuple[Any, Any, Any]) -> Any:
        count, moves, _ = state
        return moves & (count < steps)

    def forth(state: tuple[Any, Any, Any]) -> tuple[Any, Any, Any]:
        count, _, value = state
        new = pure(value, *held)
        return count + 1, ~xp.all(_settled(xp, new, value) | xp.isnan(new)), new

    for _ in range(_USUAL_STEPS):  # most points have converged by then, and the compiler fuses these steps
        start = pure(start, *held)
    return jax.lax.while_loop(goes_on, forth, (_USUAL_STEPS, True, start))[2]


def bisect(xp: Any, function: Callable[[Array], Array], low: Array, high: Array, steps: int = 60) -> Array:
    """Root of an increasing function between `low` and `high`, by `steps` bisections."""

    def halve(bracket: tuple[Array, Array]) -> tuple[Array, Array]:
        low, high = bracket
        middle = 0.5 * (low + high)
        above = function(middle) > 0
        return xp.where(above, low, middle), xp.where(above, middle, high)

    low, high = _repeat(xp, halve, (low, high), steps)
    return 0.5 * (low + high)


def rising_root(
    xp: Any,
    function: Callable[[Array], tuple[Array, Array]],
    low: Array,
    high: Array,
    steps: int,
    start: Array | None = None,
    inward: int = 0,
) -> Array:
    """Root of a rising function between `low` and `high`, by Newton's method within a bracket that shrinks.

    Parameters
    ----------
    function             Maps places to values and slopes.
    low, high : (...,)   Ends of the bracket, of one shape; without a root in it, the result is near one of them.
    steps : int          Most steps; the bracket is halved where a step would not be half the last one or leaves the bracket.
    start : (...,)       Place to start from; the middle by default.
    inward : int         Times that an end is moved half the way to the start where the function has not the sign of a rising
        one, for functions that fall towards the ends.

    Returns
    -------
    (...,)   Its derivatives are those of the root.
    """

    least = _LEAST_MOVE * (high - low)

    def narrow(state: _Bracket, function: Callable[..., tuple[Array, Array]], *held: Any) -> _Bracket:
        low, high, place, moved = state
        value, slope = function(place, *held)
        low, high = xp.where(value < 0, place, low), xp.where(value > 0, place, high)
        new = _newton_place(xp, place, value, slope)
        quick = (new >= low) & (new <= high) & (xp.abs(new - place) <= xp.maximum(0.5 * moved, least))
        new = xp.where(quick, new, 0.5 * (low + high))
        return low, high, new, xp.abs(new - place)

    place = 0.5 * (low + high) if start is None else xp.clip(start, low, high)
    low, high, below, above = _inward(xp, function, low, high, place, inward)
    # Where no root lies in it, the bracket is one of its ends from the start.
    low, high = xp.where(above, low, high), xp.where(below | ~above, high, low)
    place = xp.clip(place, low, high)
    state: _Bracket = (low, high, place, high - low)
    if xp.__name__ == "jax.numpy":
        place = _narrowed_in_jax(xp, function, narrow, state, steps, least)
    elif xp.__name__ == "tape":
        place = xp.loop(lambda *at: (new := narrow(at, function), new[3] <= least), state, steps)[2]
    else:
        for _ in range(steps):
            state = narrow(state, function)
            if xp.all((state[3] <= least) | xp.isnan(state[2])):
                break
        place = state[2]
    value, slope = function(place)
    new = _newton_place(xp, place, value, slope)
    return xp.where((new >= low) & (new <= high), new, place)


def _inward(
    xp: Any, function: Callable[[Array], tuple[Array, Array]], low: Array, high: Array, place: Array, times: int
) -> tuple[Array, Array, Array, Array]:
    """Ends of a bracket moved towards a place, and whether the function has the sign of a rising one at each."""
    if xp.__name__ == "jax.numpy":
        return _inward_in_jax(xp, function, low, high, place, times)
    if xp.__name__ == "tape":

        def nearer(low: Array, high: Array) -> tuple[tuple[Array, Array], Array]:
            below, above = function(low)[0] <= 0, function(high)[0] >= 0
            ends = xp.where(below, low, 0.5 * (low + place)), xp.where(above, high, 0.5 * (high + place))
            return ends, below & above

        low, high = xp.loop(nearer, (low, high), times) if times else (low, high)
        times = 0
    below, above = function(low)[0] <= 0, function(high)[0] >= 0
    for _ in range(times):
        if xp.all(below & above | xp.isnan(place)):
            break
        low, high = xp.where(below, low, 0.5 * (low + place)), xp.where(above, high, 0.5 * (high + place))
        below, above = function(low)[0] <= 0, function(high)[0] >= 0
    return low, high, below, above


def _inward_in_jax(xp: Any, function: Any, low: Array, high: Array, place: Array, times: int) -> Any:
    """As a loop, which compiles in a fraction of the time, and ends as early; excluded from differentiation."""
    import jax

    low, high, place = map(jax.lax.stop_gradient, (low, high, place))
    pure, held = jax.closure_convert(function, place)
    held = [jax.lax.stop_gradient(part) for part in held]

    def goes_on(state: Any) -> Any:
        count, _, _, below, above = state
        return (count == 0) | ((count <= times) & ~xp.all(below & above | xp.isnan(place)))

    def forth(state: Any) -> Any:
        count, low, high, below, above = state
        # The first time, both hold of every end.
        low, high = xp.where(below, low, 0.5 * (low + place)), xp.where(above, high, 0.5 * (high + place))
        return count + 1, low, high, pure(low, *held)[0] <= 0, pure(high, *held)[0] >= 0

    holds = xp.full(xp.broadcast_shapes(low.shape, high.shape, place.shape), True)
    low, high = xp.broadcast_to(low, holds.shape), xp.broadcast_to(high, holds.shape)
    return jax.lax.while_loop(goes_on, forth, (0, low, high, holds, holds))[1:]


def _newton_place(xp: Any, place: Array, value: Array, slope: Array) -> Array:
    """Place after a Newton step; nan where the function does not rise, except at a root."""
    rises = slope > 0
    return xp.where(rises, place - value / xp.where(rises, slope, 1.0), xp.where(value == 0, place, xp.nan))


def _narrowed_in_jax(xp: Any, function: Any, narrow: Any, state: Any, steps: int, least: Array) -> Array:
    """Place after the steps, excluded from differentiation."""
    import jax

    state = tuple(map(jax.lax.stop_gradient, state))
    pure, held = jax.closure_convert(function, state[2])
    held = [jax.lax.stop_gradient(part) for part in held]

    def goes_on(state: Any) -> Any:
        count, moves, _ = state
        return moves & (count < steps)

    def forth(state: Any) -> Any:
        count, _, places = state
        new = narrow(places, pure, *held)
        return count + 1, xp.any(new[3] > least), new

    return jax.lax.while_loop(goes_on, forth, (0, True, state))[2][2]

"""Array namespace for complex-step differentiation of formulas over `xp`.

A tiny imaginary part carries the derivative. Its square underflows and no difference is taken, so the derivative is exact
to rounding. Comparisons, absolute values and `where` use the real parts only.

Source: squire1998.
"""

from __future__ import annotations

import operator
from collections.abc import Callable
from typing import Any

import numpy as np

STEP = 1e-30
"""Imaginary part of the perturbed value, relative to its magnitude. Its square is far below float64 resolution."""


class Stepped:
    """NumPy array of values (real parts) with their derivatives (imaginary parts over a step)."""

    __slots__ = ("z",)
    z: Any
    __array_ufunc__ = None  # NumPy leaves mixed operations to this class

    def __init__(self, z: Any) -> None:
        """Wrap complex numbers."""
        self.z = np.asarray(z, dtype=complex)

    def __array_namespace__(self) -> Namespace:
        """The namespace that carries derivatives."""
        return NAMESPACE

    @property
    def value(self) -> np.ndarray:
        """Values without their derivatives."""
        return self.z.real

    @property
    def slope(self) -> np.ndarray:
        """Imaginary parts."""
        return self.z.imag

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the array."""
        return self.z.shape

    @property
    def ndim(self) -> int:
        """Number of dimensions."""
        return self.z.ndim

    def __getitem__(self, key: Any) -> Stepped:
        """Select elements."""
        return Stepped(self.z[key])

    def __len__(self) -> int:
        """Length of the first axis."""
        return len(self.z)

    def __bool__(self) -> bool:
        """Whether a single value is nonzero."""
        return bool(self.z.real)

    def __neg__(self) -> Stepped:
        """Negate."""
        return Stepped(-self.z)

    def __abs__(self) -> Stepped:
        """Absolute value; its derivative has the sign of the value."""
        return Stepped(np.where(self.z.real < 0, -self.z, self.z))


def _plain(value: Any) -> Any:
    return value.z if isinstance(value, Stepped) else value


def _arithmetic(operation: Callable[[Any, Any], Any]) -> tuple[Callable[..., Stepped], Callable[..., Stepped]]:
    def forward(self: Stepped, other: Any) -> Stepped:
        return Stepped(operation(self.z, _plain(other)))

    def backward(self: Stepped, other: Any) -> Stepped:
        return Stepped(operation(_plain(other), self.z))

    return forward, backward


def _comparison(operation: Callable[[Any, Any], Any]) -> Callable[..., Any]:
    return lambda self, other: operation(self.z.real, other.z.real if isinstance(other, Stepped) else other)


def _power(base: Any, exponent: Any) -> Any:
    """Power, term by term: NumPy's complex power loses imaginary parts this small."""
    base, exponent = np.asarray(base), np.asarray(exponent)
    value = np.power(base.real, exponent.real)
    with np.errstate(divide="ignore", invalid="ignore"):
        by_base = np.where(base.imag == 0, 0.0, exponent.real * np.power(base.real, exponent.real - 1.0) * base.imag)
        by_exponent = np.where(exponent.imag == 0, 0.0, value * np.log(base.real) * exponent.imag)
    return value + 1j * (by_base + by_exponent)


def _product(one: Any, other: Any) -> Any:
    """Product, term by term: infinity times a number without a derivative has no derivative."""
    one, other = np.asarray(one), np.asarray(other)
    with np.errstate(invalid="ignore"):
        slope = np.where(one.imag == 0, 0.0, one.imag * other.real) + np.where(
            other.imag == 0, 0.0, one.real * other.imag
        )
        return _joined(one.real * other.real, slope)


def _quotient(one: Any, other: Any) -> Any:
    one, other = np.asarray(one), np.asarray(other)
    with np.errstate(divide="ignore", invalid="ignore"):
        value = np.asarray(one.real / other.real)
        slope = np.where(one.imag == 0, 0.0, one.imag / other.real)
        slope = slope - np.where(other.imag == 0, 0.0, value * other.imag / other.real)
    return _joined(value, slope)


def _joined(value: Any, slope: Any) -> np.ndarray:
    """Complex numbers from their real and imaginary parts; keeps infinities."""
    value, slope = np.broadcast_arrays(value, slope)
    found = np.empty(value.shape, dtype=complex)
    found.real, found.imag = value, slope
    return found


for _name, _operation in {
    "add": operator.add, "sub": operator.sub, "mul": _product, "truediv": _quotient, "pow": _power,
}.items():  # fmt: skip
    _forward, _backward = _arithmetic(_operation)
    setattr(Stepped, f"__{_name}__", _forward)
    setattr(Stepped, f"__r{_name}__", _backward)
for _name in ("lt", "le", "gt", "ge", "eq", "ne"):
    setattr(Stepped, f"__{_name}__", _comparison(getattr(operator, _name)))


_SLOPES: dict[str, Callable[[Any, Any], Any]] = {
    # Derivative of each function, given its argument and its value.
    "sqrt": lambda x, y: 0.5 / y,
    "exp": lambda x, y: y,
    "log": lambda x, y: 1.0 / x,
    "log1p": lambda x, y: 1.0 / (1.0 + x),
    "expm1": lambda x, y: y + 1.0,
    "sin": lambda x, y: np.cos(x),
    "cos": lambda x, y: -np.sin(x),
    "tan": lambda x, y: 1.0 + y * y,
    "asin": lambda x, y: 1.0 / np.sqrt(1.0 - x * x),
    "acos": lambda x, y: -1.0 / np.sqrt(1.0 - x * x),
    "atan": lambda x, y: 1.0 / (1.0 + x * x),
}


class Namespace:
    """The part of the array API that the formulas use, with derivatives; plain arrays go to NumPy."""

    __name__ = "infinivar complex step"

    def __getattr__(self, name: str) -> Any:
        """NumPy's function of that name, extended to arguments with derivatives if its derivative is known."""
        own = getattr(np, name)
        if not callable(own) or isinstance(own, type):
            return own
        slope = _SLOPES.get(name)

        def function(*arguments: Any, **options: Any) -> Any:
            if not any(isinstance(argument, Stepped) for argument in arguments):
                return own(*arguments, **options)
            if slope is not None:
                z = arguments[0].z
                value = own(z.real)
                with np.errstate(divide="ignore", invalid="ignore"):
                    return Stepped(_joined(value, np.where(z.imag == 0, 0.0, slope(z.real, value) * z.imag)))
            if name in ("isnan", "isfinite", "sign", "floor"):
                return own(arguments[0].z.real)
            if name in ("zeros_like", "ones_like", "full_like"):
                return own(arguments[0].z.real, *arguments[1:], **options)
            if name in ("sum", "mean", "reshape", "matmul", "take", "broadcast_to", "cumulative_sum"):
                return Stepped(own(*map(_plain, arguments), **options))
            raise NotImplementedError(f"{name} carries no derivative")

        return function

    def asarray(self, value: Any, dtype: Any = None) -> Any:
        """Convert to an array; a value with derivatives is returned unchanged."""
        return value if isinstance(value, Stepped) else np.asarray(value, dtype=dtype)

    def astype(self, value: Any, dtype: Any) -> Any:
        """Convert to another type; a value with derivatives is returned unchanged."""
        return value if isinstance(value, Stepped) else np.astype(value, dtype)

    def abs(self, value: Any) -> Any:
        """Absolute value."""
        return abs(value)

    def where(self, condition: Any, one: Any, other: Any) -> Any:
        """Choose by condition."""
        if isinstance(one, Stepped) or isinstance(other, Stepped):
            return Stepped(np.where(condition, _plain(one), _plain(other)))
        return np.where(condition, one, other)

    def atan2(self, across: Any, along: Any) -> Any:
        """Angle of a point, with its derivative."""
        if not (isinstance(across, Stepped) or isinstance(along, Stepped)):
            return np.atan2(across, along)
        y: Any = np.asarray(_plain(across))
        x: Any = np.asarray(_plain(along))
        with np.errstate(divide="ignore", invalid="ignore"):
            slope = (x.real * y.imag - y.real * x.imag) / (x.real**2 + y.real**2)
        return Stepped(_joined(np.atan2(y.real, x.real), np.where((x.imag == 0) & (y.imag == 0), 0.0, slope)))

    def maximum(self, one: Any, other: Any) -> Any:
        """The larger, with its derivative."""
        return self.where((_real(one) >= _real(other)) | np.isnan(_real(one)), one, other)

    def minimum(self, one: Any, other: Any) -> Any:
        """The smaller, with its derivative."""
        return self.where((_real(one) <= _real(other)) | np.isnan(_real(one)), one, other)

    def clip(self, value: Any, low: Any, high: Any) -> Any:
        """Clip to bounds."""
        if not any(isinstance(part, Stepped) for part in (value, low, high)):
            return np.clip(value, low, high)
        return self.minimum(self.maximum(value, low), high)

    def max(self, value: Any, axis: int = -1, keepdims: bool = False) -> Any:
        """The largest along an axis, with its derivative."""
        if not isinstance(value, Stepped):
            return np.max(value, axis=axis, keepdims=keepdims)
        place = np.expand_dims(np.argmax(value.z.real, axis=axis), axis)
        found = np.take_along_axis(value.z, place, axis)
        return Stepped(found if keepdims else np.squeeze(found, axis))

    def broadcast_arrays(self, *values: Any) -> list[Any]:
        """Broadcast to one shape."""
        shape = np.broadcast_shapes(*(np.shape(_plain(value)) for value in values))
        spread = (np.broadcast_to(_plain(value), shape) for value in values)
        return [
            Stepped(found) if isinstance(value, Stepped) else found for value, found in zip(values, spread, strict=True)
        ]

    def concat(self, values: Any, axis: int = 0) -> Any:
        """Join along an axis."""
        return _together(np.concatenate, values, axis)

    def stack(self, values: Any, axis: int = 0) -> Any:
        """Join along a new axis."""
        return _together(np.stack, values, axis)


def _together(join: Callable[..., Any], values: Any, axis: int) -> Any:
    joined = join([_plain(value) for value in values], axis=axis)
    return Stepped(joined) if any(isinstance(value, Stepped) for value in values) else joined


def _real(value: Any) -> Any:
    return value.z.real if isinstance(value, Stepped) else value


NAMESPACE = Namespace()


def size_of_step(at: Any) -> np.ndarray:
    """Imaginary part that perturbs each value."""
    return STEP * np.where(np.asarray(at) == 0, 1.0, np.abs(at))


def derivative(function: Callable[[Any], Any], at: Any) -> tuple[np.ndarray, np.ndarray]:
    """Value of a function over `xp` and its derivative, element by element.

    Parameters
    ----------
    function : callable   Function of one array; each element of the result depends only on the corresponding element.
    at : (...,) float     Argument.

    Returns
    -------
    value, slope : (...,) float
    """
    at = np.asarray(at, dtype=float)
    size = size_of_step(at)
    found = function(Stepped(_joined(at, size)))
    if not isinstance(found, Stepped):  # independent of the argument
        found = np.asarray(found, dtype=float)
        return found, np.zeros_like(found)
    return found.value, found.slope / np.broadcast_to(size, found.shape)

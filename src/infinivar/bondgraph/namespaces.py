"""Functions that generated code calls: on plain floats and on CasADi expressions."""

from __future__ import annotations

import math
from typing import Any

FUNCTIONS = ("where", "clip", "abs", "sign", "sqrt", "exp", "log", "sin", "cos", "tan", "asin", "acos", "atan", "tanh")
"""What generated code calls, of an array namespace."""


class FloatNamespace:
    """Functions for generated code on plain floats; several times faster than NumPy on scalars."""

    where = clip = None  # `compiled` replaces them with conditional expressions
    sign = staticmethod(lambda value: float(value > 0) - float(value < 0))
    abs, sqrt, exp, log = abs, math.sqrt, math.exp, math.log
    sin, cos, tan, asin, acos, atan, tanh = math.sin, math.cos, math.tan, math.asin, math.acos, math.atan, math.tanh


def casadi_namespace() -> Any:
    """Functions for generated code on CasADi expressions.

    Raises
    ------
    ImportError
        If CasADi is not installed.
    """
    import casadi

    class CasadiNamespace:
        where, sign = staticmethod(casadi.if_else), casadi.sign
        clip = staticmethod(lambda value, low, high: casadi.fmin(casadi.fmax(value, low), high))
        abs, sqrt, exp, log = casadi.fabs, casadi.sqrt, casadi.exp, casadi.log
        sin, cos, tan, asin, acos = casadi.sin, casadi.cos, casadi.tan, casadi.asin, casadi.acos
        atan, tanh = casadi.atan, casadi.tanh

    return CasadiNamespace

"""The cobotic system as one writes it by hand: equations with plain floats, SciPy's LSODA, no energy audit."""

from __future__ import annotations

from itertools import pairwise
from math import copysign, cos, sin, sqrt

import numpy as np
from scipy.integrate import odeint


def equations(p: dict[str, float]):
    """Right-hand side of the five states link speed, bell speed, cylinder speed, steering angle, link position."""
    link, steering = p["m"] + p["m_l"], p["J_b"] + p["J_m_s"] * p["n_s"] ** 2
    cylinder = p["J_c"] + p["J_m_c"] * p["n_c"] ** 2
    k_s, k_c = p["K_s"] * p["n_s"], p["K_c"] * p["n_c"]
    t_s, t_c = p["T_bell"] + p["T_shear"] + p["n_s"] * p["T_m_s"], p["n_c"] * (p["T_m_c"] + p["T_g_c"])
    f_r, f_lg, slip, c = p["f_in"] + p["f_wa"], p["f_lg"], p["mu_P"], p["C"]
    radius, eps = p["R"], p["v_eps"]
    eps_s, eps_c = p["eps_s"], p["eps_c"]

    def sgn(x: float, width: float) -> float:
        s = x / width
        return copysign(1.0, s) if abs(s) >= 1.0 else 0.5 * s * (3.0 - s * s)

    def rates(time: float, state, current_c: float, current_s: float):
        ldot, phidot, omega, phi, _ = state.tolist()
        cosine, sine = cos(phi), sin(phi)
        surface = radius * omega
        u, v = ldot * cosine + surface * sine, ldot * sine - surface * cosine
        fu = c * u / sqrt(v * v + eps * eps)
        fu = slip if fu > slip else -slip if fu < -slip else fu
        fr = f_r * sgn(v, eps)
        return (
            (-fu * cosine - fr * sine - f_lg * sgn(ldot, eps)) / link,
            (k_s * current_s - t_s * sgn(phidot, eps_s)) / steering,
            (k_c * current_c - t_c * sgn(omega, eps_c) - radius * (fu * sine - fr * cosine)) / cylinder,
            phidot,
            ldot,
        )

    return rates


def simulate(parameters: dict[str, float], controller, state, times, rtol: float, atol: float):
    """States at the samples; the controller is given the same signals as in the program's own run."""
    rates = equations(parameters)
    rows = [np.array(state)]
    memory = controller.start({})
    for begin, end in pairwise(times):
        ldot, phidot, omega, phi, position = rows[-1].tolist()
        measured = {"omega": omega, "phi": phi, "phi_rate": phidot, "l": position, "ldot": ldot}
        given, memory = controller.sample(begin, measured, memory)
        currents = tuple(given.values())
        rows.append(
            odeint(rates, rows[-1], (begin, end), args=currents, tfirst=True, rtol=rtol, atol=atol, tcrit=(end,))[1]
        )
    return np.array(rows)

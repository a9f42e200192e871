"""What a motion takes of a drive as small C functions for its controller: feed-forward, steering, losses and demands on limits.

They are the formulas of `operate` and `follow`, recorded once and printed as C99, in float or double, without dependencies,
allocation or global state.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from infinivar.bondgraph.c_code import c_number, statements, table_of
from infinivar.bondgraph.tape import Number, Tape
from infinivar.drivetrain.drive import followed, operated, orders_of
from infinivar.motion.course import Course

_LEAST = 1e-30
"""Smaller numbers only keep a divisor from 0, which they are in float."""
_POINTS = 24
"""Instants at which the test compares."""
_FASTEST, _SLOWEST, _STRONGEST, _WEAKEST = 2.0, 1e-3, 2e3, 1e-3
"""Between these lie speed and force of the test: the largest, halved until they are within limits. [m s^-1], [N]"""

_STEADY = {"position": "m", "speed": "m/s", "force": "N"}
COURSE = {
    "position": "m",
    "speed": "m/s",
    "acceleration": "m/s^2",
    "jerk": "m/s^3",
    "snap": "m/s^4",
    "fifth": "m/s^5",
    "sixth": "m/s^6",
    "force": "N",
    "force_rate": "N/s",
    "force_curvature": "N/s^2",
    "force_third": "N/s^3",
    "force_fourth": "N/s^4",
}
"""Values of a course at an instant, with their units along a line."""
_ORDERS = {"fifth": 5, "sixth": 6, "force_third": 5, "force_fourth": 6}
"""Order of a drive from which on it asks for an input."""
_MEANING = {
    "steady": "Speed and force, applied by the drive to the load, of a steady motion.",
    "follow": "Motion of the load, external force on it along the motion, and its mass.",
}


_REAL = (
    "#ifndef REAL",
    "#define REAL double",
    "#endif",
    "#ifndef INFINIVAR_REAL /* once, however many drives there are */",
    "#define INFINIVAR_REAL",
    "typedef REAL real;",
    "#endif",
    "",
    "#ifdef __cplusplus",
    'extern "C" {',
    "#endif",
)


_UNKNOWN = """    for (int i = 0; i < {0}; i++) {{
        known = known && isfinite(u[i]);
    }}
    for (int i = 0; !known && i < {1}; i++) {{
        y[i] = NAN;
    }}
    if (!known) {{
        return;
    }}"""
"""What is not a number as an input gives none."""


class Law(NamedTuple):
    """A function of a drive."""

    name: str
    inputs: Mapping[str, str]
    """Units by name."""
    evaluate: Any
    """Maps values by name to results by name."""


def laws(drive: Any) -> list[Law]:
    """The functions of a drive: `steady` and `follow`."""
    orders = orders_of(drive)
    rotary = drive.axis.rotary
    moving = {name: unit for name, unit in COURSE.items() if _ORDERS.get(name, 0) <= orders}
    units = {"load_mass": "kg m^2" if rotary else "kg"}

    def of(inputs: Mapping[str, str]) -> dict[str, str]:
        about = {name: unit.replace("m/s", "rad/s").replace("N", "N m") for name, unit in inputs.items()}
        return {**about, "position": "rad"} if rotary else dict(inputs)

    def steady(**values: Any) -> dict[str, Any]:
        point = operated(drive, **values)
        return results_of(point, {limit.name: demand for limit, demand in point.utilisation.items()})

    def follow(load_mass: Any, **values: Any) -> dict[str, Any]:
        point = followed(drive, Course(**values), load_mass=load_mass)
        demands = {f"{limit.name}_{part}": demand for (limit, part), demand in point.utilisation.items()}
        return results_of(point, demands)

    return [Law("steady", of(_STEADY), steady), Law("follow", {**of(moving), **units}, follow)]


def results_of(point: Any, demands: Mapping[str, Any]) -> dict[str, Any]:
    """Results of a point by name."""
    return {
        "power_in_W": point.power_in,
        **dict(point.states),
        **{f"loss_{name}_W": loss for name, loss in point.losses.items()},
        **{f"demand_{name}": demand for name, demand in demands.items()},
    }


def law_files(drive: Any, name: str) -> dict[str, str]:
    """C of the laws of a drive, and a test that compares it with the program, by the names of the files.

    Parameters
    ----------
    drive : CoboticDrive or ConventionalDrive
    name : str   Of the files and before the names of the functions: letters, digits and "_".

    Returns
    -------
    dict of str to str   ``NAME.h``, ``NAME.c`` and ``NAME_test.c``; the same for the same drive.

    Raises
    ------
    TypeError, AttributeError
        If a law of another package decides by a value, or calls what C has not.
    """
    found = laws(drive)
    recorded = {law.name: record(law) for law in found}
    guard = f"{name.upper()}_H"
    header = [f"#ifndef {guard}", f"#define {guard}", "", *_REAL, ""]
    body = [f'#include "{name}.h"', "", "#include <float.h>", "#include <tgmath.h>", ""]
    body += [f"#define LEAST(x) (sizeof(real) == sizeof(float) ? (real){_LEAST} : (real)(x))", ""]
    body += [
        "static const real settled[] = {sizeof(real) == sizeof(float) ? 16 * (real)FLT_EPSILON : (real)1e-12};",
        "",
    ]
    for law in found:
        tape, results = recorded[law.name]
        inputs = [f"{name}_{law.name}_{identifier(one)}" for one in law.inputs]
        outputs = [f"{name}_{law.name}_{identifier(one)}" for one in results]
        header += [f"/* {_MEANING[law.name]} */", "enum {"]
        header += [f"    {one.upper()}, /* {unit} */" for one, unit in zip(inputs, law.inputs.values(), strict=True)]
        header += [f"    {name.upper()}_{law.name.upper()}_INPUTS", "};", "", "enum {"]
        header += [f"    {one.upper()}_OUT," for one in outputs]
        header += [f"    {name.upper()}_{law.name.upper()}_OUTPUTS", "};", ""]
        header += [f"void {name}_{law.name}(const real *u, real *y);", ""]
        counts = (f"{name.upper()}_{law.name.upper()}_INPUTS", f"{name.upper()}_{law.name.upper()}_OUTPUTS")
        body += function(f"void {name}_{law.name}", f"{law.name}_data", tape, results, "real", counts)
    header += ["#ifdef __cplusplus", "}", "#endif", "", "#endif", ""]
    return {
        f"{name}.h": "\n".join(header),
        f"{name}.c": _reals("\n".join(body)),
        f"{name}_test.c": _test(name, found),
    }


def function(
    head: str, data: str, tape: Tape, results: Mapping[str, Number], real: str, counts: tuple[str, str]
) -> list[str]:
    """Lines of a C function that computes results of a tape, after its data, from the inputs.

    Parameters
    ----------
    head : str                    Type and name of the function, such as "static void law".
    data : str                    Name of the data.
    tape, results                 As `record` gives them.
    real : str                    Type of the arguments.
    counts : tuple of str         Names of the numbers of inputs and outputs.
    """
    return [
        *table_of(tape, data),
        f"{head}(const {real} *u, {real} *y)",
        "{",
        f"    const {real} *p = {data};",
        "    int known = 1;",
        "    (void)p; (void)settled;",
        *_UNKNOWN.format(*counts).splitlines(),
        *statements(tape, list(results.values()), "y"),
        "}",
        "",
    ]


def record(law: Law) -> tuple[Tape, dict[str, Number]]:
    """The tape of a law, and its results on the tape by name."""
    tape = Tape({})
    values = {one: tape.input("inputs", place) for place, one in enumerate(law.inputs)}
    return tape, law.evaluate(**values)


def identifier(name: str) -> str:
    """A name in letters, digits and underscores."""
    return re.sub(r"\W+", "_", name)


def _reals(text: str) -> str:
    """Numbers and variables of double precision as those of the type `real`."""
    text = re.sub(r"\bdouble\b", "real", text)

    def number(found: re.Match[str]) -> str:
        return f"LEAST({found[0]})" if 0.0 < float(found[0]) < _LEAST else f"(real){found[0]}"

    return re.sub(r"(?<![\w.])(\d+\.\d+(?:e[+-]?\d+)?|\d+e[+-]?\d+)(?!\w)", number, text)


def _test(name: str, found: Sequence[Law]) -> str:
    """A program that compares the functions with values of this one, and returns 0 if they agree."""
    lines = [f'#include "{name}.h"', "", "#include <math.h>", "#include <stdio.h>", ""]
    checks = []
    for law in found:
        given = _instants(law)
        results = law.evaluate(**given)
        rows = {"u": list(given.values()), "y": list(results.values())}
        for array, columns in rows.items():
            table = np.stack([np.broadcast_to(np.asarray(one, dtype=float), _POINTS) for one in columns], axis=-1)
            lines += [f"static const double {law.name}_{array}[{_POINTS}][{table.shape[1]}] = {{"]
            lines += [f"    {{{', '.join(map(c_number, row))}}}," for row in table.tolist()]
            lines += ["};", ""]
        counts = ", ".join(f"{name.upper()}_{law.name.upper()}_{what}" for what in ("INPUTS", "OUTPUTS"))
        checks.append(
            f"worst = larger(worst, compared({name}_{law.name}, &{law.name}_u[0][0], &{law.name}_y[0][0], {counts}));"
        )
    return "\n".join([*lines, *_COMPARED.splitlines(), *(f"    {one}" for one in checks), *_ENDS.splitlines(), ""])


_COMPARED = f"""static double larger(double one, double other)
{{
    return one > other ? one : other;
}}

/* Largest difference of a result, over its largest size at all instants. */
static double compared(void (*law)(const real *, real *), const double *given, const double *wanted, int inputs, int outputs)
{{
    real u[64], y[256];
    double worst = 0.0;
    for (int out = 0; out < outputs; out++) {{
        double size = 1e-30, off = 0.0;
        for (int row = 0; row < {_POINTS}; row++) {{
            const double known = wanted[row * outputs + out];
            for (int in = 0; in < inputs; in++) {{
                u[in] = (real)given[row * inputs + in];
            }}
            law(u, y);
            if (isfinite(known)) {{
                size = larger(size, fabs(known));
                off = larger(off, isfinite((double)y[out]) ? fabs((double)y[out] - known) : INFINITY);
            }} else if (isfinite((double)y[out])) {{
                off = INFINITY;
            }}
        }}
        worst = larger(worst, off / size);
    }}
    return worst;
}}

int main(void)
{{
    const double permitted = sizeof(real) == sizeof(float) ? 1e-3 : 1e-9;
    double worst = 0.0;"""

_ENDS = """    if (worst <= permitted) {
        printf("all values agree within %.0e of the largest\\n", permitted);
        return 0;
    }
    printf("values differ by %.1e of the largest, permitted are %.0e\\n", worst, permitted);
    return 1;
}"""


def _instants(law: Law) -> dict[str, Any]:
    """Values of the inputs during a sinusoid of 1 Hz, as fast and with as much force as the limits permit at all instants."""
    speed, force = _FASTEST, 0.0
    while not _within(law, _sinusoid(law, speed, force)) and speed > _SLOWEST:
        speed *= 0.5
    force = _STRONGEST
    while not _within(law, _sinusoid(law, speed, force)) and force > _WEAKEST:
        force *= 0.5
    return _sinusoid(law, speed, force)


def _within(law: Law, given: Mapping[str, Any]) -> bool:
    with np.errstate(all="ignore"):
        found = law.evaluate(**given)
    demands = (one for name, one in found.items() if name.startswith("demand_"))
    return all(np.isfinite(one).all() for one in found.values()) and all((one <= 1.0).all() for one in demands)


def _sinusoid(law: Law, speed: float, force: float) -> dict[str, Any]:
    turn, angle = 2.0 * np.pi, 2.0 * np.pi * (np.arange(_POINTS) + 0.3) / _POINTS
    orders = ("position", "speed", "acceleration", "jerk", "snap", "fifth", "sixth")
    forces = ("force", "force_rate", "force_curvature", "force_third", "force_fourth")
    found: dict[str, Any] = {"load_mass": np.asarray(0.0)}
    found |= {
        name: speed * turn ** (order - 1) * np.sin(angle + 0.5 * np.pi * order) for order, name in enumerate(orders)
    }
    found |= {
        name: force * turn**order * np.cos(angle + 1.0 + 0.5 * np.pi * order) for order, name in enumerate(forces)
    }
    return {name: found[name] for name in law.inputs}

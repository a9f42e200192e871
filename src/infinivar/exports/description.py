"""modelDescription.xml and buildDescription.xml of FMI 2.0 and 3.0.

Source: fmi2014, section 2.2; fmi2022, section 2.4.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterable
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from infinivar.exports.plant import Plant
from infinivar.exports.variables import Variable

_BASES = {
    "1": {},
    "s": {"s": 1},
    "m": {"m": 1},
    "kg": {"kg": 1},
    "A": {"A": 1},
    "K": {"K": 1},
    "rad": {"rad": 1},
    "N": {"kg": 1, "m": 1, "s": -2},
    "J": {"kg": 1, "m": 2, "s": -2},
    "W": {"kg": 1, "m": 2, "s": -3},
    "V": {"kg": 1, "m": 2, "s": -3, "A": -1},
    "ohm": {"kg": 1, "m": 2, "s": -3, "A": -2},
    "H": {"kg": 1, "m": 2, "s": -2, "A": -2},
}
"""Exponents of the SI base units in the units that graphs state."""

_TOLERANCE, _STEP, _END = "1e-8", "1e-3", "1"
"""Of the default experiment."""


_ABILITIES = {
    "2.0": (
        "canNotUseMemoryManagementFunctions",
        "canGetAndSetFMUstate",
        "canSerializeFMUstate",
        "providesDirectionalDerivative",
    ),
    "3.0": ("canGetAndSetFMUState", "canSerializeFMUState", "providesDirectionalDerivatives"),
}
"""Attributes of both kinds of simulation that are true."""


def base_units(unit: str) -> dict[str, int]:
    """Exponents of the SI base units in a product of units and powers, such as "kg m^2" or "rad/(N m)".

    Raises
    ------
    KeyError
        If a unit is not among those that graphs state.
    """
    found: dict[str, int] = {}
    above, *below = unit.replace("(", "").replace(")", "").split("/")
    for part, sign in ((above, 1), *((part, -1) for part in below)):
        for word in part.split():
            name, _, power = word.partition("^")
            for base, exponent in _BASES[name].items():
                found[base] = found.get(base, 0) + sign * exponent * int(power or 1)
    return {base: exponent for base, exponent in found.items() if exponent}


def token(plant: Plant, version: str) -> str:
    """Identifier of a model's content: the same for the same model."""
    content = "\n".join([version, plant.name, plant.title, *map(repr, plant.variables), plant.text, plant.control])
    return f"{{{hashlib.sha256(content.encode()).hexdigest()[:32]}}}"


def model_description(plant: Plant, version: str, program: str) -> bytes:
    """Text of modelDescription.xml.

    Parameters
    ----------
    plant : Plant
    version : str   "2.0" or "3.0".
    program : str   Name and version of the program that exports.
    """
    second = version == "2.0"
    root = Element(
        "fmiModelDescription",
        {
            "fmiVersion": version,
            "modelName": plant.title,
            "guid" if second else "instantiationToken": token(plant, version),
            "description": "Drive-train with its controllers"
            if plant.signals
            else "Plant of a drive-train, without its controllers",
            "generationTool": program,
            "variableNamingConvention": "structured",
            **({"numberOfEventIndicators": "0"} if second else {}),
        },
    )
    able = {
        "modelIdentifier": plant.name,
        **dict.fromkeys(_ABILITIES[version], "true"),
    }
    unneeded = {"completedIntegratorStepNotNeeded": "true"} if second else {"needsCompletedIntegratorStep": "false"}
    for kind, own in (
        ("ModelExchange", unneeded),
        ("CoSimulation", {"canHandleVariableCommunicationStepSize": "true"}),
    ):
        one = SubElement(root, kind, {**able, **own})
        if second:
            SubElement(SubElement(one, "SourceFiles"), "File", name=f"{plant.name}.c")
    _units(root, plant)
    SubElement(SubElement(root, "LogCategories"), "Category", name="logStatusError", description="Calls that fail")
    SubElement(root, "DefaultExperiment", startTime="0", stopTime=_END, tolerance=_TOLERANCE, stepSize=_STEP)
    variables = SubElement(root, "ModelVariables")
    for place, one in enumerate(plant.variables):
        _variable(variables, place, one, plant, second)
    _structure(SubElement(root, "ModelStructure"), plant, second)
    return _text(root)


def build_description(plant: Plant, version: str) -> bytes:
    """Text of sources/buildDescription.xml, of FMI 3.0."""
    root = Element("fmiBuildDescription", fmiVersion=version)
    build = SubElement(root, "BuildConfiguration", modelIdentifier=plant.name)
    SubElement(SubElement(build, "SourceFileSet", language="C99"), "SourceFile", name=f"{plant.name}.c")
    return _text(root)


def _text(root: Element) -> bytes:
    indent(root)
    return b'<?xml version="1.0" encoding="UTF-8"?>\n' + tostring(root, "utf-8") + b"\n"


def _units(root: Element, plant: Plant) -> None:
    units = SubElement(root, "UnitDefinitions")
    for unit in sorted({one.unit for one in plant.variables if one.unit}):
        bases = {base: str(exponent) for base, exponent in base_units(unit).items()}
        SubElement(SubElement(units, "Unit", name=unit), "BaseUnit", bases)


_KINDS = {
    "time": ("independent", "continuous", None),
    "state": ("output", "continuous", "exact"),
    "derivative": ("local", "continuous", "calculated"),
    "input": ("input", "continuous", None),
    "rate": ("input", "continuous", None),
    "output": ("output", "continuous", "calculated"),
    "parameter": ("parameter", "tunable", "exact"),
    "command": ("local", "discrete", "calculated"),
    "goal": ("input", "continuous", None),
}
"""Causality, variability and initial value of each role."""


def _variable(root: Element, place: int, one: Variable, plant: Plant, second: bool) -> None:
    causality, variability, initial = ("local", "constant", "exact") if one.fixed else _KINDS[one.role]
    own = {
        "name": one.name,
        "valueReference": str(place),
        "description": one.description,
        "causality": causality,
        "variability": variability,
        **({"initial": initial} if initial else {}),
    }
    numbers = {
        **({"unit": one.unit} if one.unit else {}),
        **({"min": repr(one.least)} if math.isfinite(one.least) else {}),
        **({"max": repr(one.most)} if math.isfinite(one.most) else {}),
        **({} if one.start is None or initial == "calculated" else {"start": repr(one.start)}),
        **({"derivative": str(_state_of(place, plant) + second)} if one.role == "derivative" else {}),
    }
    if second:
        SubElement(SubElement(root, "ScalarVariable", own), "Real", numbers)
    else:
        SubElement(root, "Float64", {**own, **numbers})


def _state_of(place: int, plant: Plant) -> int:
    """Place of the state of a derivative."""
    return place - len(plant.places("state"))


def _structure(root: Element, plant: Plant, second: bool) -> None:
    """Unknowns and what they depend on; FMI 2.0 counts variables from 1, FMI 3.0 names value references."""
    derivatives, outputs = plant.places("derivative"), plant.places("state", "output")
    computed = sorted([*derivatives, *plant.places("output")])
    groups = (
        ("Outputs", "Output", outputs, ("state", "input", "rate")),
        ("Derivatives", "ContinuousStateDerivative", derivatives, ("state", "input", "rate")),
        ("InitialUnknowns", "InitialUnknown", computed, ("state", "input", "rate", "parameter")),
    )
    for group, name, places, roles in groups:
        parent = SubElement(root, group) if second else root
        for place in places:
            known = [one for one in plant.behind.get(place, (place,)) if _counts(plant.variables[one], roles)]
            key, value = ("index", place + 1) if second else ("valueReference", place)
            dependencies = " ".join(str(one + second) for one in known)
            SubElement(parent, "Unknown" if second else name, {key: str(value), "dependencies": dependencies})


def _counts(one: Variable, roles: Iterable[str]) -> bool:
    return one.role in roles and not one.fixed

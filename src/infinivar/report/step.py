"""The bodies of a drive as solids in a STEP file, for CAD: one assembly, in millimetres."""

from __future__ import annotations

import importlib
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from infinivar._core import extras
from infinivar.drivetrain.layout import Solid
from infinivar.errors import InputError

_MM = 1e3
_DATE = re.compile(rb"'\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d'")
_NO_DATE = b"'1970-01-01T00:00:00'"


def installed() -> bool:
    """Whether the library that writes STEP is there."""
    return extras.there("OCP")


def save_step(solids: Sequence[Solid], path: Path, title: str) -> Path:
    """Write solids as a STEP file, AP214, in which each is a part of one assembly with the name of its body.

    Parameters
    ----------
    solids : sequence of Solid   Of one drive, such as those of `WholeMass.layout`.
    path : Path                  Replaced if it exists.
    title : str                  Of the assembly.

    Raises
    ------
    InputError
        If the library is not installed, or the file cannot be written.
    """
    extras.load("OCP", "cad", "a STEP file")
    text, message = _module("TCollection").TCollection_ExtendedString, _module("Message")
    message.Message.DefaultMessenger_s().RemovePrinters(message.Message_PrinterOStream.get_type_descriptor_s())
    document = _module("TDocStd").TDocStd_Document(text("solids"))
    shapes = _module("XCAFDoc").XCAFDoc_DocumentTool.ShapeTool_s(document.Main())

    def named(label: Any, name: str) -> Any:
        _module("TDataStd").TDataStd_Name.Set_s(label, text(name))
        return label

    whole = named(shapes.NewShape(), title)
    for solid in solids:
        part = named(shapes.AddShape(_shape(solid), False), solid.body)
        named(shapes.AddComponent(whole, part, _module("TopLoc").TopLoc_Location()), solid.body)
    shapes.UpdateAssemblies()
    writer = _module("STEPCAFControl").STEPCAFControl_Writer()
    writer.SetNameMode(True)
    good = _module("IFSelect").IFSelect_ReturnStatus.IFSelect_RetDone
    done = writer.Transfer(document) and writer.Write(str(path)) == good
    if not done:
        raise InputError(f"{path}: the STEP file could not be written")
    path.write_bytes(_DATE.sub(_NO_DATE, path.read_bytes(), count=1))
    return path


def _module(name: str) -> Any:
    return importlib.import_module(f"OCP.{name}")


def _shape(solid: Solid) -> Any:
    """A box, or a cylinder about an axis. [mm]"""
    make, gp = _module("BRepPrimAPI"), _module("gp")
    ranges = {axis: tuple(_MM * float(end) for end in getattr(solid, axis)) for axis in "xyz"}
    if solid.form == "box":
        low, high = (gp.gp_Pnt(*(ranges[axis][end] for axis in "xyz")) for end in (0, 1))
        return make.BRepPrimAPI_MakeBox(low, high).Shape()
    across = next(axis for axis in "xyz" if axis != solid.form)
    begin = [ranges[axis][0] if axis == solid.form else 0.5 * sum(ranges[axis]) for axis in "xyz"]
    along = gp.gp_Ax2(gp.gp_Pnt(*begin), gp.gp_Dir(*(float(axis == solid.form) for axis in "xyz")))
    radius, length = (0.5 * (ranges[across][1] - ranges[across][0]), ranges[solid.form][1] - ranges[solid.form][0])
    return make.BRepPrimAPI_MakeCylinder(along, radius, length).Shape()

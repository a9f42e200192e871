"""What the drives of a study leave out of their losses: bearings that carry the transmission's forces, where none are stated."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from infinivar.drivetrain.cobotic import CoboticDrive
from infinivar.drivetrain.conventional import ConventionalDrive
from infinivar.parts.shaft_bearings import CylinderBearings, PulleyBearings


def uncounted(drive: Any) -> tuple[str, ...]:
    """Names of the bearings whose friction a drive or machine does not state, such as "cylinder bearings"."""
    parts = (drive, *(getattr(drive, name, None) for name in ("drive", "leg", "separate")))
    return tuple(name for part in parts for name in _of(part))


def _of(drive: Any) -> tuple[str, ...]:
    if isinstance(drive, CoboticDrive):
        return () if drive.cylinder_bearings is not None else (CylinderBearings.title,)
    if isinstance(drive, ConventionalDrive):
        stage = drive.pulley if drive.pulley is not None else drive.belt
        stated = stage is None or stage.bearings is not None or _positive(stage.friction_torque)
        return () if stated else (PulleyBearings.title,)
    return ()


def _positive(value: Any) -> bool:
    return not isinstance(value, (int, float)) or value > 0


def not_counted(drives: Mapping[str, Any], titles: Mapping[str, str]) -> str:
    """Sentence on the bearings that are not counted, with the drives concerned; "" if all are."""
    found: dict[str, list[str]] = {}
    for name, drive in drives.items():
        for what in uncounted(drive):
            found.setdefault(what, []).append(titles.get(name, name))
    if not found:
        return ""
    named = "; ".join(what if len(drives) == 1 else f"{what} of {' and '.join(of)}" for what, of in found.items())
    return f"Not counted: {named}."

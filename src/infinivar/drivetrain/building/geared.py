"""Pulleys and belt, rack, or screw, and what carries them."""

from __future__ import annotations

import functools
import math
from collections.abc import Iterator, Mapping
from typing import Any

from infinivar._core.array_namespace import Array, as_floats, namespace
from infinivar._core.fields import given
from infinivar.drivetrain.body import Body
from infinivar.drivetrain.building.base import UNKNOWN, Building, Frame, Load, held_by, load_on, mm
from infinivar.limits import Demand, Limit
from infinivar.parts import catalogue
from infinivar.parts.structure import beams
from infinivar.parts.structure.beams import STEEL_DENSITY

_BELT = ("width", "belt_density")
_BESIDE = 6e-3
"""Width of flanges and hub of a pulley beside its belt: median of 60 pulleys, sati2016. [m]"""


class GearedBuilding(Building):
    """See `Building`."""

    def own(self) -> Iterator[Body]:
        """See `Building.own`."""
        stage, force = self.drive.stage, self.service.force
        names = {stage.title: "stage", f"{stage.title} bearings": "bearings", "rail": "rail", "frame": "frame"}
        if stage.title == "shaft":  # what turns a joint is bought whole
            return
        lacking = UNKNOWN if self.service.travel is None or force is None else None
        if stage.title not in ("pulley", "belt", "rack", "screw"):
            lacking = f"what a {stage.title} weighs is not known"
        if lacking is not None or force is None:
            for name, key in names.items():
                yield self.body(name, None, lacking or UNKNOWN, key=key)
            return
        own = getattr(stage, "bearings", None)
        bearing = None if own is None else own.bearing
        yield self._stage()
        yield self.bearings(f"{stage.title} bearings", 4 if self.belted else 2, self.held, bearing, 0.5 * self.pull)
        yield self.carriage()
        yield self.rail_body()
        yield self.frame()

    def loads(self) -> Iterator[Load]:
        """See `Building.loads`."""
        stage, force = self.drive.stage, self.service.force
        if stage.title == "shaft" or force is None:
            return
        own = getattr(stage, "bearings", None)
        bearing = (None if own is None else own.bearing) or catalogue.lightest_part("bearings", 0.5 * self.pull)
        if bearing is not None:
            along = stage.title == "screw"  # one of its bearings takes the thrust
            yield load_on(f"{stage.title} bearing", bearing, 0.0 if along else 0.5 * self.pull, force if along else 0.0)
        yield self.on_rail()

    @property
    def carried(self) -> Array:
        """See `Building.carried`. [N]"""
        return given(self.service.force, math.nan)

    @property
    def belted(self) -> bool:
        """Whether a belt or cable runs around two pulleys, each between two bearings."""
        return self.drive.stage.title in ("pulley", "belt")

    @property
    def pull(self) -> Array:
        """Largest on both bearings of a shaft together, or along a screw. [N]"""
        own = getattr(self.drive.stage, "bearings", None)
        if not self.belted:
            return self.carried
        return self.structure.pull_ratio * self.carried if own is None or own.pull is None else own.pull

    @functools.cached_property
    def belt(self) -> Mapping[str, Any]:
        """Width and mass of a belt: as stated, else of the lightest of its pitch that carries its taut span; nan if none."""
        stage = self.drive.stage
        if stage.title != "belt":
            return {**dict.fromkeys(_BELT, math.nan), "name": None}
        own = {name: value for name in _BELT if (value := getattr(stage, name)) is not None}
        if len(own) == len(_BELT):
            return {**own, "name": stage.name}
        return {**catalogue.lightest("belts", 0.5 * (self.pull + self.carried), _BELT, pitch=stage.pitch), **own}

    @property
    def wheel_width(self) -> Array:
        """Width of pulleys, pinion and rack. [m]"""
        return _known(self.belt["width"] + _BESIDE, self.structure.pulley_width)

    @functools.cached_property
    def held(self) -> Mapping[str, Any]:
        """Sizes of a bearing of the stage."""
        own = getattr(self.drive.stage, "bearings", None)
        return held_by(None if own is None else own.bearing, 0.5 * self.pull)

    @property
    def shaft(self) -> Mapping[Demand, Array]:
        """Radius of the shaft in its bearings over that of the pulley or pinion on it; 0 where no bearing is known. [-]"""
        stage, own = self.drive.stage, getattr(self.drive.stage, "bearings", None)
        if stage.title not in ("pulley", "belt", "rack") or self.service.force is None:
            return {}
        bore = self.held["bore"] if own is None or own.bore is None else own.bore
        return {(Limit.SHAFT, stage.title): _known(0.5 * bore / stage.travel_per_radian, 0.0)}

    @property
    def guided(self) -> Array:
        """See `Building.guided`: the nut."""
        stage = self.drive.stage
        return self.structure.nut_ratio * stage.diameter if stage.title == "screw" else 0.0

    @property
    def offset(self) -> Array:
        """From the axis of pulley, pinion or screw to the top of the carriage. [m]"""
        stage = self.drive.stage
        if stage.title == "screw":
            return stage.diameter  # of the nut, twice as thick
        return stage.travel_per_radian + (self.wheel_width if stage.title == "rack" else 0.0)

    def sizes(self) -> Frame | None:
        """See `Building.sizes`; the pull at the axis bends the bar along its whole length."""
        held, rail = self.held, self.rail
        reach, across = self.offset + rail["height"], held["outside_diameter"] + 4.0 * self.structure.least_wall
        length = self.rail_length
        if self.belted:  # the carriage stops between the plates, and the pulleys do not touch
            apart = 2.0 * self.drive.stage.travel_per_radian + self.structure.least_wall
            xp = namespace(length, across, apart)
            length = xp.maximum(*as_floats(xp, length + across, apart))
        height = self.bar(0.0, self.pull * reach, length, rail["width"])
        if height is None:
            return None
        beyond, count = 0.5 * held["outside_diameter"], 4 if self.belted else 2
        return Frame(length, rail["width"], height, reach, beyond, across, held["breadth"], count)

    def _stage(self) -> Body:
        """Pulleys and cable, belt, rack and pinion, or screw and nut."""
        stage, structure, length = self.drive.stage, self.structure, self.rail_length
        if stage.title == "screw":
            nut = self.guided
            thread = beams.Section(0.5 * stage.diameter).area * given(stage.length, length)
            around = beams.Section(stage.diameter, 0.5 * stage.diameter).area * nut
            basis = f"thread of {mm(stage.diameter)}, and nut"
            return self.body("screw", STEEL_DENSITY * (thread + around), basis, key="stage")
        radius, width = stage.travel_per_radian, self.wheel_width
        disc = math.pi * radius**2 * width
        if stage.title == "rack":
            basis = f"pinion of {mm(2.0 * radius)}, and rack"
            return self.body("rack", STEEL_DENSITY * (width**2 * length + disc), basis, key="stage")
        if self.metal.density is None:
            return self.body(stage.title, None, "density of structure.material is missing", key="stage")
        strand = _known(self.belt["belt_density"], structure.belt_density) * (2.0 * length + 2.0 * math.pi * radius)
        basis = f"two of {mm(2.0 * radius)}, and {self.belt.get('name') or 'belt or cable'}"
        return self.body(stage.title, 2.0 * disc * self.metal.density + strand, basis, key="stage")


def _known(value: Array, otherwise: Array) -> Array:
    """A value, or another where it is not known, which is nan."""
    if isinstance(value, float):
        return otherwise if math.isnan(value) else value
    xp = namespace(value, otherwise)
    value, otherwise = as_floats(xp, value, otherwise)
    return xp.where(xp.isnan(value), otherwise, value)

"""Displays of several axes: what the worst direction of the handle and the worst of several hands leave of one axis.

All axes are alike, so that their loops stay the same if they are combined: with the singular values of the Jacobian, a display of
several axes is one axis for each direction of the handle. An axis that moves s times as far as the handle carries a hand of 1/s^2
of its mass, damping and stiffness, and the handle feels s^2 of the impedance of the axis.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from annotated_types import Ge

from infinivar._core.arrays import real_array, shown
from infinivar._core.described import derived, finite, reported
from infinivar._core.fields import check_number
from infinivar._core.result import Result, result
from infinivar.displays.kinds import AdmittanceDisplay, Display
from infinivar.displays.stability import check_display, least_stable_mass, stiffest_wall
from infinivar.errors import ParameterError, require
from infinivar.motion.users import ArmModel
from infinivar.units import plain


@result
class DirectionLimits(Result):
    """Mass and wall of a display in each direction of its handle, as returned by `worst_direction`; m directions.

    Attributes
    ----------
    display : str             Kind of display.
    hands : texts             Those tried.
    direction : (m, m)        Unit vectors of the handle, by row.
    travel : (m,)             Travel of the axes over that of the handle, sigma. [-]
    least_mass : (m,)         Felt in free motion, with the handle, in the hand that needs most; nan if none is stable. [kg]
    wall : (m,)               Stiffest stable wall over the margin, at the handle, in the hand that permits least. [N m^-1]
    mass_hand, wall_hand : m texts   Which hand that is.
    margin : float            [-]
    """

    display: str = reported()
    hands: tuple[str, ...] = reported()
    direction: np.ndarray = reported()
    travel: np.ndarray = reported("1", key="travel_1")
    least_mass: np.ndarray = reported("kg", convert=finite)
    wall: np.ndarray = reported("N/m", convert=finite)
    mass_hand: tuple[str, ...] = reported()
    wall_hand: tuple[str, ...] = reported()
    margin: float = reported("1", key="margin_1")

    @derived()
    def verdict(self) -> str:
        """One-sentence answer: the heaviest and the softest direction, each with its hand."""
        heavy, soft = (
            int(place) for place in (np.argmax(np.nan_to_num(self.least_mass, nan=np.inf)), np.nanargmin(self.wall))
        )
        mass = float(self.least_mass[heavy])
        felt = f"{plain(mass, 3)} kg" if math.isfinite(mass) else "no stable mass"
        return (
            f"Worst directions: {felt} along {self._along(heavy)} with {self.mass_hand[heavy]}; wall of "
            f"{plain(1e-3 * float(self.wall[soft]), 3)} N/mm along {self._along(soft)} with {self.wall_hand[soft]}."
        )

    def _along(self, place: int) -> str:
        return f"({', '.join(plain(float(one), 2) for one in self.direction[place])})"


def worst_direction(
    display: Display, jacobian: Any, hands: ArmModel | Sequence[ArmModel], *, margin: float = 1.1
) -> DirectionLimits:
    """Mass felt and stiffest wall of a display of several equal axes, in each direction and in the worst of several hands.

    Parameters
    ----------
    display : AdmittanceDisplay or ImpedanceDisplay
        One axis; its handle mass is that of the handle. Force sensor, structure and virtual mass are those of an axis.
    jacobian : (n, m) float   Travels of the axes by that of the handle along m lines, n >= m; of rank m. [-]
    hands : ArmModel or several   Alike in all directions; by their range a user who grips as he likes.
    margin : float            To the limits of stability, >= 1. [-]

    Returns
    -------
    DirectionLimits

    Raises
    ------
    ParameterError
        If an argument is out of range, or the axes leave a direction of the handle free.

    Source: none; singular values, `least_stable_mass` and `stiffest_wall`.
    """
    check_display(display)
    check_number("margin", margin, "1", Ge(1))
    found = real_array("jacobian", jacobian)
    require(
        found.ndim == 2 and 0 < found.shape[1] <= found.shape[0], "jacobian", f"shape {found.shape}", "(n, m), n >= m"
    )
    every = (hands,) if isinstance(hands, ArmModel) else tuple(hands)
    for hand in every:
        if not isinstance(hand, ArmModel):
            raise ParameterError(f"hands must be ArmModels, got {shown(hand)}")
    require(bool(every), "hands", "none", "one or several ArmModels")
    _, travel, direction = np.linalg.svd(found, full_matrices=False)
    require(bool(travel[-1] > 1e-9 * travel[0]), "jacobian", "one of lower rank", "one that leaves no direction free")
    masses, walls = np.zeros((len(every), len(travel))), np.zeros((len(every), len(travel)))
    for row, hand in enumerate(every):
        for place, one in enumerate((travel**2).tolist()):
            carried = replace(hand, mass=hand.mass / one, damping=hand.damping / one, stiffness=hand.stiffness / one)
            axis = replace(display, handle_mass=display.handle_mass / one)
            mass = axis.drive_mass / (1.0 + getattr(axis, "force_gain", 0.0))
            if isinstance(axis, AdmittanceDisplay):
                mass = margin * least_stable_mass(axis.softest(), carried)
                axis = replace(axis, virtual_mass=mass) if math.isfinite(mass) else None
            wall = math.nan if axis is None else axis.at_handle(stiffest_wall(axis, carried) / margin)
            masses[row, place], walls[row, place] = one * mass + display.handle_mass, one * wall
    most = np.argmax(np.nan_to_num(masses, nan=np.inf), axis=0)
    least = np.argmin(np.nan_to_num(walls, nan=0.0), axis=0)
    names, places = [one.name for one in every], np.arange(len(travel))
    return DirectionLimits(
        display=type(display).__name__,
        hands=tuple(names),
        direction=direction,
        travel=travel,
        least_mass=masses[most, places],
        wall=walls[least, places],
        mass_hand=tuple(names[place] for place in most),
        wall_hand=tuple(names[place] for place in least),
        margin=float(margin),
    )

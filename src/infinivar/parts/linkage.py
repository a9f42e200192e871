r"""Linkages between a joint and a drive: lever, lever arm by angle, linear actuator across the joint, four-bar.

A linkage maps the joint angle :math:`\theta` to the position of the drive, :math:`x = g(\theta)`: a length for a drive along
a line, an angle for a four-bar driven by a shaft. The slope g' is the lever arm (of a four-bar, the ratio). It maps speed
outward and force inward, :math:`\dot x = g'\dot\theta`, :math:`F = M/g'`, so an ideal linkage conserves power.

With :math:`\psi = \theta + \theta_0`, the angle between arm and base:

- ``lever``: :math:`x = a\,\theta`;
- ``table``: g' is an interpolating spline of degree up to five through `arms`, constant beyond the table; x is its integral
  from joint angle 0;
- ``crank``: x is the length of the actuator, :math:`x^2 = a^2 + b^2 - 2 a b \cos\psi`; x grows with the angle for
  :math:`0 < \psi < \pi`, and both ends are dead centres;
- ``four-bar``: x is the angle of the crank from the base line, which points from the drive's shaft to the joint. Of the two
  assemblies it is the one where the crank leads the diagonal from the drive's shaft to the coupler's end on the rocker; in
  a parallelogram, crank and rocker are then parallel.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, NamedTuple

from annotated_types import Gt

from infinivar._core import chain_rule
from infinivar._core.array_namespace import Array, namespace
from infinivar._core.bounds import FINITE
from infinivar._core.fields import check, check_choice, component, quantities, quantity
from infinivar._core.pieces import through
from infinivar.errors import ParameterError
from infinivar.parts.elastic import interval, rising_rows, same_length
from infinivar.units import show

LinkageShape = Literal["lever", "table", "crank", "four-bar"]

NEEDS = {
    "lever": ("arm",),
    "table": ("angles", "arms"),
    "crank": ("arm", "base", "offset"),
    "four-bar": ("arm", "base", "offset", "crank", "coupler"),
}
"""Fields of each shape."""

_CLOSEST = 1e-9
"""How close to a dead centre, as a sine or cosine, the formulas are evaluated."""

_DEAD = 1e-3
_IN_LINE = math.sqrt(1.0 - _DEAD**2)
"""Sine of the angle between two bars, and its cosine, from which they count as in line: there is hardly a lever arm left."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Linkage:
    """Linkage between a joint and a drive.

    - ``lever``: constant lever `arm`, as of a cable on a pulley about the joint;
    - ``table``: lever arm by joint angle, `arms` at `angles`;
    - ``crank``: linear actuator between a pivot on the fixed link at distance `base` from the joint and one on the moving
      link at distance `arm`; `offset` is the angle between both at joint angle 0;
    - ``four-bar``: the drive's shaft turns a crank of length `crank`, which moves the joint's rocker of length `arm` by a
      `coupler`; `base` is the distance of the shafts, `offset` the rocker's angle at joint angle 0.

    Raises
    ------
    ParameterError
        If a field is outside its range, missing or not used by the shape, if the arm of a table vanishes anywhere, or if a
        four-bar cannot be assembled.
    """

    shape: LinkageShape = component("lever, table, crank or four-bar", default="lever")
    arm: float | None = quantity("m", Gt(0), "Lever arm, or length of the arm on the joint", default=None)
    angles: tuple[float, ...] | None = quantities("rad", FINITE, "Joint angles of the table, increasing", default=None)
    arms: tuple[float, ...] | None = quantities("m", Gt(0), "Lever arms at these angles", default=None)
    base: float | None = quantity("m", Gt(0), "Distance of the fixed pivot, or of the drive's shaft", default=None)
    offset: float | None = quantity("rad", FINITE, "Angle between arm and base at joint angle 0", default=None)
    crank: float | None = quantity("m", Gt(0), "Length of the crank on the drive's shaft", default=None)
    coupler: float | None = quantity("m", Gt(0), "Length of the coupler", default=None)

    def __post_init__(self) -> None:
        """Validate the fields and their combination."""
        check(self)
        check_choice(self, "shape", NEEDS)
        if self.angles is not None and self.arms is not None:
            rising_rows("angles", self.angles, "rad")
            same_length("angles", self.angles, "arms", self.arms)
            place, least = through(self.angles, self.arms, "constant").lowest(0)
            if not least > 0:
                low, high = (show(end, "rad") for end in interval(self.angles, place))
                raise ParameterError(
                    f"arms must stay positive on the smooth curve through them; it reaches {show(least, 'm')} between {low} "
                    f"and {high}: change the values there, or add some"
                )
        if self.shape == "four-bar":
            self._check_four_bar()

    def _check_four_bar(self) -> None:
        names = ("arm", "base", "crank", "coupler")
        bars = dict(zip(names, self._lengths(*names), strict=True))
        if not all(isinstance(length, (int, float)) for length in bars.values()):
            return  # arrays, such as those of derivatives, are left alone
        name = max(bars, key=lambda key: bars[key])
        rest = sum(bars.values()) - bars[name]
        if not bars[name] < rest:
            raise ParameterError(
                f"{name} must be < {show(rest, 'm')}, the other three bars in a row, got {bars[name]:g}"
            )

    def _lengths(self, *names: str) -> list[float]:
        """Values of fields that the shape needs."""
        return [getattr(self, name) for name in names]

    @property
    def rotary_drive(self) -> bool:
        """Whether the drive's side turns; else it moves along a line."""
        return self.shape == "four-bar"

    @property
    def dead_centres(self) -> bool:
        """Whether bars can come into line, so that the joint has a range of its own."""
        return self.shape in ("crank", "four-bar")

    def position(self, angle: Array) -> Array:
        """Position of the drive at a joint angle.

        Parameters
        ----------
        angle : (...,) float   [rad]

        Returns
        -------
        (...,) float   [m]; of a four-bar [rad]. Where a linkage cannot reach, the value at its dead centre.

        Source: geometry; for four-bars Freudenstein's equation, freudenstein1955.
        """
        return self.derivatives(angle, 0)[0]

    def derivatives(self, angle: Array, orders: int) -> list[Array]:
        """Position of the drive and its derivatives by the joint angle, up to an order; see `position`."""
        if self.shape == "lever":
            return [self.arm * angle, self.arm, *[0.0] * (orders - 1)][: orders + 1]
        if self.angles is not None and self.arms is not None:
            arms = through(self.angles, self.arms, "constant")
            return [arms.integral().derivatives(angle, 0)[0], *(arms.derivatives(angle, orders - 1) if orders else ())]
        if self.shape == "crank":
            return self._crank(angle, orders)
        return self._four_bar(angle, orders)

    def demand(self, angle: Array) -> Array:
        """Nearness to a dead centre or to the end of the table: 1 there, above 1 beyond; 0 for a lever. [-]

        For a crank and a four-bar it is the cosine of the angle between the bars that come into line, up to 1 mrad before they
        do. From there on it is 1 plus the angle beyond, over 90 degrees; where the crank of a four-bar cannot reach the
        coupler, the cosine that this would take. Of a table it is the angle from its middle over half its range.
        """
        xp = namespace(self, angle)
        if self.shape == "lever":
            return 0.0 * angle
        if self.angles is not None:
            low, high = self.angles[0], self.angles[-1]
            return xp.abs(angle - 0.5 * (low + high)) / (0.5 * (high - low))
        turned = angle + self.offset
        if self.shape == "crank":
            return _beyond(xp.cos(turned), xp.sin(turned))
        bars = self._bars(angle, 0)
        at_crank = abs(bars.at_crank)
        at_crank = xp.where(at_crank > _IN_LINE, at_crank + (1.0 - _IN_LINE), at_crank)
        return xp.where(at_crank > bars.at_rocker, at_crank, bars.at_rocker)

    def beyond_reach(self, angle: Array) -> Array:
        """Whether a joint angle is at or beyond a dead centre, so that no force of the drive moves the joint."""
        return self.demand(angle) > (1.0 if self.dead_centres else math.inf)

    def _crank(self, angle: Array, orders: int) -> list[Array]:
        """Length of the actuator and its derivatives."""
        a, b = self._lengths("arm", "base")
        cosine = _cosine(angle + self.offset, orders)
        square = [-2.0 * a * b * part for part in cosine]
        square[0] = _above_zero(square[0] + a * a + b * b, a, b)
        return chain_rule.root(square)

    def _bars(self, angle: Array, orders: int) -> _Bars:
        """Geometry of the four-bar: O and Q are the shafts of drive and joint, A and B the coupler's ends, e = |OB|."""
        xp = namespace(self, angle)
        a, b, c, d = self._lengths("crank", "coupler", "arm", "base")
        turned = angle + self.offset
        cosine = _cosine(turned, orders)
        x = [c * part for part in cosine]
        x[0] = x[0] + d
        y = [c * part for part in _sine(turned, orders)]
        square = [2.0 * c * d * part for part in cosine]
        square[0] = _above_zero(square[0] + c * c + d * d, c, d)
        diagonal = chain_rule.root(square)
        raised = list(square)
        raised[0] = raised[0] + a * a - b * b
        lead = chain_rule.quotient(raised, [2.0 * a * part for part in diagonal])  # cosine of the angle AOB
        crank = xp.atan2(y[0], x[0]) + xp.acos(_inside(xp, lead[0]))
        # Angle between coupler and rocker at B: toggles where it is 0 or pi.
        to_crank = a * xp.cos(crank) - x[0], a * xp.sin(crank) - y[0]
        to_joint = d - x[0], -y[0]
        along = (to_crank[0] * to_joint[0] + to_crank[1] * to_joint[1]) / (b * c)
        across = (to_crank[0] * to_joint[1] - to_crank[1] * to_joint[0]) / (b * c)
        at_crank = (a * a + b * b - square[0]) / (2.0 * a * b)
        return _Bars(x, y, square, lead, crank, at_crank, _beyond(along, across))

    def _four_bar(self, angle: Array, orders: int) -> list[Array]:
        """Angle of the crank and its derivatives."""
        bars = self._bars(angle, orders)
        if orders == 0:
            return [bars.crank]
        # Rate of the diagonal's direction, atan2(y, x), and of the angle AOB, acos(lead).
        xp = namespace(self, angle)
        swept = chain_rule.total(
            chain_rule.product(bars.x, bars.y[1:]), [-part for part in chain_rule.product(bars.y, bars.x[1:])]
        )
        turning = chain_rule.quotient(swept, bars.square)
        lead = [_inside(xp, bars.lead[0]), *bars.lead[1:]]
        rest = [-part for part in chain_rule.product(lead, lead)]
        rest[0] = rest[0] + 1.0
        opening = chain_rule.quotient(lead[1:], chain_rule.root(rest))
        return [bars.crank, *(one - other for one, other in zip(turning, opening, strict=True))]


class _Bars(NamedTuple):
    """Geometry of a four-bar; rows of derivatives by the joint angle."""

    x: list[Array]
    y: list[Array]
    square: list[Array]
    lead: list[Array]
    crank: Array
    at_crank: Array
    """Cosine of the angle between crank and coupler: 1 in magnitude where they are in line, above where out of reach."""
    at_rocker: Array
    """Nearness to the dead centre where coupler and rocker are in line; above 1 beyond it."""


def _cosine(angle: Array, orders: int) -> list[Array]:
    xp = namespace(angle)
    sine, cosine = xp.sin(angle), xp.cos(angle)
    return [(cosine, -sine, -cosine, sine)[k % 4] for k in range(orders + 1)]


def _sine(angle: Array, orders: int) -> list[Array]:
    xp = namespace(angle)
    sine, cosine = xp.sin(angle), xp.cos(angle)
    return [(sine, cosine, -sine, -cosine)[k % 4] for k in range(orders + 1)]


def _beyond(cosine: Array, sine: Array) -> Array:
    """Magnitude of a cosine while the sine is clearly positive; 1 plus the angle beyond, over 90 degrees, where it is not."""
    xp = namespace(cosine, sine)
    beyond = (math.asin(_DEAD) - xp.atan2(sine, xp.abs(cosine))) / (0.5 * math.pi)
    return xp.where(sine > _DEAD, xp.abs(cosine), 1.0 + beyond)


def _above_zero(square: Array, one: float, other: float) -> Array:
    """The square of the distance between the ends of two bars, kept above 0: only bars of equal length fold onto each other."""
    if isinstance(one, (int, float)) and isinstance(other, (int, float)) and one != other:
        return square
    return namespace(square).maximum(square, (_CLOSEST * (one + other)) ** 2)


def _inside(xp: object, cosine: Array) -> Array:
    """A cosine kept just inside -1 to 1."""
    return xp.clip(cosine, -1.0 + _CLOSEST, 1.0 - _CLOSEST)  # type: ignore[attr-defined]

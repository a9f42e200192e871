"""Elements of a scene in MJCF, the XML format of MuJoCo, and the joints whose positions are recorded with it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

import numpy as np

LEAST, LEAST_INERTIA = 1e-9, 1e-12
"""Mass [kg] and moment of inertia [kg m^2] of bodies that have none in the machine: MuJoCo has no moving body without."""

COLOURS = {
    "body": (0.93, 0.85, 0.62, 1.0),
    "floor": (0.97, 0.97, 0.97, 1.0),
    "cylinder": (0.72, 0.76, 0.80, 1.0),
    "stripe": (0.35, 0.40, 0.46, 1.0),
    "wheel": (0.12, 0.12, 0.14, 1.0),
    "link": (0.34, 0.39, 0.44, 1.0),
    "rod": (0.62, 0.71, 0.78, 1.0),
    "handle": (0.0, 0.447, 0.698, 1.0),
    "guide": (0.42, 0.45, 0.50, 0.3),
    "path": (0.42, 0.45, 0.50, 0.8),
    "force": (0.835, 0.369, 0.0, 1.0),
}
"""Red, green, blue and opacity."""


def text(values: Any) -> str:
    """Numbers of an attribute, in full."""
    return " ".join(f"{one:.17g}" for one in np.ravel(np.asarray(values, dtype=float)).tolist())


@dataclass
class Scene:
    """A scene while it is made."""

    root: Element
    world: Element
    assets: Element
    equality: Element
    count: int
    """Of instants, t."""
    qpos: list[np.ndarray] = field(default_factory=list)
    """Positions of the joints so far, (t, 1), (t, 4) or (t, 7), in the order of MuJoCo: bodies in depth."""

    @classmethod
    def empty(cls, name: str, count: int) -> Scene:
        """A scene without bodies, with light and no gravity."""
        root = Element("mujoco", model=name)
        SubElement(root, "compiler", angle="radian", inertiafromgeom="false")
        SubElement(root, "option", gravity="0 0 0")
        visual = SubElement(root, "visual")
        SubElement(visual, "global", offwidth="1280", offheight="960")
        SubElement(visual, "headlight", ambient="0.6 0.6 0.6", diffuse="0.5 0.5 0.5", specular="0.1 0.1 0.1")
        # Nothing touches: the motion is recorded.
        SubElement(SubElement(root, "default"), "geom", contype="0", conaffinity="0")
        assets = SubElement(root, "asset")
        sky = {
            "name": "sky",
            "type": "skybox",
            "builtin": "flat",
            "rgb1": "1 1 1",
            "rgb2": "1 1 1",
            "width": "8",
            "height": "48",
        }
        SubElement(assets, "texture", sky)
        return cls(root, SubElement(root, "worldbody"), assets, SubElement(root, "equality"), count)

    def body(
        self,
        parent: Element,
        name: str,
        at: Any,
        mass: float,
        inertia: Any,
        *,
        centre: Any = (0.0, 0.0, 0.0),
        axes: Any = None,
    ) -> Element:
        """A body with its mass, and moments of inertia about its centre of mass along its axes, or (3, 3); axes: its x and y."""
        turned = {} if axes is None else {"xyaxes": text(axes)}
        made = SubElement(parent, "body", {"name": name, "pos": text(at), **turned})
        moments, own = np.asarray(inertia, dtype=float), {}
        if moments.ndim == 2:
            moments, turn = np.linalg.eigh(moments)
            own = {"xyaxes": text(turn[:, :2].T)}
            # Rounded numbers of a file may be of no body, by a little; the third axis may point either way.
            moments[2] = min(moments[2], moments[0] + moments[1])
        moments = np.maximum(moments, LEAST_INERTIA)
        given = {"pos": text(centre), "mass": text(max(mass, LEAST)), "diaginertia": text(moments), **own}
        SubElement(made, "inertial", given)
        return made

    def joint(
        self, body: Element, name: str, kind: str, values: np.ndarray, axis: Any = None, armature: float = 0.0
    ) -> None:
        """A joint with its positions at all instants."""
        given = {} if axis is None else {"axis": text(axis)}
        if armature:
            given["armature"] = text(armature)
        if kind == "free":
            SubElement(body, "freejoint", name=name)
        else:
            SubElement(body, "joint", {"name": name, "type": kind, **given})
        self.qpos.append(np.asarray(values, dtype=float).reshape(self.count, -1))

    def geom(self, body: Element, kind: str, colour: str, **given: Any) -> Element:
        """A shape that is only seen."""
        attributes = {name: one if isinstance(one, str) else text(one) for name, one in given.items()}
        return SubElement(body, "geom", {"type": kind, "rgba": text(COLOURS[colour]), **attributes})

    def mesh(self, name: str, vertices: np.ndarray, faces: np.ndarray | None = None) -> None:
        """A mesh; without faces the convex hull of its vertices."""
        given = {} if faces is None else {"face": " ".join(str(one) for one in np.ravel(faces).tolist())}
        SubElement(self.assets, "mesh", {"name": name, "vertex": text(vertices), "inertia": "convex", **given})

    def handle(self, body: Element, at: Any, size: float) -> None:
        """The handle, as a knob and a site."""
        SubElement(body, "site", name="handle", pos=text(at), size=text(0.5 * size))
        self.geom(body, "sphere", "handle", pos=at, size=[size])

    def written(self) -> str:
        """The scene as text."""
        ElementTree.indent(self.root)
        return ElementTree.tostring(self.root, encoding="unicode") + "\n"

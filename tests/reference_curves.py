"""Curves and walls in the plane by closed forms, independent of the program's own."""

import math
from typing import NamedTuple

import numpy as np


class Near(NamedTuple):
    arc_length: float
    tangent: np.ndarray
    curvature: float
    offset: float


class Line:
    """Along x."""

    def nearest(self, point, near=None):
        return Near(float(point[0]), np.array([1.0, 0.0]), 0.0, float(point[1]))


class Circle:
    """About the origin, counter-clockwise."""

    def __init__(self, radius):
        self.radius = radius

    def nearest(self, point, near=None):
        x, y = map(float, point)
        far, angle = math.hypot(x, y), math.atan2(y, x)
        return Near(self.radius * angle, np.array([-y, x]) / far, 1.0 / self.radius, self.radius - far)


class HalfPlane:
    """Free above y = height."""

    dimension = 2

    def __init__(self, height=0.0):
        self.height = height

    def distance(self, point):
        return np.asarray(point)[..., 1] - self.height

    def normal(self, point):
        return np.broadcast_to([0.0, 1.0], np.shape(point))

    def hessian(self, point):
        return np.zeros((*np.shape(point), 2))


class Disc:
    """Free outside a circle about the origin."""

    dimension = 2

    def __init__(self, radius):
        self.radius = radius

    def distance(self, point):
        return np.linalg.norm(point, axis=-1) - self.radius

    def normal(self, point):
        return point / np.linalg.norm(point, axis=-1, keepdims=True)

    def hessian(self, point):
        far = np.linalg.norm(point, axis=-1)[..., None, None]
        out = np.asarray(self.normal(point))
        return (np.eye(2) - out[..., :, None] * out[..., None, :]) / far

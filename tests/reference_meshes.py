"""Triangle meshes of simple solids, with their normals outwards: vertices and faces."""

import numpy as np

_GOLDEN = (1.0 + 5.0**0.5) / 2.0
_ICOSAHEDRON = [(-1, _GOLDEN, 0), (1, _GOLDEN, 0), (-1, -_GOLDEN, 0), (1, -_GOLDEN, 0)]


def box(half=(1.0, 1.0, 1.0)):
    corners = [[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
    sides = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    faces = [triangle for a, b, c, d in sides for triangle in ((a, b, c), (a, c, d))]
    return np.array(corners, dtype=float) * half, np.array(faces)


def distance_from_box(points, half):
    """Closed form: > 0 outside."""
    beyond = np.abs(points) - half
    return np.linalg.norm(np.maximum(beyond, 0.0), axis=-1) + np.minimum(beyond.max(axis=-1), 0.0)


def sphere(radius=1.0, halvings=3):
    """An icosahedron whose triangles are halved, with its vertices on a sphere."""
    ring = np.array(_ICOSAHEDRON)
    vertices = np.concatenate([ring, np.roll(ring, 1, axis=1), np.roll(ring, 2, axis=1)])
    side = 2.0
    triples = [(a, b, c) for a in range(12) for b in range(a) for c in range(b)]
    faces = [
        one
        for one in triples
        if np.allclose(np.linalg.norm(vertices[list(one)] - vertices[list(one[1:] + one[:1])], axis=1), side)
    ]
    corners = vertices[np.array(faces)]
    outwards = np.einsum(
        "ij,ij->i", np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), corners[:, 0]
    )
    corners = np.where((outwards > 0.0)[:, None, None], corners, corners[:, ::-1])
    for _ in range(halvings):
        a, b, c = corners.transpose(1, 0, 2)
        ab, bc, ca = a + b, b + c, c + a
        corners = np.concatenate(
            [np.stack(one, axis=1) for one in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))]
        )
        corners = corners / np.linalg.norm(corners, axis=2, keepdims=True)
    corners = np.round(corners / np.linalg.norm(corners, axis=2, keepdims=True), 12)
    vertices, place = np.unique(corners.reshape(-1, 3), axis=0, return_inverse=True)
    return radius * vertices, place.reshape(-1, 3)

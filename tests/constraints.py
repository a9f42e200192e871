"""Motion under constraints ``A xi = 0`` by the projection of a mass: ``M dxi = F + A^T lambda``, ``A dxi = -dA xi``."""

import numpy as np


def free_projection(A, M):
    """P, which keeps of a twist what the constraints leave free."""
    back = np.linalg.solve(M, A.T)
    return np.eye(len(M)) - back @ np.linalg.solve(A @ back, A)


def constrained_motion(M, F, A, dA, twist):
    """Acceleration, and the force along each row on the machine."""
    back, free = np.linalg.solve(M, A.T), np.linalg.solve(M, F)
    reaction = np.linalg.solve(A @ back, -dA @ twist - A @ free)
    return free + back @ reaction, reaction

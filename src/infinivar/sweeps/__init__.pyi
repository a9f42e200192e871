from .builds import BuildsSweep, builds_sweep
from .cobotic import CoboticStudySweep, cobotic_study_sweep
from .geared import GearedSweep, geared_sweep
from .runs import RunBuilds, RunsSweep, runs_sweep
from .sensitivity import SensitivitySweep, sensitivity_sweep
from .sessions import Sessions, SessionsSweep, sessions_sweep

__all__ = [
    "BuildsSweep",
    "CoboticStudySweep",
    "GearedSweep",
    "RunBuilds",
    "RunsSweep",
    "SensitivitySweep",
    "Sessions",
    "SessionsSweep",
    "builds_sweep",
    "cobotic_study_sweep",
    "geared_sweep",
    "runs_sweep",
    "sensitivity_sweep",
    "sessions_sweep",
]

"""Results of which tests make one each, and whether their arrays are locked."""

import dataclasses

import numpy as np
import pytest

SAVED = {
    "Builds", "Calibration", "Comparison", "ContactSheet", "DrivePoint", "DriveResult", "DutyComparison", "DutyResult",
    "DynamicMap", "GearedCalibration", "MovingPoint", "OperatingPoint", "Policy", "Reproduction", "Sensitivity", "Simulation",
    "SteadyMap", "SteadyRolling", "SteeringStep", "Trajectory", "TwoWays",
}  # fmt: skip
"""Public results that `test_results` makes; `test_saved_results` makes the others."""


def arrays_in(value):
    """All NumPy arrays that can be reached through fields, dictionaries and tuples of a result."""
    if isinstance(value, np.ndarray):
        yield value
    elif dataclasses.is_dataclass(value):
        for field in dataclasses.fields(value):
            yield from arrays_in(getattr(value, field.name))
    elif isinstance(value, dict):
        for item in value.values():
            yield from arrays_in(item)
    elif isinstance(value, tuple):
        for item in value:
            yield from arrays_in(item)


def assert_locked(value):
    """No array can be written to, nor can anyone open its lock or that of the memory below it."""
    for array in arrays_in(value):
        base = array
        while isinstance(base, np.ndarray):
            assert not base.flags.writeable
            with pytest.raises(ValueError, match="WRITEABLE"):
                base.flags.writeable = True
            base = base.base
        assert type(base) is bytes

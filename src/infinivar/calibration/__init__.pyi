from .calibrate import calibrate_cobotic, calibrate_geared
from .result import GearedCalibration

__all__ = [
    "GearedCalibration",
    "calibrate_cobotic",
    "calibrate_geared",
]

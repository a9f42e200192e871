from .calibrate import calibrate_cobotic, calibrate_geared
from .measured.report import MeasuredReport, measured_report
from .result import GearedCalibration

__all__ = [
    "GearedCalibration",
    "MeasuredReport",
    "calibrate_cobotic",
    "calibrate_geared",
    "measured_report",
]

"""Calibration of a geared drive: motor and gearhead on a dynamometer, or moving a pendulum."""

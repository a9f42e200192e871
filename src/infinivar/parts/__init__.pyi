from . import amplifier, bearing, belt, gearhead, heat, linear, motor, screw, shaft_bearings, stage, tables

__all__ = [
    "amplifier",
    "bearing",
    "belt",
    "gearhead",
    "heat",
    "linear",
    "motor",
    "screw",
    "shaft_bearings",
    "stage",
    "tables",
]

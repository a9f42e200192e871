from . import amplifier, bearing, belt, gearhead, heat, linear, motor, screw, stage, tables

__all__ = [
    "amplifier",
    "bearing",
    "belt",
    "gearhead",
    "heat",
    "linear",
    "motor",
    "screw",
    "stage",
    "tables",
]

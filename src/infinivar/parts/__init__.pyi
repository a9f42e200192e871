from . import amplifier, bearing, belt, gearhead, heat, linear, motor, screw, stage

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
]

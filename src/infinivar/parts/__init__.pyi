from . import amplifier, bearing, gearhead, heat, linear, motor

__all__ = [
    "amplifier",
    "bearing",
    "gearhead",
    "heat",
    "linear",
    "motor",
]

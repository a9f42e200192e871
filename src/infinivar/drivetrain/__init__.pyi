from .drive import Drive, DrivePoint, MovingPoint
from .steering import SteeringPlant

__all__ = [
    "Drive",
    "DrivePoint",
    "MovingPoint",
    "SteeringPlant",
]

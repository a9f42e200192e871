from . import design_trends

__all__ = [
    "design_trends",
]

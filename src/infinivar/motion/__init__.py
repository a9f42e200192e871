"""Motions and forces of a load over time, and the duty cycles and scenarios that use them."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

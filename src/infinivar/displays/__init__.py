"""Haptic displays: stability and stiffest wall, passivity, range of impedances, and the energy of use by a hand."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

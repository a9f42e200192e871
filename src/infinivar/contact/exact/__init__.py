"""Exact rolling contact: two elastic half-spaces that roll on an elliptical patch, with creepage, spin and dry friction."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

"""Machine parts as frozen values, each with its own law, and the catalogue they can be taken from."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

"""infinivar: drive-trains with an infinitely variable (cobotic) transmission and with a fixed ratio.

The public names are those of ``__init__.pyi``; they load on first use, so that importing the package costs next to nothing.
"""

import lazy_loader

__version__ = "0.1.0"

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

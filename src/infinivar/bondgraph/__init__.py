"""Bond graphs: one graph of a machine, from which its drawing, equations, simulation and energy audit all come."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

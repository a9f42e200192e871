"""Large studies in numbered chunks, on one machine or a cluster, that continue where they were stopped."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

"""Machines of rolling contacts, and their rivals with a motor for each link: kinds, equations in time, and control."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

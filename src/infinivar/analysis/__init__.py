"""Analyses: functions of drive-trains that return frozen results; nothing here plots or prints."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

"""The paper by Faulring, Colgate & Peshkin (2006): its figures, its claims, and the verdicts on them."""

import lazy_loader

from infinivar._core.presentation import register

register(
    "infinivar.paper.reproduce.Reproduction",
    plot="infinivar.paper.report:draw",
    save="infinivar.paper.report:save",
    table="infinivar.paper.report:table",
)

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

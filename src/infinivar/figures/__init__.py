"""Figures, one module each: ``data(...)`` gives the numbers, ``draw(ax, data)`` draws them."""

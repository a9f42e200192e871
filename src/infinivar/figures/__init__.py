"""Figures, one module each: ``data(...)`` returns the numbers, ``draw(ax, data)`` draws them."""

"""Motions and forces of a load over time, and the duty cycles and scenarios that use them."""

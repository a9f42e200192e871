"""The nearest miss of a search over geared drives."""

from internals import GearedRequest, nearest_miss


def nearest_geared(template, motors, gearheads, pairs, *, stages=(), weighed=False, **options):
    """Of the pairs with a template, at stages or over a range of radii; `weighed`: only those whose masses are stated."""
    tables = {"motors": motors, "gearheads": gearheads, "pairs": pairs}
    aim = "mass" if weighed else "energy"
    return nearest_miss(GearedRequest(template=template, stages=tuple(stages), objective=aim, **tables, **options))
